"""The error of temperatures under shade that a ``.htt`` database states: its response against whole solutions."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.kernel.pixels import EXACT, LINEAR, PERIODIC, SURFACE, Database, Tables, array_names
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.days import joined_days, solve_days
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.response import ResponseTable
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS, RESPONSE_HOURS
from skyshine.mat.surface.solver import FINE_STEPS
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.tables import film_response as wet
from skyshine.mat.tables import response
from skyshine.mat.tables.shade import FORCING_TIME
from skyshine.mat.tables.stated_error import ErrorMeasure, measure
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.hdf5 import Variable

QUANTITY = "shaded_temperature"
SHADE_METHOD = (
    "response against whole solutions in fine steps, at random altitudes, slopes and azimuths: a shadow of some hours,"
    " and shade all day beside a wall; surfaces that melt count in the errors by material only"
)
_PLACES = 2  # altitudes and planes, all combined, under each of the surroundings


@dataclass(frozen=True, eq=False)
class ShadeError:
    """Errors over all measured materials, and by material.

    Attributes
    ----------
    variables : dict of str to Variable
        Variables for the group ``accuracy``.
    """

    measured: ErrorMeasure
    variables: dict[str, Variable]


def stored_response(table: ResponseTable) -> Tables:
    """The response as a reader of the file has it; the code of a material is its number, from 1."""
    database, film = Database(SURFACE), table.film
    arrays = {
        response.KERNEL: table.kernel,
        response.REFERENCE: table.temperature,
        response.LOSS_SLOPE: table.loss_slope,
        response.LOSS_EXCESS: table.loss_excess,
        response.MELT: table.melt,
        response.HIGHEST: table.highest,
    }
    if film is not None:
        arrays |= {
            wet.LOSS: film.heat_loss,
            wet.EVAPORATION: film.evaporation,
            wet.SUNLIGHT: film.sunlight,
            wet.DRY_SUNLIGHT: film.dry_sunlight,
            wet.CAPACITY: film.capacity,
            wet.RAIN: film.rain,
        } | ({} if film.before is None else {wet.BEFORE: film.before})
    axes = {
        "material": (1.0 + np.arange(len(table.kernel)), EXACT, 0.0),
        response.ALTITUDE: (table.altitudes_m / 1e3, LINEAR, 0.0),
        response.SLOPE: (table.slopes_deg, LINEAR, 0.0),
        response.HOUR: (RESPONSE_HOURS, PERIODIC, response.DAY_H),
        response.LAG: (LAG_STARTS, LINEAR, 0.0),
        response.OFFSET: (OFFSETS, LINEAR, 0.0),
        FORCING_TIME: (response.forcing_hours(), PERIODIC, response.DAY_H),
    }
    for number, (name, names) in enumerate(array_names(SURFACE)):
        if name in arrays:
            database.set_array(number, np.asarray(arrays[name]))
            for index, axis in enumerate(names):
                nodes, rule, period = axes[axis]
                database.set_axis(number, index, np.asarray(nodes, float), rule, period, np.nan, False)
    return Tables(database, None, None)


def shade_error(
    materials: Sequence[SurfaceMaterial],
    scene: Scene,
    table: ResponseTable,
    fixed: Collection[str],
    generator: np.random.Generator,
    rows: Integers,
    *,
    at_slopes: bool = False,
) -> ShadeError:
    """Measure the response of materials.

    Parameters
    ----------
    materials : sequence of M SurfaceMaterial
    scene : Scene
        Its altitudes and slopes limit those at which the error is measured.
    fixed : collection of str
        Names of materials whose temperature is given; they have no error.
    rows : (R,) int array
        Numbers of the materials that are measured.
    at_slopes : bool
        Whether slopes of the scene are tested, instead of slopes between them.
    """
    altitudes, slopes = (
        generator.uniform(limits.min(), limits.max(), _PLACES)
        for limits in (np.asarray(scene.altitude), np.asarray(scene.slope))
    )
    altitudes = np.unique(altitudes)  # one where the scene has one
    if at_slopes:
        slopes = generator.choice(np.asarray(scene.slope, float), _PLACES)
    azimuths = generator.uniform(0, 360, _PLACES)
    sunlit = Scene(scene.sun, scene.weather, scene.sky, altitudes, slopes, azimuths)
    morning = generator.uniform(5, 16)
    wall = float(scene.weather.air_temperature.mean()) + generator.uniform(-10, 20)
    shades = [
        replace(sunlit, surroundings=Surroundings(((morning, (morning + generator.uniform(0.5, 6)) % 24.0),))),
        replace(sunlit, surroundings=Surroundings(((0.0, 24.0),), generator.uniform(0.3, 0.9), wall)),
    ]
    forcings = [scene.forcing(FINE_STEPS) for scene in (sunlit, *shades)]
    days = joined_days([sunlit, *shades])
    stored = stored_response(table)
    kilometres = np.repeat(sunlit.altitude, _PLACES) / 1e3
    errors, frozen, by_material = [], [], []
    for number in rows:
        material = materials[number]
        if material.name in fixed:
            by_material.append((0.0, 0.0))
            continue
        highest = np.full(kilometres.size, table.highest[number], float)
        code = np.full(kilometres.size, number + 1)
        faces = [code, kilometres, np.zeros(kilometres.size), np.tile(slopes, sunlit.altitude.size)]
        temperature, melts = _solved(material, days)
        start, *exact_days = temperature.reshape(len(forcings), -1, FINE_STEPS)
        melting, *melting_there = melts.reshape(len(forcings), -1)
        absorbed, *absorbed_there = (Balance(forcing, material).absorbed for forcing in forcings)
        part = []
        for shaded, exact, melted in zip(absorbed_there, exact_days, melting_there, strict=True):
            change = stored.changes(faces, shaded - absorbed, start, highest)
            part.append(np.minimum(start + change, table.highest[number]) - exact)
            frozen.append(~(melting | melted))
        errors += part
        by_material.append((float(np.sqrt(np.mean(np.square(part)))), float(np.abs(part).max())))
    solid = np.concatenate([error[rows].ravel() for error, rows in zip(errors, frozen, strict=True)] or [np.empty(0)])
    rms, largest = np.array(by_material, np.float32).T
    words = "of temperatures in the shade, against whole solutions"
    return ShadeError(
        measure(QUANTITY, solid, solid),
        {
            "shade_rms": Variable(("material",), rms, "K", f"root mean square error {words}"),
            "shade_maximum": Variable(("material",), largest, "K", f"largest error {words}"),
        },
    )


def _solved(material: SurfaceMaterial, days: Sequence[Callable[[int], Forcing]]) -> tuple[Floats, Booleans]:
    """Temperatures (columns, FINE_STEPS) [K], and which columns melt at some time."""
    temperature = np.empty(days[-1](FINE_STEPS).shape)
    melts = np.zeros(len(temperature), bool)
    for columns, solution in solve_days(material, days, steps=FINE_STEPS):
        temperature[columns] = solution.temperature
        melts[columns] = np.any(solution.melt > 0, axis=1)
    return temperature, melts
