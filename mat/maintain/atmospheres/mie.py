"""Scattering by homogeneous spheres.

References
----------
Bohren and Huffman 1983, Absorption and Scattering of Light by Small Particles, chapter 4 and appendix A.
"""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats


@numba.njit(cache=True)
def _one(x: float, m: complex) -> tuple[float, float, float]:
    """Efficiencies of extinction and scattering, and asymmetry, of a sphere of size parameter x and refractive index m
    = n + ik.
    """
    y = m * x
    # Terms by Wiscombe 1980, Appl. Opt. 19, 1505. The logarithmic derivative runs down from as far above |y|, where its
    # start, 0, is forgotten before it counts.
    terms = int(x + 4.05 * x ** (1 / 3) + 2) + 1
    start = max(terms, int(abs(y) + 4.05 * abs(y) ** (1 / 3))) + 16
    derivative = np.zeros(start + 1, dtype=np.complex128)
    for n in range(start, 0, -1):
        derivative[n - 1] = n / y - 1 / (derivative[n] + n / y)
    psi_before, psi = np.cos(x), np.sin(x)
    chi_before, chi = -np.sin(x), np.cos(x)
    extinction = scattering = forward = 0.0
    a_before, b_before = 0j, 0j
    for n in range(1, terms + 1):
        psi_now = (2 * n - 1) * psi / x - psi_before
        chi_now = (2 * n - 1) * chi / x - chi_before
        xi, xi_now = complex(psi, -chi), complex(psi_now, -chi_now)
        first, second = derivative[n] / m + n / x, derivative[n] * m + n / x
        a = (first * psi_now - psi) / (first * xi_now - xi)
        b = (second * psi_now - psi) / (second * xi_now - xi)
        extinction += (2 * n + 1) * (a.real + b.real)
        scattering += (2 * n + 1) * (abs(a) ** 2 + abs(b) ** 2)
        forward += (2 * n + 1) / (n * (n + 1)) * (a * np.conj(b)).real
        if n > 1:
            forward += (n - 1) * (n + 1) / n * (a_before * np.conj(a) + b_before * np.conj(b)).real
        a_before, b_before = a, b
        psi_before, psi, chi_before, chi = psi, psi_now, chi, chi_now
    return 2 * extinction / x**2, 2 * scattering / x**2, 2 * forward / scattering


@numba.njit(cache=True)
def _many(sizes: Floats, indices: npt.NDArray[np.complex128]) -> Floats:
    """Efficiencies of extinction and scattering, and asymmetry, (3, N)."""
    result = np.empty((3, sizes.size))
    for k in range(sizes.size):
        result[0, k], result[1, k], result[2, k] = _one(sizes[k], indices[k])
    return result


def sphere_efficiencies(
    size_parameter: npt.ArrayLike, refractive_index: npt.ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Efficiencies of spheres.

    Parameters
    ----------
    size_parameter : array
        Circumference over wavelength, above 0.
    refractive_index : array of complex
        n + ik, k at least 0; broadcast against the first.

    Returns
    -------
    extinction, scattering, asymmetry : arrays
    """
    x, m = np.broadcast_arrays(np.asarray(size_parameter, float), np.asarray(refractive_index, complex))
    extinction, scattering, asymmetry = _many(np.ascontiguousarray(x.ravel()), np.ascontiguousarray(m.ravel()))
    return extinction.reshape(x.shape), scattering.reshape(x.shape), asymmetry.reshape(x.shape)
