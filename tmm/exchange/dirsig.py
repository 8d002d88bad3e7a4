"""Material map and mixture map of DIRSIG.

As its manual has them (Property Maps): a material map is an image of digital counts with a look-up table from count to
material label; a mixture map is an image of floats with one band a material, the share of it. Both go with a scene's
own projector and geometry, which name these files. The mixture map is written as ENVI raster (band sequential,
little-endian), which DIRSIG reads.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import COMPONENTS, WEIGHT_TOTAL
from skyshine.tmm.exchange.files import write_bytes, write_json
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.legend import legend

MAX_COUNT = 255  # largest count of the 8 bit image of digital counts; 0 is no material


def write_dirsig(folder: str | os.PathLike[str], image: MaterialImage) -> list[Path]:
    """Write ``NAME.material.pgm`` with ``NAME.material.lut``, ``NAME.mixture.img`` with ``.hdr``, and the legend
    ``NAME.material.json``.

    The look-up table has a line ``count label`` for each material; labels are the material names.
    Raises InputError: there are more materials than digital counts, or a file cannot be written.
    """
    if len(image.materials) > MAX_COUNT:
        raise InputError(f"'{image.name}' has {len(image.materials)} materials; allowed in a material map: {MAX_COUNT}")
    endings = (".material.pgm", ".material.lut", ".mixture.img", ".mixture.hdr", ".material.json")
    paths = [Path(folder) / f"{image.name}{ending}" for ending in endings]
    entries = legend(image)
    # binary portable grey map: a header of text, then the counts by rows
    header = f"P5\n{image.width} {image.height}\n{MAX_COUNT}\n".encode()
    write_bytes(paths[0], header + image.index(start=1).astype(np.uint8).tobytes())
    write_bytes(paths[1], "".join(f"{k} {entry['name']}\n" for k, entry in entries.items()).encode())
    write_bytes(paths[2], mixture_bands(image).astype("<f4").tobytes())
    write_bytes(paths[3], _envi_header(image).encode())
    content = {"image": paths[0].name, "mixture": paths[2].name, "no_material": 0}
    write_json(paths[4], {**content, "materials": {str(k): entry for k, entry in entries.items()}})
    return paths


def mixture_bands(image: MaterialImage) -> npt.NDArray[Any]:
    """Shares (K, H, W) float32 of the materials in the order of their codes; all 0 where there is none."""
    bands = np.zeros((len(image.materials), image.height, image.width), np.float32)
    weight = image.level.mix_weight / np.float32(WEIGHT_TOTAL)
    for band, code in zip(bands, image.materials, strict=True):
        for k in range(COMPONENTS):
            band += np.where(image.level.mix_code[..., k] == code, weight[..., k], 0)
    return bands


def _envi_header(image: MaterialImage) -> str:
    fields = {
        "description": f"{{Material shares of {image.name}}}",
        "samples": image.width,
        "lines": image.height,
        "bands": len(image.materials),
        "header offset": 0,
        "file type": "ENVI Standard",
        "data type": 4,  # float32
        "interleave": "bsq",
        "byte order": 0,  # little-endian
        "band names": "{" + ", ".join(image.materials.values()) + "}",
    }
    return "ENVI\n" + "".join(f"{key} = {value}\n" for key, value in fields.items())
