"""A plan of a scene as triangles: level, or over the heights of an image."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import tifffile

from skyshine.mat.render.scene_file import HeightMap, LoadedScene, Plan
from skyshine.mat.render.surface_mesh import Covering, SurfaceMesh, surface_of
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.images.raster import read_channels

MAX_HEIGHTS = 1 << 23  # samples of a height map, for memory
_NODATA_TAG = 42113  # GDAL_NODATA, of GeoTIFF files


def plan_surface(scene: LoadedScene, plan: Plan) -> SurfaceMesh:
    """The surface of a plan; its centre is the origin.

    Raises
    ------
    InputError
        The texture or the height map cannot be read, or heights are missing.
    """
    with open_tmm(plan.texture) as texture:
        width, height = texture.width * plan.metres_per_texel, texture.height * plan.metres_per_texel
    across, down, heights = np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.zeros((2, 2))
    if plan.height_map is not None:
        values = _heights(plan.height_map)
        across, down = (_nodes(count) for count in values.shape[::-1])
        heights = np.pad(values, 1, mode="edge")
    u, v = np.meshgrid(across, down)
    points = np.stack([(u - 0.5) * width, (0.5 - v) * height, heights], axis=-1)
    points = turned(points, plan.top_azimuth_deg)
    key = ("surface", "plan", "texture")
    triangles, uv = _cells(points), _cells(np.stack([u, v], axis=-1))
    covering = Covering(None, plan.texture, key)
    numbers = np.zeros(len(triangles), int)
    return surface_of(triangles, numbers, (covering,), uv, scene.model.surface.altitude_km, plan.texture)


def turned(points: Floats, azimuth: float) -> Floats:
    """Points (..., 3) whose north is turned to an azimuth [degree]."""
    angle = np.radians(azimuth)
    east = points[..., 0] * np.cos(angle) + points[..., 1] * np.sin(angle)
    north = points[..., 1] * np.cos(angle) - points[..., 0] * np.sin(angle)
    return np.stack([east, north, points[..., 2]], axis=-1)


def _nodes(count: int) -> Floats:
    """Places of the values of a row in the image, 0 to 1: the middles of its texels, and its two borders."""
    return np.concatenate([[0.0], (np.arange(count) + 0.5) / count, [1.0]])


def _cells(grid: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Two triangles of each cell of a grid (h, w, x), rows from the top, counterclockwise from above: (F, 3, x)."""
    top_left, top_right, low_left, low_right = grid[:-1, :-1], grid[:-1, 1:], grid[1:, :-1], grid[1:, 1:]
    lower = np.stack([top_left, low_left, low_right], axis=-2)
    second = np.stack([top_left, low_right, top_right], axis=-2)
    return np.stack([lower, second], axis=2).reshape(-1, 3, grid.shape[-1])


def _heights(height_map: HeightMap) -> Floats:
    """Heights (h, w) [m] of an image."""
    path = height_map.image
    stored, nodata = _tiff(path) if path.suffix.lower() in (".tif", ".tiff") else (read_channels(path), None)
    values = np.asarray(stored, float)
    values = values[..., 0] if values.ndim == 3 and values.shape[-1] == 1 else values
    if values.ndim != 2:
        raise InputError(f"has the shape {np.shape(stored)}; allowed: one channel of heights; save it so", file=path)
    if values.size > MAX_HEIGHTS:
        raise InputError(f"has {values.size} heights; allowed: at most {MAX_HEIGHTS}; thin it", file=path)
    missing = ~np.isfinite(values) if nodata is None else ~np.isfinite(values) | (values == nodata)
    if missing.any():
        row, column = np.argwhere(missing)[0]
        raise InputError(
            f"has {missing.sum()} places without height, the first in row {row}, column {column}; allowed: finite"
            " heights everywhere; fill them",
            file=path,
        )
    heights: Floats = values * height_map.metres_per_value + height_map.metres_at_zero
    return heights


def _tiff(path: Path) -> tuple[npt.NDArray[Any], float | None]:
    """Numbers of a TIFF file as they are stored, and the one that marks no data."""
    try:
        with tifffile.TiffFile(path) as file:
            page = file.pages[0]
            tag = getattr(page, "tags", {}).get(_NODATA_TAG)
            nodata = None if tag is None else float(str(tag.value).strip("\0 "))
            return np.asarray(page.asarray()), nodata
    except (tifffile.TiffFileError, ValueError, OSError, IndexError, RuntimeError) as error:
        raise InputError(f"is no TIFF file of heights ({error}); save it again", file=path) from None
