"""Calibration of confidence on held-out texels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

STEPS = 65535  # confidences are looked up in a table of this fineness
LIMIT = 1e-4  # confidences are kept this far from 0 and 1, whose log-odds are infinite
SLOPE_LIMIT, OFFSET_LIMIT = 10.0, 10.0  # of a fit: beyond, the answer is as good as certain
_LOW, _HIGH = np.array([0.0, -OFFSET_LIMIT]), np.array([SLOPE_LIMIT, OFFSET_LIMIT])
ROUNDS, PRECISION = 100, 1e-9  # of Newton's method, which settles in about six rounds
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

    def loss(at: npt.NDArray[np.float64]) -> float:
        z = at[0] * odds + at[1]
        return float(np.sum(weight * (np.logaddexp(0, z) - target * z)) + PRIOR / 2 * ((at[0] - 1) ** 2 + at[1] ** 2))

    def derivatives(at: npt.NDArray[np.float64]) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        chance = _expit(at[0] * odds + at[1])
        residual, curvature = weight * (chance - target), weight * chance * (1 - chance)
        slope = np.array([residual @ odds + PRIOR * (at[0] - 1), residual.sum() + PRIOR * at[1]])
        mixed = curvature @ odds
        return slope, np.array([[curvature @ odds**2 + PRIOR, mixed], [mixed, curvature.sum() + PRIOR]])

    slope, offset = _least(loss, derivatives)
    # Rounded, so that the last bits of a sum do not show in the files.
    return Calibration(round(float(slope), 4), round(float(offset), 4))


def _least(
    loss: Callable[[npt.NDArray[np.float64]], float],
    derivatives: Callable[[npt.NDArray[np.float64]], tuple[npt.NDArray[Any], npt.NDArray[Any]]],
) -> npt.NDArray[np.float64]:
    """Where a strictly convex loss of (slope, offset) is least within the limits, by Newton's method from the identity.

    Each step goes to the least of the quadratic model within the limits, or part of the way (Armijo's rule: Nocedal and
    Wright 2006, Numerical Optimization, 3.1), so that it stays within them.
    """
    at = np.array([1.0, 0.0])
    for _ in range(ROUNDS):
        slope, curvature = derivatives(at)
        step = _quadratic_least(slope, curvature, _LOW - at, _HIGH - at)
        if np.abs(step).max() < PRECISION:
            break
        value, length = loss(at), 1.0
        while length > PRECISION and loss(at + length * step) > value + 1e-4 * length * float(slope @ step):
            length /= 2
        at = at + length * step
    return at


def _quadratic_least(
    slope: npt.NDArray[np.float64],
    curvature: npt.NDArray[np.float64],
    low: npt.NDArray[np.float64],
    high: npt.NDArray[np.float64],
) -> npt.NDArray[np.float64]:
    """The step (2,) within limits at which slope . step + step . curvature . step / 2 is least."""
    inside: npt.NDArray[Any] = -np.linalg.solve(curvature, slope)
    if (inside >= low).all() and (inside <= high).all():
        return inside
    edges = []
    for fixed, free in ((0, 1), (1, 0)):
        for limit in (low[fixed], high[fixed]):
            step = np.empty(2)
            step[fixed] = limit
            least = -(slope[free] + curvature[free, fixed] * limit) / curvature[free, free]
            step[free] = min(max(least, low[free]), high[free])
            edges.append(step)
    return min(edges, key=lambda step: float(slope @ step + step @ curvature @ step / 2))


def _log_odds(probability: npt.NDArray[Any]) -> npt.NDArray[Any]:
    inside = np.clip(probability.astype(np.float64), LIMIT, 1 - LIMIT)
    odds: npt.NDArray[np.float64] = np.log(inside) - np.log1p(-inside)
    return odds


def _expit(z: npt.NDArray[Any]) -> npt.NDArray[Any]:
    probability: npt.NDArray[np.float64] = 1 / (1 + np.exp(-z))
    return probability
