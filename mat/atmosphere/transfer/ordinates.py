"""Discrete ordinates: the directions of the equations of scattering layers, by azimuthal moment, and the light that
goes from direction to direction.

Radiances travel at the Gauss nodes of each hemisphere, and depend on azimuth by the cosines of its multiples.

References
----------
Stamnes, Tsay, Wiscombe and Jayaweera 1988, Appl. Opt. 27, 2502.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.schemas.arrays import Booleans, Floats, Integers, Reals

# Azimuthal moments of light scattered more than once.
AZIMUTHAL = 6


@dataclass(frozen=True, eq=False)
class Ordinates:
    """Directions of n nodes a hemisphere, for M azimuthal moments.

    Attributes
    ----------
    node, weight : (n,) arrays
        Cosines of the angle from the vertical; their weights sum to 1.
    at_nodes : (M, L, n) array
        `legendre` of the nodes.
    """

    node: Floats
    weight: Floats
    at_nodes: Floats

    @property
    def moments(self) -> int:
        """L: as many moments of the phase function as there are nodes in both hemispheres."""
        return 2 * self.node.size

    @property
    def azimuthal(self) -> int:
        """M."""
        return len(self.at_nodes)

    @property
    def even(self) -> Booleans:
        """Whether an associated Legendre function is even in the cosine, l + m even: (M, L, 1)."""
        even: Booleans = (np.add.outer(np.arange(self.azimuthal), np.arange(self.moments)) % 2 == 0)[..., None]
        return even

    @property
    def factor(self) -> Floats:
        """2 l + 1, (L,)."""
        factor: Floats = 2 * np.arange(self.moments, dtype=float) + 1
        return factor

    @property
    def twice(self) -> Floats:
        """Factor of each azimuthal moment, (M,): 2, but for the first."""
        twice: Floats = np.where(np.arange(self.azimuthal) == 0, 1.0, 2.0)
        return twice

    def legendre(self, cosine: npt.ArrayLike) -> Floats:
        """Associated Legendre functions with unit norm factor, sqrt((l - m)! / (l + m)!) P_l^m, (M, L, X) at cosines
        (X,).
        """
        return _legendre(np.asarray(cosine, dtype=float), self.azimuthal, self.moments)

    @property
    def pairs(self) -> tuple[Integers, Integers]:
        """Azimuthal moment and degree of the associated Legendre functions that are not 0, (B,) each."""
        return _pairs(self.azimuthal, self.moments)

    def functions(self, cosine: Floats) -> Floats:
        """Those functions (X, B) at cosines (X,), of a source function tabulated by `pairs`."""
        azimuth, degree = self.pairs
        return np.ascontiguousarray(self.legendre(cosine)[azimuth, degree].T)

    def flux(self, radiance: Reals) -> Reals:
        """Flux (N, ...) through the levels, of the radiances (N, M, n, ...) of one hemisphere."""
        flux: Reals = 2 * np.pi * np.tensordot(self.weight * self.node, radiance[:, 0], axes=(0, 1))
        return flux

    def moments_at_levels(self, rising: Reals, falling: Reals) -> tuple[Reals, Reals]:
        """Legendre moments (N, M, L, U, P) of the radiances (N, M, n, U, P), halved: those of functions even in the
        cosine, 0 for the others, and those of odd functions.
        """
        shape = rising.shape
        parts = []
        for parity, radiance in ((self.even, rising + falling), (~self.even, rising - falling)):
            weights = (np.where(parity, 0.5 * self.at_nodes, 0.0) * self.weight).astype(rising.dtype)  # (M, L, n)
            moments = weights @ radiance.reshape(*shape[:3], -1)
            parts.append(moments.reshape(*shape[:2], self.moments, *shape[3:]))
        return parts[0], parts[1]

    def from_moments(self, weighted: Reals, even: Reals, odd: Reals) -> tuple[Reals, Reals]:
        """Light (N, M, n, U, P) scattered into the nodes going up and going down, from `moments_at_levels`; `weighted`
        as of `scattered_into`.
        """
        shape = even.shape
        outgoing = np.swapaxes(self.at_nodes, -1, -2).astype(even.dtype)
        both, difference = (
            (outgoing @ (part * weighted[:, None, :, None]).reshape(*shape[:3], -1)).reshape(*shape[:2], -1, *shape[3:])
            for part in (even, odd)
        )
        return both + difference, both - difference

    def scattered_into(self, weighted: Floats, rising: Floats, falling: Floats, cosine: Floats) -> Floats:
        """Diffuse radiation scattered into directions.

        Parameters
        ----------
        weighted : (N, L, P) array
            Scattering times 2 l + 1 times the moments of the phase function, in any unit.
        rising, falling : (N, M, n, U, P) arrays
            Radiances.
        cosine : (X,) array
            Cosines of the directions, positive up.

        Returns
        -------
        (N, M, X, U, P) array
            In the product of both units.
        """
        even, odd = self.moments_at_levels(rising, falling)
        moments = (even + odd) * weighted[:, None, :, None]
        outgoing = np.swapaxes(self.legendre(cosine), -1, -2)
        scattered = outgoing @ moments.reshape(*even.shape[:3], -1)
        result: Floats = scattered.reshape(*even.shape[:2], -1, *even.shape[3:])
        return result

    def out_of_beam(self, weighted: Floats, sine: Floats) -> Floats:
        """Light scattered out of a beam of unit irradiance into the nodes.

        Parameters
        ----------
        weighted : (N-1, L, P) array
            Weights as in `scattered_into`.
        sine : (U,) array
            Sine of the source's elevation.

        Returns
        -------
        (N-1, M, 2 n, U, P) array
            sr^-1: into the nodes going up, and into those going down.
        """
        outgoing = np.concatenate([self.at_nodes, np.where(self.even, self.at_nodes, -self.at_nodes)], axis=2)
        pairs = outgoing[..., None] * self.legendre(-sine)[:, :, None]  # (M, L, 2 n, U)
        pairs *= (self.twice / (4 * np.pi))[:, None, None, None]
        light: Floats = np.einsum("mlnu,klp->kmnup", pairs, weighted, optimize=True)
        return light


@lru_cache
def ordinates(nodes: int, azimuthal: int = AZIMUTHAL) -> Ordinates:
    """Gauss's directions, with so many nodes a hemisphere."""
    node, weight = np.polynomial.legendre.leggauss(nodes)
    node, weight = 0.5 * node + 0.5, 0.5 * weight
    return Ordinates(node, weight, _legendre(node, azimuthal, 2 * nodes))


@lru_cache
def _pairs(azimuthal: int, moments: int) -> tuple[Integers, Integers]:
    azimuth, degree = np.nonzero(np.arange(moments) >= np.arange(azimuthal)[:, None])
    return azimuth, degree


def _legendre(cosine: Floats, azimuthal: int, moments: int) -> Floats:
    result = np.zeros((azimuthal, moments, cosine.size))
    for m in range(azimuthal):
        for order in range(m, moments):
            scale = math.sqrt(math.factorial(order - m) / math.factorial(order + m))
            result[m, order] = scale * scipy.special.lpmv(m, order, cosine)
    return result
