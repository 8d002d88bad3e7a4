"""Materials that textures use, and their shares; `mat` reads these to omit the other materials."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.database.levels import WEIGHT_TOTAL
from skyshine.tmm.database.reader import open_tmm

CHUNK = 256  # texels a side


def read_usage(path: str | os.PathLike[str]) -> dict[str, float]:
    """Share of a texture's texels with data that have each of its materials.

    Raises
    ------
    InputError
        The file is missing or damaged, or is no texture database.
    """
    return _read(path)[0]


def library_usage(paths: Iterable[str | os.PathLike[str]]) -> dict[str, float]:
    """Share of each material in all texels with data of several textures, largest first.

    Raises
    ------
    InputError
        A file is missing or damaged, or is no texture database.
    """
    totals: dict[str, float] = {}
    texels = 0
    for path in paths:
        shares, weight = _read(path)
        texels += weight
        for name, share in shares.items():
            totals[name] = totals.get(name, 0.0) + share * weight
    return {name: total / texels for name, total in sorted(totals.items(), key=lambda item: (-item[1], item[0]))}


def chunk_usage(path: str | os.PathLike[str]) -> tuple[tuple[str, ...], npt.NDArray[Any]]:
    """Share of each material in the chunks of level 0, such as a runtime pages in.

    Returns
    -------
    names : tuple of str
        K materials.
    share : (rows, columns, K) float64
        Of all texels of a chunk of `CHUNK` texels a side, less at the right and lower edge; what is missing to 1 is
        unknown or without data.

    Raises
    ------
    InputError
        The file is missing or damaged, or is no texture database.
    """
    with open_tmm(path) as file:
        codes, names = np.array(list(file.materials)), tuple(file.materials.values())
        share = np.zeros((-(-file.height // CHUNK), -(-file.width // CHUNK), len(codes)))
        for row in range(len(share)):
            rows = slice(row * CHUNK, (row + 1) * CHUNK)
            mix_code, mix_weight = (file.rows(name, rows) for name in ("mix_code", "mix_weight"))
            for column in range(share.shape[1]):
                part = np.s_[:, column * CHUNK : (column + 1) * CHUNK]
                code, weight = mix_code[part], mix_weight[part]
                total = np.bincount(code.ravel(), weight.ravel(), minlength=int(codes.max()) + 1)
                share[row, column] = total[codes] / (code.shape[0] * code.shape[1] * float(WEIGHT_TOTAL))
        return names, share


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, float], int]:
    with open_tmm(path) as file:
        return file.usage, int(file.group_attributes("usage")["texels_with_data"])
