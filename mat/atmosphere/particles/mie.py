"""Scattering by homogeneous spheres: efficiencies, phase functions and their Legendre moments.

References
----------
Bohren and Huffman 1983, Absorption and Scattering of Light by Small Particles, chapter 4 and appendix A. Wiscombe 1980,
Appl. Opt. 19, 1505 (number of terms).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats

Complexes = npt.NDArray[np.complex128]

_TERMS_AT_ONCE = 256  # terms of the Mie series, which bound the memory of a block
_LARGEST_TABLE = 20_000_000  # logarithmic derivatives held at once
# Panels of the quadrature over scattering angle: the first, over the largest size parameter, and at most, rad; growth;
# widest, rad.
_FIRST_PANEL, _FIRST_LIMIT, _PANEL_GROWTH, _WIDEST_PANEL, _PANEL_POINTS = 0.3, 5e-4, 1.3, np.radians(1.5), 6


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
    efficiencies, _ = scattered_light(x.ravel(), m.ravel(), np.empty(0))
    extinction, scattering, asymmetry = (part.reshape(x.shape) for part in efficiencies)
    return extinction, scattering, asymmetry


def scattered_light(size_parameter: Floats, refractive_index: Complexes, cosine: Floats) -> tuple[Floats, Floats]:
    """Efficiencies of spheres, and the intensity of unpolarised light that they scatter.

    Parameters
    ----------
    size_parameter : (K,) array
        Circumference over wavelength, above 0.
    refractive_index : (K,) array of complex
        n + ik, k at least 0.
    cosine : (A,) array
        Cosine of the scattering angle.

    Returns
    -------
    efficiencies : (3, K) array
        Extinction, scattering, asymmetry.
    intensity : (K, A) array
        Mean of the squares of the two amplitudes, (|S1|^2 + |S2|^2) / 2.
    """
    order = np.argsort(size_parameter, kind="stable")
    efficiencies, intensity = np.empty((3, order.size)), np.empty((order.size, cosine.size))
    sorted_size = size_parameter[order]
    length = _terms(sorted_size) + (np.abs(refractive_index[order]) * sorted_size).astype(int)
    start = 0
    while start < order.size:
        within = np.arange(1, order.size - start + 1) * np.maximum.accumulate(length[start:]) <= _LARGEST_TABLE
        part = order[start : start + max(int(np.count_nonzero(within)), 1)]
        efficiencies[:, part], intensity[part] = _sorted_spheres(size_parameter[part], refractive_index[part], cosine)
        start += part.size
    return efficiencies, intensity


def phase_of_spheres(
    radius: Floats,
    number: Floats,
    refractive_index: complex,
    wavelength: float,
    angle: Floats,
    moments: int,
    *,
    averaged: bool = False,
) -> tuple[Floats, Floats, Floats]:
    """Scattering by mixtures of spheres of many sizes.

    Parameters
    ----------
    radius : (K,) array
        um, increasing.
    number : (E, K) array
        Number of spheres per radius, of E mixtures, in any measure.
    refractive_index : complex
        n + ik.
    wavelength : float
        um.
    angle : (A,) array
        Scattering angles from 0 to pi, rad, increasing.
    moments : int
        How many Legendre moments, of which the first is 1.
    averaged : bool
        The logarithm of the phase function is its mean about each angle, falling off to the next ones, in which the
        interference in large spheres of single sizes averages out.

    Returns
    -------
    sections : (3, E) array
        Extinction and scattering [um^2 times the measure of `number`] and asymmetry.
    phase : (E, A) array
        Mean over the sphere 1.
    moments : (E, M) array
    """
    node, weight = scattering_quadrature(2 * np.pi * radius[-1] / wavelength)
    at = node if averaged else np.append(node, angle)
    size = 2 * np.pi * radius / wavelength
    efficiencies, intensity = scattered_light(size, np.full(size.size, refractive_index), np.cos(at))
    share = number * _trapezoid_weights(radius)
    area = share * np.pi * radius**2
    extinction, scattering = area @ efficiencies[0], area @ efficiencies[1]
    asymmetry = (area * efficiencies[1]) @ efficiencies[2] / scattering
    # The differential section is intensity / k^2, the phase function 4 pi times it over the section.
    phase = 4 * np.pi * (share @ intensity) * (wavelength / (2 * np.pi)) ** 2 / scattering[:, None]
    at_node = phase[:, : node.size]
    mean = at_node * (0.5 * weight * np.sin(node))
    legendre = (mean @ np.polynomial.legendre.legvander(np.cos(node), moments - 1)) / mean.sum(axis=1)[:, None]
    if averaged:
        near = _hats(angle, node) * weight
        phase = np.exp(np.log(at_node) @ near.T / near.sum(axis=1))
    else:
        phase = phase[:, node.size :]
    return np.array([extinction, scattering, asymmetry]), phase, legendre


def scattering_quadrature(largest_size: float) -> tuple[Floats, Floats]:
    """Nodes and weights of scattering angles [rad], dense in the forward peak of spheres of a size parameter."""
    edges = [0.0, min(_FIRST_PANEL / largest_size, _FIRST_LIMIT)]
    while edges[-1] < np.pi:
        edges.append(edges[-1] + min((_PANEL_GROWTH - 1) * edges[-1], _WIDEST_PANEL))
    edges[-1] = np.pi
    point, weight = np.polynomial.legendre.leggauss(_PANEL_POINTS)
    lower, width = np.array(edges[:-1])[:, None], np.diff(edges)[:, None]
    return (lower + 0.5 * (point + 1) * width).ravel(), (0.5 * weight * width).ravel()


def _hats(angle: Floats, node: Floats) -> Floats:
    """Weights (A, Q) of functions that are 1 at one of the angles and fall linearly to 0 at its neighbours."""
    upper = np.clip(np.searchsorted(angle, node, side="right"), 1, angle.size - 1)
    share = (node - angle[upper - 1]) / (angle[upper] - angle[upper - 1])
    result = np.zeros((angle.size, node.size))
    column = np.arange(node.size)
    result[upper - 1, column] = 1 - share
    result[upper, column] = share
    return result


def _trapezoid_weights(radius: Floats) -> Floats:
    step = np.diff(radius)
    weight = np.zeros(radius.size)
    weight[:-1] += 0.5 * step
    weight[1:] += 0.5 * step
    return weight


def _terms(size: Floats) -> npt.NDArray[np.int64]:
    return np.asarray((size + 4.05 * size ** (1 / 3) + 2).astype(np.int64) + 1)


def _sorted_spheres(x: Floats, m: Complexes, cosine: Floats) -> tuple[Floats, Floats]:
    """As `scattered_light`, of sizes that rise."""
    terms = _terms(x)
    sums = np.zeros((3, x.size))
    # Amplitudes S1 + S2 and S1 - S2, real and imaginary parts.
    amplitude = np.zeros((2, 2, x.size, cosine.size))
    last_a, last_b = np.zeros(x.size, complex), np.zeros(x.size, complex)
    angular = _angular_functions(cosine, int(terms[-1]))
    for start, a, b in _coefficients(x, m, terms):
        n = np.arange(start, start + a.shape[1], dtype=float)
        sums[0] += (a.real + b.real) @ (2 * n + 1)
        sums[1] += (a.real**2 + a.imag**2 + b.real**2 + b.imag**2) @ (2 * n + 1)
        sums[2] += (a * b.conj()).real @ ((2 * n + 1) / (n * (n + 1)))
        before = [np.column_stack([previous, part[:, :-1]]) for previous, part in ((last_a, a), (last_b, b))]
        sums[2] += (before[0] * a.conj() + before[1] * b.conj()).real @ ((n - 1) * (n + 1) / n)
        last_a, last_b = a[:, -1], b[:, -1]
        if cosine.size:
            pi, tau = next(angular)
            factor = (2 * n + 1) / (n * (n + 1))
            for total, both, function in ((amplitude[0], a + b, pi + tau), (amplitude[1], a - b, pi - tau)):
                total[0] += (both.real * factor) @ function
                total[1] += (both.imag * factor) @ function
    intensity = 0.25 * np.sum(amplitude**2, axis=(0, 1))
    extinction, scattering = 2 * sums[0] / x**2, 2 * sums[1] / x**2
    return np.array([extinction, scattering, 2 * sums[2] / sums[1]]), intensity


def _coefficients(x: Floats, m: Complexes, terms: npt.NDArray[np.int64]) -> Iterator[tuple[int, Complexes, Complexes]]:
    """Number of the first term, and coefficients a and b (K, n) of it and those after it; 0 beyond a sphere's terms."""
    y = m * x
    size = np.abs(y)
    # The logarithmic derivative runs down from as far above |y|, where its start, 0, is forgotten before it counts.
    start = int(max(terms[-1], (size + 4.05 * size ** (1 / 3)).max())) + 16
    derivative = np.zeros((int(terms[-1]) + 1, x.size), complex)
    value = np.zeros(x.size, complex)
    for n in range(start, 0, -1):
        value = n / y - 1 / (value + n / y)
        if n <= terms[-1] + 1:
            derivative[n - 1] = value
    psi_before, psi = np.cos(x), np.sin(x)
    chi_before, chi = -np.sin(x), np.cos(x)
    for begin in range(1, int(terms[-1]) + 1, _TERMS_AT_ONCE):
        count = min(_TERMS_AT_ONCE, int(terms[-1]) + 1 - begin)
        a, b = np.zeros((x.size, count), complex), np.zeros((x.size, count), complex)
        for n in range(begin, begin + count):
            # Upward recurrence is stable up to a sphere's own number of terms only.
            on = slice(int(np.searchsorted(terms, n)), None)
            size = x[on]
            psi_now = (2 * n - 1) * psi[on] / size - psi_before[on]
            chi_now = (2 * n - 1) * chi[on] / size - chi_before[on]
            xi, xi_now = psi[on] - 1j * chi[on], psi_now - 1j * chi_now
            electric = derivative[n, on] / m[on] + n / size
            magnetic = derivative[n, on] * m[on] + n / size
            a[on, n - begin] = (electric * psi_now - psi[on]) / (electric * xi_now - xi)
            b[on, n - begin] = (magnetic * psi_now - psi[on]) / (magnetic * xi_now - xi)
            psi_before[on], psi[on], chi_before[on], chi[on] = psi[on].copy(), psi_now, chi[on].copy(), chi_now
        yield begin, a, b


def _angular_functions(cosine: Floats, terms: int) -> Iterator[tuple[Floats, Floats]]:
    """Functions pi and tau (n, A) of the terms, part by part as `_coefficients`."""
    before, now = np.zeros(cosine.size), np.ones(cosine.size)
    for start in range(1, terms + 1, _TERMS_AT_ONCE):
        numbers = range(start, min(start + _TERMS_AT_ONCE, terms + 1))
        pi, tau = np.empty((len(numbers), cosine.size)), np.empty((len(numbers), cosine.size))
        for row, n in enumerate(numbers):
            if n > 1:
                before, now = now, ((2 * n - 1) * cosine * now - n * before) / (n - 1)
            pi[row], tau[row] = now, n * cosine * now - (n + 1) * before
        yield pi, tau
