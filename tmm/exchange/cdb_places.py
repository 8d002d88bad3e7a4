"""Places in a CDB: its tiles and its models' textures, by the names of their files and on the globe.

Geocells are one degree high and 1 to 12 degrees wide, by latitude; from level 0 down a tile covers its geocell, and
each finer level halves its sides (OGC 15-113, volume 1, clause 2.1, requirements 11 to 15). Names of files and folders
follow clauses 3.4, 3.6 and 5.6 and the examples in the conformance tests of CDB 1.0.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.gdal import WGS84
from skyshine.tmm.images.georeference import Affine

INDEX, MIXTURE = 1, 2  # component selector 1
TILE_SIDE = 1024  # tile side of levels of detail from 0; each coarser one has half the texels a side
MIN_LOD, MAX_LOD = -10, 23  # levels of detail of OGC CDB 1.2
MAX_LAYERS = 255  # layers of a composite material have one byte
# Width of a geocell in degrees from a latitude on, to north and south (OGC 15-113, volume 1, table 2-2).
_WIDTHS = ((89, 12), (80, 6), (75, 4), (70, 3), (50, 2), (0, 1))

_TILE = re.compile(
    r"(?P<cell>[NS]\d{2}[EW]\d{3})(?:_D\d{3}_S\d{3}_T\d{3})?_(?P<lod>LC?\d{2})_U(?P<up>\d+)_R(?P<right>\d+)"
)
_MODEL = re.compile(r"D504_S\d{3}_T\d{3}_(?P<lod>LC?\d{2})_(?P<name>[^.]+)")
_MODEL_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{1,31}")


def _lod(text: str) -> int:
    return -int(text[2:]) if text.startswith("LC") else int(text[1:])


def lod_name(lod: int) -> str:
    return f"LC{-lod:02d}" if lod < 0 else f"L{lod:02d}"


def geocell_width(south: int) -> int:
    """Width in degrees of the geocells whose southern edge is at a latitude.

    >>> [geocell_width(latitude) for latitude in (49, 50, -50, -51, 89, -90)]
    [1, 2, 1, 2, 12, 12]
    """
    nearest = south if south >= 0 else -south - 1  # the edge towards the equator
    return next(width for latitude, width in _WIDTHS if nearest >= latitude)


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
        return f"{self.cell}_{lod_name(self.lod)}_U{self.up}_R{self.right}"

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """South, west, north and east in degrees."""
        south = int(self.cell[1:3]) * (-1 if self.cell[0] == "S" else 1)
        west = int(self.cell[4:]) * (-1 if self.cell[3] == "W" else 1)
        height, width = (size / (1 << max(self.lod, 0)) for size in (1, geocell_width(south)))
        south_edge, west_edge = south + self.up * height, west + self.right * width
        return south_edge, west_edge, south_edge + height, west_edge + width

    def georeference(self) -> tuple[Affine, str]:
        """Map of its texels to longitude and latitude, and the name of that system."""
        south, west, north, east = self.bounds
        return ((east - west) / self.side, 0.0, west, 0.0, (south - north) / self.side, north), WGS84

    def raster(self, root: Path, component: int, layer: int) -> Path:
        """Path of a raster of the tile in the CDB at `root`."""
        return self._path(root, 5, "005_RMTexture", component, layer, "tif")

    def table(self, root: Path) -> Path:
        """Path of the tile's table in the CDB at `root`."""
        return self._path(root, 6, "006_RMDescriptor", 1, 1, "xml")

    def _path(self, root: Path, dataset: int, folder: str, component: int, layer: int, ending: str) -> Path:
        level = "LC" if self.lod < 0 else lod_name(self.lod)
        file = f"{self.cell}_D{dataset:03d}_S{component:03d}_T{layer:03d}_{lod_name(self.lod)}_U{self.up}_R{self.right}"
        return root / "Tiles" / self.cell[:3] / self.cell[3:] / folder / level / f"U{self.up}" / f"{file}.{ending}"


@dataclass(frozen=True)
class ModelTexture:
    """The place of a model's material texture of one level of detail."""

    name: str
    lod: int

    def raster(self, root: Path, component: int, layer: int) -> Path:
        """Path of a raster of the texture in the CDB at `root`."""
        file = f"D504_S{component:03d}_T{layer:03d}_{lod_name(self.lod)}_{self.name}.tif"
        return self._folder(root, "504_GTModelMaterial") / file

    def table(self, root: Path) -> Path:
        """Path of the table of all levels of detail of the texture in the CDB at `root`."""
        return self._folder(root, "505_GTModelCMT") / f"D505_S001_T001_{self.name}.xml"

    def _folder(self, root: Path, dataset: str) -> Path:
        return root / "GTModel" / dataset / self.name[0].upper() / self.name[1].upper() / self.name


def parse_tile(text: str) -> Tile:
    """The tile that a name such as N12E044_L00_U0_R0 represents.

    Raises InputError: it is no tile's name, or no such tile exists at its level of detail.
    """
    match = _TILE.fullmatch(text)
    if not match:
        raise InputError(f"found the tile '{text}'; allowed: such as N12E044_L00_U0_R0 or S33E151_LC03_U0_R0")
    tile = Tile(match["cell"], _lod(match["lod"]), int(match["up"]), int(match["right"]))
    count = 1 << max(tile.lod, 0)
    if not (MIN_LOD <= tile.lod <= MAX_LOD and tile.up < count and tile.right < count):
        raise InputError(
            f"found the tile '{text}'; allowed: levels LC10 to L23, with U and R below {count} at {lod_name(tile.lod)}"
        )
    return tile


def model_texture(name: str, lod: int) -> ModelTexture:
    """A model texture by name and level of detail.

    Raises InputError: the name or the level is not what CDB allows.
    """
    if not _MODEL_NAME.fullmatch(name):
        raise InputError(f"found the texture name '{name}'; allowed: 2 to 32 letters, digits, _ or -")
    if not MIN_LOD <= lod <= MAX_LOD:
        raise InputError(f"found the level of detail {lod}; allowed: {MIN_LOD} to {MAX_LOD}")
    return ModelTexture(name, lod)


def place_of(file_name: str) -> Tile | ModelTexture:
    """What the name of a raster of indices represents.

    Raises InputError: it is no such name.
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


def locate(path: Path) -> tuple[Tile | ModelTexture, Path]:
    """What a path represents, and the folder of the CDB that it is in."""
    location = place_of(path.name)
    inside = location.raster(Path(), INDEX, 1)
    full = Path(os.path.abspath(path))
    if full.parts[-len(inside.parts) :] != inside.parts:
        raise InputError(f"is not in its place in a CDB; allowed: {inside} below the CDB's folder", file=path)
    return location, Path(*full.parts[: -len(inside.parts)])


def is_placed(path: Path) -> bool:
    """Whether a path is that of a raster of indices in its place in a CDB."""
    try:
        locate(path)
    except InputError:
        return False
    return True
