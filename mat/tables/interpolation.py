"""Multilinear interpolation on tables, vectorised over query points."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from skyshine.mat.tables.axes import AxisRule
from skyshine.schemas.errors import InputError, nearest


def interpolate(values: np.ndarray, rules: Sequence[AxisRule], where: Mapping[str, np.ndarray]) -> np.ndarray:
    """Linear interpolation in every axis of a table.

    Parameters
    ----------
    values : (n1, n2, ...) ndarray
    rules : one AxisRule for each axis of `values`
    where : mapping of axis name to values
        Broadcast against each other; axes of one node may be left out.

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
    corners = []
    for rule in rules:
        if rule.name not in where and rule.nodes.size > 1:
            raise InputError(f"the axis '{rule.name}' is missing; give a value for it")
        corners.append(rule.locate(np.asarray(where.get(rule.name, rule.nodes[0]))))
    shape = np.broadcast_shapes(*(lower.shape for lower, _, _ in corners))
    result = np.zeros(shape)
    moving = [bool(np.any(weight != 0)) for _, _, weight in corners]
    for choice in itertools.product(*((0, 1) if moves else (0,) for moves in moving)):
        index = tuple(upper if up else lower for up, (lower, upper, _) in zip(choice, corners))
        share = np.ones(())
        for up, (_, _, weight) in zip(choice, corners):
            share = share * (weight if up else 1.0 - weight)
        result = result + share * values[index]
    return result
