"""Nodes of the tables in channels: the initial ones, and those placed by the interpolation error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from skyshine.mat.quantities.channels.coordinates import HORIZON, LEVEL, ZENITH
from skyshine.schemas.arrays import Floats

# Elevations of the source [degree]; the job's own elevations bound the first.
_TWILIGHT, _RISE = (-18, -14, -10, -8, -6, -4.5), (-3, -2, -1.3, -0.6, 0, 0.6, 1.2, 2, 3)
SOURCE_ELEVATIONS = (*_TWILIGHT, *_RISE, 4, 5.5, 7.5, 10, 15, 20, 30, 40, 50, 60, 75, 90)
SCATTERING_ANGLES = (0, 0.5, 1, 1.5, 2, 3, 4, 5.5, 7.5, 10, 15, 20, 30, 40, 60, 80, 100, 120, 140, 160, 180)
_STEEP = 2.5  # power by which nodes crowd at the zenith


@dataclass(frozen=True)
class NodeCounts:
    """Numbers of nodes from which the placing starts.

    Attributes
    ----------
    share, height : int
        Along the way and over the heights of observers.
    ground, limb, upward : int
        Numbers of directions into the ground, of those that pass a lowest point, and of those above the level.
    """

    share: int = 20
    height: int = 24
    ground: int = 8
    limb: int = 14
    upward: int = 10

    def scaled(self, factor: float) -> NodeCounts:
        """So many times as many on each part, at least 4."""
        return NodeCounts(*(max(4, round(getattr(self, field.name) * factor)) for field in fields(self)))


@dataclass(frozen=True, eq=False)
class ChannelNodes:
    """Nodes of all axes, the directions in their three parts.

    Attributes
    ----------
    share, height_root : (X,), (Z,) arrays
        Coordinates as in `coordinates.RayPlaces`.
    ground, limb, upward : arrays
        Directions: 0 to 1, 2 to 3 and 3 to 4.
    source_elevation, scattering_angle : (SE,), (SA,) arrays
        degree.
    """

    share: Floats
    height_root: Floats
    ground: Floats
    limb: Floats
    upward: Floats
    source_elevation: Floats
    scattering_angle: Floats

    @classmethod
    def of(
        cls, counts: NodeCounts, heights_km: tuple[float, float], elevations_deg: tuple[float, float] = (-18.0, 90.0)
    ) -> ChannelNodes:
        """So many nodes between two heights above the ground, which may be one, and two elevations of the source:
        directions closer at 0, shares at both ends.
        """
        part, roots = np.linspace(0.0, 1.0, counts.share), np.cbrt(heights_km)
        return cls(
            part**2 * (3 - 2 * part),
            np.linspace(float(roots[0]), float(roots[1]), counts.height) if roots[1] > roots[0] else roots[:1],
            # Steep lines crowd at 0: their lengths, by which thermal light goes, differ while heights do not.
            np.linspace(0.0, 1.0, counts.ground) ** 3,
            np.linspace(HORIZON, LEVEL, counts.limb),
            # So do lines from 15 degree to the zenith, on the last twelfth.
            ZENITH - (ZENITH - LEVEL) * np.linspace(1.0, 0.0, counts.upward) ** _STEEP,
            elevation_nodes(SOURCE_ELEVATIONS, *elevations_deg),
            np.array(SCATTERING_ANGLES, float),
        )

    @property
    def direction(self) -> Floats:
        """(U,)."""
        return np.concatenate([self.ground, self.limb, self.upward[1:]])

    @property
    def shape(self) -> tuple[int, int, int]:
        """(X, Z, U)."""
        return self.share.size, self.height_root.size, self.direction.size

    @property
    def size(self) -> int:
        """Nodes of one field."""
        return int(np.prod(self.shape))

    @classmethod
    def parts(cls) -> tuple[str, ...]:
        """Names of the arrays."""
        return tuple(field.name for field in fields(cls))

    def with_spacing(self, part: str, edges: Floats, count: Floats) -> ChannelNodes:
        """With so many intervals (n,) between neighbours of edges (n + 1,) in a part, spread over them evenly."""
        total = np.concatenate([[0.0], np.cumsum(count)])
        intervals = max(1, round(float(total[-1])))
        nodes = np.interp(np.linspace(0.0, total[-1], intervals + 1), total, edges)
        return replace(self, **{part: nodes})


def elevation_nodes(nodes: Sequence[float], lowest: float, highest: float) -> Floats:
    """Elevations [degree] between those of a job, both included."""
    inside = [float(node) for node in nodes if lowest < node < highest]
    return np.unique([lowest, *inside, highest])
