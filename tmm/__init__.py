"""The texture material mapper: photographs in, material codes with their confidence out."""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "TextureJob": "job.model",
    "TmmJob": "job.model",
    "TextureMap": "mapping.texture_map",
    "map_texture": "mapping.texture_map",
    "write_texture": "mapping.write",
    "open_tmm": "database.reader",
    "read_usage": "database.usage",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    # Imported when asked for, so that `tmm --help` does not wait for image and HDF5 libraries.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
