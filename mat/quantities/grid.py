"""The axes of the atmospheric quantities."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    from skyshine.mat.atmosphere.transfer.air import SpectralAir
    from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight


@dataclass(frozen=True, eq=False)
class PathGrid:
    """Axes of the atmospheric tables, each a strictly increasing array.

    Attributes
    ----------
    range_km, altitude_km, elevation_deg : (R,), (A,), (E,) arrays
        Range, altitude of the observer above sea level, elevation of the line of sight at the observer.
    source_elevation_deg, source_azimuth_deg : (SE,), (SA,) arrays
    """

    range_km: Floats
    altitude_km: Floats
    elevation_deg: Floats
    source_elevation_deg: Floats
    source_azimuth_deg: Floats

    def __post_init__(self) -> None:
        for field in fields(self):
            name = field.name
            values = np.array(getattr(self, name), dtype=float)
            if values.ndim != 1 or not values.size or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0):
                raise InputError(f"grid axis {name} must contain finite, strictly increasing numbers")
            object.__setattr__(self, name, values)

    @property
    def shape(self) -> tuple[int, ...]:
        """(R, A, E, SE, SA)."""
        return tuple(getattr(self, field.name).size for field in fields(self))


def lines_of_sight(
    air: SpectralAir, range_km: Floats, altitude_km: Floats, elevation_deg: Floats
) -> Iterator[LineOfSight]:
    """`line_of_sight.lines_of_sight` for ranges (n, R) [km] from observers at altitudes (n,) [km] and elevations (n,)
    [degree].
    """
    from skyshine.mat.atmosphere.transfer import line_of_sight  # slow to import

    ranges, altitude, elevation = np.asarray(range_km) * 1e3, np.asarray(altitude_km) * 1e3, np.radians(elevation_deg)
    return line_of_sight.lines_of_sight(air, ranges, altitude, elevation)
