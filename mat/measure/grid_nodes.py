"""Nodes of tables on five axes by tolerance: cells are halved where linear interpolation between channels' values errs.

The error of one axis at a place is the difference between the quantity there and its linear interpolation between the
two neighbours on that axis alone, both read from the channels. Each cell in which 99 % of such errors exceed the axis's
part of the tolerance is halved, until none does or the table would be too large. The error of the whole table is then
measured at other places.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import VALID, tables_on_axes
from skyshine.mat.tables.gridded import AXES, FIELDS, QUANTITIES, Gridded
from skyshine.schemas.arrays import Floats

LINES, TEST_LINES = 6000, 4000  # places on which cells are halved in each pass, and on which the table is measured
PASSES = 12  # rounds at most, each of which halves the cells that are too wide
PART = 0.4  # fraction of the tolerance, which one axis may leave in 99 % of the reads of a cell
_NEAREST_KM = 1e-3  # least range and height of the lowest observer, in whose logarithm places are drawn
_START = {"range": 6, "altitude": 4, "elevation": 9, "source_elevation": 5, "source_azimuth": 4}
_HORIZON = 10.0  # degree, within which half of the lines lie that do not end at the ground


@dataclass(frozen=True, eq=False)
class PlacedGrid:
    """Tables on five axes.

    Attributes
    ----------
    tables : dict of str to Gridded
        Tables by the names of `gridded.QUANTITIES`.
    errors : dict of str to (n,) array
        Errors of each at random places, in the scale's unit.
    quantity_errors : dict of str to (n,) array
        The same in the quantity's unit.
    """

    tables: dict[str, Gridded]
    errors: dict[str, Floats]
    quantity_errors: dict[str, Floats]

    @property
    def p99(self) -> float:
        """99 % of the errors of the worst quantity."""
        return max(float(np.percentile(np.abs(error), 99)) for error in self.errors.values())


def placed_grid(air: AtmosphereTable, scale: Scale, tolerance: float, *, most_nodes: int, seed: int) -> PlacedGrid:
    """Tables on five axes that meet a tolerance, or come as close to it as their size allows.

    Parameters
    ----------
    scale : Scale
        What the tolerance counts.
    tolerance : float
        Error of 99 % of the reads.
    most_nodes : int
        Nodes of the largest table, that of path radiance.
    """
    generator = np.random.default_rng([seed, 0])
    nodes = {name: _start(air, name) for name in AXES}
    for _ in range(PASSES):
        points = drawn_points(air, LINES, generator)
        wide = {name: _wide_cells(air, nodes, name, points, scale, PART * tolerance) for name in AXES}
        if not any(cells.any() for cells in wide.values()):
            break
        halved = {name: _halved(nodes[name], cells) for name, cells in wide.items()}
        if prod(axis.size for axis in halved.values()) > most_nodes:
            break
        nodes = halved
    tables = tables_on_axes(air, PathGrid(**dict(zip(FIELDS, nodes.values(), strict=True))))
    points = drawn_points(air, TEST_LINES, generator)
    quantity_errors = {name: tables[name].read(points) - _value(air, name, points) for name in QUANTITIES}
    errors = {name: _error(air, scale, name, tables[name].read(points), points) for name in QUANTITIES}
    return PlacedGrid(tables, errors, quantity_errors)


def drawn_points(air: AtmosphereTable, count: int, generator: np.random.Generator) -> dict[str, Floats]:
    """Places (n,) by axis as scenes look: a third of the lines ends at the ground."""
    ground = float(air.attributes["ground_altitude_km"])
    (near, far), (low, high) = (np.asarray(air.attributes[name], float) for name in ("range_km", "altitude_km"))
    heights = np.maximum(np.array([low, high]) - ground, _NEAREST_KM)
    height = np.exp(generator.uniform(np.log(heights[0]), np.log(heights[1]), count))
    reach = np.exp(generator.uniform(np.log(max(near, _NEAREST_KM)), np.log(far), count))
    elevation = np.degrees(np.arcsin(generator.uniform(-1, 1, count)))
    level = generator.random(count) < 0.5
    elevation = np.where(level, generator.uniform(-_HORIZON, _HORIZON, count), elevation)
    down = generator.random(count) < 1 / 3
    steep = np.clip(height / np.maximum(reach, height), 0.0, 1.0)  # on a plane; the line ends a little before it
    elevation = np.where(down & (reach >= height), -np.degrees(np.arcsin(steep)), elevation)
    sources = np.asarray(air.root.axes["source_elevation"].values, float)
    points = {
        "range": reach,
        "altitude": np.clip(ground + height, low, high),
        "elevation": elevation,
        "source_elevation": generator.uniform(sources[0], sources[-1], count),
        "source_azimuth": 180.0 * generator.random(count) ** 2,  # more of them towards the source
    }
    line: dict[str, Any] = {name: points[name] for name in AXES[:3]}
    inside = air.value(VALID, **line) > 0
    return {name: values[inside] for name, values in points.items()}


def _start(air: AtmosphereTable, name: str) -> Floats:
    """Few nodes from end to end: of ranges and heights in the logarithm."""
    count = _START[name]
    if name == "range":
        near, far = (float(value) for value in air.attributes["range_km"])
        return np.unique([near, *np.geomspace(max(near, _NEAREST_KM), far, count)[1:]])
    if name == "altitude":
        ground = float(air.attributes["ground_altitude_km"])
        low, high = (float(value) for value in air.attributes["altitude_km"])
        heights = np.geomspace(max(low - ground, _NEAREST_KM), max(high - ground, _NEAREST_KM), count)[1:-1]
        return np.unique(np.clip([low, *(ground + heights), high], low, high))
    if name == "elevation":
        return np.array([-90, -30, -10, -3, 0, 3, 10, 30, 90], float)
    if name == "source_azimuth":
        return np.array([0.0, 20.0, 60.0, 180.0])
    nodes = np.asarray(air.root.axes[name].values, float)
    return np.unique(np.linspace(nodes[0], nodes[-1], count))


def _value(air: AtmosphereTable, quantity: str, points: dict[str, Floats]) -> Floats:
    where: dict[str, Any] = {name: points[name] for name in AXES[: QUANTITIES[quantity][1]]}
    return air.value(quantity, **where)


def _error(air: AtmosphereTable, scale: Scale, quantity: str, read: Floats, points: dict[str, Floats]) -> Floats:
    """Errors (n,) of values read at places, in the scale's unit."""
    through = air.transmittance(range=points["range"], beta_star=_value(air, "beta_star", points))
    return scale.error(quantity, read, _value(air, quantity, points), through, points["range"])


