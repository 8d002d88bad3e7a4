"""Savings and errors of a job's omissions: built with and without them, both read at random places."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.builder.build import build
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import VALID
from skyshine.mat.tables.gridded import AXES, FIELDS, QUANTITIES
from skyshine.mat.tables.loader import open_as, open_table
from skyshine.mat.tables.table import Table
from skyshine.schemas.arrays import Floats
from skyshine.schemas.process_memory import children_seconds

# Bounds that the plan states: relative, and in K where columns are solved in other batches to the solver's residual.
VALUE_BOUND, KELVIN_BOUND = 1e-3, 0.01
_READS = 5000  # random points at which both tables are read
_TEMPERATURES = ".htt.h5"
_NEAREST_KM = 1e-3  # range from which lines of sight are drawn
# Two files that each keep a tolerance in 99 % of the reads differ by at most two tolerances in this share of them.
_SHARE = 0.98


@dataclass(frozen=True)
class BuildCost:
    """Of a build: processor seconds, which other work on the machine hardly changes, and bytes of its files."""

    seconds: float
    size: int


@dataclass(frozen=True)
class Comparison:
    """The job as it is and whole; differences of reads, by file and value, with what is allowed.

    Differences are the largest, those of atmospheres the largest of 98 % of the reads.
    """

    trimmed: BuildCost
    full: BuildCost
    differences: dict[str, tuple[float, float]]


def compare(loaded: LoadedJob, folder: Path, seed: int) -> Comparison:
    """Build both into a folder and read them.

    Parameters
    ----------
    folder : Path
        Empty; for `kept` and `whole`.
    seed : int
        Seed of the points that are read.
    """
    job, everything = (
        variant.model_copy(update={"output": variant.output.model_copy(update={"pictures": False})})
        for variant in (loaded.trimmed, loaded.requested)
    )
    update = {"query_limits": None, "accuracy": everything.accuracy.model_copy(update={"negligible_k": 0.0})}
    everything = everything.model_copy(update=update | ({"materials": "all"} if everything.materials == "used" else {}))
    costs = {
        name: build_cost(variant, folder / name)
        for name, variant in (
            ("kept", replace(loaded, trimmed=job)),
            ("whole", replace(loaded, trimmed=everything, requested=everything)),
        )
    }
    generator = np.random.default_rng(seed)
    differences: dict[str, tuple[float, float]] = {}
    for ours, theirs in _pairs(folder / "kept", folder / "whole"):
        if ours.name.endswith(_TEMPERATURES):
            differences |= table_differences(open_table(ours), open_table(theirs), generator)
        else:
            differences |= air_differences(_air(ours), _air(theirs), path_grid(job), generator)
    return Comparison(costs["kept"], costs["whole"], differences)


def build_cost(loaded: LoadedJob, folder: Path) -> BuildCost:
    """Build a job anew in one process, without pictures; what its textures take is not counted."""
    before = children_seconds()
    result = build(loaded, out=folder, jobs=1, fresh=True, pictures=False)
    textures = {name: entry for name, entry in result["files"].items() if name.endswith(".tmm.h5")}
    size = sum((folder / file).stat().st_size for file in result["files"] if file not in textures)
    seconds = children_seconds() - before - sum(entry["processor_seconds"] for entry in textures.values())
    return BuildCost(seconds, size)


def read_differences(
    reduced: LoadedJob, kept: Path, whole: Path, generator: np.random.Generator
) -> dict[str, tuple[float, float]]:
    """Differences of what two builds give inside the needs of the first, with their bounds: temperatures, and the
    quantities of the air as `air_differences`.

    Parameters
    ----------
    reduced : LoadedJob
        Job with needs.
    kept, whole : Path
        Folders of the builds with and without them.
    generator : Generator
        Source of the points that are read.
    """
    job = reduced.trimmed
    differences: dict[str, tuple[float, float]] = {}
    for ours, theirs in _pairs(kept, whole):
        if ours.name.endswith(_TEMPERATURES):
            differences |= temperature_difference(open_table(ours), open_table(theirs), job, generator)
        else:
            differences |= air_differences(_air(ours), _air(theirs), path_grid(job), generator)
    return differences


def temperature_difference(
    trimmed: Table, full: Table, job: Job, generator: np.random.Generator
) -> dict[str, tuple[float, float]]:
    """Difference of the temperatures of two tables at random places of the first, with its bound: what both files state
    that 99 % of their reads err, together.
    """
    axes = {
        name: np.asarray(axis.values)
        for name, axis in trimmed.root.axes.items()
        if name in trimmed.root.variables["temperature"].dims
    }
    exact = {"material"} | ({"slope", "azimuth"} if job.query_limits and job.query_limits.faces_deg else set())
    for name in exact - {"material"}:  # faces beyond the axes of the whole table have no peer
        nodes = np.asarray(full.root.axes[name].values, float)
        axes[name] = axes[name][(axes[name] >= nodes[0]) & (axes[name] <= max(nodes[-1], 360.0 * (name == "azimuth")))]
    points: dict[str, Any] = {
        name: generator.choice(nodes, _READS) if name in exact else generator.uniform(nodes[0], nodes[-1], _READS)
        for name, nodes in axes.items()
    }
    error = np.abs(trimmed.value("temperature", **points) - full.value("temperature", **points))
    stated = 0.0
    for table in (trimmed, full):
        accuracy = table.root.groups["accuracy"]
        number = list(accuracy.axes["quantity"].values).index("temperature")
        stated += float(accuracy.variables["p99_kelvin"].data[number])
    return {f"{trimmed.path.name}: temperature, K": (float(np.quantile(error, _SHARE)), stated)}


def _pairs(kept: Path, whole: Path) -> list[tuple[Path, Path]]:
    """Tables of states in both folders."""
    return [(file, whole / file.name) for file in sorted(kept.glob("s*.h5"))]


def _air(file: Path) -> AtmosphereTable:
    return open_as(AtmosphereTable, file, "build it again")


def table_differences(trimmed: Table, full: Table, generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Largest differences of all values of two tables at random places inside the first, with their bounds."""
    axes = {name: np.asarray(axis.values) for name, axis in trimmed.root.axes.items()}
    points: dict[str, Any] = {
        name: generator.choice(nodes, _READS) if name == "material" else generator.uniform(nodes[0], nodes[-1], _READS)
        for name, nodes in axes.items()
    }
    differences = {}
    for name, variable in trimmed.root.variables.items():
        if variable.dtype.kind != "f":
            continue
        where = {axis: points[axis] for axis in variable.dims}
        ours, theirs = (table.value(name, **where) for table in (trimmed, full))
        kelvin = variable.units == "K"
        scale = 1.0 if kelvin else np.maximum(np.abs(theirs), np.median(np.abs(theirs)))
        difference = np.abs(ours - theirs) / np.where(scale > 0, scale, 1.0)
        differences[f"{trimmed.path.name}: {name}"] = float(difference.max()), KELVIN_BOUND if kelvin else VALUE_BOUND
    return differences


