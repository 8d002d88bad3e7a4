"""Reflectance from optical constants: a smooth opaque surface, a clear pane and a coated one, at normal incidence."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats


def fresnel_reflectance(index: npt.NDArray[np.complex128]) -> Floats:
    """Reflectance of a smooth surface against air at normal incidence.

    Parameters
    ----------
    index : ndarray of complex
        n + ik.

    Returns
    -------
    ndarray

    References
    ----------
    Fresnel's equations; Bohren and Huffman (1983), equation 2.58.
    """
    amplitude = np.abs((index - 1.0) / (index + 1.0))
    return amplitude**2


def pane(index: npt.NDArray[np.complex128], wavelength: Floats, thickness: float) -> tuple[Floats, Floats]:
    """Reflectance and absorptance of a plane-parallel pane at normal incidence.

    Parameters
    ----------
    index : ndarray of complex
        n + ik.
    wavelength : ndarray
        [um]
    thickness : float
        [m]; many wavelengths, so that the multiple reflections add without interference.

    Returns
    -------
    reflectance, absorptance : ndarray

    References
    ----------
    Geometric series of internal reflections; Siegel and Howell, Thermal Radiation Heat Transfer,
    chapter on windows.
    """
    face = fresnel_reflectance(index)
    return _pane(index, wavelength, thickness, (face, 1.0 - face))


def coated_pane(
    index: npt.NDArray[np.complex128],
    film: npt.NDArray[np.complex128],
    wavelength: Floats,
    thickness: float,
    film_thickness: float,
) -> tuple[Floats, Floats]:
    """Reflectance and absorptance of a pane whose back face bears a thin film, at normal incidence.

    Parameters
    ----------
    index, film : ndarray of complex
        n + ik of pane and film.
    wavelength : ndarray
        [um]
    thickness, film_thickness : float
        [m]; the waves in the film interfere, those in the pane do not.

    Returns
    -------
    reflectance, absorptance : ndarray
        What the film absorbs counts to the pane.

    References
    ----------
    Airy's formulas of a film; Born and Wolf, Principles of Optics, section 1.6.4.
    """
    inner = index.real  # the weak absorption of glass does not change what its face reflects
    at_pane, at_air = (inner - film) / (inner + film), (film - 1.0) / (film + 1.0)
    phase = np.exp(2j * np.pi * film * film_thickness / (wavelength * 1e-6))
    both = 1.0 + at_pane * at_air * phase**2
    reflected = np.abs((at_pane + at_air * phase**2) / both) ** 2
    passed = np.abs((1.0 + at_pane) * (1.0 + at_air) * phase / both) ** 2 / inner
    return _pane(index, wavelength, thickness, (reflected, passed))


def _pane(
    index: npt.NDArray[np.complex128], wavelength: Floats, thickness: float, back: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Reflectance and absorptance of a pane whose back face reflects and passes shares of the light within it."""
    face, (reflected, passed) = fresnel_reflectance(index), back
    inside = np.exp(-4.0 * np.pi * index.imag * thickness / (wavelength * 1e-6))
    entered = (1.0 - face) * inside / (1.0 - face * reflected * inside**2)
    reflectance = face + (1.0 - face) * entered * reflected * inside
    return reflectance, 1.0 - reflectance - entered * passed
