"""Writing of exchange files: whole ones or none."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from skyshine.schemas.abandoned_parts import remove_abandoned
from skyshine.schemas.errors import InputError
from skyshine.schemas.whole_files import write_whole


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file whole, its folder with it: a part file first, renamed when it is complete.

    Raises InputError: the file cannot be written.
    """
    path = Path(path)
    remove_abandoned(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; check free space and permissions", file=path) from None
    write_whole(path, content)


def write_json(path: str | os.PathLike[str], content: dict[str, Any]) -> None:
    """Write JSON, indented, keys in the order given; raises as `write_bytes`."""
    write_bytes(path, (json.dumps(content, indent=2, ensure_ascii=False) + "\n").encode())
