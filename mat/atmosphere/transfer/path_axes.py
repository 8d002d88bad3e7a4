"""The axes of a table's lines of sight, as the transfer reads them from `quantities.grid.PathGrid`, and the part of
all paths that they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skyshine.schemas.arrays import Floats

# Least share and number of the lines that sample all paths of a job: those of its smallest part are not fewer, nor
# fewer than so many.
_LEAST_SHARE, _LEAST_LINES = 0.25, 16


@dataclass(frozen=True)
class PathScope:
    """The part of a job's paths that its scenes read: random lines of sight are as dense in it as they are in all.

    Attributes
    ----------
    share : float
        Share of the cells of range, altitude and elevation.
    highest_surface : float
        Height above the ground up to which light on surfaces is read, m.
    lowest_source : float
        Elevation above which the source is everywhere along the paths, degree.
    """

    share: float = 1.0
    highest_surface: float = math.inf
    lowest_source: float = -90.0

    @property
    def is_part(self) -> bool:
        """Whether scenes read less than all paths."""
        return self.share < 1

    def lines(self, count: int, minimum: int = _LEAST_LINES) -> int:
        """How many lines sample this part where `count` sample all."""
        return max(math.ceil(max(self.share, _LEAST_SHARE) * count), min(minimum, count))

    def heights(self, nodes: Sequence[float] | Floats) -> Floats:
        """Of ascending heights above the ground [m] those that are read: up to the first at or above the highest."""
        heights = np.asarray(nodes, float)
        return heights[: int(np.searchsorted(heights, self.highest_surface)) + 1]


ALL_PATHS = PathScope()


class PathAxes(Protocol):
    """Axes of the atmospheric tables, each a strictly increasing array."""

    @property
    def range_km(self) -> Floats:
        """Range (R,) [km]."""

    @property
    def altitude_km(self) -> Floats:
        """Altitude (A,) of the observer above sea level [km]."""

    @property
    def elevation_deg(self) -> Floats:
        """Elevation (E,) of the line of sight at the observer [degree]."""

    @property
    def source_elevation_deg(self) -> Floats:
        """Elevation (SE,) of the source [degree]."""

    @property
    def source_azimuth_deg(self) -> Floats:
        """Azimuth (SA,) of the source from that of the line of sight, or its scattering angle [degree]."""
