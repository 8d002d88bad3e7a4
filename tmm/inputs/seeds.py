"""Seeds: the texels whose material is known, from polygons, GeoJSON and label images."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.labels import NONE, Labels
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.inputs.polygons import Ring, check_vertices, polygon_mask, seed_polygons
from skyshine.tmm.job.model import Seeds, TextureJob

BLOCK = 32  # texels; a label image is divided into regions of this size
BLOCKS = 4096  # of one material in a label image that are seeds: four million texels tell its colours well enough
POLYGON_TEXELS = 1 << 22  # of one polygon that are seeds; a larger one is thinned to a regular grid
PIECE_TEXELS = 1 << 21  # read at a time


@dataclass(frozen=True)
class SeedTexels:
    """Texels of known material, each once.

    Attributes
    ----------
    names : tuple of str
        Materials in the order of their codes.
    rows, columns : (N,) int
    material : (N,) int
        Index into `names`.
    region : (N,) int
        Texels of one region (a polygon, or a block of a label image) are alike and are held out together.
    colours : (N, C)
        As the texture holds them.
    conflicting : int
        Texels that more than one material claimed; they are left out.
    """

    names: tuple[str, ...]
    rows: npt.NDArray[Any]
    columns: npt.NDArray[Any]
    material: npt.NDArray[Any]
    region: npt.NDArray[Any]
    colours: npt.NDArray[Any]
    conflicting: int


def seed_files(seeds: Seeds | None) -> tuple[str, ...]:
    """Files that seeds come from, relative to the job's folder."""
    files = (seeds.file, seeds.labels.image if seeds.labels else None) if seeds else ()
    return tuple(name for name in files if name is not None)


def seed_texels(
    job: TextureJob, seeds: Seeds, names: tuple[str, ...], texture: Windowed, path: Path, base_folder: Path
) -> SeedTexels:
    """Find the seed texels of a texture.

    Parameters
    ----------
    names : tuple of str
        Materials that the seeds name, in the order of their codes.
    path : Path
        Of the texture, for messages.

    Raises
    ------
    InputError
        A polygon reaches beyond the image, the label image does not fit, or a material has no texel left once texels
        without data and texels claimed by several materials are taken away.
    """
    claims = [np.empty((3, 0), np.int64)]
    for region, (name, rings) in enumerate(seed_polygons(seeds, base_folder)):
        check_vertices(name, rings, texture, path)
        texels = _inside(rings, texture)
        claims.append(np.stack([texels, np.full_like(texels, names.index(name)), np.full_like(texels, region)]))
    if seeds.labels is not None:
        labels = Labels(seeds.labels, base_folder, names).fits(texture.height, texture.width)
        claims += _label_claims(labels, len(names), job.held_out.random_seed)
    return _settle(job, names, texture, path, np.concatenate(claims, axis=1))


def _settle(
    job: TextureJob, names: tuple[str, ...], texture: Windowed, path: Path, claims: npt.NDArray[Any]
) -> SeedTexels:
    """Keep each claimed texel once; `claims` is (3, N): texel number, material, region."""
    texel, material, region = claims
    order = np.argsort(texel, kind="stable")
    texel, material, region = texel[order], material[order], region[order]
    unique, first, _counts = np.unique(texel, return_index=True, return_counts=True)
    lowest, highest = (reduce.reduceat(material, first) for reduce in (np.minimum, np.maximum))
    agreed = lowest == highest
    rows, columns = np.divmod(unique, texture.width)
    colours, valid = gather(texture, rows, columns)
    keep = agreed & valid
    kept = first[keep]
    number = np.bincount(material[kept], minlength=len(names))
    for index in np.flatnonzero(number == 0):
        raise InputError(
            f"material '{names[index]}' of '{job.name}' has no seed texel left (outside the data, or claimed by other "
            "materials too); draw a polygon that it has alone",
            file=path,
        )
    rows, columns = rows[keep], columns[keep]
    region = _divide(material[kept], region[kept], rows, columns)
    return SeedTexels(names, rows, columns, material[kept], region, colours[keep], int(np.sum(~agreed)))


