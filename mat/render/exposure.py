"""Shade through the day and open sky of points of a surface, by rays to the Sun and to the sky."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.quantities.lines_of_sight import direction
from skyshine.mat.render.rays import RayCaster
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.mat.render.walls import WallKinds
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.progress import Advance, Progress, silent

SKY_RAYS = 64  # sky rays of the hemisphere above a point: 1 / 64 of the sky each
_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))  # golden angle of Vogel's spiral, Mathematical Biosciences 44, 1979


@dataclass(frozen=True, eq=False)
class SeenExposure:
    """Exposure of n points.

    Attributes
    ----------
    shaded : (n, T) bool array
        Whether the surface hides the Sun at each step of the day; False where the face is turned away from it, or
        where it is below the horizon.
    sky_view : (n,) array
        Open share of the sky above each face, 0 to 1; 1 where it faces no sky.
    walls : (n, K) array
        Share of the hidden sky that is hidden by each wall of `WallKinds`; what is left of 1 is not known.
    """

    shaded: Booleans
    sky_view: Floats
    walls: Floats

    def before(self, count: int) -> SeenExposure:
        """The same with shares of `count` walls: those of walls that hide none of this sky are 0."""
        return replace(self, walls=np.pad(self.walls, ((0, 0), (0, count - self.walls.shape[1]))))

    def of_mixtures(self, shares: Floats, shaded_sky: Floats) -> tuple[Floats, Floats]:
        """Share of the direct light that the materials of each point let fall on them, and the open share of their sky,
        (n,) each: means over the materials.

        Parameters
        ----------
        shares : (n, M) array
            Area fractions of the materials; they sum to 1.
        shaded_sky : (n, M) array
            Open share of the sky above those that are in the shade all day; not a number for others.
        """
        shade = np.where(np.isnan(shaded_sky), 0.0, shares)
        hidden_sky = self.sky_view[:, None] - np.fmin(self.sky_view[:, None], shaded_sky)
        lit_share: Floats = np.clip(1.0 - shade.sum(axis=-1), 0.0, 1.0)
        view: Floats = np.clip(self.sky_view - np.sum(shares * hidden_sky, axis=-1), 0.0, 1.0)
        return lit_share, view


def exposure_of(
    points: SeenSurface,
    surface: SurfaceMesh,
    caster: RayCaster,
    sun_elevation: Floats,
    sun_azimuth: Floats,
    progress: Progress = silent,
    kinds: WallKinds | None = None,
) -> SeenExposure:
    """Trace the shadows of a day and the open sky.

    Parameters
    ----------
    seen, surface, caster
    sun_elevation, sun_azimuth : (T,) array
        Direction of the Sun at steps of the day [degree].
    kinds : WallKinds, optional
        Register of the walls that hide the sky; without it walls are not recorded.
    """
    shaded, view = np.zeros((len(points), sun_elevation.size), bool), np.ones(len(points))
    walls = np.zeros((len(points), 0))
    if not _is_flat(surface):
        with progress(sun_elevation.size + SKY_RAYS, "tracing shadows") as advance:
            for step, sun in enumerate(direction(sun_elevation, sun_azimuth)):
                if sun_elevation[step] > 0:
                    shaded[:, step] = hidden(points, caster, sun)
                advance(1)
            view, walls = open_sky(points, caster, kinds, advance)
    return SeenExposure(shaded, view, walls)


def open_sky(
    points: SeenSurface, caster: RayCaster, kinds: WallKinds | None, advance: Advance = lambda steps: None
) -> tuple[Floats, Floats]:
    """Open share of the sky above each face (n,), and shares of the rest that walls hide (n, K)."""
    above, unblocked = np.zeros(len(points)), np.zeros(len(points))
    blocked_by: dict[int, Floats] = {}
    tangent, second = _tangents(points.normal)
    for across, along, up in _cosine_directions():
        ray = across * tangent + along * second + up * points.normal
        rows = np.flatnonzero(ray[:, 2] > 0)
        above[rows] += 1
        if kinds is None:
            unblocked[rows] += ~caster.blocked(points.start[rows], ray[rows])
        else:
            hits = caster.first(points.start[rows], ray[rows])
            unblocked[rows] += ~hits.met
            hit_rows = rows[hits.met]
            wall = kinds.of(hits.face[hits.met], ray[hit_rows])
            for number in np.unique(wall[wall >= 0]):
                count = blocked_by.setdefault(int(number), np.zeros(len(points), np.float32))
                count[hit_rows[wall == number]] += 1
        advance(1)
    view = np.divide(unblocked, above, out=np.ones(len(points)), where=above > 0)
    counts = np.zeros((len(points), 0 if kinds is None else len(kinds)))
    for number, count in blocked_by.items():
        counts[:, number] = count
    return view, counts / np.maximum(above - unblocked, 1)[:, None]


def hidden(points: SeenSurface, caster: RayCaster, towards: Floats) -> Booleans:
    """Points (n,) from which the surface hides a direction (3,) to which their faces are turned."""
    result = np.zeros(len(points), bool)
    rows = np.flatnonzero(points.normal @ towards > 0)
    result[rows] = caster.blocked(points.start[rows], np.broadcast_to(towards, (rows.size, 3)))
    return result


def _is_flat(surface: SurfaceMesh) -> bool:
    """Whether all triangles lie in one plane, so that none hides the sky from another."""
    base = surface.triangles[0, 0]
    size = float(np.max(surface.bounds[1] - surface.bounds[0]))
    height = (surface.triangles - base) @ surface.normal[0]
    return bool(np.all(np.abs(height) <= 1e-9 * size))


def _cosine_directions() -> Floats:
    """Directions (SKY_RAYS, 3) about the z axis, as dense as the cosine from it."""
    number = np.arange(SKY_RAYS) + 0.5
    radius, turn = np.sqrt(number / SKY_RAYS), number * _GOLDEN
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], axis=-1)


def _tangents(normal: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors (n, 3) each, at right angles to normals and to each other; the first is level."""
    level = np.stack([-normal[:, 1], normal[:, 0], np.zeros(len(normal))], axis=-1)
    length = np.linalg.norm(level, axis=-1, keepdims=True)
    tangent = np.where(length > 1e-9, level / np.maximum(length, 1e-9), [1.0, 0.0, 0.0])
    return tangent, np.cross(normal, tangent)
