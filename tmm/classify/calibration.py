"""Calibration of confidence on held-out texels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

STEPS = 65535  # confidences are looked up in a table of this fineness
LIMIT = 1e-4  # confidences are kept this far from 0 and 1, whose log-odds are infinite
SLOPE_LIMIT, OFFSET_LIMIT = 10.0, 10.0  # of a fit: beyond, the answer is as good as certain
LOW, HIGH = np.array([0.0, -OFFSET_LIMIT]), np.array([SLOPE_LIMIT, OFFSET_LIMIT])
START = np.array([1.0, 0.0])  # what a classifier says of itself
NEWTON_STEPS, NEWTON_END = 100, 1e-8  # far more than a smooth loss of two parameters takes; a hundredth of what is kept
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
        table = _expit(self.slope * _log_odds(np.arange(STEPS + 1) / STEPS) + self.offset).astype(np.float32)
        table[0] = 0
        calibrated: npt.NDArray[np.float32] = np.take(table, np.rint(confidence * np.float32(STEPS)).astype(np.intp))
        return calibrated


IDENTITY = Calibration(1.0, 0.0)


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

    def loss(parameters: npt.NDArray[Any]) -> tuple[float, npt.NDArray[Any], npt.NDArray[Any]]:
        z = parameters[0] * odds + parameters[1]
        value = np.sum(weight * (np.logaddexp(0, z) - target * z)) + PRIOR / 2 * np.sum((parameters - START) ** 2)
        found = _expit(z)
        residual, curved = weight * (found - target), weight * found * (1 - found)
        gradient = np.array([residual @ odds, residual.sum()]) + PRIOR * (parameters - START)
        mixed = curved @ odds
        hessian = np.array([[curved @ odds**2, mixed], [mixed, curved.sum()]]) + PRIOR * np.eye(2)
        return float(value), gradient, hessian

    slope, offset = _least(loss)
    # Rounded, so that the last bits of an optimiser do not show in the files.
    return Calibration(round(float(slope), 4), round(float(offset), 4))


def _least(
    loss: Callable[[npt.NDArray[Any]], tuple[float, npt.NDArray[Any], npt.NDArray[Any]]],
) -> npt.NDArray[np.float64]:
    """Where a convex loss, given with its gradient and Hessian, is least between `LOW` and `HIGH`.

    Newton's method on the parameters that their limits do not hold (Bertsekas 1982, SIAM J. Control Optim. 20:221-246).
    """
    at = START
    value, gradient, hessian = loss(at)
    for _ in range(NEWTON_STEPS):
        free = ~((at <= LOW) & (gradient > 0) | (at >= HIGH) & (gradient < 0))
        step = np.zeros(2)
        step[free] = -np.linalg.solve(hessian[np.ix_(free, free)], gradient[free])
        length = 1.0
        while True:
            new = np.clip(at + length * step, LOW, HIGH)
            found = loss(new)
            if found[0] <= value + 1e-4 * gradient @ (new - at) or length < NEWTON_END:
                break
            length /= 2
        moved = np.abs(new - at).max()
        at, (value, gradient, hessian) = new, found
        if moved < NEWTON_END:
            break
    return at


def _log_odds(probability: npt.NDArray[Any]) -> npt.NDArray[Any]:
    inside = np.clip(probability.astype(np.float64), LIMIT, 1 - LIMIT)
    odds: npt.NDArray[np.float64] = np.log(inside) - np.log1p(-inside)
    return odds


def _expit(z: npt.NDArray[Any]) -> npt.NDArray[Any]:
    probability: npt.NDArray[np.float64] = 1 / (1 + np.exp(-z))
    return probability