def air_differences(
    trimmed: AtmosphereTable, full: AtmosphereTable, grid: PathGrid, generator: np.random.Generator
) -> dict[str, tuple[float, float]]:
    """Differences of the quantities of two atmospheres on random lines of sight, in the unit of their tolerance.

    Each may miss its tolerance, and the first what its omissions may change.

    Parameters
    ----------
    grid : PathGrid
        Axes whose ends the lines and sources lie between.
    """
    ends = dict(zip(AXES, (getattr(grid, field)[[0, -1]] for field in FIELDS), strict=True))
    nearest, farthest = np.maximum(ends["range"], _NEAREST_KM)
    points: dict[str, Any] = {name: generator.uniform(low, high, _READS) for name, (low, high) in ends.items()}
    points["range"] = np.exp(generator.uniform(np.log(nearest), np.log(farthest), _READS))
    in_air = trimmed.value(VALID, **{name: points[name] for name in AXES[:3]}) == 1
    points = {name: values[in_air] for name, values in points.items()}

    def read(table: AtmosphereTable) -> dict[str, Floats]:
        return {
            name: table.value(name, **{axis: points[axis] for axis in AXES[:count]})
            for name, (_, count) in QUANTITIES.items()
        }

    ours, theirs = read(trimmed), read(full)
    notes = trimmed.root.groups["accuracy"].attributes
    tolerance, unit = tolerance_parts(str(notes["tolerance"]))
    # Light of the source outside the atmosphere is at least what reaches a surface.
    source = np.pi * float(np.max(theirs["direct_radiance"], initial=0.0))
    response = SpectralResponse.rectangular(*np.asarray(trimmed.attributes["wavelength_um"], float))
    scale = Scale.of_unit(unit, response, source)
    through = full.transmittance(range=points["range"], beta_star=theirs["beta_star"])
    bound = 2 * tolerance + float(notes.get("left_out_bound", 0.0)) * scale.factor
    differences = {}
    for name, exact in theirs.items():
        error = np.abs(scale.error(name, ours[name], exact, through, points["range"]))
        differences[f"{trimmed.path.name}: {name}, {unit}"] = float(np.quantile(error, _SHARE)), bound
    return differences
