"""Image files read by rows, so that an image larger than memory can be worked through.

OpenImageIO reads them; GDAL does where a TIFF is compressed in a way that OpenImageIO does not decode (ZSTD, LERC,
LZMA), has CIELAB colours, or is asked for the indices of its palette.
"""

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
from skyshine.tmm.images.gdal import open_dataset, quiet
from skyshine.tmm.images.georeference import is_tiff

KEPT_BYTES = 1 << 27  # decoded size up to which an image is kept whole: 4096 x 4096 texels of RGB come below it
PIECE_ROWS = 64  # decoded at a time of an image that is not kept whole
PIECE_TEXELS = 1 << 21  # piece texels of a row of tiles decoded at a time
FOREIGN = {  # beginnings of files that are images, but of a kind that is not read: what to do
    b"\xabKTX 20": "is a KTX 2 texture, which is not read; save its base level as PNG, by 'ktx extract --level 0'",
    b"\xabKTX 11": "is a KTX texture, which is not read; save its base level as PNG",
}


class Raster:
    """An image file whose rows are read when they are asked for.

    Rows that follow one another are read once: those of the last request are kept. An image of up to `KEPT_BYTES` is
    kept whole. Formats that decode only as a whole (progressive JPEG, JPEG 2000, DDS) take their size in memory.

    path : Path
    height, width, channels : int
    channel_names : list of str
    alpha : int or None; channel that the file says is alpha.
    colour_space : str; name of the encoding that the file states; empty where it states none.
    kind : str; type of the values in the file.
    dtype : numpy.dtype
        uint8 and uint16 as stored; any other integer is scaled to its full range, any other float is float32.
    """

    def __init__(self, path: Path, indices: bool = False) -> None:
        """Open the first image of the file; with `indices`, those of its palette in place of colours.

        Raises InputError: the file is missing, is no image, or contains more than one plane.
        """
        self.path, self._source = path, _open(path, indices)
        source = self._source
        self.height, self.width, self.channels = source.height, source.width, len(source.channel_names)
        self.channel_names, self.alpha, self.kind = source.channel_names, source.alpha, source.kind
        self.colour_space, self._tile = source.colour_space, source.tile
        self.dtype = np.dtype(self.kind if self.kind in ("uint8", "uint16") else "float32")
        self._whole = self.height * self.width * self.channels * self.dtype.itemsize <= KEPT_BYTES
        self._first, self._end, self._kept = 0, 0, np.empty((0, self.width, self.channels), self.dtype)

    def rows(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Rows `start` to `stop` (excluded) as (stop - start, width, channels); valid until the next call.

        Raises InputError: the file is damaged or cut short.
        """
        if not self._first <= start <= stop <= self._end:
            if self._whole:
                self._first, self._end, self._kept = 0, self.height, self._read(0, self.height)
            else:
                low, high = self._aligned(start, stop)
                # What is kept already serves from the row asked for: tiles are wanted whole only where they are
                # decoded.
                self._keep(start if self._first <= start < self._end else low, high)
        return self._kept[start - self._first : stop - self._first]

    def _keep(self, low: int, high: int) -> None:
        """Read rows `low` to `high`, but for those that are kept already: they move to the front of the buffer."""
        overlap = self._end - low if self._first <= low < self._end else 0
        buffered = self._kept[low - self._first : self._end - self._first] if overlap else self._kept[:0]
        if high - low > len(self._kept):
            self._kept = np.empty((high - low, self.width, self.channels), self.dtype)
        self._kept[:overlap] = buffered
        self._first, self._end = low, low + overlap
        while self._end < high:
            # In pieces, because what is read is an array of its own until it is copied.
            stop = min(self._aligned(self._end, self._end + PIECE_ROWS)[1], high)
            target = self._kept[self._end - low : stop - low]
            step = self.width
            if side := self._tile[1]:
                step = max(PIECE_TEXELS // (stop - self._end) // side, 1) * side
            for left in range(0, self.width, step):
                right = min(left + step, self.width)
                target[:, left:right] = self._read(self._end, stop, left, right)
            self._end = stop

    def _aligned(self, start: int, stop: int) -> tuple[int, int]:
        """The rows of whole tiles that contain these rows."""
        side = self._tile[0] or 1
        return start // side * side, min(-(-stop // side) * side, self.height)

    def _read(self, start: int, stop: int, left: int = 0, right: int | None = None) -> npt.NDArray[Any]:
        """Decode rows; of tiled images, columns from `left` to `right` of them."""
        right = self.width if right is None else right
        values, problem = self._source.read(start, stop, left, right)
        # A JPEG that ends early still returns texels, with only the error text to tell.
        if values is None or problem:
            raise InputError(_reason("is damaged or cut short", problem), file=self.path)
        texels: npt.NDArray[Any] = values.reshape(stop - start, right - left, self.channels)
        return texels


class _OpenImageIO:
    """An image file as OpenImageIO reads it."""

    def __init__(self, source: Any, spec: Any) -> None:
        self._source, self._spec = source, spec
        self.height, self.width = spec.height, spec.width
        self.channel_names, self.kind = list(spec.channelnames), str(spec.format)
        self.alpha = spec.alpha_channel if 0 <= spec.alpha_channel < spec.nchannels else None
        self.colour_space: str = spec.get_string_attribute("oiio:ColorSpace")
        self.tile = spec.tile_height, spec.tile_width

    def read(self, start: int, stop: int, left: int, right: int) -> tuple[npt.NDArray[Any] | None, str]:
        """Texels of a window, all columns where the image has no tiles, and what went wrong."""
        spec, source = self._spec, self._source
        kind = self.kind if self.kind in ("uint8", "uint16") else "float"
        with _decoders_silent():
            if (start, stop, left, right) == (0, self.height, 0, self.width):
                values = source.read_image(kind)
            elif spec.tile_width:
                columns = (spec.x + left, spec.x + right)
                rows = (spec.y + start, spec.y + stop)
                values = source.read_tiles(*columns, *rows, 0, 1, 0, spec.nchannels, kind)
            else:
                values = source.read_scanlines(spec.y + start, spec.y + stop, 0, 0, spec.nchannels, kind)
        return values, source.geterror()

    @property
    def decodes(self) -> bool:
        """Whether its first texels can be decoded."""
        down, across = self.tile
        values, _ = self.read(0, min(down or 1, self.height), 0, min(across or self.width, self.width))
        return values is not None


class _Gdal:
    """An image file as GDAL reads it: its colours, or the indices of its palette."""

    tile = 0, 0
    colour_space = ""

    def __init__(self, dataset: Any, indices: bool) -> None:
        from rasterio.enums import ColorInterp

        self._dataset = dataset
        self.height, self.width, self.kind = dataset.height, dataset.width, str(dataset.dtypes[0])
        meaning = list(dataset.colorinterp)
        self._table = None
        if dataset.count == 1 and not indices and (table := colour_table(dataset)) is not None:
            self._table, meaning = table, [ColorInterp.red, ColorInterp.green, ColorInterp.blue]
        if meaning[:3] == [ColorInterp.red, ColorInterp.green, ColorInterp.blue]:
            self.channel_names = ["R", "G", "B", *("A" if m == ColorInterp.alpha else "extra" for m in meaning[3:])]
        else:
            self.channel_names = ["Y" if len(meaning) == 1 else f"band{k + 1}" for k in range(len(meaning))]
        self.alpha = meaning.index(ColorInterp.alpha) if ColorInterp.alpha in meaning else None

    def read(self, start: int, stop: int, left: int, right: int) -> tuple[npt.NDArray[Any] | None, str]:
        """Texels of a window, and what went wrong."""
        from rasterio.errors import RasterioError

        with quiet():
            try:
                planes = self._dataset.read(window=((start, stop), (left, right)))
            except RasterioError as error:
                return None, str(error)
        if self._table is not None:
            return np.take(self._table, planes[0], axis=0), ""
        values = np.moveaxis(planes, 0, -1)
        if values.dtype.kind in "iu" and values.dtype not in (np.uint8, np.uint16):
            values = values / np.float32(np.iinfo(values.dtype).max)
        return np.ascontiguousarray(values, dtype=values.dtype if values.dtype.kind == "u" else np.float32), ""


def colour_table(dataset: Any) -> npt.NDArray[np.uint8] | None:
    """Red, green and blue (256, 3) of the indices of a palette; None where a dataset of GDAL has none."""
    with quiet():
        try:
            entries = dataset.colormap(1)
        except (ValueError, KeyError):
            return None
    table = np.zeros((256, 3), np.uint8)
    for index, colour in entries.items():
        table[index] = colour[:3]
    return table


def read_channels(path: Path) -> npt.NDArray[Any]:
    """All channels (H, W, C) of an image; see `Raster` for their types and for what is raised."""
    raster = Raster(path)
    return raster.rows(0, raster.height)


def file_sha256(path: Path) -> str:
    """SHA-256 of a file's bytes.

    Raises InputError: the file cannot be read.
    """
    if path.exists() and not path.is_file():
        raise InputError("is no file that can be read; check the path", file=path)
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None


def _open(path: Path, indices: bool) -> _OpenImageIO | _Gdal:
    import OpenImageIO as oiio

    if not path.is_file():
        raise InputError("does not exist or is not a file; check the image's path", file=path)
    with open(path, "rb") as file:
        start = file.read(12)
    for beginning, remedy in FOREIGN.items():
        if start.startswith(beginning):
            raise InputError(remedy, file=path)
    if indices and (dataset := open_dataset(path)) is not None and colour_table(dataset) is not None:
        return _Gdal(dataset, True)
    config = oiio.ImageSpec()
    config["oiio:UnassociatedAlpha"] = 1  # else colours come multiplied by alpha, and change with it
    with _decoders_silent():
        source = oiio.ImageInput.open(str(path), config)
    problem = "" if source is not None else oiio.geterror()
    opened = None
    if source is not None:
        spec = source.spec()
        if spec.depth > 1 or spec.width < 1 or spec.height < 1:
            raise InputError(f"has the size {spec.width} x {spec.height} x {spec.depth}; allowed: one plane", file=path)
        opened = _OpenImageIO(source, spec)
        # OpenImageIO passes CIELAB on as if it were red, green and blue.
        plain = "lab" not in str(spec.get_string_attribute("tiff:ColorSpace")).lower()
        if spec.getattribute("tiff:PhotometricInterpretation") is None or (plain and opened.decodes):
            return opened
    dataset = open_dataset(path) if is_tiff(path) else None
    if dataset is not None and _decodes(dataset):
        return _Gdal(dataset, False)
    if opened is None:
        raise InputError(_reason("is not an image that can be read", problem), file=path)
    return opened  # what is wrong with it is said where it is read


def _decodes(dataset: Any) -> bool:
    from rasterio.errors import RasterioError

    with quiet():
        try:
            dataset.read(1, window=((0, 1), (0, dataset.width)))
        except RasterioError:
            return False
    return dataset.dtypes[0] in ("uint8", "uint16", "int8", "int16", "uint32", "int32", "float32", "float64")


@contextmanager
def _decoders_silent() -> Iterator[None]:
    """Keep what libpng and libtiff write to standard error by themselves: their reason is in the error raised."""
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
    summary = detail.strip().splitlines()[0] if detail.strip() else "no reason given"
    return f"{message} ({summary.rstrip('.')}); allowed: PNG, JPEG, TIFF and what else OpenImageIO reads; save it again"
