"""The ``.htt`` database of one state."""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import clock_text, tolerance_parts
from skyshine.mat.job.model import Job
from skyshine.mat.job.surface import at_kelvin
from skyshine.mat.job.trim import hours_around
from skyshine.mat.measure.probes import NIGHT_DEG
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.sampling import random_coordinates
from skyshine.mat.measure.surface_nodes import PERIODS, RefinedAxes, placed_times, refined_axes, within_period
from skyshine.mat.plan.plan import PLACED_ON, measured_on
from skyshine.mat.products.product import Context, TableIdentity, TaskReport
from skyshine.mat.products.shade_error import SHADE_METHOD, shade_error
from skyshine.mat.products.turbulence import HOURS, turbulence_fields
from skyshine.mat.scene.atmosphere import materials_digest, without_air_time
from skyshine.mat.scene.sources import source_tracks
from skyshine.mat.scene.summary import state_attributes
from skyshine.mat.scene.surface import given_temperatures, scene_inputs, surface_materials, surroundings_identity
from skyshine.mat.surface.enclosure import Enclosure
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.response import response_table
from skyshine.mat.surface.solver import FINE_STEPS
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath, sun_hours
from skyshine.mat.surface.table import SurfaceTemperatures, rounded, temperature_table
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.mat.tables.axes import EXACT, LINEAR, PERIODIC, AxisRule
from skyshine.mat.tables.files import HTT
from skyshine.mat.tables.htt import enclosure_attributes, htt_group, material_axis, midnight_of, shade_fields
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.stated_error import ErrorMeasure, accuracy_group, measure
from skyshine.mat.tables.tracks import track_fields, track_hours
from skyshine.materials.records import Material
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.hdf5 import Axis, Group, Variable

# Random values of each axis at which the interpolation error is measured; all their combinations are. Of azimuths and
# slopes fewer, to `_FEWEST_FACES`, where many materials are measured at each: some `_COLUMNS` columns are enough.
PROBES = {"altitude_km": 3, "azimuth_deg": 5, "slope_deg": 5, "time_h": 24}
_FEWEST_FACES, _COLUMNS = 3, 600
FACE_AXES = ("azimuth_deg", "slope_deg")
LEVEL_DEG, STEEP_DEG = 10.0, 60.0  # slopes of which errors are stated apart
_SOLVER_METHOD = (
    "{} against {} steps a day at the random places of one altitude, difference times {:.3g} (second order)"
)

Axes = dict[str, npt.NDArray[np.float64]]


