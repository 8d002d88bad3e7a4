"""A texture, from whose texels materials are read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .axis import SceneError
from .database import PACKING, SMALL, number, text

TOTAL = 65535  # what the weights of a texel sum to
SHADE_TOTAL = 255  # of a texel that lies in the shade as a whole
COMPONENTS = 3
PLANES = ("code", "mix_code", "mix_weight")


@dataclass(frozen=True)
class Level:
    """One mip level: three codes and three weights a texel, and its share in the shade where the file has that."""

    codes: NDArray[np.uint16]
    weights: NDArray[np.uint16]
    shade: NDArray[np.uint8] | None


class Texture:
    """A .tmm file; each level is read and checked whole when the first pixel asks for it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.levels: dict[int, Level] = {}
        self._read(0)

    def mixture(self, across: float, down: float, level: int = 0) -> list[tuple[float, float]]:
        """Codes and shares of the materials at a point, in texels of level 0 from the top left corner of the image."""
        row, column = self._place(across, down, level)
        codes, weights = self.levels[level].codes, self.levels[level].weights
        if codes[row, column, 0] == 0:
            raise SceneError(f"texel: [{across:g}, {down:g}] has no material")
        pairs = zip(codes[row, column].tolist(), weights[row, column].tolist(), strict=True)
        return [(float(code), weight / TOTAL) for code, weight in pairs if weight]

    def shade(self, across: float, down: float, level: int = 0) -> float:
        """Share of the texel at that point in the shade of its photograph; 0 where the file has no such layer."""
        row, column = self._place(across, down, level)
        shade = self.levels[level].shade
        return 0.0 if shade is None else int(shade[row, column]) / SHADE_TOTAL

    def _place(self, across: float, down: float, level: int) -> tuple[int, int]:
        """Row and column in a level, which is read where it was not yet."""
        height, width = self.levels[0].codes.shape[:2]
        if not (0 <= across <= width and 0 <= down <= height):
            raise SceneError(f"texel: found [{across:g}, {down:g}]; allowed: 0 to {width}, 0 to {height}")
        if level not in self.levels:
            self._read(level)
        rows, columns = self.levels[level].codes.shape[:2]
        return min(int(down * rows / height), rows - 1), min(int(across * columns / width), columns - 1)

    def _read(self, level: int) -> None:
        try:
            if not self.path.is_file():
                raise OSError
            file = h5py.File(self.path, "r")
        except OSError:
            raise SceneError(f"{self.path}: is not a readable HDF5 file") from None
        with file:
            try:
                self.levels[level] = self._level(file, level)
            except (OSError, KeyError, RuntimeError, ValueError, TypeError, AttributeError) as error:
                words = " ".join(str(error).split())
                raise SceneError(f"{self.path}: is damaged ({words:.100})") from None

    def _level(self, file: h5py.File, level: int) -> Level:
        if text(file, "filetype") != "tmm" or not text(file, "format_version").startswith("1."):
            raise SceneError(f"{self.path}: holds {text(file, 'filetype')[:40]!r}; allowed: tmm 1.x")
        known = self._plane(file, "materials/material", 1, "u2")
        if known.size == 0 or known[0] < 1 or np.any(np.diff(known.astype(int)) <= 0):
            raise SceneError(f"{self.path}: the codes of its materials do not ascend from 1")
        code, codes, weights = (
            self._plane(file, f"levels/{level}/{name}", 3 if "_" in name else 2, "u2") for name in PLANES
        )
        if codes.shape != (*code.shape, COMPONENTS) or weights.shape != codes.shape:
            raise SceneError(f"{self.path}: the arrays of level {level} do not fit each other")
        if number(file[f"levels/{level}/mix_weight"], "total") != TOTAL:
            raise SceneError(f"{self.path}: the weights of level {level} do not state their total, {TOTAL}")
        if not np.all(np.isin(codes, np.append(known, 0))) or np.any(codes[..., 0] != code):
            raise SceneError(f"{self.path}: level {level} has codes that are not those of its materials")
        if np.any(weights.sum(axis=-1, dtype=np.int64) != TOTAL):
            raise SceneError(f"{self.path}: the weights of level {level} do not sum to {TOTAL}")
        if np.any((codes == 0) & (weights > 0) & (code != 0)[..., None]):
            raise SceneError(f"{self.path}: level {level} gives weight to no material")
        return Level(codes, weights, self._shade(file, level, code.shape))

    def _shade(self, file: h5py.File, level: int, shape: tuple[int, ...]) -> NDArray[np.uint8] | None:
        """The layer of shade, which a file has on all levels or on none."""
        if file.get("levels/0/shade", getlink=True) is None:
            return None
        shade = self._plane(file, f"levels/{level}/shade", 2, "u1")
        if shade.shape != shape:
            raise SceneError(f"{self.path}: the arrays of level {level} do not fit each other")
        if number(file[f"levels/{level}/shade"], "total") != SHADE_TOTAL:
            raise SceneError(f"{self.path}: the shade of level {level} does not state its total, {SHADE_TOTAL}")
        return shade

    def _plane(self, file: h5py.File, name: str, rank: int, kind: str) -> NDArray[Any]:
        """An array of this very file, of a type."""
        place: h5py.Group = file
        for part in name.split("/"):
            if part not in place and not isinstance(place.get(part, getlink=True), h5py.SoftLink):
                raise SceneError(f"{self.path}: lacks '{name}'")
            if not isinstance(place.get(part, getlink=True), h5py.HardLink):
                raise SceneError(f"{self.path}: '{name}' is a link to somewhere else")
            place = place[part]
            if not isinstance(place, h5py.Group | h5py.Dataset):
                raise SceneError(f"{self.path}: '{name}' is not an array")
        if not isinstance(place, h5py.Dataset) or place.is_virtual or place.external is not None:
            raise SceneError(f"{self.path}: '{name}' is not an array of this file")
        if place.dtype.newbyteorder("=") != np.dtype(kind):
            raise SceneError(f"{self.path}: '{name}' has values of another type")
        if place.shape is None or len(place.shape) != rank or place.size == 0:
            raise SceneError(f"{self.path}: '{name}' has the shape {place.shape}; allowed: {rank} axes, none empty")
        if math.prod(place.shape) * place.dtype.itemsize > PACKING * self.path.stat().st_size + SMALL:
            raise SceneError(f"{self.path}: '{name}' claims more bytes than the file can hold")
        return np.asarray(place[()])
