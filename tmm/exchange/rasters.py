"""Reading and writing of the rasters that exchange formats are made of."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.exchange.files import write_bytes
from skyshine.tmm.images.gdal import quiet
from skyshine.tmm.images.georeference import Affine
from skyshine.tmm.images.raster import read_channels


def read_plane(path: str | os.PathLike[str]) -> npt.NDArray[Any]:
    """The only channel (H, W) of an image; see `read_channels` for types and errors.

    Raises InputError: it cannot be read, or has several channels.
    """
    channels = read_channels(Path(path))
    if channels.shape[2] != 1:
        raise InputError(
            f"has {channels.shape[2]} channels; allowed: one; name a raster of material indices", file=path
        )
    return channels[..., 0]


def write_tiff(
    path: str | os.PathLike[str],
    values: npt.NDArray[Any],
    georeference: tuple[Affine, str] | None = None,
    names: dict[str, str] | None = None,
    **layout: Any,
) -> None:
    """Write a plane (H, W) as TIFF without a date.

    Raises InputError: GDAL does not know the coordinate system, or the file cannot be written.

    georeference : (Affine, str), optional; where it lies on a map, and in which coordinate system.
    names : dict of str to str, optional; texts of its band by their keys.
    **layout
        Options of GDAL's driver, such as ``compress``.
    """
    from rasterio.errors import RasterioError
    from rasterio.io import MemoryFile
    from rasterio.transform import Affine as Transform

    if georeference is not None:
        layout |= {"transform": Transform(*georeference[0]), "crs": georeference[1] or None}
    height, width = values.shape
    with quiet(), MemoryFile() as memory:
        try:
            with memory.open(driver="GTiff", height=height, width=width, count=1, dtype=values.dtype, **layout) as file:
                file.write(values, 1)
                file.update_tags(1, **(names or {}))
        except RasterioError as error:
            raise InputError(f"cannot be written: {error}; name another system of coordinates", file=path) from None
        write_bytes(path, bytes(memory.getbuffer()))


def png_bytes(values: npt.NDArray[np.uint8], palette: npt.NDArray[np.uint8] | None = None) -> bytes:
    """An 8 bit PNG of a plane (H, W), of colours (H, W, 3 or 4), or of indices (H, W) into a palette (N, 3)."""
    from PIL import Image

    picture, content = Image.fromarray(values), io.BytesIO()
    if palette is not None:
        picture = picture.convert("P")
        picture.putpalette(palette.tobytes(), "RGB")
    picture.save(content, format="PNG", optimize=False)
    return content.getvalue()
