"""Consecutive days as blocks of one causal response: what temperatures and light of days before leave for a day."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skyshine.mat.surface.column_forcing import Forcing
from skyshine.schemas.arrays import Floats


def day_block(response: Floats, steps: int, days: int) -> Floats:
    """The matrix (N, N) from the values of a day to their effect so many days later, of a response by lag."""
    lag = np.arange(steps)[:, None] - np.arange(steps) + days * steps
    block: Floats = np.where(lag >= 0, response[np.maximum(lag, 0)], 0.0)
    return block


def left_by_days_before(before: Sequence[Floats], blocks: Sequence[Floats], periodic: Floats) -> Floats:
    """What all days before, oldest first, leave: `blocks` by days since, of which the periodic matrix is the sum.

    The first day represents all before it: the whole of the periodic matrix less what has its own day.
    """
    oldest = periodic - np.sum(blocks[: len(before)], axis=0)
    matrices = [*blocks[1 : len(before)], oldest]
    heat: Floats = np.sum([day @ block.T for day, block in zip(reversed(before), matrices, strict=True)], axis=0)
    return heat


def mean_air(forcings: Sequence[Forcing]) -> Floats:
    """Mean air temperature (rows, 1) of all days [K]."""
    means = [np.atleast_2d(forcing.air_temperature).mean(axis=1, keepdims=True) for forcing in forcings]
    mean: Floats = np.mean(means, axis=0)
    return mean
