"""Means of the forcing over the solver's steps."""

from __future__ import annotations

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
        Number of steps of the solver.

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
    half = ratio // 2
    padded = np.concatenate([values[..., samples - half :], values, values[..., :half]], axis=-1)
    total = sum((padded[..., k : k + samples : ratio] for k in range(1, ratio)), padded[..., :samples:ratio])
    if ratio % 2 == 0:  # a step ends at a sample: half of it, and of the one at which it begins
        total = total + 0.5 * (padded[..., ratio::ratio] - padded[..., :samples:ratio])
    means: Floats = total / ratio
    return means
