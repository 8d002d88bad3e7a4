"""The texture material mapper: photographs in, material codes with their confidence out."""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "TextureJob": "job",
    "TmmJob": "job",
    "TextureMap": "build",
    "map_texture": "build",
    "write_texture": "database",
    "open_tmm": "reader",
    "read_usage": "usage",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    # Imported when asked for, so that `tmm --help` does not wait for image and HDF5 libraries.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
