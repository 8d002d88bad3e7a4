"""Features at seed texels, as they are and in shadow, for the training of networks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.features.textured import MARGIN, features, in_other_light, in_shadow, light_planes, names
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.inputs.seeds import SeedTexels

SAMPLE = 3000  # seed texels of a material in one texture that a network is trained on
TILE = 256  # texels: features are computed about the seeds of one such tile at a time


@dataclass(frozen=True)
class Examples:
    """Features of seeds, as they are and in shadow.

    texel : (N,) int; which of the seeds each is.
    plain, shaded : (N, F) float32
        As they are; with shadows drawn on them and, of a library, in the light of another photograph.
    material : (N,) int; index into the names of the seeds.
    """

    texel: npt.NDArray[Any]
    plain: npt.NDArray[np.float32]
    shaded: npt.NDArray[np.float32]
    material: npt.NDArray[Any]


def examples(
    texture: Windowed,
    seeds: SeedTexels,
    random_seed: int,
    sample: int = SAMPLE,
    other_light: bool = False,
) -> Examples:
    """Features at a random sample of the seeds, of `sample` texels a material at most."""
    random = np.random.default_rng(random_seed)
    chosen = []
    for k in range(len(seeds.names)):
        mine = np.flatnonzero(seeds.material == k)
        chosen.append(mine if len(mine) <= sample else random.choice(mine, sample, replace=False))
    texel = np.sort(np.concatenate(chosen))
    plain, shaded = (np.empty((len(texel), len(names())), np.float32) for _ in range(2))
    tile = seeds.rows[texel] // TILE * (texture.width // TILE + 1) + seeds.columns[texel] // TILE
    for number in np.unique(tile):
        mine = np.flatnonzero(tile == number)
        rows, columns = seeds.rows[texel[mine]], seeds.columns[texel[mine]]
        top, left = max(rows.min() - MARGIN, 0), max(columns.min() - MARGIN, 0)
        bottom, right = (
            min(n.max() + MARGIN + 1, size) for n, size in ((rows, texture.height), (columns, texture.width))
        )
        pixels, valid = texture.window(slice(top, bottom), slice(left, right))
        pixels = np.where(valid[..., np.newaxis], pixels, pixels.dtype.type(0))
        at = (slice(None), rows - top, columns - left)
        plain[mine] = _features(pixels, valid, texture.encoding)[at].T
        dimmed = in_shadow(pixels, texture.encoding, random)[0]
        if other_light:
            dimmed = in_other_light(dimmed, random)
        shaded[mine] = _features(dimmed, valid, "linear")[at].T
    return Examples(texel, plain, shaded, seeds.material[texel])


def _features(pixels: npt.NDArray[Any], valid: npt.NDArray[np.bool_], encoding: str) -> npt.NDArray[Any]:
    planes = light_planes(pixels.reshape(-1, pixels.shape[2]), encoding)
    lab, linear = (part.reshape(3, *valid.shape) for part in planes)
    return features(lab, linear, valid)
