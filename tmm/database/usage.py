"""Which materials textures use, and how much of them: what `mat` reads to leave out the others."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.hdf5 import open_database, sound

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
    with open_database(path, "tmm", 1) as file, sound(path):
        codes, names = file["materials/material"][()], file["materials/name"].asstr()[()].tolist()
        mix_code, mix_weight = (file[f"levels/0/{name}"] for name in ("mix_code", "mix_weight"))
        height, width, _ = mix_code.shape
        share = np.zeros((-(-height // CHUNK), -(-width // CHUNK), len(codes)))
        for row, column in np.ndindex(share.shape[:2]):
            part = np.s_[row * CHUNK : (row + 1) * CHUNK, column * CHUNK : (column + 1) * CHUNK]
            code, weight = mix_code[part], mix_weight[part]
            total = np.bincount(code.ravel(), weight.ravel(), minlength=int(codes.max(initial=0)) + 1)
            share[row, column] = total[codes] / (code.shape[0] * code.shape[1] * float(mix_weight.attrs["total"]))
        return tuple(names), share


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, float], int]:
    with open_database(path, "tmm", 1) as file:
        names = file["materials/name"].asstr()[()].tolist()
        shares = file["usage/share"][()].astype(float).tolist()
        return dict(zip(names, shares, strict=True)), int(file["usage"].attrs["texels_with_data"])
