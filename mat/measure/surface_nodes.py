"""Grids of the temperature table by tolerance, as `atmosphere_nodes` places those of the atmospheric tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.refinement import fewest_nodes, subdivided
from skyshine.mat.measure.sampling import random_places
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import CheckFailed

PERIODS = {"azimuth_deg": 360.0, "time_h": 24.0}
PARTS = {"altitude_km": 4, "azimuth_deg": 6, "slope_deg": 6, "time_h": 6}
_OTHERS = {"altitude_km": 3, "azimuth_deg": 6, "slope_deg": 5, "time_h": 24}
_FIRST_SHARE, _PASSES, _MARGIN = 0.6, 5, 0.9
_TESTS = {"altitude_km": 4, "azimuth_deg": 8, "slope_deg": 8, "time_h": 24}
_DECIMALS = 9  # of a node, so that clock times and angles stay plain numbers


TemperatureOn = Callable[[dict[str, Floats]], Floats]


@dataclass(frozen=True, eq=False)
class RefinedAxes:
    """Axes that hold a tolerance, with the error at random points, K."""

    axes: dict[str, Floats]
    p99: float
    maximum: float


def refined_axes(
    temperature: TemperatureOn,
    base: Mapping[str, npt.ArrayLike],
    materials: int,
    tolerance: float,
    *,
    seed: int,
    max_nodes: int,
) -> RefinedAxes:
    """The fewest nodes, between the ends of a job's axes, that hold a tolerance.

    Parameters
    ----------
    temperature : callable
        (M, A, Z, S, T) temperatures [K] on axes altitude_km, azimuth_deg, slope_deg, time_h.
    base : mapping of str to (n,) array
        The job's axes.
    materials : int
        M.
    tolerance : float
        K.
    seed, max_nodes : int
        Of the random points; nodes that the table may have.

    Raises
    ------
    CheckFailed
        The tolerance cannot be reached with so many nodes.
    """
    generator, size = random_stream(seed, Stream.TEMPERATURE_NODES), 0
    closed = {name: _closed(name, nodes) for name, nodes in base.items()}
    profiles = {name: _profile(name, temperature, closed, generator) for name in base}
    places = {name: within_period(name, random_places(closed[name], n, generator)) for name, n in _TESTS.items()}
    truth = temperature(places)
    share, reached = _FIRST_SHARE, ""
    for _ in range(_PASSES):
        axes = {name: _nodes(name, *profiles[name], share * tolerance, base[name]) for name in base}
        size = materials * int(np.prod([nodes.size for nodes in axes.values()]))
        if size > max_nodes:
            break
        error = np.abs(read_temperature(temperature(axes), axes, places) - truth)
        p99, maximum = float(np.percentile(error, 99)), float(error.max())
        if p99 <= _MARGIN * tolerance and maximum <= 2 * _MARGIN * tolerance:
            return RefinedAxes(axes, p99, maximum)
        reached = f"; an error of {p99:.2g} K (99 %), {maximum:.2g} K (worst) is left with {size:,}"
        share *= float(np.clip(0.9 * _MARGIN * tolerance * min(1 / p99, 2 / maximum), 0.25, 0.8))
    widest = max(axes, key=lambda name: axes[name].size)
    raise CheckFailed(
        f"surface_grid.tolerance {tolerance:g} K cannot be held with {max_nodes:,} nodes: it takes {size:,}{reached},"
        f" most for the {widest.rsplit('_', 1)[0]}, {axes[widest].size}; raise it, shorten that axis, allow more with"
        " surface_grid.most_nodes, or name closer axes to start from"
    )


def within_period(axis: str, values: Floats) -> Floats:
    """Values of a periodic axis within its first period; those of another axis, also below 0, as they are."""
    return np.mod(values, PERIODS[axis]) if axis in PERIODS else values


def read_temperature(table: Floats, axes: Mapping[str, npt.ArrayLike], places: dict[str, Floats]) -> Floats:
    """Interpolated temperatures (M, ...) at all combinations of places."""
    rules = [
        AxisRule(name, np.asarray(nodes, float), *((PERIODIC, PERIODS[name]) if name in PERIODS else ()))
        for name, nodes in axes.items()
    ]
    mesh = dict(zip(places, np.meshgrid(*places.values(), indexing="ij", sparse=True), strict=True))
    return np.stack([interpolate(one.astype(float), rules, mesh) for one in table])


def _closed(name: str, axis: npt.ArrayLike) -> Floats:
    nodes = np.asarray(axis, float)
    return np.append(nodes, nodes[0] + PERIODS[name]) if name in PERIODS and nodes.size > 1 else nodes


def _profile(
    axis: str, temperature: TemperatureOn, closed: dict[str, Floats], generator: np.random.Generator
) -> tuple[Floats, Floats]:
    """Places (n,) along an axis and temperatures (K, n) there, at random places of the others."""
    places = np.round(subdivided(closed[axis], PARTS[axis]), _DECIMALS)
    others = {
        name: places if name == axis else np.unique(random_places(nodes, _OTHERS[name], generator))
        for name, nodes in closed.items()
    }
    wrapped = {
        name: np.unique(within_period(name, values)) if name in PERIODS else values for name, values in others.items()
    }
    table = np.moveaxis(temperature(wrapped), 1 + list(closed).index(axis), -1)
    values = table.reshape(-1, table.shape[-1]).astype(float)
    if axis in PERIODS and places.size > 1:
        turn = np.argsort(np.argsort(np.mod(places[:-1], PERIODS[axis])))
        values = values[:, np.append(turn, turn[0])]
    return places, values


def _nodes(name: str, places: Floats, values: Floats, allowed: float, base: npt.ArrayLike) -> Floats:
    if places.size == 1:
        return np.asarray(base, float)

    def error(start: int, end: int) -> Floats:
        share = (places[start + 1 : end] - places[start]) / (places[end] - places[start])
        read: Floats = values[:, start, None] * (1 - share) + values[:, end, None] * share
        return read - values[:, start + 1 : end]

    nodes = places[fewest_nodes(places, error, allowed)]
    return np.sort(np.mod(nodes[:-1], PERIODS[name])) if name in PERIODS else nodes