def gather(
    texture: Windowed, rows: npt.NDArray[Any], columns: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Colours (N, C) and validity (N,) of texels in the order of their rows, read from the top to the bottom."""
    colours, valid = np.empty((len(rows), texture.channels), texture.dtype), np.empty(len(rows), bool)
    step = max(PIECE_TEXELS // texture.width, 1)
    for start in range(0, texture.height, step):
        part = slice(*np.searchsorted(rows, (start, start + step)))
        if part.start < part.stop:
            band = slice(start, min(start + step, texture.height))
            pixels, known = texture.window(band, slice(0, texture.width))
            at = rows[part] - start, columns[part]
            colours[part], valid[part] = pixels[at], known[at]
    return colours, valid


def _divide(
    material: npt.NDArray[Any], region: npt.NDArray[Any], rows: npt.NDArray[Any], columns: npt.NDArray[Any]
) -> npt.NDArray[Any]:
    """Split the regions of a material that has only one into four blocks at most, so that a part can be held out."""
    block = np.zeros_like(region)
    for index in np.unique(material):
        mine = material == index
        if len(np.unique(region[mine])) == 1:
            for bit, position in ((1, rows[mine]), (2, columns[mine])):
                block[mine] += bit * (position > np.median(position))
    return np.unique(np.stack([region, block]), axis=1, return_inverse=True)[1].ravel()


def _inside(rings: tuple[Ring, ...], texture: Windowed) -> npt.NDArray[Any]:
    """Numbers of the texels in a polygon; of a very large one, those of a regular grid."""
    outline = np.array([position[:2] for position in rings[0]])
    # A vertex on the far edge of the image stands in its last texel.
    low, high = (
        np.minimum(edge.astype(int), (texture.width - 1, texture.height - 1))
        for edge in (outline.min(0), outline.max(0))
    )
    width, height = high - low + 1
    step = int(np.ceil(np.sqrt(width * height / POLYGON_TEXELS)))
    rows, columns = np.nonzero(polygon_mask(rings, texture, low[1], low[0], (height, width), step))
    texels: npt.NDArray[np.int64] = (rows * step + low[1]) * texture.width + columns * step + low[0]
    return texels


def _label_claims(labels: Labels, count: int, random_seed: int) -> list[npt.NDArray[Any]]:
    """Claims of a label image: of each material all blocks that hold it, or BLOCKS of them drawn at random."""
    random, across = np.random.default_rng(random_seed), -(-labels.width // BLOCK)
    bands = [slice(top, min(top + BLOCK, labels.height)) for top in range(0, labels.height, BLOCK)]
    present = np.zeros((count, len(bands) * across), bool)
    for number, band in enumerate(bands):
        known = labels.rows(band.start, band.stop)
        for k in range(count):
            texels = np.add.reduceat((known == k).any(axis=0), np.arange(0, labels.width, BLOCK))
            present[k, number * across : (number + 1) * across] = texels > 0
    for mine in present:
        blocks = np.flatnonzero(mine)
        if len(blocks) > BLOCKS:
            mine[np.setdiff1d(blocks, random.choice(blocks, BLOCKS, replace=False))] = False
    claims = []
    for number, band in enumerate(bands):
        chosen = present[:, number * across : (number + 1) * across]
        if chosen.any():
            rows, columns = np.nonzero((known := labels.rows(band.start, band.stop)) != NONE)
            material = known[rows, columns].astype(np.int64)
            block = columns // BLOCK
            keep = chosen[material, block]
            # Negative, so that no block shares its number with a polygon.
            region = -1 - (number * across + block[keep])
            claims.append(np.stack([((rows + band.start) * labels.width + columns)[keep], material[keep], region]))
    return claims
