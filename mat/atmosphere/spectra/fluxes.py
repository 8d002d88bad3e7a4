"""Broadband fluxes on the ground: longwave of the sky, direct and diffuse sunlight, at any altitude and elevation of
the Sun.

A few spectral points represent the whole thermal and the whole solar spectrum. They are chosen from the points of the
absorption table by `mat.maintain.lines.broadband`, with fluxes of many states as targets; their file states the
errors. At a point everything is as in a sensor's band: layers with their gases, particles and cloud,
refracted beams through spherical shells, diffuse light by discrete ordinates with the ground's reflection.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine import atmospheres
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable, default_water_continuum
from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.ordinate_light import level_light
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, forward_scattered, sky_irradiance, zenith_angles
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import open_database, sound

FILETYPE = "broadband"
# cm^-1. Thermal: less than 0.1 % of the radiance of a black body of 330 K lies outside. Solar: radiation below 0.3 um
# does not reach the ground, and that beyond 12.5 um is below 0.4 W m^-2.
LONGWAVE, SHORTWAVE = (10.0, 3400.0), (800.0, 33400.0)
QUANTITIES = ("longwave_down", "longwave_levels", "direct_normal", "diffuse")
# Zenith angles of the thermal sky: Gauss nodes in the cosine; against 24 of them, 2e-4.
_ZENITHS = 8


@dataclass(frozen=True, eq=False)
class BroadbandFluxes:
    """Fluxes at A altitudes and S elevations of the Sun, W m^-2.

    Attributes
    ----------
    altitude : (A,) array
        m.
    source_elevation : (S,) array
        degree.
    longwave_down : (A,) array
        Thermal irradiance of a horizontal surface by the sky.
    direct_normal : (A, S) array
        Sunlight that was not scattered, on a surface normal to it; 0 where the Earth hides the Sun.
    diffuse : (A, S) array
        Scattered sunlight on a horizontal surface, from the sky.
    """

    altitude: Floats
    source_elevation: Floats
    longwave_down: Floats
    direct_normal: Floats
    diffuse: Floats


@dataclass(frozen=True, eq=False)
class BroadbandPoints:
    """The points that represent the thermal and the solar spectrum.

    Attributes
    ----------
    longwave, longwave_levels : SpectralPoints
        Points of the thermal flux from the sky, and of upward and downward ones on all levels, with weights in cm^-1.
    shortwave : SpectralPoints
        Points with weights in W m^-2 of sunlight outside the atmosphere at 1 au.
    errors : dict
        Errors by quantity: {"max", "p95", "rms"}, W m^-2, against all points of the table, on states the points were
        not fitted to.
    """

    longwave: SpectralPoints
    longwave_levels: SpectralPoints
    shortwave: SpectralPoints
    errors: dict[str, dict[str, float]]

    @classmethod
    def open(cls, path: str | Path | None = None, table: AbsorptionTable | None = None) -> BroadbandPoints:
        """Read a file of broadband points, by default the packaged one for the packaged absorption table.

        The table may have another water vapour continuum than the one with which the points were chosen.

        Raises
        ------
        InputError
            The file is missing or damaged, or belongs to another absorption table.
        """
        path = atmospheres.path("broadband.h5") if path is None else path
        table = AbsorptionTable.open() if table is None else table
        with open_database(path, FILETYPE) as file, sound(path):
            if str(file.attrs["absorption_sha256"]) != table.content.split()[0]:
                raise InputError(
                    f"was chosen from another absorption table than {table.path}; choose anew in a"
                    " checkout: python -m mat.maintain.lines broadband --out FILE",
                    file=path,
                )

            def chosen(points: SpectralPoints, name: str) -> SpectralPoints:
                return points.subset(file[name]["index"][()], file[name]["weight"][()].astype(float))

            thermal = table.points(*LONGWAVE)
            longwave, levels = chosen(thermal, "longwave"), chosen(thermal, "longwave_levels")
            shortwave = chosen(table.points(*SHORTWAVE), "shortwave")
            errors = {
                name: {key: float(file["errors"][name].attrs[key]) for key in ("max", "p95", "rms")}
                for name in QUANTITIES
            }
        return cls(longwave, levels, shortwave, errors)


@lru_cache(maxsize=2)
def packaged_points(water_continuum: str | None = None) -> BroadbandPoints:
    """The packaged points with a water vapour continuum, by default that of jobs; read once a process."""
    name = default_water_continuum() if water_continuum is None else water_continuum
    return BroadbandPoints.open(table=AbsorptionTable.open(water_continuum=name))


def broadband_fluxes(
    state: AtmosphericState,
    altitude: npt.ArrayLike,
    source_elevation: npt.ArrayLike,
    ground_albedo: float,
    *,
    sun_distance: float = 1.0,
    points: BroadbandPoints | None = None,
) -> BroadbandFluxes:
    """Longwave and shortwave irradiance of the ground under a state.

    Parameters
    ----------
    state : AtmosphericState
        State with its particles.
    altitude : (A,) array
        Altitudes of the surfaces, m; from the state's ground up.
    source_elevation : (S,) array
        Geometric elevations of the Sun there, degree, -90 to 90; diffuse light ends with twilight.
    ground_albedo : float
        Albedo of the surroundings for sunlight, 0 to 1.
    sun_distance : float
        au.
    points : BroadbandPoints, optional
        Spectral points; by default the packaged ones.

    Raises
    ------
    InputError
        An altitude below the ground of the state or above its highest level, an elevation or an albedo outside its
        range.
    """
    altitude, elevation = (np.atleast_1d(np.asarray(x, dtype=float)) for x in (altitude, source_elevation))
    _check(state, altitude, elevation, ground_albedo, sun_distance)
    points = packaged_points() if points is None else points
    longwave = sky_emission(state, points.longwave, altitude) @ points.longwave.weight
    sunlight = points.shortwave.weight / sun_distance**2
    air = SpectralAir.of(state, points.shortwave)
    direct, diffuse = (part @ sunlight for part in sunlight_shares(air, altitude, elevation, ground_albedo))
    return BroadbandFluxes(altitude, elevation, longwave, direct, diffuse)


def sky_emission(state: AtmosphericState, points: SpectralPoints, altitude: Floats) -> Floats:
    """Thermal irradiance of a horizontal surface by the sky at altitudes (A,) [m], at each point: (A, P) W m^-2
    (cm^-1)^-1.
    """
    air = replace(SpectralAir.of(state, points), angles=tuple(sorted(zenith_angles(_ZENITHS))))
    return sky_irradiance(air, altitude, np.zeros(0), zeniths=_ZENITHS).thermal


def sunlight_shares(
    air: SpectralAir, altitude: Floats, source_elevation: Floats, ground_albedo: float, *, spherical: bool = True
) -> tuple[Floats, Floats]:
    """Direct and diffuse sunlight at a surface, per unit of the irradiance normal to it outside the atmosphere.

    Parameters
    ----------
    air : SpectralAir
    altitude : (A,) array, m
    source_elevation : (S,) array, degree
    spherical : bool
        Diffuse light under a low source is that of spherical layers, otherwise of plane ones.

    Returns
    -------
    direct : (A, S, P) array
        On a surface normal to the beam.
    diffuse : (A, S, P) array
        On a horizontal surface, from above; with the light that particles scatter straight forward, however near to the
        Sun.
    """
    elevation, sine = np.radians(source_elevation), np.sin(np.radians(source_elevation))
    direct = direct_transmittance(air.source_paths, altitude, elevation)
    diffuse = np.maximum(sine, 0.0)[:, None] * forward_scattered(air, altitude, elevation, direct)
    levels = air.state.altitude
    lower = np.clip(np.searchsorted(levels, altitude, side="right") - 1, 0, levels.size - 2)
    share = ((altitude - levels[lower]) / np.diff(levels)[lower])[:, None, None]
    _, falling = level_light(
        air.state,
        air.shells,
        air.optics,
        air.delta_fraction,
        air.scaled_source_paths,
        sine,
        ground_albedo,
        air.nodes,
        spherical=spherical,
    )
    diffuse += falling[lower] * (1 - share) + falling[lower + 1] * share
    return direct, diffuse


def _check(
    state: AtmosphericState, altitude: Floats, elevation: Floats, ground_albedo: float, sun_distance: float
) -> None:
    low, high = state.altitude[[0, -1]]
    if not np.all((altitude >= low) & (altitude <= high)):
        raise InputError(
            f"found surface altitudes {altitude.min():g} to {altitude.max():g} m; allowed: {low:g} to {high:g} m, the"
            f" ground and the highest level of atmospheric state '{state.name}'"
        )
    if not np.all(np.abs(elevation) <= 90.0):
        raise InputError(
            f"found source elevations {elevation.min():g} to {elevation.max():g} degree; allowed: -90 to 90"
        )
    if not 0.0 <= ground_albedo <= 1.0:
        raise InputError(f"found ground albedo {ground_albedo:g}; allowed: 0 to 1")
    if not (np.isfinite(sun_distance) and sun_distance > 0):
        raise InputError(f"found distance of the Sun {sun_distance:g} au; allowed: above 0")
