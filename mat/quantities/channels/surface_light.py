"""Light on the surfaces at the ends of paths, by height and elevation of the source, at few of a band's points.

A path weighs this light by the transmittance of each point; so light is kept as a sum of few spectra, each a number by
height and source, with a factor at each point. No path axes are needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.quantities.ambient_harmonics import HarmonicSky, ground_emission
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.parts import fitted_parts, pivots
from skyshine.mat.quantities.sky_table import SKY_HEIGHTS, SkyTable
from skyshine.schemas.arrays import Floats

# Heights above the ground of targets of the beam [m], in space too.
TARGET_HEIGHTS = np.concatenate(
    [
        SKY_HEIGHTS[:9],
        [3.5e3, 4e3, 4.5e3, 5e3, 5.75e3, 6.5e3, 7.25e3, 8e3, 9e3, 10e3, 11e3, 12e3, 13e3, 14e3, 15.5e3, 17e3],
        [18.5e3, 20e3, 22e3, 24e3, 27e3, 30e3, 34e3, 38e3, 43e3, 50e3, 60e3, 7e4, 8e4, 9e4, 1e5],
        [1.1e5, 1.25e5, 1.5e5, 2e5, 2.8e5, 4e5, 6e5, 9e5, 1.3e6],
    ]
)
# Elevations of the source above that at which it rises [degree]; transmittance changes most there.
ABOVE_RISE = (0, 0.1, 0.2, 0.35, 0.5, 0.75, 1, 1.3, 1.7, 2.2, 2.8, 3.5, 4.5, 6, 8, 10, 13, 17, 22, 30, 40, 55, 75, 100)
_MOST_PARTS = 16
_SHARE = 1e-3  # of the largest light that a path lets through: what its parts may miss at most


@dataclass(frozen=True, eq=False)
class LightParts:
    """Light as a sum of K spectra.

    Attributes
    ----------
    value : (K, ...) array
        W m^-2 sr^-1.
    factor : (P, K) array
        Of each spectrum at the band's points: the light that reaches an observer is the sum over j and k of tau_j
        factor[j, k] value[k].
    """

    value: Floats
    factor: Floats

    @classmethod
    def of(cls, spectral: Floats, weight: Floats, through: Floats) -> LightParts:
        """Of light (..., P) by the points' weights (P,), as paths of transmittances (m, P) show it."""
        rows = spectral.reshape(-1, spectral.shape[-1]) * weight
        rows_used = rows[np.abs(rows).max(axis=1) > 0]
        if not rows_used.size:
            return cls(np.zeros((1, *spectral.shape[:-1])), np.zeros((weight.size, 1)))
        allowed = _SHARE * np.abs(rows_used @ through.T).max()
        order = pivots(rows_used * np.sqrt(np.mean(through**2, axis=0)))
        for count in range(1, min(_MOST_PARTS, weight.size) + 1):
            parts = fitted_parts(rows_used, np.sort(order[:count]))
            error = (rows_used[:, parts.index] @ parts.factor.T - rows_used) @ through.T
            if np.abs(error).max() <= allowed:
                break
        scale = parts.factor.sum(axis=0)
        scale = np.where(np.abs(scale) > 0, scale, 1.0)  # a value is then what a path without air lets through
        value = rows[:, parts.index].T * scale[:, None]
        return cls(value.reshape(parts.count, *spectral.shape[:-1]), parts.factor / scale)


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
        Of `ambient_harmonics.ground_emission`.
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


def surface_light(
    atmosphere: BandAtmosphere, irradiance: Floats, source_elevation: Floats, through: Floats, harmonics: int
) -> SurfaceLight:
    """Compute the light.

    Parameters
    ----------
    atmosphere : BandAtmosphere
    irradiance : (P,) array
        Of the source outside the atmosphere, W m^-2 (cm^-1)^-1.
    source_elevation : (SE,) array
        Nodes for diffuse light, degree.
    through : (m, P) array
        Transmittances of sample paths.
    harmonics : int
        How many; 0 for level surfaces alone.
    """
    air, weight = atmosphere.air, atmosphere.band.radiance_weight / np.pi
    air.prepare()
    heights = np.array(SKY_HEIGHTS, float)
    altitude = air.state.surface_altitude + heights
    targets = air.state.surface_altitude + TARGET_HEIGHTS
    elevation, dark = np.radians(source_elevation), np.zeros_like(irradiance)
    rise = air.source_rays.rise_at(targets)
    above = np.radians(np.array(ABOVE_RISE, float))
    beam = np.concatenate(
        [
            direct_transmittance(air.source_paths, targets[row : row + 1], np.minimum(up + above, np.pi / 2))
            for row, up in enumerate(rise)
        ]
    )
    emitted = SkyTable.of(air, altitude, elevation[:1], dark).at(altitude)[:, 0]
    lit = np.any(irradiance > 0) and air.scatters
    both = SkyTable.of(air, altitude, elevation, irradiance).at(altitude) if lit else emitted[:, None]
    scattered = np.maximum(both - emitted[:, None], 0.0) + np.zeros((altitude.size, elevation.size, 1))
    around: tuple[LightParts | None, LightParts | None, LightParts | None] = (None, None, None)
    if harmonics:
        own, to_ground = HarmonicSky.over_ground(air, elevation[:1], dark, harmonics).at(altitude)
        whole = own
        if lit:
            whole = HarmonicSky.over_ground(air, elevation, irradiance, harmonics).at(altitude)[0]
        rest = whole - own + np.zeros((altitude.size, elevation.size, 1, 1))
        around = (
            LightParts.of(np.moveaxis(own[:, 0], -1, 1), weight * np.pi, through),
            LightParts.of(np.moveaxis(rest, -1, 2), weight * np.pi, through),
            LightParts.of(np.moveaxis(to_ground, -1, 1), weight * np.pi, through),
        )
    return SurfaceLight(
        heights / 1e3,
        source_elevation,
        TARGET_HEIGHTS / 1e3,
        np.degrees(rise),
        np.degrees(above),
        LightParts.of(beam * irradiance, weight, through),
        LightParts.of(emitted, weight, through),
        LightParts.of(scattered, weight, through),
        *around,
        ground_emission(atmosphere.band),
    )
