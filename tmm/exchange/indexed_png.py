"""Indexed PNG: one palette entry a material, with a legend in JSON."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from skyshine.materials.colours import material_colours
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm.exchange.files import write_bytes, write_json
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.legend import legend
from skyshine.tmm.exchange.rasters import png_bytes

MAX_MATERIALS = 255  # a palette has 256 entries, the first represents no material


def write_png(folder: str | os.PathLike[str], image: MaterialImage) -> list[Path]:
    """Write ``NAME.png``, in the fixed colours of its materials, and ``NAME.legend.json``.

    Raises InputError: there are more materials than palette entries, or a file cannot be written.
    """
    if len(image.materials) > MAX_MATERIALS:
        raise InputError(
            f"'{image.name}' has {len(image.materials)} materials; allowed in an indexed PNG: {MAX_MATERIALS}; use --to"
            " gltf"
        )
    named = material_colours(tuple(image.materials.values()), load_library())
    colours = np.concatenate([np.zeros((1, 3), np.uint8), named])
    paths = [Path(folder) / f"{image.name}{ending}" for ending in (".png", ".legend.json")]
    write_bytes(paths[0], png_bytes(image.index(start=1).astype(np.uint8), colours))
    entries = {
        str(k): {**entry, "colour": "#{:02X}{:02X}{:02X}".format(*colours[k])} for k, entry in legend(image).items()
    }
    write_json(paths[1], {"image": paths[0].name, "no_material": 0, "materials": entries})
    return paths
