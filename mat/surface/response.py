"""Linear response of surfaces to a change of absorbed heat, and how their heat loss departs from linear.

About a solution T of f(T) + C T = source, a small change q of the absorbed heat moves T by about J^-1 q, J = s + C,
with the day's mean s of f' (of leaves the geometric one). One s a day lets readers take rows between hours though f'
changes tenfold at sunrise. The rows of J^-1 at `RESPONSE_HOURS` are summed over cells of lag: heat that was absorbed
long ago matters by its mean over hours. The excess of f over s T is added, which is tabulated against temperature; with
it the response of one face is valid for faces of other azimuths, on which the Sun shines at other hours.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.canopy_response import CanopyResponse
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction, real_at_end
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.film_response import DRY_FILM, FilmResponse, film_response, under_film
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.penetrating_light import penetrating_light_harmonics
from skyshine.mat.surface.reading import in_steps
from skyshine.mat.surface.relaxation import melting_cap
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS, RESPONSE_HOURS, response_slopes
from skyshine.mat.surface.solution import Method, Solution
from skyshine.mat.surface.solver import DAY, FINE_STEPS, STEPS
from skyshine.mat.surface.sun_path import SunPath
from skyshine.schemas.arrays import Floats, Integers, Singles
from skyshine.schemas.digits import rounded_bits, rounded_to

# m between altitudes at most: leaves draw water by the temperature and dryness of their air, so that what they lose at
# an offset from it is not linear in altitude. Of grass in calm air 3 km apart, shade errs by 1.8 K rms without it.
ALTITUDE_STEP = 1000.0
# degree from the stored plane, of the planes over which the response of leaves and soil is averaged: how both share
# heat follows the angle of the sunlight. Grass on random planes errs by 0.34 K rms with four, by 0.50 K with one.
CANOPY_TURNS = np.array([0.0, 90.0, 180.0, 270.0])
_DIGITS = 11  # binary ones of a response: 0.02 % of it
# Steps of heat losses in what they change the temperature by [K]: up to so many kelvin from the air's temperature, and
# in proportion to the offset beyond. Half of one is below a thirtieth of the error that shade has by other terms.
_LOSS_STEP, _NEAR = 1 / 8, 10.0
NO_LIMIT = 1e4  # K, above all temperatures of a database
_LEAST_SLOPE = 1e-3  # W m^-2 K^-1, as in Newton's matrix
_COLDEST = 20.0  # K: the vapour's laws end there, and no surface under a sky is colder


@dataclass(frozen=True, eq=False)
class SurfaceResponse:
    """Response of some columns.

    Attributes
    ----------
    kernel : ndarray, shape (columns, 24, L)
        Kelvin at `RESPONSE_HOURS` per mean change of absorbed heat over each cell of lag [K m^2 W^-1].
    temperature : ndarray, shape (columns, 24)
        Temperature to which `OFFSETS` are added [K]: that of the air, or of the surface itself where there is none.
    loss_slope : ndarray, shape (columns, 24)
        Mean over the day of the derivative of the heat loss f by temperature [W m^-2 K^-1].
    loss_excess : ndarray, shape (columns, 24, O)
        f at `OFFSETS` from `temperature`, less f there and less the offset times that derivative [W m^-2].
    melt : ndarray, shape (columns, 24)
        Heat spent on melting [W m^-2].
    film : FilmResponse or None
        What a film of water changes; the others are then of the dry surface. None: surfaces know no film.
    """

    kernel: Floats
    temperature: Floats
    loss_slope: Floats
    loss_excess: Floats
    melt: Floats
    film: FilmResponse | None = None

    @classmethod
    def empty(cls, columns: int, *, film: bool = False) -> SurfaceResponse:
        """Of surfaces whose temperature is given: no heat changes it. With `film` it has one that has no water."""
        hours = (columns, RESPONSE_HOURS.size)
        return cls(
            np.zeros((*hours, LAG_STARTS.size)),
            np.zeros(hours),
            np.ones(hours),
            np.zeros((*hours, OFFSETS.size)),
            np.zeros(hours),
            FilmResponse.empty(*hours, OFFSETS.size) if film else None,
        )

    def mean_of_planes(self, counts: Integers) -> SurfaceResponse:
        """Means over planes that follow each other, so many (S,) for each of S planes, at every altitude.

        Only of leaves, which no film covers.
        """
        starts = np.cumsum(counts) - counts

        def mean(values: Floats) -> Floats:
            by_plane = values.reshape(-1, counts.sum(), *values.shape[1:])
            total = np.add.reduceat(by_plane, starts, axis=1) / counts.reshape(-1, *[1] * (values.ndim - 1))
            return np.asarray(total.reshape(-1, *values.shape[1:]))

        film = (
            None if self.film is None else FilmResponse.empty(len(mean(self.melt)), RESPONSE_HOURS.size, OFFSETS.size)
        )
        return SurfaceResponse(
            mean(self.kernel),
            mean(self.temperature),
            mean(self.loss_slope),
            mean(self.loss_excess),
            mean(self.melt),
            film,
        )


def response_planes(sun: SunPath, slopes: Floats) -> tuple[Floats, Floats]:
    """Those slopes and the azimuth of each plane [degree]: walls are those that face the Sun at its highest."""
    chosen = response_slopes(slopes)
    return chosen, np.full(chosen.size, float(sun.solar_azimuth[np.argmax(sun.solar_elevation)]))


def surface_response(
    material: SurfaceMaterial, days: Sequence[Callable[[int], Forcing]], *, steps: int = STEPS
) -> SurfaceResponse:
    """Response of all columns of a material.

    Parameters
    ----------
    days : sequence of callables
        Functions as in `skyshine.mat.surface.days.solve_days`.
    steps : int
        Solver times of a day.

    Notes
    -----
    J is taken in fine steps, by BDF2, about the solution in coarser ones, read between its times: a shadow comes and
    goes within minutes. Melting is not in J: the response is that of a surface of this temperature that does not
    melt. Readers end the melting before such a surface cools. Where layers let sunlight in, the kernel is that of a
    change of sunlight, which shade is for the most part.
    """
    forcing = days[-1](FINE_STEPS)
    response = SurfaceResponse.empty(forcing.shape[0], film=forcing.rain is not None)
    for columns, solution in solve_days(material, days, steps=steps):
        _fill(response, material, forcing.columns(columns), columns, solution)
    return response


def _fill(
    response: SurfaceResponse, material: SurfaceMaterial, forcing: Forcing, columns: Integers, solution: Solution
) -> None:
    """Put the response of columns that were solved alike."""
    forcing = under_film(forcing, DRY_FILM) if material.canopy is None else solution.under(forcing, material)
    temperature, melt = (in_steps(values, FINE_STEPS) for values in (solution.temperature, solution.melt))
    at_hours = np.arange(RESPONSE_HOURS.size) * (FINE_STEPS // RESPONSE_HOURS.size)
    cells = lag_cells(FINE_STEPS)
    if solution.sources is None:
        by_lag, slope = _skin_kernel(material, forcing, temperature, solution, at_hours)
        response.kernel[columns] = np.add.reduceat(by_lag, cells, axis=1)[:, None]
        balance = Balance(forcing.times(at_hours).columns(np.repeat(np.arange(columns.size), OFFSETS.size)), material)
        airless = balance.airless

        def lost(moved: Floats) -> Floats:
            """Heat losses at temperatures (columns, O, 24)."""
            return np.asarray(balance.loss(moved.reshape(-1, moved.shape[-1])), float).reshape(moved.shape)

    else:
        sources = np.concatenate([in_steps(part, FINE_STEPS) for part in np.split(solution.sources, 2, axis=1)], axis=1)
        about = CanopyResponse(material, forcing, sources, _scheme(solution), at_hours)
        slope, airless = about.slope, False

        def lost(moved: Floats) -> Floats:
            """Heat losses at temperatures (columns, O, 24)."""
            return np.stack([about.loss(part) for part in np.moveaxis(moved, 1, 0)], axis=1)

        lags = (at_hours[:, None] - np.arange(FINE_STEPS)) % FINE_STEPS
        for column, inverse in zip(columns, about.kernel, strict=True):
            response.kernel[column] = np.add.reduceat(np.take_along_axis(inverse, lags, axis=1), cells, axis=1)
    response.loss_slope[columns] = slope
    response.melt[columns] = melt[:, at_hours]
    origin = temperature[:, at_hours]
    if not airless:
        origin = np.broadcast_to(forcing.times(at_hours).air_temperature, origin.shape)
    response.temperature[columns] = origin
    moved = np.maximum(origin[:, None] + OFFSETS[:, None], _COLDEST)
    loss = lost(moved)
    excess = loss - loss[:, OFFSETS == 0] - slope[:, None] * (moved - origin[:, None])
    response.loss_excess[columns] = np.swapaxes(excess, 1, 2)
    if response.film is not None and solution.film is not None and material.canopy is None:
        temperatures = [np.maximum(origin + offset, _COLDEST) for offset in OFFSETS]
        film = film_response(material, forcing.times(at_hours), temperatures, solution.film[:, 0])
        response.film.put(columns, film)


def _scheme(solution: Solution) -> str:
    return "euler" if solution.method[0] in (Method.EULER, Method.EULER_NEWTON) else "bdf2"


def _skin_kernel(
    material: SurfaceMaterial, forcing: Forcing, temperature: Floats, solution: Solution, at_hours: Integers
) -> tuple[Floats, Floats]:
    """J^-1 by lag (columns, FINE_STEPS), equal at all times since s is, and s at some times (columns, times)."""
    conduction = Conduction(material.thermal, FINE_STEPS, DAY, _scheme(solution))
    _, slope = Balance(forcing, material).loss_and_slope(temperature)
    slope = np.maximum(slope, _LEAST_SLOPE)
    # Readers correct for the slope of each time, in few steps: those of leaves, which store no heat, converge at night
    # with the geometric mean, eight times below the day's slopes (reed 0.1 K in place of 0.6).
    mean = (np.exp(np.log(slope).mean(axis=1)) if material.surface.canopy else slope.mean(axis=1))[:, None]
    arrives = 1.0 + real_at_end(penetrating_light_harmonics(conduction)) if material.thermal.light else 1.0
    by_harmonic = arrives / (real_at_end(conduction.admittance) + mean)
    return np.fft.irfft(by_harmonic, FINE_STEPS), mean + np.zeros((1, at_hours.size))


def lag_cells(steps: int) -> Integers:
    """Index of the first step of lag of each cell; a step is centred on its lag."""
    cells: Integers = np.round((LAG_STARTS - LAG_STARTS[0]) * (steps / 24.0)).astype(int)
    return cells


@dataclass(frozen=True, eq=False)
class ResponseTable:
    """Responses of M materials at altitudes and slopes of their own; arrays are float32.

    Attributes
    ----------
    altitudes_m, slopes_deg : ndarray, shape (A,), (S,)
    kernel : ndarray, shape (M, A, S, 24, L)
    temperature, loss_slope : ndarray, shape (M, A, S, 24)
    loss_excess : ndarray, shape (M, A, S, 24, O)
    melt : ndarray, shape (M, A, S, 24)
        Heat spent on melting, as in `SurfaceResponse`.
    solar_absorptance, thermal_emissivity : ndarray, shape (M,)
        Share of sunlight that becomes heat, less the power that cells deliver at 25 C, and thermal emissivity.
    highest : ndarray, shape (M,)
        Melting point of surfaces that cannot exceed it [K]; `NO_LIMIT` of others.
    film : FilmTable or None
        Film, as in `SurfaceResponse`.
    """

    altitudes_m: Floats
    slopes_deg: Floats
    kernel: Singles
    temperature: Singles
    loss_slope: Singles
    loss_excess: Singles
    melt: Singles
    solar_absorptance: Singles
    thermal_emissivity: Singles
    highest: Singles
    film: FilmTable | None = None


@dataclass(frozen=True, eq=False)
class FilmTable:
    """Films of water on M materials, with the rain of a day; arrays are float32.

    Attributes
    ----------
    heat_loss, evaporation : ndarray, shape (M, A, S, 24, O)
    sunlight, dry_sunlight : ndarray, shape (M, A, S, 24)
        Absorbed sunlight, as in `FilmResponse`.
    before : ndarray, shape (M, A, S), or None
        Water before the day, as in `FilmResponse`; None: the day repeats, and its film with it.
    capacity : ndarray, shape (M,)
        Water that stays on a surface [kg m^-2]; 0 where none does.
    rain : ndarray, shape (FINE_STEPS,)
        Rain on level ground [kg m^-2 s^-1].
    """

    heat_loss: Singles
    evaporation: Singles
    sunlight: Singles
    dry_sunlight: Singles
    before: Singles | None
    capacity: Singles
    rain: Singles


def _close_enough(altitudes: Floats) -> Floats:
    """Altitudes with others evenly between those more than `ALTITUDE_STEP` apart."""
    gaps = [
        np.linspace(low, high, int(np.ceil((high - low) / ALTITUDE_STEP)), endpoint=False)
        for low, high in itertools.pairwise(altitudes)
    ]
    return np.concatenate([*gaps, altitudes[-1:]])


def response_table(
    materials: Sequence[SurfaceMaterial],
    scene: Scene,
    *,
    steps: int = STEPS,
    prescribed: Collection[str] = (),
) -> ResponseTable:
    """Responses of all materials at the altitudes of a scene and between those far apart, for faces of its slopes.

    Parameters
    ----------
    materials : sequence of M SurfaceMaterial
    steps : int
        Solver times of a day.
    prescribed : collection of str
        Names of materials whose temperature is given, which no heat changes.
    """
    altitudes = _close_enough(np.unique(np.asarray(scene.altitude, float)))
    slopes, azimuths = response_planes(scene.sun, np.asarray(scene.slope, float))
    turns = np.where((slopes > 0) & (slopes < 180), CANOPY_TURNS.size, 1)
    turned_azimuths = np.concatenate([a + CANOPY_TURNS[:n] for a, n in zip(azimuths, turns, strict=True)]) % 360.0
    days, turned_days = (
        Scene(scene.sun, scene.weather, scene.sky, altitudes, *planes).days
        for planes in ((slopes, azimuths), (np.repeat(slopes, turns), turned_azimuths))
    )
    responses = []
    for material in materials:
        if material.name in prescribed:
            responses.append(
                SurfaceResponse.empty(altitudes.size * slopes.size, film=days[-1](FINE_STEPS).rain is not None)
            )
            continue
        if material.canopy is None:
            responses.append(surface_response(material, days, steps=steps))
        else:
            responses.append(surface_response(material, turned_days, steps=steps).mean_of_planes(turns))
    shape = (len(materials), altitudes.size, slopes.size, RESPONSE_HOURS.size)

    def table(name: str) -> Singles:
        parts = np.stack([getattr(response, name) for response in responses]).astype(np.float32)
        return parts.reshape(*shape, *parts.shape[3:])

    return ResponseTable(
        altitudes,
        slopes,
        _rounded_kernel(table("kernel")),
        table("temperature"),
        table("loss_slope"),
        _rounded_loss(table("loss_excess"), table("loss_slope")),
        table("melt"),
        np.array([material.solar_absorptance - material.surface.delivered for material in materials], np.float32),
        np.array([material.thermal_emissivity for material in materials], np.float32),
        np.array([melting_cap(material) or NO_LIMIT for material in materials], np.float32),
        _film_table(materials, [response.film for response in responses], days, shape, prescribed),
    )


def _rounded_kernel(kernel: Singles) -> Singles:
    """Responses (..., L) to a share of the largest over all lags."""
    largest = np.abs(kernel).max(axis=-1, keepdims=True)
    return rounded_to(kernel, largest * 2.0**-_DIGITS).astype(np.float32)


def _rounded_loss(excess: Singles, slope: Singles) -> Singles:
    """Heat losses (..., O) to what changes the temperature by `_LOSS_STEP`, far from the air's by a share of the
    offset, for mean slopes (...) of the loss.
    """
    offsets = np.abs(OFFSETS)
    kelvin = _LOSS_STEP * np.maximum(1.0, offsets / _NEAR)
    secant = np.abs(slope)[..., None] + np.abs(excess) / np.where(offsets > 0, offsets, np.inf)
    return rounded_to(excess, kelvin * secant).astype(np.float32)


def _film_table(
    materials: Sequence[SurfaceMaterial],
    films: Sequence[FilmResponse | None],
    days: Sequence[Callable[[int], Forcing]],
    shape: tuple[int, ...],
    prescribed: Collection[str],
) -> FilmTable | None:
    """Film tables of all materials; None where it does not rain, or no material keeps a film."""
    rain = days[-1](FINE_STEPS).rain
    wet = [None if material.name in prescribed else material.film for material in materials]
    if rain is None or not any(wet):
        return None

    def table(name: str) -> Singles:
        return np.stack([getattr(film, name) for film in films]).astype(np.float32)

    return FilmTable(
        rounded_bits(table("heat_loss"), _DIGITS).reshape(*shape, OFFSETS.size),
        rounded_bits(table("evaporation"), _DIGITS).reshape(*shape, OFFSETS.size),
        table("sunlight").reshape(shape),
        table("dry_sunlight").reshape(shape),
        table("before").reshape(shape[:3]) if len(days) > 1 else None,
        np.array([0.0 if film is None else film.capacity for film in wet], np.float32),
        np.atleast_2d(rain)[0].astype(np.float32),
    )
