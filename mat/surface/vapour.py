"""Vapour pressure over water, over ice, and over a surface whose water freezes.

References
----------
Murphy and Koop 2005, Q. J. R. Meteorol. Soc. 131, 1539: equations (10), liquid water, supercooled too, 123 to 332 K
(within 0.3 % of IAPWS to 353 K), and (7), ice, above 110 K.
"""

from __future__ import annotations

from functools import lru_cache

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
# K: where surfaces under a sky usually are, and the degree of the polynomial that has the logarithm there to 5e-6: in
# single precision, in which an iteration begins, it takes the place of the laws at a third of their time.
_USUAL, _DEGREE = (240.0, 345.0), 8


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
    kelvin = np.asarray(temperature, float)
    pressure: Floats = np.exp(_water(np.atleast_1d(kelvin))).reshape(kelvin.shape)
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
    logarithm = _water_single(kelvin) if _is_usual(kelvin) else _water(kelvin)
    latent_heat = np.ones((1,) * kelvin.ndim, kelvin.dtype)
    freezes = kelvin < ZERO_CELSIUS
    if np.any(freezes):
        frozen = _frozen_share(kelvin[freezes] - ZERO_CELSIUS)[0]
        logarithm[freezes] += frozen * (_ice(kelvin[freezes]) - logarithm[freezes])
        latent_heat = np.ones_like(kelvin)
        latent_heat[freezes] = 1 + (_SUBLIMATION_RATIO - 1) * frozen
    return np.exp(logarithm, out=logarithm), latent_heat


def surface_vapour_and_slopes(temperature: Reals) -> tuple[Reals, Reals, Reals, Reals]:
    """Both values of `surface_vapour` and their derivatives by temperature.

    Parameters
    ----------
    temperature : ndarray
        [K]

    Returns
    -------
    pressure, latent_heat, pressure_slope, latent_heat_slope : ndarray
        [Pa], [1], [Pa K^-1], [K^-1]; those of the latent heat have one element where no water is frozen.
    """
    kelvin = np.maximum(temperature, _COLDEST_VAPOUR)
    logarithm, slope = _water_single_and_slope(kelvin) if _is_usual(kelvin) else _water_and_slope(kelvin)
    latent_heat = np.ones((1,) * kelvin.ndim, kelvin.dtype)
    latent_slope = np.zeros_like(latent_heat)
    freezes = kelvin < ZERO_CELSIUS
    if np.any(freezes):
        cold = kelvin[freezes]
        frozen, freezing = _frozen_share(cold - ZERO_CELSIUS)
        beside = _ice(cold) - logarithm[freezes]
        slope[freezes] += frozen * (_ice_slope(cold) - slope[freezes]) + freezing * beside
        logarithm[freezes] += frozen * beside
        latent_heat, latent_slope = np.ones_like(kelvin), np.zeros_like(kelvin)
        latent_heat[freezes] = 1 + (_SUBLIMATION_RATIO - 1) * frozen
        latent_slope[freezes] = (_SUBLIMATION_RATIO - 1) * freezing
        slope[temperature <= _COLDEST_VAPOUR] = 0.0
    pressure = np.exp(logarithm, out=logarithm)
    slope *= pressure
    return pressure, latent_heat, slope, latent_slope


def _is_usual(kelvin: Reals) -> bool:
    """Whether temperatures are in single precision, in which an iteration begins, and within `_USUAL`."""
    return bool(kelvin.dtype == np.float32 and kelvin.min() >= _USUAL[0] and kelvin.max() <= _USUAL[1])


@lru_cache(maxsize=1)
def _usual_powers() -> tuple[list[np.float32], list[np.float32]]:
    """Coefficients of `_water` over `_USUAL`, highest power first, of -1 to 1, and of its slope by temperature."""
    polynomial = np.polynomial.Chebyshev.interpolate(lambda t: _water(np.asarray(t)), _DEGREE, _USUAL)
    powers = polynomial.convert(kind=np.polynomial.Polynomial, domain=_USUAL, window=[-1.0, 1.0])
    slope = powers.deriv()
    return [np.float32(c) for c in powers.coef[::-1]], [np.float32(c) for c in slope.coef[::-1]]


def _scaled(kelvin: Reals) -> Reals:
    low, high = _USUAL
    return (kelvin - np.float32(0.5 * (low + high))) * np.float32(2.0 / (high - low))


def _horner(coefficients: list[np.float32], x: Reals) -> Reals:
    total: Reals = coefficients[0] * x
    total += coefficients[1]
    for coefficient in coefficients[2:]:
        total *= x
        total += coefficient
    return total


def _water_single(kelvin: Reals) -> Reals:
    """`_water` by its polynomial, to 1e-5."""
    return _horner(_usual_powers()[0], _scaled(kelvin))


def _water_single_and_slope(kelvin: Reals) -> tuple[Reals, Reals]:
    """`_water_and_slope` by the polynomial."""
    (powers, slope), x = _usual_powers(), _scaled(kelvin)
    return _horner(powers, x), _horner(slope, x)


def _water(kelvin: Reals) -> Reals:
    """Logarithm of the pressure over liquid water [ln Pa]."""
    return _water_terms(kelvin)[0]


def _water_and_slope(kelvin: Reals) -> tuple[Reals, Reals]:
    """`_water` and its derivative by temperature [K^-1]."""
    exponent, bend, second = _water_terms(kelvin)
    inverse = 1 / kelvin
    slope = 1331.22 * inverse
    slope -= 9.44523
    slope *= inverse
    slope += 0.014025
    slope *= bend
    bend *= bend
    np.subtract(1.0, bend, out=bend)
    bend *= second
    bend *= 0.0415
    slope += bend
    bend = 6763.22 * inverse
    bend -= 4.210
    bend *= inverse
    slope += bend
    slope += 0.000367
    return exponent, slope


def _water_terms(kelvin: Reals) -> tuple[Reals, Reals, Reals]:
    """The logarithm over liquid water a + b tanh(c) [ln Pa], tanh(c) and b."""
    logarithm, inverse = np.log(kelvin), 1 / kelvin
    bend = kelvin - 218.8
    bend *= 2 * 0.0415
    np.minimum(bend, 80.0, out=bend)  # tanh is 1 there; more overflows single precision in trial temperatures
    np.exp(bend, out=bend)  # tanh x = 1 - 2 / (1 + exp 2x): exp takes half the time of tanh
    bend += 1.0
    np.divide(-2.0, bend, out=bend)
    bend += 1.0
    second = 0.014025 * kelvin
    second -= 1331.22 * inverse
    second -= 9.44523 * logarithm
    second += 53.878
    inverse *= -6763.22
    logarithm *= 4.210
    exponent = 0.000367 * kelvin
    exponent += inverse
    exponent -= logarithm
    exponent += 54.842763
    exponent += bend * second
    return exponent, bend, second


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
