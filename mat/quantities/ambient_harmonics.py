"""Spherical harmonics of the radiance around a surface, weighted as equation (20) weights the level sky.

The emission of the ground follows its own temperature, by the hour, and is stored separately: of unit radiance,
weighted at a few temperatures of the ground, since the path weighs the colours of its emission.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import Rays, trace
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathScope
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.radiance_field import Directions, GroundReflection, RadianceField, cell_phases
from skyshine.mat.quantities.sky_table import SkyTable
from skyshine.mat.quantities.surface_light import radiance_weight
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.spherical_harmonics import HARMONICS, harmonics_at, zonal
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats

# Zenith angles of a hemisphere and azimuths of half a turn. Against 32 x 24, harmonics up to l = 4 give faces at the
# ground the same radiance within 0.003 K at reflectance 0.3, faces 2 km above it within 0.01 K, in 3-5 and 8-12 um.
ZENITHS, AZIMUTHS = 12, 6
# Heights above the ground [m] at which radiance is computed; between them its share in irradiance is linear.
HEIGHTS = (0, 250, 1e3, 2e3, 3e3, 5e3, 8e3, 12e3, 17e3, 30e3, 60e3)
# K; between them the weight of the ground's emission is linear to 1e-3 of it.
GROUND_TEMPERATURES = (230.0, 280.0, 330.0, 380.0)


@dataclass(frozen=True, eq=False)
class AmbientHarmonics:
    """Tables of harmonics on a grid.

    Attributes
    ----------
    radiance : (R, A, E, SE, H) array
        Coefficients of the radiance around the end of each line of sight, without the ground's emission, W m^-2 sr^-1.
    ground : (R, A, E, T, Z) array
        Coefficients of the harmonics `zonal` of the ground's emission, per unit of the radiance that it emits in the
        band at each of `GROUND_TEMPERATURES`.
    """

    grid: PathGrid
    radiance: Floats
    ground: Floats

    @property
    def count(self) -> int:
        """Number of harmonics."""
        return int(self.radiance.shape[-1])


@dataclass(frozen=True, eq=False)
class HarmonicSky:
    """Coefficients of the radiance around points at Z altitudes, at P spectral points.

    Attributes
    ----------
    sky : SkyTable
        Irradiance of a level face, from the same directions.
    above : (Z, SE, P, H) array
        Coefficients of the upper hemisphere over that irradiance.
    below : (Z, SE, P, H) array
        Radiance of the lower hemisphere, without the ground's emission, W m^-2 sr^-1 (cm^-1)^-1.
    ground : (Z, P, L) array
        Coefficients of the harmonics `zonal` of the transmittance to the ground.
    """

    sky: SkyTable
    above: Floats
    below: Floats
    ground: Floats

    @classmethod
    def of(
        cls, air: SpectralAir, altitude: Floats, source_elevation: Floats, irradiance: Floats, count: int
    ) -> HarmonicSky:
        """Compute the first `count` harmonics at altitudes (any,) [m] inside the atmosphere; other arguments as
        `SkyTable.of`.
        """
        altitude = np.unique(np.minimum(altitude, air.shells.top))
        directions = Directions.of(ZENITHS, AZIMUTHS)
        basis = harmonics_at(directions.vectors, HARMONICS[:count]) * directions.solid_angle[..., None]
        axial = harmonics_at(directions.vectors[:, 0], zonal(count)) * 2 * np.pi * directions.weight[:, None]
        level = directions.irradiance_weights(np.array([0.0, 0.0, 1.0]))
        reflection = GroundReflection.of(air, source_elevation)
        phases = cell_phases(air, directions, source_elevation) if np.any(irradiance > 0) else None

        def at(height: float) -> tuple[Floats, Floats, Floats, Floats]:
            field = RadianceField.at(air, height, source_elevation, reflection, directions, phases)
            radiance = field.radiance(irradiance)
            above = np.einsum("dah,dsap->sph", basis[ZENITHS:], radiance[ZENITHS:])
            below = np.einsum("dah,dsap->sph", basis[:ZENITHS], radiance[:ZENITHS])
            flux = np.einsum("da,dsap->sp", level, radiance)
            return above, below, flux, np.einsum("dl,dp->pl", axial, field.to_ground)

        above, below, flux, ground = (np.stack(part) for part in zip(*parallel_map(at, list(altitude)), strict=True))
        flux = np.maximum(flux, np.finfo(float).tiny)
        return cls(SkyTable(air, altitude, np.log(flux)), above / flux[..., None], below, ground)

    @classmethod
    def over_ground(
        cls, air: SpectralAir, source_elevation: Floats, irradiance: Floats, count: int, scope: PathScope = ALL_PATHS
    ) -> HarmonicSky:
        """The table at those of `HEIGHTS` above the ground that are read; arguments as `of`."""
        altitude = air.state.surface_altitude + scope.heights(HEIGHTS)
        return cls.of(air, altitude, source_elevation, irradiance, count)

    def at(self, altitude: Floats) -> tuple[Floats, Floats]:
        """Coefficients (R, SE, P, H) [W m^-2 sr^-1 (cm^-1)^-1] at altitudes (R,) [m], and of the transmittance to the
        ground (R, P, L): those of the sky in proportion to its irradiance.
        """
        nodes = self.sky.altitude
        lower = np.clip(np.searchsorted(nodes, altitude, side="right") - 1, 0, max(nodes.size - 2, 0))
        upper = np.minimum(lower + 1, nodes.size - 1)
        step = np.where(upper > lower, nodes[upper] - nodes[lower], 1.0)
        share = np.clip((altitude - nodes[lower]) / step, 0.0, 1.0)

        def between(values: Floats) -> Floats:
            part = share.reshape(-1, *(1,) * (values.ndim - 1))
            mixed: Floats = values[lower] * (1 - part) + values[upper] * part
            return mixed

        radiance = between(self.above) * self.sky.at(altitude)[..., None] + between(self.below)
        return radiance, between(self.ground)


def harmonics_along(band: BandPoints, path: LineOfSight, sky: HarmonicSky, emission: Floats) -> tuple[Floats, Floats]:
    """The coefficients at each range of a line of sight, (R, SE, H) and (R, T, L), as in `AmbientHarmonics`.

    Parameters
    ----------
    emission : (T, P) array
        Emission of the ground, from `ground_emission`.
    """
    weight = np.pi * radiance_weight(band, path)
    radiance, ground = sky.at(path.surface_altitude)
    return (
        np.einsum("rp,rsph->rsh", weight, radiance, optimize=True),
        np.einsum("rp,tp,rpl->rtl", weight, emission, ground, optimize=True),
    )


def ground_emission(band: BandPoints) -> Floats:
    """Spectral radiance of black bodies at `GROUND_TEMPERATURES` over their radiance in the band, (T, P)."""
    spectral = planck_wavenumber(band.wavenumber, np.array(GROUND_TEMPERATURES)[:, None])
    emission: Floats = spectral / (spectral @ band.radiance_weight)[:, None]
    return emission


def ambient_harmonics(atmosphere: BandAtmosphere, grid: PathGrid, irradiance: Floats, count: int) -> AmbientHarmonics:
    """Tables of the first `count` harmonics on a grid.

    Parameters
    ----------
    irradiance : (P,) array
        Irradiance of the source, as in `BandAtmosphere.table`.
    count : int
        One of `spherical_harmonics.COUNTS`.
    """
    air, band = atmosphere.air, atmosphere.band
    ranges, elevation = grid.range_km * 1e3, np.radians(grid.elevation_deg)
    source = np.radians(grid.source_elevation_deg)
    air.prepare()
    sky = HarmonicSky.over_ground(air, source, irradiance, count, atmosphere.scope)
    emission = ground_emission(band)
    radiance = np.empty((*grid.shape[:4], count))
    ground = np.empty((*grid.shape[:3], len(GROUND_TEMPERATURES), len(zonal(count))))

    def line(rays: Rays, altitude: float, row: int) -> tuple[Floats, Floats]:
        path = LineOfSight.of(air, rays, row, altitude, elevation[row], ranges)
        return harmonics_along(band, path, sky, emission)

    reach = np.broadcast_to(ranges, (elevation.size, ranges.size))
    for level, altitude in enumerate(grid.altitude_km * 1e3):
        rays = trace(air.shells, np.full(elevation.size, altitude), elevation, reach)
        lines = parallel_map(partial(line, rays, altitude), range(elevation.size))
        for row, (of_sky, of_ground) in enumerate(lines):
            radiance[:, level, row], ground[:, level, row] = of_sky, of_ground
    return AmbientHarmonics(grid, radiance, ground)
