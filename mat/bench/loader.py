"""How fast a table is read: interpolated values a second of processor time, beside scipy's interpolator on the same
table.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from skyshine.mat.tables.axes import AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.schemas.arrays import Floats

REPEATS = 3  # the fastest is kept: other programs on the machine only ever slow one down


@dataclass(frozen=True)
class LoaderBench:
    """Values a second of one core, and the largest difference of the two results relative to the table's largest
    value.
    """

    shape: tuple[int, ...]
    values_per_second: float
    scipy_values_per_second: float
    difference: float


def bench_loader(shape: tuple[int, ...], points: int, seed: int = 1) -> LoaderBench:
    """Read a random table of a shape at random points.

    Parameters
    ----------
    shape : tuple of int
        Nodes of each axis, at least 2.
    points : int
    """
    draw = np.random.default_rng(seed)
    nodes = [np.sort(draw.random(count)) for count in shape]
    values = draw.random(shape).astype(np.float32)
    where = {f"axis{k}": draw.uniform(axis[0], axis[-1], points) for k, axis in enumerate(nodes)}
    rules = [AxisRule(name, axis) for name, axis in zip(where, nodes, strict=True)]
    seconds, values_read = _fastest(lambda: interpolate(values, rules, where))
    peer = RegularGridInterpolator(nodes, values.astype(float))
    stacked = np.stack(list(where.values()), axis=1)
    peer_seconds, expected = _fastest(lambda: peer(stacked))
    return LoaderBench(shape, points / seconds, points / peer_seconds, float(np.max(np.abs(values_read - expected))))


def _fastest(work: Callable[[], Floats]) -> tuple[float, Floats]:
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        result = work()
        times.append(time.process_time() - begin)
    return min(times), result
