"""Quality measured on seeds that the classifier has not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.calibration import IDENTITY, Calibration, fit_calibration
from skyshine.tmm.classify.mapper import Classified, Mapper
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.materials import UNKNOWN
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.quality.counts import Quality, Tally

MAX_REGIONS = 200  # tested of one material: enough for two digits, and a label image stays affordable
TILE = 1024  # texels; a larger region is tested in pieces of this size


@dataclass(frozen=True)
class HeldOut:
    """Quality on seeds that the model has not seen.

    quality : Quality
    calibration : Calibration; turns a classifier's own confidence into one that is as often right as it says.
    areas : int; separate places that were omitted in turn.
    """

    quality: Quality
    calibration: Calibration
    areas: int = 0


def untested(count: int) -> HeldOut:
    """The answer for a way of assigning `count` materials that has no seeds to hold out."""
    return HeldOut(Tally(count).quality(), IDENTITY)


def measure(
    job: TextureJob,
    seeds: SeedTexels,
    mapper_of: Callable[[npt.NDArray[Any]], Mapper],
    thresholds: tuple[float, float],
) -> HeldOut:
    """Classify each separate place of seeds by a model of the other parts' seeds.

    The places of a material are dealt out over the parts in a random order of recorded seed. Not tested are materials
    with one place, which cannot be omitted; answers to what `tmm suggest` asked, which lie where the map was in doubt
    and say little of all the rest; and seeds of the class `unknown`.

    mapper_of : callable; gives the classifier that is trained on the seeds where a mask (N,) bool is true.
    thresholds : (float, float); of confidence and typicality.
    """
    fold = folds(job, seeds)
    parts = np.unique(fold[fold >= 0])
    assigned, confidence, typicality = at_seeds({part: mapper_of(fold != part) for part in parts}, seeds, fold)
    tested = fold >= 0
    columns = HeldOutTexels(seeds.material, assigned, confidence, seeds.region, fold, typicality)
    measured = held_out(len(seeds.names) - (UNKNOWN in seeds.names), columns.only(tested), thresholds)
    return replace(measured, areas=len(np.unique(seeds.region[tested])))


@dataclass(frozen=True)
class HeldOutTexels:
    """What was found at texels that the classifier has not seen.

    material, assigned : (N,) int; index of the true material and of the one assigned, -1 for none.
    confidence, typicality : (N,) float32
    region, fold : (N,) int; texels of one region are alike; those of one part were classified by one classifier.
    """

    material: npt.NDArray[Any]
    assigned: npt.NDArray[Any]
    confidence: npt.NDArray[np.float32]
    region: npt.NDArray[Any]
    fold: npt.NDArray[Any]
    typicality: npt.NDArray[np.float32]

    def only(self, chosen: npt.NDArray[np.bool_]) -> HeldOutTexels:
        """The texels that `chosen` (N,) bool keeps."""
        return HeldOutTexels(**{name: values[chosen] for name, values in vars(self).items()})

    @classmethod
    def joined(cls, parts: Sequence[HeldOutTexels]) -> HeldOutTexels:
        """The texels of all parts, in their order."""
        return cls(**{name: np.concatenate([vars(part)[name] for part in parts]) for name in vars(parts[0])})


def held_out(count: int, texels: HeldOutTexels, thresholds: tuple[float, float] = (0.0, 0.0)) -> HeldOut:
    """Quality of what was found at held-out texels (N,).

    The calibration is fitted to all parts; where it is tested, to the other parts. The threshold of confidence
    applies to the calibrated one.

    count : int; number of materials.
    texels : HeldOutTexels
    thresholds : (float, float); of confidence and typicality.
    """
    true, fold, region, confidence = texels.material, texels.fold, texels.region, texels.confidence
    right = texels.assigned == true
    calibration = fit_calibration(confidence, right, region)
    calibrated = confidence.copy()
    for part in np.unique(fold):
        mine = fold == part
        calibrated[mine] = fit_calibration(confidence[~mine], right[~mine], region[~mine])(confidence[mine])
    assigned = with_unknown(Classified(texels.assigned, calibrated, texels.typicality), thresholds)
    tally = Tally(count)
    tally.add(true, assigned, calibrated)
    return HeldOut(tally.quality(), calibration)


def folds(job: TextureJob, seeds: SeedTexels) -> npt.NDArray[Any]:
    """The part (N,) in which each seed texel is held out; -1 where it never is.

    Materials with one place are not held out, and of others `MAX_REGIONS` places at most.
    """
    random = np.random.default_rng(job.held_out.random_seed)
    fold = np.full(len(seeds.rows), -1)
    for k in range(len(seeds.names)):
        mine = (seeds.material == k) & ~seeds.answered
        if seeds.names[k] == UNKNOWN:
            continue
        regions, region = np.unique(seeds.region[mine], return_inverse=True)
        if len(regions) < 2:
            continue
        part = np.full(len(regions), -1)
        part[random.permutation(len(regions))[:MAX_REGIONS]] = (
            np.arange(min(len(regions), MAX_REGIONS)) % job.held_out.folds
        )
        fold[mine] = part[region]
    return fold


def at_seeds(
    mappers: dict[int, Mapper], seeds: SeedTexels, fold: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]:
    """What classifiers find at seeds, each by the classifier of its part.

    Returns
    -------
    assigned : (N,) int16; index into the names of the seeds; -1 where `fold` is negative or nothing is found.
    confidence, typicality : (N,) float32
    """
    assigned, confidence = np.full(len(fold), -1, np.int16), np.zeros(len(fold), np.float32)
    typicality = np.zeros(len(fold), np.float32)
    for mine in _groups(np.flatnonzero(fold >= 0), seeds):
        mapper, rows, columns = mappers[fold[mine[0]]], seeds.rows[mine], seeds.columns[mine]
        top, left = rows.min(), columns.min()
        result = mapper.window(top, rows.max() + 1, left, columns.max() + 1)
        at = rows - top, columns - left
        number = {name: k for k, name in enumerate(seeds.names) if name != UNKNOWN}
        index = np.array([*(number.get(name, -1) for name in mapper.names), -1], np.int16)
        assigned[mine], confidence[mine], typicality[mine] = (
            index[result.material[at]],
            result.confidence[at],
            result.typicality[at],
        )
    return assigned, confidence, typicality


def _groups(texels: npt.NDArray[np.int64], seeds: SeedTexels) -> list[npt.NDArray[Any]]:
    """Divide texel numbers by region and tile, in the order of their first rows: an image is read from the top."""
    if not len(texels):
        return []
    keys = np.stack([seeds.region[texels], seeds.rows[texels] // TILE, seeds.columns[texels] // TILE])
    # Texels of one region may be of several parts where materials share it, as blocks of a label image do.
    number = np.unique(np.concatenate([keys, seeds.material[texels][np.newaxis]]), axis=1, return_inverse=True)[
        1
    ].ravel()
    order = np.argsort(number, kind="stable")
    groups = np.split(texels[order], np.flatnonzero(np.diff(number[order])) + 1)
    return sorted(groups, key=lambda group: (seeds.rows[group[0]], seeds.columns[group[0]]))


def with_unknown(result: Classified, thresholds: tuple[float, float]) -> npt.NDArray[Any]:
    """Material index of a classification, -1 where confidence or typicality is below its threshold or has no data."""
    unsure = result.confidence < thresholds[0]
    unsure |= result.typicality < thresholds[1]
    return np.where(unsure, result.material.dtype.type(-1), result.material)
