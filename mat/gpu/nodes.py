"""Nodes of texture axes: those between which linear interpolation of given functions errs least, the best first."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from skyshine.schemas.arrays import Floats, Integers


def insertion_order(candidates: Floats, values: Floats, initial: Integers, max_count: int) -> tuple[Integers, Floats]:
    """Candidates in the order in which they lower the largest error of linear interpolation.

    Parameters
    ----------
    candidates : (n,) array
        Ascending.
    values : (n, q) array
        Values of the functions at the candidates.
    initial : array of int
        Indices of nodes that are taken from the beginning, with both ends.
    max_count : int
        Nodes to stop at.

    Returns
    -------
    order : (k,) int array
        `initial`, then the nodes added, best first.
    error : (k,) array
        Largest error with the nodes up to that one; infinite for fewer than `initial`.
    """
    nodes = sorted({int(index) for index in initial})
    order, error = list(nodes), [np.inf] * (len(nodes) - 1)
    residual = np.zeros(candidates.size)
    for low, high in pairwise(nodes):
        residual[low : high + 1] = _missed(candidates, values, low, high)
    error.append(float(residual.max(initial=0.0)))
    while len(order) < max_count and error[-1] > 0:
        candidate = int(residual.argmax())
        position = int(np.searchsorted(nodes, candidate))
        low, high = nodes[position - 1], nodes[position]
        nodes.insert(position, candidate)
        order.append(candidate)
        for start, stop in ((low, candidate), (candidate, high)):
            residual[start : stop + 1] = _missed(candidates, values, start, stop)
        error.append(float(residual.max()))
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
    fewest = [int(np.isinf(error).sum()) + 1 for error in errors]
    best, counts = np.inf, (fewest[0], fewest[1])
    for count in range(fewest[0], enough[0] + 1):
        second = min(texels // count, enough[1])
        if second < fewest[1]:
            break
        total = errors[0][count - 1] + errors[1][second - 1]
        if total < best:
            best, counts = total, (count, second)
    return counts
