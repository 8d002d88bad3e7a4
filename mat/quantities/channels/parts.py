"""Interpolation of many columns from a few: interpolative decomposition of spectra and of source directions.

Optical depths of a band's points along a path, the light of its points, and path radiance under all directions of the
source are nearly linear in few of themselves. The few are chosen by pivoted QR, all others are sums of them with
factors of least squares.

References
----------
Businger and Golub 1965, Numer. Math. 7, 269 (QR with column pivoting).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from skyshine.schemas.arrays import Floats, Integers

# Share of the squared norm of a column added to the normal equations: limits coefficients where columns hardly differ.
_RIDGE = 1e-11


@dataclass(frozen=True, eq=False)
class Parts:
    """K columns chosen of n, and what the others are of them.

    Attributes
    ----------
    index : (K,) int array
    factor : (n, K) array
        Column j is the sum over k of factor[j, k] times column index[k].
    """

    index: Integers
    factor: Floats

    @property
    def count(self) -> int:
        """K."""
        return int(self.index.size)


def pivots(values: Floats) -> Integers:
    """Columns (n,) of values (m, n) in the order in which QR with pivoting takes them: the largest first, each next by
    what is left of it.
    """
    order: Integers = scipy.linalg.qr(values, mode="r", pivoting=True)[1]
    return order


def fitted_parts(values: Floats, index: Integers, weight: Floats | None = None) -> Parts:
    """The factors of chosen columns by least squares.

    Parameters
    ----------
    values : (m, n) array
    index : (K,) int array
    weight : (m, n) array, optional
        Weight of each value's error; by default 1.
    """
    base = values[:, index]
    if weight is None:
        factor = _solved(base[None], values[None])[0].T
    else:
        of_columns = np.ascontiguousarray(weight.T)[..., None]
        factor = _solved(base * of_columns, values.T[..., None] * of_columns)[..., 0]
    factor[index] = np.eye(index.size)
    return Parts(index, factor)


def _solved(base: Floats, values: Floats) -> Floats:
    """Least squares of B systems: coefficients (B, K, n) of bases (B, m, K) for values (B, m, n)."""
    scale = np.linalg.norm(base, axis=1, keepdims=True)
    scale = np.where(scale > 0, scale, 1.0)
    scaled = base / scale
    across = np.swapaxes(scaled, 1, 2)
    normal = across @ scaled + _RIDGE * np.eye(base.shape[2])
    solved: Floats = np.asarray(np.linalg.solve(normal, across @ values), float) / np.swapaxes(scale, 1, 2)
    return solved


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
