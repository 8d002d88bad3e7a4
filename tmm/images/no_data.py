"""Where an image says that it has no data: GDAL's no-data value, masks in a TIFF and beside an image (``.msk``)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.gdal import open_dataset, quiet
from skyshine.tmm.images.georeference import is_tiff
from skyshine.tmm.images.raster import Raster

SIDECAR = ".msk"  # added to the whole name of the image
COLLAR = 12  # levels of 8 bit about the no-data value that JPEG leaves of it: half of its steps at quality 75
PIECE_TEXELS = 1 << 21  # looked at at a time


class NoData:
    """What an image file says of texels without data besides alpha; alike for all channels.

    A texel has none where a mask is 0, where all its colours are the no-data value, or, of a lossy file, where they
    are near that value all the way to a border of the image.

    value : float or None; the no-data value.
    lossy : bool; whether values near it count on the collar of the image.
    masked : bool; whether the file or one beside it has a mask.
    """

    def __init__(self, path: Path, image: Raster) -> None:
        """Look for what there is.

        Raises InputError: a mask cannot be read, or has another size than the image.
        """
        self.value: float | None = None
        self.lossy = False
        self._dataset: Any = None
        if is_tiff(path):
            self._look(path, str(image.kind))
        sidecar = path.with_name(path.name + SIDECAR)
        self._mask = Raster(sidecar) if sidecar.is_file() else None
        if self._mask is not None and (self._mask.height, self._mask.width) != (image.height, image.width):
            raise InputError(
                f"has a mask of {self._mask.width} x {self._mask.height}; allowed: the image's {image.width} x "
                f"{image.height}",
                file=sidecar,
            )
        self.masked = self._mask is not None or self._dataset is not None
        self._edges: tuple[npt.NDArray[Any], ...] | None = None

    def _look(self, path: Path, kind: str) -> None:
        from rasterio.enums import MaskFlags

        dataset = open_dataset(path)
        if dataset is None:
            return
        with quiet():
            value, flags = dataset.nodata, dataset.mask_flag_enums[0]
            self.lossy = value is not None and "jpeg" in str(dataset.profile.get("compress", "")).lower()
            if MaskFlags.per_dataset in flags and MaskFlags.alpha not in flags:
                self._dataset = dataset
        if value is not None and not math.isnan(value):
            self.value = _as_read(value, kind)

    def reasons(
        self, rows: slice, columns: slice, colours: npt.NDArray[Any]
    ) -> Iterator[tuple[str, npt.NDArray[np.bool_]]]:
        """Why texels (h, w) of a window of these colours (h, w, C) have no data, one reason after the other."""
        if self._mask is not None:
            yield "mask", self._mask.rows(rows.start, rows.stop)[:, columns, 0] == 0
        if self._dataset is not None:
            with quiet():
                inside = self._dataset.read_masks(1, window=((rows.start, rows.stop), (columns.start, columns.stop)))
            yield "mask", inside == 0
        if self.value is not None:
            yield "no-data value", self._same(colours)
        if self._edges is not None:
            top, bottom, left, right = self._edges
            row, column = np.arange(rows.start, rows.stop)[:, np.newaxis], np.arange(columns.start, columns.stop)
            outside = (column < left[rows, np.newaxis]) | (column > right[rows, np.newaxis])
            outside |= (row < top[columns]) | (row > bottom[columns])
            yield "collar", outside & self._near(colours)

    def find_collar(self, windows: Iterator[tuple[slice, npt.NDArray[Any]]], height: int, width: int) -> None:
        """Find how far values near no data reach into a lossy image from its borders.

        windows : iterator of (slice, (h, w, C) array); rows and colours of bands of the image, from its top.
        """
        top, bottom = np.full(width, height), np.full(width, -1)
        left, right = np.full(height, width), np.full(height, -1)
        for rows, colours in windows:
            inside = ~self._near(colours)
            nonempty = inside.any(axis=0)
            low, high = inside.argmax(axis=0), len(inside) - 1 - inside[::-1].argmax(axis=0)
            top[nonempty] = np.minimum(top[nonempty], rows.start + low[nonempty])
            bottom[nonempty] = rows.start + high[nonempty]
            row_nonempty = inside.any(axis=1)
            left[rows] = np.where(row_nonempty, inside.argmax(axis=1), width)
            right[rows] = np.where(row_nonempty, width - 1 - inside[:, ::-1].argmax(axis=1), -1)
        self._edges = top, bottom, left, right

    def _same(self, colours: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        equal: npt.NDArray[np.bool_] = colours == self.value
        if colours.dtype.kind == "f":
            equal = np.isclose(colours.astype(np.float64), float(self.value or 0), rtol=1e-6, atol=0)
        all_bands: npt.NDArray[np.bool_] = np.logical_and.reduce(equal, axis=-1)
        return all_bands

    def _near(self, colours: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        apart = np.abs(colours.astype(np.float64) - float(self.value or 0))
        near: npt.NDArray[np.bool_] = np.logical_and.reduce(apart <= COLLAR, axis=-1)
        return near


def _as_read(value: float, kind: str) -> float:
    """A stored number as `Raster` gives it: integers of other than 8 and 16 bit are scaled to their full range."""
    if kind in ("int8", "int16", "uint32", "int32"):
        return value / np.iinfo(kind).max
    return value
