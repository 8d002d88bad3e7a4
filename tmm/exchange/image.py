"""A texture as all exchange formats take it: materials by code, at most three of them in a texel."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import Level
from skyshine.tmm.database.reader import open_tmm

MAX_TEXELS = (
    1 << 27
)  # texels of a level that is exchanged: it is held in memory whole, with up to 24 bytes a texel while it is written


def check_size(height: int, width: int, path: str | os.PathLike[str]) -> None:
    """Refuse a level too large to be exchanged, with an InputError."""
    if height * width > MAX_TEXELS:
        raise InputError(
            f"has {width} x {height} texels; allowed in an exchange: {MAX_TEXELS}; export a coarser level with --level,"
            " or divide the image",
            file=path,
        )


@dataclass(frozen=True)
class MaterialImage:
    """One level of a texture.

    name : str
    materials : dict of int to str; material names by code, codes ascending; every code of the level is among them.
    level : Level; code (H, W), mix_code and mix_weight (H, W, 3).
    """

    name: str
    materials: dict[int, str]
    level: Level

    @property
    def height(self) -> int:
        return int(self.level.code.shape[0])

    @property
    def width(self) -> int:
        return int(self.level.code.shape[1])

    @property
    def layers(self) -> int:
        """How many materials the most mixed texel has, one at least."""
        present = (self.level.mix_weight > 0).any(axis=(0, 1))
        return max(int(present.sum()), 1)

    def index(self, rank: int = 0, start: int = 0) -> npt.NDArray[Any]:
        """Materials (H, W) int64 counted in the order of their codes.

        rank : int; 0 for the material with the largest share, 1 and 2 for the next.
        start : int; number of the first material; ``first - 1`` represents no material.
        """
        codes = np.array(list(self.materials), np.int64)
        code = self.level.code if rank == 0 else self.level.mix_code[..., rank]
        return np.where(code > 0, np.searchsorted(codes, code) + start, start - 1)


def read_levels(path: str | os.PathLike[str], levels: range | list[int] | None = None) -> list[MaterialImage]:
    """Levels of a texture database.

    Raises InputError: the file is missing or damaged, is no texture database, or has no such level, or one of more than
    `MAX_TEXELS`.

    path : path; a ``.tmm.h5``.
    levels : sequence of int, optional; by default the first alone.
    """
    with open_tmm(path) as file:
        chosen = [0] if levels is None else list(levels)
        for k in chosen:
            if not 0 <= k < file.levels:
                raise InputError(f"found level {k}; allowed: 0 to {file.levels - 1}", file=path)
            check_size(*file.size(k), path)
        name = re.sub(r"\.tmm\.h5$", "", os.path.basename(path))
        planes = ("code", "mix_code", "mix_weight")
        return [
            MaterialImage(name, file.materials, Level(*(file.array(f"levels/{k}/{plane}") for plane in planes)))
            for k in chosen
        ]
