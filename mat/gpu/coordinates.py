"""Axes of the textures of the air, and the lines of sight that their texels stand for.

Classic tables are read on range, elevation and altitude themselves. Tables in channels have coordinates in which the
horizon lies between two neighbouring texels: share, direction and height root of `quantities.channels.coordinates`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.channel_table import ChannelTable
from skyshine.schemas.arrays import Floats

RAY, PLAIN = "ray", "plain"
_DIVISIONS = {"range": 16, "elevation": 6, "altitude": 3}  # of a classic table's cells, for the choice of nodes
_SHARES = np.unique(np.concatenate([[0.0], np.geomspace(1e-5, 0.05, 80), np.linspace(0.05, 1.0, 120)]))
_STEEP = np.geomspace(1e-6, 0.2, 120)  # directions; at 5 km above the ground those of -88 to -2 degree


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines of sight of any shape: range [km], altitude of the observer [km], elevation [degree]."""

    range: Floats
    altitude: Floats
    elevation: Floats

    def where(self) -> dict[str, Any]:
        """As the tables are asked."""
        return {"range": self.range, "altitude": self.altitude, "elevation": self.elevation}

    def take(self, index: Any) -> Lines:
        """Some of them."""
        return Lines(self.range[index], self.altitude[index], self.elevation[index])


@dataclass(frozen=True, eq=False)
class AirCoordinates:
    """Coordinates of the textures of one table.

    Attributes
    ----------
    kind : str
        ``ray`` or ``plain``.
    range_km, altitude_km : (2,) array
        What the table is for.
    rays : RayCoordinates, optional
        Of ``ray``.
    nodes : tuple of three arrays
        Of ``plain``: the table's own nodes of range, elevation and altitude.
    """

    kind: str
    range_km: Floats
    altitude_km: Floats
    rays: RayCoordinates | None
    nodes: tuple[Floats, Floats, Floats]

    @classmethod
    def of(cls, air: AtmosphereTable, farthest_km: float | None = None) -> AirCoordinates:
        """Those of a table, for ranges up to one [km]."""
        if isinstance(air, ChannelTable):
            attributes = air.attributes
            heights = np.asarray(air.root.axes["height_root"].values, float)
            directions = np.asarray(air.root.axes["direction"].values, float)
            ground, scale = float(attributes["ground_altitude_km"]), float(attributes["scale_height_km"])
            radius = np.asarray(air.root.variables["effective_radius"].data, float)
            rays = RayCoordinates(ground, heights, radius, scale)
            ranges, altitudes = (np.asarray(attributes[name], float) for name in ("range_km", "altitude_km"))
            if farthest_km is not None:
                ranges = np.array([ranges[0], np.clip(farthest_km, *ranges)])
            return cls(RAY, ranges, altitudes, rays, (_SHARES, directions, heights))
        ranges, elevations, altitudes = (_own_nodes(air, name) for name in ("range", "elevation", "altitude"))
        if farthest_km is not None:
            end = float(np.clip(farthest_km, ranges[0], ranges[-1]))
            ranges = np.append(ranges[ranges < end], end)
        return cls(PLAIN, ranges[[0, -1]], altitudes[[0, -1]], None, (ranges, elevations, altitudes))

    def candidates(self, altitude: float | None) -> tuple[Floats, Floats, Floats]:
        """Places at which nodes of the three axes may stand; one altitude [km] stands alone."""
        if self.kind == RAY:
            assert self.rays is not None
            first, last = np.cbrt(np.maximum(self.altitude_km - self.rays.ground_km, 0.0))
            directions = np.union1d(_divided(self.nodes[1], 4), _STEEP)
            directions = directions[(directions <= 1) | (directions >= 2)]
            heights = np.linspace(first, last, 25) if last > first else np.array([first])
            if altitude is not None:
                heights = np.array([np.cbrt(max(altitude - self.rays.ground_km, 0.0))])
            return _SHARES, directions, heights
        axes = [
            _divided(nodes, _DIVISIONS[name], geometric=name == "range")
            for name, nodes in zip(("range", "elevation", "altitude"), self.nodes, strict=True)
        ]
        return axes[0], axes[1], axes[2] if altitude is None else np.array([altitude])

    def first_nodes(self, candidates: Sequence[Floats]) -> tuple[Floats, Floats, Floats]:
        """Nodes that must stand: the ends, and both sides of the horizon."""
        ends = [np.unique(axis[[0, -1]]) for axis in candidates]
        if self.kind == RAY:
            ends[1] = np.unique(np.concatenate([ends[1], [v for v in (1.0, 2.0, 3.0) if v in candidates[1]]]))
        return ends[0], ends[1], ends[2]

    def lines(self, first: Floats, second: Floats, third: Floats) -> Lines:
        """Lines of sight (n3, n2, n1) of all combinations of nodes."""
        shape = (third.size, second.size, first.size)
        if self.kind == PLAIN:
            return Lines(
                np.broadcast_to(first, shape),
                np.broadcast_to(third[:, None, None], shape),
                np.broadcast_to(second[:, None], shape),
            )
        assert self.rays is not None
        ranges, elevations = np.empty(shape), np.empty(shape)
        for layer, height in enumerate(third):
            for row, direction in enumerate(second):
                angle, way, _ = self.rays.line(float(height), float(direction), first)
                elevations[layer, row], ranges[layer, row] = np.clip(angle, -90.0, 90.0), way
        altitude = np.clip(self.rays.ground_km + third**3, *self.altitude_km)
        return Lines(
            np.clip(ranges, *self.range_km),
            np.broadcast_to(altitude[:, None, None], shape),
            elevations,
        )

    def locate(self, lines: Lines) -> tuple[Floats, Floats, Floats]:
        """Coordinates of lines of sight."""
        if self.kind == PLAIN:
            return lines.range, lines.elevation, lines.altitude
        assert self.rays is not None
        places = self.rays.locate(lines.range, lines.altitude, lines.elevation)
        return places.share, places.direction, places.height_root


def _own_nodes(air: AtmosphereTable, name: str) -> Floats:
    """Nodes of all axes of a name, those of single quantities too."""
    axes = [np.asarray(axis.values, float) for key, axis in air.root.axes.items() if _is(key, name)]
    return np.unique(np.concatenate(axes))


def _is(key: str, name: str) -> bool:
    return key == name or (key.endswith(f"_{name}") and not key.endswith(f"source_{name}"))


def _divided(nodes: Floats, count: int, *, geometric: bool = False) -> Floats:
    parts = [nodes[:1]]
    for low, high in pairwise(nodes):
        space = np.geomspace if geometric and low > 0 else np.linspace
        parts.append(space(low, high, count + 1)[1:])
    return np.unique(np.concatenate(parts))