def _wide_cells(
    air: AtmosphereTable,
    nodes: dict[str, Floats],
    axis: str,
    points: dict[str, Floats],
    scale: Scale,
    allowed: float,
) -> np.ndarray:
    """Cells (n - 1,) of an axis in which interpolation along it alone errs by more than is allowed in 99 % of reads."""
    at = nodes[axis]
    wide = np.zeros(max(at.size - 1, 0), bool)
    if at.size < 2:
        return wide
    cell = np.clip(np.searchsorted(at, points[axis], side="right") - 1, 0, at.size - 2)
    share = (points[axis] - at[cell]) / (at[cell + 1] - at[cell])
    ends = [points | {axis: at[cell + step]} for step in (0, 1)]
    for name, (_, count) in QUANTITIES.items():
        if axis not in AXES[:count]:
            continue
        low, high = (_value(air, name, end) for end in ends)
        error = np.abs(_error(air, scale, name, low * (1 - share) + high * share, points))
        for number in np.flatnonzero(~wide):
            reads = error[cell == number]
            wide[number] = reads.size > 0 and np.percentile(reads, 99) > allowed
    return wide


def _halved(nodes: Floats, cells: np.ndarray) -> Floats:
    """Nodes with one more in the middle of some cells."""
    middle = (nodes[1:] + nodes[:-1]) / 2
    return np.sort(np.concatenate([nodes, middle[cells]]))
