"""One surface through the day or a record, with every flux."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.back_boundary import back_drive
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.canopy import CanopyBalance
from skyshine.mat.surface.canopy_days import solve_canopy
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import depth_response, frequencies
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.forcing import Scene, Sky, plane_irradiance, sun_cosine
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.penetrating_light import absorbed_sunlight, light_at_depth
from skyshine.mat.surface.record import Record, record_forcing
from skyshine.mat.surface.solution import Method, Solution
from skyshine.mat.surface.solver import DAY, solve_columns
from skyshine.mat.surface.sun_path import SOLAR_CONSTANT, SunPath
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Solar elevation and azimuth [degree] at UTC times.
SunAt: TypeAlias = Callable[[npt.NDArray[np.datetime64]], tuple[Floats, Floats]]
# Aureole of the light of a record, of whose air nothing is known: share of diffuse light from around the Sun over the
# index of Hay and Davies (1980), direct light over that above the atmosphere. Radiative transfer finds 0.3 to 0.9 of it
# under Suns of 20 to 60 degrees and visibilities of 23 to 80 km.
_AUREOLE = 0.6
_NO_DEPTH = "found a depth and leaf_area_index; allowed: one of them; remove one"
_SHOWN_STEPS = 192  # steps of a day that are printed: one column costs little, and fluxes by 7.5 min are smooth
LONGEST_STEP = 900.0  # s: coarser records are solved at a fraction of their step


@dataclass(frozen=True, eq=False)
class ColumnResult:
    """Temperatures and fluxes of one column; arrays are (N,).

    Attributes
    ----------
    time : list of float or str
        Times in `time_units`: hours of the local clock, or ISO 8601 (UTC).
    temperature : ndarray
        [K]
    fluxes : dict of str to ndarray
        [W m^-2]; absorbed ones positive inwards, the others outwards: absorbed = emitted + convection + evaporation
        + conduction + melt.
    residual, energy_closure, bound_excess : float
        [W m^-2], [W m^-2], [K]; see `skyshine.mat.surface.solution.Solution`.
    depth_temperature : ndarray or None
        Temperature at the requested depth [K].
    notes : tuple of str
        Defaults used for columns that the record lacks.
    film : ndarray or None
        Water on the surface, of an open canopy on its leaves [kg m^-2]; None without rain.
    leaf_temperature, soil_temperature : ndarray or None
        Temperatures of leaves and of the soil in their gaps [K], which `temperature` combines; None for a single skin.
    """

    time: list[float] | list[str]
    time_units: str
    temperature: Floats
    fluxes: dict[str, Floats]
    residual: float
    energy_closure: float
    bound_excess: float
    method: str
    iterations: int
    depth_temperature: Floats | None
    notes: tuple[str, ...] = ()
    film: Floats | None = None
    leaf_temperature: Floats | None = None
    soil_temperature: Floats | None = None

    def since(self, start: int) -> ColumnResult:
        """The result from a time on, by number."""
        series = ("time", "temperature", "depth_temperature", "film", "leaf_temperature", "soil_temperature")
        arrays = {name: values for name in series if (values := getattr(self, name)) is not None}
        fluxes = {name: values[start:] for name, values in self.fluxes.items()}
        return replace(self, fluxes=fluxes, **{name: values[start:] for name, values in arrays.items()})


def from_scene(
    material: SurfaceMaterial,
    sun: SunPath,
    weather: NearSurfaceAir,
    sky: Sky,
    altitude: float,
    slope: float,
    azimuth: float,
    depth: float | None = None,
    surroundings: Surroundings | None = None,
) -> ColumnResult:
    """A plane at an altitude [m] under a scene's Sun, sky and weather; slope and azimuth in degrees, depth in m."""
    scene = Scene(sun, weather, sky, np.array([altitude]), np.array([slope]), np.array([azimuth]), surroundings)
    if depth is not None and material.canopy is not None:
        raise InputError(_NO_DEPTH)
    if depth is not None and weather.before:
        raise InputError("found a depth and days before; allowed: one of them; remove history_days or the depth")
    ((_, solution),) = solve_days(material, scene.days, steps=_SHOWN_STEPS, fine_steps=None)
    steps = solution.temperature.shape[1]
    hours = [float(hour) for hour in np.arange(steps) * (24.0 / steps)]
    return _result(material, scene.forcing(steps), solution, (hours, "h"), DAY, depth)


def from_record(
    material: SurfaceMaterial,
    record: Record,
    slope: float,
    azimuth: float,
    sun: SunAt | None,
    ground_albedo: float,
    depth: float | None = None,
    surroundings: Surroundings | None = None,
    spin_up: int = 0,
) -> ColumnResult:
    """A plane under a measured record, periodic over its length; temperatures at the record's own times.

    Parameters
    ----------
    record : Record
        A back that is given by hour is given in UTC.
    slope, azimuth : float
        [degree]
    sun : callable or None
        Solar elevation and azimuth [degree] at UTC times; needed where the slope is not 0, with
        `surroundings`, and for a record of direct and diffuse light. Without it gaps of a canopy take all light as
        even.
    depth : float, optional
        Below the skin [m], at which the temperature is wanted too.
    surroundings : Surroundings, optional
        Hours of shade are in UTC.
    spin_up : int
        Days before the record, each as its first; without them what the ground keeps at its begin is of its end.
    """
    if spin_up:
        longer = record.after_first_day(spin_up)
        whole = from_record(material, longer, slope, azimuth, sun, ground_albedo, depth, surroundings)
        return whole.since(longer.steps - record.steps)
    if depth is not None and material.canopy is not None:
        raise InputError(_NO_DEPTH)
    factor = int(np.ceil(record.step / LONGEST_STEP - 1e-9))
    refined = record.refined(factor)
    start_hour = float((record.start - record.start.astype("datetime64[D]")) / np.timedelta64(1, "h"))
    shortwave = _shortwave(refined, slope, azimuth, sun, ground_albedo, surroundings, start_hour)
    cosine = None if sun is None else sun_cosine(slope, azimuth, *sun(refined.times))
    forcing = record_forcing(refined, shortwave, slope, surroundings, cosine)
    if material.canopy is not None:
        ((_, solution),) = solve_canopy(
            material,
            [lambda _: forcing],
            steps=refined.steps,
            fine_steps=None,
            period=refined.period,
            start_hour=start_hour,
            scheme="bdf2",
        )
    else:
        ((_, solution),) = solve_columns(
            material,
            lambda _: forcing,
            steps=refined.steps,
            fine_steps=None,
            period=refined.period,
            start_hour=start_hour,
            scheme="bdf2",
        )
    times = [f"{time}Z" for time in np.datetime_as_string(record.times, unit="s")]
    result = _result(material, forcing, solution, (times, "ISO 8601"), refined.period, depth, factor, start_hour)
    return replace(result, notes=record.notes)


