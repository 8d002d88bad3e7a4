"""The specular lobe: shininess from its width, its shape, and the factor that conserves its energy.

The lobe is a power of chi = s.n, where s is the half vector between the directions to the source (i)
and to the observer (r) and n the surface normal. Angles are in degrees.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Table values are means over these angles between source and normal [degree]; equation (43) and table 1.
SOURCE_ANGLES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)

# Widths a lobe may have [degree]. Below the lower limit the Sun's disc (0.53 degree) is five times as wide as the
# lobe and shininess exceeds 7e6, where chi in single precision no longer resolves the lobe. Above the upper limit
# half of the maximum lies below the horizon at normal incidence, so that no such width exists.
FWHM_LIMITS = (0.1, 180.0)

_AZIMUTHS = 4096  # equal steps of the half vector's azimuth


def shininess(fwhm: npt.ArrayLike) -> Floats:
    """Exponent of a lobe whose full width at half maximum is `fwhm`.

    Parameters
    ----------
    fwhm : array_like
        [degree], 0.1 to 180.

    Returns
    -------
    ndarray or float

    Raises
    ------
    InputError
        If a width is outside 0.1 to 180 degrees or not a number.

    References
    ----------
    Equation (42).
    """
    width = np.asarray(fwhm, dtype=float)
    lowest, highest = FWHM_LIMITS
    outside = ~((width >= lowest) & (width <= highest))
    if np.any(outside):
        example = width[outside].flat[0]
        raise InputError(f"found a lobe width of {example:g} degree; allowed: {lowest:g} to {highest:g} degree")
    # log cos x as log1p of 1 - cos x, which keeps its digits for narrow lobes.
    exponent: Floats = np.log(0.5) / np.log1p(-2.0 * np.sin(np.radians(width) / 8.0) ** 2)
    return exponent


def specular_lobe(
    exponent: npt.ArrayLike, source: npt.ArrayLike, observer: npt.ArrayLike, normal: npt.ArrayLike
) -> Floats:
    """Lobe value chi^exponent for directions of source and observer.

    Parameters
    ----------
    exponent : array_like
        Shininess.
    source, observer, normal : array_like, shape (..., 3)
        Unit vectors from the surface; broadcast against each other.

    Returns
    -------
    ndarray, shape (...)
        0 to 1; 0 where the half vector lies below the surface or source and observer are opposite.

    References
    ----------
    Equations (37), (38) and (41).
    """
    between = np.asarray(source, dtype=float) + np.asarray(observer, dtype=float)
    length = np.linalg.norm(between, axis=-1)
    along = np.sum(between * np.asarray(normal, dtype=float), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        chi = np.where(length > 0.0, along / length, 0.0)
    value: Floats = np.clip(chi, 0.0, 1.0) ** np.asarray(exponent, dtype=float)
    return value


def lobe_integral(exponent: float | Floats, source_angle: npt.ArrayLike) -> Floats:
    """Integral of the lobe over the hemisphere of observer directions.

    Parameters
    ----------
    exponent : float or 0-d array
        Shininess, not negative.
    source_angle : array_like, shape (m,)
        Angle between source and normal [degree], 0 up to below 90.

    Returns
    -------
    ndarray, shape (m,)
        [sr]

    Notes
    -----
    With the half vector s as variable the solid angle of the observer is 4 (i.s) dOmega_s, and the lobe depends
    on the polar angle t of s alone. At the azimuth p of s, i.s = A cos(t - d) with
    A cos d = cos(theta_i) and A sin d = sin(theta_i) cos p, and the observer is above the surface while
    t < pi/4 + d/2. The integral over t is then elementary for the cos t term and an incomplete beta function for
    the sin t term; the one over azimuth is of a smooth periodic function, for which equal steps converge fastest.

    References
    ----------
    The denominator of equation (43).
    """
    theta = np.radians(np.asarray(source_angle, dtype=float))[..., None]
    azimuth = (np.arange(_AZIMUTHS) + 0.5) * (2.0 * np.pi / _AZIMUTHS)
    level, across = np.cos(theta), np.sin(theta) * np.cos(azimuth)
    limit = 0.25 * np.pi + 0.5 * np.arctan2(across, level)
    # integral of cos^(n+1) t sin t, and of cos^n t sin^2 t, from 0 to the limit.
    cosine_part = -np.expm1((exponent + 2.0) * np.log(np.cos(limit))) / (exponent + 2.0)
    order = 0.5 * (exponent + 1.0)
    sine_part = 0.5 * np.exp(scipy.special.betaln(1.5, order)) * scipy.special.betainc(1.5, order, np.sin(limit) ** 2)
    integral: Floats = 4.0 * np.mean(level * cosine_part + across * sine_part, axis=-1) * 2.0 * np.pi
    return integral


def normalisation(fwhm: float, source_angles: npt.ArrayLike = SOURCE_ANGLES) -> Floats:
    """N_s of a lobe for each source angle.

    Parameters
    ----------
    fwhm : float
        Full width of the lobe at half maximum [degree], 0.1 to 180.
    source_angles : array_like, shape (m,)
        Angle between source and normal [degree], 0 up to below 90.

    Returns
    -------
    ndarray, shape (m,)

    Raises
    ------
    InputError
        If the width or an angle is out of range.

    References
    ----------
    Equation (43); table 1 contains its mean over `SOURCE_ANGLES`.
    """
    angles = np.asarray(source_angles, dtype=float)
    if not np.all((angles >= 0.0) & (angles < 90.0)):
        raise InputError("source angles must be at least 0 and below 90 degree")
    factor: Floats = 2.0 * np.pi * np.cos(np.radians(angles)) / lobe_integral(shininess(fwhm), angles)
    return factor


def normalisation_to_grazing(fwhm: float, source_angles: npt.ArrayLike) -> Floats:
    """`normalisation` up to 90 degree, where it is 0: no light falls on the surface, and half of the lobe is still
    above it.
    """
    angles = np.asarray(source_angles, dtype=float)
    result = np.zeros(angles.shape)
    result[angles != 90.0] = normalisation(fwhm, angles[angles != 90.0])
    return result
