"""Rain: drops of Marshall and Palmer's distribution, from the ground to a height.

References
----------
Marshall and Palmer 1948, J. Meteorol. 5, 165. LOWTRAN7, FUNCTION TNRAIN (Kneizys et al. 1988, AFGL-TR-88-0177).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles import tables
from skyshine.mat.atmosphere.particles.particles import SphereModel, interpolated_phase, interpolated_table
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# N(D) = N0 exp(-L D), D the diameter, R the rain rate in mm/h.
NUMBER = 8e6  # N0, m^-4
SLOPE_PER_CM, SLOPE_EXPONENT = 41.0, -0.21  # L = 41 R^-0.21 cm^-1
RATES = (0.01, 300.0)  # mm/h; above 300 it has rained for minutes at a time only
_EDGE = 10.0  # m in which the rain begins below its top


@dataclass(frozen=True)
class RainLayer:
    """Even rain from the ground to a height.

    Attributes
    ----------
    rate : float
        mm/h.
    top : float
        m above the ground.
    """

    rate: float
    top: float

    def __post_init__(self) -> None:
        if not RATES[0] <= self.rate <= RATES[1]:
            raise InputError(f"rain rate {self.rate:g} mm/h is outside {RATES[0]:g} to {RATES[1]:g} mm/h")
        if not 2 * _EDGE <= self.top <= 15e3:
            raise InputError(
                f"rain from {self.top / 1e3:g} km above the ground is outside {2 * _EDGE / 1e3:g} to 15 km"
            )

    @property
    def edges(self) -> tuple[float, ...]:
        """Heights above the ground at which levels must be, m."""
        return (self.top - _EDGE, self.top)

    @property
    def model(self) -> SphereModel:
        """Optical properties of the drops."""
        return _model(self.rate)[0]

    def extinction_550(self, height: npt.ArrayLike) -> Floats:
        """At 0.55 um at heights above the ground [m], m^-1."""
        geometric = np.pi * NUMBER / (1e2 * SLOPE_PER_CM * self.rate**SLOPE_EXPONENT) ** 3
        extinction: Floats = (
            geometric * _model(self.rate)[1] * np.clip((self.top - np.asarray(height)) / _EDGE, 0.0, 1.0)
        )
        return extinction


@lru_cache(maxsize=16)
def _model(rate: float) -> tuple[SphereModel, float]:
    """The model, and its extinction at 0.55 um over twice the cross section of the drops."""
    phase = interpolated_phase(tables.phase_table("rain"), rate)
    return SphereModel.of_table("rain", *interpolated_table(tables.rain_table(), rate), **phase)
