"""The optical depths of a few spectral points, of which those of all points of a band are sums."""

from __future__ import annotations

import numpy as np

from skyshine.mat.quantities.channels.parts import Parts, fitted_parts, pivots
from skyshine.schemas.arrays import Floats

# Absorbers are added until the transmittance of sample paths is right; at most so many.
MOST_ABSORBERS = 20
_LEAST, _STEP = 4, 2  # number of absorbers at first, and added until the error is allowed
_SMALLEST = 1e-300  # extinction, of points that absorb nothing
_MOST_ROWS = 1500  # paths that enter the decomposition: its time grows with their number
_WORST = 5.0  # root mean square errors; paths that are no sample err by more where the worst of the sample does
_OPAQUE = 1e-4  # transmittance added to all, so that the depth of opaque points is determined


def absorbers(depth: Floats, length: Floats, weight: Floats, allowed: float) -> Parts:
    """The fewest points that give the in-band transmittance of sample paths.

    Parameters
    ----------
    depth : (n, P) array
        Optical depths of n paths.
    length : (n,) array
        Length of the paths; any unit.
    weight : (P,) array
        Weights of the points in the band.
    allowed : float
        Root mean square error of transmittance; the largest is within `_WORST` times.

    Returns
    -------
    Parts
        Of the P points.
    """
    rows = slice(None, None, max(1, len(depth) // _MOST_ROWS))
    depth, length, share = depth[rows], length[rows], weight / weight.sum()
    through = np.exp(-depth)
    mean = depth / length[:, None]
    exact, order = through @ share, pivots(mean / np.maximum(np.sqrt(np.mean(mean**2, axis=0)), _SMALLEST))
    limit = min(MOST_ABSORBERS, depth.shape[1])
    for count in range(min(_LEAST, limit), limit + 1, _STEP):
        chosen = fitted_parts(depth, np.sort(order[:count]), through + _OPAQUE)
        error = np.exp(-np.maximum(depth[:, chosen.index] @ chosen.factor.T, 0.0)) @ share - exact
        if np.sqrt(np.mean(error**2)) <= allowed and np.abs(error).max() <= _WORST * allowed:
            break
    return chosen
