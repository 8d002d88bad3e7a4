"""What each part that a job can set does to the pixel: the job as written with this part alone one step coarser."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.transfer.stream_count import azimuthal_count
from skyshine.mat.bench.model import TimeModel, counts
from skyshine.mat.bench.pixel_errors import AirOf, Truths, errors_of, sets_of
from skyshine.mat.bench.rungs import Rung
from skyshine.mat.bench.sample import with_spectral_tolerance
from skyshine.mat.bench.thinned import thinned, without_harmonics, without_response
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.sizes import kelvin_of, measures
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import Kind
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.scene.compiled import StateBand
from skyshine.schemas.quantity import quantity

FEW_STEPS = 48
COARSER_POINTS = 4.0  # times the tolerance of a compiled band


def _same(tables: Tables) -> Tables:
    return tables


def with_coarser_points(loaded: LoadedJob) -> LoadedJob:
    """The job with fewer spectral points."""
    return with_spectral_tolerance(loaded, COARSER_POINTS * loaded.trimmed.accuracy.spectral_tolerance)


def _few_points(prepared: Prepared) -> BandAtmosphere:
    loaded = with_coarser_points(prepared.loaded)
    of_band = StateBand.of(loaded, prepared.state, prepared.band)
    return BandAtmosphere.of(of_band.air, of_band.compiled.band)


def _few_streams(prepared: Prepared) -> BandAtmosphere:
    air = prepared.reduced.air
    return replace(prepared.reduced, air=replace(air, nodes=air.nodes // 2, azimuthal=azimuthal_count(air.nodes // 2)))


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
    air : callable or None
        Coarser air, where its light is the part.
    """

    name: str
    key: str
    tables: Callable[[Tables], Tables] = _same
    steps: int | None = None
    air: AirOf | None = None


PARTS = (
    Part("half the nodes on each axis of the air", "atmosphere_grid.tolerance", lambda tables: thinned(tables, 2, 1)),
    Part("half the nodes on each axis of T", "surface_grid.tolerance", lambda tables: thinned(tables, 1, 2)),
    Part(f"{COARSER_POINTS:g} times the spectral tolerance", "accuracy.spectral_tolerance", air=_few_points),
    Part("half the streams of scattered light", "none: 8, or 12 in cloud", air=_few_streams),
    Part(f"{FEW_STEPS} steps of the heat balance", "accuracy.solver_steps", steps=FEW_STEPS),
    Part("light of level faces on tilted ones", "accuracy.tilted_faces_k", without_harmonics),
    Part("no response to shade and walls", "needs.shade", without_response),
)


def part_errors(rung: Rung, truths: Truths, model: TimeModel) -> list[dict[str, Any]]:
    """Error of the pixel with each part coarser, and the processor seconds that this saves, where they are known.

    Parameters
    ----------
    rung : Rung
        Job as written, built and measured.
    """
    rows = []
    whole, _ = model.stages(counts(rung, rung.tables))
    for part in PARTS:

        def tables(state: int, band: int, source: str, part: Part = part) -> Tables:
            return part.tables(rung.tables(state, band, source))

        errors = errors_of(truths, tables, part.steps, part.air)["all"]
        less = model.stages(counts(rung, tables))[0]
        rows.append(_row(part.name, part.key, errors, _saved(part, whole, less, rung, truths)))
    return rows + _texels(rung, truths)


def _saved(part: Part, whole: dict[str, float], less: dict[str, float], rung: Rung, truths: Truths) -> float:
    """Processor seconds that a coarser part saves."""
    if part.steps is not None:
        return whole["temperature"] * max(1 - part.steps / rung.loaded.trimmed.accuracy.solver_steps, 0.0)
    if part.tables is without_response:
        return _stage(rung, Kind.TEMPERATURE, "response")
    if part.air is not None:
        airs = [(prepared.reduced, part.air(prepared)) for prepared in truths.prepared.values()]
        usual, coarser = (sum(air.band.weight.size for air in pair) for pair in zip(*airs, strict=True))
        if coarser != usual:  # all that is computed at each point
            return float(whole["tables"] * (1 - coarser / usual))
        return sum(_field_seconds(air) - _field_seconds(coarse) for air, coarse in airs)
    return sum(whole.values()) - sum(less.values())


def _field_seconds(atmosphere: BandAtmosphere) -> float:
    """Processor seconds of the fields of light at the points of a band."""
    air, begin = replace(atmosphere.air), time.process_time()
    air.prepare()
    return time.process_time() - begin


def _row(name: str, key: str, errors: dict[str, Any], saved: float) -> dict[str, Any]:
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
        tables = rung.tables(state, band, source)
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
