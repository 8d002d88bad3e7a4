"""Means of the forcing over the solver's steps."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


def step_means(values: Floats, steps: int) -> Floats:
    """Means of periodic samples over the steps centred on each solver time, by the trapezium rule.

    Parameters
    ----------
    values : (..., n or 1) ndarray
        Samples through the period, or a constant.
    steps : int
        Of the solver.

    Returns
    -------
    (..., steps or 1) ndarray

    Raises
    ------
    InputError
        The number of samples is not a multiple of the number of steps.
    """
    samples = values.shape[-1]
    if samples == 1:
        return values
    if samples % steps:
        raise InputError(f"found {steps} solver steps; allowed: divisors of {samples}")
    ratio = samples // steps
    if ratio == 1:
        return values
    weights = np.zeros(samples)
    offsets = np.arange(-(ratio // 2), ratio // 2 + 1)
    ends = 0.5 if ratio % 2 == 0 else 1.0
    weights[offsets % samples] = np.where(np.abs(offsets) == ratio // 2, ends, 1.0) / ratio
    kernel = _circulant_rows(tuple(weights), ratio)
    means: Floats = values @ kernel
    return means


@lru_cache(maxsize=8)
def _circulant_rows(weights: tuple[float, ...], ratio: int) -> Floats:
    """(samples, steps) matrix that applies a symmetric periodic kernel and keeps every `ratio`-th result."""
    samples = len(weights)
    rows, columns = np.arange(samples)[:, None], np.arange(0, samples, ratio)[None, :]
    kernel: Floats = np.asarray(weights)[(rows - columns) % samples]
    return kernel
