"""Nodes of the temperature table, dense where it bends: of all axes by tolerance, or a given number of times of day."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.sampling import random_coordinates
from skyshine.mat.tables.axes import LINEAR, PERIODIC, AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import CheckFailed

PERIODS = {"azimuth_deg": 360.0, "time_h": 24.0}
# Greatest distance between the candidates for nodes.
_SPACING = {"altitude_km": 0.25, "azimuth_deg": 2.4, "slope_deg": 2.25, "time_h": 0.075}
_OTHERS = {"altitude_km": 3, "azimuth_deg": 6, "slope_deg": 5, "time_h": 24}
# Shares of the tolerance, which the nodes of each axis alone may miss: errors of time cost no columns to mend, those of
# azimuth and slope, which multiply them, cost most. Shares measured on four materials at 0.3 K.
_SHARES = {"altitude_km": 0.48, "azimuth_deg": 1.0, "slope_deg": 0.8, "time_h": 0.33}
_PASSES, _MARGIN = 6, 0.9  # refinements; share of the tolerance aimed at, so that other random points meet it too
_COARSER, _MOST_PASSES = 1.4, 24  # shares of a tolerance that is not insisted on, until the table is small enough
_WORST, _NEARLY_ALL = 3, 99.98  # times the tolerance, within which this percentage of the reads is
_TESTS = {"altitude_km": 2, "azimuth_deg": 14, "slope_deg": 14, "time_h": 24}
_LEAST_K, _MOST_K, _HALVINGS = 0.003, 50.0, 10  # between which errors of so many times are sought, in logarithm
_DECIMALS = 9  # decimals of a node, so that clock times and angles stay plain numbers


TemperatureOn = Callable[[dict[str, Floats]], Floats]


ALLOWED_SHARE = 0.01  # fraction of the candidates in a cell that may exceed the allowed error, up to twice


def fewest_nodes(candidates: Floats, error: Callable[[int, int], Floats], allowed: float) -> Integers:
    """The fewest ordered candidates that serve as nodes: after each, the farthest one whose cell meets the tolerance.

    Parameters
    ----------
    candidates : (n,) array
        Candidates, increasing; the first and the last are always nodes.
    error : callable
        error(a, b) gives the errors (..., b - a - 1) at the candidates between the a-th and the b-th where those two
        are nodes; not a number counts as none.
    allowed : float
        Error that `ALLOWED_SHARE` of the candidates of a cell may exceed, none more than twofold.

    Returns
    -------
    (k,) int array
        Indices of the nodes.

    Notes
    -----
    A cell inside a cell that meets the tolerance is assumed to meet it too. Between neighbouring candidates nothing is
    known, and nothing is refused.
    """
    nodes, end = [0], len(candidates) - 1
    while nodes[-1] < end:
        start = nodes[-1]
        reach, step = start + 1, 1
        while reach < end and meets(error(start, min(reach + step, end)), allowed):
            reach = min(reach + step, end)
            step *= 2
        while step > 1:
            step //= 2
            if reach + step <= end and meets(error(start, reach + step), allowed):
                reach += step
        nodes.append(reach)
    return np.array(nodes)


def meets(error: Floats, allowed: float) -> bool:
    """Whether errors keep to what is allowed: all but `ALLOWED_SHARE` within it, none beyond twice."""
    size = np.abs(error[np.isfinite(error)])
    if not size.size:
        return True
    return float(size.max()) <= 2 * allowed and float(np.mean(size > allowed)) <= ALLOWED_SHARE


@dataclass(frozen=True, eq=False)
class RefinedAxes:
    """Axes that meet a tolerance, with 99 and 99.98 % of the errors at random points, K."""

    axes: dict[str, Floats]
    p99: float
    largest: float


def refined_axes(
    temperature: TemperatureOn,
    base: Mapping[str, npt.ArrayLike],
    materials: int,
    tolerance: float,
    *,
    seed: int,
    max_nodes: int,
    whole_day: bool = True,
    fixed: Collection[str] = (),
    insist: bool = True,
) -> RefinedAxes:
    """The fewest nodes, between the ends of a job's axes, that meet a tolerance.

    Parameters
    ----------
    temperature : callable
        (M, A, Z, S, T) temperatures [K] on axes altitude_km, azimuth_deg, slope_deg, time_h.
    base : mapping of str to (n,) array
        The job's axes.
    materials : int
        M.
    tolerance : float
        Tolerance of the 99th percentile of all reads [K]; all but two in ten thousand are within three times, as far as
        the size allows.
    seed, max_nodes : int
        Seed of the random points; maximum number of nodes of the table.
    whole_day : bool
        The last time is followed by the first.
    fixed : collection of str
        Axes that keep their nodes, at which alone they are read.
    insist : bool
        Whether a tolerance that is not held is an error; otherwise the axes come as close as the size allows.

    Raises
    ------
    CheckFailed
        The tolerance is insisted on, and cannot be reached with so many nodes.
    """
    generator, size = random_stream(seed, Stream.TEMPERATURE_NODES), 0
    open_axes = {*fixed, *(() if whole_day else ("time_h",))}
    closed = {name: _closed(name, nodes, open_axes) for name, nodes in base.items()}
    profiles = {name: _profile(name, temperature, closed, fixed, generator) for name in base if name not in fixed}
    points = {name: _drawn(name, closed[name], n, name in fixed, generator) for name, n in _TESTS.items()}
    truth = temperature(points)
    share, reached = 1.0, ""
    holding: RefinedAxes | None = None
    for _ in range(_PASSES if insist else _MOST_PASSES):
        axes = {
            name: _nodes(name, *profiles[name], share * _SHARES[name] * tolerance, base[name], open_axes)
            if name in profiles
            else np.asarray(base[name], float)
            for name in base
        }
        size = materials * int(np.prod([nodes.size for nodes in axes.values()]))
        if size > max_nodes:
            if insist or holding is not None:
                break
            share *= _COARSER
            continue
        beside = _beside(axes, points, open_axes)
        error = np.abs(read_temperature(temperature(beside), beside, points, open_axes) - truth)
        p99, largest = (float(np.percentile(error, part)) for part in (99.0, _NEARLY_ALL))
        if p99 <= _MARGIN * tolerance or not insist:
            holding = RefinedAxes(axes, p99, largest)
            if p99 <= _MARGIN * tolerance and largest <= _WORST * tolerance:
                return holding
        reached = f"; an error of {p99:.2g} K (99 %), {largest:.2g} K (worst) is left with {size:,}"
        share *= float(np.clip(0.9 * _MARGIN * tolerance * min(1 / p99, _WORST / largest), 0.5, 0.8))
    if holding is not None:  # all but a few faces that the Sun grazes, whose error the file states
        return holding
    widest = max(axes, key=lambda name: axes[name].size)
    raise CheckFailed(
        f"surface_grid.tolerance {tolerance:g} K cannot be held with {max_nodes:,} nodes: it takes {size:,}{reached},"
        f" most for the {widest.rsplit('_', 1)[0]}, {axes[widest].size}; raise it, shorten that axis, allow more with"
        " surface_grid.most_nodes, or name closer axes to start from"
    )


def _beside(axes: Mapping[str, Floats], points: Mapping[str, Floats], open_axes: Collection[str]) -> dict[str, Floats]:
    """The nodes between which places lie: reads there need no others. Times, which cost no columns, are all there."""
    chosen = {}
    for name, nodes in axes.items():
        before = np.searchsorted(nodes, points[name], side="right") - 1
        if name in PERIODS and name not in open_axes:
            either = np.concatenate([before, before + 1]) % nodes.size
        else:
            before = np.clip(before, 0, max(nodes.size - 2, 0))
            either = np.concatenate([before, np.minimum(before + 1, nodes.size - 1)])
        chosen[name] = nodes if name == "time_h" else nodes[np.unique(either)]
    return chosen


def placed_times(
    temperature: TemperatureOn,
    axes: Mapping[str, npt.ArrayLike],
    *,
    whole_day: bool,
    seed: int,
    fixed: Collection[str] = (),
) -> Floats:
    """Times of the day where temperatures bend, as many as an axis has and between its ends.

    Parameters
    ----------
    temperature : callable
        Function as in `refined_axes`.
    axes : mapping of str to (n,) array
        Axes of the table. Times that are a part of the day may continue beyond 24 h.
    whole_day : bool
        The last time is followed by the first.
    seed : int
        Seed of the altitudes, azimuths and slopes at which the day is sampled.
    fixed : collection of str
        Names of fixed axes, as in `refined_axes`.

    Returns
    -------
    (n,) array
        Clock hours, increasing. Of all axes with so few nodes about that with the least error.
    """
    generator, count = random_stream(seed, Stream.TEMPERATURE_NODES), np.size(axes["time_h"])
    if count <= 2 - whole_day:
        return np.asarray(axes["time_h"], float)
    open_axes = {*fixed, *(() if whole_day else ("time_h",))}
    closed = {name: _closed(name, nodes, open_axes) for name, nodes in axes.items()}
    hours, values = _profile("time_h", temperature, closed, fixed, generator)
    error, cells = _cell_error(hours, values), count - (not whole_day)
    chosen, low, high = np.array([0, hours.size - 1]), np.log(_LEAST_K), np.log(_MOST_K)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        fewest = fewest_nodes(hours, error, float(np.exp(middle)))
        if fewest.size - 1 <= cells:
            chosen, high = fewest, middle
        else:
            low = middle
    while chosen.size - 1 < cells:
        widest = int(np.argmax(np.diff(chosen)))
        chosen = np.insert(chosen, widest + 1, (chosen[widest] + chosen[widest + 1]) // 2)
    times: Floats = hours[chosen[:-1] if whole_day else chosen]
    return times


def within_period(axis: str, values: Floats) -> Floats:
    """Values of a periodic axis within its first period; those of another axis, also below 0, as they are."""
    return np.mod(values, PERIODS[axis]) if axis in PERIODS else values


def read_temperature(
    table: Floats, axes: Mapping[str, npt.ArrayLike], points: dict[str, Floats], open_axes: Collection[str] = ()
) -> Floats:
    """Interpolated temperatures (M, ...) at all combinations of places; no last node of open axes is followed by the
    first.
    """
    rules = []
    for name, nodes in axes.items():
        kind = (PERIODIC if name not in open_axes else LINEAR, PERIODS[name]) if name in PERIODS else ()
        rules.append(AxisRule(name, np.asarray(nodes, float), *kind))
    mesh = dict(zip(points, np.meshgrid(*points.values(), indexing="ij", sparse=True), strict=True))
    return np.stack([interpolate(material_table.astype(float), rules, mesh) for material_table in table])


def _closed(name: str, axis: npt.ArrayLike, open_axes: Collection[str]) -> Floats:
    nodes, goes_round = np.asarray(axis, float), name in PERIODS and name not in open_axes
    return np.append(nodes, nodes[0] + PERIODS[name]) if goes_round and nodes.size > 1 else nodes


def _drawn(name: str, nodes: Floats, count: int, at_nodes: bool, generator: np.random.Generator) -> Floats:
    """Random coordinates (count,) on an axis, or some of its nodes, at least one."""
    if at_nodes:
        return np.sort(generator.choice(nodes, min(count, nodes.size), replace=False))
    return within_period(name, random_coordinates(nodes, count, generator))


def _profile(
    axis: str,
    temperature: TemperatureOn,
    closed: dict[str, Floats],
    fixed: Collection[str],
    generator: np.random.Generator,
) -> tuple[Floats, Floats]:
    """Places (n,) along an axis and temperatures (K, n) there, at random places of the others."""
    candidates = _candidates(axis, closed[axis])
    distinct, number = np.unique(np.round(within_period(axis, candidates), _DECIMALS), return_inverse=True)
    others = {
        name: distinct if name == axis else np.unique(_drawn(name, nodes, _OTHERS[name], name in fixed, generator))
        for name, nodes in closed.items()
    }
    table = np.moveaxis(temperature(others), 1 + list(closed).index(axis), -1)
    return candidates, table.reshape(-1, table.shape[-1]).astype(float)[:, number]


def _candidates(axis: str, nodes: Floats) -> Floats:
    """The places of an axis that may become nodes: equal parts of each cell."""
    pieces = [nodes[:1]]
    for low, high in itertools.pairwise(nodes):
        parts = int(np.ceil((high - low) / _SPACING[axis] - 1e-6))
        pieces.append(np.linspace(low, high, max(parts, 1) + 1)[1:])
    return np.concatenate(pieces).round(_DECIMALS)


def _nodes(
    name: str, candidates: Floats, values: Floats, allowed: float, base: npt.ArrayLike, open_axes: Collection[str]
) -> Floats:
    if candidates.size == 1:
        return np.asarray(base, float)

    nodes = candidates[fewest_nodes(candidates, _cell_error(candidates, values), allowed)]
    goes_round = name in PERIODS and name not in open_axes
    return np.sort(np.mod(nodes[:-1], PERIODS[name])) if goes_round else nodes


def _cell_error(candidates: Floats, values: Floats) -> Callable[[int, int], Floats]:
    """Errors (K, m) of linear interpolation inside a cell between two of the places."""

    def error(start: int, end: int) -> Floats:
        share = (candidates[start + 1 : end] - candidates[start]) / (candidates[end] - candidates[start])
        read: Floats = values[:, start, None] * (1 - share) + values[:, end, None] * share
        return read - values[:, start + 1 : end]

    return error
