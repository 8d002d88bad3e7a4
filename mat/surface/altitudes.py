"""Quantities between altitudes."""

from __future__ import annotations

import numpy as np

from skyshine.schemas.arrays import Floats


def between_altitudes(nodes: Floats, values: Floats, altitude: Floats) -> Floats:
    """Values at altitudes (A,), linear between the nodes and constant beyond them.

    Parameters
    ----------
    nodes : (L,) ndarray
        Increasing [m].
    values : (L, ...) ndarray
    altitude : (A,) ndarray
        [m]

    Returns
    -------
    (A, ...) ndarray

    Examples
    --------
    >>> between_altitudes(np.array([0.0, 100.0]), np.array([[1.0], [3.0]]), np.array([50.0, 900.0])).tolist()
    [[2.0], [3.0]]
    """
    if nodes.size == 1:
        return np.repeat(values, len(altitude), axis=0)
    lower = np.clip(np.searchsorted(nodes, altitude, side="right") - 1, 0, nodes.size - 2)
    share = np.clip((np.asarray(altitude) - nodes[lower]) / np.diff(nodes)[lower], 0.0, 1.0)
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    between: Floats = values[lower] * (1 - share) + values[lower + 1] * share
    return between
