"""Directions of the Sun through the day, at the times to which all of the forcing is given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

SOLAR_CONSTANT = 1361.1  # W m^-2, Gueymard (2018), Solar Energy 168, 2-9
SUN_STEPS = 576  # sun steps of 150 s: a multiple of 48, 72, 96, 144, 192, 288


def sun_hours() -> Floats:
    """Local clock hours at which Sun and weather are given, (SUN_STEPS,)."""
    return np.arange(float(SUN_STEPS)) * (24.0 / SUN_STEPS)


@dataclass(frozen=True, eq=False)
class SunPath:
    """Directions of the Sun through the day, seen from a place.

    Attributes
    ----------
    altitude : float
        Altitude of the ground [m].
    solar_elevation, solar_azimuth : ndarray, shape (SUN_STEPS,)
        Position of the Sun at the local clock hours `sun_hours()` [degree]; azimuth from north eastward.
    sun_distance : float
        [au]
    """

    altitude: float
    solar_elevation: Floats
    solar_azimuth: Floats
    sun_distance: float = 1.0

    def __post_init__(self) -> None:
        for name in ("solar_elevation", "solar_azimuth"):
            values = np.asarray(getattr(self, name), float)
            if values.shape != (SUN_STEPS,) or not np.all(np.isfinite(values)):
                raise InputError(
                    f"{name}: found shape {values.shape}; allowed: {SUN_STEPS} finite angles through a day"
                )
