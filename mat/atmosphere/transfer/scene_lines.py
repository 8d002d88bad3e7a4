"""Random lines of sight as scenes look: to the ground, along the horizon, to the sky, and in every cell of a table.

A third of the lines ends on the ground, for most pixels show the ground. A third lies in the cells of altitude
and elevation, as many lines in each, and finds what a single cell has wrong. A sixth passes the limb, and a sixth goes
up: directions even in solid angle, heights of observers and ranges even in their logarithm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells, trace
from skyshine.mat.atmosphere.transfer.path_axes import PathAxes
from skyshine.schemas.arrays import Booleans, Floats, Integers

LOWEST_KM = 0.01  # height above the ground of the lowest observer whose lines end on it
_GROUND, _CELLS, _LIMB = 1 / 3, 1 / 3, 1 / 6  # shares of the lines; the rest goes up
# Pairs of height and direction drawn for one line to the ground: most that are no line at all have too short a range.
_CANDIDATES = 40
_RADIUS_KM = EARTH_RADIUS / 1e3
REGIONS = ("ground", "air", "sky", "limb")
SKY_KM = 20.0  # altitude above which a line has left 95 % of the air


@dataclass(frozen=True, eq=False)
class SceneLines:
    """n lines of sight at R ranges each.

    Attributes
    ----------
    altitude_km, elevation_deg : (n,) arrays
        Observer above sea level; line of sight above the horizontal there.
    range_km : (n, R) array
        Increasing along each line; of lines that end on the ground, the last range is that to the ground.
    on_ground : (n,) bool array
        Lines that end on the ground.
    """

    altitude_km: Floats
    elevation_deg: Floats
    range_km: Floats
    on_ground: Booleans

    @classmethod
    def drawn(cls, shells: Shells, base: PathAxes, count: int, generator: np.random.Generator) -> SceneLines:
        """Draw lines between the ends of the axes of a job, in random order."""
        altitude, elevation, ranges = lines_in_cells(base, count, generator)
        order = generator.permutation(count)
        to_ground, _, limb, upward = np.split(order, np.round(count * np.cumsum([_GROUND, _CELLS, _LIMB])).astype(int))
        for rows, draw in ((to_ground, _towards_ground), (limb, _past_the_limb), (upward, _upward)):
            directions = draw(base, shells.altitude[0] / 1e3, rows.size, generator)
            if directions is not None:  # the job has such lines
                altitude[rows], elevation[rows] = directions
                ranges[rows] = _even_in_logarithm(base, rows.size, generator)
        return cls._ended(shells, base, altitude, elevation, ranges, generator)

    @classmethod
    def of_pixels(cls, shells: Shells, base: PathAxes, count: int, generator: np.random.Generator) -> SceneLines | None:
        """Draw lines of one range, to the ground, half of them of observers at heights that are even up to `SKY_KM`: a
        camera in an aircraft has as many pixels as one on a mast. None where the job has no such lines.
        """
        ground_km = shells.altitude[0] / 1e3
        height = _heights(base, ground_km, _CANDIDATES * count, generator)
        even = generator.uniform(height.min(), np.clip(SKY_KM, height.min(), height.max()), height.size)
        height = np.where((generator.random(height.size) < 0.5) & (height.min() < SKY_KM), even, height)
        directions = _meeting_the_ground(base, ground_km, height, count, generator)
        if directions is None:
            return None
        lines = cls._ended(shells, base, *directions, np.full((count, 1), base.range_km[-1]), generator)
        return lines.some(np.flatnonzero(lines.on_ground)) if lines.on_ground.any() else None

    def some(self, lines: Integers) -> SceneLines:
        """Lines of some numbers."""
        return SceneLines(
            self.altitude_km[lines], self.elevation_deg[lines], self.range_km[lines], self.on_ground[lines]
        )

    def regions(self) -> dict[str, Booleans]:
        """Which ends (n, R) of the lines lie in each of `REGIONS`, one for each: on the ground, on upward lines above
        `SKY_KM`, on lines that look down past the ground, and all other.
        """
        farthest = np.arange(self.range_km.shape[1]) == self.range_km.shape[1] - 1
        meets, start = self.on_ground[:, None], _RADIUS_KM + self.altitude_km[:, None]
        sine = np.sin(np.radians(self.elevation_deg))[:, None]
        # Ends of straight lines over a round Earth.
        end = np.sqrt(start**2 + self.range_km**2 + 2 * start * self.range_km * sine) - _RADIUS_KM
        # Lines that meet the ground beyond the longest range look down steeply, but from space.
        dip = np.degrees(np.arccos(_RADIUS_KM / (_RADIUS_KM + np.maximum(self.altitude_km, 0.0))))[:, None]
        elevation = self.elevation_deg[:, None]
        ground, sky = meets & farthest, (elevation >= 0) & (end >= SKY_KM)
        limb = np.broadcast_to((elevation < 0) & (elevation > -dip) & ~meets, ground.shape)
        return dict(zip(REGIONS, (ground, ~(ground | limb | sky), sky, limb), strict=True))

    @classmethod
    def _ended(
        cls,
        shells: Shells,
        base: PathAxes,
        altitude: Floats,
        elevation: Floats,
        ranges: Floats,
        generator: np.random.Generator,
    ) -> SceneLines:
        """The lines with their last range on the ground where they meet it within the ranges of the job; ranges that
        lay behind it are drawn again before it.
        """
        rays = trace(shells, altitude * 1e3, np.radians(elevation))
        end = rays.end / 1e3
        shortest, longest = base.range_km[0], base.range_km[-1]
        on_ground = rays.ground & (end >= shortest) & (end <= longest) & (base.range_km.size > 1)
        ground = np.where(on_ground, end, longest)[:, None]
        # Ranges of 0 alone have no logarithm.
        nearest = max(float(shortest), min(1e-3, float(longest)), np.finfo(float).tiny)
        before = nearest * (np.maximum(ground, nearest) / nearest) ** generator.random(ranges.shape)
        ranges = np.sort(np.where(on_ground[:, None] & (ranges > ground), before, ranges), axis=1)
        ranges[on_ground, -1] = end[on_ground]
        return cls(altitude, elevation, ranges, on_ground)


def _towards_ground(
    base: PathAxes, ground_km: float, count: int, generator: np.random.Generator
) -> tuple[Floats, Floats] | None:
    """Altitudes and elevations of lines that meet the ground within the ranges of a job: even in solid angle and in the
    logarithm of height, which for one direction is that of range.
    """
    height = _heights(base, ground_km, max(count, 1) * _CANDIDATES, generator)
    return _meeting_the_ground(base, ground_km, height, count, generator)


def _meeting_the_ground(
    base: PathAxes, ground_km: float, height: Floats, count: int, generator: np.random.Generator
) -> tuple[Floats, Floats] | None:
    """The same of the first `count` of some heights [km] in whose random directions lines do."""
    steepest, flattest = np.sin(np.radians(np.clip(-base.elevation_deg[[0, -1]], 0.0, 90.0)))
    if not flattest < steepest:
        return None
    sine = generator.uniform(flattest, steepest, height.size)
    horizon = np.sqrt(2 * height / _RADIUS_KM)  # dip of a straight line; a refracted one meets the ground there too
    longest, shortest = base.range_km[-1], base.range_km[0]
    # The range over a flat Earth is a little shorter than the true one, twice as long at the horizon.
    meets = (sine > horizon) & (2 * height <= sine * longest) & (height >= sine * shortest)
    chosen = np.flatnonzero(meets)[:count]
    if chosen.size < count:
        return None
    return ground_km + height[chosen], -np.degrees(np.arcsin(sine[chosen]))


def _past_the_limb(
    base: PathAxes, ground_km: float, count: int, generator: np.random.Generator
) -> tuple[Floats, Floats] | None:
    """The same of lines that look below the horizontal and pass a lowest point above the ground."""
    height = _heights(base, ground_km, count, generator)
    # The straight line that touches the ground; refraction lets a fifteenth of them meet it.
    lowest = -np.degrees(np.arccos(_RADIUS_KM / (_RADIUS_KM + height)))
    low, high = np.maximum(lowest, base.elevation_deg[0]), np.minimum(0.0, base.elevation_deg[-1])
    if np.any(low >= high):
        return None
    return ground_km + height, generator.uniform(low, high)


def _upward(
    base: PathAxes, ground_km: float, count: int, generator: np.random.Generator
) -> tuple[Floats, Floats] | None:
    """The same of lines above the horizontal, even in solid angle."""
    lowest, highest = np.sin(np.radians(np.clip(base.elevation_deg[[0, -1]], 0.0, 90.0)))
    if lowest >= highest:
        return None
    sine = generator.uniform(lowest, highest, count)
    return ground_km + _heights(base, ground_km, count, generator), np.degrees(np.arcsin(sine))


def _heights(base: PathAxes, ground_km: float, count: int, generator: np.random.Generator) -> Floats:
    """Heights (count,) of observers above the ground [km], even in their logarithm from `LOWEST_KM` on."""
    low, high = (max(float(altitude) - ground_km, 0.0) for altitude in base.altitude_km[[0, -1]])
    low = min(max(low, LOWEST_KM), high)
    if not low < high:
        return np.full(count, high)
    return np.exp(generator.uniform(np.log(low), np.log(high), count))


def _even_in_logarithm(base: PathAxes, count: int, generator: np.random.Generator) -> Floats:
    """Ranges (count, R) [km], one in each of R equal parts of the logarithm between a job's shortest and longest."""
    steps, (shortest, longest) = max(1, base.range_km.size - 1), base.range_km[[0, -1]]
    if base.range_km.size == 1:
        return np.full((count, 1), longest)
    shortest = max(float(shortest), min(LOWEST_KM, 0.5 * float(longest)))
    share = (np.arange(steps) + generator.random((count, steps))) / steps
    ranges: Floats = shortest * (longest / shortest) ** share
    return ranges


