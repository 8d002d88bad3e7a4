"""Nodes of a database in channels by tolerance: placed where the error is, until random lines of sight hold it.

Where a table does not hold, every second node of each part of each axis is left out in turn. What that changes of a
read is three times the error that the part leaves there, for linear interpolation errs with the square of the step. So
each interval of each part gets the number of nodes that its own worst reads ask for, more or fewer than it had.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skyshine.mat.measure.probes import Probes
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

_PASSES = 8
WORST = 3.0  # tolerances, which the worst reads may err
_MARGIN, _WORST = 0.95, 2.8  # tolerances that 99 % of the reads hold, and nearly all: others are a little worse
_NEARLY_ALL = 99.98  # % of the reads
_PART = 0.4  # of the tolerance, which an interval of a part may leave in 99 % of its reads
_TIGHTER = 0.7  # of that part, once, where a pass has gained too little
_WORST_SHARE = 2.0  # tolerances that it may leave in its worst read, over what it may leave in 99 %
_THINNED, _GROWTH = 0.7, 4.0  # intervals for one, in one pass
_IDLE = 0.5  # of the nodes that an interval has: where it needs fewer, it is thinned
_STEADY = 0.75  # of its neighbours' growth, which an interval grows by at least
_WORTH = 0.8  # of the nodes, at most, for which those that hold the tolerance are thinned once more
_GAIN = 0.85  # of the error of the pass before, which more nodes must leave at most
_WORST_LINES, _OTHER_LINES = 80, 160  # on which parts are blamed
_OF_PATHS = ("beta_star", "path_radiance_ratio")
_SOURCE = ("source_elevation", "scattering_angle")  # axes of path radiance alone


@dataclass(frozen=True)
class ChannelQuantity:
    """One quantity of a database in channels, read as the tables of `Probes` are.

    Attributes
    ----------
    table : AtmosphereTable
    name : str
    """

    table: AtmosphereTable
    name: str

    def read(self, places: dict[str, Floats]) -> Floats:
        """Values at places by the names of `gridded.AXES`."""
        names = {rule.name for rule in self.table.rules(self.name)}
        where = {name: values for name, values in places.items() if name in names}
        return self.table.clamped().value(self.name, **where)


@dataclass(frozen=True)
class PlacedChannels:
    """A database in channels that holds a tolerance.

    Attributes
    ----------
    table : AtmosphereTable
    nodes : ChannelNodes
    p99, worst : float
        99 and 99.98 % of the errors at random points, of the worst quantity, in the tolerance's unit.
    """

    table: AtmosphereTable
    nodes: ChannelNodes
    p99: float
    worst: float


def quantities_of(table: AtmosphereTable) -> dict[str, ChannelQuantity]:
    """The four quantities of a table."""
    return {name: ChannelQuantity(table, name) for name in QUANTITIES}


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
    """Few nodes that hold a tolerance.

    Parameters
    ----------
    table_of : callable
        The table on some nodes.
    probes : sequence of Probes
        Random lines of sight with the quantities on them, in groups that hold the tolerance each; the first with all
        quantities, the others with those of paths alone.
    nodes : ChannelNodes
        To start from.
    scale : Scale
        In what the tolerance counts.
    tolerance : float
        Of 99 % of the reads of each quantity; all but two in ten thousand are within three times.
    max_nodes : int
        Of one field.
    fewest : bool
        Whether nodes are thinned further where those that hold the tolerance are more than the errors ask for.
    insist : bool
        Whether a tolerance that is not held is an error; otherwise the table is the closest of those that were tried.

    Raises
    ------
    CheckFailed
        The tolerance is insisted on, or no table was tried, and it cannot be held with so many nodes.
    """
    p99, worst, over, tried, part = np.inf, np.inf, np.inf, nodes.size, _PART
    placed: PlacedChannels | None = None
    closest, least = placed, np.inf
    for _ in range(_PASSES):
        if nodes.size > max_nodes:
            break
        before, tried, table = over, nodes.size, table_of(nodes)
        p99, worst = largest_errors(table, probes, scale)
        if p99 <= _MARGIN * tolerance and worst <= _WORST * tolerance:
            placed = PlacedChannels(table, nodes, p99, worst)
            fewer = _placed_anew(nodes, table, probes, scale, _PART * tolerance) if fewest else nodes
            if fewer.size > _WORTH * nodes.size:
                break
            nodes = fewer
            continue
        if placed is not None:
            break
        over = float(np.max([p99 / _MARGIN, worst / _WORST])) / tolerance
        if over < least:
            closest, least = PlacedChannels(table, nodes, p99, worst), over
        if not over <= _GAIN * before:
            if part < _PART or not np.isfinite(over):
                break  # what errs is not what nodes hold
            part *= _TIGHTER
        nodes = _placed_anew(nodes, table, probes, scale, part * tolerance)
    placed = placed or (None if insist else closest)
    if placed is not None:
        return placed
    raise CheckFailed(
        f"atmosphere_grid.tolerance {tolerance:g} cannot be held in channels: {tried:,} nodes a field leave an"
        f" error of {p99:.2g} (99 %), {worst:.2g} (worst); raise it, or allow more with"
        " atmosphere_grid.most_nodes"
    )


def largest_errors(table: AtmosphereTable, probes: Sequence[Probes], scale: Scale) -> tuple[float, float]:
    """99 and 99.98 % of the errors of a table at random points, of the worst quantity, in the scale's unit; `probes` as
    `placed_channels`.
    """
    tables, (all_around, *others) = quantities_of(table), probes
    measured = [all_around.errors(tables, scale)]
    measured += [group.errors({name: tables[name] for name in _OF_PATHS}, scale) for group in others]
    # Not a number anywhere makes these not a number, which holds no tolerance.
    p99 = float(np.max([_percentile(error, 99.0) for group in measured for error in group.values()]))
    pooled = [np.concatenate([group[name] for group in measured if name in group]) for name in tables]
    return p99, float(np.max([_percentile(error, _NEARLY_ALL) for error in pooled]))


def _percentile(error: Floats, share: float) -> float:
    return float(np.percentile(np.abs(error), share)) if error.size else 0.0


def _placed_anew(
    nodes: ChannelNodes, table: AtmosphereTable, groups: Sequence[Probes], scale: Scale, allowed: float
) -> ChannelNodes:
    """Nodes of which each interval leaves what is allowed, by the reads on the worst lines and on some others."""
    few = [_lines(probes, _worst_lines(table, probes, scale)) for probes in groups]
    errors = _errors(table, few, scale)
    parts = [part for part in nodes.parts() if getattr(nodes, part).size > 2]
    blamed = _blamed(errors, {part: _errors(_without_every_second(table, part, nodes), few, scale) for part in parts})
    placed = nodes
    for part in parts:
        at = getattr(nodes, part)
        edges = np.append(at[:-1:2], at[-1])
        found = np.full(edges.size - 1, np.nan)
        for group, probes in zip(blamed[part], few, strict=True):
            where = _coordinates(table, probes)[part]
            for name, values in group.items():
                if part not in _SOURCE or name == "path_radiance_ratio":
                    found = np.fmax(found, _by_interval(edges, np.broadcast_to(where, values.shape), values))
        had = np.diff(np.searchsorted(at, edges))
        placed = placed.with_spacing(part, edges, had * _growth(found / allowed))
    return placed


def _blamed(
    errors: Sequence[dict[str, Floats]], thinned: dict[str, Sequence[dict[str, Floats]]]
) -> dict[str, list[dict[str, Floats]]]:
    """Error of each read that each part leaves: a third of the change without every second node, and at least its
    share, among all parts, of the error that the read has.
    """
    blamed: dict[str, list[dict[str, Floats]]] = {part: [] for part in thinned}
    for number, whole in enumerate(errors):
        for part in thinned:
            blamed[part].append({})
        for name, error in whole.items():
            change = {part: np.abs(groups[number][name] - error) / 3 for part, groups in thinned.items()}
            total = np.maximum(sum(change.values()), np.finfo(float).tiny)
            for part, values in change.items():
                blamed[part][number][name] = np.maximum(values, values / total * np.abs(error))
    return blamed


def _by_interval(edges: Floats, at: Floats, error: Floats) -> Floats:
    """Error (n,) of the reads in each of n intervals; not a number where no read stands."""
    inside: Booleans = np.isfinite(error) & (at >= edges[0]) & (at <= edges[-1])
    interval = np.clip(np.searchsorted(edges, at[inside], side="right") - 1, 0, edges.size - 2)
    reads = error[inside]
    found = np.full(edges.size - 1, np.nan)
    for number in np.unique(interval):
        own = reads[interval == number]
        found[number] = max(float(np.percentile(own, 99)), float(own.max()) / _WORST_SHARE)
    return found


def _growth(over: Floats) -> Floats:
    """By what the numbers of intervals grow, of errors over those allowed; where none is known, as the neighbours."""
    known = np.flatnonzero(np.isfinite(over))
    if not known.size:
        return np.ones(over.size)
    factor = np.sqrt(np.interp(np.arange(over.size), known, over[known]))
    beside = np.maximum(np.append(factor[1:], 0.0), np.insert(factor[:-1], 0, 0.0))
    asked = np.maximum(factor, _STEADY * beside)
    growth: Floats = np.where(asked < _IDLE, _THINNED, np.clip(asked, 1.0, _GROWTH))
    return growth


def _worst_lines(table: AtmosphereTable, probes: Probes, scale: Scale) -> Integers:
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
    return replace(
        probes,
        seen=probes.seen.some(lines),
        places=places,
        ambient_at=probes.ambient_at[:0],
        truth=AtmosphericQuantities(**truth),
    )


def _errors(table: AtmosphereTable, groups: Sequence[Probes], scale: Scale) -> list[dict[str, Floats]]:
    """Errors (n, R, S or 1) of transmittance and of path radiance at the probes; not a number behind the ground."""
    tables = quantities_of(table)
    return [
        {
            name: np.where(probes.above_ground(name, error), error, np.nan)
            for name in _OF_PATHS
            for error in [probes.error(name, tables[name], scale)]
        }
        for probes in groups
    ]


def _coordinates(table: AtmosphereTable, probes: Probes) -> dict[str, Floats]:
    """Places of the probes on each part of each axis, (n, R, S or 1); outside its nodes where they lie in another."""
    places = probes.places
    at = table.rays.locate(places["range"], places["altitude"], places["elevation"])
    return {
        "share": at.share,
        "height_root": at.height_root,
        "ground": np.where(at.to_ground, at.direction, -1.0),
        "limb": np.where(at.to_ground | (at.direction > LEVEL), -1.0, at.direction),
        "upward": np.where(at.direction >= LEVEL, at.direction, -1.0),
        "source_elevation": places["source_elevation"],
        "scattering_angle": scattering_angle(places["elevation"], places["source_elevation"], places["source_azimuth"]),
    }


def _without_every_second(table: AtmosphereTable, part: str, nodes: ChannelNodes) -> AtmosphereTable:
    """The table with every second node of a part of an axis left out, but for its ends."""
    root = table.root
    axis = part if part in root.axes else "direction"
    whole = np.asarray(root.axes[axis].values, float)
    first = {"limb": nodes.ground.size, "upward": nodes.ground.size + nodes.limb.size - 1}.get(part, 0)
    of_part = np.arange(first, first + getattr(nodes, part).size)
    kept: Integers = np.setdiff1d(np.arange(whole.size), of_part[1:-1:2])

    def cut(variable: Variable) -> Variable:
        if axis not in variable.dims:
            return variable
        return replace(variable, data=np.take(np.asarray(variable.data), kept, axis=variable.dims.index(axis)))

    old: Axis = root.axes[axis]
    axes = root.axes | {axis: replace(old, values=whole[kept])}
    variables = {name: cut(variable) for name, variable in root.variables.items()}
    return replace(table, root=Group(axes, variables, root.groups, root.attributes))
