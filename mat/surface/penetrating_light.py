"""Sunlight absorbed within layers that let it in: ice. Its heat reaches the surface later, and in part not at all.

By reciprocity the heat flux at a surface held at 0 K, from a unit of heat put into the stack at a depth, is the
temperature at that depth per kelvin at the surface, nothing driving the back: a self-adjoint operator has a symmetric
Green's function (Carslaw and Jaeger 1959, Conduction of Heat in Solids, 2nd ed., section 14.2).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from skyshine.mat.surface.balance import skin_of
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import (
    Complexes,
    Conduction,
    circulant,
    cut,
    delayed_weights,
    depth_response,
    frequencies,
    surface_admittance,
)
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.materials.records import Back, PenetratingLight, ThermalStack
from skyshine.schemas.arrays import Floats

# m: edges of the panels of Gauss-Legendre points, close at the surface, where waves of minutes end.
_PANELS = np.array([0.0, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0])
_POINTS = 8
_DEEPEST = 30.0  # e-foldings, below which no light arrives


def light_response(stack: ThermalStack, s: Complexes) -> Complexes:
    """Heat flux at the surface per absorbed sunlight at complex frequencies, less 1: what its depth changes.

    Parameters
    ----------
    s : (n,) complex
        [1/s]

    Returns
    -------
    (n,) complex
        0 where all light is absorbed at the surface.
    """
    change = np.zeros(len(s), complex)
    for part in stack.light:
        change += part.share * (_reaching(stack, part, s) - 1.0)
    return change


def _reaching(stack: ThermalStack, part: PenetratingLight, s: Complexes) -> Complexes:
    """The share of light absorbed by one exponential law in the layers that arrives at the surface."""
    arriving: Complexes = np.zeros(len(s), complex)
    total = 0.0
    for depth, absorbed in _absorbing_depths(stack, part):
        arriving += absorbed * depth_response(stack, s, depth)[0]
        total += absorbed
    return arriving * (1.0 / total)


def _absorbing_depths(stack: ThermalStack, part: PenetratingLight, kink: float = 0.0) -> list[tuple[float, float]]:
    """Depths [m] at which light of one exponential law is absorbed, and how much of it; an integrand may have a kink at
    a depth.
    """
    bottom = min(sum(layer.thickness for layer in stack.layers), _DEEPEST / part.extinction)
    edges = np.append(_PANELS[bottom > _PANELS], bottom)
    if 0 < kink < bottom:
        edges = np.union1d(edges, [kink])
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    depths = []
    for low, high in pairwise(edges):
        for node, weight in zip(nodes, weights, strict=True):
            depth = float(low + 0.5 * (high - low) * (node + 1.0))
            depths.append((depth, 0.5 * (high - low) * weight * part.extinction * np.exp(-part.extinction * depth)))
    return depths


def light_at_depth(stack: ThermalStack, s: Complexes, depth: float) -> Complexes:
    """Temperature at a depth per absorbed sunlight at complex frequencies, the surface held at 0.

    Parameters
    ----------
    s : (n,) complex
        [1/s]
    depth : float
        Below the skin [m], within the layers.

    Returns
    -------
    (n,) complex
        [K m^2 W^-1]

    Notes
    -----
    Heat put in at the depth warms it by the reciprocal of what both sides draw from it; heat put in elsewhere by that
    times the temperature there per kelvin at the depth, since Green's function is symmetric (see the module).
    """
    heated: Complexes = np.zeros(len(s), complex)
    above, below = cut(stack.layers, depth)
    if not above or (not below and stack.back.kind == "fixed"):
        return heated  # the surface, or a back of given temperature
    no_skin = replace(stack.skin, thickness=0.0)
    up, down = (
        ThermalStack(no_skin, (upper, lower), back)
        for (upper, lower, *_), back in (
            ([*reversed(above), no_skin], Back("fixed")),
            ([*below, no_skin, no_skin], stack.back),
        )
    )
    drawn = surface_admittance(up, s) + surface_admittance(down, s)
    for part in stack.light:
        absorbing = _absorbing_depths(stack, part, depth)
        total = sum(absorbed for _, absorbed in absorbing)
        for at, absorbed in absorbing:
            side = up if at < depth else down
            away = min(abs(at - depth), sum(layer.thickness for layer in side.layers))  # but for rounding it is less
            there = depth_response(side, s, away)[0]
            heated += part.share * absorbed / total * there / drawn
    return heated


def absorbed_sunlight(material: SurfaceMaterial, forcing: Forcing) -> Floats:
    """By surface and layers together (columns, N) [W m^-2]."""
    received = forcing.shortwave_direct + forcing.shortwave_diffuse + forcing.shortwave_reflected
    absorbed: Floats = skin_of(material, forcing).solar_absorptance * received + np.zeros(forcing.shape)
    return absorbed


def penetrating_light_flux(material: SurfaceMaterial, forcing: Forcing, conduction: Conduction) -> Floats:
    """What the depth of absorbed light changes in the heat that reaches the surface (columns, N) [W m^-2]."""
    absorbed = absorbed_sunlight(material, forcing)
    return np.fft.irfft(np.fft.rfft(absorbed) * penetrating_light_harmonics(conduction), conduction.steps)


def penetrating_light_matrix(conduction: Conduction) -> Floats:
    """The circulant (N, N) matrix of `penetrating_light_flux`."""
    return circulant(penetrating_light_harmonics(conduction), conduction.steps)


def penetrating_light_harmonics(conduction: Conduction) -> Complexes:
    """Flux of `penetrating_light_flux` per unit of absorbed light, at the harmonics 0 ... N/2."""
    return _light_response(conduction.stack, conduction.steps, conduction.period, conduction.scheme)


@lru_cache(maxsize=32)
def _light_response(stack: ThermalStack, steps: int, period: float, scheme: str) -> Complexes:
    return light_response(stack, frequencies(steps, period, scheme))


def delayed_light(stack: ThermalStack, step: float, lags: int, scheme: str) -> Floats:
    """`penetrating_light_flux` at 0, 1, 2 ... steps after a unit of light was absorbed for one step (lags,)."""
    (weights,) = delayed_weights(lambda s: (light_response(stack, s),), step, lags, scheme)
    return weights
