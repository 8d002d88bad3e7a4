"""Calibration of confidence on held-out texels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

STEPS = 65535  # confidences are looked up in a table of this fineness
LIMIT = 1e-4  # confidences are kept this far from 0 and 1, whose log-odds are infinite
SLOPE_LIMIT, OFFSET_LIMIT = 10.0, 10.0  # of a fit: beyond, the answer is as good as certain
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
    from scipy.optimize import minimize

    if not len(confidence):
        return IDENTITY
    number = np.unique(region, return_inverse=True)[1]
    weight = 1 / np.bincount(number)[number]
    odds = _log_odds(confidence)
    # Targets off 0 and 1, by Platt's Bayesian count of those right and wrong.
    count_right, count_wrong = weight[right].sum(), weight[~right].sum()
    target = np.where(right, (count_right + 1) / (count_right + 2), 1 / (count_wrong + 2))

    def loss(parameters: npt.NDArray[Any]) -> tuple[float, npt.NDArray[Any]]:
        slope, offset = parameters
        z = slope * odds + offset
        value = np.sum(weight * (np.logaddexp(0, z) - target * z)) + PRIOR / 2 * ((slope - 1) ** 2 + offset**2)
        residual = weight * (_expit(z) - target)
        return value, np.array([residual @ odds + PRIOR * (slope - 1), residual.sum() + PRIOR * offset])

    slope, offset = minimize(
        loss, [1.0, 0.0], jac=True, method="L-BFGS-B", bounds=[(0, SLOPE_LIMIT), (-OFFSET_LIMIT, OFFSET_LIMIT)]
    ).x
    # Rounded, so that the last bits of an optimiser do not show in the files.
    return Calibration(round(float(slope), 4), round(float(offset), 4))


def _log_odds(probability: npt.NDArray[Any]) -> npt.NDArray[Any]:
    inside = np.clip(probability.astype(np.float64), LIMIT, 1 - LIMIT)
    odds: npt.NDArray[np.float64] = np.log(inside) - np.log1p(-inside)
    return odds


def _expit(z: npt.NDArray[Any]) -> npt.NDArray[Any]:
    probability: npt.NDArray[np.float64] = 1 / (1 + np.exp(-z))
    return probability
