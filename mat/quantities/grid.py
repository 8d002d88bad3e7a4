"""The axes that the atmospheric quantities are computed on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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

    range_km: np.ndarray
    altitude_km: np.ndarray
    elevation_deg: np.ndarray
    source_elevation_deg: np.ndarray
    source_azimuth_deg: np.ndarray

    def __post_init__(self):
        for name in self.__dataclass_fields__:
            values = np.array(getattr(self, name), dtype=float)
            if values.ndim != 1 or not values.size or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0):
                raise InputError(f"grid axis {name} must hold finite, strictly increasing numbers")
            object.__setattr__(self, name, values)

    @property
    def shape(self):
        """(R, A, E, SE, SA)."""
        return tuple(getattr(self, name).size for name in self.__dataclass_fields__)


class ScatteringGrid(PathGrid):
    """Axes of which the last holds the angle between line of sight and source, 0 to 180 degree, in place of the
    source's azimuth.
    """

    by_scattering_angle = True
