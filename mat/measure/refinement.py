"""Nodes where the error is: the fewest on each axis that meet a tolerance of linear interpolation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skyshine.schemas.arrays import Floats, Integers

ALLOWED_SHARE = 0.01  # fraction of the candidates in a cell that may exceed the allowed error, up to twice


def fewest_nodes(candidates: Floats, error: Callable[[int, int], Floats], allowed: float) -> Integers:
    """The fewest ordered candidates that serve as nodes: after each, the farthest one whose cell meets the tolerance.

    Parameters
    ----------
    candidates : (n,) array
        Candidates, increasing; the first and the last are always nodes.
    error : callable
        error(a, b) gives the errors (..., b - a - 1) at the candidates between the a-th and the b-th where those two
        are nodes; not a number counts as none.
    allowed : float
        Error that `ALLOWED_SHARE` of the candidates of a cell may exceed, none more than twofold.

    Returns
    -------
    (k,) int array
        Indices of the nodes.

    Notes
    -----
    A cell inside a cell that meets the tolerance is assumed to meet it too. Between neighbouring candidates nothing is
    known, and nothing is refused.
    """
    nodes, end = [0], len(candidates) - 1
    while nodes[-1] < end:
        start = nodes[-1]
        reach, step = start + 1, 1
        while reach < end and meets(error(start, min(reach + step, end)), allowed):
            reach = min(reach + step, end)
            step *= 2
        while step > 1:
            step //= 2
            if reach + step <= end and meets(error(start, reach + step), allowed):
                reach += step
        nodes.append(reach)
    return np.array(nodes)


def meets(error: Floats, allowed: float) -> bool:
    """Whether errors keep to what is allowed: all but `ALLOWED_SHARE` within it, none beyond twice."""
    size = np.abs(error[np.isfinite(error)])
    if not size.size:
        return True
    return float(size.max()) <= 2 * allowed and float(np.mean(size > allowed)) <= ALLOWED_SHARE
