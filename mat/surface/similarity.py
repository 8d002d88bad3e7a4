"""Monin-Obukhov similarity: profiles of wind, temperature and humidity near a surface, and optical turbulence.

References
----------
Fairall et al. 2003, J. Climate 16, 571 (COARE 3.0): functions of unstable air, which blend those of Kansas with free
convection (Grachev et al. 2000, Boundary-Layer Meteorol. 94, 495). Beljaars and Holtslag 1991, J. Appl. Meteorol. 30,
327: functions of stable air. Andreas 1988, J. Opt. Soc. Am. A 5, 481: structure function of temperature, after Wyngaard
et al. 1971, J. Opt. Soc. Am. 61, 1646. Wesely 1976, J. Appl. Meteorol. 15, 1177: share of humidity.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import STANDARD_GRAVITY
from skyshine.mat.surface.convection import VON_KARMAN
from skyshine.schemas.arrays import Floats

# Beljaars and Holtslag 1991: a, b, c, d.
_A, _B, _C, _D = 0.7, 0.75, 5.0, 0.35
_LARGEST_EXPONENT = 50.0  # Fairall et al. 2003, code of COARE 3.0
# Slopes of Kansas and of free convection: Fairall et al. 2003.
_KANSAS, _FREE_MOMENTUM, _FREE_HEAT = 15.0, 10.15, 34.15
# Andreas 1988: C_T^2 z^(2/3) / T*^2 of neutral air, and how it falls in unstable and rises in stable air.
_NEUTRAL, _UNSTABLE, _STABLE = 4.9, 6.1, 2.2
# dn/dT = -79e-6 P / T^2 with P in hPa, visible light and the windows of the infrared: Andreas 1988.
_INDEX_SLOPE = 79e-8  # K Pa^-1
_BOWEN = 0.03  # Wesely 1976
_LATENT_OVER_CAPACITY = 2.45e6 / 1005.0  # K: latent heat of vaporisation at 20 C over the heat capacity of air


def momentum_profile(stability: npt.ArrayLike) -> Floats:
    """Integrated departure psi of the wind's logarithmic profile at z / L, in its shape."""
    zeta = np.asarray(stability, float)
    unstable, stable = np.minimum(zeta, 0.0), np.maximum(zeta, 0.0)
    x = (1 - _KANSAS * unstable) ** 0.25
    kansas = 2 * np.log((1 + x) / 2) + np.log((1 + x**2) / 2) - 2 * np.arctan(x) + np.pi / 2
    decay = np.exp(-np.minimum(_D * stable, _LARGEST_EXPONENT))
    rise = -(_A * stable + _B * (stable - _C / _D) * decay + _B * _C / _D)
    return np.where(zeta < 0, _blended(unstable, kansas, _FREE_MOMENTUM), rise)


def heat_profile(stability: npt.ArrayLike) -> Floats:
    """Integrated departure psi of the profiles of temperature and humidity at z / L, in its shape."""
    zeta = np.asarray(stability, float)
    unstable, stable = np.minimum(zeta, 0.0), np.maximum(zeta, 0.0)
    kansas = 2 * np.log((1 + np.sqrt(1 - _KANSAS * unstable)) / 2)
    decay = np.exp(-np.minimum(_D * stable, _LARGEST_EXPONENT))
    b = 2 / 3
    rise = -((1 + b * stable) ** 1.5 + b * (stable - _C / _D) * decay + b * _C / _D - 1)
    return np.where(zeta < 0, _blended(unstable, kansas, _FREE_HEAT), rise)


def _blended(zeta: Floats, kansas: Floats, slope: float) -> Floats:
    """Psi of unstable air: Kansas near neutral, free convection far from it."""
    y = np.cbrt(1 - slope * zeta)
    convective = (
        1.5 * np.log((1 + y + y**2) / 3) - np.sqrt(3) * np.arctan((1 + 2 * y) / np.sqrt(3)) + np.pi / np.sqrt(3)
    )
    share = zeta**2 / (1 + zeta**2)
    blended: Floats = (1 - share) * kansas + share * convective
    return blended


def inverse_obukhov_length(
    friction_velocity: npt.ArrayLike,
    temperature_scale: npt.ArrayLike,
    humidity_scale: npt.ArrayLike,
    temperature: npt.ArrayLike,
) -> Floats:
    """1 / L of the air near a surface.

    Parameters
    ----------
    friction_velocity, temperature_scale, humidity_scale, temperature : array_like
        u* [m/s], T* [K] and q* [kg/kg], negative where heat and vapour rise, and air temperature [K]; they broadcast.

    Returns
    -------
    ndarray
        [m^-1]; negative in unstable air.
    """
    kelvin = np.asarray(temperature, float)
    virtual = np.asarray(temperature_scale, float) + 0.61 * kelvin * np.asarray(humidity_scale, float)
    inverse: Floats = VON_KARMAN * STANDARD_GRAVITY * virtual / (kelvin * np.asarray(friction_velocity, float) ** 2)
    return inverse


def index_structure(
    height: npt.ArrayLike,
    friction_velocity: npt.ArrayLike,
    temperature_scale: npt.ArrayLike,
    humidity_scale: npt.ArrayLike,
    temperature: npt.ArrayLike,
    pressure: npt.ArrayLike,
) -> Floats:
    """Structure constant of the refractive index, Cn2, in the surface layer.

    Parameters
    ----------
    height : array_like
        Height above the surface, above 0 [m].
    friction_velocity, temperature_scale, humidity_scale : array_like
        u* [m/s], T* [K], q* [kg/kg], as in `inverse_obukhov_length`.
    temperature, pressure : array_like
        Air temperature [K] and pressure [Pa].

    Returns
    -------
    ndarray
        Cn2 [m^(-2/3)], of the shape to which the arguments broadcast: C_T^2 = T*^2 z^(-2/3) f(z / L), f = 4.9
        (1 - 6.1 z / L)^(-2/3) in unstable and 4.9 (1 + 2.2 (z / L)^(2/3)) in stable air, times the squares of
        dn / dT and 1 + 0.03 / B, with the Bowen ratio B. For visible light and the infrared windows to 14 um.

    Examples
    --------
    A hot day at 2 m, 300 W m^-2 of sensible heat into a light wind:

    >>> float(f"{index_structure(2.0, 0.3, -0.85, 0.0, 300.0, 101325.0):.1e}")
    1.6e-12
    """
    height, scale = np.asarray(height, float), np.asarray(temperature_scale, float)
    stability = height * inverse_obukhov_length(friction_velocity, scale, humidity_scale, temperature)
    unstable, stable = np.minimum(stability, 0.0), np.maximum(stability, 0.0)
    shape = np.where(
        stability < 0, (1 - _UNSTABLE * unstable) ** (-2 / 3), 1 + _STABLE * np.cbrt(stable) ** 2
    )  # 1 at both
    # T* (1 + 0.03 / B), with B = cp T* / (Lv q*): humidity counts where there is no flux of heat, too.
    moist = scale + _BOWEN * _LATENT_OVER_CAPACITY * np.asarray(humidity_scale, float)
    slope = _INDEX_SLOPE * np.asarray(pressure, float) / np.asarray(temperature, float) ** 2
    structure: Floats = (slope * moist) ** 2 * _NEUTRAL * shape * height ** (-2 / 3)
    return structure
