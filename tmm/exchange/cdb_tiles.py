"""A texture with a place on the ground, cut into the tiles of a CDB at all levels of detail.

At the level whose texels are about as small as the texture's, each texel has the material in its middle; a coarser tile
has the means of the four below it, so that whatever a finer tile contains is in all that are coarser, down to the one
texel of level -10.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.schemas.progress import Progress, silent
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Level, pure_level, ranked, shares_of
from skyshine.tmm.database.reader import TmmFile, open_tmm
from skyshine.tmm.exchange.cdb import from_image, read_cdb, to_image, write_cdb
from skyshine.tmm.exchange.cdb_grid import Geocell, Ground
from skyshine.tmm.exchange.cdb_materials import CdbMaterials
from skyshine.tmm.exchange.cdb_places import INDEX, MAX_LOD, MIN_LOD, Tile
from skyshine.tmm.exchange.image import MaterialImage

MOST_TILES = 1 << 14  # largest number of tiles of the finest level: some 20 GB
_UNIT = 1 << 20  # unit of a share, which is ranked and rounded as an integer


@dataclass(frozen=True)
class _Patch:
    """Shares of the materials in a part of a tile, of the whole texel: what has no material has none.

    top, left : int; first row and column.
    codes : (K,) uint16; ascending.
    share : (K, h, w) float32
    """

    top: int
    left: int
    codes: npt.NDArray[np.uint16]
    share: npt.NDArray[np.float32]

    @property
    def size(self) -> tuple[int, int]:
        return self.share.shape[1], self.share.shape[2]


def cut_tiles(
    path: Path,
    root: Path,
    materials: CdbMaterials,
    finest: int | None = None,
    progress: Progress = silent,
) -> list[Path]:
    """Write the tiles of a texture database, datasets 005 and 006, into the CDB at `root`.

    Texels that it has no material for stay as an earlier texture wrote them, such as the next sheet of a mosaic.
    Raises InputError: the texture has no place on a map, or one that is not known; it would make more than `MOST_TILES`
    tiles, or has no material; or a tile that is there contains what is no material of the library.

    finest : int, optional
        The finest level of detail, -10 to 23; by default the one whose texels are nearest in size to the texture's.
    """
    with open_tmm(path) as file:
        ground = Ground(file, path)
        lod = ground.finest if finest is None else finest
        if not MIN_LOD <= lod <= MAX_LOD:
            raise InputError(f"found the level of detail {lod}; allowed: {MIN_LOD} to {MAX_LOD}")
        sampled = max(lod, ground.finest)
        if (count := ground.tile_count(sampled)) > MOST_TILES:
            raise InputError(
                f"would make {count} tiles of level {sampled}; allowed: {MOST_TILES}; divide the image, or name a"
                " coarser level with --lod",
                file=path,
            )
        if not file.group_attributes("usage")["texels_with_material"]:
            raise InputError("has no texel with a material; there is nothing to write", file=path)
        with progress(count, "cutting tiles") as advance:
            cutter = _Cutter(file, ground, root, materials, lod, sampled, advance)
            for cell in ground.geocells():
                cutter.cut(cell, cell.tile(MIN_LOD, 0, 0))
    if not cutter.written:
        raise InputError(
            f"has no material in the middle of a texel of level {sampled}; name a finer one with --lod", file=path
        )
    return cutter.written


class _Cutter:
    def __init__(
        self,
        file: TmmFile,
        ground: Ground,
        root: Path,
        materials: CdbMaterials,
        finest: int,
        sampled: int,
        advance: Callable[[float], None],
    ) -> None:
        """`finest` is the level from which tiles are written, `sampled` the one that the texture is read at."""
        self._file, self._ground, self._root, self._materials = file, ground, root, materials
        self._finest, self._sampled_lod, self._advance = finest, sampled, advance
        self.written: list[Path] = []

    def cut(self, cell: Geocell, tile: Tile) -> _Patch | None:
        """Write a tile after those of finer levels; returns its shares, None where it has none."""
        if not self._ground.touches(cell, tile):
            return None
        if tile.lod == self._sampled_lod:
            patch = self._sampled(cell, tile)
            self._advance(1)
        else:
            halves = (0, 1) if tile.lod >= 0 else (0,)
            below = [
                _halved(part, tile.side // 2 * (1 - up) if len(halves) > 1 else 0, tile.side // 2 * right)
                for up in halves
                for right in halves
                if (part := self.cut(cell, _finer(tile, up, right))) is not None
            ]
            patch = _joined(below)
        if patch is not None and tile.lod <= self._finest:
            self._write(tile, patch)
        return patch

    def _sampled(self, cell: Geocell, tile: Tile) -> _Patch | None:
        """Shares in the middles of the texels of a tile."""
        codes = np.array(list(self._file.materials), np.uint16)
        share = np.zeros((len(codes), tile.side, tile.side), np.float32)
        height, width = self._file.height, self._file.width
        for top, x, y in self._ground.pixels(cell, tile):
            column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
            inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
            if not inside.any():
                continue
            rows = slice(int(row[inside].min()), int(row[inside].max()) + 1)
            columns = slice(int(column[inside].min()), int(column[inside].max()) + 1)
            window = self._file.window(0, rows, columns)
            at = np.where(inside, row - rows.start, 0), np.where(inside, column - columns.start, 0)
            for k in np.flatnonzero(np.isin(codes, window.mix_code)):
                sampled = shares_of(window, codes[k])[at] / np.float32(WEIGHT_TOTAL)
                share[k, top : top + len(sampled)] = np.where(inside, sampled, 0)
        return _cropped(_Patch(0, 0, codes, share))

    def _write(self, tile: Tile, patch: _Patch) -> None:
        # Shares of what is known: a texel that lies across the border of the texture is its materials'.
        total = patch.share.sum(axis=0)
        counts = np.rint(patch.share * (_UNIT / np.where(total > 0, total, 1))).astype(np.int64)
        part, level = ranked(patch.codes, counts), pure_level(np.zeros((tile.side, tile.side), np.uint16))
        inside = slice(patch.top, patch.top + patch.size[0]), slice(patch.left, patch.left + patch.size[1])
        for target, source in zip(vars(level).values(), vars(part).values(), strict=True):
            target[inside] = source
        names = self._file.materials
        index_file = tile.raster(self._root, INDEX, 1)
        if index_file.is_file():
            names, level = self._over(index_file, level)
        self.written += write_cdb(self._root, from_image(MaterialImage(tile.name, names, level), tile, self._materials))

    def _over(self, index_file: Path, level: Level) -> tuple[dict[int, str], Level]:
        """A level laid over what an earlier texture wrote of the tile, and the names of all materials."""
        earlier = read_cdb(index_file)
        for composite in earlier.table.values():
            if composite.name not in self._materials.library:
                raise InputError(
                    f"contains '{composite.name}', which is no material of the library, and would be lost; name another"
                    " folder with --out",
                    file=index_file,
                )
        below = to_image(earlier, self._materials)
        empty = level.code == 0
        for plane, earlier_plane in zip(vars(level).values(), vars(below.level).values(), strict=True):
            plane[empty] = earlier_plane[empty]
        return dict(sorted({**below.materials, **self._file.materials}.items())), level


def _finer(tile: Tile, up: int, right: int) -> Tile:
    """One of the tiles of the next level that lie in a tile: below level 0 the only one."""
    if tile.lod < 0:
        return Tile(tile.cell, tile.lod + 1, 0, 0)
    return Tile(tile.cell, tile.lod + 1, 2 * tile.up + up, 2 * tile.right + right)


def _cropped(patch: _Patch) -> _Patch | None:
    """The part of a patch that has materials, and the materials that it has."""
    covered = np.asarray((patch.share > 0).any(axis=0))
    if not covered.any():
        return None
    rows, columns = np.flatnonzero(covered.any(axis=1)), np.flatnonzero(covered.any(axis=0))
    present = patch.share.any(axis=(1, 2))
    part = patch.share[present, rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return _Patch(patch.top + int(rows[0]), patch.left + int(columns[0]), patch.codes[present], part.copy())


def _halved(patch: _Patch, top: int, left: int) -> _Patch:
    """Means over two by two texels, as a part of the coarser tile that begins at `top` and `left`."""
    before = patch.top % 2, patch.left % 2
    after = (patch.size[0] + before[0]) % 2, (patch.size[1] + before[1]) % 2
    even = np.pad(patch.share, ((0, 0), (before[0], after[0]), (before[1], after[1])))
    means = even.reshape(len(even), even.shape[1] // 2, 2, even.shape[2] // 2, 2).mean(axis=(2, 4), dtype=np.float32)
    return _Patch(top + patch.top // 2, left + patch.left // 2, patch.codes, means)


def _joined(patches: list[_Patch]) -> _Patch | None:
    """Patches of one tile, which do not overlap, as one."""
    if not patches:
        return None
    top, left = (min(getattr(patch, side) for patch in patches) for side in ("top", "left"))
    bottom = max(patch.top + patch.size[0] for patch in patches)
    right = max(patch.left + patch.size[1] for patch in patches)
    codes = np.unique(np.concatenate([patch.codes for patch in patches]))
    share: npt.NDArray[Any] = np.zeros((len(codes), bottom - top, right - left), np.float32)
    for patch in patches:
        rows = slice(patch.top - top, patch.top - top + patch.size[0])
        columns = slice(patch.left - left, patch.left - left + patch.size[1])
        share[np.searchsorted(codes, patch.codes), rows, columns] += patch.share
    return _Patch(top, left, codes, share)
