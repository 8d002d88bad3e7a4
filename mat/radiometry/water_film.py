"""Reflectance of a rough surface under films of water, from that of the dry surface.

Light that the surface scatters is thrown back at the water's upper face, many times, and has as many chances to be
absorbed (Angstrom 1925); the surface itself absorbs more where its index differs less from what lies on it (Lekner and
Dorf 1988); water absorbs on the way, and beyond 2.7 um no light comes through: there the film's own face is what is
left.

References
----------
Lekner and Dorf (1988), Appl. Opt. 27, 1278-1280: equations of p, of the diffuse reflectance (Stern) and of the surface
under water. Verhoef, in Yang, van der Tol, Yin and Verhoef (2020), Remote Sens. Environ. 247, 111870: soil of some
moisture as dry ground and ground under one, two, ... films (BSM).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats

SURFACE_INDEX = 2.0  # surface index of the solid, as BSM takes it
SOIL_FILM = 1.5e-4  # m: one film of BSM
# Films of BSM: no film below the first volume fraction of water; one film more, in the mean, for each 25 % beyond.
_FIRST_FILM, _MOISTURE_OF_FILM = 0.05, 0.25
_MOST_FILMS = 6  # more cover less than a thousandth of any soil
_LEAST_INDEX = 1.02  # keeps Stern's formula away from its removable singularity at 1


def diffuse_reflectance(index: npt.ArrayLike) -> Floats:
    """Reflectance of a smooth face for even light from the side of lower index; `index` above 1 is the ratio of both.

    References
    ----------
    Stern, in Lekner and Dorf (1988), equation (6); 0.0668 for water of 1.333 against air.
    """
    n = np.asarray(index, float)
    n2 = n * n
    transmitted: Floats = (
        (3 * n2 + 2 * n + 1) / (3 * (n + 1) ** 2)
        - 2 * n**3 * (n2 + 2 * n - 1) / ((n2 + 1) ** 2 * (n2 - 1))
        + n2 * (n2 + 1) / (n2 - 1) ** 2 * np.log(n)
        - n2 * (n2 - 1) ** 2 / (n2 + 1) ** 3 * np.log(n * (n + 1) / (n - 1))
    )
    return transmitted


def film_reflectance(
    dry: npt.ArrayLike, wavelength: npt.ArrayLike, index: npt.ArrayLike, thickness: float | Floats
) -> Floats:
    """Reflectance of a surface under a film of water.

    Parameters
    ----------
    dry : (n,) array_like
        Reflectance of the dry surface.
    wavelength : (n,) array_like
        [um]
    index : (n,) array_like
        n + ik of water there.
    thickness : float
        [m]

    Returns
    -------
    (n,) ndarray
    """
    reflectance, water = np.asarray(dry, float), np.asarray(index, complex)
    n = np.maximum(water.real, _LEAST_INDEX)
    face = np.abs((water - 1) / (water + 1)) ** 2
    back = 1 - (1 - diffuse_reflectance(n)) / n**2  # reflectance of light from below at the water's upper face
    passed = np.exp(-8 * math.pi * water.imag * thickness / (np.asarray(wavelength, float) * 1e-6))
    lower = np.maximum(SURFACE_INDEX / n, _LEAST_INDEX)
    gain = (1 - diffuse_reflectance(lower)) / (1 - diffuse_reflectance(SURFACE_INDEX))
    absorbed = 1 - reflectance
    below = 1 - absorbed * (reflectance * gain + absorbed)
    wet: Floats = face + (1 - face) * (1 - back) * passed * below / (1 - back * passed * below)
    return wet


def film_shares(moisture: float) -> Floats:
    """Shares of a soil's surface under no film, one, two ... (7,), at a volume fraction of water."""
    mean = max(moisture - _FIRST_FILM, 0.0) / _MOISTURE_OF_FILM
    shares = np.array([mean**k / math.factorial(k) for k in range(_MOST_FILMS + 1)])
    normalised: Floats = shares / shares.sum()
    return normalised


def moist_reflectance(dry: npt.ArrayLike, wavelength: npt.ArrayLike, index: npt.ArrayLike, moisture: float) -> Floats:
    """Reflectance (n,) of a soil at a volume fraction of water; arguments as of `film_reflectance`."""
    shares = film_shares(moisture)
    parts = [np.asarray(dry, float)]
    parts += [film_reflectance(dry, wavelength, index, SOIL_FILM * count) for count in range(1, shares.size)]
    reflectance: Floats = np.sum([share * part for share, part in zip(shares, parts, strict=True)], axis=0)
    return reflectance
