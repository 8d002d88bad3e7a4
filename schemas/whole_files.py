"""Files that are written whole or not at all: a part file first, renamed when it is complete."""

from __future__ import annotations

import contextlib
import os
import platform
from pathlib import Path

from skyshine.schemas.errors import InputError

PART = ".skyshine-part"  # ends the names of files that are not yet whole; no file of a user ends so


def part_file(path: Path) -> Path:
    """Name under which this process writes a file until it is complete; unlike that of any other process or machine."""
    return path.with_name(f".{path.name}.{platform.node()}.{os.getpid()}{PART}")


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all; text in UTF-8.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    part = part_file(path)
    try:
        part.write_bytes(content.encode() if isinstance(content, str) else content)
        os.replace(part, path)
    except OSError as error:
        words = error.strerror or error
        raise InputError(f"cannot be written: {words}; check free space and permissions", file=path) from None
    finally:
        with contextlib.suppress(OSError):  # no folder, no part
            part.unlink(missing_ok=True)
