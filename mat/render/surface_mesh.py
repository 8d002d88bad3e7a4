"""The surface of a scene as triangles with their materials, slopes and azimuths."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.lines_of_sight import slope_and_azimuth
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

MAX_TRIANGLES = 1 << 24  # for memory
# A part of a mesh: material, corners (F, 3, 3), texture coordinates (F, 3, 2) from the top left corner.
MeshPart = tuple[str, Floats, Floats | None]

LEAST_AREA = 1e-12  # m^2 below which a triangle has no direction


@dataclass(frozen=True)
class Covering:
    """What covers some of the triangles: one material, or a texture of materials.

    Attributes
    ----------
    texture : Path or None
        A ``.tmm.h5`` file.
    place : tuple
        Path of the key of the scene file that names it, for errors.
    """

    material: str | None
    texture: Path | None
    place: tuple[str | int, ...]


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """F triangles; none of them without area.

    Attributes
    ----------
    triangles : (F, 3, 3) array
        Corners, then east, north and up [m].
    covering : (F,) int array
        Index into `coverings`.
    uv : (F, 3, 2) array
        Texture coordinates of the corners, from the top left corner of the image; 0 where there is no texture.
    altitude : float
        Altitude of height 0 [km].
    """

    triangles: Floats
    covering: Integers
    coverings: tuple[Covering, ...]
    uv: Floats
    altitude: float

    @cached_property
    def normal(self) -> Floats:
        """Unit normals (F, 3), to the side from which the corners go round counterclockwise."""
        cross = _cross(self.triangles)
        normal: Floats = cross / np.linalg.norm(cross, axis=-1, keepdims=True)
        return normal

    @cached_property
    def area(self) -> Floats:
        """(F,) [m^2]"""
        area: Floats = 0.5 * np.linalg.norm(_cross(self.triangles), axis=-1)
        return area

    @property
    def slope(self) -> Floats:
        """(F,) of the normals from the zenith [degree]."""
        return slope_and_azimuth(self.normal)[0]

    @property
    def azimuth(self) -> Floats:
        """(F,) to which the normals point, from north eastward [degree]; 0 for level triangles."""
        return slope_and_azimuth(self.normal)[1]

    @cached_property
    def bounds(self) -> Floats:
        """Least and greatest east, north and up, (2, 3) [m]."""
        corners = self.triangles.reshape(-1, 3)
        bounds: Floats = np.stack([corners.min(axis=0), corners.max(axis=0)])
        return bounds

    @property
    def altitudes(self) -> tuple[float, float]:
        """Altitudes of the lowest and the highest corner [km]."""
        low, high = self.altitude + self.bounds[:, 2] * 1e-3
        return float(low), float(high)

    def points(self, face: Integers, weights: Floats) -> Floats:
        """Points (n, 3) [m] on faces (n,) with weights (n, 3) of their corners."""
        points: Floats = np.einsum("nc,ncx->nx", weights, self.triangles[face])
        return points

    def texture_coordinates(self, face: Integers, weights: Floats) -> Floats:
        """Texture coordinates (n, 2) there."""
        coordinates: Floats = np.einsum("nc,ncx->nx", weights, self.uv[face])
        return coordinates


def surface_of(
    triangles: npt.ArrayLike,
    covering: npt.ArrayLike,
    coverings: tuple[Covering, ...],
    uv: npt.ArrayLike,
    altitude: float,
    file: Path,
) -> SurfaceMesh:
    """A surface without the triangles that have no area.

    Raises
    ------
    InputError
        No triangle has an area, or a corner is not finite.
    """
    corners, coordinates = np.asarray(triangles, float).reshape(-1, 3, 3), np.asarray(uv, float).reshape(-1, 3, 2)
    if not np.all(np.isfinite(corners)) or not np.all(np.isfinite(coordinates)):
        raise InputError("has a corner whose place is not finite; repair the file", file=file)
    nonempty = 0.5 * np.linalg.norm(_cross(corners), axis=-1) > LEAST_AREA
    if not nonempty.any():
        raise InputError("has no triangle with an area; allowed: at least one; name another file", file=file)
    return SurfaceMesh(
        corners[nonempty], np.asarray(covering, int)[nonempty], coverings, coordinates[nonempty], altitude
    )


def _cross(triangles: Floats) -> Floats:
    cross: Floats = np.cross(triangles[..., 1, :] - triangles[..., 0, :], triangles[..., 2, :] - triangles[..., 0, :])
    return cross
