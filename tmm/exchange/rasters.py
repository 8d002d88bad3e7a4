"""Reading and writing of the rasters that exchange formats are made of."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.exchange.files import write_bytes
from skyshine.tmm.images.raster import read_channels


def read_plane(path: str | os.PathLike[str]) -> npt.NDArray[Any]:
    """The only channel (H, W) of an image; see `read_channels` for types and errors.

    Raises
    ------
    InputError
        It cannot be read, or has several channels.
    """
    channels = read_channels(Path(path))
    if channels.shape[2] != 1:
        raise InputError(
            f"has {channels.shape[2]} channels; allowed: one; name a raster of material indices", file=path
        )
    return channels[..., 0]


def write_tiff(
    path: str | os.PathLike[str], values: npt.NDArray[Any], tags: Mapping[int, tuple[float, ...]] | None = None
) -> None:
    """Write a plane (H, W) as TIFF without a date: uint8 and uint16 compressed by LZW, float32 as it is.

    Parameters
    ----------
    tags : dict of int to tuple, optional
        Further tags by number: whole numbers as 16 bit, else doubles.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    from PIL import Image, TiffImagePlugin, TiffTags

    directory = TiffImagePlugin.ImageFileDirectory_v2()
    for number, numbers in (tags or {}).items():
        whole = all(isinstance(value, int) for value in numbers)
        directory.tagtype[number] = TiffTags.SHORT if whole else TiffTags.DOUBLE
        directory[number] = numbers
    content = io.BytesIO()
    compression = {"compression": "tiff_lzw"} if values.dtype.kind == "u" else {}
    Image.fromarray(values).save(content, format="TIFF", tiffinfo=directory, **compression)
    write_bytes(path, content.getvalue())
