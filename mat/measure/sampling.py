"""Random coordinates between the nodes of an axis, every cell as likely as every other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats


def random_coordinates(nodes: npt.ArrayLike, count: int, generator: np.random.Generator) -> Floats:
    """Random coordinates (count,) on an axis; all cells are equally likely, and an axis of one node gives that node."""
    nodes = np.asarray(nodes, float)
    if nodes.size == 1:
        return np.full(count, nodes[0])
    cell = generator.integers(nodes.size - 1, size=count)
    values: Floats = nodes[cell] + generator.random(count) * (nodes[cell + 1] - nodes[cell])
    return values
