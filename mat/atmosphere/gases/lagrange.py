"""Cubic Lagrange interpolation weights on uneven nodes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats


def lagrange_weights(nodes: npt.ArrayLike, x: npt.ArrayLike) -> Floats:
    """Weights of the cubic through the four nodes around each x.

    Parameters
    ----------
    nodes : (N,) array, increasing, N >= 2 (with fewer than four nodes, the polynomial through all of them)
    x : array of any shape, within the nodes

    Returns
    -------
    x.shape + (N,) array; each row sums to 1 and is 0 outside its stencil
    """
    nodes, x = np.asarray(nodes, float), np.asarray(x, float)
    size = min(4, nodes.size)
    start = np.clip(np.searchsorted(nodes, x, side="right") - size // 2, 0, nodes.size - size)
    index = start[..., None] + np.arange(size)
    stencil = nodes[index]
    weights = np.zeros((*x.shape, nodes.size))
    for k in range(size):
        others = np.delete(stencil, k, axis=-1)
        value = np.prod((x[..., None] - others) / (stencil[..., k, None] - others), axis=-1)
        np.put_along_axis(weights, index[..., k, None], value[..., None], axis=-1)
    return weights
