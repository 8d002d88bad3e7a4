"""Nodes where the error is: the fewest on each axis that hold a tolerance of linear interpolation."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

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


def uniform_nodes(places: Floats, error_of: Callable[[Floats], Floats], allowed: float, max_nodes: int) -> int:
    """Number of equally spaced nodes with 99 % of the errors within the same: the smallest of a sequence that grows by
    a quarter.

    Parameters
    ----------
    places : (n,) array
        First and last are the ends.
    error_of : callable
        Errors at all places for the nodes given.
    allowed : float
        See `percentile_99`.
    max_nodes : int
        Result where even these are not enough.
    """
    count = 2
    while count < max_nodes:
        if percentile_99(error_of(np.linspace(places[0], places[-1], count))) <= allowed:
            return count
        count += max(1, count // 4)
    return max_nodes


def holds(error: Floats, allowed: float) -> bool:
    """Whether errors keep to what is allowed: all but `ALLOWED_SHARE` within it, none beyond twice."""
    size = np.abs(error[np.isfinite(error)])
    if not size.size:
        return True
    return float(size.max()) <= 2 * allowed and float(np.mean(size > allowed)) <= ALLOWED_SHARE


def percentile_99(error: Floats) -> float:
    """Of the size of errors; those that are not a number count as none."""
    size = np.abs(error[np.isfinite(error)])
    return float(np.percentile(size, 99)) if size.size else 0.0


def subdivided(nodes: npt.ArrayLike, parts: int, logarithmic: bool = False) -> Floats:
    """Each cell of an axis cut into equal parts, in the logarithm where both ends are above 0 and it is asked for."""
    nodes = np.asarray(nodes, float)
    share = np.arange(1, parts + 1) / parts
    pieces = [nodes[:1]]
    for low, high in itertools.pairwise(nodes):
        inside = low * (high / low) ** share if logarithmic and low > 0 else low + (high - low) * share
        inside[-1] = high
        pieces.append(inside)
    return np.concatenate(pieces)
