"""What leaving out saves and changes: a job built as it is and built whole, and both read at random places of what it needs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyshine.mat.build import build
from skyshine.mat.job import LoadedJob
from skyshine.mat.tables.loader import open_table

# What the plan says at most: of a value, and in K, where columns are solved in other batches to the solver's residual.
VALUE_BOUND, KELVIN_BOUND = 1e-3, 0.01
_READS = 5000


@dataclass(frozen=True)
class Cost:
    """Of a build: seconds of all its tasks together, and bytes of its files."""

    seconds: float
    size: int


@dataclass(frozen=True)
class Comparison:
    """The job as it is and whole; largest differences of reads, by file, with what is allowed."""

    kept: Cost
    whole: Cost
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
    job, everything = (one.model_copy(update={"output": one.output.model_copy(update={"pictures": False})}) for one in (loaded.job, loaded.whole))
    update = {"needs": None} | ({"materials": "all"} if everything.materials == "used" else {})
    everything = everything.model_copy(update=update)
    costs = {}
    for name, one in (("kept", replace(loaded, job=job)), ("whole", replace(loaded, job=everything, whole=everything))):
        result = build(one, out=folder / name, jobs=1, fresh=True)
        parts = {content["seconds"] for content in result["files"].values()}
        size = sum((folder / name / file).stat().st_size for file in result["files"])
        costs[name] = Cost(sum(parts), size)
    generator = np.random.default_rng(seed)
    differences = {}
    for file in sorted((folder / "kept").glob("s*.h5")):
        differences |= _differences(file, folder / "whole" / file.name, generator)
    return Comparison(costs["kept"], costs["whole"], differences)


def _differences(kept_file: Path, whole_file: Path, generator) -> dict[str, tuple[float, float]]:
    kept, whole = open_table(kept_file), open_table(whole_file)
    axes = {name: np.asarray(axis.values) for name, axis in kept.root.axes.items()}
    places = {
        name: generator.choice(nodes, _READS) if name == "material" else generator.uniform(nodes[0], nodes[-1], _READS)
        for name, nodes in axes.items()
    }
    found = {}
    for name, variable in kept.root.variables.items():
        if variable.kind != "f":
            continue
        where = {axis.removeprefix(f"{name}_"): places[axis] for axis in variable.dims}
        one, other = (np.asarray(table.value(name, **where)) for table in (kept, whole))
        kelvin = variable.units == "K"
        scale = 1.0 if kelvin else np.maximum(np.abs(other), np.median(np.abs(other)))
        difference = np.abs(one - other) / np.where(scale > 0, scale, 1.0)
        found[f"{kept_file.name}: {name}"] = float(difference.max()), KELVIN_BOUND if kelvin else VALUE_BOUND
    return found
