"""The ``.htt`` database of one state."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skyshine.mat.job.fields import clock_text, tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.surface import at_kelvin
from skyshine.mat.job.trim import hours_around
from skyshine.mat.measure.sampling import random_places
from skyshine.mat.measure.surface_nodes import refined_axes
from skyshine.mat.plan.plan import Task
from skyshine.mat.products.product import Product, TaskReport
from skyshine.mat.scene.atmosphere import materials_digest
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.table import TemperatureTable, temperature_table
from skyshine.mat.tables.axes import EXACT, LINEAR, PERIODIC, AxisRule
from skyshine.mat.tables.files import HTT
from skyshine.mat.tables.htt import htt_group
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.stated_error import ErrorMeasure, accuracy_group, measure
from skyshine.materials.library import load_library

# Random values of each axis at which the interpolation error is measured; all their combinations are.
PROBES = {"altitude": 3, "azimuth": 5, "slope": 5, "time": 24}
FINE_STEPS = 288  # of the finer solution that the solver's error is measured against


def run(
    task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool, report: TaskReport
) -> None:
    """Build the temperature table of a state; arguments as `products.run_task`."""
    library, job = load_library(), loaded.job
    axes = {
        "altitude_km": job.surface_altitudes_km,
        "azimuth_deg": job.surface_grid.azimuth_deg,
        "slope_deg": job.surface_grid.slope_deg,
        "time_h": job.surface_grid.time,
    }
    hours = None if job.needs is None else job.needs.hours
    resolved = {
        "site": job.site.model_dump(mode="json"),
        "state": job.states[task.index - 1].model_dump(mode="json", exclude={"date", "series"}),
        "surface_grid": {**job.surface_grid.model_dump(mode="json"), "altitude_km": job.surface_altitudes_km},
        "accuracy": job.accuracy.model_dump(mode="json", include={"solver_steps", "seed"}),
        "materials": list(materials),
        "operated": {name: job.operated[name].model_dump(mode="json") for name in materials if name in job.operated},
        **({} if hours is None else {"hours": [clock_text(time) for time in hours]}),
        "temperatures_c": {name: job.temperatures_c[name] for name in materials if name in job.temperatures_c},
        "materials_sha256": materials_digest(library, materials),
    }
    product = Product(folder / task.files[0], HTT, f"materials {library.version}", resolved)
    if not fresh and product.is_there():
        report.kept = True
        return
    chosen = [library[name] for name in materials]
    codes = np.array([material.code for material in chosen])
    given = {name: at_kelvin(celsius) for name, celsius in job.temperatures_c.items()}
    solver = _Solver(surface_materials(chosen, job.operated), scene_inputs(job, task.index), given)
    steps = job.accuracy.solver_steps
    base, placed = dict(axes), {}
    if job.surface_grid.tolerance is not None:
        with report.stage("grid"):
            refined = refined_axes(
                lambda at: solver.table(at, steps).temperature,
                axes,
                len(chosen),
                tolerance_parts(job.surface_grid.tolerance)[0],
                seed=job.accuracy.seed,
                max_nodes=job.surface_grid.most_nodes,
            )
        axes, placed = dict(refined.axes), {"tolerance": job.surface_grid.tolerance}
        report.notes.append(
            f"{' x '.join(str(nodes.size) for nodes in axes.values())} nodes hold {job.surface_grid.tolerance}"
        )
    # The whole day is solved, and its nodes are placed for all of it; the file holds the hours that are asked for.
    kept = hours_around(list(axes["time_h"]), hours)
    whole_day = len(kept) == len(axes["time_h"])
    axes["time_h"] = np.array(kept)
    if not whole_day:
        base["time_h"] = np.unique([hours[0], hours[1] + (24.0 if hours[1] < hours[0] else 0.0)])
    with report.stage("tables"):
        table = solver.table(axes, steps)
    with report.stage("accuracy"):
        error, solver_error = _errors(solver, table, codes, axes, base, steps, job.accuracy.seed, whole_day)
    with report.stage("write"):
        notes = {
            "seed": job.accuracy.seed,
            "method": "linear interpolation against direct computation at random altitudes, azimuths, slopes and times",
            "solver_error_kelvin": solver_error.maximum,
            "solver_error_rms_kelvin": solver_error.rms,
            "solver_error_method": f"{steps} against {FINE_STEPS} steps a day at the same random places",
            **placed,
        }
        attributes = {"state": job.states[task.index - 1].profile, "date": job.site.date.isoformat()}
        accuracy = accuracy_group([error], {}, {}, notes)
        product.write(htt_group(table, codes, materials, axes, accuracy, attributes, whole_day=whole_day))
    report.notes.append(
        f"largest residual {np.max(table.residual):.1e} W/m2, bound excess {np.max(table.bound_excess):.1e} K"
    )


class _Solver:
    """The heat balance of the job's materials in one state."""

    def __init__(self, materials, inputs, given):
        self.materials, self.inputs, self.given = materials, inputs, given

    def table(self, axes: dict, steps: int) -> TemperatureTable:
        metres = [1e3 * altitude for altitude in axes["altitude_km"]]
        return temperature_table(
            self.materials,
            *self.inputs,
            metres,
            axes["azimuth_deg"],
            axes["slope_deg"],
            np.mod(axes["time_h"], 24.0),
            steps=steps,
            given=self.given,
        )


def _errors(
    solver: _Solver,
    table: TemperatureTable,
    codes: np.ndarray,
    axes: dict,
    base: dict,
    steps: int,
    seed: int,
    whole_day: bool,
) -> tuple[ErrorMeasure, ErrorMeasure]:
    """Errors of interpolation and of the solver's step, at random places of the job's own axes."""
    generator = np.random.default_rng(seed)
    closed = {"azimuth_deg": 360.0, "time_h": 24.0}
    places = {}
    for name, nodes in base.items():
        nodes = np.asarray(nodes, float)
        if name in closed and nodes.size > 1 and (whole_day or name != "time_h"):
            nodes = np.append(nodes, nodes[0] + closed[name])
        count = PROBES[name.split("_")[0]] if nodes.size > 1 else 1
        places[name] = np.mod(random_places(nodes, count, generator), closed.get(name, np.inf))
    exact, fine = (solver.table(places, n).temperature.astype(float) for n in (steps, FINE_STEPS))
    rules = [
        AxisRule("material", codes, EXACT),
        AxisRule("altitude", np.asarray(axes["altitude_km"], float)),
        AxisRule("azimuth", np.asarray(axes["azimuth_deg"], float), PERIODIC, 360.0),
        AxisRule("slope", np.asarray(axes["slope_deg"], float)),
        AxisRule("time", np.asarray(axes["time_h"], float), PERIODIC if whole_day else LINEAR, 24.0),
    ]
    mesh = np.meshgrid(codes, *places.values(), indexing="ij", sparse=True)
    read = interpolate(
        table.temperature.astype(float), rules, dict(zip((rule.name for rule in rules), mesh, strict=True))
    )
    return measure("temperature", read - exact, read - exact), measure("solver", exact - fine, exact - fine)
