"""Grids of the atmospheric tables by tolerance.

Each axis is looked at by itself: along it the quantities are computed at many places, at random values of the other axes, and the
fewest of the places are kept that hold the axis's share of the tolerance. Then the whole table is measured at random points, and the
shares are tightened until it holds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skyshine.mat.accuracy.atmospheric import QUANTITIES, Scale
from skyshine.mat.accuracy.interpolation import random_places
from skyshine.mat.accuracy.probes import AXES, FIELDS
from skyshine.mat.quantities import AtmosphericQuantities, PathGrid
from skyshine.mat.tables.axes import AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.refinement import fewest_nodes, subdivided, uniform_nodes
from skyshine.schemas.errors import CheckFailed

PARTS = (8, 8, 12, 8, 8)  # of each cell of the job's axes: the places that may become nodes
# Random values of the other axes at which each axis is looked at.
_OTHERS = {0: (0, 10, 24, 4, 3), 1: (40, 0, 24, 3, 2), 2: (40, 12, 0, 4, 3), 3: (12, 5, 16, 0, 6), 4: (12, 5, 18, 10, 0)}
_FIRST_SHARE = 0.5  # of the tolerance, for each axis: their largest errors rarely meet
_PASSES = 4
_TESTS = 400  # random points at which the whole table is measured in each pass
_MARGIN = 0.9  # of the tolerance, there: other points are a little worse
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
        Of the error at random points, in the tolerance's unit.
    uniform : tuple of int
        Nodes that each axis would take, spaced equally (ranges in their logarithm), for the same share.
    """

    grid: PathGrid
    share: float
    p99: float
    maximum: float
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
    table_of: TableOf, at_points: Callable, base: PathGrid, scale: Scale, tolerance: float, *, seed: int, most: int
) -> RefinedGrid:
    """The fewest nodes, between the ends of a job's axes, that hold a tolerance.

    Parameters
    ----------
    table_of : callable
        Quantities on a grid.
    at_points : callable
        Quantities at ranges, altitudes, elevations and source angles.
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
    places = [random_places(getattr(base, name), _TESTS, generator) for name in FIELDS]
    truth = at_points(*places)
    share, last = _FIRST_SHARE, None
    for _ in range(_PASSES):
        grid = PathGrid(*(profile.nodes(share * tolerance) for profile in profiles))
        if np.prod(grid.shape) > most:
            break
        p99, maximum = _measured(table_of(grid), grid, places, truth, scale)
        last = p99, maximum
        if p99 <= _MARGIN * tolerance and maximum <= 2 * _MARGIN * tolerance:
            uniform = tuple(profile.uniform(share * tolerance) for profile in profiles)
            return RefinedGrid(grid, share, p99, maximum, uniform)
        share *= float(np.clip(0.9 * _MARGIN * tolerance * min(1 / p99, 2 / maximum), 0.25, 0.8))
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
        places = subdivided(nodes[axis], PARTS[axis], logarithmic=axis == 0)
        others = [_strata(nodes[i], count, generator) if i != axis else places for i, count in enumerate(_OTHERS[axis])]
        grid = PathGrid(*others)
        table = table_of(grid)

        def along(values):
            whole = np.broadcast_to(values.reshape(values.shape + (1,) * (5 - values.ndim)), grid.shape)
            return np.moveaxis(whole, axis, -1).reshape(-1, grid.shape[axis])

        values = {name: along(getattr(table, key)) for name, key in QUANTITIES.items()}
        return cls(axis, places, values, along(table.transmittance), along(table.valid), along(grid.range_km), scale)

    def nodes(self, allowed: float) -> np.ndarray:
        """The fewest places that hold an error."""
        return self.places[fewest_nodes(self.places, self._cell_error, allowed)] if self.places.size > 1 else self.places

    def uniform(self, allowed: float) -> int:
        """How many equally spaced nodes hold it."""
        if self.places.size == 1:
            return 1
        logarithmic = self.axis == 0 and self.places[0] > 0
        forth, back = (np.log, np.exp) if logarithmic else (np.array, np.array)
        return uniform_nodes(forth(self.places), lambda nodes: self._error(self._from_nodes(back(nodes))), allowed, _MOST_UNIFORM)

    def _cell_error(self, start: int, end: int) -> np.ndarray:
        inside = slice(start + 1, end)
        share = (self.places[inside] - self.places[start]) / (self.places[end] - self.places[start])
        read = {name: v[:, start, None] * (1 - share) + v[:, end, None] * share for name, v in self.values.items()}
        return self._error(read, inside)

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


def _measured(table, grid, places, truth, scale) -> tuple[float, float]:
    """99th percentile and largest of the errors at points, of the worst quantity each."""
    size = np.abs(np.array(list(errors_at(table, grid, places, truth, scale).values())))
    if not size.size:
        return 0.0, 0.0
    worst = size.max(axis=0)
    return float(np.percentile(worst, 99)), float(worst.max())
