"""Random places and lines of sight between the nodes of axes, every cell as likely as every other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.grid import PathGrid
from skyshine.schemas.arrays import Floats, Integers


def random_places(nodes: npt.ArrayLike, count: int, generator: np.random.Generator) -> Floats:
    """Random places (count,) on an axis, every cell as likely as every other; an axis of one node gives that node."""
    nodes = np.asarray(nodes, float)
    if nodes.size == 1:
        return np.full(count, nodes[0])
    cell = generator.integers(nodes.size - 1, size=count)
    places: Floats = nodes[cell] + generator.random(count) * (nodes[cell + 1] - nodes[cell])
    return places


def lines_in_cells(base: PathGrid, count: int, generator: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Altitude, elevation (n,) and ranges (n, R) of lines, as many in each cell of altitude and elevation, a range in
    each cell of ranges.
    """
    cells = max(1, base.altitude_km.size - 1), max(1, base.elevation_deg.size - 1)
    turn = generator.permutation(cells[0] * cells[1])[np.arange(count) % (cells[0] * cells[1])]
    altitude, elevation = (
        _in_cell(nodes, cell, generator)
        for nodes, cell in zip((base.altitude_km, base.elevation_deg), np.divmod(turn, cells[1]), strict=True)
    )
    steps = max(1, base.range_km.size - 1)
    return altitude, elevation, _in_cell(base.range_km, np.broadcast_to(np.arange(steps), (count, steps)), generator)


def _in_cell(nodes: Floats, cell: Integers, generator: np.random.Generator) -> Floats:
    """A random place in each of some cells of an axis; an axis of one node gives that node."""
    if nodes.size == 1:
        return np.full(np.shape(cell), nodes[0])
    places: Floats = nodes[cell] + generator.random(np.shape(cell)) * (nodes[cell + 1] - nodes[cell])
    return places
