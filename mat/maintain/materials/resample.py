"""Resampling of a finely known spectrum to the compact grid of the library."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded

from skyshine.schemas.arrays import Floats

# Relative step of the compact grid up to 15 um and beyond; the source features (resolution 4 to 16 cm^-1 in the
# thermal infrared) are broader than 1 %.
STEP, COARSE_STEP, COARSE_FROM = 0.01, 0.025, 15.0
# Relative step at which the sources are read: finer than any of them.
FINE_STEP = 0.0005


def compact_grid(lower: float, upper: float) -> Floats:
    """Nodes of the compact grid [um], both ends included."""
    inner = min(upper, COARSE_FROM)
    count = int(np.ceil(np.log(inner / lower) / np.log1p(STEP)))
    nodes = np.geomspace(lower, inner, count + 1)
    if upper > COARSE_FROM:
        count = int(np.ceil(np.log(upper / COARSE_FROM) / np.log1p(COARSE_STEP)))
        nodes = np.concatenate([nodes, np.geomspace(COARSE_FROM, upper, count + 1)[1:]])
    return np.round(nodes, 5)


def fine_grid(lower: float, upper: float) -> Floats:
    """Points at which the sources are read [um]."""
    return np.geomspace(lower, upper, int(np.ceil(np.log(upper / lower) / np.log1p(FINE_STEP))) + 1)


def project(fine: Floats, values: Floats, nodes: Floats) -> Floats:
    """Piecewise linear function on `nodes` nearest to a finely sampled one in the mean square.

    The residual is orthogonal to every hat function, and these sum to 1: the integral over the
    whole grid is conserved, and that over any band of several nodes nearly so.

    Parameters
    ----------
    fine, values : ndarray, shape (f,)
        Wavelengths [um] and the spectrum there; `fine` spans the nodes.
    nodes : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (n,)
    """
    cell = np.clip(np.searchsorted(nodes, fine, side="right") - 1, 0, len(nodes) - 2)
    right = (fine - nodes[cell]) / np.diff(nodes)[cell]
    complement = 1.0 - right
    weight = np.gradient(fine)
    diagonal = np.bincount(cell, weight * complement**2, len(nodes)) + np.bincount(
        cell + 1, weight * right**2, len(nodes)
    )
    beside = np.bincount(cell, weight * complement * right, len(nodes))
    target = np.bincount(cell, weight * complement * values, len(nodes)) + np.bincount(
        cell + 1, weight * right * values, len(nodes)
    )
    banded = np.array([np.concatenate([[0.0], beside[:-1]]), diagonal])
    return np.asarray(solveh_banded(banded, target))
