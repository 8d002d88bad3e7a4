"""A check of the heaps of HDF5 files, in which libhdf5 turns for ever where they are damaged."""

from __future__ import annotations

import mmap
import os
import re
import struct

from skyshine.schemas.errors import InputError

# Global heaps hold the text of a file (HDF5 File Format Specification 3.0, III.E): signature, version 1, three zero
# bytes, size.
_COLLECTION = re.compile(rb"GCOL\x01\0\0\0")
_HEAD = 16  # bytes before the first object; and of the head of each object
_WORD = 1 << 64


def refuse_endless_heaps(path: str | os.PathLike) -> None:
    """Refuse a file with a heap object without length, on which libhdf5 (2.0.0 and before) never gets to the next one.

    Raises
    ------
    InputError
        Such an object is found.
    OSError
        The file cannot be read.
    """
    with open(path, "rb") as file:
        if not os.fstat(file.fileno()).st_size:
            return
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            for found in _COLLECTION.finditer(content):
                if _endless(content, found.start()):
                    raise InputError(
                        "is damaged (a text heap with an object without length); build it again", file=path
                    )


def _endless(content: mmap.mmap, start: int) -> bool:
    """Whether the walk through the objects of a collection stands still."""
    if start + _HEAD > len(content):
        return False
    end = min(start + struct.unpack_from("<Q", content, start + 8)[0], len(content))
    place = start + _HEAD
    while place + _HEAD <= end:
        index, size = struct.unpack_from("<H6xQ", content, place)
        # An object is its head and its data in whole words of 8 bytes; free space, number 0, counts its own head.
        step = (size if index == 0 else _HEAD + (size + 7) // 8 * 8) % _WORD
        if step < _HEAD:
            return True
        place += step
    return False
