"""The axes of the atmospheric quantities."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


@dataclass(frozen=True, eq=False)
class PathGrid:
    """Axes of the atmospheric tables, each a strictly increasing array.

    Attributes
    ----------
    range_km, altitude_km, elevation_deg : (R,), (A,), (E,) arrays
        Range, altitude of the observer above sea level, elevation of the line of sight at the observer.
    source_elevation_deg, source_azimuth_deg : (SE,), (SA,) arrays
    """

    by_scattering_angle = False

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
                raise InputError(f"grid axis {name} must hold finite, strictly increasing numbers")
            object.__setattr__(self, name, values)

    @property
    def shape(self) -> tuple[int, ...]:
        """(R, A, E, SE, SA)."""
        return tuple(getattr(self, field.name).size for field in fields(self))


class ScatteringGrid(PathGrid):
    """Axes with the angle between line of sight and source, 0 to 180 degree, in place of the source's azimuth."""

    by_scattering_angle = True
