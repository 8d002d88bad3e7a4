"""Calibration of confidence on held-out texels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

STEPS = 65535  # confidences are looked up in a table of this fineness
LIMIT = 1e-4  # confidences are kept this far from 0 and 1, whose log-odds are infinite
SLOPE_LIMIT, OFFSET_LIMIT = 10.0, 10.0  # limits of a fit: beyond, the answer is as good as certain
ROUNDS, SETTLED = 50, 1e-6  # Newton's method takes some five; change of the parameters at which it ends
PRIOR = 1.0  # regions that the identity counts as: few held-out regions hardly change what a classifier says of itself


@dataclass(frozen=True)
class Calibration:
    """Platt scaling: log-odds of being right = slope x log-odds of the confidence + offset.

    Platt 1999, "Probabilistic outputs for support vector machines", in: Advances in Large Margin Classifiers, MIT
    Press.
    """

    slope: float
    offset: float

    def __call__(self, confidence: npt.NDArray[np.float32]) -> npt.NDArray[Any]:
        """Calibrated confidence, float32, of the same shape; 0 stays 0."""
        if self == IDENTITY:
            return confidence
        table = _table(self)
        calibrated: npt.NDArray[np.float32] = np.take(table, np.rint(confidence * np.float32(STEPS)).astype(np.intp))
        return calibrated


IDENTITY = Calibration(1.0, 0.0)


@lru_cache(maxsize=16)
def _table(calibration: Calibration) -> npt.NDArray[np.float32]:
    """Calibrated confidences of all that are looked up: a texture asks for them window by window."""
    odds = _log_odds(np.arange(STEPS + 1) / STEPS)
    table: npt.NDArray[np.float32] = _expit(calibration.slope * odds + calibration.offset).astype(np.float32)
    table[0] = 0
    return table


def fit_calibration(
    confidence: npt.NDArray[np.float32], right: npt.NDArray[np.bool_], region: npt.NDArray[Any]
) -> Calibration:
    """Fit to texels (N,): confidence, whether right, and region; a region counts once, because its texels are alike."""
    if not len(confidence):
        return IDENTITY
    number = np.unique(region, return_inverse=True)[1]
    weight = 1 / np.bincount(number)[number]
    odds = _log_odds(confidence)
    # Targets off 0 and 1, by Platt's Bayesian count of those right and wrong.
    count_right, count_wrong = weight[right].sum(), weight[~right].sum()
    target = np.where(right, (count_right + 1) / (count_right + 2), 1 / (count_wrong + 2))

    def loss(at: npt.NDArray[Any]) -> float:
        z = at[0] * odds + at[1]
        return float(weight @ (np.logaddexp(0, z) - target * z)) + PRIOR / 2 * float((at[0] - 1) ** 2 + at[1] ** 2)

    def descend(at: npt.NDArray[Any], fitted: slice) -> npt.NDArray[Any]:
        """Newton's method, damped, over the free parameters; the loss is convex."""
        for _ in range(ROUNDS):
            probability = _expit(at @ basis)
            rise = basis @ (weight * (probability - target)) + PRIOR * (at - (1.0, 0.0))
            bend = (basis * (weight * probability * (1 - probability))) @ basis.T + PRIOR * np.eye(2)
            step = np.zeros(2)
            step[fitted] = np.linalg.solve(bend[fitted, fitted], rise[fitted])
            while loss(at - step) > loss(at) and np.abs(step).max() > SETTLED:
                step /= 2
            at = at - step
            if np.abs(step).max() < SETTLED:
                break
        return at

    basis = np.stack([odds, np.ones_like(odds)])
    at = descend(np.array([1.0, 0.0]), slice(0, 2))
    if not 0 <= at[0] <= SLOPE_LIMIT:
        at = descend(np.array([np.clip(at[0], 0, SLOPE_LIMIT), 0.0]), slice(1, 2))
    at[1] = np.clip(at[1], -OFFSET_LIMIT, OFFSET_LIMIT)
    # Rounded, so that the last bits of sums do not show in the files.
    return Calibration(round(float(at[0]), 4), round(float(at[1]), 4))


def _log_odds(probability: npt.NDArray[Any]) -> npt.NDArray[Any]:
    inside = np.clip(probability.astype(np.float64), LIMIT, 1 - LIMIT)
    odds: npt.NDArray[np.float64] = np.log(inside) - np.log1p(-inside)
    return odds


def _expit(z: npt.NDArray[Any]) -> npt.NDArray[Any]:
    probability: npt.NDArray[np.float64] = 1 / (1 + np.exp(-z))
    return probability
