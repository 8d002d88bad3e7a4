"""Materials that textures use, and their shares; `mat` reads these to omit the other materials."""

from __future__ import annotations

import os
from collections.abc import Iterable

from skyshine.tmm.database.reader import open_tmm


def read_usage(path: str | os.PathLike[str]) -> dict[str, float]:
    """Share of a texture's texels with data that have each of its materials.

    Raises InputError: the file is missing or damaged, or is no texture database.
    """
    return _read(path)[0]


def library_usage(paths: Iterable[str | os.PathLike[str]]) -> dict[str, float]:
    """Share of each material in all texels with data of several textures, largest first.

    Raises InputError: a file is missing or damaged, or is no texture database.
    """
    totals: dict[str, float] = {}
    texels = 0
    for path in paths:
        shares, weight = _read(path)
        texels += weight
        for name, share in shares.items():
            totals[name] = totals.get(name, 0.0) + share * weight
    return {name: total / texels for name, total in sorted(totals.items(), key=lambda item: (-item[1], item[0]))}


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, float], int]:
    with open_tmm(path) as file:
        return file.usage, int(file.group_attributes("usage")["texels_with_data"])
