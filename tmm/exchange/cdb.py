"""Raster materials of OGC CDB: tiles (datasets 005 and 006) and textures of geotypical models (504 and 505).

Component selector 1 is 001 for indices into the Composite Material Table and 002 for the share of that material;
selector 2 is the layer, from 001. Indices are unsigned integers in LZW-compressed TIFF, shares floats from 0 to 1 in
plain TIFF, as OGC 15-113 (volume 1, clauses 3.4, 3.6 and 5.6) has integers compressed and floats not. File and folder
names follow the same clauses and the examples in the OGC conformance tests of CDB 1.0.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import COMPONENTS, WEIGHT_TOTAL, Level, integer_weights
from skyshine.tmm.exchange.cdb_materials import CdbMaterials
from skyshine.tmm.exchange.cdb_table import Composite, read_table, write_table
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.rasters import read_plane, write_tiff

INDEX, MIXTURE = 1, 2  # component selector 1
TILE_SIDE = 1024  # of levels of detail from 0; each coarser one has half the texels a side
MIN_LOD, MAX_LOD = -10, 23
MAX_LAYERS = 255
_SHARE_UNIT = 1_000_000  # shares are ranked and scaled as integers

_TILE = re.compile(
    r"(?P<cell>[NS]\d{2}[EW]\d{3})(?:_D\d{3}_S\d{3}_T\d{3})?_(?P<lod>LC?\d{2})_U(?P<up>\d+)_R(?P<right>\d+)"
)
_MODEL = re.compile(r"D504_S\d{3}_T\d{3}_(?P<lod>LC?\d{2})_(?P<name>[^.]+)")
_MODEL_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{1,31}")


def _lod(text: str) -> int:
    return -int(text[2:]) if text.startswith("LC") else int(text[1:])


def _lod_name(lod: int) -> str:
    return f"LC{-lod:02d}" if lod < 0 else f"L{lod:02d}"


@dataclass(frozen=True)
class Tile:
    """The place of a tile, such as N12E044_L00_U0_R0."""

    cell: str
    lod: int
    up: int
    right: int

    @property
    def side(self) -> int:
        """Texels a side."""
        return TILE_SIDE >> max(-self.lod, 0)

    @property
    def name(self) -> str:
        return f"{self.cell}_{_lod_name(self.lod)}_U{self.up}_R{self.right}"

    def raster(self, root: Path, component: int, layer: int) -> Path:
        """Path of a raster of the tile in the CDB at `root`."""
        return self._path(root, 5, "005_RMTexture", component, layer, "tif")

    def table(self, root: Path) -> Path:
        """Path of the tile's table in the CDB at `root`."""
        return self._path(root, 6, "006_RMDescriptor", 1, 1, "xml")

    def _path(self, root: Path, dataset: int, folder: str, component: int, layer: int, ending: str) -> Path:
        level = "LC" if self.lod < 0 else _lod_name(self.lod)
        file = (
            f"{self.cell}_D{dataset:03d}_S{component:03d}_T{layer:03d}_{_lod_name(self.lod)}_U{self.up}_R{self.right}"
        )
        return root / "Tiles" / self.cell[:3] / self.cell[3:] / folder / level / f"U{self.up}" / f"{file}.{ending}"


@dataclass(frozen=True)
class ModelTexture:
    """The place of a model's material texture of one level of detail."""

    name: str
    lod: int

    def raster(self, root: Path, component: int, layer: int) -> Path:
        """Path of a raster of the texture in the CDB at `root`."""
        file = f"D504_S{component:03d}_T{layer:03d}_{_lod_name(self.lod)}_{self.name}.tif"
        return self._folder(root, "504_GTModelMaterial") / file

    def table(self, root: Path) -> Path:
        """Path of the table of all levels of detail of the texture in the CDB at `root`."""
        return self._folder(root, "505_GTModelCMT") / f"D505_S001_T001_{self.name}.xml"

    def _folder(self, root: Path, dataset: str) -> Path:
        return root / "GTModel" / dataset / self.name[0].upper() / self.name[1].upper() / self.name


def parse_tile(text: str) -> Tile:
    """The tile that a name such as N12E044_L00_U0_R0 stands for.

    Raises
    ------
    InputError
        It is no tile's name, or no such tile exists at its level of detail.
    """
    match = _TILE.fullmatch(text)
    if not match:
        raise InputError(f"found the tile '{text}'; allowed: such as N12E044_L00_U0_R0 or S33E151_LC03_U0_R0")
    tile = Tile(match["cell"], _lod(match["lod"]), int(match["up"]), int(match["right"]))
    count = 1 << max(tile.lod, 0)
    if not (MIN_LOD <= tile.lod <= MAX_LOD and tile.up < count and tile.right < count):
        raise InputError(
            f"found the tile '{text}'; allowed: levels LC10 to L23, with U and R below {count} at {_lod_name(tile.lod)}"
        )
    return tile


