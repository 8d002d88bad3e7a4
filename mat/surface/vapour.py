"""Vapour pressure over water, over ice, and over a surface whose water freezes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.schemas.arrays import Floats, Reals

# Magnus forms p = 611.2 Pa exp(a t / (b + t)), t in degrees Celsius, over water and over ice: Sonntag (1990),
# Z. Meteorol. 70, 340-344; WMO-No. 8, Annex 4.B.
_ZERO_CELSIUS_PRESSURE = 611.2
_WATER_FACTOR, _WATER_OFFSET = 17.62, 243.12
_ICE_FACTOR, _ICE_OFFSET = 22.46, 272.62
# Water on a surface is ice below this many degrees under the melting point and liquid above it, part of each between:
# chosen wide enough that the jump of the latent heat leaves the loss increasing with temperature at any pressure.
_FREEZING_RANGE = 2.0
# Latent heat of sublimation over that of vaporisation at 0 C: 2.834 and 2.501 MJ/kg, Rogers and Yau (1989), A Short
# Course in Cloud Physics, 3rd ed., table 2.1.
_SUBLIMATION_RATIO = 2.834 / 2.501
# Below 150 K water vapour over the surface is below 1e-5 Pa; the clip keeps Magnus' formula away from its pole.
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
    Magnus form with the constants of Sonntag (1990), Z. Meteorol. 70, 340-344; WMO-No. 8, Annex 4.B.
    """
    celsius = np.maximum(np.asarray(temperature, float), _COLDEST_VAPOUR) - ZERO_CELSIUS
    pressure: Floats = _ZERO_CELSIUS_PRESSURE * np.exp(_WATER_FACTOR * celsius / (_WATER_OFFSET + celsius))
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
    Magnus forms over water and ice with the constants of Sonntag (1990); WMO-No. 8, Annex 4.B.
    """
    celsius = temperature - ZERO_CELSIUS
    coldest = celsius.min()
    if coldest < _COLDEST_VAPOUR - ZERO_CELSIUS:
        np.maximum(celsius, _COLDEST_VAPOUR - ZERO_CELSIUS, out=celsius)
    exponent = celsius + _WATER_OFFSET
    np.divide(_WATER_FACTOR, exponent, out=exponent)
    latent_heat = np.ones((1,) * celsius.ndim, celsius.dtype)
    if coldest < 0:
        freezes = celsius < 0
        below, water = celsius[freezes], exponent[freezes]
        frozen = _frozen_share(below)[0]
        exponent[freezes] = water + frozen * (_ICE_FACTOR / (_ICE_OFFSET + below) - water)
        latent_heat = np.ones_like(celsius)
        latent_heat[freezes] = 1 + (_SUBLIMATION_RATIO - 1) * frozen
    exponent *= celsius
    np.exp(exponent, out=exponent)
    exponent *= _ZERO_CELSIUS_PRESSURE
    return exponent, latent_heat


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
    celsius = np.maximum(temperature, _COLDEST_VAPOUR) - ZERO_CELSIUS
    frozen, freezing = _frozen_share(celsius)
    water, ice = _WATER_FACTOR / (_WATER_OFFSET + celsius), _ICE_FACTOR / (_ICE_OFFSET + celsius)
    slope = (1 - frozen) * _WATER_OFFSET * water / (_WATER_OFFSET + celsius)
    slope = slope + frozen * _ICE_OFFSET * ice / (_ICE_OFFSET + celsius)
    slope = pressure * (slope + celsius * freezing * (ice - water))
    return np.where(temperature > _COLDEST_VAPOUR, slope, 0.0), (_SUBLIMATION_RATIO - 1) * freezing


def _frozen_share(celsius: Reals) -> tuple[Reals, Reals]:
    """Share of ice in the water on a surface and its derivative by temperature, both continuous."""
    depth = np.clip(-celsius / _FREEZING_RANGE, 0.0, 1.0)
    return depth**2 * (3 - 2 * depth), -6 * depth * (1 - depth) / _FREEZING_RANGE
