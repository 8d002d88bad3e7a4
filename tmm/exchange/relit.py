"""The photograph of a texture without its cast shade."""

from __future__ import annotations

import io
import os
from pathlib import Path

import numpy as np
import tifffile

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import find_image, open_tmm
from skyshine.tmm.exchange.files import write_bytes
from skyshine.tmm.features.shade import RelitTexture
from skyshine.tmm.inputs.load import open_texture

_ROWS = 256  # read at a time


def write_relit(folder: str | os.PathLike[str], path: str | os.PathLike[str]) -> list[Path]:
    """Write ``NAME.relit.tif``: the texture as it was classified, of the type and encoding of its image.

    Raises InputError: the database has no shade, the image is not found, or a file cannot be written.

    path : path; the database; the image is looked for by its name (see `find_image`).
    """
    with open_tmm(path) as file:
        if not file.has_shade:
            raise InputError("has no layer of shade; classify the texture with 'shade'", file=path)
        job, image = file.job, find_image(file, Path(path), None)
    texture = open_texture(job.model_copy(update={"image": image.name}), image.parent)
    assert isinstance(texture, RelitTexture)
    bands = [
        texture.window(slice(top, min(top + _ROWS, texture.height)), slice(0, texture.width))[0]
        for top in range(0, texture.height, _ROWS)
    ]
    content = io.BytesIO()
    values = np.concatenate(bands)
    tifffile.imwrite(
        content, values, photometric="rgb", compression="zlib", predictor=values.dtype.kind == "u", metadata=None
    )
    target = Path(folder) / f"{job.name}.relit.tif"
    write_bytes(target, content.getvalue())
    return [target]
