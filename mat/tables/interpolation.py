"""Multilinear interpolation on tables, vectorised over query points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.tables.axes import AxisRule
from skyshine.schemas.errors import InputError, nearest

BATCH = 1024  # query points whose 32 corners fit the processor's second-level cache


def interpolate(values: np.ndarray, rules: Sequence[AxisRule], where: Mapping[str, np.ndarray]) -> np.ndarray:
    """Linear interpolation in every axis of a table.

    Parameters
    ----------
    values : (n1, n2, ...) ndarray
    rules : one AxisRule for each axis of `values`
    where : mapping of axis name to values
        Coordinates, broadcast against each other; axes of one node may be omitted.

    Returns
    -------
    ndarray
        Of the broadcast shape of `where`, float64.

    Raises
    ------
    InputError
        An axis is missing or unknown, or a value lies outside an axis whose rule is ``error``.
    """
    names = [rule.name for rule in rules]
    for name in where:
        if name not in names:
            raise InputError(f"found the axis '{name}'; {nearest(name, names)}")
    corners: list[tuple[npt.NDArray[np.intp], npt.NDArray[np.float64]]] = []
    stride = values.size
    base: npt.NDArray[np.intp] | int = 0
    for rule, count in zip(rules, values.shape, strict=True):
        if rule.name not in where and rule.nodes.size > 1:
            raise InputError(f"the axis '{rule.name}' is missing; give a value for it")
        lower, upper, weight = rule.locate(np.asarray(where.get(rule.name, rule.nodes[0])))
        stride //= count
        base = base + lower * stride
        if np.any(weight != 0):
            corners.append(((upper - lower) * stride, weight))
    shape = np.broadcast_shapes(np.shape(base), *(weight.shape for _, weight in corners))
    return _sum_corners(values.reshape(-1), shape, base, corners)


def _sum_corners(
    flat: npt.NDArray[Any],
    shape: tuple[int, ...],
    base: npt.NDArray[np.intp] | int,
    corners: list[tuple[npt.NDArray[np.intp], npt.NDArray[np.float64]]],
) -> npt.NDArray[np.float64]:
    """Weighted sums over the corners of one cell a point, in batches.

    Parameters
    ----------
    flat : (n,) ndarray
    base : (...) int
        Index of the lowest corner.
    corners : list of (step, weight)
        Step to the upper node in `flat`, and its weight, for each axis on which the corners differ.
    """
    lowest = np.broadcast_to(base, shape).reshape(-1)
    moves = [(np.broadcast_to(step, shape).reshape(-1), np.broadcast_to(w, shape).reshape(-1)) for step, w in corners]
    result = np.empty(lowest.size)
    for start in range(0, lowest.size, BATCH):
        part = slice(start, start + BATCH)
        index = np.empty((1 << len(moves), lowest[part].size), np.intp)
        index[0] = lowest[part]
        for k, (step, _) in enumerate(moves):
            np.add(index[: 1 << k], step[part], out=index[1 << k : 2 << k])
        sums = flat.take(index).astype(float)
        for _, weight in reversed(moves):  # the axis added last parts the corners into halves
            half = sums.shape[0] // 2
            lower, upper = sums[:half], sums[half:]
            lower *= 1.0 - weight[part]
            upper *= weight[part]
            lower += upper
            sums = lower
        result[part] = sums[0]
    return result.reshape(shape)
