"""Vapour pressure over water, over ice, and over a surface whose water freezes.

References
----------
Murphy and Koop 2005, Q. J. R. Meteorol. Soc. 131, 1539: equations (10), liquid water, supercooled too, 123 to 332 K
(within 0.3 % of IAPWS to 353 K), and (7), ice, above 110 K.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.schemas.arrays import Floats, Reals

# Water on a surface is ice below this many degrees under the melting point and liquid above it, part of each between:
# chosen wide enough that the jump of the latent heat leaves the loss increasing with temperature at any pressure.
_FREEZING_RANGE = 2.0
# Latent heat of sublimation over that of vaporisation at 0 C: 2.834 and 2.501 MJ/kg, Rogers and Yau (1989), A Short
# Course in Cloud Physics, 3rd ed., table 2.1.
_SUBLIMATION_RATIO = 2.834 / 2.501
# Below 150 K water vapour over the surface is below 1e-5 Pa; the clip keeps the formulas within their range.
_COLDEST_VAPOUR = 150.0


def saturation_pressure(temperature: npt.ArrayLike) -> Floats:
    """Saturation vapour pressure over water.

    Parameters
    ----------
    temperature : array_like
        [K]

    Returns
    -------
    ndarray
        Of the same shape [Pa].

    References
    ----------
    Murphy and Koop 2005, equation (10).
    """
    pressure: Floats = np.exp(_water(np.asarray(temperature, float)))
    return pressure


def surface_vapour(temperature: Reals) -> tuple[Reals, Reals]:
    """Vapour pressure of the water or frost on a surface, and its latent heat over that of liquid water.

    Parameters
    ----------
    temperature : ndarray
        [K]

    Returns
    -------
    pressure : ndarray
        Of the same shape [Pa].
    latent_heat : ndarray
        Of the same shape, or of one element, 1, where no water is frozen [1].

    References
    ----------
    Murphy and Koop 2005, equations (10) and (7); in between, the logarithm is shared as the ice is.
    """
    kelvin = np.maximum(temperature, _COLDEST_VAPOUR)
    logarithm = _water(kelvin)
    latent_heat = np.ones((1,) * kelvin.ndim, kelvin.dtype)
    freezes = kelvin < ZERO_CELSIUS
    if np.any(freezes):
        frozen = _frozen_share(kelvin[freezes] - ZERO_CELSIUS)[0]
        logarithm[freezes] += frozen * (_ice(kelvin[freezes]) - logarithm[freezes])
        latent_heat = np.ones_like(kelvin)
        latent_heat[freezes] = 1 + (_SUBLIMATION_RATIO - 1) * frozen
    return np.exp(logarithm), latent_heat


def surface_vapour_slopes(temperature: Reals, pressure: Reals) -> tuple[Reals, Reals]:
    """Derivatives of both values of `surface_vapour` by temperature.

    Parameters
    ----------
    temperature : ndarray
        [K]
    pressure : ndarray
        That `surface_vapour` gives for it [Pa].

    Returns
    -------
    pressure_slope, latent_heat_slope : ndarray
        [Pa K^-1], [K^-1]
    """
    kelvin = np.maximum(temperature, _COLDEST_VAPOUR)
    frozen, freezing = _frozen_share(kelvin - ZERO_CELSIUS)
    slope = _water_slope(kelvin)
    if np.any(frozen > 0):
        slope = slope + frozen * (_ice_slope(kelvin) - slope) + freezing * (_ice(kelvin) - _water(kelvin))
    return np.where(temperature > _COLDEST_VAPOUR, pressure * slope, 0.0), (_SUBLIMATION_RATIO - 1) * freezing


def _water(kelvin: Reals) -> Reals:
    """Logarithm of the pressure over liquid water [ln Pa]."""
    logarithm = np.log(kelvin)
    first = 54.842763 - 6763.22 / kelvin - 4.210 * logarithm + 0.000367 * kelvin
    second = 53.878 - 1331.22 / kelvin - 9.44523 * logarithm + 0.014025 * kelvin
    exponent: Reals = first + np.tanh(0.0415 * (kelvin - 218.8)) * second
    return exponent


def _water_slope(kelvin: Reals) -> Reals:
    """Derivative of `_water` by temperature [K^-1]."""
    bend = np.tanh(0.0415 * (kelvin - 218.8))
    second = 53.878 - 1331.22 / kelvin - 9.44523 * np.log(kelvin) + 0.014025 * kelvin
    first = 6763.22 / kelvin**2 - 4.210 / kelvin + 0.000367 + 0.0415 * (1 - bend**2) * second
    slope: Reals = first + bend * (1331.22 / kelvin**2 - 9.44523 / kelvin + 0.014025)
    return slope


def _ice(kelvin: Reals) -> Reals:
    """Logarithm of the pressure over ice [ln Pa]."""
    return 9.550426 - 5723.265 / kelvin + 3.53068 * np.log(kelvin) - 0.00728332 * kelvin


def _ice_slope(kelvin: Reals) -> Reals:
    """Derivative of `_ice` by temperature [K^-1]."""
    return 5723.265 / kelvin**2 + 3.53068 / kelvin - 0.00728332


def _frozen_share(celsius: Reals) -> tuple[Reals, Reals]:
    """Share of ice in the water on a surface and its derivative by temperature, both continuous."""
    depth = np.clip(-celsius / _FREEZING_RANGE, 0.0, 1.0)
    return depth**2 * (3 - 2 * depth), -6 * depth * (1 - depth) / _FREEZING_RANGE
