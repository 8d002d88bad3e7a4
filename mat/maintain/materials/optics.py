"""Reflectance from optical constants: a smooth opaque surface and a clear pane, at normal incidence."""

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
    passed = np.exp(-4.0 * np.pi * index.imag * thickness / (wavelength * 1e-6))
    transmittance = (1.0 - face) ** 2 * passed / (1.0 - (face * passed) ** 2)
    reflectance = face * (1.0 + passed * transmittance)
    return reflectance, 1.0 - reflectance - transmittance