class TemperatureProduct:
    """Surface temperatures of a state through the day."""

    def identity(self, context: Context) -> tuple[TableIdentity, ...]:
        """The one file of a state."""
        job, library, materials = context.loaded.trimmed, context.library, context.materials
        limits = job.query_limits
        hours = None if limits is None else limits.hours
        state = job.states[context.task.index - 1]
        weather = state.weather
        resolved = {
            "site": job.site.model_dump(mode="json"),
            "state": state.model_dump(mode="json", exclude={"date", "series"}),
            "surface_grid": {**job.surface_grid.model_dump(mode="json"), "altitude_km": job.surface_altitudes_km},
            "accuracy": job.accuracy.model_dump(mode="json", include={"solver_steps", "seed"}),
            **({"measured_on": few} if (few := measured_on(state, len(materials))) < len(materials) else {}),
            "materials": list(materials),
            "operated": {
                name: job.operated[name].model_dump(mode="json") for name in materials if name in job.operated
            },
            **({} if limits is None or limits.shade else {"shade": False}),
            **({} if limits is None or limits.faces_deg is None else {"faces_only": True}),
            **({} if hours is None else {"hours": [clock_text(time) for time in hours]}),
            "temperatures_c": {name: job.temperatures_c[name] for name in materials if name in job.temperatures_c},
            "materials_sha256": materials_digest(library, materials),
            **surroundings_identity(job, context.task.index),
            **({"ground": ground.model_dump(mode="json")} if (ground := weather.ground_year) else {}),
            **({"water": water} if (water := weather.water) else {}),
        }
        return (TableIdentity(context.task.files[0], HTT, f"materials {library.version}", resolved),)

    def compute(self, context: Context, report: TaskReport) -> Iterator[Group]:
        """The temperatures of all materials, on nodes that the job names or that meet its tolerance."""
        job, state = context.loaded.trimmed, context.task.index
        materials = [context.library[name] for name in context.materials]
        solver = state_solver(job, materials, state)
        codes, steps, seed = [material.code for material in materials], job.accuracy.solver_steps, job.accuracy.seed
        start = StartAxes.of(job)
        requested, whole_day, fixed = start.requested, start.whole_day, start.fixed
        axes, tolerance_note = dict(start.axes), {}
        limits = job.query_limits

        tolerance = job.surface_grid.tolerance
        if tolerance is not None:
            with report.stage("grid"):
                refined = tolerance_axes(
                    job, solver, start, job.surface_grid.most_nodes, insist=context.loaded.insists("surface_grid")
                )
            axes, tolerance_note = dict(refined.axes), {"tolerance": tolerance}
            report.notes.append(
                f"{' x '.join(str(nodes.size) for nodes in axes.values())} nodes for {tolerance}:"
                f" {refined.p99:.2g} K in 99 %, {refined.largest:.2g} K in nearly all reads"
            )
        if job.surface_grid.time is None and tolerance is None:
            with report.stage("grid"):
                some = solver.some(_placed_on(solver, seed))
                axes["time_h"] = placed_times(
                    lambda at: some.table(at, steps).temperature.astype(float),
                    axes,
                    whole_day=whole_day,
                    seed=seed,
                    fixed=fixed,
                )
        with report.stage("tables"):
            kelvin = None if tolerance is None else tolerance_parts(tolerance)[0]
            table = rounded(solver.table(axes, steps), kelvin)
        shaded = limits is None or limits.shade
        response = None
        if shaded:
            with report.stage("response"):
                response = response_table(solver.materials, solver.scene(axes), steps=steps, prescribed=solver.fixed)
        day = job.on_date_of_state(state).site
        measured = _measured(job.states[state - 1], day.date, seed, len(materials))
        with report.stage("accuracy"):
            drawn = random_stream(seed, Stream.TEMPERATURE_ERROR)
            probes = _places(requested, whole_day, drawn, measured.size, fixed)
            rules = _rules(np.array(codes)[measured], axes, whole_day)
            of_measured = replace(table, temperature=table.temperature[measured])
            error, solver_error = _errors(solver.some(measured), of_measured, rules, probes, steps)
        notes = {
            "seed": seed,
            "method": (
                "linear interpolation against direct computation at random altitudes, azimuths, slopes and times, which"
                " placed no node;"
                f" twilight: Sun 0 to {-NIGHT_DEG:g} degree down; level: slopes to {LEVEL_DEG:g} degree, steep:"
                f" {STEEP_DEG:g} to 90, overhanging: beyond"
                + ("; slopes and azimuths of the faces alone" if fixed else "")
                + (f"; {measured.size} of {len(codes)} materials, drawn by date" if measured.size < len(codes) else "")
            ),
            "solver_error_kelvin": solver_error.maximum,
            "solver_error_rms_kelvin": solver_error.rms,
            "solver_error_method": _SOLVER_METHOD.format(steps, *_compared(steps)),
            **tolerance_note,
        }
        errors, by_material, by_material_axes = [error], {}, {}
        if response is not None:
            with report.stage("accuracy"):
                generator = random_stream(seed, Stream.SHADE_ERROR)
                shade = shade_error(
                    solver.materials,
                    solver.scene(axes),
                    response,
                    solver.fixed,
                    generator,
                    measured,
                    at_slopes=bool(fixed),
                )
            errors.append(shade.measured)
            if measured.size == len(codes):
                by_material, by_material_axes = shade.variables, {"material": material_axis(codes)}
            notes["shade_method"] = SHADE_METHOD
        attributes: dict[str, Any] = {
            **state_attributes(without_air_time(job.states[state - 1])),
            "date": day.date.isoformat(),
            **_surroundings(job.states[state - 1], solver.inputs[2].enclosure),
            **({"ground": ground.text} if (ground := job.states[state - 1].weather.ground_year) else {}),
        }
        accuracy = accuracy_group(errors, by_material, by_material_axes, notes)
        report.notes.append(
            f"largest residual {np.max(table.residual):.1e} W/m2, bound excess {np.max(table.bound_excess):.1e} K"
        )
        fields = None if response is None else shade_fields(response, solver.scene(axes))
        tracks = track_fields(source_tracks(day, track_hours()))
        turbulence = _turbulence(solver, job.states[state - 1], axes, steps)
        yield htt_group(
            table,
            codes,
            context.materials,
            axes,
            accuracy,
            attributes,
            midnight=midnight_of(day.date, day.utc_offset_h),
            whole_day=whole_day,
            shade=fields,
            tracks=tracks,
            turbulence=turbulence,
        )