def lines_in_cells(base: PathAxes, count: int, generator: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Altitude, elevation (n,) and ranges (n, R) of lines, as many in each cell of altitude and elevation, a range in
    each cell of ranges.
    """
    cells = max(1, base.altitude_km.size - 1), max(1, base.elevation_deg.size - 1)
    turn = generator.permutation(cells[0] * cells[1])[np.arange(count) % (cells[0] * cells[1])]
    altitude, elevation = (
        _in_cell(nodes, cell, generator)
        for nodes, cell in zip((base.altitude_km, base.elevation_deg), np.divmod(turn, cells[1]), strict=True)
    )
    steps = max(1, base.range_km.size - 1)
    return altitude, elevation, _in_cell(base.range_km, np.broadcast_to(np.arange(steps), (count, steps)), generator)


def _in_cell(nodes: Floats, cell: Integers, generator: np.random.Generator) -> Floats:
    """A random place in each of some cells of an axis; an axis of one node gives that node."""
    if nodes.size == 1:
        return np.full(np.shape(cell), nodes[0])
    values: Floats = nodes[cell] + generator.random(np.shape(cell)) * (nodes[cell + 1] - nodes[cell])
    return values


def spread(nodes: Floats, count: int, generator: np.random.Generator) -> Floats:
    """Random places (count,) on an axis, one in each of as many equal parts of its cells, in random order."""
    position = (generator.permutation(count) + generator.random(count)) / max(count, 1) * (nodes.size - 1)
    values: Floats = np.interp(position, np.arange(nodes.size), nodes)
    return values
