"""Textures: colours as their file holds them, their encoding, and where there is no data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.images.no_data import NoData
from skyshine.tmm.images.raster import Raster, file_sha256

ALPHA_LIMIT = 0.5  # the usual cut-off of alpha-tested textures
_SRGB = {"srgb_rec709_scene", "srgb_rec709_display", "srgb", "srgb_texture"}
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

    Attributes
    ----------
    pixels : (H, W, C) uint8, uint16 or float32
        Red, green, blue as the file holds them: integers over their full range, floats as they are. Grey is repeated.
        A fourth channel is near infrared.
    valid : (H, W) bool
        False where the texel is transparent, the file says that it has no data, or a channel is not finite.
    encoding : str
        ``srgb``, ``linear``, or another colour space that OpenImageIO names and can convert.
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
        self, path: Path, colour_space: str = "auto", alpha: str = "no-data", near_infrared: str | None = None
    ) -> None:
        """Open an image as it is stored (an orientation tag turns nothing: a runtime's texture unit does not either).

        Parameters
        ----------
        path : Path
        colour_space : {"auto", "srgb", "linear"}
            ``auto`` takes the file's own metadata; without any, integers are sRGB and floats linear.
        alpha : {"no-data", "ignore"}
            Whether texels with alpha below one half, masked ones and those of a no-data value have no data.
        near_infrared : str, optional
            Name or number, from 1, of the channel of near infrared.

        Raises
        ------
        InputError
            The file is missing or is no image, its colour space is unknown, it lacks a channel, or its mask does
            not fit.
        """
        self.path, self._raster = path, Raster(path)
        picked, self._alpha = _channels(path, self._raster.spec, near_infrared)
        # Neighbours, as they mostly are, are copied many times faster as a slice.
        beside = picked == list(range(picked[0], picked[0] + len(picked)))
        self._picked: slice | list[int] = slice(picked[0], picked[0] + len(picked)) if beside else picked
        self._no_data = NoData(path, self._raster) if alpha == "no-data" else None
        if alpha == "ignore":
            self._alpha = None
        self.height, self.width, self.channels = self._raster.height, self._raster.width, len(picked)
        self.dtype = self._raster.dtype
        self.encoding = _encoding(path, self._raster.spec, self.dtype) if colour_space == "auto" else colour_space
        self.sha256 = file_sha256(path)

    def window(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours and validity of a window; see `Windowed`.

        Raises
        ------
        InputError
            The file is damaged or cut short.
        """
        values = self._raster.rows(rows.start, rows.stop)[:, columns]
        colours = np.array(
            values[..., self._picked], order="C"
        )  # what the raster gives holds until its next call alone
        valid = np.isfinite(colours).all(axis=-1) if colours.dtype.kind == "f" else np.ones(colours.shape[:2], bool)
        if self._alpha is not None:
            full = np.iinfo(self.dtype).max if self.dtype.kind == "u" else 1.0
            valid &= values[..., self._alpha] >= ALPHA_LIMIT * full
        if self._no_data is not None:
            valid &= self._no_data.valid(rows, columns, colours)
        return colours, valid


def _channels(path: Path, spec: Any, near_infrared: str | None) -> tuple[list[int], int | None]:
    """Numbers of the channels red, green, blue and, where wanted, near infrared; and that of alpha or None."""
    names = list(spec.channelnames)
    infrared = None if near_infrared is None else _named(path, names, near_infrared)
    alpha = spec.alpha_channel if 0 <= spec.alpha_channel < spec.nchannels else None
    if alpha == infrared:
        alpha = None
    colours = [i for i in range(spec.nchannels) if i not in (alpha, infrared)]
    if {"R", "G", "B"} <= set(names):
        picked = [names.index(c) for c in "RGB"]
    elif len(colours) == 1:
        picked = colours * 3
    elif len(colours) >= 3:
        picked = colours[:3]
    else:
        raise InputError(f"has the channels {', '.join(names)}; allowed: grey or R, G, B, with or without A", file=path)
    return picked + ([] if infrared is None else [infrared]), alpha


def _named(path: Path, names: list[str], wanted: str) -> int:
    if wanted in names:
        return names.index(wanted)
    if wanted.isdecimal() and 1 <= int(wanted) <= len(names):
        return int(wanted) - 1
    raise InputError(
        f"has no channel '{wanted}'; {nearest(wanted, names)}, or a number from 1 to {len(names)}", file=path
    )


def _encoding(path: Path, spec: Any, dtype: np.dtype[Any]) -> str:
    import OpenImageIO as oiio

    stated: str = spec.get_string_attribute("oiio:ColorSpace")
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
