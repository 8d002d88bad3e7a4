"""Quality of a classification, measured on seeds that its model has not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.tmm.classify import TextureClassifier, fit_seeds
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.job import TextureJob
from skyshine.tmm.seeds import SeedTexels
from skyshine.tmm.texture import Texture

MAX_REGIONS = 200  # tested of one material: enough for two digits, and a label image stays affordable


@dataclass(frozen=True)
class Quality:
    """Held-out seeds against what was found there.

    Attributes
    ----------
    confusion : (K, K + 1) int64
        Texels by true material and found material; the first column is unknown.
    """

    confusion: np.ndarray

    @property
    def tested(self) -> int:
        """Number of texels tested."""
        return int(self.confusion.sum())

    @property
    def overall_accuracy(self) -> float:
        """Share of the tested texels with the right material; 0 where none was tested."""
        return float(np.trace(self.confusion[:, 1:]) / max(self.tested, 1))

    @property
    def intersection_over_union(self) -> np.ndarray:
        """(K,) float64 of each material; 0 for one that was neither present nor found."""
        hit = np.diag(self.confusion[:, 1:])
        union = self.confusion.sum(axis=1) + self.confusion[:, 1:].sum(axis=0) - hit
        return hit / np.maximum(union, 1)

    @property
    def mean_iou(self) -> float:
        """Mean intersection over union of the materials that were tested; 0 where none was."""
        tested = self.confusion.sum(axis=1) > 0
        return float(self.intersection_over_union[tested].mean()) if tested.any() else 0.0


def measure(job: TextureJob, texture: Texture, colours: DistinctColours, seeds: SeedTexels) -> Quality:
    """Classify each seed region by a model of the other parts' seeds.

    The regions of a material are dealt out over the parts in a random order of recorded seed. A material with one
    region cannot be left out and is not tested.
    """
    fold = _folds(job, seeds)
    confusion = np.zeros((len(seeds.names), len(seeds.names) + 1), np.int64)
    for part in range(job.held_out.folds):
        tested = fold == part
        if not tested.any():
            continue
        model = fit_seeds(texture, seeds, job.classifier, ~tested)
        classifier = TextureClassifier(texture, colours, model, job.classifier.radius, tabulate=False)
        found_index = np.array([0] + [1 + seeds.names.index(name) for name in model.names])
        for mine in _groups(np.flatnonzero(tested), seeds.region):
            found = found_index[_found(classifier, seeds.rows[mine], seeds.columns[mine], job) + 1]
            np.add.at(confusion, (seeds.material[mine], found), 1)
    return Quality(confusion)


def _folds(job: TextureJob, seeds: SeedTexels) -> np.ndarray:
    """The part (N,) in which each seed texel is held out; -1 where it never is."""
    random = np.random.default_rng(job.held_out.random_seed)
    fold = np.full(len(seeds.rows), -1)
    for k in range(len(seeds.names)):
        mine = seeds.material == k
        regions, region = np.unique(seeds.region[mine], return_inverse=True)
        if len(regions) < 2:
            continue
        part = np.full(len(regions), -1)
        part[random.permutation(len(regions))[:MAX_REGIONS]] = (
            np.arange(min(len(regions), MAX_REGIONS)) % job.held_out.folds
        )
        fold[mine] = part[region]
    return fold


def _groups(texels: np.ndarray, region: np.ndarray) -> list[np.ndarray]:
    """Divide texel numbers by the region (N,) in which each lies."""
    texels = texels[np.argsort(region[texels], kind="stable")]
    return np.split(texels, np.flatnonzero(np.diff(region[texels])) + 1)


def _found(classifier: TextureClassifier, rows: np.ndarray, columns: np.ndarray, job: TextureJob) -> np.ndarray:
    """Material found at texels, as an index into the model's names; -1 unknown."""
    top, left = rows.min(), columns.min()
    result = classifier.window(top, rows.max() + 1, left, columns.max() + 1)
    return with_unknown(result, job)[rows - top, columns - left]


def with_unknown(result, job: TextureJob) -> np.ndarray:
    """Material index (H, W) of a classification, -1 where it is below the job's thresholds or has no data."""
    settings = job.classifier
    unsure = result.confidence < settings.confidence_threshold
    unsure |= result.typicality < settings.typicality_threshold
    return np.where(unsure, -1, result.material)
