"""Rays against the triangles of a surface: the first hit, and whether there is any."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.schemas.arrays import Booleans, Floats, Integers

FEW = 8  # triangles up to which all are tested, without the ray caster's package
_START = 1e-6  # fraction of the size of the surface, by which a ray begins before the point that it leaves
_PARALLEL = 1e-12  # share of the product of edges, below which a ray is in the triangle's plane
_EDGE = 1e-9  # beyond its edges a triangle is hit too, so that no ray passes between two
_BLOCK = 1 << 18  # rays traced at a time


@dataclass(frozen=True, eq=False)
class Hits:
    """The first triangle that each of n rays meets.

    Attributes
    ----------
    face : (n,) int array
        -1 where there is none.
    distance : (n,) array
        [m]; infinite where there is none.
    weights : (n, 3) array
        Barycentric weights of the corners at the point; 0 where there is none.
    """

    face: Integers
    distance: Floats
    weights: Floats

    @property
    def met(self) -> Booleans:
        """Rays that meet the surface (n,)."""
        hit: Booleans = self.face >= 0
        return hit


class RayCaster(Protocol):
    """Rays from points (n, 3) [m] in unit directions (n, 3)."""

    def first(self, origin: Floats, direction: Floats) -> Hits:
        """The first triangles met, from either side."""

    def blocked(self, origin: Floats, direction: Floats) -> Booleans:
        """Whether the rays (n,) meet any triangle."""


def ray_caster(surface: SurfaceMesh) -> RayCaster:
    """The ray caster of a surface: Embree, or a plain test of all triangles where they are few.

    Raises
    ------
    ModuleNotFoundError
        embreex is not installed, and the surface has more than `FEW` triangles.
    """
    return FewTriangles(surface) if len(surface.triangles) <= FEW else EmbreeCaster(surface)


def start_height(surface: SurfaceMesh) -> float:
    """Distance [m] above a face at which a ray that leaves it begins, lest it meets the face itself.

    Coordinates are of single precision in Embree: 6e-8 of the size of the surface.
    """
    size = float(np.max(surface.bounds[1] - surface.bounds[0]))
    return max(_START * size, 1e-4)


class FewTriangles:
    """Tests each ray against each triangle (Moller and Trumbore, Journal of Graphics Tools 2, 1997)."""

    def __init__(self, surface: SurfaceMesh) -> None:
        self._corner = surface.triangles[:, 0]
        self._edges = surface.triangles[:, 1:] - surface.triangles[:, :1]

    def first(self, origin: Floats, direction: Floats) -> Hits:
        face = np.full(len(origin), -1)
        distance, weights = np.full(len(origin), np.inf), np.zeros((len(origin), 3))
        for number in range(len(self._corner)):
            length, u, v = self._meet(number, origin, direction)
            nearer = length < distance
            face[nearer], distance[nearer] = number, length[nearer]
            weights[nearer] = np.stack([1 - u - v, u, v], axis=-1)[nearer]
        return Hits(face, distance, weights)

    def blocked(self, origin: Floats, direction: Floats) -> Booleans:
        return self.first(origin, direction).met

    def _meet(self, number: int, origin: Floats, direction: Floats) -> tuple[Floats, Floats, Floats]:
        """Distance to one triangle, infinite where it is missed, and the weights of its last two corners."""
        edge, second = self._edges[number]
        normal = np.cross(direction, second)
        determinant = normal @ edge
        scale = np.linalg.norm(edge) * np.linalg.norm(second)
        inside = np.abs(determinant) > _PARALLEL * scale
        inverse = np.divide(1.0, determinant, out=np.zeros_like(determinant), where=inside)
        start = origin - self._corner[number]
        u = np.sum(start * normal, axis=-1) * inverse
        across = np.cross(start, edge)
        v = np.sum(direction * across, axis=-1) * inverse
        length = across @ second * inverse
        inside &= (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE) & (length > 0)
        return np.where(inside, length, np.inf), u, v


class EmbreeCaster:
    """Embree through embreex, in coordinates from the middle of the surface, which are of single precision there."""

    def __init__(self, surface: SurfaceMesh) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._middle = surface.bounds.mean(axis=0)
        self._scene: Any = EmbreeScene(robust=True)
        corners = (surface.triangles - self._middle).astype(np.float32)
        self._mesh = TriangleMesh(
            scene=self._scene,
            vertices=np.ascontiguousarray(corners.reshape(-1, 3)),
            indices=np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3),
        )

    def first(self, origin: Floats, direction: Floats) -> Hits:
        parts = [
            self._scene.run(start, ahead, query="INTERSECT", output=True)
            for start, ahead in self._pieces(origin, direction)
        ]
        face = np.concatenate([part["primID"] for part in parts]).astype(int)
        distance, u, v = (np.concatenate([part[name] for part in parts]).astype(float) for name in ("tfar", "u", "v"))
        hit = face >= 0
        weights = np.where(hit[:, None], np.stack([1 - u - v, u, v], axis=-1), 0.0)
        return Hits(face, np.where(hit, distance, np.inf), weights)

    def blocked(self, origin: Floats, direction: Floats) -> Booleans:
        parts = [self._scene.run(start, ahead, query="OCCLUDED") for start, ahead in self._pieces(origin, direction)]
        blocked: Booleans = np.concatenate(parts) >= 0
        return blocked

    def _pieces(
        self, origin: Floats, direction: Floats
    ) -> list[tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]:
        start = (np.asarray(origin, float) - self._middle).astype(np.float32)
        ahead = np.ascontiguousarray(direction, np.float32)
        count = max(len(start), 1)
        return [(start[begin : begin + _BLOCK], ahead[begin : begin + _BLOCK]) for begin in range(0, count, _BLOCK)]
