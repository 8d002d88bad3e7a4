"""Nodes of the channel tables: few numbers say how many on each part of each axis."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from skyshine.mat.quantities.channels.coordinates import HORIZON, LEVEL, ZENITH
from skyshine.schemas.arrays import Floats

_STEEP = 2.5  # power by which nodes crowd at the zenith


@dataclass(frozen=True)
class NodeCounts:
    """Numbers of nodes.

    Attributes
    ----------
    share, height : int
        Along the way and over the heights of observers.
    ground, limb, upward : int
        Of directions into the ground, of those that pass a lowest point, and of those above the level.
    """

    share: int = 20
    height: int = 24
    ground: int = 8
    limb: int = 14
    upward: int = 10

    @property
    def size(self) -> int:
        """Nodes of one field."""
        return self.share * self.height * (self.ground + self.limb + self.upward - 1)

    def grown(self, name: str, factor: float) -> NodeCounts:
        """More on one part."""
        count: int = getattr(self, name)
        return replace(self, **{name: max(count + 1, round(count * factor))})

    @classmethod
    def names(cls) -> tuple[str, ...]:
        return tuple(field.name for field in fields(cls))


@dataclass(frozen=True, eq=False)
class ChannelNodes:
    """Nodes of the three axes.

    Attributes
    ----------
    share, height_root, direction : (X,), (Z,), (U,) arrays
        As the coordinates of `coordinates.RayPlaces`.
    """

    share: Floats
    height_root: Floats
    direction: Floats

    @classmethod
    def of(cls, counts: NodeCounts, lowest_km: float, highest_km: float) -> ChannelNodes:
        """Between two heights above the ground [km], which may be one: directions closer at 0, shares at both ends."""
        part = np.linspace(0.0, 1.0, counts.share)
        roots = np.cbrt([lowest_km, highest_km])
        height = np.linspace(float(roots[0]), float(roots[1]), counts.height) if roots[1] > roots[0] else roots[:1]
        direction = np.concatenate(
            [
                # Steep lines crowd at 0: their lengths, by which thermal light goes, differ while heights do not.
                np.linspace(0.0, 1.0, counts.ground) ** 3,
                np.linspace(HORIZON, LEVEL, counts.limb),
                # So do lines from 15 degree to the zenith, on the last twelfth.
                ZENITH - (ZENITH - LEVEL) * np.linspace(1.0, 0.0, counts.upward)[1:] ** _STEEP,
            ]
        )
        return cls(part**2 * (3 - 2 * part), height, direction)

    @property
    def shape(self) -> tuple[int, int, int]:
        """(X, Z, U)."""
        return self.share.size, self.height_root.size, self.direction.size
