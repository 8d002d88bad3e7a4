"""Legends: which number of an exported raster is which material, as JSON beside it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from skyshine.materials.library import MaterialLibrary, unknown_material
from skyshine.schemas.errors import InputError
from skyshine.tmm.exchange.image import MaterialImage

BYTE_LIMIT = 10_000_000  # far beyond 65,536 entries


def legend(image: MaterialImage, first: int = 1) -> dict[int, dict[str, Any]]:
    """Code and name of each material by its number, counted from `first` in the order of the codes."""
    return {k: {"code": code, "name": name} for k, (code, name) in enumerate(image.materials.items(), first)}


def read_legend(path: str | os.PathLike[str], library: MaterialLibrary) -> dict[int, str]:
    """Material names by number, from a legend that `tmm export` or a user wrote.

    Names count: a code that another library gave is not looked at.

    Parameters
    ----------
    library : MaterialLibrary

    Raises
    ------
    InputError
        The file is missing or no such legend, or names a material that the library has not.
    """
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise InputError("is no file that can be read; check the path", file=path)
        if path.stat().st_size > BYTE_LIMIT:
            raise InputError(f"found {path.stat().st_size} bytes; allowed: at most {BYTE_LIMIT}", file=path)
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None
    except (ValueError, RecursionError) as error:
        line, column = getattr(error, "lineno", None), getattr(error, "colno", None)
        raise InputError("is not JSON; fix it here", file=path, line=line, column=column) from None
    entries = content.get("materials") if isinstance(content, dict) else None
    if not isinstance(entries, dict) or not entries:
        raise InputError("has no 'materials'; allowed: an object of numbers, each with a 'name'", file=path)
    return {_number(key, path): _name(key, entry, path, library) for key, entry in entries.items()}


def _number(key: str, path: Path) -> int:
    if not (key.isascii() and key.isdecimal() and len(key) <= 5 and int(key) <= 65535):
        raise InputError(f"materials: found the number '{key[:40]}'; allowed: 0 to 65535", file=path)
    return int(key)


def _name(key: str, entry: object, path: Path, library: MaterialLibrary) -> str:
    name = entry.get("name") if isinstance(entry, dict) else entry
    if not isinstance(name, str) or name not in library:
        raise InputError(f"materials.{key}: {unknown_material(name, library.names)}", file=path)
    return name
