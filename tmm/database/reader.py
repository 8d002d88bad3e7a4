"""Reading texels from a ``.tmm.h5`` database."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import h5py
import numpy as np
import numpy.typing as npt
import yaml

from skyshine.mat.tables.dataset import dataset
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import open_database, sound
from skyshine.schemas.hdf5_gate import refuse_large
from skyshine.tmm.database.checks import check_parts, check_values
from skyshine.tmm.database.layout import CHUNK, FILETYPE, SHADE_TOTAL
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Level
from skyshine.tmm.images.raster import file_sha256
from skyshine.tmm.job.model import TextureJob, stored_job

if TYPE_CHECKING:
    import xarray


class TmmFile:
    """A texture database, open for reading; see `open_tmm`.

    Attributes
    ----------
    materials : dict of int to str
        Material names by code.
    width, height : int
        Size of level 0 [texel].
    levels : int
        Number of mip levels.
    """

    def __init__(self, file: h5py.File) -> None:
        self._file = file
        self._planes: dict[tuple[int, str], npt.NDArray[Any]] = {}
        with sound(file.filename):
            check_parts(file, file.filename)
            group = file["materials"]
            self.materials = dict(zip(group["material"][()].tolist(), group["name"].asstr()[()].tolist(), strict=True))
            self._known = np.zeros(1 << 16, np.bool_)
            self._known[[0, *self.materials]] = True
            self.levels = len(file["levels"])
            self.height, self.width = file["levels/0/code"].shape

    def size(self, level: int) -> tuple[int, int]:
        """Height and width of a level."""
        with sound(self._file.filename):
            height, width = self._file[f"levels/{level}/code"].shape
            return int(height), int(width)

    @property
    def attributes(self) -> dict[str, Any]:
        """Root attributes and provenance."""
        with sound(self._file.filename):
            return {**self._file.attrs, **self._file["provenance"].attrs}

    @property
    def job(self) -> TextureJob:
        """The job that the database was made from.

        Raises InputError: it is no job of a texture.
        """
        try:
            return stored_job(self.attributes["job"])
        except (ValueError, yaml.YAMLError):
            raise InputError("is damaged (its job cannot be read); build it again", file=self._file.filename) from None

    def group_attributes(self, name: str) -> dict[str, Any]:
        """Attributes of ``usage``, ``quality`` or another group."""
        with sound(self._file.filename):
            return {
                key: value.item() if hasattr(value, "item") else value for key, value in self._file[name].attrs.items()
            }

    def rows(self, name: str, rows: slice, step: int = 1) -> npt.NDArray[Any]:
        """Rows of an array of level 0, such as ``code``; every `step`-th row and column of them."""
        return self.array(f"levels/0/{name}", rows)[::step, ::step]

    def thinned(self, name: str, step: int) -> npt.NDArray[Any]:
        """Every `step`-th row and column of an array of level 0."""
        band = CHUNK * step
        return np.concatenate([self.rows(name, slice(top, top + band), step) for top in range(0, self.height, band)])

    def array(self, name: str, rows: slice = slice(None)) -> npt.NDArray[Any]:
        """Rows of an array by its path in the file, such as ``levels/0/confidence``; by default all of it."""
        with sound(self._file.filename):
            stored = self._file[name]
            count = len(range(*rows.indices(stored.shape[0])))
            refuse_large(self._file.filename, name, stored.dtype.itemsize * count * math.prod(stored.shape[1:]))
            values: npt.NDArray[Any] = stored[rows]
            check_values(self._file.filename, name, values, self._known)
            return values

    def window(self, level: int, rows: slice, columns: slice) -> Level:
        """Materials of a window of a level."""
        with sound(self._file.filename):
            parts = []
            for plane in ("code", "mix_code", "mix_weight"):
                name = f"levels/{level}/{plane}"
                parts.append(self._file[name][rows, columns])
                check_values(self._file.filename, name, parts[-1], self._known)
            return Level(*parts)

    def has(self, name: str) -> bool:
        """Whether the file contains an array of this path."""
        return name in self._file

    @property
    def usage(self) -> dict[str, float]:
        """Share of the texels with data that have each material."""
        return dict(zip(self.materials.values(), self.array("usage/share").astype(float).tolist(), strict=True))

    def code(
        self, x: npt.ArrayLike, y: npt.ArrayLike, level: int = 0, outside: Literal["error", "clamp"] = "error"
    ) -> npt.NDArray[Any]:
        """Material code at points.

        Raises InputError: there is no such level, or a point lies outside.

        Parameters
        ----------
        x, y : array_like; pixel coordinates of level 0, from the top left corner: the first texel spans 0 to 1.
        level : int
        outside : {"error", "clamp"}; what to do with points beyond the image.

        Returns
        -------
        uint16
            0 where there is no material.
        """
        return self._at("code", x, y, level, outside)

    def mixture(
        self, x: npt.ArrayLike, y: npt.ArrayLike, level: int = 0, outside: Literal["error", "clamp"] = "error"
    ) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Material codes (..., 3) uint16 and their shares (..., 3) float64 at points; parameters as for `code`."""
        weights = self._at("mix_weight", x, y, level, outside)
        return self._at("mix_code", x, y, level, outside), weights / WEIGHT_TOTAL

    def confidence(
        self, x: npt.ArrayLike, y: npt.ArrayLike, outside: Literal["error", "clamp"] = "error"
    ) -> npt.NDArray[Any]:
        """Confidence at points of level 0; parameters as for `code`."""
        return self._at("confidence", x, y, 0, outside)

    @property
    def has_shade(self) -> bool:
        """Whether the photograph's cast shade is a layer of the file."""
        return self.has("levels/0/shade")

    def shade(
        self, x: npt.ArrayLike, y: npt.ArrayLike, level: int = 0, outside: Literal["error", "clamp"] = "error"
    ) -> npt.NDArray[Any]:
        """Share (...) float64 in cast shade at points; parameters as for `code`. 0 where the file has no such layer."""
        if not self.has_shade:
            return 0.0 * self._at("code", x, y, level, outside)
        return self._at("shade", x, y, level, outside) / SHADE_TOTAL

    def to_xarray(self, level: int = 0) -> xarray.Dataset:
        """Codes, shares and what else a level contains, as an `xarray.Dataset` over rows and columns from the top left.

        Raises InputError: there is no such level, or xarray is not installed.

        level : int
        """
        if not 0 <= level < self.levels:
            raise InputError(f"found level {level}; allowed: 0 to {self.levels - 1}", file=self._file.filename)
        height, width = self.size(level)
        plane, ranked = ("row", "column"), ("row", "column", "rank")
        names = {"code": plane, "mix_code": ranked, "mix_weight": ranked, "confidence": plane, "shade": plane}
        arrays = {name: self.array(f"levels/{level}/{name}") for name in names if self.has(f"levels/{level}/{name}")}
        return dataset(
            {"row": ("1", np.arange(height)), "column": ("1", np.arange(width)), "rank": ("1", np.arange(3))},
            {name: (names[name], "1", values) for name, values in arrays.items()},
            {"material_codes": list(self.materials), "material_names": list(self.materials.values()), "level": level},
        )

    def _at(self, name: str, x: npt.ArrayLike, y: npt.ArrayLike, level: int, outside: str) -> npt.NDArray[Any]:
        if not 0 <= level < self.levels:
            raise InputError(f"found level {level}; allowed: 0 to {self.levels - 1}", file=self._file.filename)
        if (level, name) not in self._planes:
            self._planes[level, name] = self.array(f"levels/{level}/{name}")
        plane = self._planes[level, name]
        across, down = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        if outside == "clamp":
            across, down = np.clip(across, 0, self.width), np.clip(down, 0, self.height)
        inside = (across >= 0) & (across <= self.width) & (down >= 0) & (down <= self.height)
        if not inside.all():
            at = np.flatnonzero(~inside.ravel())[0]
            raise InputError(
                f"found the point ({across.flat[at]:g}, {down.flat[at]:g}); allowed: x from 0 to {self.width}, y from "
                f"0 to {self.height}; or ask for outside='clamp'",
                file=self._file.filename,
            )
        row = np.minimum((down * plane.shape[0] / self.height).astype(int), plane.shape[0] - 1)
        column = np.minimum((across * plane.shape[1] / self.width).astype(int), plane.shape[1] - 1)
        values: npt.NDArray[Any] = plane[row, column]
        return values

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> TmmFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def open_tmm(path: str | os.PathLike[str]) -> TmmFile:
    """Open a texture database.

    Raises InputError: the file is missing or damaged, is of another type, or has another major version of the format.
    """
    file = open_database(Path(path), FILETYPE)
    try:
        return TmmFile(file)
    except InputError:
        file.close()
        raise


def find_image(file: TmmFile, path: Path, image: str | os.PathLike[str] | None) -> Path:
    """The texture's own image: the one given, or one of its name beside the database, in the folder above, or here.

    Raises InputError: it is not found, or its bytes are not those that were classified.
    """
    recorded, digest = Path(str(file.attributes["texture"])), file.attributes["texture_sha256"]
    candidates = [Path(image)] if image else [path.parent / recorded.name, path.parent.parent / recorded, recorded]
    for candidate in candidates:
        if candidate.is_file():
            if file_sha256(candidate) == digest:
                return candidate
            raise InputError(
                "is not the image that was classified (its SHA-256 differs); name it with --image", file=candidate
            )
    searched = ", ".join(str(candidate) for candidate in candidates)
    raise InputError(f"the image of this texture is not at {searched}; name it with --image", file=path)
