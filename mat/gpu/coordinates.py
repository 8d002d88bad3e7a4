"""Axes of the textures of the air, and the lines of sight that their texels represent.

They are the coordinates of the channels, share, direction and height root of `quantities.channels.coordinates`: the
horizon lies between two neighbouring texels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.schemas.arrays import Floats

_SHARES = np.unique(np.concatenate([[0.0], np.geomspace(1e-5, 0.05, 80), np.linspace(0.05, 1.0, 120)]))
_STEEP = np.geomspace(1e-6, 0.2, 120)  # directions; at 5 km above the ground those of -88 to -2 degree
_HEIGHTS = 25  # heights of the observer, among which layers are chosen


@dataclass(frozen=True, eq=False)
class AirCoordinates:
    """Coordinates of the textures of one table.

    Attributes
    ----------
    range_km, altitude_km : (2,) array
        Ends of what the table is for [km].
    directions : (D,) array
        Nodes of the table's own axis of direction.
    """

    range_km: Floats
    altitude_km: Floats
    rays: RayCoordinates
    directions: Floats

    @classmethod
    def of(cls, air: AtmosphereTable, farthest_km: float | None = None) -> AirCoordinates:
        """Coordinates of a table, for ranges up to one [km]."""
        attributes, axes = air.attributes, air.root.axes
        heights, directions = (np.asarray(axes[name].values, float) for name in ("height_root", "direction"))
        ground, scale = float(attributes["ground_altitude_km"]), float(attributes["scale_height_km"])
        radius = np.asarray(air.root.variables["effective_radius"].data, float)
        ranges, altitudes = (np.asarray(attributes[name], float) for name in ("range_km", "altitude_km"))
        if farthest_km is not None:
            ranges = np.array([ranges[0], np.clip(farthest_km, *ranges)])
        return cls(ranges, altitudes, RayCoordinates(ground, heights, radius, scale), directions)

    def candidates(self, altitude: float | None) -> tuple[Floats, Floats, Floats]:
        """Candidates of nodes of the three axes; a given altitude [km] is the only one of its axis."""
        directions = np.union1d(_divided(self.directions, 4), _STEEP)
        directions = directions[(directions <= 1) | (directions >= 2)]
        altitudes = self.altitude_km if altitude is None else np.array([altitude])
        lowest, highest = np.cbrt(np.maximum(altitudes[[0, -1]] - self.rays.ground_km, 0.0))
        heights = np.linspace(lowest, highest, _HEIGHTS) if highest > lowest else np.array([lowest])
        return _SHARES, directions, heights

    def first_nodes(self, candidates: Sequence[Floats]) -> tuple[Floats, Floats, Floats]:
        """Nodes that are always taken: the ends, and both sides of the horizon."""
        shares, directions, heights = (np.unique(axis[[0, -1]]) for axis in candidates)
        borders = [border for border in (1.0, 2.0, 3.0) if border in candidates[1]]
        return shares, np.unique(np.concatenate([directions, borders])), heights

    def lines(self, shares: Floats, directions: Floats, heights: Floats) -> LinesOfSight:
        """Lines of sight (n3, n2, n1) of all combinations of nodes."""
        shape = (heights.size, directions.size, shares.size)
        ranges, elevations = np.empty(shape), np.empty(shape)
        for layer, height in enumerate(heights):
            for row, direction in enumerate(directions):
                angle, way, _ = self.rays.line(float(height), float(direction), shares)
                elevations[layer, row], ranges[layer, row] = np.clip(angle, -90.0, 90.0), way
        altitude = np.clip(self.rays.ground_km + heights**3, *self.altitude_km)
        return LinesOfSight(
            np.clip(ranges, *self.range_km),
            np.broadcast_to(altitude[:, None, None], shape),
            elevations,
        )

    def locate(self, lines: LinesOfSight) -> tuple[Floats, Floats, Floats]:
        """Share, direction and height root of lines of sight."""
        located = self.rays.locate(lines.range, lines.altitude, lines.elevation)
        return located.share, located.direction, located.height_root


def _divided(nodes: Floats, count: int) -> Floats:
    """Nodes with more between them: cells in so many equal parts."""
    parts = [np.linspace(low, high, count + 1)[1:] for low, high in pairwise(nodes)]
    return np.concatenate([nodes[:1], *parts])
