"""Grids of the atmospheric tables by tolerance: for each quantity the axes that meet the tolerance.

Each axis is first treated alone: the quantity is computed at many places along the axis, at random values of the other
axes, and the fewest places that meet the tolerance are kept as nodes. Then the table is measured on random lines of
sight. Where its error exceeds the tolerance, cells of the axis with the largest curvature are halved, those first that
gain most for their cost, until new random lines show that the tolerance holds.

The nodes of path radiance are placed by scattering angle if the job's azimuths cover the full circle.

Direct light begins with a step when the source rises over the horizon of a surface, at an elevation that falls with the
surface's height. No grid of linear cells holds a step to twice a tolerance: in cells with the horizon inside, the
tolerance bounds the share of reads with a larger error, not their largest error, and that error is measured separately.
Of the other reads of path radiance and direct light, too, a few in ten thousand may err by more than twice the
tolerance: lines along the ground towards a low Sun.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from skyshine.mat.measure.axis_profile import AxisProfile
from skyshine.mat.measure.probes import Probes
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.grid import PathGrid, ScatteringGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.tables.gridded import FIELDS, QUANTITIES, Gridded
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.errors import CheckFailed

# Scattering angles [degree], closer towards the source, in place of the job's azimuths.
_ANGLES = np.array([0, 1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 60, 90, 120, 150, 180], float)
_START = 1.0  # of the tolerance, for each axis looked at by itself
_LOOSEST = 20.0  # tolerances: that loose the start may be where the table would be too large
_DRAWS = 2  # of random lines in each pass
_PASSES = 20
_GROWTH, _FAST_GROWTH, _SMALL = 1.6, 2.5, 100_000  # of a table in one pass, at most; of one of fewer nodes than that
# Lines in each draw: few for sky light, which takes as long as all the rest.
_LINES = {"beta_star": 2000, "path_radiance_ratio": 1000, "ambient": 240, "direct": 2000}
_CAUTION = {"ambient_radiance": 0.6}  # of the tolerance, where so few reads do not show how bad the worst of others is
# of the reads of a quantity may be worse than the tolerance: those of all four together are then less than 1 %
_OVER = 0.003
_MARGIN = 0.95  # of the tolerance, there: other points are a little worse
_WORST = 1.6  # tolerances: the worst of a thousand other points may be as much as two
# Of the reads of a quantity, those that may be worse even so: where the sun shines along the horizon, no affordable
# table meets the tolerance for the last few.
_FAR = {"path_radiance_ratio": 1.5e-4, "direct_radiance": 1.5e-4}


@dataclass(frozen=True, eq=False)
class Placed:
    """A quantity on axes that hold a tolerance.

    Attributes
    ----------
    table : Gridded
    p99, maximum : float
        Of the error at random points, in the tolerance's unit; the largest without direct light in cells with the
        source's rise inside.
    horizon_share, horizon_maximum : float
        Of the points, those where direct light is worse than the tolerance in a cell with the source's rise inside; its
        largest error there.
    uniform : tuple of int
        Nodes that each axis would take, spaced equally (ranges in their logarithm), to be as good along it.
    """

    table: Gridded
    p99: float
    maximum: float
    horizon_share: float
    horizon_maximum: float
    uniform: tuple[int, ...]

    @property
    def ratio(self) -> float:
        """Nodes of the uniform grid over these."""
        return float(np.prod([float(n) for n in self.uniform])) / self.table.values.size


TableOf = Callable[[PathGrid, str], AtmosphericQuantities]
ProbesOf = Callable[[np.random.Generator, str, int], Probes]


def placed_grids(
    table_of: TableOf,
    probes_of: ProbesOf,
    base: PathGrid,
    scales: Mapping[str, tuple[Scale, float]],
    *,
    seed: int,
    max_nodes: int,
) -> dict[str, Placed]:
    """For each quantity the fewest nodes, between the ends of a job's axes, that hold its tolerance.

    Parameters
    ----------
    table_of : callable
        On a grid, the one quantity that is named as in `AtmosphericQuantities`.
    probes_of : callable
        Random lines of sight on the job's axes, drawn with a generator, with the one quantity on them; how many.
    base : PathGrid
        The job's axes: their ends, and by their cells how the random points lie.
    scales : mapping of str to (Scale, float)
        By quantity, in what the tolerance counts, and the tolerance.
    seed, max_nodes : int
        Of the random points; nodes that a table may have.

    Raises
    ------
    CheckFailed
        A tolerance cannot be reached with so many nodes.
    """
    return {
        name: _placed(
            name,
            table_of,
            probes_of,
            base,
            *scales[name],
            random_stream(seed, Stream.ATMOSPHERE_NODES, number),
            max_nodes,
        )
        for number, name in enumerate(QUANTITIES)
        if name in scales
    }


def _placed(
    name: str,
    table_of: TableOf,
    probes_of: ProbesOf,
    base: PathGrid,
    scale: Scale,
    asked: float,
    generator: np.random.Generator,
    max_nodes: int,
) -> Placed:
    (key, count), tolerance = QUANTITIES[name], asked * _CAUTION.get(name, 1.0)
    if name == "path_radiance_ratio" and base.source_azimuth_deg[0] == 0 and base.source_azimuth_deg[-1] == 180:
        base = ScatteringGrid(base.range_km, base.altitude_km, base.elevation_deg, base.source_elevation_deg, _ANGLES)
    profiles = [AxisProfile.of(name, axis, table_of, base, scale, generator) for axis in range(count)]
    axes = _first_axes(profiles, tolerance, max_nodes)
    fresh: _Measured | None = None
    worst_axis: int | None = None
    lines: list[Probes] = []
    for _ in range(_PASSES):
        if _size(axes) > max_nodes:
            break
        grid = type(base)(*axes, *(getattr(base, field)[:1] for field in FIELDS[count:]))
        quantities = table_of(grid, key)
        table = Gridded(grid, getattr(quantities, key), quantities.valid)
        # Earlier lines are measured again, so that cells once refined stay good; whether the tolerance holds is decided
        # on fresh lines.
        lines += [probes_of(generator, key, _LINES[key]) for _ in range(_DRAWS)]
        errors = [_Measured.of(name, table, probes, scale, tolerance) for probes in lines]
        fresh = _Measured.together(errors[-_DRAWS:])
        if fresh.holds:
            return Placed(
                table,
                *fresh.summary,
                tuple(profile.uniform(nodes) for profile, nodes in zip(profiles, axes, strict=True)),
            )
        axes, worst_axis = _halved(name, table, lines, errors, [profile.logarithmic for profile in profiles])
    error = f" after an error of {fresh.summary[0]:.2g} (99 %), {fresh.summary[1]:.2g} (worst)" if fresh else ""
    longest = int(np.argmax([nodes.size for nodes in axes]))
    axis = FIELDS[longest if worst_axis is None else worst_axis].rsplit("_", 1)[0]
    raise CheckFailed(
        f"atmosphere_grid.tolerance {asked:g} cannot be held for {name} with {max_nodes:,} nodes: it takes more than"
        f" {' x '.join(str(nodes.size) for nodes in axes)} = {_size(axes):,}{error}, most for the"
        f" {axis.replace('_', ' ')}; raise it, shorten that axis, or allow more with atmosphere_grid.most_nodes"
    )


def _first_axes(profiles: list[AxisProfile], tolerance: float, max_nodes: int) -> list[Floats]:
    """Nodes that hold the tolerance along each axis by itself, or a looser one where the table would be too large."""
    allowed = _START * tolerance
    axes = [profile.nodes(allowed) for profile in profiles]
    while _size(axes) > max_nodes and allowed < _LOOSEST * tolerance:
        allowed *= 1.5
        axes = [profile.nodes(allowed) for profile in profiles]
    return axes


def _size(axes: list[Floats]) -> int:
    return int(np.prod([nodes.size for nodes in axes]))


@dataclass(frozen=True, eq=False)
class _Measured:
    """Errors of a quantity in tolerances at n points: 0 behind the ground; where the source rises in the cell; how many
    are above ground.
    """

    name: str
    error: Floats
    rising: Booleans
    counts: int
    tolerance: float

    @classmethod
    def of(cls, name: str, table: Gridded, probes: Probes, scale: Scale, tolerance: float) -> _Measured:
        error = np.abs(probes.error(name, table, scale)) / tolerance
        above = probes.above_ground(name, error)
        lit = probes.lit(table) if name == "direct_radiance" else np.zeros(error.shape)
        rising = above & (lit > 0) & (lit < 1)
        return cls(name, np.where(above, error, 0.0), rising, int(np.count_nonzero(above)), tolerance)

    @classmethod
    def together(cls, parts: list[_Measured]) -> _Measured:
        error, rising = (
            np.concatenate([np.ravel(getattr(part, name)) for part in parts]) for name in ("error", "rising")
        )
        return cls(parts[0].name, error, rising, sum(part.counts for part in parts), parts[0].tolerance)

    @property
    def too_many(self) -> bool:
        """More are worse than the tolerance than may be."""
        return bool(np.count_nonzero(self.error > _MARGIN) > _OVER * self.counts)

    @property
    def holds(self) -> bool:
        far = np.count_nonzero((self.error > _WORST) & ~self.rising)
        return bool(not self.too_many and far <= _FAR.get(self.name, 0.0) * self.counts)

    @property
    def summary(self) -> tuple[float, float, float, float]:
        """99th percentile, largest off the horizon, share of reads worse on the horizon and largest there; in the
        tolerance's unit.
        """
        ranked, rank = np.sort(self.error, axis=None), int(0.01 * self.counts)
        p99 = ranked[max(ranked.size - 1 - rank, 0)] if ranked.size else 0.0
        largest = [np.max(self.error, where=where, initial=0.0) for where in (~self.rising, self.rising)]
        share = np.count_nonzero(self.rising & (self.error > 1)) / max(self.counts, 1)
        return (
            float(p99 * self.tolerance),
            float(largest[0] * self.tolerance),
            share,
            float(largest[1] * self.tolerance),
        )


def _halved(
    name: str, table: Gridded, lines: list[Probes], errors: list[_Measured], logarithmic: list[bool]
) -> tuple[list[Floats], int | None]:
    """Axes with the cells halved that are to blame for the worst reads, and the axis most to blame."""
    many, parts = _Measured.together(errors).too_many, []
    for probes, measured in zip(lines, errors, strict=True):
        bad = (measured.error > _MARGIN) & (many | ~measured.rising)
        located = table.located(probes.at(name))
        parts.append(
            (
                {axis: np.broadcast_to(value, bad.shape)[bad] for axis, value in located.items()},
                measured.error[bad],
                measured.rising[bad],
            )
        )
    places = {axis: np.concatenate([part[0][axis] for part in parts]) for axis in table.axes}
    error, rising = (np.concatenate([part[number] for part in parts]) for number in (1, 2))
    blame = np.stack([_bend(table, places, axis) for axis in range(len(table.nodes))])
    if np.any(rising):
        at = {axis: value[rising] for axis, value in places.items()}
        blame[:, rising] = np.stack([_dusk(table, at, axis) for axis in range(len(table.nodes))])
    worst, score = np.argmax(blame, axis=0), {}
    for axis, (label, nodes) in enumerate(zip(table.axes, table.nodes, strict=True)):
        if nodes.size == 1:
            continue
        mine = worst == axis
        cells = np.clip(np.searchsorted(nodes, places[label][mine], side="right") - 1, 0, nodes.size - 2)
        for cell, amount in enumerate(np.bincount(cells, error[mine] ** 2, nodes.size - 1)):
            if amount > 0:
                score[axis, cell] = amount * nodes.size  # a node more costs one in so many
    axes, size = [list(nodes) for nodes in table.nodes], [nodes.size for nodes in table.nodes]
    for axis, cell in sorted(score, key=lambda key: -score[key]):
        low, high = table.nodes[axis][cell], table.nodes[axis][cell + 1]
        axes[axis].append(np.sqrt(low * high) if logarithmic[axis] else (low + high) / 2)
        if np.prod([len(nodes) / n for nodes, n in zip(axes, size, strict=True)]) > (
            _GROWTH if np.prod(size) > _SMALL else _FAST_GROWTH
        ):
            break
    worst_axis = int(np.argmax(np.bincount(worst, error**2, len(axes)))) if worst.size else None
    return [np.unique(nodes) for nodes in axes], worst_axis


def _bend(table: Gridded, places: dict[str, Floats], axis: int) -> Floats:
    """Error (n,) that the bend of the table around places leaves along one axis."""
    label, nodes = table.axes[axis], table.nodes[axis]
    x = places[label]
    if nodes.size < 3:
        return np.zeros(x.size)
    cell = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, nodes.size - 2)
    around = np.clip(cell + np.arange(-1, 3)[:, None], 0, nodes.size - 1)
    values = np.stack([table.read_at(table.values, places | {label: nodes[at]}) for at in around])
    step = np.diff(nodes[around], axis=0)
    slope = np.diff(values, axis=0) / np.where(step > 0, step, np.inf)
    width = np.where((step[:-1] > 0) & (step[1:] > 0), (step[:-1] + step[1:]) / 2, np.inf)
    bend = np.abs(np.diff(slope, axis=0) / width).max(axis=0)
    error: Floats = 0.5 * (x - nodes[cell]) * (nodes[cell + 1] - x) * bend
    return error


def _dusk(table: Gridded, places: dict[str, Floats], axis: int) -> Floats:
    """How much of the horizon (n,) lies across one axis: the change of the lit share over the cell."""
    label, nodes = table.axes[axis], table.nodes[axis]
    cell = np.clip(np.searchsorted(nodes, places[label], side="right") - 1, 0, max(nodes.size - 2, 0))
    lit = (table.values > 0).astype(float)
    ends = [table.read_at(lit, places | {label: nodes[np.minimum(cell + step, nodes.size - 1)]}) for step in (0, 1)]
    change: Floats = np.abs(ends[1] - ends[0])
    return change
