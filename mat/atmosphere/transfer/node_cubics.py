"""Weights of values at nodes for places between them: piecewise cubics, computed once for all places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats, Integers

_WIDTH = 4  # nodes of a cubic


@dataclass(frozen=True, eq=False)
class NodeCubics:
    """Cubic through the four nodes around a place, or a straight line where a part has fewer.

    Attributes
    ----------
    nodes : (X,) array
        Increasing.
    first_node : (X,) int array
        First of the W nodes that have a weight from each node on.
    coefficient : (X, W, 4) array
        Coefficients of the powers, from 0 on, of the distance from each node, in the weights of the W nodes from
        `first_node` on.

    Examples
    --------
    >>> first, weight = NodeCubics.of(np.arange(5.0)).weights(np.array([0.5, 4.0]))
    >>> first.tolist(), (weight + 0.0).round(4).tolist()
    ([0, 1], [[0.3125, 0.9375, -0.3125, 0.0625], [0.0, 0.0, 0.0, 1.0]])
    """

    nodes: Floats
    first_node: Integers
    coefficient: Floats

    @classmethod
    def of(cls, nodes: Floats, ends: Sequence[int] = ()) -> NodeCubics:
        """Cubics through nodes; each part, up to the next of `ends`, has cubics of its own."""
        width = min(_WIDTH, nodes.size)
        first_node, coefficient = np.zeros(nodes.size, int), np.zeros((nodes.size, width, _WIDTH))
        start = 0
        for stop in (*ends, nodes.size):
            for lower in range(start, stop):
                count = _WIDTH if stop - start >= _WIDTH else min(stop - start, 2)
                low = min(max(lower - (count - 1) // 2, start), stop - count)
                first_node[lower] = min(low, nodes.size - width)
                there = nodes[low : low + count] - nodes[lower]
                for i in range(count):
                    others = np.delete(there, i)
                    polynomial = np.polynomial.polynomial.polyfromroots(others) / np.prod(there[i] - others)
                    coefficient[lower, low - first_node[lower] + i, :count] = polynomial
            start = stop
        return cls(nodes, first_node, coefficient)

    def weights(self, coordinates: Floats) -> tuple[Integers, Floats]:
        """First node (K,) and weights (K, W) of the W nodes from it on, for places (K,) no farther than the nodes."""
        lower = np.maximum(np.searchsorted(self.nodes, coordinates, side="right") - 1, 0)
        step = coordinates - self.nodes[lower]
        square = step * step
        powers = np.stack([np.ones_like(step), step, square, square * step], axis=1)
        return self.first_node[lower], (self.coefficient[lower] @ powers[:, :, None])[:, :, 0]
