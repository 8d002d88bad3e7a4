"""What the pixels of a frame see: points of the surface, their direction and their materials."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from skyshine.mat.quantities.lines_of_sight import slope_and_azimuth
from skyshine.mat.render.camera import ViewRays
from skyshine.mat.render.rays import RayCaster, start_height
from skyshine.mat.render.surface import Mixtures, SurfaceMaterials
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.schemas.arrays import Floats, Integers

_GRAZING = 0.01  # least cosine by which a pixel's footprint is widened


@dataclass(frozen=True, eq=False)
class SeenSurface:
    """The n pixels of a frame that meet the surface.

    Attributes
    ----------
    pixel : (n,) int array
        Number in the frame, row by row from the top.
    face : (n,) int array
        Number of the triangle.
    weights : (n, 3) array
        Barycentric weights of its corners, at the point.
    point, normal : (n, 3) array
        [m], and the unit normal on the side of the observer; to east, north and up.
    start : (n, 3) array
        Slightly above the point, where rays that leave it begin [m].
    range : (n,) array
        [km]
    slope, azimuth : (n,) array
        Orientation of the face [degree].
    altitude : (n,) array
        Altitude of the point [km].
    """

    pixel: Integers
    face: Integers
    weights: Floats
    point: Floats
    normal: Floats
    start: Floats
    range: Floats
    slope: Floats
    azimuth: Floats
    altitude: Floats
    materials: Mixtures

    @classmethod
    def of(cls, rays: ViewRays, surface: SurfaceMesh, materials: SurfaceMaterials, caster: RayCaster) -> SeenSurface:
        """Trace the rays of a frame.

        Raises
        ------
        InputError
            A texel that is seen has no material.
        """
        hits = caster.first(rays.origin, rays.direction)
        pixel = np.flatnonzero(hits.met)
        face, weights, distance = hits.face[pixel], hits.weights[pixel], hits.distance[pixel]
        ahead = rays.direction[pixel]
        normal = surface.normal[face]
        towards = -np.sum(normal * ahead, axis=-1)
        normal = np.where(towards[:, None] < 0, -normal, normal)
        point = surface.points(face, weights)
        slope, azimuth = slope_and_azimuth(normal)
        side = rays.side + rays.spread[pixel] * distance
        # An oblique face shows more of its texture in one direction: the mean of both sides of the footprint.
        footprint = side / np.sqrt(np.maximum(np.abs(towards), _GRAZING))
        return cls(
            pixel,
            face,
            weights,
            point,
            normal,
            point + normal * start_height(surface),
            distance * 1e-3,
            slope,
            azimuth,
            surface.altitude + point[:, 2] * 1e-3,
            materials.at(face, weights, footprint),
        )

    def take(self, rows: Integers) -> SeenSurface:
        """Some of them."""
        mixtures = self.materials
        parts = {field.name: getattr(self, field.name)[rows] for field in fields(self) if field.name != "materials"}
        return SeenSurface(
            **parts, materials=replace(mixtures, number=mixtures.number[rows], share=mixtures.share[rows])
        )

    def __len__(self) -> int:
        return self.pixel.size
