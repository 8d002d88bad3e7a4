"""Nodes of a database in channels by tolerance: refined where the error is largest, until random lines of sight meet
it.

Where a table misses the tolerance, every second node of each part of each axis is removed in turn. What that changes of
a read is three times the error that the part leaves there, for linear interpolation errs with the square of the step.
So each interval of each part gets the number of nodes that its cell_reads worst reads ask for, more or fewer than it
had.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skyshine.mat.measure.probes import OF_PATHS, Probes
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.channels.coordinates import LEVEL
from skyshine.mat.quantities.channels.nodes import ChannelNodes
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.gridded import QUANTITIES
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.hdf5 import Axis, Group, Variable

_PASSES = 8  # refinements at most
WORST = 3.0  # tolerances, which the worst reads may err
_MARGIN, _WORST = 0.95, 2.8  # tolerances that 99 % of the reads are within, and nearly all: others are a little worse
_NEARLY_ALL = 99.98  # % of the reads
_PART = 0.4  # fraction of the tolerance, which an interval of a part may leave in 99 % of its reads
_TIGHTER = 0.7  # fraction of that part, once, where a pass has gained too little
_WORST_SHARE = 2.0  # tolerances that it may leave in its worst read, over what it may leave in 99 %
_THINNED, _GROWTH = 0.7, 4.0  # intervals for one, in one pass
_IDLE = 0.5  # fraction of the nodes that an interval has: where it needs fewer, it is thinned
_STEADY = 0.75  # fraction of its neighbours' growth, which an interval grows by at least
_WORTH = 0.8  # fraction of the nodes, at most, for which those within the tolerance are thinned once more
_GAIN = 0.85  # fraction of the error of the pass before, which more nodes must leave at most
_WORST_LINES, _OTHER_LINES = 80, 160  # on which parts are blamed
_SOURCE = ("source_elevation", "scattering_angle")  # axes of path radiance alone


@dataclass(frozen=True)
class ChannelQuantity:
    """One quantity of a database in channels, read as the tables of `Probes` are."""

    table: AtmosphereTable
    name: str

    def read(self, coordinates: dict[str, Floats]) -> Floats:
        """Values at coordinates by the names of `gridded.AXES`."""
        names = {rule.name for rule in self.table.rules(self.name)}
        where = {name: values for name, values in coordinates.items() if name in names}
        return self.table.value(self.name, **where)


@dataclass(frozen=True)
class PlacedChannels:
    """A database in channels that meets a tolerance.

    Attributes
    ----------
    p99, largest : float
        99 and 99.98 % of the errors at random points, of the worst quantity, in the tolerance's unit.
    """

    table: AtmosphereTable
    nodes: ChannelNodes
    p99: float
    largest: float


def quantities_of(table: AtmosphereTable) -> dict[str, ChannelQuantity]:
    """The four quantities of a table, beyond its axes those at their ends."""
    clamped = table.clamped()
    return {name: ChannelQuantity(clamped, name) for name in QUANTITIES}


def placed_channels(
    table_of: Callable[[ChannelNodes], AtmosphereTable],
    probes: Sequence[Probes],
    nodes: ChannelNodes,
    scale: Scale,
    tolerance: float,
    *,
    max_nodes: int,
    fewest: bool = False,
    insist: bool = True,
) -> PlacedChannels:
    """Few nodes that meet a tolerance.

    Parameters
    ----------
    table_of : callable
        The table on some nodes.
    probes : sequence of Probes
        Random lines of sight with the quantities on them, in groups that meet the tolerance each; the first with all
        quantities, the others with those of paths alone.
    nodes : ChannelNodes
        Nodes at the start of the refinement.
    scale : Scale
        Scale in which the tolerance is measured.
    tolerance : float
        Tolerance of the 99th percentile of the reads of each quantity; all but two in ten thousand are within three
        times.
    max_nodes : int
        Maximum number of nodes of one field.
    fewest : bool
        Whether nodes are thinned further where those that meet the tolerance are more than the errors ask for.
    insist : bool
        Whether a tolerance that is not held is an error; otherwise the table is the closest of those that were tried.

    Raises
    ------
    CheckFailed
        The tolerance is insisted on, or no table was tried, and it cannot be held with so many nodes.
    """
    p99, largest, over, size, part = np.inf, np.inf, np.inf, nodes.size, _PART
    result: PlacedChannels | None = None
    closest, closest_excess = result, np.inf
    for _ in range(_PASSES):
        if nodes.size > max_nodes:
            break
        before, size, table = over, nodes.size, table_of(nodes)
        p99, largest = largest_errors(table, probes, scale)
        if p99 <= _MARGIN * tolerance and largest <= _WORST * tolerance:
            result = PlacedChannels(table, nodes, p99, largest)
            fewer = _placed_anew(nodes, table, probes, scale, _PART * tolerance) if fewest else nodes
            if fewer.size > _WORTH * nodes.size:
                break
            nodes = fewer
            continue
        if result is not None:
            break
        over = float(np.max([p99 / _MARGIN, largest / _WORST])) / tolerance
        if over < closest_excess:
            closest, closest_excess = PlacedChannels(table, nodes, p99, largest), over
        if not over <= _GAIN * before:
            if part < _PART or not np.isfinite(over):
                break  # nodes cannot reduce these errors
            part *= _TIGHTER
        nodes = _placed_anew(nodes, table, probes, scale, part * tolerance)
    result = result or (None if insist else closest)
    if result is not None:
        return result
    raise CheckFailed(
        f"atmosphere_grid.tolerance {tolerance:g} cannot be held in channels: {size:,} nodes a field leave an"
        f" error of {p99:.2g} (99 %), {largest:.2g} (worst); raise it, or allow more with"
        " atmosphere_grid.most_nodes"
    )


def largest_errors(table: AtmosphereTable, probes: Sequence[Probes], scale: Scale) -> tuple[float, float]:
    """99 and 99.98 % of the errors of a table at random points, of the worst quantity, in the scale's unit; `probes` as
    `placed_channels`.
    """
    tables, (all_around, *others) = quantities_of(table), probes
    measured = [all_around.errors(tables, scale)]
    measured += [group.errors({name: tables[name] for name in OF_PATHS}, scale) for group in others]
    # A single NaN makes these NaN, which meets no tolerance.
    p99 = float(np.max([_percentile(error, 99.0) for group in measured for error in group.values()]))
    pooled = [np.concatenate([group[name] for group in measured if name in group]) for name in tables]
    return p99, float(np.max([_percentile(error, _NEARLY_ALL) for error in pooled]))


def _percentile(error: Floats, share: float) -> float:
    return float(np.percentile(np.abs(error), share)) if error.size else 0.0


def _placed_anew(
    nodes: ChannelNodes, table: AtmosphereTable, groups: Sequence[Probes], scale: Scale, allowed: float
) -> ChannelNodes:
    """Nodes of which each interval leaves what is allowed, by the reads on the worst lines and on some others."""
    subsets = [_lines(probes, _worst_lines(table, probes, scale)) for probes in groups]
    errors = _errors(table, subsets, scale)
    parts = [part for part in nodes.parts() if getattr(nodes, part).size > 2]
    blamed = _blamed(
        errors, {part: _errors(_without_every_second(table, part, nodes), subsets, scale) for part in parts}
    )
    moved = nodes
    for part in parts:
        at = getattr(nodes, part)
        edges = np.append(at[:-1:2], at[-1])
        interval_error = np.full(edges.size - 1, np.nan)
        for group, probes in zip(blamed[part], subsets, strict=True):
            where = _coordinates(table, probes)[part]
            for name, values in group.items():
                if part not in _SOURCE or name == "path_radiance_ratio":
                    interval_error = np.fmax(
                        interval_error, _by_interval(edges, np.broadcast_to(where, values.shape), values)
                    )
        count = np.diff(np.searchsorted(at, edges))
        moved = moved.with_spacing(part, edges, count * _growth(interval_error / allowed))
    return moved


def _blamed(
    errors: Sequence[dict[str, Floats]], thinned: dict[str, Sequence[dict[str, Floats]]]
) -> dict[str, list[dict[str, Floats]]]:
    """Error of each read that each part leaves: a third of the change without every second node, and at least its
    share, among all parts, of the error that the read has.
    """
    blamed: dict[str, list[dict[str, Floats]]] = {part: [] for part in thinned}
    for number, by_quantity in enumerate(errors):
        for part in thinned:
            blamed[part].append({})
        for name, error in by_quantity.items():
            change = {part: np.abs(groups[number][name] - error) / 3 for part, groups in thinned.items()}
            total = np.maximum(sum(change.values()), np.finfo(float).tiny)
            for part, values in change.items():
                blamed[part][number][name] = np.maximum(values, values / total * np.abs(error))
    return blamed


def _by_interval(edges: Floats, at: Floats, error: Floats) -> Floats:
    """Error (n,) of the reads in each of n intervals; NaN where there is no read."""
    inside: Booleans = np.isfinite(error) & (at >= edges[0]) & (at <= edges[-1])
    interval = np.clip(np.searchsorted(edges, at[inside], side="right") - 1, 0, edges.size - 2)
    reads = error[inside]
    interval_error = np.full(edges.size - 1, np.nan)
    for number in np.unique(interval):
        cell_reads = reads[interval == number]
        interval_error[number] = max(float(np.percentile(cell_reads, 99)), float(cell_reads.max()) / _WORST_SHARE)
    return interval_error


def _growth(over: Floats) -> Floats:
    """By what the numbers of intervals grow, of errors over those allowed; where none is known, as the neighbours."""
    measured = np.flatnonzero(np.isfinite(over))
    if not measured.size:
        return np.ones(over.size)
    factor = np.sqrt(np.interp(np.arange(over.size), measured, over[measured]))
    beside = np.maximum(np.append(factor[1:], 0.0), np.insert(factor[:-1], 0, 0.0))
    demanded = np.maximum(factor, _STEADY * beside)
    growth: Floats = np.where(demanded < _IDLE, _THINNED, np.clip(demanded, 1.0, _GROWTH))
    return growth


def _worst_lines(table: AtmosphereTable, probes: Probes, scale: Scale) -> Integers:
    """Numbers of the lines of sight with the largest errors, and of some others."""
    tables, largest = quantities_of(table), np.zeros(len(probes.truth.transmittance))
    for name in OF_PATHS:
        error = np.abs(probes.error(name, tables[name], scale))
        visible_error = np.where(probes.above_ground(name, error), error, 0.0)
        largest = np.maximum(largest, visible_error.reshape(largest.size, -1).max(axis=1))
    lines: Integers = np.union1d(np.argsort(largest)[-_WORST_LINES:], np.arange(min(_OTHER_LINES, largest.size)))
    return lines


def _lines(probes: Probes, lines: Integers) -> Probes:
    """Some lines of probes, without ambient light, which the nodes of paths hardly change."""
    truth: dict[str, Any] = {
        name: None if values is None or name == "ambient" else values[lines]
        for name, values in vars(probes.truth).items()
    }
    coordinates = {name: values[lines] for name, values in probes.coordinates.items()}
    return replace(
        probes,
        scene_lines=probes.scene_lines.some(lines),
        coordinates=coordinates,
        ambient_at=probes.ambient_at[:0],
        truth=AtmosphericQuantities(**truth),
    )


def _errors(table: AtmosphereTable, groups: Sequence[Probes], scale: Scale) -> list[dict[str, Floats]]:
    """Errors (n, R, S or 1) of transmittance and of path radiance at the probes; not a number behind the ground."""
    tables = quantities_of(table)
    return [
        {
            name: np.where(probes.above_ground(name, error), error, np.nan)
            for name in OF_PATHS
            for error in [probes.error(name, tables[name], scale)]
        }
        for probes in groups
    ]


def _coordinates(table: AtmosphereTable, probes: Probes) -> dict[str, Floats]:
    """Places of the probes on each part of each axis, (n, R, S or 1); outside its nodes where they lie in another."""
    coordinates = probes.coordinates
    at = table.rays.locate(coordinates["range"], coordinates["altitude"], coordinates["elevation"])
    return {
        "share": at.share,
        "height_root": at.height_root,
        "ground": np.where(at.to_ground, at.direction, -1.0),
        "limb": np.where(at.to_ground | (at.direction > LEVEL), -1.0, at.direction),
        "upward": np.where(at.direction >= LEVEL, at.direction, -1.0),
        "source_elevation": coordinates["source_elevation"],
        "scattering_angle": scattering_angle(
            coordinates["elevation"], coordinates["source_elevation"], coordinates["source_azimuth"]
        ),
    }


def _without_every_second(table: AtmosphereTable, part: str, nodes: ChannelNodes) -> AtmosphereTable:
    """The table without every second node of a part of an axis; the ends remain."""
    root = table.root
    axis = part if part in root.axes else "direction"
    values = np.asarray(root.axes[axis].values, float)
    start = {"limb": nodes.ground.size, "upward": nodes.ground.size + nodes.limb.size - 1}.get(part, 0)
    of_part = np.arange(start, start + getattr(nodes, part).size)
    remaining: Integers = np.setdiff1d(np.arange(values.size), of_part[1:-1:2])

    def cut(variable: Variable) -> Variable:
        if axis not in variable.dims:
            return variable
        return replace(variable, data=np.take(np.asarray(variable.data), remaining, axis=variable.dims.index(axis)))

    old: Axis = root.axes[axis]
    axes = root.axes | {axis: replace(old, values=values[remaining])}
    variables = {name: cut(variable) for name, variable in root.variables.items()}
    return replace(table, root=Group(axes, variables, root.groups, root.attributes))
