"""One canonical SHA-256 over values of any depth: databases, kept bands and cache keys are all checked by it.

A value is fed as its kind, its size and its content, so that no two different values give the same bytes. The bytes do
not depend on the machine: numbers are little-endian, text is UTF-8, mappings are in the order of their keys.
"""

from __future__ import annotations

import dataclasses
import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from hashlib import _Hash


def digest_of(*values: Any) -> str:
    """SHA-256 over values, as 64 hexadecimal digits; see `feed` for what a value may be."""
    digest = hashlib.sha256()
    feed(digest, values)
    return digest.hexdigest()


def feed(digest: _Hash, value: Any) -> None:
    """Add a value to a hash.

    Parameters
    ----------
    digest : hash object
    value : None, bool, int, float, str, bytes, array, dict, list, tuple or dataclass, of any depth

    Raises
    ------
    TypeError
        The value, or one inside it, is of another kind.
    """
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.kind == "O":
            feed(digest, [list(np.shape(value)), *np.ravel(value).tolist()])
            return
        array = np.ascontiguousarray(value).astype(value.dtype.newbyteorder("<"), copy=False)
        digest.update(f"array {array.dtype.str} {np.shape(value)} ".encode())
        digest.update(array.tobytes())
    elif isinstance(value, str | bytes):
        content = value.encode() if isinstance(value, str) else value
        digest.update(f"{type(value).__name__} {len(content)} ".encode() + content)
    elif value is None or isinstance(value, bool | int | float):
        digest.update(f"{type(value).__name__} {value!r} ".encode())
    elif isinstance(value, dict):
        digest.update(f"dict {len(value)} ".encode())
        for key in sorted(value):
            feed(digest, key)
            feed(digest, value[key])
    elif isinstance(value, list | tuple):
        digest.update(f"sequence {len(value)} ".encode())
        for item in value:
            feed(digest, item)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        digest.update(f"{type(value).__name__} ".encode())
        feed(digest, {field.name: getattr(value, field.name) for field in dataclasses.fields(value)})
    else:
        raise TypeError(f"no digest is defined for a {type(value).__name__}")
