"""Nodes of a database in channels by tolerance: the fewest, of a family of grids, that hold it.

The grid is measured on random lines of sight. Where it does not hold, every second node of each part of each axis is
left out in turn: what that changes of the reads on the lines is three times the error that the part leaves, for linear
interpolation errs with the square of the step. Each part then grows by what its error asks for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skyshine.mat.measure.probes import Probes
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.channels.coordinates import LEVEL
from skyshine.mat.quantities.channels.nodes import NodeCounts
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.tables.channel_table import ChannelTable
from skyshine.mat.tables.channels import NODES
from skyshine.mat.tables.gridded import QUANTITIES
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.hdf5 import Axis, Group, Variable

_PASSES = 8
_MARGIN, _WORST = 0.95, 2.8  # tolerances that 99 % of the reads hold, and all: others are a little worse
_PART = 0.45  # of the tolerance, which a part may leave before it grows
_WORST_SHARE = 2.0  # tolerances that a part may leave of the worst reads, over what it may leave of 99 %
_GROWTH = 2.0  # of a part in one pass, at most
_LEAST_GROWTH = 1.2
_GAIN = 0.85  # of the error of the pass before, which more nodes must leave at most
_WORST_LINES, _OTHER_LINES = 40, 60  # on which parts are blamed
_OF_PATHS = ("beta_star", "path_radiance_ratio")


@dataclass(frozen=True)
class ChannelQuantity:
    """One quantity of a database in channels, read as the tables of `Probes` are.

    Attributes
    ----------
    table : ChannelTable
    name : str
    """

    table: ChannelTable
    name: str

    def read(self, places: dict[str, Floats]) -> Floats:
        """Values at places by the names of `gridded.AXES`."""
        names = {rule.name for rule in self.table.rules(self.name)}
        where = {name: values for name, values in places.items() if name in names}
        return self.table.value(self.name, out_of_range="clamp", **where)


@dataclass(frozen=True)
class PlacedChannels:
    """A database in channels that holds a tolerance.

    Attributes
    ----------
    table : ChannelTable
    counts : NodeCounts
    p99, maximum : float
        Of the error at random points, over all quantities, in the tolerance's unit.
    """

    table: ChannelTable
    counts: NodeCounts
    p99: float
    maximum: float


def quantities_of(table: ChannelTable) -> dict[str, ChannelQuantity]:
    """The four quantities of a table."""
    return {name: ChannelQuantity(table, name) for name in QUANTITIES}


def placed_channels(
    table_of: Callable[[NodeCounts], ChannelTable],
    probes_of: Callable[[], Sequence[Probes]],
    scale: Scale,
    tolerance: float,
    *,
    max_nodes: int,
) -> PlacedChannels:
    """The fewest nodes that hold a tolerance.

    Parameters
    ----------
    table_of : callable
        The table with some numbers of nodes.
    probes_of : callable
        Fresh random lines of sight with the quantities on them, in groups that hold the tolerance each; the first with
        all quantities, the others with those of paths alone.
    scale : Scale
        In what the tolerance counts.
    tolerance : float
        Of 99 % of the reads of each quantity; the worst is within three times.
    max_nodes : int
        Of one field.

    Raises
    ------
    CheckFailed
        The tolerance cannot be held with so many nodes.
    """
    counts, p99, worst, over = NodeCounts(), np.inf, np.inf, np.inf
    tried = counts.size
    for _ in range(_PASSES):
        if counts.size > max_nodes:
            break
        before, tried = over, counts.size
        table, (all_around, *others) = table_of(counts), probes_of()
        tables = quantities_of(table)
        measured = list(all_around.errors(tables, scale).values())
        for probes in others:
            measured += probes.errors({name: tables[name] for name in _OF_PATHS}, scale).values()
        errors = [np.abs(error) for error in measured if error.size]
        p99 = max((float(np.percentile(error, 99)) for error in errors), default=0.0)
        worst = max((float(error.max()) for error in errors), default=0.0)
        if p99 <= _MARGIN * tolerance and worst <= _WORST * tolerance:
            return PlacedChannels(table, counts, p99, worst)
        over = max(p99 / _MARGIN, worst / _WORST) / tolerance
        if over > _GAIN * before:
            break  # what errs is not what nodes hold
        counts = _grown(counts, table, [all_around, *others], scale, tolerance)
    raise CheckFailed(
        f"atmosphere_grid.tolerance {tolerance:g} cannot be held in channels: {tried:,} nodes a field leave an"
        f" error of {p99:.2g} (99 %), {worst:.2g} (worst); raise it, allow more with atmosphere_grid.most_nodes, or"
        " write layout: classic"
    )


def _grown(
    counts: NodeCounts, table: ChannelTable, groups: Sequence[Probes], scale: Scale, tolerance: float
) -> NodeCounts:
    """More nodes on the parts that leave too much on the worst lines and on some others."""
    few = [_lines(probes, _worst_lines(table, probes, scale)) for probes in groups]
    whole = _reads(table, few, scale)
    left: dict[str, float] = {}
    for name in NodeCounts.names():
        coarse = _reads(_without_every_second(table, name), few, scale)
        errors = [np.abs(a - b) / 3 for a, b in zip(coarse, whole, strict=True)]
        left[name] = max(
            max(float(np.percentile(error, 99)), float(error.max()) / _WORST_SHARE) / tolerance for error in errors
        )
    limit = min(_PART, max(left.values()))
    grown = counts
    for name, error in left.items():
        if error >= limit:
            grown = grown.grown(name, float(np.clip(np.sqrt(error / _PART), _LEAST_GROWTH, _GROWTH)))
    return grown


def _worst_lines(table: ChannelTable, probes: Probes, scale: Scale) -> Integers:
    """Numbers of the lines of sight with the largest errors, and of some others."""
    tables, worst = quantities_of(table), np.zeros(len(probes.truth.transmittance))
    for name in _OF_PATHS:
        error = np.abs(probes.error(name, tables[name], scale))
        seen = np.where(probes.above_ground(name, error), error, 0.0)
        worst = np.maximum(worst, seen.reshape(worst.size, -1).max(axis=1))
    lines: Integers = np.union1d(np.argsort(worst)[-_WORST_LINES:], np.arange(min(_OTHER_LINES, worst.size)))
    return lines


def _lines(probes: Probes, lines: Integers) -> Probes:
    """Some lines of probes, without ambient light, which the nodes of paths hardly change."""
    truth: dict[str, Any] = {
        name: None if values is None or name == "ambient" else values[lines]
        for name, values in vars(probes.truth).items()
    }
    places = {name: values[lines] for name, values in probes.places.items()}
    return replace(probes, places=places, ambient_at=probes.ambient_at[:0], truth=AtmosphericQuantities(**truth))


def _reads(table: ChannelTable, groups: Sequence[Probes], scale: Scale) -> list[Floats]:
    """Errors of transmittance and of path radiance at the probes above the ground."""
    tables = quantities_of(table)
    of_paths = {name: tables[name] for name in _OF_PATHS}
    return [error for probes in groups for error in probes.errors(of_paths, scale).values()]


def _without_every_second(table: ChannelTable, part: str) -> ChannelTable:
    """The table with every second node of a part of an axis left out, but for its ends."""
    root = table.root
    direction = np.asarray(root.axes["direction"].values)
    axis = {"share": "share", "height": "height_root"}.get(part, "direction")
    nodes = np.asarray(root.axes[axis].values)
    inside = {
        "ground": direction <= 1,
        "limb": (direction > 1) & (direction <= LEVEL),
        "upward": direction >= LEVEL,
    }.get(part, np.ones(nodes.size, bool))
    of_part = np.flatnonzero(inside)
    dropped = of_part[1:-1:2]
    kept: Integers = np.setdiff1d(np.arange(nodes.size), dropped)

    def cut(variable: Variable) -> Variable:
        if axis not in variable.dims or not set(variable.dims) & set(NODES):
            return variable
        return replace(variable, data=np.take(np.asarray(variable.data), kept, axis=variable.dims.index(axis)))

    old: Axis = root.axes[axis]
    axes = root.axes | {axis: replace(old, values=nodes[kept])}
    variables = {name: cut(variable) for name, variable in root.variables.items()}
    return replace(table, root=Group(axes, variables, root.groups, root.attributes))
