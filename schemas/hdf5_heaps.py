"""A check of the heaps of HDF5 files: a damaged heap makes libhdf5 loop without end."""

from __future__ import annotations

import mmap
import os
import re
import struct

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath

# Global heaps contain the text of a file (HDF5 File Format Specification 3.0, III.E): signature, version 1, three zero
# bytes, size.
_COLLECTION = re.compile(rb"GCOL\x01\0\0\0")
_HEAD = 16  # bytes before the first object; and of the head of each object
_WORD = 1 << 64


def largest_text(path: StrPath) -> int:
    """Bytes of the largest object in the text heaps of a file, which no text in it exceeds.

    Raises
    ------
    InputError
        A heap contains an object without length, on which libhdf5 (2.0.0 and before) never gets to the next one.
    OSError
        The file cannot be read.
    """
    largest = 0
    with open(path, "rb") as file:
        if not os.fstat(file.fileno()).st_size:
            return 0
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            for match in _COLLECTION.finditer(content):
                size = _largest_object(content, match.start())
                if size is None:
                    raise InputError(
                        "is damaged (a text heap with an object without length); build it again", file=path
                    )
                largest = max(largest, size)
    return largest


def _largest_object(content: mmap.mmap, start: int) -> int | None:
    """Bytes of the largest object of a collection; None where the walk through its objects does not advance."""
    if start + _HEAD > len(content):
        return 0
    end = min(start + struct.unpack_from("<Q", content, start + 8)[0], len(content))
    position, largest = start + _HEAD, 0
    while position + _HEAD <= end:
        index, size = struct.unpack_from("<H6xQ", content, position)
        # An object is its head and its data in whole words of 8 bytes; free space, number 0, counts its own head.
        step = (size if index == 0 else _HEAD + (size + 7) // 8 * 8) % _WORD
        if step < _HEAD:
            return None
        largest = max(largest, size if index else 0)
        position += step
    return largest
