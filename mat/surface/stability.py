"""How warm or cold ground strengthens or weakens the exchange with the wind over it."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import STANDARD_GRAVITY
from skyshine.mat.surface.convection import VON_KARMAN, Wind, heat_logarithm, lively, momentum_logarithm
from skyshine.schemas.arrays import Floats, Reals

# 3 b and d of Louis, Tiedtke and Geleyn (1982) with their b = d = 5.
_SLOPE, _TAIL = 15.0, 5.0
# Law of free convection where the roughness length for heat is exp(-2) of that for momentum: Mascart, Noilhan and
# Giordani (1995), whose cubic polynomials of 2 are C* = 3.2165 + 8.6862 + 2.1440 - 0.6248 and p = 0.5802 - 0.3142 +
# 0.1308 - 0.0208.
_FREE, _FREE_POWER = 13.4219, 0.3760


@dataclass(frozen=True, eq=False)
class Stability:
    """Transfer coefficient over that of neutral air, as a function of temperature difference.

    Attributes
    ----------
    richardson : ndarray
        Negative bulk Richardson number of a surface 1 K warmer than the air [K^-1].
    convection : ndarray
        Weight of free convection in warm ground's law [1].
    share : ndarray
        Share of stability in the factor: 1 on level to upright faces, less on overhanging ones, 0 on those that face
        down.

    Notes
    -----
    With R = `richardson` (T - T_air), level ground has 1 + 15 R / (1 + free sqrt(R)) where the ground is warmer, and
    1 / (1 + 15 |R| sqrt(1 + 5 |R|)) where it is colder: continuous with its derivative, 15, at R = 0. The long tail of
    the second keeps calm nights from parting ground and air. The stratification of the air is that of the place,
    whichever way its faces are inclined; on hanging ones the departure from 1 fades linearly with the angle (chosen).

    References
    ----------
    Louis, Tiedtke and Geleyn (1982), A short history of the PBL parametrization at ECMWF, ECMWF workshop on planetary
    boundary layer parametrization, 59-80; as Essery (2015), Geosci. Model Dev. 8, 3867-3876, FSM 1.0, has it.
    """

    richardson: Floats
    convection: Floats
    share: Floats

    @classmethod
    def of(
        cls, wind: Wind, air_temperature: npt.ArrayLike, cos_slope: npt.ArrayLike, roughness_length: float
    ) -> Stability:
        """The stability of ground of a roughness length [m].

        Parameters
        ----------
        air_temperature : array_like
            [K]
        cos_slope : array_like
            1 face up, 0 a wall, -1 face down.
        roughness_length : float
            [m]

        Notes
        -----
        The law is one of a single height. Wind and temperature, measured at two, are carried to the geometric mean of
        both along the neutral profiles: with the linear functions of Dyer (1974) for stable air the
        coefficient between two heights then agrees to a twentieth up to z / L = 0.5.
        """
        height = np.sqrt(np.asarray(wind.height, float) * np.asarray(wind.air_height, float))
        momentum = momentum_logarithm(height, roughness_length)
        speed = lively(wind.speed) * momentum / momentum_logarithm(wind.height, roughness_length)
        heat = heat_logarithm(height, roughness_length)
        warmth = heat / heat_logarithm(wind.air_height, roughness_length)
        richardson: Floats = STANDARD_GRAVITY * height * warmth / (np.asarray(air_temperature, float) * speed**2)
        share: Floats = 1.0 + np.arcsin(np.clip(np.asarray(cos_slope, float), -1.0, 0.0)) / (np.pi / 2)
        convection: Floats = _SLOPE * _FREE * VON_KARMAN**2 / (momentum * heat) * np.exp(_FREE_POWER * heat)
        return cls(richardson, convection, share)

    def single(self) -> Stability:
        """The same in single precision."""
        return Stability(*(getattr(self, item.name).astype(np.float32) for item in fields(self)))

    def factor(self, difference: Reals) -> Reals:
        """The factor at temperature differences to the air [K]."""
        unstable, cold = self._sides(difference)
        tail = _TAIL * cold
        tail += 1.0
        np.sqrt(tail, out=tail)
        tail *= cold
        tail *= _SLOPE
        tail += 1.0
        root = np.sqrt(unstable)
        root *= self.convection
        root += 1.0
        unstable *= _SLOPE
        unstable /= root
        unstable += 1.0
        unstable /= tail
        return self._shared(unstable)

    def factor_and_slope(self, difference: Reals) -> tuple[Reals, Reals]:
        """The factor, and its derivative by temperature [K^-1]."""
        unstable, cold = self._sides(difference)
        tail = _TAIL * cold
        tail += 1.0
        np.sqrt(tail, out=tail)
        fall = 1.5 * _TAIL * cold
        fall += 1.0
        fall /= tail
        tail *= cold
        tail *= _SLOPE
        tail += 1.0
        fall /= tail
        fall /= tail
        root = np.sqrt(unstable)
        root *= self.convection
        slope = 0.5 * root
        slope += 1.0
        root += 1.0
        slope /= root
        slope /= root
        slope *= fall  # either side leaves the other 1
        slope *= _SLOPE * self.share * self.richardson
        unstable *= _SLOPE
        unstable /= root
        unstable += 1.0
        unstable /= tail
        return self._shared(unstable), slope

    def _shared(self, factor: Reals) -> Reals:
        """A level surface's factor as that of the faces; in place."""
        factor -= 1.0
        factor *= self.share
        factor += 1.0
        return factor

    def _sides(self, difference: Reals) -> tuple[Reals, Reals]:
        """|R| where the ground is warmer and where it is colder, 0 elsewhere."""
        unstable: Reals = self.richardson * difference
        size = np.abs(unstable)
        cold: Reals = size - unstable
        cold *= 0.5
        unstable += size
        unstable *= 0.5
        return unstable, cold
