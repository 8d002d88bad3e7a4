"""Where an image says that it has no data: GDAL's no-data value, masks in a TIFF and beside an image (``.msk``)."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.georeference import TIFF_ERRORS, is_tiff
from skyshine.tmm.images.raster import Raster

_VALUE_TAG = 42113  # GDAL_NODATA: a number as text
_MASK = 4  # bit of NewSubfileType (TIFF 6.0): the image is a transparency mask of another one
SIDECAR = ".msk"  # added to the whole name of the image


class NoData:
    """What an image file says of texels without data besides alpha; alike for all channels.

    A texel has none where a mask is 0, or all its colours are the no-data value.
    """

    def __init__(self, path: Path, image: Raster) -> None:
        """Look for what there is.

        Raises
        ------
        InputError
            A mask cannot be read, or has another size than the image.
        """
        self._value, number = _tags(path) if is_tiff(path) else (None, None)
        self._masks = [Raster(path, number)] if number is not None else []
        sidecar = path.with_name(path.name + SIDECAR)
        if sidecar.is_file():
            self._masks.append(Raster(sidecar))
        for mask in self._masks:
            if (mask.height, mask.width) != (image.height, image.width):
                raise InputError(
                    f"has a mask of {mask.width} x {mask.height}; allowed: the image's {image.width} x {image.height}",
                    file=mask.path,
                )
        if self._value is not None:
            self._value = _as_read(self._value, str(image.spec.format))

    def valid(self, rows: slice, columns: slice, colours: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        """Whether the texels of a window of these colours (h, w, C) have data, (h, w); raises as `Raster.rows`."""
        valid = np.ones(colours.shape[:2], np.bool_)
        for mask in self._masks:
            valid &= mask.rows(rows.start, rows.stop)[:, columns, 0] != 0
        if self._value is not None:
            if colours.dtype.kind == "u":
                valid &= (colours != self._value).any(axis=-1)
            else:
                same = np.isclose(colours.astype(np.float64), self._value, rtol=1e-6, atol=0)
                valid &= ~same.all(axis=-1)
        return valid


def _tags(path: Path) -> tuple[float | None, int | None]:
    """The no-data value of a TIFF, and the number of the mask of its first image; None where there is none."""
    import tifffile

    try:
        with tifffile.TiffFile(path) as file:
            first = file.pages[0]
            tag = first.tags.get(_VALUE_TAG) if isinstance(first, tifffile.TiffPage) else None
            masks = [
                number
                for number, page in enumerate(file.pages)
                if isinstance(page, tifffile.TiffPage) and page.subfiletype == _MASK
            ]
            value = float(str(tag.value).strip("\0 ")) if tag is not None else math.nan
    except TIFF_ERRORS:
        return None, None  # as of a file whose tags tifffile does not read; texels that are not finite have no data
    return None if math.isnan(value) else value, masks[0] if masks else None


def _as_read(value: float, kind: str) -> float:
    """A stored number as `Raster` gives it: integers of other than 8 and 16 bit are scaled to their full range."""
    if kind in ("int8", "int16", "uint32", "int32"):
        return value / np.iinfo(kind).max
    return value
