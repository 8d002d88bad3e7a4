"""Raster materials of OGC CDB: tiles (datasets 005 and 006) and textures of geotypical models (504 and 505).

Component selector 1 is 001 for indices into the Composite Material Table and 002 for the share of that material;
selector 2 is the layer, from 001. Indices are unsigned integers in LZW-compressed TIFF, shares floats from 0 to 1 in
plain TIFF, as OGC 15-113 (volume 1, clauses 3.4, 3.6 and 5.6) has integers compressed and floats not. File and folder
names follow the same clauses and the examples in the OGC conformance tests of CDB 1.0.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import count, takewhile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Level, pure_level, ranked
from skyshine.tmm.exchange.cdb_materials import CdbMaterials
from skyshine.tmm.exchange.cdb_places import INDEX, MAX_LAYERS, MIXTURE, ModelTexture, Tile, locate, lod_name
from skyshine.tmm.exchange.cdb_table import Composite, read_table, write_table
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.rasters import read_plane, write_tiff

_SHARE_UNIT = 1_000_000  # shares are ranked and scaled as integers


@dataclass(frozen=True)
class CdbRaster:
    """Raster materials as CDB has them.

    location : Tile or ModelTexture
    index : (L, H, W) integer
        Index into the table of each layer; 0 for the default, which is no material unless the table has it.
    share : (L, H, W) float32; share of each layer's material.
    table : dict of int to Composite
    """

    location: Tile | ModelTexture
    index: npt.NDArray[Any]
    share: npt.NDArray[Any]
    table: dict[int, Composite]


def read_cdb(path: str | os.PathLike[str], table_path: str | os.PathLike[str] | None = None) -> CdbRaster:
    """Read a raster of dataset 005 or 504 with its other layers, its shares and its table.

    Raises InputError: a file is missing or damaged, layers differ in size, or an index is not in the table.

    path : path
        Its first layer of indices, ``..._D005_S001_T001_....tif`` or ``D504_S001_T001_....tif``, in its place in a CDB.
    table_path : path, optional; of its table, where that is not in its own place.
    """
    path = Path(path)
    location, root = locate(path)
    layers = [read_plane(path)]
    while len(layers) < MAX_LAYERS and location.raster(root, INDEX, len(layers) + 1).is_file():
        layers.append(read_plane(location.raster(root, INDEX, len(layers) + 1)))
    shares = [_share(location.raster(root, MIXTURE, k + 1), layer, len(layers)) for k, layer in enumerate(layers)]
    for layer in layers:
        if layer.shape != layers[0].shape or layer.dtype.kind != "u":
            raise InputError(
                "has layers of different sizes, or of other than unsigned integers; write them again", file=path
            )
    packaged = location.table(root)
    if table_path is None and not packaged.exists():
        raise InputError(
            "is not there, the Composite Material Table of these rasters; name one with --table", file=packaged
        )
    table = read_table(packaged if table_path is None else table_path)
    index = np.stack(layers)
    indices_in(index, table, path, (packaged if table_path is None else Path(table_path)).name)
    return CdbRaster(location, index, np.stack(shares), table)


def _share(path: Path, layer: npt.NDArray[Any], layers: int) -> npt.NDArray[Any]:
    if not path.is_file():  # without shares the layers count alike
        return np.full(layer.shape, 1 / layers, np.float32)
    share = read_plane(path)
    if share.shape != layer.shape:
        raise InputError(f"is {share.shape[1]} x {share.shape[0]}; allowed: the size of its indices", file=path)
    full = np.iinfo(share.dtype).max if share.dtype.kind == "u" else 1.0
    share = share.astype(np.float32) / np.float32(full)
    if not ((share >= 0) & (share <= 1)).all():
        raise InputError("has shares outside 0 to 1; write them again", file=path)
    return share


def to_image(raster: CdbRaster, materials: CdbMaterials) -> MaterialImage:
    """The three materials of ours with the largest shares in each texel.

    Raises InputError: a composite in use has no counterpart among our materials.
    """
    return indexed_image(raster.location.name, raster.index, raster.share, raster.table, materials)


def indexed_image(
    name: str,
    layers: npt.NDArray[Any],
    shares: npt.NDArray[Any],
    table: dict[int, Composite],
    materials: CdbMaterials,
) -> MaterialImage:
    """The materials of ours in layers (L, H, W) of indices into a table, with the share (L, H, W) of each; see
    `to_image`.
    """
    mixtures = {k: materials.mixture(table[k]) for k in np.unique(layers).tolist() if k in table}
    codes = sorted({code for mixture in mixtures.values() for code in mixture})
    sums = np.zeros((len(codes), *layers.shape[1:]), np.float32)
    for row, code in enumerate(codes):
        by_index = np.zeros(int(layers.max()) + 1, np.float32)
        for index, mixture in mixtures.items():
            by_index[index] = mixture.get(code, 0.0)
        for index, share in zip(layers, shares, strict=True):
            sums[row] += by_index[index] * share
    names = {code: materials.library.by_code(code).name for code in codes}
    return MaterialImage(name, names, ranked_level(np.array(codes, np.uint16), sums))


def indices_in(index: npt.NDArray[Any], table: dict[int, Composite], path: Path, table_name: str) -> list[int]:
    """The indices that an image and a table share, ascending.

    Raises InputError: the table lacks one; 0 may be absent, which is no material then.
    """
    present = np.unique(index).tolist()
    missing = sorted(set(present) - {0} - set(table))
    if missing:
        raise InputError(
            f"has the index {missing[0]}, which {table_name} has not; allowed: {', '.join(map(str, table))}", file=path
        )
    return [k for k in present if k in table]


def ranked_level(codes: npt.NDArray[np.uint16], shares: npt.NDArray[Any]) -> Level:
    """A level of the largest shares (K, H, W) of materials whose codes (K,) ascend."""
    if not codes.size:
        return pure_level(np.zeros(shares.shape[1:], np.uint16))
    return ranked(codes, (np.rint(share * _SHARE_UNIT).astype(np.int64) for share in shares))


def used_codes(image: MaterialImage) -> list[int]:
    """Codes of the materials that some texel has, ascending."""
    return sorted(set(np.unique(image.level.mix_code[image.level.mix_weight > 0]).tolist()) - {0})


def from_image(
    image: MaterialImage, location: Tile | ModelTexture, materials: CdbMaterials, codes: list[int] | None = None
) -> CdbRaster:
    """Our materials as layers of composite materials, indices from 1 in the order of the codes.

    Raises InputError: the size is not the place's, or a material has no composite in the map.

    codes : list of int, optional; the materials of the table, ascending; by default those in use.
    """
    _check_size(image, location)
    level = image.level
    present = used_codes(image) if codes is None else codes
    table = {k: materials.composite(image.materials[code], k) for k, code in enumerate(present, 1)}
    lookup = np.zeros(max(present, default=0) + 1, np.uint8 if len(present) < 256 else np.uint16)
    lookup[present] = np.arange(1, len(present) + 1)
    index = np.stack([lookup[level.mix_code[..., k]] for k in range(image.layers)])
    weight = np.moveaxis(level.mix_weight[..., : image.layers], -1, 0)
    return CdbRaster(location, index, (weight / np.float32(WEIGHT_TOTAL)).astype(np.float32), table)


def _check_size(image: MaterialImage, location: Tile | ModelTexture) -> None:
    size = f"{image.width} x {image.height}"
    if isinstance(location, Tile) and (image.height, image.width) != (location.side, location.side):
        raise InputError(
            f"'{image.name}' is {size}; allowed for a tile of {lod_name(location.lod)}: {location.side} x "
            f"{location.side}; resample the texture to the tile's texels, or name another level of detail"
        )
    if isinstance(location, ModelTexture) and any(n & (n - 1) for n in (image.height, image.width)):
        raise InputError(f"'{image.name}' is {size}; allowed for a model texture: powers of two; resample the texture")


def write_cdb(root: str | os.PathLike[str], raster: CdbRaster) -> list[Path]:
    """Write indices, shares where there are several layers, and the table into a CDB.

    Raises InputError: there is nothing to write in the table, it breaks the schema, or a file cannot be written.

    Returns the files written.
    """
    root = Path(root)
    if not raster.table:
        raise InputError(
            f"'{raster.location.name}' has no texel with a material; a Composite Material Table cannot be empty"
        )
    _remove_layers(root, raster.location)
    georeference = raster.location.georeference() if isinstance(raster.location, Tile) else None
    paths = []
    for layer, index in enumerate(raster.index, 1):
        smallest = np.uint8 if index.max() < 256 else np.uint16
        paths.append(raster.location.raster(root, INDEX, layer))
        write_tiff(paths[-1], index.astype(smallest), georeference, compress="lzw")
        if len(raster.index) > 1:
            paths.append(raster.location.raster(root, MIXTURE, layer))
            write_tiff(paths[-1], raster.share[layer - 1], georeference)
    table = raster.location.table(root)
    write_table(table, list(raster.table.values()))
    return [*paths, table]


def _remove_layers(root: Path, location: Tile | ModelTexture) -> None:
    """Remove what an earlier writing left: a layer more than are written now would count as one of them.

    Layers are written from the first and removed from the last: those of an interrupted run follow each other too.
    """
    for component in (INDEX, MIXTURE):
        found = takewhile(Path.exists, (location.raster(root, component, layer) for layer in count(1)))
        for path in reversed(list(found)):
            path.unlink()
