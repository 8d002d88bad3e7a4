"""Posteriors and typicality averaged over a square box about each texel, in exact integers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

POSTERIOR_ONE = 65535  # posteriors are summed as 16 bit integers: with MAX_RADIUS a sum stays below 2^32


def pairs_of(posterior: npt.NDArray[np.uint16]) -> npt.NDArray[Any]:
    """Planes (K, ...) uint16 as pairs ((K + 1) // 2, ...) uint64, one in the lower and one in the upper 32 bits.

    Sums of a pair are the pair of the sums, at half the work; each fits 32 bits with MAX_RADIUS, so none carries over.
    """
    pairs = posterior[::2].astype(np.uint64)
    pairs[: len(posterior) // 2] |= posterior[1::2].astype(np.uint64) << np.uint64(32)
    return pairs


def strongest(
    pairs: Iterable[npt.NDArray[Any]],
    number: int,
    valid: npt.NDArray[np.bool_],
    radius: int,
    inner: tuple[slice, slice],
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Material of the largest mean posterior over the box about each inner texel, and that mean as float32.

    Parameters
    ----------
    pairs : iterable of (h, w) uint64
        Posteriors in units of 1 / POSTERIOR_ONE, as `pairs_of` makes them.
    number : int
        Of the pairs.
    valid : (h, w) bool
        Texels that count.
    """
    if not valid.all():
        pairs = (pair * valid for pair in pairs)
    sums = (_box_sum(pair, radius, inner) for pair in pairs)
    material, best = _largest(sums, number, POSTERIOR_ONE * (2 * radius + 1) ** 2)
    confidence = best.astype(np.float32) / (np.float32(POSTERIOR_ONE) * _members(valid, radius, inner))
    return material, np.minimum(confidence, np.float32(1))


def averaged(
    plane: npt.NDArray[np.float32], valid: npt.NDArray[np.bool_], radius: int, inner: tuple[slice, slice]
) -> npt.NDArray[np.float32]:
    """Mean of values (h, w), 0 to 1, over the texels with data in the box about each inner texel.

    Parameters
    ----------
    valid : (h, w) bool
        Texels that count.
    """
    if radius == 0:
        return plane[inner]
    counted = np.rint(plane * np.float32(POSTERIOR_ONE)).astype(np.uint16)
    if not valid.all():
        counted *= valid
    sums = _box_sum(counted, radius, inner).astype(np.float32)
    sums /= np.float32(POSTERIOR_ONE) * _members(valid, radius, inner)
    return np.minimum(sums, np.float32(1), out=sums)


def _largest(pairs: Iterable[npt.NDArray[Any]], number: int, limit: int) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Number (h, w) int16 of the plane with the largest value, the first among equals, and that value, uint32.

    Parameters
    ----------
    pairs : iterable of (h, w) uint64
        `number` pairs of planes; written to.
    limit : int
        The largest value that may occur.
    """
    last = 2 * number - 1
    bits = last.bit_length()
    if limit >> (32 - bits):
        return _largest_by_plane(pairs)
    # The plane's number, counted from the last, stands in the bits below its value: one maximum finds both.
    best: npt.NDArray[np.uint32] = np.empty(0, np.uint32)
    for k, both in enumerate(pairs):
        both <<= np.uint64(bits)
        both |= np.uint64((last - 2 * k - 1) << 32 | (last - 2 * k))
        keys = both.view(np.uint32)
        best = np.maximum(best, keys, out=best) if k else keys
    best = np.maximum(best[:, ::2], best[:, 1::2])
    return np.int16(last) - (best & np.uint32((1 << bits) - 1)).astype(np.int16), best >> np.uint32(bits)


def _largest_by_plane(pairs: Iterable[npt.NDArray[Any]]) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    material: npt.NDArray[np.int16] = np.empty(0, np.int16)
    best: npt.NDArray[np.uint32] = np.empty(0, np.uint32)
    for k, both in enumerate(pairs):
        if k == 0:
            material, best = np.zeros(both.shape, np.int16), np.zeros(both.shape, np.uint32)
        for half, value in enumerate((both.astype(np.uint32), (both >> np.uint64(32)).astype(np.uint32))):
            np.copyto(material, np.int16(2 * k + half), where=value > best)
            np.maximum(best, value, out=best)
    return material, best


def _members(valid: npt.NDArray[np.bool_], radius: int, inner: tuple[slice, slice]) -> npt.NDArray[Any]:
    """Number of texels with data in the box about each inner texel, float32, at least 1: those that its mean is
    over.
    """
    if not valid.all():
        members: npt.NDArray[np.float32] = np.maximum(_box_sum(valid, radius, inner), 1).astype(np.float32)
        return members
    ends = zip(valid.shape, inner, strict=True)
    rows, columns = (_box_sum(np.ones((1, n), bool), radius, np.s_[:, part])[0].astype(np.float32) for n, part in ends)
    whole: npt.NDArray[np.float32] = np.multiply.outer(rows, columns)
    return whole


def _box_sum(plane: npt.NDArray[Any], radius: int, inner: tuple[slice, slice]) -> npt.NDArray[Any]:
    """Sum over the square of `radius` about each inner texel, with nothing beyond the edge: uint64 of pairs, else
    uint32.

    Running sums in integers are exact, whatever the block; they may wrap, their differences are right while the sum
    itself fits, which MAX_RADIUS ensures.
    """
    (height, width), side = plane.shape, 2 * radius + 1
    kind = np.uint64 if plane.dtype == np.uint64 else np.uint32
    running = np.zeros((height, width + side), kind)
    np.cumsum(plane, axis=1, dtype=kind, out=running[:, radius + 1 : radius + 1 + width])
    running[:, radius + 1 + width :] = running[:, radius + width, np.newaxis]
    across = running[:, side:][:, inner[1]] - running[:, :-side][:, inner[1]]
    running = np.zeros((height + side, across.shape[1]), kind)
    for row in range(height):  # numpy's own cumsum down the columns is many times slower than adding rows
        np.add(running[radius + row], across[row], out=running[radius + row + 1])
    running[radius + 1 + height :] = running[radius + height]
    return running[side:][inner[0]] - running[:-side][inner[0]]
