"""Ambient radiance of a face of any direction, integrated directly over its hemisphere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS
from skyshine.mat.quantities.radiance_field import Directions, GroundReflection, RadianceField, cell_phases
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Booleans, Floats

# Zenith angles of a hemisphere and azimuths of half a turn; against 32 x 24: 0.006 K rms and 0.02 K at most, at
# reflectance 0.3, in 3-5 and 8-12 um.
ZENITHS, AZIMUTHS = 12, 6


@dataclass(frozen=True, eq=False)
class Walls:
    """Walls that hide a part of the sky of n faces, evenly in all directions above the horizon.

    Attributes
    ----------
    sky_view : (n,) array
        Open share of the sky, 0 to 1.
    temperature, emissivity : (n,) arrays
        K; what a wall does not emit it reflects of sky and ground in equal parts, of sunlight nothing.
    """

    sky_view: Floats
    temperature: Floats
    emissivity: Floats


@dataclass(frozen=True, eq=False)
class Facets:
    """n faces, and the ground and walls around them.

    Attributes
    ----------
    normal : (n, 3) array
        Normals from `spherical_harmonics.face_normal`.
    ground_temperature : (n,) array
        K.
    altitude : (n,) array or None
        m, at which the light around is computed; by default where their lines of sight end.
    """

    normal: Floats
    ground_temperature: Floats
    altitude: Floats | None = None
    walls: Walls | None = None

    def take(self, rows: Booleans) -> Facets:
        """Some of the faces."""
        walls = self.walls
        if walls is not None:
            walls = Walls(walls.sky_view[rows], walls.temperature[rows], walls.emissivity[rows])
        altitude = None if self.altitude is None else self.altitude[rows]
        return Facets(self.normal[rows], self.ground_temperature[rows], altitude, walls)


def light_among_walls(
    air: SpectralAir, altitude: Floats, source_elevation: Floats, irradiance: Floats, faces: Facets
) -> Floats:
    """Irradiance (n, P) of n faces, W m^-2 (cm^-1)^-1; faces under one sky share its computation.

    Parameters
    ----------
    altitude, source_elevation : (n,) arrays
        m; geometric, rad.
    irradiance : (P,) array
        Irradiance of the source outside the atmosphere, normal to the beam, W m^-2 (cm^-1)^-1; the ambient light
        excludes the direct beam.
    """
    if not len(faces.normal):
        return np.zeros((0, irradiance.size))
    directions = Directions.of(ZENITHS, AZIMUTHS)
    weights = np.stack([directions.irradiance_weights(face) for face in faces.normal])
    walls = faces.walls
    if walls is not None:
        weights[:, ZENITHS:] *= walls.sky_view[:, None, None]
    upright = np.zeros_like(weights[:1])
    upright[0, ZENITHS:] = directions.irradiance_weights(np.array([0.0, 0.0, 1.0]))[ZENITHS:]
    skies, sky_of = np.unique(
        np.stack([altitude, source_elevation, faces.ground_temperature], axis=1), axis=0, return_inverse=True
    )
    sky_weights = [np.concatenate([weights[sky_of == number], upright]) for number in range(len(skies))]
    parts = _weighted_light(air, skies[:, 0], skies[:, 1], directions, sky_weights, irradiance, skies[:, 2])
    light, level = np.empty((altitude.size, irradiance.size)), np.empty((altitude.size, irradiance.size))
    for number, part in enumerate(parts):
        light[sky_of == number], level[sky_of == number] = part[:-1], part[-1]
    if walls is None:
        return light
    air_temperature = np.full_like(altitude, air.state.surface_temperature)
    black, even = (
        planck_wavenumber(air.optics.wavenumber, kelvin[:, None]) for kelvin in (walls.temperature, air_temperature)
    )
    emissivity = walls.emissivity[:, None]
    wall = emissivity * black + (1 - emissivity) * 0.5 * (level / np.pi + even)
    hidden = (1 - walls.sky_view) * 0.5 * (1 + faces.normal[:, 2])
    return light + np.pi * hidden[:, None] * wall


def _weighted_light(
    air: SpectralAir,
    altitude: Floats,
    source_elevation: Floats,
    directions: Directions,
    weights: Sequence[Floats],
    irradiance: Floats,
    ground_temperature: Floats,
) -> list[Floats]:
    """Sums of the radiance around n places, each with weights (F, D, A) of its own: n of (F, P)."""
    air.prepare()
    # Light of a source so far below the horizon nothing is scattered.
    dark = replace(air, scatters=False)
    emissivity = 1 - air.state.albedo_at(air.optics.wavenumber)

    def one(number: int) -> Floats:
        source = source_elevation[number : number + 1]
        point_air = air if source[0] > np.radians(ELEVATIONS[0]) else dark
        reflection = GroundReflection.of(point_air, source)
        phases = cell_phases(point_air, directions, source)
        field = RadianceField.at(point_air, float(altitude[number]), source, reflection, directions, phases)
        emitted = emissivity * planck_wavenumber(air.optics.wavenumber, ground_temperature[number])
        radiance = field.radiance(irradiance)[:, 0] + (field.to_ground * emitted)[:, None]
        light: Floats = np.einsum("fda,dap->fp", weights[number], radiance, optimize=True)
        return light

    _ = directions.samples  # before threads share it
    return parallel_map(one, range(altitude.size))