def _shortwave(
    record: Record,
    slope: float,
    azimuth: float,
    sun: SunAt | None,
    ground_albedo: float,
    surroundings: Surroundings | None,
    start_hour: float,
) -> tuple[Floats, Floats, Floats]:
    """Direct, diffuse and reflected irradiance on the plane; a level one takes the measured sum as diffuse.

    References
    ----------
    Direct and diffuse parts of the measured sum: Erbs, Klein and Duffie (1982), Solar Energy 28, 293-302, as in pvlib.
    """
    total = record.values.get("sw_down")
    if sun is None:
        if total is None:
            raise InputError("direct_normal and diffuse need the Sun; give latitude and longitude, or a column sw_down")
        return np.zeros_like(total), total, np.zeros_like(total)
    import pvlib

    elevation, sun_azimuth = sun(record.times)
    times = record.times.astype("datetime64[D]")
    day = (times - times.astype("datetime64[Y]")).astype(int) + 1
    if "direct_normal" in record.values and "diffuse" in record.values:
        parts = {"dni": record.values["direct_normal"], "dhi": record.values["diffuse"]}
    else:
        parts = pvlib.irradiance.erbs(total, 90.0 - elevation, day)
    normal = np.asarray(pvlib.irradiance.get_extra_radiation(day, solar_constant=SOLAR_CONSTANT))
    aureole = _AUREOLE * np.minimum(parts["dni"] / normal, 1.0)
    direct, diffuse, reflected = plane_irradiance(
        slope, azimuth, elevation, sun_azimuth, parts["dni"], parts["dhi"], ground_albedo, aureole
    )
    if surroundings is None:
        return direct, diffuse, reflected
    step = record.step / 3600.0
    shaded = surroundings.shaded(start_hour + step * np.arange(float(record.steps)), step)
    even = 0.5 * (1 + np.cos(np.radians(slope))) * (1 - aureole) * parts["dhi"]
    return *surroundings.sunlight(direct, diffuse, even, shaded), reflected


def _result(
    material: SurfaceMaterial,
    forcing: Forcing,
    solution: Solution,
    clock: tuple[list[float] | list[str], str],
    period: float,
    depth: float | None,
    stride: int = 1,
    start_hour: float = 0.0,
) -> ColumnResult:
    """The result at `stride`-th solver time."""
    leaves, soil = None, None
    if solution.sources is None:
        fluxes = Balance(solution.under(forcing, material), material).fluxes(solution.temperature)
    else:
        fluxes = CanopyBalance(solution.under(forcing, material), material).fluxes(solution.sources)
        leaves, soil = np.split(solution.sources[0], 2)
    gain = fluxes["shortwave_absorbed"] + fluxes["longwave_absorbed"]
    spent = fluxes["longwave_emitted"] + fluxes["convection"] + fluxes["evaporation"] + solution.melt
    fluxes |= {"conduction": gain - spent, "melt": solution.melt}
    surface = solution.temperature[0]
    return ColumnResult(
        time=clock[0],
        time_units=clock[1],
        temperature=surface[::stride],
        fluxes={name: np.asarray(values[0, ::stride], float) for name, values in fluxes.items()},
        residual=float(solution.residual[0]),
        energy_closure=float(solution.energy_closure[0]),
        bound_excess=float(solution.bound_excess[0]),
        method=Method(solution.method[0]).name.lower(),
        iterations=int(solution.iterations[0]),
        film=None if solution.film is None else solution.film[0, : surface.size : stride],
        leaf_temperature=None if leaves is None else leaves[::stride],
        soil_temperature=None if soil is None else soil[::stride],
        depth_temperature=None
        if depth is None
        else _at_depth(material, forcing, surface, period, depth, start_hour)[::stride],
    )


def _at_depth(
    material: SurfaceMaterial, forcing: Forcing, surface: Floats, period: float, depth: float, start_hour: float
) -> Floats:
    """Temperature at a depth [m] below the skin, from the surface's (N,) [K] and the back's drive, wave by wave."""
    steps = len(surface)
    hours = start_hour + np.arange(float(steps)) * (period / steps / 3600.0)
    drive = back_drive(material, forcing, hours)[0] + np.zeros(steps)
    waves = frequencies(steps, period, "spectral")
    from_surface, from_back = depth_response(material.thermal, waves, depth)
    spectrum = np.fft.rfft(surface) * from_surface + np.fft.rfft(drive) * from_back
    if material.thermal.light:
        spectrum = spectrum + np.fft.rfft(absorbed_sunlight(material, forcing)[0]) * light_at_depth(
            material.thermal, waves, depth
        )
    temperature: Floats = np.fft.irfft(spectrum, steps)
    return temperature
