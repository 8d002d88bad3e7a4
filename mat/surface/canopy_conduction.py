"""Conduction between leaves, the space beneath them and the soil: a linear operator on the temperatures of both."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.mat.surface.canopy import gap_to_sky
from skyshine.mat.surface.conduction import (
    Complexes,
    between_faces,
    circulant,
    delayed_weights,
    frequencies,
    stack_response,
)
from skyshine.mat.surface.day_blocks import day_block
from skyshine.mat.surface.material import Canopy
from skyshine.schemas.arrays import Floats, Reals

# Up to this many steps a matrix product is faster than Fourier transforms.
_DENSE_FLUX_STEPS = 192


def canopy_admittance(canopy: Canopy, s: Complexes) -> tuple[Complexes, Complexes, Complexes]:
    """What leaves and soil draw from their temperatures at complex frequencies.

    Parameters
    ----------
    s : (n,) complex
        Laplace variable, as in `conduction.surface_admittance`.

    Returns
    -------
    leaves : (n,) complex
        Heat flux into the leaves per kelvin of their own, by the area that they cover [W m^-2 K^-1].
    across : (n,) complex
        Of it, what comes out at the soil; times the cover it is that by area of ground.
    soil : (n,) complex
        Heat flux into soil and the space above it per kelvin of the soil, by area of ground.
    """
    stack = canopy.leaves.thermal
    leaf, across = between_faces(stack.layers[0], s)
    skin = stack.skin
    below, _ = stack_response(canopy.soil.thermal, s)
    cover = 1.0 - gap_to_sky(canopy.leaf_area)
    return leaf + s * (skin.thickness * skin.density * skin.heat_capacity), across, below + cover * leaf


@dataclass(frozen=True, eq=False)
class CanopyConduction:
    """The response to temperatures of leaves and soil at N times of a period, which lie one after the other.

    Attributes
    ----------
    times : int
        N.
    period : float
        [s]
    scheme : str
        Scheme, as in `conduction.Conduction`.
    """

    canopy: Canopy
    times: int
    period: float
    scheme: str = "bdf2"

    @property
    def steps(self) -> int:
        """Unknowns of a column, 2 N."""
        return 2 * self.times

    @cached_property
    def _response(self) -> tuple[Complexes, Complexes, Complexes]:
        return canopy_admittance(self.canopy, frequencies(self.times, self.period, self.scheme))

    @property
    def _cover(self) -> float:
        return 1.0 - gap_to_sky(self.canopy.leaf_area)

    @property
    def admittance(self) -> Complexes:
        """Admittance of the soil at the harmonics 0 ... N/2 [W m^-2 K^-1]."""
        return self._response[2]

    @cached_property
    def matrix(self) -> Floats:
        """The matrix (2 N, 2 N) of `flux`."""
        leaves, across, soil = (circulant(part, self.times) for part in self._response)
        return np.block([[leaves, -across], [-self._cover * across, soil]])

    def flux(self, temperature: Reals) -> Floats:
        """Heat flux (..., 2 N) [W m^-2] into leaves and soil of temperatures [K] above a back at 0."""
        if self.times <= _DENSE_FLUX_STEPS:
            product: Floats = temperature @ self.matrix.T
            return product
        leaves, across, soil = self._response
        above, below = (np.fft.rfft(part) for part in np.split(temperature, 2, axis=-1))
        into = leaves * above - across * below, soil * below - self._cover * across * above
        return np.concatenate([np.fft.irfft(part, self.times) for part in into], axis=-1)

    def relax(self, flux: Floats, conductance: float) -> Floats:
        """Temperatures (..., 2 N) [K] whose `flux` plus `conductance` times themselves is `flux` (..., 2 N)."""
        leaves, across, soil = self._response
        above, below = (np.fft.rfft(part) for part in np.split(flux, 2, axis=-1))
        leaf, ground = leaves + conductance, soil + conductance
        determinant = leaf * ground - self._cover * across**2
        spectra = (
            (ground * above + across * below) / determinant,
            (leaf * below + self._cover * across * above) / determinant,
        )
        return np.concatenate([np.fft.irfft(part, self.times) for part in spectra], axis=-1)

    def delayed(self, days: int) -> list[Floats]:
        """Matrices (2 N, 2 N) from the temperatures of a day to the flux 0, 1 ... days later."""
        step = self.period / self.times
        parts = delayed_weights(lambda s: canopy_admittance(self.canopy, s), step, days * self.times, self.scheme)
        blocks = [[day_block(part, self.times, day) for part in parts] for day in range(days)]
        return [np.block([[leaves, -across], [-self._cover * across, soil]]) for leaves, across, soil in blocks]


@dataclass(frozen=True, eq=False)
class CanopyDay(CanopyConduction):
    """Conduction of a day that does not repeat, by its own temperatures alone."""

    @cached_property
    def matrix(self) -> Floats:
        return self.delayed(1)[0]

    def flux(self, temperature: Reals) -> Floats:
        product: Floats = temperature @ self.matrix.T
        return product
