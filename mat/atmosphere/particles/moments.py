"""Legendre moments of phase functions.

References
----------
Chandrasekhar 1950, Radiative Transfer, section 48.
"""

from __future__ import annotations

import numpy as np

from skyshine.schemas.arrays import Floats

MOMENTS = 65  # held of each phase function: a solution of 64 streams, and the fraction that goes straight forward


def moment_weights(angle: Floats, count: int) -> Floats:
    """Weights (count, A) of values at angles (A,) [rad] in the Legendre moments of a function linear between them; the
    first row gives its mean.
    """
    point, weight = np.polynomial.legendre.leggauss(4)
    part, width = 0.5 * (point + 1), np.diff(angle)[:, None]
    node = angle[:-1, None] + part * width
    share = (
        0.25
        * weight
        * width
        * np.sin(node)
        * np.moveaxis(np.polynomial.legendre.legvander(np.cos(node), count - 1), -1, 0)
    )
    result = np.zeros((count, angle.size))
    result[:, :-1] += np.sum(share * (1 - part), axis=-1)
    result[:, 1:] += np.sum(share * part, axis=-1)
    return result


def log_linear_mean(angle: Floats, phase: Floats) -> Floats:
    """Mean over the sphere (...) of phase functions (A, ...) whose logarithm is linear between angles (A,) [rad]."""
    point, weight = np.polynomial.legendre.leggauss(8)
    part, width = 0.5 * (point + 1), np.diff(angle)[:, None]
    node = angle[:-1, None] + part * width
    logarithm = np.log(phase)
    lower, rise = logarithm[:-1, None], np.diff(logarithm, axis=0)[:, None]
    shape = (1, part.size, *(1,) * (phase.ndim - 1))
    between = np.exp(lower + part.reshape(shape) * rise)
    mean: Floats = np.tensordot(0.25 * weight * width * np.sin(node), between, axes=2)
    return mean
