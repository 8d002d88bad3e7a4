"""Nodes of texture axes: those between which linear interpolation of given functions errs least, the best first."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from skyshine.schemas.arrays import Floats, Integers


def insertion_order(candidates: Floats, values: Floats, first: Integers, most: int) -> tuple[Integers, Floats]:
    """Candidates in the order in which they lower the largest error of linear interpolation.

    Parameters
    ----------
    candidates : (n,) array
        Ascending.
    values : (n, q) array
        Of the functions at the candidates.
    first : array of int
        Indices of nodes that stand from the beginning, with both ends.
    most : int
        Nodes to stop at.

    Returns
    -------
    order : (k,) int array
        `first`, then the nodes added, best first.
    error : (k,) array
        Largest error with the nodes up to that one; infinite for fewer than `first`.
    """
    nodes = sorted({int(index) for index in first})
    order, error = list(nodes), [np.inf] * (len(nodes) - 1)
    missed = np.zeros(candidates.size)
    for low, high in pairwise(nodes):
        missed[low : high + 1] = _missed(candidates, values, low, high)
    error.append(float(missed.max(initial=0.0)))
    while len(order) < most and error[-1] > 0:
        worst = int(missed.argmax())
        place = int(np.searchsorted(nodes, worst))
        low, high = nodes[place - 1], nodes[place]
        nodes.insert(place, worst)
        order.append(worst)
        for start, stop in ((low, worst), (worst, high)):
            missed[start : stop + 1] = _missed(candidates, values, start, stop)
        error.append(float(missed.max()))
    return np.array(order), np.array(error)


def _missed(candidates: Floats, values: Floats, low: int, high: int) -> Floats:
    """Largest error of each candidate between two nodes."""
    part, width = candidates[low : high + 1], candidates[high] - candidates[low]
    weight = ((part - part[0]) / width)[:, None] if width > 0 else np.zeros((part.size, 1))
    line = values[low] * (1 - weight) + values[high] * weight
    return np.asarray(np.abs(values[low : high + 1] - line).max(axis=1))


def best_counts(errors: tuple[Floats, Floats], texels: int, tolerance: float) -> tuple[int, int]:
    """Numbers of nodes of two axes whose product is at most `texels`, with the least sum of errors.

    No more nodes are taken than `tolerance` needs on each axis.
    """
    enough = [int(np.argmax(error <= tolerance)) + 1 if np.any(error <= tolerance) else error.size for error in errors]
    least = [int(np.isinf(error).sum()) + 1 for error in errors]
    best, found = np.inf, (least[0], least[1])
    for count in range(least[0], enough[0] + 1):
        other = min(texels // count, enough[1])
        if other < least[1]:
            break
        total = errors[0][count - 1] + errors[1][other - 1]
        if total < best:
            best, found = total, (count, other)
    return found
