"""Where a texture lies on the globe: the tiles of a CDB that it touches, and its texels in theirs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import TmmFile
from skyshine.tmm.exchange.cdb_places import MAX_LOD, MIN_LOD, TILE_SIDE, Tile, geocell_width
from skyshine.tmm.images.gdal import WGS84, find_system, transformed
from skyshine.tmm.images.georeference import Affine

# The place of a texel is computed at the nodes of a grid and taken as linear between them. In the whole geocell of
# level 0 a step is 1/32 of a degree, over which a UTM grid bends by 0.1 m at most: a thousandth of a texel.
_STEPS = 32
_BAND = 256  # rows of texels whose places are worked out at a time
_SLACK = 0.25  # slack of a level: texels of a tile may be 1.19 times those of the texture before a finer level is taken
_EDGE_POINTS = 65  # on each side of a texture, whose bent outline limits the tiles that it can touch


@dataclass(frozen=True)
class Geocell:
    """A geocell by its south-western corner in degrees; `west` may lie beyond 180 where a map goes on."""

    south: int
    west: int

    @property
    def width(self) -> int:
        """In degrees."""
        return geocell_width(self.south)

    def tile(self, lod: int, up: int, right: int) -> Tile:
        """A tile of the geocell."""
        west = (self.west + 180) % 360 - 180
        cell = f"{'NS'[self.south < 0]}{abs(self.south):02d}{'EW'[west < 0]}{abs(west):03d}"
        return Tile(cell, lod, up, right)

    def bounds(self, tile: Tile) -> tuple[float, float, float, float]:
        """South, west, north and east of one of its tiles, where the map goes on beyond 180 degrees with it."""
        south, west, north, east = tile.bounds
        turn = self.west - (self.west + 180) % 360 + 180
        return south, west + turn, north, east + turn


class Ground:
    """Where a texture lies on the globe.

    finest : int; level of detail whose texels are about as small as those of the texture.
    """

    def __init__(self, file: TmmFile, path: Path) -> None:
        """Read the place of a texture database.

        Raises InputError: it has none, or one on a map whose projection is not known.
        """
        if "geo_affine" not in file.attributes:
            raise InputError(
                "has no place on a map, which the tiles of a CDB are cut by; classify an image with GeoTIFF tags or a"
                " world file, or name the tile with --tile",
                file=path,
            )
        a, b, c, d, e, f = (float(value) for value in file.attributes["geo_affine"])
        self._affine: Affine = (a, b, c, d, e, f)
        self._system = find_system(str(file.attributes["geo_crs"]), path)
        self._height, self._width = file.height, file.width
        longitude, latitude = self._outline()
        if not (np.isfinite([*longitude, *latitude]).all() and np.abs(latitude).max() <= 90):
            raise InputError("lies beyond latitudes of -90 to 90 degrees; correct its place on the map", file=path)
        self._low, self._high = (longitude.min(), latitude.min()), (longitude.max(), latitude.max())
        if self._high[0] - self._low[0] > 180:
            raise InputError("is more than 180 degrees wide; divide the image", file=path)
        self.finest = self._finest()

    def _finest(self) -> int:
        x, y = self._width / 2 + np.array([[-0.5, 0.5], [0, 0]]), self._height / 2 + np.array([[0, 0], [-0.5, 0.5]])
        longitude, latitude = self.degrees(x, y)
        wide, high = (np.hypot(*np.diff(angle, axis=1).ravel()) for angle in (longitude, latitude))
        south = int(np.clip(np.floor(latitude.mean()), -90, 89))
        smaller = min(high, wide / geocell_width(south))
        return int(np.clip(np.ceil(np.log2(1 / (TILE_SIDE * smaller)) - _SLACK), MIN_LOD, MAX_LOD))

    def degrees(self, x: npt.NDArray[Any], y: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Longitude and latitude of pixel coordinates of level 0."""
        a, b, c, d, e, f = self._affine
        return transformed(self._system, WGS84, a * x + b * y + c, d * x + e * y + f)

    def _outline(self) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        along = np.linspace(0, 1, _EDGE_POINTS)
        ends = np.zeros_like(along)
        x = np.concatenate([along, along, ends, ends + 1]) * self._width
        y = np.concatenate([ends, ends + 1, along, along]) * self._height
        return self.degrees(x, y)

    def geocells(self) -> list[Geocell]:
        """The geocells that the texture may touch, from south to north and west to east."""
        cells = []
        for south in range(max(int(np.floor(self._low[1])), -90), min(int(np.ceil(self._high[1])), 90)):
            width = geocell_width(south)
            west_edge = int(np.floor(self._low[0] / width)) * width
            cells += [Geocell(south, west) for west in range(west_edge, int(np.ceil(self._high[0])), width)]
        return cells

    def touches(self, cell: Geocell, tile: Tile) -> bool:
        """Whether the texture may touch a tile: by the box about its outline."""
        south, west, north, east = cell.bounds(tile)
        (left, low), (right, high) = self._low, self._high
        return bool(south < high and north > low and west < right and east > left)

    def tile_count(self, lod: int) -> int:
        """How many tiles of a level the texture may touch, nearly."""
        count = 1 << max(lod, 0)
        total = 0
        for cell in self.geocells():
            high = min(self._high[1], cell.south + 1) - max(self._low[1], cell.south)
            wide = min(self._high[0], cell.west + cell.width) - max(self._low[0], cell.west)
            total += (int(high * count) + 1) * (int(wide * count / cell.width) + 1)
        return total

    def pixels(self, cell: Geocell, tile: Tile) -> Iterator[tuple[int, npt.NDArray[Any], npt.NDArray[Any]]]:
        """Pixel coordinates of level 0 of the middles of a tile's texels.

        Yields
        ------
        row : int; first row of texels, from the north.
        x, y : (rows, side) float64
        """
        south, west, north, east = cell.bounds(tile)
        steps = min(_STEPS, tile.side)
        at = np.linspace(0, 1, steps + 1)
        longitude, latitude = np.meshgrid(west + at * (east - west), north - at * (north - south))
        nodes = transformed(WGS84, self._system, longitude, latitude)
        a, b, c, d, e, f = self._affine
        u, v = nodes[0] - c, nodes[1] - f
        area = a * e - b * d
        x_nodes, y_nodes = (e * u - b * v) / area, (a * v - d * u) / area
        weights = _linear((np.arange(tile.side) + 0.5) / tile.side * steps, steps)
        for row in range(0, tile.side, _BAND):
            down = weights[row : row + _BAND]
            yield row, down @ x_nodes @ weights.T, down @ y_nodes @ weights.T


def _linear(position: npt.NDArray[np.float64], steps: int) -> npt.NDArray[np.float64]:
    """Weights (N, steps + 1) of nodes at places between 0 and `steps`."""
    weights: npt.NDArray[np.float64] = np.maximum(1 - np.abs(position[:, np.newaxis] - np.arange(steps + 1)), 0)
    return weights
