"""Light on the surfaces at the ends of paths, by height and elevation of the source, at few of a band's points.

A path weighs this light by the transmittance of each point; so light is kept as a sum of few spectra, each a number by
height and source, with a factor at each point. No path axes are needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.quantities.ambient_harmonics import HarmonicSky, ground_emission
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.parts import Parts, fitted_parts, pivots
from skyshine.mat.quantities.sky_table import SKY_HEIGHTS, SkyTable
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.arrays import Floats

# Heights above the ground of targets of the beam [m], in space too, and elevations of the source above that at which it
# rises there [degree]; transmittance changes most near the rise. Others are placed between them by tolerance.
TARGET_HEIGHTS = np.concatenate(
    [
        SKY_HEIGHTS[:9],
        [3.5e3, 4e3, 4.5e3, 5e3, 5.75e3, 6.5e3, 7.25e3, 8e3, 9e3, 10e3, 11e3, 12e3, 13e3, 14e3, 15.5e3, 17e3],
        [18.5e3, 20e3, 22e3, 24e3, 27e3, 30e3, 34e3, 38e3, 43e3, 50e3, 60e3, 7e4, 8e4, 9e4, 1e5],
        np.geomspace(1.05e5, 1.3e6, 36),  # the horizon falls with the root of the height
    ]
)
_NEAR_RISE = (0, 0.03, 0.06, 0.1, 0.14, 0.18, 0.23, 0.28, 0.34, 0.4, 0.48, 0.57, 0.67, 0.78, 0.9, 1.05, 1.2, 1.4)
_LOW = (1.55, 1.7, 1.85, 2, 2.2, 2.4, 2.6, 2.8, 3, 3.3, 3.6, 4, 4.5, 5, 5.6, 6.3, 7.1, 8, 9.2, 10.5, 12, 14)
ABOVE_RISE = (*_NEAR_RISE, *_LOW, 17, 22, 30, 40, 55, 75, 100)
GROUND_TEMPERATURE = 300.0  # K, at which the ground's light is as right as the sky's
_NODES_SHARE = 5.0  # multiple of what light may miss otherwise, which the beam may miss half way between two nodes
_HALVINGS = 4  # halvings of an interval at most
_ROUNDING = 1e-12  # fraction of the largest singular value: smaller ones are rounding


@dataclass(frozen=True, eq=False)
class LightParts:
    """Light as a sum of K spectra.

    Attributes
    ----------
    value : (K, ...) array
        W m^-2 sr^-1.
    factor : (P, K) array
        Factor of each spectrum at the band's points: the light that reaches an observer is the sum over j and k of
        tau_j factor[j, k] value[k].
    """

    value: Floats
    factor: Floats

    @classmethod
    def of(cls, spectral: Floats, weight: Floats, through: Floats, allowed: float) -> LightParts:
        """The fewest spectra that give the light (..., P) by the points' weights (P,) that paths of transmittances
        (m, P) let through, each within what is allowed [W m^-2 sr^-1].

        They are the singular vectors of light by paths, which are the fewest.
        """
        rows = spectral.reshape(-1, spectral.shape[-1]) * weight
        through = np.vstack([through, np.ones(weight.size)])  # a path without air among them
        vectors, size, _ = np.linalg.svd(rows @ np.linalg.qr(through)[1].T, full_matrices=False)
        exact = rows @ through.T
        rank = max(1, int(np.count_nonzero(size > _ROUNDING * max(size[0], np.finfo(float).tiny))))
        count = 0
        while count < rank:
            count += 1
            value = vectors[:, :count] * size[:count]
            factor = rows.T @ vectors[:, :count] / np.where(size[:count] > 0, size[:count], 1.0)
            if np.abs(value @ (through @ factor).T - exact).max() <= allowed:
                break
        largest = np.maximum(np.abs(factor).max(axis=0), np.finfo(float).tiny)
        return cls((value * largest).T.reshape(count, *spectral.shape[:-1]), factor / largest)


@dataclass(frozen=True, eq=False)
class SurfaceLight:
    """Light on surfaces at heights above the ground.

    Attributes
    ----------
    height_km : (Y,) array
        Nodes for diffuse light.
    sky_elevation : (SE,) array
        Nodes of the source's elevation for diffuse light, degree.
    target_height_km : (B,) array
        Nodes for the beam.
    rise : (B,) array
        Elevation at which the source rises there, degree.
    above_rise : (D,) array
        Nodes of the elevation above it, degree.
    direct : LightParts
        (K, B, D): of the beam, over pi.
    thermal_sky, scattered_sky : LightParts
        (K, Y) and (K, Y, SE): diffuse on a level surface, over pi.
    thermal_harmonics, scattered_harmonics : LightParts or None
        (K, Y, H) and (K, Y, SE, H), as `ambient_harmonics.AmbientHarmonics.radiance`.
    ground_harmonics : LightParts or None
        (K, Y, L): transmittance to the ground, without its emission.
    ground_emission : (T, P) array
        Emission of the ground from `ambient_harmonics.ground_emission`.
    """

    height_km: Floats
    sky_elevation: Floats
    target_height_km: Floats
    rise: Floats
    above_rise: Floats
    direct: LightParts
    thermal_sky: LightParts
    scattered_sky: LightParts
    thermal_harmonics: LightParts | None
    scattered_harmonics: LightParts | None
    ground_harmonics: LightParts | None
    ground_emission: Floats


def _beam(air: SpectralAir, heights: Floats, above_rise: Floats) -> Floats:
    """Transmittance (B, D, P) from a source so far above its rise [degree] to targets so high above the ground [m]."""
    targets, above = air.state.surface_altitude + heights, np.radians(above_rise)
    rows = [
        direct_transmittance(air.source_paths, target[None], np.minimum(up + above, np.pi / 2))
        for target, up in zip(targets, air.source_rays.rise_at(targets), strict=True)
    ]
    return np.concatenate(rows)


def _beam_nodes(air: SpectralAir, start: tuple[Floats, Floats], light: Floats, allowed: float) -> tuple[Floats, Floats]:
    """Heights (B,) [m] and elevations above the rise (D,) [degree] between which the beam of a source is linear within
    what is allowed, those to start from among them; its light at the band's points is (P,) [W m^-2 sr^-1].
    """
    nodes = list(start)
    at_nodes = _beam(air, *nodes) @ light
    for axis in (1, 0):
        for _ in range(_HALVINGS):
            middle = (nodes[axis][1:] + nodes[axis][:-1]) / 2
            between = list(nodes)
            between[axis] = middle
            exact, of_axis = _beam(air, between[0], between[1]) @ light, np.moveaxis(at_nodes, axis, 0)
            deviation = np.moveaxis(exact, axis, 0) - (of_axis[1:] + of_axis[:-1]) / 2
            wide = np.abs(deviation).max(axis=1) > allowed
            if not wide.any():
                break
            position = np.searchsorted(nodes[axis], middle[wide])
            nodes[axis] = np.insert(nodes[axis], position, middle[wide])
            at_nodes = np.insert(at_nodes, position, np.compress(wide, exact, axis=axis), axis=axis)
    return nodes[0], nodes[1]


def _few_points(rows: Floats, through: Floats, allowed: float) -> Parts:
    """The points whose scattered light on level surfaces, rows (n, P) [W m^-2 sr^-1], gives that of all as paths of
    transmittances (m, P) let it through; that from other sides has the same spectra.
    """
    order = pivots(rows * np.sqrt(np.mean(through**2, axis=0)))
    for count in range(1, order.size + 1):
        chosen = fitted_parts(rows, np.sort(order[:count]))
        if np.abs((rows[:, chosen.index] @ chosen.factor.T - rows) @ through.T).max() <= allowed:
            break
    return chosen


def _around(nodes: Floats, low: float, high: float) -> Floats:
    """The nodes between two values, with the next beyond each."""
    start = max(0, int(np.searchsorted(nodes, low, side="right")) - 1)
    return nodes[start : max(int(np.searchsorted(nodes, high)) + 1, start + 2)]


@dataclass(frozen=True, eq=False)
class EmittedLight:
    """Light around surfaces at Y heights, at the P points of a band, without a source.

    Attributes
    ----------
    level : (Y, P) array
        Irradiance on a level surface, W m^-2 (cm^-1)^-1.
    harmonics : (Y, P, H) array
        Harmonics from `ambient_harmonics.HarmonicSky`.
    ground : (Y, P, L) array
        Harmonics of the transmittance to the ground.
    """

    level: Floats
    harmonics: Floats
    ground: Floats

    @classmethod
    def of(cls, atmosphere: BandAtmosphere, harmonics: int) -> EmittedLight:
        """At the heights of `surface_light`, with so many harmonics, 0 for none."""
        air, dark = atmosphere.air, np.zeros(atmosphere.band.weight.size)
        air.prepare()
        altitude, nadir = air.state.surface_altitude + atmosphere.scope.heights(SKY_HEIGHTS), np.array([-np.pi / 2])
        level = SkyTable.of(air, altitude, nadir, dark).at(altitude)[:, 0]
        if not harmonics:
            return cls(level, np.zeros((altitude.size, dark.size, 0)), np.zeros((altitude.size, dark.size, 0)))
        sky, ground = HarmonicSky.over_ground(air, nadir, dark, harmonics, atmosphere.scope).at(altitude)
        return cls(level, sky[:, 0], ground)


def surface_light(
    atmosphere: BandAtmosphere,
    irradiance: Floats,
    source_elevation: Floats,
    through: Floats,
    emitted: EmittedLight,
    allowed: float,
) -> SurfaceLight:
    """Compute the light.

    Parameters
    ----------
    irradiance : (P,) array
        Irradiance of the source outside the atmosphere, W m^-2 (cm^-1)^-1.
    source_elevation : (SE,) array
        Nodes for diffuse light, degree.
    through : (m, P) array
        Transmittances of sample paths.
    allowed : float
        What each light may miss of what a path lets through, W m^-2 sr^-1.
    """
    air, weight = atmosphere.air, atmosphere.band.radiance_weight / np.pi
    air.prepare()
    scope, ground = atmosphere.scope, air.state.surface_altitude
    heights, targets, above = scope.heights(SKY_HEIGHTS), scope.heights(TARGET_HEIGHTS), np.array(ABOVE_RISE, float)
    altitude, elevation = ground + heights, np.radians(source_elevation)
    rise = np.degrees(air.source_rays.rise_at(ground + targets))
    above = _around(above, source_elevation[0] - rise.max(), source_elevation[-1] - rise.min())
    targets, above = _beam_nodes(air, (targets, above), weight * irradiance, _NODES_SHARE * allowed)
    beam, rise = _beam(air, targets, above), air.source_rays.rise_at(ground + targets)
    level, sky, harmonics = emitted.level, emitted.harmonics, emitted.harmonics.shape[2]
    sunlit = np.any(irradiance > 0) and air.scatters
    both = SkyTable.of(air, altitude, elevation, irradiance).at(altitude) if sunlit else level[:, None]
    scattered = np.maximum(both - level[:, None], 0.0) + np.zeros((altitude.size, elevation.size, 1))
    harmonic_parts: tuple[LightParts | None, LightParts | None, LightParts | None] = (None, None, None)
    if harmonics:
        glow = float(planck_wavenumber(atmosphere.band.wavenumber, GROUND_TEMPERATURE).max())
        lit_sky = np.zeros((altitude.size, elevation.size, harmonics, 1))
        if sunlit:
            chosen = _few_points(scattered.reshape(-1, weight.size) * weight, through, allowed)
            part = air.part(chosen.index)
            total = HarmonicSky.over_ground(part, elevation, irradiance[chosen.index], harmonics, scope).at(altitude)[0]
            of_few = (total - sky[:, None, chosen.index]) * weight[chosen.index, None]
            lit_sky = np.swapaxes(of_few, -1, -2) @ chosen.factor.T / weight
        harmonic_parts = (
            LightParts.of(np.moveaxis(sky, -1, 1), weight * np.pi, through, allowed),
            LightParts.of(lit_sky + np.zeros(weight.size), weight * np.pi, through, allowed),
            LightParts.of(np.moveaxis(emitted.ground, -1, 1), weight * np.pi, through, allowed / glow),
        )
    return SurfaceLight(
        heights / 1e3,
        source_elevation,
        targets / 1e3,
        np.degrees(rise),
        above,
        LightParts.of(beam * irradiance, weight, through, allowed),
        LightParts.of(level, weight, through, allowed),
        LightParts.of(scattered, weight, through, allowed),
        *harmonic_parts,
        ground_emission(atmosphere.band),
    )
