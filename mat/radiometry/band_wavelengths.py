"""Spectra within a band as numbers at a few wavelengths, linear between them.

A spectrum f represents sum_b f_b h_b(wavelength), where the functions h_b are 1 at one of the wavelengths, 0 at the
others, and sum to 1 everywhere. Light parted by these functions meets the reflectance of any material as a sum over
them, whatever the light's own spectrum is within.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavelength
from skyshine.schemas.arrays import Floats

if TYPE_CHECKING:
    from skyshine.materials.library import Material

_STEP = 0.02  # fraction of the middle wavelength: spectra of materials in 3-5 and 8-12 um to a hundredth of a kelvin
_FEWEST, _MOST = 9, 65  # wavelengths of a band
_PER_STEP = 40  # samples of a material's spectrum
_TIE = 1e-6  # weight that ties numbers at wavelengths without response to the spectrum itself


def band_wavelengths(response: SpectralResponse) -> Floats:
    """The wavelengths of a band, (B,) [um], evenly from its lower to its upper end.

    Examples
    --------
    >>> from skyshine.mat.radiometry.blackbody import SpectralResponse
    >>> band_wavelengths(SpectralResponse.rectangular(3.0, 5.0)).size
    26
    """
    step = _STEP * (response.upper + response.lower) / 2
    count = int(np.clip(np.ceil((response.upper - response.lower) / step), _FEWEST - 1, _MOST - 1)) + 1
    return np.linspace(response.lower, response.upper, count)


def parted(wavelength: Floats, nodes: Floats) -> Floats:
    """The functions h_b of nodes (B,) at wavelengths (n,), both in um, (n, B); the end values beyond the ends."""
    position = np.clip((wavelength - nodes[0]) / (nodes[1] - nodes[0]), 0.0, nodes.size - 1.0)
    lower = np.minimum(position.astype(int), nodes.size - 2)
    shares, row = np.zeros((wavelength.size, nodes.size)), np.arange(wavelength.size)
    shares[row, lower] = 1.0 - (position - lower)
    shares[row, lower + 1] += position - lower
    return shares


def reflectance_spectra(materials: Sequence[Material], response: SpectralResponse) -> Floats:
    """Reflectance of materials at the wavelengths of a band, (M, B): the nearest by the response, 0 to 1."""
    nodes = band_wavelengths(response)
    fine = np.linspace(nodes[0], nodes[-1], _PER_STEP * (nodes.size - 1) + 1)
    weight = response.at_wavelength(fine)
    shares = parted(fine, nodes)
    normal = (shares * weight[:, None]).T @ shares
    tie = _TIE * np.trace(normal) / nodes.size
    normal[np.diag_indices(nodes.size)] += tie
    spectra = np.array([np.interp(fine, m.wavelength, m.reflectance) for m in materials])
    at_nodes = np.array([np.interp(nodes, m.wavelength, m.reflectance) for m in materials])
    projected = np.linalg.solve(normal, (spectra * weight @ shares + tie * at_nodes).T).T
    return np.clip(projected, 0.0, 1.0)


def emission_shares(response: SpectralResponse, temperature: Floats) -> Floats:
    """Share of each wavelength of a band in what a black body emits into it, (T, B), at temperatures (T,) [K], above
    0; each row sums to 1.
    """
    nodes = band_wavelengths(response)
    between = response.wavelength[(response.wavelength > nodes[0]) & (response.wavelength < nodes[-1])]
    edges = np.union1d(nodes, between)
    node, weight = SpectralResponse(edges, response.at_wavelength(edges)).quadrature
    # A factor of each temperature cancels; without it cold black bodies underflow.
    exponent = np.log(np.maximum(planck_wavelength(node, temperature[:, None]), np.finfo(float).tiny))
    emitted = np.exp(exponent - exponent.max(axis=1, keepdims=True)) * weight
    by_node = emitted @ parted(node, nodes)
    shares: Floats = by_node / by_node.sum(axis=1, keepdims=True)
    return shares