def model_texture(name: str, lod: int) -> ModelTexture:
    """A model texture by name and level of detail.

    Raises
    ------
    InputError
        The name or the level is not what CDB allows.
    """
    if not _MODEL_NAME.fullmatch(name):
        raise InputError(f"found the texture name '{name}'; allowed: 2 to 32 letters, digits, _ or -")
    if not MIN_LOD <= lod <= MAX_LOD:
        raise InputError(f"found the level of detail {lod}; allowed: {MIN_LOD} to {MAX_LOD}")
    return ModelTexture(name, lod)


@dataclass(frozen=True)
class CdbRaster:
    """Raster materials as CDB has them.

    Attributes
    ----------
    place : Tile or ModelTexture
    index : (L, H, W) integer
        Index into the table of each layer; 0 for the default, which is no material unless the table has it.
    share : (L, H, W) float32
        Share of each layer's material.
    table : dict of int to Composite
    """

    place: Tile | ModelTexture
    index: npt.NDArray[Any]
    share: npt.NDArray[Any]
    table: dict[int, Composite]


def read_cdb(path: str | os.PathLike[str]) -> CdbRaster:
    """Read a raster of dataset 005 or 504 with its other layers, its shares and its table.

    Parameters
    ----------
    path : path
        Its first layer of indices, ``..._D005_S001_T001_....tif`` or ``D504_S001_T001_....tif``, in its place in a CDB.

    Raises
    ------
    InputError
        A file is missing or damaged, layers differ in size, or an index is not in the table.
    """
    path = Path(path)
    place, root = _locate(path)
    layers = [read_plane(path)]
    while len(layers) < MAX_LAYERS and place.raster(root, INDEX, len(layers) + 1).is_file():
        layers.append(read_plane(place.raster(root, INDEX, len(layers) + 1)))
    shares = [_share(place.raster(root, MIXTURE, k + 1), layer, len(layers)) for k, layer in enumerate(layers)]
    for layer in layers:
        if layer.shape != layers[0].shape or layer.dtype.kind != "u":
            raise InputError(
                "has layers of different sizes, or of other than unsigned integers; write them again", file=path
            )
    table = read_table(place.table(root))
    index = np.stack(layers)
    missing = sorted(set(np.unique(index).tolist()) - {0} - set(table))
    if missing:
        raise InputError(
            f"has the index {missing[0]}, which {place.table(root).name} has not; allowed:"
            f" {', '.join(map(str, table))}",
            file=path,
        )
    return CdbRaster(place, index, np.stack(shares), table)


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


def place_of(file_name: str) -> Tile | ModelTexture:
    """What the name of a raster of indices stands for.

    Raises
    ------
    InputError
        It is no such name.
    """
    stem = Path(file_name).stem
    tile, model = _TILE.fullmatch(stem), _MODEL.fullmatch(stem)
    if tile and "_D005_" in stem:
        return Tile(tile["cell"], _lod(tile["lod"]), int(tile["up"]), int(tile["right"]))
    if model:
        return ModelTexture(model["name"], _lod(model["lod"]))
    raise InputError(
        "is not named as a CDB raster; allowed: such as N12E044_D005_S001_T001_L00_U0_R0.tif or"
        " D504_S001_T001_L04_Wall.tif",
        file=file_name,
    )


def _locate(path: Path) -> tuple[Tile | ModelTexture, Path]:
    """What a path stands for, and the folder of the CDB that it is in."""
    place = place_of(path.name)
    inside = place.raster(Path(), INDEX, 1)
    full = Path(os.path.abspath(path))
    if full.parts[-len(inside.parts) :] != inside.parts:
        raise InputError(f"is not in its place in a CDB; allowed: {inside} below the CDB's folder", file=path)
    return place, Path(*full.parts[: -len(inside.parts)])


def to_image(raster: CdbRaster, materials: CdbMaterials) -> MaterialImage:
    """The three materials of ours with the largest shares in each texel.

    Raises
    ------
    InputError
        A composite in use has no counterpart among our materials.
    """
    mixtures = {k: materials.mixture(raster.table[k]) for k in np.unique(raster.index).tolist() if k in raster.table}
    codes = sorted({code for mixture in mixtures.values() for code in mixture})
    shares = np.zeros((len(codes), *raster.index.shape[1:]), np.float32)
    for row, code in enumerate(codes):
        by_index = np.zeros(int(raster.index.max()) + 1, np.float32)
        for index, mixture in mixtures.items():
            by_index[index] = mixture.get(code, 0.0)
        for index, share in zip(raster.index, raster.share, strict=True):
            shares[row] += by_index[index] * share
    names = {code: materials.library.by_code(code).name for code in codes}
    name = raster.place.name
    return MaterialImage(name, names, ranked_level(np.array(codes, np.uint16), shares))


