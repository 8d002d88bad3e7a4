"""Sums and means over a square box about each place of a grid, in exact integers, and grids coarser than the texels."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

POSTERIOR_ONE = 65535  # posteriors are summed as 16 bit integers: with MAX_RADIUS a sum stays below 2^32


class Cells:
    """The cells, squares of `side` texels from the top left corner on, that contain a stretch of rows or of columns.

    wide : slice; these cells and `reach` more to each side, as far as the texture goes.
    inner : slice; they themselves, within `wide`.
    texels : slice; the stretch, within their texels.

    Examples
    --------
    >>> cells = Cells(5, 9, 100, side=4, reach=1)
    >>> cells.wide, cells.inner, cells.texels
    (slice(0, 4, None), slice(1, 3, None), slice(1, 5, None))
    """

    def __init__(self, start: int, stop: int, size: int, side: int, reach: int) -> None:
        """Of texels `start` to `stop` of `size`."""
        low, end = start // side, (stop - 1) // side + 1
        before = max(low - reach, 0)
        self.wide = slice(before, min(end + reach, -(-size // side)))
        self.inner = slice(low - before, end - before)
        self.texels = slice(start - low * side, stop - low * side)


def at_texels(values: npt.NDArray[Any], side: int, rows: Cells, columns: Cells) -> npt.NDArray[Any]:
    """Values (h, w) of inner cells at their texels."""
    if side == 1:
        return values
    high, wide = values.shape
    fine = np.broadcast_to(values[:, np.newaxis, :, np.newaxis], (high, side, wide, side))
    return np.ascontiguousarray(fine.reshape(high * side, wide * side)[rows.texels, columns.texels])


def strongest(
    planes: Iterable[npt.NDArray[np.uint16]], valid: npt.NDArray[np.bool_], radius: int, inner: tuple[slice, slice]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Material (h, w) int16 of the largest mean posterior over the box about each inner place, the first among equals,
    and that mean as float32.

    planes : iterable of (h, w) uint16; posterior of each material in units of 1 / POSTERIOR_ONE.
    valid : (h, w) bool; places that count.
    """
    material: npt.NDArray[np.int16] = np.empty(0, np.int16)
    best: npt.NDArray[np.uint32] = np.empty(0, np.uint32)
    complete = valid.all()
    for k, plane in enumerate(planes):
        sums = _box_sum(plane if complete else plane * valid, radius, inner)
        if k == 0:
            material, best = np.zeros(sums.shape, np.int16), sums
            continue
        np.copyto(material, np.int16(k), where=sums > best)
        np.maximum(best, sums, out=best)
    return material, _mean(best, valid, radius, inner)


def averaged(
    plane: npt.NDArray[np.float32], valid: npt.NDArray[np.bool_], radius: int, inner: tuple[slice, slice]
) -> npt.NDArray[np.float32]:
    """Mean of values (h, w), 0 to 1, over the places that count, `valid` (h, w), in the box about each inner one."""
    if radius == 0:
        return plane[inner]
    counted = np.rint(plane * np.float32(POSTERIOR_ONE)).astype(np.uint16)
    return _mean(_box_sum(counted * valid, radius, inner), valid, radius, inner)


def _mean(
    sums: npt.NDArray[np.uint32], valid: npt.NDArray[np.bool_], radius: int, inner: tuple[slice, slice]
) -> npt.NDArray[np.float32]:
    mean = sums.astype(np.float32)
    mean /= np.float32(POSTERIOR_ONE) * np.maximum(_box_sum(valid, radius, inner), 1).astype(np.float32)
    return np.minimum(mean, np.float32(1), out=mean)


def _box_sum(plane: npt.NDArray[Any], radius: int, inner: tuple[slice, slice]) -> npt.NDArray[np.uint32]:
    """Sum over the square of `radius` about each inner place, with nothing beyond the edge.

    Running sums in integers are exact, whatever the block; they may wrap, their differences are right while the sum
    itself fits, which MAX_RADIUS ensures.
    """
    (height, width), side = plane.shape, 2 * radius + 1
    running = np.zeros((height, width + side), np.uint32)
    np.cumsum(plane, axis=1, dtype=np.uint32, out=running[:, radius + 1 : radius + 1 + width])
    running[:, radius + 1 + width :] = running[:, radius + width, np.newaxis]
    across = running[:, side:][:, inner[1]] - running[:, :-side][:, inner[1]]
    running = np.zeros((height + side, across.shape[1]), np.uint32)
    for row in range(height):  # numpy's own cumsum down the columns is many times slower than adding rows
        np.add(running[radius + row], across[row], out=running[radius + row + 1])
    running[radius + 1 + height :] = running[radius + height]
    sums: npt.NDArray[np.uint32] = running[side:][inner[0]] - running[:-side][inner[0]]
    return sums
