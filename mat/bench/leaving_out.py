"""Savings and errors of a job's omissions: built with and without them, both read at random places."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.builder.build import build
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.loader import open_table
from skyshine.schemas.arrays import Floats
from skyshine.schemas.process_memory import children_seconds

# Bounds that the plan states: relative, and in K where columns are solved in other batches to the solver's residual.
VALUE_BOUND, KELVIN_BOUND = 1e-3, 0.01
_READS = 5000
_SINGLE = 1e-6  # of a value in single precision, after a few products


@dataclass(frozen=True)
class BuildCost:
    """Of a build: processor seconds, which other work on the machine hardly changes, and bytes of its files."""

    seconds: float
    size: int


@dataclass(frozen=True)
class Comparison:
    """The job as it is and whole; largest differences of reads, by file, with what is allowed."""

    kept: BuildCost
    whole: BuildCost
    differences: dict[str, tuple[float, float]]


def compare(loaded: LoadedJob, folder: Path, seed: int) -> Comparison:
    """Build both into a folder and read them.

    Parameters
    ----------
    loaded : LoadedJob
    folder : Path
        Empty; for `kept` and `whole`.
    seed : int
        Of the places that are read.
    """
    job, everything = (
        one.model_copy(update={"output": one.output.model_copy(update={"pictures": False})})
        for one in (loaded.trimmed, loaded.requested)
    )
    update = {"query_limits": None, "accuracy": everything.accuracy.model_copy(update={"negligible_k": 0.0})}
    everything = everything.model_copy(update=update | ({"materials": "all"} if everything.materials == "used" else {}))
    costs = {}
    for name, one in (
        ("kept", replace(loaded, trimmed=job)),
        ("whole", replace(loaded, trimmed=everything, requested=everything)),
    ):
        before = children_seconds()
        result = build(one, out=folder / name, jobs=1, fresh=True)
        size = sum((folder / name / file).stat().st_size for file in result["files"])
        costs[name] = BuildCost(children_seconds() - before, size)
    generator = np.random.default_rng(seed)
    differences: dict[str, tuple[float, float]] = {}
    for file in sorted((folder / "kept").glob("s*.h5")):
        differences |= _differences(file, folder / "whole" / file.name, generator)
    return Comparison(costs["kept"], costs["whole"], differences)


def _differences(kept_file: Path, whole_file: Path, generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    kept, whole = open_table(kept_file), open_table(whole_file)
    axes = {name: np.asarray(axis.values) for name, axis in kept.root.axes.items()}
    places: dict[str, Any] = {
        name: generator.choice(nodes, _READS) if name == "material" else generator.uniform(nodes[0], nodes[-1], _READS)
        for name, nodes in axes.items()
    }
    if "valid" in kept.root.variables:
        # How values go on behind the ground depends on the ranges of a table, which says so.
        before_ground = kept.value("valid", **{axis: places[axis] for axis in kept.root.variables["valid"].dims}) == 1
        places = {name: values[before_ground] for name, values in places.items()}
    if kept.root.groups["accuracy"].attributes.get("left_out_bound_kelvin", 0.0) > 0:
        if not isinstance(kept, AtmosphereTable) or not isinstance(whole, AtmosphereTable):
            raise TypeError(f"{kept_file.name}: only atmospheric tables state a bound in kelvin")
        return _radiance_differences(kept, whole, places)
    differences = {}
    for name, variable in kept.root.variables.items():
        if variable.kind != "f":
            continue
        where = {axis.removeprefix(f"{name}_"): places[axis] for axis in variable.dims}
        one, other = (table.value(name, **where) for table in (kept, whole))
        kelvin = variable.units == "K"
        scale = 1.0 if kelvin else np.maximum(np.abs(other), np.median(np.abs(other)))
        difference = np.abs(one - other) / np.where(scale > 0, scale, 1.0)
        differences[f"{kept_file.name}: {name}"] = float(difference.max()), KELVIN_BOUND if kelvin else VALUE_BOUND
    return differences


def _radiance_differences(
    kept: AtmosphereTable, whole: AtmosphereTable, places: dict[str, Floats]
) -> dict[str, tuple[float, float]]:
    """Of radiances at the observer, K, where light or particles are left out.

    Beyond what single precision, or other steps along lines whose ranges are left out, change.
    """
    other_steps = kept.root.axes["range"].values.size < whole.root.axes["range"].values.size
    notes = kept.root.groups["accuracy"].attributes
    bound, radiance = (float(notes[name]) for name in ("left_out_bound_kelvin", "left_out_bound"))
    share = VALUE_BOUND if other_steps else _SINGLE
    differences = {}
    for (name, one), other in zip(_radiances(kept, places).items(), _radiances(whole, places).values(), strict=True):
        excess = np.abs(one - other) - share * np.maximum(np.abs(other), np.median(np.abs(other)))
        differences[f"{kept.path.name}: {name}, K"] = float(np.max(excess, initial=0.0)) * bound / radiance, bound
    return differences


def _radiances(table: AtmosphereTable, places: dict[str, Floats]) -> dict[str, Floats]:
    """Radiances of path, sky and source at the observer, (9), (11), (19) and (35), of a surface that reflects all."""

    def read(name: str) -> Floats:
        axes = [axis.removeprefix(f"{name}_") for axis in table.root.variables[name].dims]
        where: dict[str, Any] = {axis: places[axis] for axis in axes}
        return table.value(name, **where)

    through = table.transmittance(range=places["range"], beta_star=read("beta_star"))
    return {
        "path": read("path_radiance_ratio") * (1 - through),
        "sky": read("ambient_radiance") * through,
        "direct": read("direct_radiance") * through,
    }
