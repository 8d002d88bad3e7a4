"""The weight of air: gravity by altitude and the molar mass of dry air."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from skyshine.mat.radiometry.constants import STANDARD_GRAVITY
from skyshine.schemas.arrays import Floats

_Altitude = TypeVar("_Altitude", np.float64, Floats)

EARTH_RADIUS = 6356766.0  # m, of the gravity below (US Standard Atmosphere 1976)
DRY_AIR_MOLAR_MASS = 28.9647e-3  # kg mol^-1 (US Standard Atmosphere 1976)


def gravity(altitude: _Altitude) -> _Altitude:
    """m s^-2 at 45 degrees (US Standard Atmosphere 1976: 9.80665 falling with the square of distance)."""
    acceleration: _Altitude = STANDARD_GRAVITY * (EARTH_RADIUS / (EARTH_RADIUS + altitude)) ** 2
    return acceleration
