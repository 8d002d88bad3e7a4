"""A photograph whose cast shade is taken away as it is read."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.features.cast_shade import CastShade, Fall
from skyshine.tmm.features.light import linear_light, stored_light
from skyshine.tmm.images.texture import TextureFile

_TILE = 512  # texels of a side of a tile whose cast shade is found at once


class RelitTexture(TextureFile):
    """A texture whose shade is taken away as it is read."""

    def __init__(self, *arguments: Any, fall: Fall) -> None:
        """Open an image as `TextureFile` does, and find its shade by how shadows fall.

        Raises InputError: as `TextureFile` and `CastShade.of`, or the colours have no encoding that is known here.
        """
        super().__init__(*arguments)
        if self.encoding not in ("srgb", "linear"):
            raise InputError(
                f"has the colour space '{self.encoding}'; allowed with shade: srgb and linear; say colour_space",
                file=self.path,
            )
        self._drawn: list[tuple[float, Any]] = []
        self._tiles: dict[tuple[int, int], npt.NDArray[np.float32]] = {}
        self._base = _Plain(self)
        self.found = CastShade.of(self._base, self.path, fall)

    def draw(self, fraction: float, masks: Any) -> None:
        """Say how much of what polygons cover is in the shade.

        Parameters
        ----------
        fraction : float
            0 to 1.
        masks : callable
            Function of a window's top, left and shape (h, w) that returns the texels in shade.
        """
        self._drawn.append((fraction, masks))

    def plain(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours of a window as the file stores them, and validity."""
        return super().window(rows, columns)

    def shade(self, rows: slice, columns: slice) -> npt.NDArray[np.float32]:
        """Share (h, w) of the texels of a window in the shade."""
        return self._shaded(rows, columns)[1]

    def window(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours without shade, as in the file, and validity; see `Windowed`."""
        light, fraction, valid = self._shaded(rows, columns)
        return stored_light(self.found.relit(light, fraction), self.encoding, self.dtype), valid

    def _shaded(
        self, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        colours, valid = self.plain(rows, columns)
        light, fraction = linear_light(colours, self.encoding), self._cast(rows, columns)
        for share, masks in self._drawn:
            fraction[masks(rows.start, columns.start, fraction.shape) & valid] = share
        return light, fraction, valid

    def _cast(self, rows: slice, columns: slice) -> npt.NDArray[np.float32]:
        """Of tiles that are kept while a band of the texture is read: shadows reach far into their neighbours."""
        fraction = np.empty((rows.stop - rows.start, columns.stop - columns.start), np.float32)
        for row in range(rows.start // _TILE, -(-rows.stop // _TILE)):
            for column in range(columns.start // _TILE, -(-columns.stop // _TILE)):
                top, left = row * _TILE, column * _TILE
                tile = self._tile(row, column)
                down = slice(max(rows.start, top), min(rows.stop, top + _TILE))
                across = slice(max(columns.start, left), min(columns.stop, left + _TILE))
                part = tile[down.start - top : down.stop - top, across.start - left : across.stop - left]
                fraction[
                    down.start - rows.start : down.stop - rows.start,
                    across.start - columns.start : across.stop - columns.start,
                ] = part
        return fraction

    def _tile(self, row: int, column: int) -> npt.NDArray[np.float32]:
        if (row, column) not in self._tiles:
            while len(self._tiles) > self.width // _TILE + 1:
                self._tiles.pop(next(iter(self._tiles)))
            rows = slice(row * _TILE, min((row + 1) * _TILE, self.height))
            columns = slice(column * _TILE, min((column + 1) * _TILE, self.width))
            colours, valid, inner = self._wide(self.found.margin, rows, columns)
            self._tiles[row, column] = self.found.fraction(linear_light(colours, self.encoding), valid)[inner]
        return self._tiles[row, column]

    def _wide(
        self, margin: int, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.bool_], tuple[slice, slice]]:
        """Colours and validity of a window with a margin, and where the window is within."""
        top, left = max(rows.start - margin, 0), max(columns.start - margin, 0)
        wide = slice(top, min(rows.stop + margin, self.height)), slice(left, min(columns.stop + margin, self.width))
        colours, valid = self.plain(*wide)
        inner = slice(rows.start - top, rows.stop - top), slice(columns.start - left, columns.stop - left)
        return colours, valid, inner


class _Plain:
    """A relit texture as its file stores it."""

    def __init__(self, texture: RelitTexture) -> None:
        self.height, self.width, self.channels = texture.height, texture.width, texture.channels
        self.dtype, self.encoding, self.window = texture.dtype, texture.encoding, texture.plain
