"""Random places between the nodes of an axis, every cell as likely as every other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats


def random_places(nodes: npt.ArrayLike, count: int, generator: np.random.Generator) -> Floats:
    """Random places (count,) on an axis, every cell as likely as every other; an axis of one node gives that node."""
    nodes = np.asarray(nodes, float)
    if nodes.size == 1:
        return np.full(count, nodes[0])
    cell = generator.integers(nodes.size - 1, size=count)
    places: Floats = nodes[cell] + generator.random(count) * (nodes[cell + 1] - nodes[cell])
    return places
