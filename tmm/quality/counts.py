"""Quality of a classification: confusion, and calibration of the confidence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

BINS = 15  # bins of confidence, as Guo et al. (2017) take them


@dataclass(frozen=True)
class Quality:
    """Texels of known material against what was found there.

    confusion : (K, K + 1) int64; texels by true material and found material; the first column is unknown.
    bins : (3, BINS) float64
        By confidence, of the texels with a material found: their number, the sum of their confidence, those right.
    """

    confusion: npt.NDArray[np.int64]
    bins: npt.NDArray[np.float64]

    @property
    def tested(self) -> int:
        """Number of texels tested."""
        return int(self.confusion.sum())

    @property
    def overall_accuracy(self) -> float:
        """Share of the tested texels with the right material; 0 where none was tested."""
        return float(np.trace(self.confusion[:, 1:]) / max(self.tested, 1))

    @property
    def intersection_over_union(self) -> npt.NDArray[np.float64]:
        """(K,) float64 of each material; 0 for one that was neither present nor found."""
        hit = np.diag(self.confusion[:, 1:])
        union = self.confusion.sum(axis=1) + self.confusion[:, 1:].sum(axis=0) - hit
        shares: npt.NDArray[np.float64] = hit / np.maximum(union, 1)
        return shares

    @property
    def mean_iou(self) -> float:
        """Mean intersection over union of the materials that were tested; 0 where none was."""
        tested = self.confusion.sum(axis=1) > 0
        return float(self.intersection_over_union[tested].mean()) if tested.any() else 0.0

    @property
    def calibration_error(self) -> float:
        """Expected calibration error: mean of |accuracy - confidence| over bins (Naeini et al. 2015, AAAI)."""
        number, confidence, right = self.bins
        return float(np.abs(right - confidence).sum() / max(number.sum(), 1))


class Tally:
    """Counts what makes a `Quality`."""

    def __init__(self, count: int) -> None:
        self._confusion, self._bins = np.zeros((count, count + 1), np.int64), np.zeros((3, BINS))

    @property
    def texels(self) -> int:
        """Number of texels counted."""
        return int(self._confusion.sum())

    def add(self, true: npt.NDArray[Any], assigned: npt.NDArray[Any], confidence: npt.NDArray[np.float32]) -> None:
        """Count texels (N,): index of the true material, of the one assigned (-1 unknown), and its confidence."""
        shape = self._confusion.shape
        cell = true.astype(np.int64) * shape[1] + assigned + 1
        self._confusion += np.bincount(cell, minlength=self._confusion.size).reshape(shape)
        classified = assigned >= 0
        values = confidence[classified].astype(np.float64)
        number = np.minimum((values * BINS).astype(int), BINS - 1)
        for row, weight in zip(self._bins, (np.ones_like(values), values, (assigned == true)[classified]), strict=True):
            row += np.bincount(number, weight, BINS)

    def quality(self) -> Quality:
        """What was counted so far."""
        return Quality(self._confusion.copy(), self._bins.copy())