def ranked_level(codes: npt.NDArray[np.uint16], shares: npt.NDArray[Any]) -> Level:
    """A level of the largest shares (K, H, W) of materials whose codes (K,) ascend."""
    size = shares.shape[1:]
    counts = np.zeros((COMPONENTS, int(np.prod(size))), np.int64)
    ranked = np.zeros_like(counts)
    if codes.size:
        flat = shares.reshape(codes.size, -1)
        order = np.argsort(-flat, axis=0, kind="stable")[:COMPONENTS]
        counts[: len(order)] = np.rint(np.take_along_axis(flat, order, 0) * _SHARE_UNIT)
        ranked[: len(order)] = codes[order]
    weights = integer_weights(counts, WEIGHT_TOTAL)
    ranked[(weights == 0) | (counts == 0)] = 0
    mix_code, mix_weight = (
        np.ascontiguousarray(part.T).reshape(*size, COMPONENTS).astype(np.uint16) for part in (ranked, weights)
    )
    return Level(mix_code[..., 0].copy(), mix_code, mix_weight)


def used_codes(image: MaterialImage) -> list[int]:
    """Codes of the materials that some texel has, ascending."""
    return sorted(set(np.unique(image.level.mix_code[image.level.mix_weight > 0]).tolist()) - {0})


def from_image(
    image: MaterialImage, place: Tile | ModelTexture, materials: CdbMaterials, codes: list[int] | None = None
) -> CdbRaster:
    """Our materials as layers of composite materials, indices from 1 in the order of the codes.

    Parameters
    ----------
    codes : list of int, optional
        The materials of the table, ascending; by default those in use.

    Raises
    ------
    InputError
        The size is not the place's, or a material has no composite in the map.
    """
    _check_size(image, place)
    level = image.level
    used = used_codes(image) if codes is None else codes
    table = {k: materials.composite(image.materials[code], k) for k, code in enumerate(used, 1)}
    lookup = np.zeros(max(used, default=0) + 1, np.uint8 if len(used) < 256 else np.uint16)
    lookup[used] = np.arange(1, len(used) + 1)
    index = np.stack([lookup[level.mix_code[..., k]] for k in range(image.layers)])
    weight = np.moveaxis(level.mix_weight[..., : image.layers], -1, 0)
    return CdbRaster(place, index, (weight / np.float32(WEIGHT_TOTAL)).astype(np.float32), table)


def _check_size(image: MaterialImage, place: Tile | ModelTexture) -> None:
    size = f"{image.width} x {image.height}"
    if isinstance(place, Tile) and (image.height, image.width) != (place.side, place.side):
        raise InputError(
            f"'{image.name}' is {size}; allowed for a tile of {_lod_name(place.lod)}: {place.side} x {place.side};"
            " resample the texture to the tile's texels, or name another level of detail"
        )
    if isinstance(place, ModelTexture) and any(n & (n - 1) for n in (image.height, image.width)):
        raise InputError(f"'{image.name}' is {size}; allowed for a model texture: powers of two; resample the texture")


def write_cdb(root: str | os.PathLike[str], raster: CdbRaster) -> list[Path]:
    """Write indices, shares where there are several layers, and the table into a CDB.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        There is nothing to write in the table, it breaks the schema, or a file cannot be written.
    """
    root = Path(root)
    if not raster.table:
        raise InputError(
            f"'{raster.place.name}' has no texel with a material; a Composite Material Table cannot be empty"
        )
    _remove_layers(root, raster.place)
    written = []
    for layer, index in enumerate(raster.index, 1):
        smallest = np.uint8 if index.max() < 256 else np.uint16
        written.append(raster.place.raster(root, INDEX, layer))
        write_tiff(written[-1], index.astype(smallest))
        if len(raster.index) > 1:
            written.append(raster.place.raster(root, MIXTURE, layer))
            write_tiff(written[-1], raster.share[layer - 1])
    table = raster.place.table(root)
    write_table(table, list(raster.table.values()))
    return [*written, table]


def _remove_layers(root: Path, place: Tile | ModelTexture) -> None:
    """Remove what an earlier writing left: a layer more than are written now would count as one of them."""
    for component in (INDEX, MIXTURE):
        for layer in range(1, MAX_LAYERS + 1):
            place.raster(root, component, layer).unlink(missing_ok=True)
