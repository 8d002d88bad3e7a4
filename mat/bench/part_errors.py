"""What each part that a job can set does to the pixel: the job as written with this part alone one step coarser."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.transfer.stream_count import azimuthal_count
from skyshine.mat.bench.model import TimeModel, counts
from skyshine.mat.bench.pixel_errors import SetErrors, Variant, described
from skyshine.mat.bench.rungs import Rung
from skyshine.mat.bench.sample import with_spectral_tolerance
from skyshine.mat.bench.thinned import thinned, without_harmonics, without_response
from skyshine.mat.budget.sizes import kelvin_of, measures
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import Kind
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.scene.compiled import StateBand
from skyshine.schemas.quantity import quantity

FEW_STEPS = 48
COARSER_POINTS = 4.0  # times the tolerance of a compiled band
_RESPONSE = "no response to shade and walls"


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


def parts(rung: Rung) -> dict[str, Variant]:
    """The job as written with one part coarser, by the key of the job that makes it so."""
    thinner_air, thinner_surface = partial(thinned, air=2.0, surface=1.0), partial(thinned, air=1.0, surface=2.0)
    return {
        "atmosphere_grid.tolerance": Variant("half the nodes on each axis of the air", rung, thinner_air),
        "surface_grid.tolerance": Variant("half the nodes on each axis of T", rung, thinner_surface),
        "accuracy.spectral_tolerance": Variant(
            f"{COARSER_POINTS:g} times the spectral tolerance", rung, air=_few_points
        ),
        "none: 8, or 12 in cloud": Variant("half the streams of scattered light", rung, air=_few_streams),
        "accuracy.solver_steps": Variant(f"{FEW_STEPS} steps of the heat balance", rung, steps=FEW_STEPS),
        "accuracy.tilted_faces_k": Variant("light of level faces on tilted ones", rung, without_harmonics),
        "needs.shade": Variant(_RESPONSE, rung, without_response),
    }


def part_errors(rung: Rung, sets: Sequence[SetErrors], model: TimeModel) -> list[dict[str, Any]]:
    """Error of the pixel with each part coarser, and the processor seconds that this saves, where they are known.

    Parameters
    ----------
    rung : Rung
        Job as written, built.
    sets : sequence of SetErrors
        Errors of it and of its `parts`.
    model : TimeModel
    """
    whole, _ = model.stages(counts(sets, rung.setting.name))
    rows = []
    for key, part in parts(rung).items():
        of_part = described(sets, part.name)["all"]
        sizes = of_part["temperature"] or of_part["share_of_radiance"]
        rows.append(_row(part.name, key, sizes["p99"], sizes["rms"], _saved(part, whole, sets, model)))
    return rows + _texels(rung, sets)


def _saved(part: Variant, whole: dict[str, float], sets: Sequence[SetErrors], model: TimeModel) -> float:
    """Processor seconds that a coarser part saves."""
    if part.steps is not None:
        return whole["temperature"] * max(1 - part.steps / part.rung.loaded.trimmed.accuracy.solver_steps, 0.0)
    if part.tables is without_response:
        return part.rung.seconds(Kind.TEMPERATURE, "response")
    if part.air is None:
        less, _ = model.stages(counts(sets, part.name))
        return sum(whole.values()) - sum(less.values())
    bands = {(of_set.state, of_set.band): of_set for of_set in sets}.values()  # whose air all sources share
    usual, coarser = (sum(of_set.points[part.name][which] for of_set in bands) for which in (0, 1))
    if coarser != usual:  # all that is computed at each point
        return whole["tables"] * (1 - coarser / usual)
    return sum(of_set.seconds[part.name][0] - of_set.seconds[part.name][1] for of_set in bands)


def _row(name: str, key: str, error: Any, rms: Any, saved: float) -> dict[str, Any]:
    return {"part": name, "key": key, "error": error, "rms": rms, "saved": quantity(saved, "s")}


def _texels(rung: Rung, sets: Sequence[SetErrors]) -> list[dict[str, Any]]:
    """Error of the texels' materials alone: each has the radiance of the material that held-out seeds were given."""
    errors, weights = [], []
    for of_set in sets:
        if of_set.assigned is None:
            continue
        difference = of_set.radiance[:, None, :] - of_set.radiance[:, :, None]
        kelvin = kelvin_of(of_set.response, of_set.radiance[:, :, None] + 0 * difference, difference)
        if np.isfinite(kelvin).all():
            errors.append(kelvin.ravel())
            weights.append(np.broadcast_to(of_set.assigned, difference.shape).ravel())
    if not errors:
        return []
    sizes = {name: quantity(value, "K") for name, value in measures(*map(np.concatenate, (errors, weights))).items()}
    name, key = "materials of texels alone, by held-out seeds", "textures: speed, seeds"
    return [_row(name, key, sizes["p99"], sizes["rms"], rung.seconds(Kind.TEXTURE))]
