"""Digits that a file leaves out, for what its numbers err by: the zeros in their place pack well."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats, Singles

_LAST_DIGIT = 2.0**-149  # smallest number in single precision


def rounded_to(values: npt.ArrayLike, step: npt.ArrayLike) -> Floats:
    """Whole numbers of the power of two at or below a step.

    Examples
    --------
    >>> rounded_to([0.9, -1.2], 0.3).tolist()
    [1.0, -1.25]
    """
    unit = np.exp2(np.floor(np.log2(np.maximum(np.asarray(step, float), _LAST_DIGIT))))
    return np.asarray(np.rint(np.asarray(values, float) / unit) * unit)


def rounded_bits(values: Singles, bits: int) -> Singles:
    """Values to so many binary digits."""
    dropped = 24 - bits
    half, mask = np.uint32(1 << (dropped - 1)), np.uint32(0xFFFFFFFF << dropped & 0xFFFFFFFF)
    cut: Singles = ((values.view(np.uint32) + half) & mask).view(np.float32)
    return cut
