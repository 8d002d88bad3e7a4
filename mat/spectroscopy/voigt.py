"""The Voigt function and line wings, compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from skyshine.schemas.arrays import Floats

SQRT_PI = math.sqrt(math.pi)
_TERMS = 32  # terms of Weideman's expansion


def _weideman(terms: int) -> tuple[float, Floats]:
    """Coefficients of Weideman's rational expansion of the Faddeeva function (1994, SIAM J. Numer. Anal. 31, 1497)."""
    size = 4 * terms
    scale = math.sqrt(terms / math.sqrt(2.0))
    angle = np.arange(-size // 2 + 1, size // 2) * 2 * np.pi / size
    t = scale * np.tan(angle / 2)
    samples = np.concatenate([[0.0], np.exp(-(t**2)) * (scale**2 + t**2)])
    spectrum = np.real(np.fft.fft(np.fft.fftshift(samples))) / size
    return scale, np.ascontiguousarray(spectrum[1 : terms + 1][::-1])


_SCALE, _COEFFICIENTS = _weideman(_TERMS)


@njit(cache=True, fastmath=True)
def far_voigt(x2: float, y: float) -> float:
    """Voigt function for ``|x| + y > 15``: the first rational of Humlicek 1982 (JQSRT 27, 437), relative error <
    1e-4.
    """
    y2 = y * y
    a = 0.5 + y2 - x2
    return y * (0.5 + y2 + x2) / (a * a + 4.0 * x2 * y2) / SQRT_PI


@njit(cache=True)
def near_faddeeva(x: float, y: float) -> complex:
    """Faddeeva function w(x + iy) by Weideman's expansion with 32 terms."""
    iz = complex(-y, x)
    z = (_SCALE + iz) / (_SCALE - iz)
    p = complex(_COEFFICIENTS[0], 0.0)
    for k in range(1, _TERMS):
        p = p * z + _COEFFICIENTS[k]
    d = _SCALE - iz
    return 2.0 * p / (d * d) + (1.0 / SQRT_PI) / d


@njit(cache=True, fastmath=True)
def far_faddeeva(x: float, y: float) -> tuple[float, float]:
    """Real and imaginary part of the Faddeeva function for ``|x| + y > 15``, as `far_voigt`."""
    a, b = x * x - y * y - 0.5, 2.0 * x * y
    scale = 1.0 / (SQRT_PI * (a * a + b * b))
    return scale * (x * b - y * a), scale * (x * a + y * b)


@njit(cache=True)
def near_voigt(x: float, y: float) -> float:
    """Voigt function by Weideman's expansion with 32 terms, relative error < 1e-6 for y >= 1e-6 near the centre."""
    return near_faddeeva(x, y).real


@njit(cache=True)
def voigt(x: float, y: float) -> float:
    """Real part of the Faddeeva function w(x + iy), y > 0."""
    if abs(x) + y > 15.0:
        return far_voigt(x * x, y)
    return near_voigt(x, y)


@njit(cache=True)
def chi_co2(distance: float, b1: float) -> float:
    """Sub-Lorentzian factor of CO2 in nitrogen within 30 cm^-1 of the centre.

    Perrin and Hartmann 1989 (JQSRT 42, 311): 1 up to 3 cm^-1, then an exponential decay of coefficient `b1` (see
    `chi_decay`).
    """
    if distance <= 3.0:
        return 1.0
    return math.exp(-b1 * (distance - 3.0))


@njit(cache=True)
def chi_decay(temperature: float) -> float:
    """Decay coefficient of `chi_co2`, cm, for CO2 broadened by N2 (Perrin and Hartmann 1989, Table 3), 190 to 800 K."""
    return 0.416 - 0.354 * math.exp(-0.00386 * temperature)