def _turbulence(solver: Solver, state: State, axes: Axes, steps: int) -> tuple[dict[str, Axis], dict[str, Variable]]:
    """Cn2 over the ground that the state names, if its temperatures are computed here, or over its sea."""
    ground = next((material for material in solver.materials if material.name == state.ground_material), None)
    scene = solver.scene(axes)
    if ground is None or state.sea_temperature_c is not None:
        return turbulence_fields(scene, state, None, 0.0)
    level = axes | {"azimuth_deg": np.zeros(1), "slope_deg": np.zeros(1), "time_h": HOURS}
    kelvin = replace(solver, materials=[ground]).table(level, steps).temperature[0, :, 0, 0].astype(float)
    return turbulence_fields(scene, state, kelvin, ground.surface.roughness_length)


def _surroundings(state: State, enclosure: Enclosure | None) -> dict[str, Any]:
    """Root attributes of the surroundings of the surfaces; none on an open plain without a material."""
    if enclosure is None:
        return {}
    attributes = enclosure_attributes(enclosure)
    if state.ground_material is not None:
        attributes["ground_material"] = state.ground_material
    wall = None if state.surroundings is None else state.surroundings.wall
    if wall is not None and wall.material is not None:
        attributes["wall_material"] = wall.material
    elif wall is not None and wall.temperature_c is not None:
        attributes["wall_temperature"] = np.array(at_kelvin(wall.temperature_c))
    return attributes


@dataclass(frozen=True, eq=False)
class StartAxes:
    """The axes of a temperature table before nodes are placed on them.

    Attributes
    ----------
    requested : dict of str to (n,) array
        Axes as the job states them; errors are measured between their ends.
    axes : dict of str to (n,) array
        Axes of the file, with the times around the requested hours; the solver computes the whole day.
    whole_day : bool
        Whether the last time is followed by the first.
    fixed : tuple of str
        Axes that are read at their nodes alone.
    """

    requested: Axes
    axes: Axes
    whole_day: bool
    fixed: tuple[str, ...]

    @classmethod
    def of(cls, job: Job) -> StartAxes:
        """Those of a job."""
        named = {
            "altitude_km": job.surface_altitudes_km,
            "azimuth_deg": job.surface_grid.azimuth_deg,
            "slope_deg": job.surface_grid.slope_deg,
            "time_h": job.surface_grid.times,
        }
        requested = {name: np.asarray(nodes, float) for name, nodes in named.items()}
        limits = job.query_limits
        hours = None if limits is None else limits.hours
        times = hours_around(list(requested["time_h"]), hours)
        whole_day = len(times) == requested["time_h"].size
        axes = requested | {"time_h": np.array(times)}
        if hours is not None and not whole_day:
            requested["time_h"] = np.unique([hours[0], hours[1] + (24.0 if hours[1] < hours[0] else 0.0)])
        return cls(requested, axes, whole_day, () if limits is None or limits.faces_deg is None else FACE_AXES)


def state_solver(job: Job, materials: Sequence[Material], state: int) -> Solver:
    """The heat balance of some materials in a state, counted from 1, on whose date the job's site is."""
    inputs = scene_inputs(job, state)
    fixed = given_temperatures(job, job.states[state - 1])
    return Solver(surface_materials(materials, job.operated, inputs[1].wetting), inputs, fixed)


def tolerance_axes(job: Job, solver: Solver, start: StartAxes, most_nodes: int, *, insist: bool) -> RefinedAxes:
    """Axes that meet the tolerance of the job's surface_grid; arguments and errors as `refined_axes`."""
    some = solver.some(_placed_on(solver, job.accuracy.seed))

    def temperature(at: Axes) -> Floats:
        return some.table(at, job.accuracy.solver_steps).temperature.astype(float)

    return refined_axes(
        temperature,
        start.axes,
        len(solver.materials),
        tolerance_parts(str(job.surface_grid.tolerance))[0],
        seed=job.accuracy.seed,
        max_nodes=most_nodes,
        whole_day=start.whole_day,
        fixed=start.fixed,
        insist=insist,
    )


def _measured(state: State, date: dt.date, seed: int, materials: int) -> Integers:
    """Numbers of the materials on which the errors of a state are measured: of many states others on each date."""
    count = measured_on(state, materials)
    if count == materials:
        return np.arange(materials)
    of_date = random_stream(seed, Stream.TEMPERATURE_ERROR, date.toordinal())
    return np.sort(of_date.choice(materials, count, replace=False))


def _placed_on(solver: Solver, seed: int) -> Integers:
    """Numbers of the materials on which nodes are placed."""
    count = len(solver.materials)
    drawn = random_stream(seed, Stream.TEMPERATURE_NODES, 1).choice(count, min(count, PLACED_ON), replace=False)
    return np.sort(drawn)


