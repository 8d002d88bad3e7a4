"""Shares of materials as PNG: a grey mask for each material, or splat maps of four materials each.

Shares of a texel sum to 255, less where a part of it has no material. Terrains of game engines take them so: an 8 bit
grey image a layer in the Unreal Engine ("Creating and using custom heightmaps and layers", Epic Games); in Unity layers
1 to 4 are red, green, blue and alpha of the first splat map, 5 to 8 those of the second ("Terrain layers" of its
Terrain Tools).
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.database.levels import COMPONENTS, integer_weights
from skyshine.tmm.exchange.files import write_bytes, write_json
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.legend import legend
from skyshine.tmm.exchange.rasters import png_bytes

FULL = 255  # a share of 1 in 8 bits
CHANNELS = "RGBA"


def write_masks(folder: str | os.PathLike[str], image: MaterialImage) -> list[Path]:
    """Write ``NAME.MATERIAL.png`` (8 bit grey) for each material, and ``NAME.masks.json``.

    Raises InputError: a file cannot be written.
    """
    shares, paths = _shares(image), []
    entries: dict[str, dict[str, Any]] = {}
    for number, entry in legend(image).items():
        paths.append(Path(folder) / f"{image.name}.{entry['name']}.png")
        write_bytes(paths[-1], png_bytes(_share(image, shares, entry["code"])))
        entries[str(number)] = {**entry, "image": paths[-1].name}
    paths.append(Path(folder) / f"{image.name}.masks.json")
    write_json(paths[-1], {"full": FULL, "materials": entries})
    return paths


def write_splat_maps(folder: str | os.PathLike[str], image: MaterialImage) -> list[Path]:
    """Write ``NAME.splat0.png`` and on (8 bit RGBA, four materials each), and ``NAME.splat.json``.

    Raises InputError: a file cannot be written.
    """
    shares, paths = _shares(image), []
    entries: dict[str, dict[str, Any]] = {}
    layers = list(legend(image).items())
    for start in range(0, len(layers), len(CHANNELS)):
        paths.append(Path(folder) / f"{image.name}.splat{start // len(CHANNELS)}.png")
        picture = np.zeros((image.height, image.width, len(CHANNELS)), np.uint8)
        for channel, (number, entry) in enumerate(layers[start : start + len(CHANNELS)]):
            picture[..., channel] = _share(image, shares, entry["code"])
            entries[str(number)] = {**entry, "image": paths[-1].name, "channel": CHANNELS[channel]}
        write_bytes(paths[-1], png_bytes(picture))
    paths.append(Path(folder) / f"{image.name}.splat.json")
    write_json(paths[-1], {"full": FULL, "materials": entries})
    return paths


def _shares(image: MaterialImage) -> npt.NDArray[np.uint8]:
    """Shares (H, W, 3) of a texel's materials in integers that sum to `FULL`."""
    weight = image.level.mix_weight
    shares = integer_weights(weight.reshape(-1, COMPONENTS).T.astype(np.int64), FULL)
    return np.ascontiguousarray(shares.T.reshape(weight.shape).astype(np.uint8))


def _share(image: MaterialImage, shares: npt.NDArray[np.uint8], code: int) -> npt.NDArray[np.uint8]:
    """Share (H, W) of one material."""
    share: npt.NDArray[np.uint8] = np.where(image.level.mix_code == code, shares, 0).sum(axis=-1, dtype=np.uint8)
    return share
