"""What each part that a job can set does to the pixel: the job as written with this part alone one step coarser."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyshine.mat.bench.model import TimeModel, counts
from skyshine.mat.bench.pixel_errors import Truths, errors_of, sets_of, tables_of
from skyshine.mat.bench.rungs import Rung
from skyshine.mat.bench.thinned import thinned, without_harmonics, without_response
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.sizes import kelvin_of, measures
from skyshine.mat.plan.plan import Kind
from skyshine.schemas.quantity import quantity

FEW_STEPS = 48


@dataclass(frozen=True)
class Part:
    """A part of a job's accuracy.

    Attributes
    ----------
    name, key : str
        What is coarser, and the key of the job that makes it so.
    tables : callable
        Tables with this part coarser, from those of the job.
    steps : int or None
        Steps of the heat balance of a day, where these are the part.
    """

    name: str
    key: str
    tables: Callable[[Tables], Tables]
    steps: int | None = None


PARTS = (
    Part("half the nodes on each axis of the air", "atmosphere_grid.tolerance", lambda tables: thinned(tables, 2, 1)),
    Part("half the nodes on each axis of T", "surface_grid.tolerance", lambda tables: thinned(tables, 1, 2)),
    Part(f"{FEW_STEPS} steps of the heat balance", "accuracy.solver_steps", lambda tables: tables, FEW_STEPS),
    Part("light of level faces on tilted ones", "accuracy.tilted_faces_k", without_harmonics),
    Part("no response to shade and walls", "needs.shade", without_response),
)


def part_errors(rung: Rung, truths: Truths, model: TimeModel) -> list[dict[str, Any]]:
    """Error of the pixel with each part coarser, and the processor seconds that this saves, where they are known.

    Parameters
    ----------
    rung : Rung
        Job as written, built and measured.
    truths : Truths
    model : TimeModel
    """
    written, rows = tables_of(rung), []
    whole, _ = model.stages(counts(rung, written))
    for part in PARTS:

        def tables(state: int, band: int, source: str, part: Part = part) -> Tables:
            return part.tables(written(state, band, source))

        errors = errors_of(truths, tables, part.steps)["all"]
        rows.append(_row(part.name, part.key, errors, whole, model.stages(counts(rung, tables))[0], rung, part))
    return rows + _texels(rung, truths)


def _row(
    name: str, key: str, errors: dict[str, Any], whole: dict[str, float], less: dict[str, float], rung: Rung, part: Part
) -> dict[str, Any]:
    saved = sum(whole.values()) - sum(less.values())
    if part.steps is not None:
        steps = rung.loaded.trimmed.accuracy.solver_steps
        saved = whole["temperature"] * max(1 - part.steps / steps, 0.0)
    elif part.tables is without_response:
        saved = _stage(rung, Kind.TEMPERATURE, "response")
    units = "temperature" if errors["temperature"] else "share_of_radiance"
    return {
        "part": name,
        "key": key,
        "error": errors[units]["p99"],
        "rms": errors[units]["rms"],
        "saved": quantity(saved, "s"),
    }


def _stage(rung: Rung, kind: Kind, name: str) -> float:
    """Processor seconds of a stage of all tasks of a kind; not a number where none names it."""
    tasks = [] if rung.cost is None else [task for task in rung.cost.tasks if Kind(task.kind) is kind]
    seconds = [task.stages[name] for task in tasks if name in task.stages]
    return sum(seconds) if seconds else float("nan")


def _texels(rung: Rung, truths: Truths) -> list[dict[str, Any]]:
    """Error of the texels' materials alone: each has the radiance of the material that held-out seeds were given."""
    errors, weights = [], []
    for state, band, source in sets_of(rung.loaded.trimmed):
        tables = tables_of(rung)(state, band, source)
        truth = truths.of(state, band, source, tables)
        if truth is None or tables.assigned_share is None:
            continue
        difference = truth.radiance[:, None, :] - truth.radiance[:, :, None]
        response = truths.prepared[state, band].response
        kelvin = kelvin_of(response, truth.radiance[:, :, None] + 0 * difference, difference)
        if np.isfinite(kelvin).all():
            errors.append(kelvin.ravel())
            weights.append(np.broadcast_to(tables.assigned_share, difference.shape).ravel())
    if not errors:
        return []
    sizes = measures(np.concatenate(errors), np.concatenate(weights))
    seconds = _stage_of_textures(rung)
    return [
        {
            "part": "materials of texels alone, by held-out seeds",
            "key": "textures: speed, seeds",
            "error": quantity(sizes["p99"], "K"),
            "rms": quantity(sizes["rms"], "K"),
            "saved": quantity(seconds, "s"),
        }
    ]


def _stage_of_textures(rung: Rung) -> float:
    tasks = [] if rung.cost is None else [task for task in rung.cost.tasks if Kind(task.kind) is Kind.TEXTURE]
    return sum(sum(task.stages.values()) for task in tasks)
