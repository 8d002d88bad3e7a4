"""Textures: colours as their file stores them, their encoding, and where there is no data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.intake import take_in
from skyshine.tmm.images.no_data import NoData
from skyshine.tmm.images.raster import Raster, file_sha256

ALPHA_LIMIT = 0.5  # the usual cut-off of alpha-tested textures
PIECE_TEXELS = 1 << 21  # looked at at a time
# The curve of Rec. 709, which OpenImageIO states of PGM and PPM, is that of sRGB to what 8 bits show.
_SRGB = {"rec709", "srgb_rec709_scene", "srgb_rec709_display", "srgb", "srgb_texture"}
_LINEAR = {"lin_rec709_scene", "linear", "lin_srgb", "lin_rec709", "scene_linear"}


class Windowed(Protocol):
    """What classifiers need of a texture: its size and encoding, and its texels window by window."""

    height: int
    width: int
    channels: int
    dtype: np.dtype[Any]
    encoding: str

    def window(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours (h, w, C) and where there is data (h, w) bool, of a window within the texture."""


@dataclass(frozen=True)
class Texture:
    """A texture in memory.

    pixels : (H, W, C) uint8, uint16 or float32
        Red, green, blue as the file stores them: integers over their full range, floats as they are. Grey is repeated.
        A fourth channel is near infrared.
    valid : (H, W) bool
        False where the texel is transparent, the file says that it has no data, or a channel is not finite.
    encoding : str; ``srgb``, ``linear``, or another colour space that OpenImageIO names and can convert.
    """

    pixels: npt.NDArray[Any]
    valid: npt.NDArray[np.bool_]
    encoding: str

    @property
    def height(self) -> int:
        return int(self.pixels.shape[0])

    @property
    def width(self) -> int:
        return int(self.pixels.shape[1])

    @property
    def channels(self) -> int:
        return int(self.pixels.shape[2])

    @property
    def dtype(self) -> np.dtype:
        return self.pixels.dtype

    def window(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours and validity of a window; see `Windowed`."""
        return self.pixels[rows, columns], self.valid[rows, columns]


class TextureFile:
    """A texture in an image file, read window by window; windows in the order of their rows are read once.

    Attributes as of `Texture`, without its arrays, and:

    path : Path
    sha256 : str
        Of the bytes of the file.
    """

    def __init__(
        self,
        path: Path,
        colour_space: str = "auto",
        alpha: str = "auto",
        near_infrared: str | None = None,
        white: float | str | None = None,
        indices: bool = False,
    ) -> None:
        """Open an image as it is stored (an orientation tag turns nothing: a runtime's texture unit does not either).

        Raises InputError: the file is missing or is no image, its colour space is unknown, it lacks a channel, or its
        mask does not fit.

        path : Path
        colour_space : {"auto", "srgb", "linear"}
            ``auto`` takes the file's own metadata; without any, integers are sRGB and floats linear.
        alpha : {"auto", "no-data", "ignore"}
            Whether texels with alpha below one half, masked ones and those of a no-data value have no data; see
            `take_in`.
        near_infrared, white
            See `take_in`.
        indices : bool; whether the indices of the image's palette are read as grey levels.
        """
        self.path, self._raster = path, Raster(path, indices)
        self.intake = take_in(path, self._raster, near_infrared, alpha, white)
        picked = list(self.intake.colours)
        # Neighbours, as they mostly are, are copied many times faster as a slice.
        beside = picked == list(range(picked[0], picked[0] + len(picked)))
        self._picked: slice | list[int] = slice(picked[0], picked[0] + len(picked)) if beside else picked
        self._no_data = None if alpha == "ignore" else NoData(path, self._raster)
        self.height, self.width, self.channels = self._raster.height, self._raster.width, len(picked)
        self.dtype = self._raster.dtype
        self.encoding = _encoding(path, self._raster, self.dtype) if colour_space == "auto" else colour_space
        self.sha256 = file_sha256(path)
        if self._no_data is not None and self._no_data.lossy:
            self._no_data.find_collar(self._bands(), self.height, self.width)

    def window(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours and validity of a window; see `Windowed`.

        Raises InputError: the file is damaged or cut short.
        """
        values = self._raster.rows(rows.start, rows.stop)[:, columns]
        # An array of the raster is valid until its next call alone.
        colours = np.array(values[..., self._picked], order="C")
        valid = np.ones(colours.shape[:2], bool)
        for _, lost in self._reasons(rows, columns, values, colours):
            valid &= ~lost
        if self.intake.white is not None:
            full = np.iinfo(np.uint16).max
            scaled = colours * np.float32(full / self.intake.white)
            colours = np.minimum(scaled, full).astype(np.uint16)
        return colours, valid

    def without_data(self) -> dict[str, float]:
        """Share of the texels without data by its reason; a texel counts for the first of them."""
        counts: dict[str, int] = {}
        for rows, colours, values in self._pieces():
            left = np.ones(colours.shape[:2], bool)
            for reason, lost in self._reasons(rows, slice(0, self.width), values, colours):
                counts[reason] = counts.get(reason, 0) + int(np.count_nonzero(lost & left))
                left &= ~lost
        return {reason: count / (self.height * self.width) for reason, count in counts.items() if count}

    def _reasons(
        self, rows: slice, columns: slice, values: npt.NDArray[Any], colours: npt.NDArray[Any]
    ) -> Iterator[tuple[str, npt.NDArray[np.bool_]]]:
        """Why texels of a window have no data, one reason after the other."""
        if colours.dtype.kind == "f":
            yield "not finite", ~np.isfinite(colours).all(axis=-1)
        if self.intake.alpha is not None:
            yield "alpha", values[..., self.intake.alpha] < ALPHA_LIMIT * self.intake.opaque
        if self._no_data is not None:
            yield from self._no_data.reasons(rows, columns, colours)

    def _pieces(self) -> Iterator[tuple[slice, npt.NDArray[Any], npt.NDArray[Any]]]:
        """Rows, colours and values of bands of the image, from its top."""
        step = max(PIECE_TEXELS // self.width, 1)
        for top in range(0, self.height, step):
            rows = slice(top, min(top + step, self.height))
            values = self._raster.rows(rows.start, rows.stop)
            yield rows, values[..., self._picked], values

    def _bands(self) -> Iterator[tuple[slice, npt.NDArray[Any]]]:
        return ((rows, colours) for rows, colours, _ in self._pieces())

    @property
    def interpretation(self) -> dict[str, str]:
        """What the image's parts were taken to be, in words, by what it is about."""
        interpretation = {**self.intake.interpretation, "encoding": self.encoding}
        if self._no_data is not None and self._no_data.value is not None:
            near = " and near it on the collar" if self._no_data.lossy else ""
            interpretation["no data"] = f"{self._no_data.value:g}{near}"
        if self._no_data is not None and self._no_data.masked:
            interpretation["mask"] = "where it is 0"
        return interpretation


def _encoding(path: Path, image: Raster, dtype: np.dtype[Any]) -> str:
    import OpenImageIO as oiio

    stated = image.colour_space
    if not stated:
        return "linear" if dtype.kind == "f" else "srgb"
    if stated.lower() in _SRGB:
        return "srgb"
    if stated.lower() in _LINEAR:
        return "linear"
    if oiio.ColorConfig().getColorSpaceIndex(stated) < 0:
        raise InputError(
            f"states the colour space '{stated}'; say 'colour_space: srgb' or 'linear' in the job", file=path
        )
    return stated
