"""Colours that the keys of a palette name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from skyshine.schemas.errors import InputError


def palette_colour(key: str, dtype: np.dtype[Any], path: Path) -> tuple[int, int, int]:
    """The colour that a palette's key names, as a texture of this type stores it.

    Raises InputError: the texture's type cannot store it.
    """
    if dtype.kind != "u":
        raise InputError("contains floats; allowed for a palette: 8 or 16 bit colours; use rules instead", file=path)
    limit = np.iinfo(dtype).max
    if key.startswith("#"):
        # 8 bits spread over 16 as image formats do it: 255 becomes 65535.
        red, green, blue = (int(key[i : i + 2], 16) * (limit // 255) for i in (1, 3, 5))
        return red, green, blue
    if int(key) > limit:
        raise InputError(f"contains values to {limit}; the palette's grey level {key} is beyond", file=path)
    return int(key), int(key), int(key)
