"""A quantity of the atmospheric tables along one axis of a grid, and the fewest nodes there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.measure.refinement import fewest_nodes, percentile_99, subdivided, uniform_nodes
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.tables.gridded import FIELDS, QUANTITIES
from skyshine.schemas.arrays import Booleans, Floats

PARTS = (8, 8, 12, 8, 8)  # of each cell of the job's axes: the places that may become nodes
_TWILIGHT, _TWILIGHT_PARTS = -10.0, 40  # degree: from there to 0, where the horizon of heights up to 100 km lies
# Random values of the other axes at which each axis is looked at.
_OTHERS = {
    0: (0, 10, 24, 6, 6),
    1: (20, 0, 30, 6, 6),
    2: (12, 10, 0, 8, 10),
    3: (12, 6, 24, 0, 8),
    4: (12, 6, 24, 12, 0),
}
_MAX_UNIFORM, _ROWS = 4096, 1000  # nodes; values of the other axes that the comparison with them takes


@dataclass(frozen=True, eq=False)
class AxisProfile:
    """A quantity along an axis, (K, n): at n places, for K values of the other axes.

    Attributes
    ----------
    quantity : str
    logarithmic : bool
        Equal steps of this axis are those of its logarithm.
    places : (n,) array
    values, transmittance, distance : (K, n) arrays
    counts : (K, n) bool array
        False behind the ground, and where no azimuth gives the scattering angle.
    scale : Scale
        In what errors count.
    """

    quantity: str
    logarithmic: bool
    places: Floats
    values: Floats
    transmittance: Floats
    distance: Floats
    counts: Booleans
    scale: Scale

    @classmethod
    def of(
        cls,
        quantity: str,
        axis: int,
        table_of: Callable[[PathGrid, str], AtmosphericQuantities],
        base: PathGrid,
        scale: Scale,
        generator: np.random.Generator,
    ) -> AxisProfile:
        """Along one axis of a grid, by its number; arguments as `atmosphere_nodes.placed_grids`."""
        key, count = QUANTITIES[quantity]
        nodes = [getattr(base, field) for field in FIELDS]
        places = _candidates(axis, nodes[axis])
        others = [places if i == axis else _strata(nodes[i], _OTHERS[axis][i], generator) for i in range(count)]
        grid = type(base)(*others, *(nodes[i][:1] for i in range(count, 5)))
        table = table_of(grid, key)
        shape = grid.shape[:count]

        def along(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
            full = np.broadcast_to(values.reshape(values.shape + (1,) * (count - values.ndim)), shape)
            return np.moveaxis(full, axis, -1).reshape(-1, shape[axis])

        counts: Booleans = along(table.valid)
        if count == 5 and base.by_scattering_angle:
            counts = counts & along(_possible(grid))
        logarithmic = axis == 0 and places[0] > 0
        return cls(
            quantity,
            logarithmic,
            places,
            along(getattr(table, key)),
            along(table.transmittance),
            along(grid.range_km[:, None, None]),
            counts,
            scale,
        )

    def nodes(self, allowed: float) -> Floats:
        """The fewest places that hold an error; at least three, so that a bend shows."""
        if self.places.size == 1:
            return self.places
        chosen = fewest_nodes(self.places, self._cell_error, allowed)
        return self.places[np.union1d(chosen, self.places.size // 2) if chosen.size == 2 else chosen]

    def uniform(self, nodes: Floats) -> int:
        """How many equally spaced nodes are as good on this axis as those given: equal 99th percentile of errors."""
        if self.places.size == 1:
            return 1
        forward: Callable[[Floats], Floats] = np.log if self.logarithmic else np.array
        inverse: Callable[[Floats], Floats] = np.exp if self.logarithmic else np.array
        rows = slice(None, None, -(-len(self.values) // _ROWS))
        arrays = {name: getattr(self, name)[rows] for name in ("values", "transmittance", "distance", "counts")}
        sample = replace(self, **arrays)
        allowed = percentile_99(sample._error(sample._read(nodes)))

        def error_of(nodes: Floats) -> Floats:
            return sample._error(sample._read(inverse(nodes)))

        return uniform_nodes(forward(self.places), error_of, allowed, _MAX_UNIFORM)

    def _cell_error(self, start: int, end: int) -> Floats:
        """Errors (K, m) inside a cell; none where a source rises in it, which no linear cell holds."""
        inside = slice(start + 1, end)
        share = (self.places[inside] - self.places[start]) / (self.places[end] - self.places[start])
        read = self.values[:, start, None] * (1 - share) + self.values[:, end, None] * share
        lit = self.values[:, start : end + 1] > 0
        rises = np.any(lit, axis=1) & ~np.all(lit, axis=1)
        error: Floats = np.where(rises[:, None], np.nan, self._error(read, inside))
        return error

    def _error(self, read: Floats, inside: slice = slice(None)) -> Floats:
        tau, distance, exact = (array[:, inside] for array in (self.transmittance, self.distance, self.values))
        error: Floats = np.where(
            self.counts[:, inside], self.scale.error(self.quantity, read, exact, tau, distance), np.nan
        )
        return error

    def _read(self, nodes: Floats) -> Floats:
        """Values at all places, interpolated from nodes between the places, where these are linear."""
        nodes = np.clip(nodes, self.places[0], self.places[-1])
        at = np.clip(np.searchsorted(self.places, nodes, side="right") - 1, 0, self.places.size - 2)
        share = (nodes - self.places[at]) / (self.places[at + 1] - self.places[at])
        at_nodes = self.values[:, at] * (1 - share) + self.values[:, at + 1] * share
        cell = np.clip(np.searchsorted(nodes, self.places, side="right") - 1, 0, nodes.size - 2)
        weight = np.clip((self.places - nodes[cell]) / (nodes[cell + 1] - nodes[cell]), 0.0, 1.0)
        read: Floats = at_nodes[:, cell] * (1 - weight) + at_nodes[:, cell + 1] * weight
        return read


def _possible(grid: PathGrid) -> Booleans:
    """Where some azimuth gives the scattering angle, (1, 1, E, SE, SA)."""
    line, source, angle = grid.elevation_deg[:, None, None], grid.source_elevation_deg[:, None], grid.source_azimuth_deg
    possible: Booleans = (np.abs(line - source) <= angle) & (angle <= 180 - np.abs(line + source))
    return possible[None, None]


def _candidates(axis: int, nodes: Floats) -> Floats:
    """The places of an axis that may become nodes."""
    if axis != 3:
        return subdivided(nodes, PARTS[axis], logarithmic=axis == 0)
    low = np.union1d(nodes[nodes <= 0], np.clip([_TWILIGHT, 0.0], nodes[0], nodes[-1]))
    night, dusk, day = low[low <= _TWILIGHT], low[low >= _TWILIGHT], np.union1d(nodes[nodes > 0], low[-1:])
    pieces = ((night, PARTS[3]), (dusk, _TWILIGHT_PARTS), (day, PARTS[3]))
    return np.unique(np.concatenate([subdivided(piece, parts) for piece, parts in pieces if piece.size]))


def _strata(nodes: Floats, count: int, generator: np.random.Generator) -> Floats:
    """Random places on an axis, one in each of `count` equal parts of its cells."""
    if nodes.size == 1:
        return nodes
    place = (np.arange(count) + generator.random(count)) / count * (nodes.size - 1)
    return np.interp(place, np.arange(nodes.size), nodes)
