"""Chunks packed as the filters of HDF5 pack them (shuffle, deflate, Fletcher-32), and faster, for large arrays.

HDF5 deflates a shuffled chunk as one run of bytes. Its planes (the first bytes of all values, the second ones, ...) are
unlike: those that contain one value alone, as the last bytes of rounded floats and the high bytes of codes do, need no
search, and each array has a strategy of zlib that suits its others. The planes become parts of one deflate stream that
end on whole bytes (RFC 1951, 3.2.4), in the wrapping of RFC 1950, so that every reader of HDF5 reads them.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import prod
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from skyshine.schemas.array_digest import block_digest, block_shape, byte_planes, digest_of_blocks, is_constant

_ADLER = 65521  # RFC 1950: the largest prime below 2^16
_HEADER, _END = b"\x78\x9c", b"\x03\x00"  # start of a zlib stream with the usual window; an empty last block
_WORD = 65535  # Fletcher's modulus


@dataclass(frozen=True)
class Packing:
    """How planes of an array are deflated.

    Attributes
    ----------
    level : int
        Level of zlib, 1 to 9.
    strategy : int
        Strategy of zlib: `zlib.Z_RLE` for values in runs, `zlib.Z_DEFAULT_STRATEGY` for repeated patterns.
    """

    level: int
    strategy: int = zlib.Z_DEFAULT_STRATEGY


class ChunkWriter:
    """Writes whole chunks of one array, each once.

    Examples
    --------
    >>> with h5py.File("codes", "w", driver="core", backing_store=False) as file:
    ...     filters = {"chunks": (2, 2), "shuffle": True, "compression": "gzip", "fletcher32": True}
    ...     codes = file.create_dataset("code", (3, 2), "u2", **filters)
    ...     ChunkWriter(codes, Packing(1, zlib.Z_RLE)).write((0, 0), np.array([[1, 2], [3, 4], [5, 6]]))
    ...     codes[2].tolist()
    [5, 6]
    """

    def __init__(self, dataset: h5py.Dataset, packing: Packing) -> None:
        """`dataset` has the filters shuffle, deflate and Fletcher-32 in this order, or is not chunked."""
        self._dataset, self._packing = dataset, packing
        # h5py asks the file for each of these whenever they are read.
        self._shape, self._dtype, self._chunks = dataset.shape, dataset.dtype, dataset.chunks
        self._last: tuple[bytes, tuple[int, ...]] = b"", ()
        self._made = b"", b""  # stored bytes and digest of the last chunk
        self._blocks: dict[tuple[int, ...], bytes] = {}

    def write(self, start: Sequence[int], values: npt.NDArray[Any]) -> None:
        """Write values from the indices `start` on, which begin chunks; they end with chunks or with the array."""
        dataset = self._dataset
        if self._chunks is None:
            dataset[tuple(slice(at, at + length) for at, length in zip(start, values.shape, strict=True))] = values
            return
        values = values.astype(self._dtype, copy=False)
        counts = [-(-length // size) for length, size in zip(values.shape, self._chunks, strict=True)]
        for index in np.ndindex(*counts):
            low = [i * size for i, size in zip(index, self._chunks, strict=True)]
            part = values[tuple(slice(at, at + size) for at, size in zip(low, self._chunks, strict=True))]
            corner = tuple(at + offset for at, offset in zip(start, low, strict=True))
            stored, self._blocks[corner] = self._packed(part)
            dataset.id.write_direct_chunk(corner, stored)

    def digest(self) -> bytes | None:
        """Digest of the array; None where chunks are not the blocks of digests, or were not all written by this."""
        shape, chunks = self._shape, self._chunks
        if chunks != block_shape(shape):
            return None
        number = prod(-(-length // size) for length, size in zip(shape, chunks, strict=True))
        complete = len(self._blocks) == number
        return digest_of_blocks(self._blocks[offset] for offset in sorted(self._blocks)) if complete else None

    def _packed(self, values: npt.NDArray[Any]) -> tuple[bytes, bytes]:
        """What HDF5 stores for a chunk, and its digest; values at the borders of the array are fewer than a chunk's."""
        this = values.tobytes(), values.shape
        if this == self._last:  # a chunk like the one before, as of one material alone, is not packed again
            return self._made
        planes = byte_planes(np.frombuffer(this[0], values.dtype))
        digest = block_digest(planes)
        chunk = self._chunks
        if values.shape != chunk:  # HDF5 stores the chunks at the borders whole
            planes = byte_planes(np.pad(values, [(0, size - n) for n, size in zip(values.shape, chunk, strict=True)]))
        self._last, self._made = this, (packed(planes, self._packing), digest)
        return self._made


def packed(planes: Sequence[npt.NDArray[np.uint8]], packing: Packing) -> bytes:
    """The bytes that HDF5 stores for a chunk: shuffled, deflated, Fletcher-32.

    Parameters
    ----------
    planes : sequence of (n,) uint8
        Its byte planes; see `byte_planes`.

    Raises
    ------
    ValueError
        The chunk is empty.
    """
    if not planes or not len(planes[0]):
        raise ValueError("found a chunk without values; allowed: one value or more")
    parts, low, high = [_HEADER], 1, 0  # Adler-32 is high * 2^16 + low
    for plane in planes:
        number, value = len(plane), int(plane[0])
        if is_constant(plane):
            parts.append(_constant(value, number))
            # Both sums of the same byte n times follow in closed form.
            high = (high + number * low + value * (number * (number + 1) // 2)) % _ADLER
            low = (low + number * value) % _ADLER
            continue
        parts.append(_deflated(plane.data, packing))
        both = zlib.adler32(plane.data, high << 16 | low)
        low, high = both & 0xFFFF, both >> 16
    stream = b"".join([*parts, _END, (high << 16 | low).to_bytes(4, "big")])
    return stream + fletcher32(stream).to_bytes(4, "little")


def _deflated(plane: memoryview | bytes, packing: Packing) -> bytes:
    """Deflate blocks of a plane, none of them the last, that end on a whole byte."""
    deflate = zlib.compressobj(packing.level, zlib.DEFLATED, -15, 9, packing.strategy)
    return deflate.compress(plane) + deflate.flush(zlib.Z_FULL_FLUSH)


@lru_cache(maxsize=256)
def _constant(value: int, number: int) -> bytes:
    return _deflated(bytes([value]) * number, Packing(9))


def fletcher32(data: bytes) -> int:
    """Fletcher's checksum (1982, IEEE Trans. Commun. 30:247-252) as HDF5 computes it, of 16 bit words, high byte first.

    Sums are kept in ones' complement: a multiple of 65535 is 65535, and 0 only where all words are.
    """
    words = np.frombuffer(data + b"\0" if len(data) % 2 else data, ">u2").astype(np.uint64)
    low_sum = int(words.sum())
    high_sum = int(words @ np.arange(len(words), 0, -1, dtype=np.uint64))
    low_sum, high_sum = ((total - 1) % _WORD + 1 if total else 0 for total in (low_sum, high_sum))
    return high_sum << 16 | low_sum
