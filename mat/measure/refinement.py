"""Nodes where the error is: the fewest on each axis that hold a tolerance of linear interpolation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skyshine.schemas.arrays import Floats, Integers

ALLOWED_SHARE = 0.01  # of the places in a cell may be worse than allowed, up to twice


def fewest_nodes(places: Floats, error: Callable[[int, int], Floats], allowed: float) -> Integers:
    """The fewest of ordered places that serve as nodes: from each, the farthest next one whose cell holds.

    Parameters
    ----------
    places : (n,) array
        Candidates, increasing; the first and the last are always nodes.
    error : callable
        error(a, b) gives the errors (..., b - a - 1) at the places between the a-th and the b-th where those two are
        nodes; not a number counts as none.
    allowed : float
        Error that `ALLOWED_SHARE` of the places of a cell may exceed, none more than twofold.

    Returns
    -------
    (k,) int array
        Indices of the nodes.

    Notes
    -----
    A cell inside a cell that holds is taken to hold too. Between neighbouring candidates nothing is known, and nothing
    refused.
    """
    nodes, last = [0], len(places) - 1
    while nodes[-1] < last:
        start = nodes[-1]
        reach, step = start + 1, 1
        while reach < last and holds(error(start, min(reach + step, last)), allowed):
            reach = min(reach + step, last)
            step *= 2
        while step > 1:
            step //= 2
            if reach + step <= last and holds(error(start, reach + step), allowed):
                reach += step
        nodes.append(reach)
    return np.array(nodes)


def holds(error: Floats, allowed: float) -> bool:
    """Whether errors keep to what is allowed: all but `ALLOWED_SHARE` within it, none beyond twice."""
    size = np.abs(error[np.isfinite(error)])
    if not size.size:
        return True
    return float(size.max()) <= 2 * allowed and float(np.mean(size > allowed)) <= ALLOWED_SHARE
