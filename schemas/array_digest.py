"""The digest of one array, block by block and byte plane by byte plane, so that it is had while the array is written.

Blocks follow from the shape alone, whatever the chunks in which HDF5 stores an array: `BLOCK` x `BLOCK` along the first
two axes with all of the others, or `BLOCK`^2 values of an array of one axis. The digest of an array is SHA-256 over
those of its blocks in row-major order; that of a block over those of its byte planes (the first bytes of all values,
the second ones, ...; numbers are little-endian); that of a plane over its bytes. A plane of one value alone, as the
high bytes of codes are, is hashed once for all blocks.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

BLOCK = 256  # block of each of the first two axes; another number changes every digest


def block_shape(shape: Sequence[int]) -> tuple[int, ...]:
    """Extent of the blocks of an array of this shape; those at its ends are smaller."""
    limits = (BLOCK * BLOCK,) if len(shape) == 1 else (BLOCK, BLOCK)
    return tuple(min(limit, length) for limit, length in zip(limits, shape, strict=False)) + tuple(shape[2:])


def array_digest(values: npt.NDArray[Any]) -> bytes:
    """Digest of an array of numbers of any shape.

    Examples
    --------
    >>> plane = hashlib.sha256(bytes([7, 8])).digest()
    >>> array_digest(np.array([7, 8], np.uint8)) == digest_of_blocks([hashlib.sha256(plane).digest()])
    True
    """
    values = np.atleast_1d(values)
    rows = block_shape(values.shape)[0]
    bands = (values[top : top + rows] for top in range(0, len(values), rows or 1))
    return digest_of_bands(bands, values.shape)


def digest_of_bands(bands: Iterable[npt.NDArray[Any]], shape: Sequence[int]) -> bytes:
    """Digest of an array of this shape that comes as rows of blocks, from its start on."""
    return digest_of_blocks(block_digest(byte_planes(block)) for band in bands for block in _blocks(band, shape))


def digest_of_blocks(blocks: Iterable[bytes]) -> bytes:
    """Digest of an array, of those of its blocks in row-major order."""
    return hashlib.sha256(b"".join(blocks)).digest()


def block_digest(planes: Iterable[npt.NDArray[np.uint8]]) -> bytes:
    """Digest of a block, of its byte planes."""
    return hashlib.sha256(b"".join(map(_plane_digest, planes))).digest()


def byte_planes(values: npt.NDArray[Any]) -> list[npt.NDArray[np.uint8]]:
    """The first bytes of all values of an array, little-endian, the second ones, and so on."""
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<")).reshape(-1)
    size = little.dtype.itemsize
    if size not in (1, 2, 4, 8):
        octets = little.view(np.uint8).reshape(-1, size)
        return [np.ascontiguousarray(octets[:, k]) for k in range(size)]
    # Shifts take a third of the time of bytes picked from memory.
    words = little.view(np.dtype(f"<u{size}"))
    return [(words >> words.dtype.type(8 * k) if k else words).astype(np.uint8) for k in range(size)]


def is_constant(plane: npt.NDArray[np.uint8]) -> bool:
    """Whether a plane contains one value alone."""
    return bool(plane[-1] == plane[0] and (plane == plane[0]).all())


def _blocks(band: npt.NDArray[Any], shape: Sequence[int]) -> Iterator[npt.NDArray[Any]]:
    if len(shape) == 1:
        yield band
        return
    columns = block_shape(shape)[1]
    for left in range(0, shape[1], columns or 1):
        yield band[:, left : left + columns]


def _plane_digest(plane: npt.NDArray[np.uint8]) -> bytes:
    if len(plane) and is_constant(plane):
        return _constant_digest(int(plane[0]), len(plane))
    return hashlib.sha256(plane.data).digest()


@lru_cache(maxsize=1024)
def _constant_digest(value: int, count: int) -> bytes:
    return hashlib.sha256(bytes([value]) * count).digest()
