"""The error of linear interpolation in a table, measured off its nodes at random."""

from __future__ import annotations

import numpy as np


def random_places(nodes: np.ndarray, count: int, generator: np.random.Generator) -> np.ndarray:
    """Random places (count,) on an axis, every cell as likely as every other; an axis of one node gives that node."""
    nodes = np.asarray(nodes, float)
    if nodes.size == 1:
        return np.full(count, nodes[0])
    cell = generator.integers(nodes.size - 1, size=count)
    return nodes[cell] + generator.random(count) * (nodes[cell + 1] - nodes[cell])
