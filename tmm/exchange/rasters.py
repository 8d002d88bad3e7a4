"""Reading and writing of the rasters that exchange formats are made of."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.tmm.raster import read_channels


def read_plane(path: str | os.PathLike) -> np.ndarray:
    """The only channel (H, W) of an image; see `read_channels` for types and errors.

    Raises
    ------
    InputError
        It cannot be read, or has several channels.
    """
    channels = read_channels(Path(path))
    if channels.shape[2] != 1:
        raise InputError(f"has {channels.shape[2]} channels; allowed: one; name a raster of material indices", file=path)
    return channels[..., 0]


def write_image(path: str | os.PathLike, values: np.ndarray, compression: str = "none") -> None:
    """Write an image (H, W) or (H, W, C) of uint8, uint16 or float32 in the format that the path's ending names.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    import OpenImageIO as oiio

    path = Path(path)
    values = np.ascontiguousarray(values if values.ndim == 3 else values[..., np.newaxis])
    height, width, channels = values.shape
    spec = oiio.ImageSpec(width, height, channels, values.dtype.name.replace("float32", "float"))
    spec["compression"] = compression
    if values.dtype.kind == "u":
        spec["oiio:ColorSpace"] = "Raw"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}; check the folder", file=path.parent) from None
    output = oiio.ImageOutput.create(str(path))
    if output is None or not output.open(str(path), spec) or not output.write_image(values) or not output.close():
        reason = (output.geterror() if output else oiio.geterror()).strip().splitlines() or ["no reason given"]
        raise InputError(f"cannot be written: {reason[0]}; check space and rights", file=path)
