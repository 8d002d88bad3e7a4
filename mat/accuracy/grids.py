"""Grids of the atmospheric tables by tolerance.

Each axis is looked at by itself: along it the quantities are computed at many places, at random values of the other axes, and the
fewest of the places are kept that hold the axis's share of the tolerance. Then the whole table is measured on random lines of sight,
and the shares are tightened until it holds.

Direct light begins with a step when the source rises over the horizon of a surface, at an elevation that falls with the surface's height. No
grid of linear cells holds a step to twice a tolerance: in cells with the horizon inside, the tolerance bounds the share of reads that are
worse, not the worst of them, and what is left is measured apart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skyshine.mat.accuracy.atmospheric import QUANTITIES, Scale
from skyshine.mat.accuracy.probes import AXES, FIELDS, Probes
from skyshine.mat.quantities import AtmosphericQuantities, PathGrid
from skyshine.mat.tables.axes import AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.refinement import fewest_nodes, subdivided, uniform_nodes
from skyshine.schemas.errors import CheckFailed

PARTS = (8, 8, 12, 8, 8)  # of each cell of the job's axes: the places that may become nodes
_TWILIGHT, _TWILIGHT_PARTS = -10.0, 40  # degree: from there to 0, where the horizon of heights up to 100 km lies
_HORIZON_SHARE = 0.04  # of the reads in a cell of source elevation, times the axis's share of the tolerance, may meet a step
# Random values of the other axes at which each axis is looked at.
_OTHERS = {0: (0, 10, 24, 4, 3), 1: (40, 0, 24, 3, 2), 2: (40, 12, 0, 4, 3), 3: (12, 5, 16, 0, 6), 4: (12, 5, 18, 10, 0)}
_FIRST_SHARE = 0.5  # of the tolerance, for each axis: their largest errors rarely meet
_PASSES = 6
_SKY_LINES = 240  # on which sky light is measured too
_MARGIN = 0.9  # of the tolerance, there: other points are a little worse
_WORST_MARGIN = 0.45  # of twice the tolerance: the worst of other points may be twice the worst of these
_MOST_UNIFORM = 1024


@dataclass(frozen=True, eq=False)
class RefinedGrid:
    """A grid that holds a tolerance.

    Attributes
    ----------
    grid : PathGrid
    share : float
        Of the tolerance, given to each axis.
    p99, maximum : float
        Of the error at random points, in the tolerance's unit; the largest without direct light in cells with the source's rise inside.
    horizon_share, horizon_maximum : float
        Of the points, those where direct light is worse than the tolerance in a cell with the source's rise inside; its largest error there.
    uniform : tuple of int
        Nodes that each axis would take, spaced equally (ranges in their logarithm), for the same share.
    """

    grid: PathGrid
    share: float
    p99: float
    maximum: float
    horizon_share: float
    horizon_maximum: float
    uniform: tuple[int, ...]

    @property
    def cells(self) -> int:
        """Nodes of the path radiance table."""
        return int(np.prod(self.grid.shape))

    @property
    def ratio(self) -> float:
        """Nodes of the uniform grid over these."""
        return float(np.prod([float(n) for n in self.uniform])) / self.cells


TableOf = Callable[[PathGrid], AtmosphericQuantities]


def refined_grid(
    table_of: TableOf, probes_of: Callable[[np.random.Generator, int], Probes], base: PathGrid, scale: Scale, tolerance: float,
    *, seed: int, most: int,
) -> RefinedGrid:  # fmt: skip
    """The fewest nodes, between the ends of a job's axes, that hold a tolerance.

    Parameters
    ----------
    table_of : callable
        Quantities on a grid.
    probes_of : callable
        Random lines of sight on the job's axes, drawn with a generator, with sky light on so many of them.
    base : PathGrid
        The job's axes: their ends, and by their cells how the random points lie.
    scale : Scale
        In what the tolerance counts.
    tolerance : float
    seed, most : int
        Of the random points; nodes that the largest table may have.

    Raises
    ------
    CheckFailed
        The tolerance cannot be reached with so many nodes.
    """
    generator = np.random.default_rng([seed, 3])
    profiles = [_Profile.of(axis, table_of, base, scale, generator) for axis in range(5)]
    probes = probes_of(generator, _SKY_LINES)
    share, last = _FIRST_SHARE, None
    for _ in range(_PASSES):
        grid = PathGrid(*(profile.nodes(share * tolerance, share) for profile in profiles))
        if np.prod(grid.shape) > most:
            break
        found = p99, maximum, *_ = _measured(table_of(grid), grid, probes, scale, tolerance)
        last = p99, maximum
        if p99 <= _MARGIN * tolerance and maximum <= 2 * _WORST_MARGIN * tolerance:
            uniform = tuple(profile.uniform(share * tolerance) for profile in profiles)
            return RefinedGrid(grid, share, *found, uniform)
        share *= float(np.clip(0.9 * tolerance * min(_MARGIN / p99, 2 * _WORST_MARGIN / maximum), 0.25, 0.8))
    reached = f"; {int(np.prod(grid.shape)):,} nodes" + (f" after an error of {last[0]:.2g} (99 %), {last[1]:.2g} (worst)" if last else "")
    raise CheckFailed(
        f"atmosphere_grid.tolerance {tolerance:g} cannot be held with {most:,} nodes{reached}; raise it, shorten the axes, "
        "or allow more with atmosphere_grid.most_nodes"
    )


@dataclass(frozen=True, eq=False)
class _Profile:
    """Quantities along one axis, (K, n) each, at n places."""

    axis: int
    places: np.ndarray
    values: dict[str, np.ndarray]
    transmittance: np.ndarray
    valid: np.ndarray
    distance: np.ndarray
    scale: Scale

    @classmethod
    def of(cls, axis, table_of, base, scale, generator) -> _Profile:
        nodes = [getattr(base, name) for name in FIELDS]
        places = _candidates(axis, nodes[axis])
        others = [_strata(nodes[i], count, generator) if i != axis else places for i, count in enumerate(_OTHERS[axis])]
        grid = PathGrid(*others)
        table = table_of(grid)

        def along(values):
            whole = np.broadcast_to(values.reshape(values.shape + (1,) * (5 - values.ndim)), grid.shape)
            return np.moveaxis(whole, axis, -1).reshape(-1, grid.shape[axis])

        values = {name: along(getattr(table, key)) for name, key in QUANTITIES.items()}
        return cls(axis, places, values, along(table.transmittance), along(table.valid), along(grid.range_km), scale)

    def nodes(self, allowed: float, share: float) -> np.ndarray:
        """The fewest places that hold an error, and at which no more reads than a share meet a step."""
        if self.places.size == 1:
            return self.places
        steps = _HORIZON_SHARE * share if self.axis == 3 else 1.0

        def error(start, end):
            found, risen = self._cell_error(start, end)
            bad = np.any(risen & (np.abs(found) > allowed), axis=1)
            inside = np.where(risen, np.nan, found)
            return np.append(inside, np.inf) if np.mean(bad) > steps else inside

        return self.places[fewest_nodes(self.places, error, allowed)]

    def uniform(self, allowed: float) -> int:
        """How many equally spaced nodes hold it."""
        if self.places.size == 1:
            return 1
        logarithmic = self.axis == 0 and self.places[0] > 0
        forth, back = (np.log, np.exp) if logarithmic else (np.array, np.array)
        return uniform_nodes(forth(self.places), lambda nodes: self._error(self._from_nodes(back(nodes))), allowed, _MOST_UNIFORM)

    def _cell_error(self, start: int, end: int) -> tuple[np.ndarray, np.ndarray]:
        """Errors (K, m) inside a cell, and in which rows the source rises there."""
        inside = slice(start + 1, end)
        share = (self.places[inside] - self.places[start]) / (self.places[end] - self.places[start])
        read = {name: v[:, start, None] * (1 - share) + v[:, end, None] * share for name, v in self.values.items()}
        lit = self.values["direct_radiance"][:, start : end + 1] > 0
        risen = np.any(lit, axis=1) & ~np.all(lit, axis=1)
        return self._error(read, inside), np.broadcast_to(risen[:, None], (lit.shape[0], end - start - 1))

    def _error(self, read: dict, inside: slice = slice(None)) -> np.ndarray:
        """Errors (K, m) of the worst quantity at some places, not a number behind the ground."""
        tau, distance, valid = (array[:, inside] for array in (self.transmittance, self.distance, self.valid))
        found = [self.scale.error(name, read[name], v[:, inside], tau, distance) for name, v in self.values.items()]
        return np.where(valid, np.abs(found).max(axis=0), np.nan)

    def _from_nodes(self, nodes: np.ndarray) -> dict:
        """Quantities at all places, interpolated from nodes between the places, where these are linear."""
        at = np.clip(np.searchsorted(self.places, nodes, side="right") - 1, 0, self.places.size - 2)
        share = np.clip((nodes - self.places[at]) / (self.places[at + 1] - self.places[at]), 0.0, 1.0)
        back = np.clip(np.searchsorted(nodes, self.places, side="right") - 1, 0, nodes.size - 2)
        weight = np.clip((self.places - nodes[back]) / (nodes[back + 1] - nodes[back]), 0.0, 1.0)
        found = {}
        for name, v in self.values.items():
            held = v[:, at] * (1 - share) + v[:, at + 1] * share
            found[name] = held[:, back] * (1 - weight) + held[:, back + 1] * weight
        return found


def _candidates(axis: int, nodes: np.ndarray) -> np.ndarray:
    """The places of an axis that may become nodes."""
    if axis != 3:
        return subdivided(nodes, PARTS[axis], logarithmic=axis == 0)
    low = np.union1d(nodes[nodes <= 0], np.clip([_TWILIGHT, 0.0], nodes[0], nodes[-1]))
    night, dusk, day = low[low <= _TWILIGHT], low[low >= _TWILIGHT], np.union1d(nodes[nodes > 0], low[-1:])
    pieces = ((night, PARTS[3]), (dusk, _TWILIGHT_PARTS), (day, PARTS[3]))
    return np.unique(np.concatenate([subdivided(piece, parts) for piece, parts in pieces if piece.size]))


def _strata(nodes, count: int, generator) -> np.ndarray:
    """Random places on an axis, one in each of `count` equal parts of its cells."""
    if nodes.size == 1:
        return nodes
    place = (np.arange(count) + generator.random(count)) / count * (nodes.size - 1)
    return np.interp(place, np.arange(nodes.size), nodes)


def errors_at(table, grid: PathGrid, places, truth, scale: Scale | None) -> dict[str, np.ndarray]:
    """Errors of each quantity's interpolation at points above the ground, in the scale's unit; without a scale in its own.

    Parameters
    ----------
    table, truth : AtmosphericQuantities
        On the grid; at the points.
    places : five (n,) arrays
        In the order of the grid's axes.
    """
    rules = [AxisRule(name, getattr(grid, axis)) for name, axis in zip(AXES, FIELDS)]
    found = {}
    for name, key in QUANTITIES.items():
        values = getattr(table, key)
        read = interpolate(values, rules[: values.ndim], dict(zip(AXES[: values.ndim], places)))
        exact = getattr(truth, key)
        error = read - exact if scale is None else scale.error(name, read, exact, truth.transmittance, places[0])
        found[name] = error[truth.valid]
    return found


def _measured(table, grid, probes: Probes, scale, tolerance: float) -> tuple[float, float, float, float]:
    """99th percentile of the errors on lines of sight; the largest without direct light on the horizon; the share of reads where that is
    worse than the tolerance, and its largest error."""
    errors = {name: np.abs(error) for name, error in probes.errors(table, grid, scale).items()}
    sky, direct, lit = errors.pop("ambient_radiance"), errors.pop("direct_radiance"), probes.lit(table, grid)
    if not direct.size:
        return 0.0, 0.0, 0.0, 0.0
    others = np.maximum(np.repeat(errors["beta_star"], direct.size // errors["beta_star"].size), errors["path_radiance_ratio"])
    edge = np.where((lit > 0) & (lit < 1), direct, 0.0)
    p99 = max(np.percentile(values, 99) if values.size else 0.0 for values in (np.maximum(others, direct), sky))
    largest = max(float(values.max(initial=0.0)) for values in (others, np.where(edge > 0, 0.0, direct), sky))
    return float(p99), largest, float(np.mean(edge > tolerance)), float(edge.max())