@dataclass(frozen=True)
class Solver:
    """The heat balance of the job's materials in one state."""

    materials: Sequence[SurfaceMaterial]
    inputs: tuple[SunPath, NearSurfaceAir, Sky]
    fixed: Mapping[str, float | tuple[float, ...]]

    def some(self, rows: Integers) -> Solver:
        """The balance of some of the materials."""
        return replace(self, materials=[self.materials[row] for row in rows])

    def scene(self, axes: Axes) -> Scene:
        """All slopes of the axes, at their altitudes."""
        sun, weather, sky = self.inputs
        slopes = axes["slope_deg"]
        return Scene(sun, weather, sky, 1e3 * axes["altitude_km"], slopes, np.zeros_like(slopes))

    def table(self, axes: Axes, steps: int) -> SurfaceTemperatures:
        sun, weather, sky = self.inputs
        return temperature_table(
            self.materials,
            sun,
            weather,
            sky,
            [1e3 * altitude for altitude in axes["altitude_km"]],
            list(axes["azimuth_deg"]),
            list(axes["slope_deg"]),
            list(np.mod(axes["time_h"], 24.0)),
            steps=steps,
            prescribed=self.fixed,
        )


def _rules(codes: npt.ArrayLike, axes: Axes, whole_day: bool) -> list[AxisRule]:
    """How a reader interpolates in the table."""
    return [
        AxisRule("material", np.array(codes), EXACT),
        AxisRule("altitude", axes["altitude_km"]),
        AxisRule("azimuth", axes["azimuth_deg"], PERIODIC, 360.0),
        AxisRule("slope", axes["slope_deg"]),
        AxisRule("time", axes["time_h"], PERIODIC if whole_day else LINEAR, 24.0),
    ]


def _places(
    requested: Axes, whole_day: bool, generator: np.random.Generator, materials: int, fixed: Collection[str] = ()
) -> Axes:
    """Random places on each of the job's own axes, for so many materials; those of a whole day and of azimuth also
    between last and first; of fixed axes, which are read at their nodes, some of these.
    """
    probes, faces = {}, int(np.clip(math.sqrt(_COLUMNS / materials), _FEWEST_FACES, PROBES["slope_deg"]))
    for name, nodes in requested.items():
        most = min(PROBES[name], faces) if name in FACE_AXES else PROBES[name]
        if name in fixed:
            probes[name] = np.sort(generator.choice(nodes, min(most, nodes.size), replace=False))
            continue
        period = PERIODS.get(name)
        if period is not None and nodes.size > 1 and (whole_day or name != "time_h"):
            nodes = np.append(nodes, nodes[0] + period)
        drawn = random_coordinates(nodes, most if nodes.size > 1 else 1, generator)
        probes[name] = within_period(name, drawn)
    return probes


def _compared(steps: int) -> tuple[int, float]:
    """Other steps of the day, and the error of a solution over its difference from theirs, by Richardson."""
    comparison = FINE_STEPS if steps < FINE_STEPS else SUN_STEPS
    return comparison, 1 / (1 - (steps / comparison) ** 2)


def _errors(
    solver: Solver, table: SurfaceTemperatures, rules: Sequence[AxisRule], probes: Axes, steps: int
) -> tuple[ErrorMeasure, ErrorMeasure]:
    """Errors of interpolation and of the solver's step, at all combinations of the places."""
    exact = solver.table(probes, steps).temperature.astype(float)
    other_steps, factor = _compared(steps)
    few = (
        probes | {name: probes[name][:_FEWEST_FACES] for name in FACE_AXES} | {"altitude_km": probes["altitude_km"][:1]}
    )
    comparison = solver.table(few, other_steps).temperature.astype(float)
    mesh = np.meshgrid(rules[0].nodes, *probes.values(), indexing="ij", sparse=True)
    read = interpolate(
        table.temperature.astype(float), rules, dict(zip((rule.name for rule in rules), mesh, strict=True))
    )
    error = read - exact
    difference = factor * (exact[:, :1, :_FEWEST_FACES, :_FEWEST_FACES] - comparison)
    regions = {name: np.broadcast_to(inside, error.shape) for name, inside in _regions(solver.inputs[0], mesh).items()}
    return measure("temperature", error, error, regions=regions), measure("solver", difference, difference)


def _regions(sun: SunPath, points: Sequence[Floats]) -> dict[str, Booleans]:
    """Which places, open mesh of (material, altitude, azimuth, slope, time), lie in each part of the day and of the
    slopes.
    """
    *_, slope, time = points
    elevation = np.interp(np.mod(time, 24.0), sun_hours(), sun.solar_elevation, period=24.0)
    return {
        "day": elevation > 0,
        "twilight": (elevation <= 0) & (elevation > NIGHT_DEG),
        "night": elevation <= NIGHT_DEG,
        "level": slope <= LEVEL_DEG,
        "steep": (slope >= STEEP_DEG) & (slope <= 90),
        "overhanging": slope > 90,
    }
