"""Temperatures at the vertices of faces alone, as the runtime of DSTO-TN-0193 has them (section 2.1.2)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from skyshine.mat.render.rays import start_height
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface import Mixtures, SurfaceMaterials
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.mat.render.temperatures import SeenTemperatures
from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.mat.tables.band import BandTable
from skyshine.schemas.arrays import Floats, Integers

VertexTexel = Literal["centre", "nearest"]

# Weights of the corners at a vertex: slightly inside its face, whose texture may repeat or end at the edge, and beside
# which another face may be that hides the sky of the very edge.
_INSIDE = 1e-3
_CORNERS = (1 - 3 * _INSIDE) * np.eye(3) + _INSIDE
_CENTRE = np.full(3, 1 / 3)


@dataclass(frozen=True, eq=False)
class SeenVertices:
    """The vertices of the faces that n pixels of a frame see.

    Attributes
    ----------
    points : SeenSurface
        k faces as 3 k points, the three vertices of each in turn; each of one material.
    first : (n,) int array
        Row in `points` of the first vertex of the face of each pixel.
    weights : (n, 3) array
        Barycentric weights of the three vertices at each pixel; they sum to 1.
    """

    points: SeenSurface
    first: Integers
    weights: Floats

    @classmethod
    def of(
        cls, pixels: SeenSurface, surface: SurfaceMesh, materials: SurfaceMaterials, texel: VertexTexel
    ) -> SeenVertices:
        """Find the vertices and their materials.

        Parameters
        ----------
        seen, surface, materials
        texel : {'centre', 'nearest'}
            Texel whose material a vertex has: in the centre of its face, or nearest to the vertex.

        Raises
        ------
        InputError
            A texel has no material, and the scene names none for such texels.
        """
        # A face seen from both sides counts twice: the normal is on the observer's side.
        side = np.sum(pixels.normal * surface.normal[pixels.face], axis=-1) < 0
        _, pixel, number = np.unique(2 * pixels.face + side, return_index=True, return_inverse=True)
        rows = np.repeat(pixel, 3)
        face, normal = pixels.face[rows], pixels.normal[rows]
        weights = np.tile(_CORNERS, (pixel.size, 1))
        point = surface.points(face, weights)
        read = weights if texel == "nearest" else np.tile(_CENTRE, (rows.size, 1))
        points = replace(
            pixels,
            pixel=rows,
            face=face,
            weights=weights,
            point=point,
            normal=normal,
            start=point + normal * start_height(surface),
            range=pixels.range[rows],
            slope=pixels.slope[rows],
            azimuth=pixels.azimuth[rows],
            altitude=surface.altitude + point[:, 2] * 1e-3,
            materials=_largest(materials.at(face, read, np.zeros(rows.size))),
        )
        return cls(points, 3 * number.ravel(), pixels.weights)

    def temperature(self, at_vertices: SeenTemperatures, hour: int, band: BandTable) -> Floats:
        """Temperatures (n, 1) [K] of black bodies with the band radiance that is interpolated from the vertices.

        Parameters
        ----------
        at_vertices : SeenTemperatures
            Temperatures of `points`.
        hour : int
            Number of one of its hours.
        band : BandTable
        """
        blackbody = band.blackbody_radiance(at_vertices.at(hour)[:, 0]).reshape(-1, 3)
        return equivalent_temperature(band, np.sum(self.weights * blackbody[self.first // 3], axis=-1))[:, None]


def _largest(mixtures: Mixtures) -> Mixtures:
    """Points of the one material that has the largest share of each."""
    part = mixtures.share.argmax(axis=-1)[:, None]
    return Mixtures(mixtures.names, np.take_along_axis(mixtures.number, part, axis=-1), np.ones(part.shape))
