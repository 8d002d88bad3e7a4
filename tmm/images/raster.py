"""Image files read by rows through OpenImageIO, so that an image larger than memory can be worked through."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError

KEPT_BYTES = 1 << 27  # decoded size up to which an image is kept whole: 4096 x 4096 texels of RGB come below it
PIECE_ROWS = 64  # decoded at a time of an image that is not kept whole
PIECE_TEXELS = 1 << 21  # of a row of tiles decoded at a time


class Raster:
    """An image file whose rows are read when they are asked for.

    Rows that follow one another are read once: those of the last request are kept. An image of up to `KEPT_BYTES` is
    kept whole. Formats that decode only as a whole (progressive JPEG, JPEG 2000, DDS) take their size in memory.

    Attributes
    ----------
    path : Path
    spec : OpenImageIO.ImageSpec
    height, width, channels : int
    dtype : numpy.dtype
        uint8 and uint16 as stored; any other integer is scaled to its full range, any other float is float32.
    """

    def __init__(self, path: Path, number: int = 0) -> None:
        """Open an image of the file, by default its first.

        Raises
        ------
        InputError
            The file is missing, is no image, or holds more than one plane, or has no such image.
        """
        self.path = path
        self._source, self.spec = _open(path, number)
        self.height, self.width, self.channels = self.spec.height, self.spec.width, self.spec.nchannels
        kind = str(self.spec.format)
        self._kind = kind if kind in ("uint8", "uint16") else "float"
        self.dtype = np.dtype({"float": "float32"}.get(self._kind, self._kind))
        self._whole = self.height * self.width * self.channels * self.dtype.itemsize <= KEPT_BYTES
        self._first, self._end, self._kept = 0, 0, np.empty((0, self.width, self.channels), self.dtype)

    def rows(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Rows `start` to `stop` (excluded) as (stop - start, width, channels); valid until the next call.

        Raises
        ------
        InputError
            The file is damaged or cut short.
        """
        if not self._first <= start <= stop <= self._end:
            if self._whole:
                self._first, self._end, self._kept = 0, self.height, self._read(0, self.height)
            else:
                first, last = self._aligned(start, stop)
                # What is kept already serves from the row asked for: tiles are wanted whole only where they are
                # decoded.
                self._keep(start if self._first <= start < self._end else first, last)
        return self._kept[start - self._first : stop - self._first]

    def _keep(self, first: int, last: int) -> None:
        """Read rows `first` to `last`, but for those that are kept already: they move to the front of the buffer."""
        overlap = self._end - first if self._first <= first < self._end else 0
        kept = self._kept[first - self._first : self._end - self._first] if overlap else self._kept[:0]
        if last - first > len(self._kept):
            self._kept = np.empty((last - first, self.width, self.channels), self.dtype)
        self._kept[:overlap] = kept
        self._first, self._end = first, first + overlap
        while self._end < last:
            # In pieces, because what is read is an array of its own until it is copied.
            stop = min(self._aligned(self._end, self._end + PIECE_ROWS)[1], last)
            target = self._kept[self._end - first : stop - first]
            step = self.width
            if side := self.spec.tile_width:
                step = max(PIECE_TEXELS // (stop - self._end) // side, 1) * side
            for left in range(0, self.width, step):
                right = min(left + step, self.width)
                target[:, left:right] = self._read(self._end, stop, left, right)
            self._end = stop

    def _aligned(self, start: int, stop: int) -> tuple[int, int]:
        """The rows of whole tiles that hold these rows."""
        side = self.spec.tile_height or 1
        return start // side * side, min(-(-stop // side) * side, self.height)

    def _read(self, start: int, stop: int, left: int = 0, right: int | None = None) -> npt.NDArray[Any]:
        """Decode rows; of tiled images, columns from `left` to `right` of them."""
        spec, source = self.spec, self._source
        right = self.width if right is None else right
        with _decoders_silent():
            if (start, stop, left, right) == (0, self.height, 0, self.width):
                values = source.read_image(self._kind)
            elif spec.tile_width:
                columns = (spec.x + left, spec.x + right)
                rows = (spec.y + start, spec.y + stop)
                values = source.read_tiles(*columns, *rows, 0, 1, 0, spec.nchannels, self._kind)
            else:
                values = source.read_scanlines(spec.y + start, spec.y + stop, 0, 0, spec.nchannels, self._kind)
        # A JPEG that ends early still returns texels, with only the error text to tell.
        problem = source.geterror()
        if values is None or problem:
            raise InputError(_reason("is damaged or cut short", problem), file=self.path)
        texels: npt.NDArray[Any] = values.reshape(stop - start, right - left, self.channels)
        return texels


def read_channels(path: Path) -> npt.NDArray[Any]:
    """All channels (H, W, C) of an image; see `Raster` for their types and for what is raised."""
    raster = Raster(path)
    return raster.rows(0, raster.height)


def file_sha256(path: Path) -> str:
    """SHA-256 of a file's bytes.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    if path.exists() and not path.is_file():
        raise InputError("is no file that can be read; check the path", file=path)
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None


def _open(path: Path, number: int) -> tuple[Any, Any]:
    import OpenImageIO as oiio

    if not path.is_file():
        raise InputError("does not exist or is not a file; check the image's path", file=path)
    config = oiio.ImageSpec()
    config["oiio:UnassociatedAlpha"] = 1  # else colours come multiplied by alpha, and change with it
    with _decoders_silent():
        source = oiio.ImageInput.open(str(path), config)
    if source is None:
        raise InputError(_reason("is not an image that can be read", oiio.geterror()), file=path)
    if number and not source.seek_subimage(number, 0):
        raise InputError(_reason(f"has no image {number}", source.geterror()), file=path)
    spec = source.spec()
    if spec.depth > 1 or spec.width < 1 or spec.height < 1:
        raise InputError(f"has the size {spec.width} x {spec.height} x {spec.depth}; allowed: one plane", file=path)
    return source, spec


@contextmanager
def _decoders_silent() -> Iterator[None]:
    """Keep what libpng and libtiff write to standard error by themselves: their reason stands in the error raised."""
    try:
        saved = os.dup(2)
    except OSError:  # no standard error, as in a service
        yield
        return
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)


def _reason(message: str, detail: str) -> str:
    first = detail.strip().splitlines()[0] if detail.strip() else "no reason given"
    return f"{message} ({first.rstrip('.')}); allowed: PNG, JPEG, TIFF and what else OpenImageIO reads; save it again"
