"""Reading of textures through OpenImageIO: native values, encoding, and where there is no data."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError

ALPHA_LIMIT = 0.5  # the usual cut-off of alpha-tested textures
_SRGB = {"srgb_rec709_scene", "srgb_rec709_display", "srgb", "srgb_texture"}
_LINEAR = {"lin_rec709_scene", "linear", "lin_srgb", "lin_rec709", "scene_linear"}


@dataclass(frozen=True)
class Texture:
    """An image in memory.

    Attributes
    ----------
    path : Path
    pixels : (H, W, 3) uint8, uint16 or float32
        Red, green, blue as the file holds them: integers over their full range, floats as they are. Grey is repeated.
    valid : (H, W) bool
        False where the texel is transparent or a channel is not finite.
    encoding : str
        ``srgb``, ``linear``, or another colour space that OpenImageIO names and can convert.
    sha256 : str
        Of the bytes of the file.
    """

    path: Path
    pixels: np.ndarray
    valid: np.ndarray
    encoding: str
    sha256: str

    @property
    def height(self) -> int:
        return self.pixels.shape[0]

    @property
    def width(self) -> int:
        return self.pixels.shape[1]


def read_texture(path: Path, colour_space: str = "auto", alpha: str = "no-data") -> Texture:
    """Read an image file as it is stored (an orientation tag turns nothing: a runtime's texture unit does not either).

    Parameters
    ----------
    path : Path
    colour_space : {"auto", "srgb", "linear"}
        ``auto`` takes the file's own metadata; without any, integers are sRGB and floats linear.
    alpha : {"no-data", "ignore"}
        Whether texels with alpha below one half have no data.

    Raises
    ------
    InputError
        The file is missing, is no image, is damaged or cut short, or its colour space is unknown.
    """
    channels, spec = read_channels(path)
    colour, opacity = _split(path, channels, spec)
    valid = np.isfinite(colour).all(axis=-1) if colour.dtype.kind == "f" else np.ones(colour.shape[:2], bool)
    if alpha == "no-data" and opacity is not None:
        full = np.iinfo(opacity.dtype).max if opacity.dtype.kind == "u" else 1.0
        valid &= opacity >= ALPHA_LIMIT * full
    encoding = _encoding(path, spec, colour.dtype) if colour_space == "auto" else colour_space
    return Texture(path, colour, valid, encoding, file_sha256(path))


def file_sha256(path: Path) -> str:
    """SHA-256 of a file's bytes.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None


def read_channels(path: Path):
    """All channels of an image.

    Returns
    -------
    channels : (H, W, C) uint8, uint16 or float32
        8 and 16 bit unsigned as stored; any other integer scaled to its full range, any other float as float32.
    spec : OpenImageIO.ImageSpec

    Raises
    ------
    InputError
        The file is missing, is no image, or is damaged or cut short.
    """
    import OpenImageIO as oiio

    if not path.is_file():
        raise InputError("does not exist or is not a file; check the image's path", file=path)
    config = oiio.ImageSpec()
    config["oiio:UnassociatedAlpha"] = 1  # else colours come multiplied by alpha, and change with it
    source = oiio.ImageInput.open(str(path), config)
    if source is None:
        raise InputError(_reason("is not an image that can be read", oiio.geterror()), file=path)
    try:
        spec = source.spec()
        if spec.depth > 1 or spec.width < 1 or spec.height < 1:
            raise InputError(f"has the size {spec.width} x {spec.height} x {spec.depth}; allowed: one plane", file=path)
        kind = str(spec.format)
        with _decoders_silent():
            channels = source.read_image(kind if kind in ("uint8", "uint16") else "float")
        # A JPEG that ends early still returns texels, with only the error text to tell.
        problem = source.geterror()
    finally:
        source.close()
    if channels is None or problem:
        raise InputError(_reason("is damaged or cut short", problem), file=path)
    return channels.reshape(spec.height, spec.width, spec.nchannels), spec


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


def _split(path: Path, channels: np.ndarray, spec) -> tuple[np.ndarray, np.ndarray | None]:
    """Red, green, blue (H, W, 3) and alpha (H, W) or None."""
    names = list(spec.channelnames)
    alpha = spec.alpha_channel if 0 <= spec.alpha_channel < spec.nchannels else None
    rest = [i for i in range(spec.nchannels) if i != alpha]
    if {"R", "G", "B"} <= set(names):
        picked = [names.index(c) for c in "RGB"]
    elif len(rest) == 1:
        picked = rest * 3
    elif len(rest) >= 3:
        picked = rest[:3]
    else:
        raise InputError(f"has the channels {', '.join(names)}; allowed: grey or R, G, B, with or without A", file=path)
    return np.ascontiguousarray(channels[..., picked]), None if alpha is None else channels[..., alpha]


def _encoding(path: Path, spec, dtype: np.dtype) -> str:
    import OpenImageIO as oiio

    stated = spec.get_string_attribute("oiio:ColorSpace")
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
