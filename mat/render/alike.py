"""Rows of numbers that are alike, so that what they say is computed once."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Integers


def alike(*parts: npt.NDArray[Any]) -> tuple[Integers, Integers]:
    """Kinds of row that are alike, bit by bit, in all parts.

    Parameters
    ----------
    *parts : (n,) or (n, ...) arrays

    Returns
    -------
    first : (k,) int array
        A row of each kind.
    kind : (n,) int array
        Of each row.
    """
    rows = len(parts[0])
    if rows == 0:
        return np.zeros(0, int), np.zeros(0, int)
    flat = [np.ascontiguousarray(part.reshape(rows, -1)).view(np.uint8) for part in parts]
    key = np.ascontiguousarray(np.concatenate(flat, axis=1))
    _, row, kind = np.unique(key.view(np.dtype((np.void, key.shape[1])))[:, 0], return_index=True, return_inverse=True)
    return row, kind.ravel()
