"""Files of arrays that a machine keeps so as not to compute them again: believed if whole, and this user's own.

A file contains a line that says what it is, a digest over its key and its content, and arrays as numpy keeps several.
Any file that cannot be believed counts as absent. `SKYSHINE_CACHE` names another folder than the user's; leave it empty
to keep nothing.
"""

from __future__ import annotations

import io
import os
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.digest import digest_of

CACHE_VARIABLE = "SKYSHINE_CACHE"
FILE_LIMIT = 1 << 24  # bytes; a band of a thousand points takes 30 kB


def kept_folder(name: str) -> Path | None:
    """Folder of one kind of kept files; None if the environment says that nothing is kept."""
    named = os.environ.get(CACHE_VARIABLE)
    if named is not None:
        return Path(named) / name if named else None
    import platformdirs

    return Path(platformdirs.user_cache_dir("skyshine")) / name


def keep_arrays(path: Path, head: bytes, key: str, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
    """Keep arrays: a part file, renamed when it is whole. Where the folder cannot be written nothing is kept.

    Parameters
    ----------
    head : bytes
        First line of the file: what it is, with a version.
    key : str
        Digest of everything that the arrays depend on.
    arrays : mapping of str to array
        Without Python objects.
    """
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **arrays)
    part = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            part = Path(file.name)
            file.write(_with_digest(head, key, content.getvalue()))
        os.replace(part, path)
    except OSError:
        if part is not None:
            part.unlink(missing_ok=True)


def kept_arrays(path: Path, head: bytes, key: str) -> dict[str, npt.NDArray[Any]] | None:
    """The arrays of a file, or None where there is none that can be believed; arguments as `keep_arrays`."""
    try:
        stored = _own_bytes(path)
        content = stored[len(head) + 65 :]
        if stored != _with_digest(head, key, content):
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except Exception:  # whatever a damaged file leads to, it counts as absent
        return None


def _with_digest(head: bytes, key: str, content: bytes) -> bytes:
    """A kept file: what it is, the digest over key and content, the content."""
    return head + digest_of(key, content).encode() + b"\n" + content


def _own_bytes(path: Path) -> bytes:
    """Content of a file of this user; of none where it is another's, or no regular file, or too large."""
    # Without waiting: a pipe may be in place of the file.
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    descriptor = os.open(path, flags)
    with open(descriptor, "rb") as file:
        status = os.fstat(descriptor)
        foreign = hasattr(os, "geteuid") and status.st_uid != os.geteuid()
        if foreign or not stat.S_ISREG(status.st_mode) or status.st_size > FILE_LIMIT:
            return b""
        return file.read(FILE_LIMIT)
