"""What the frames of a scene read from its databases: lines of sight, faces, materials and hours."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from skyshine.mat.job.fields import Span
from skyshine.mat.render.camera import ViewRays, check_above_ground, is_still, view_rays
from skyshine.mat.render.exposure import open_sky
from skyshine.mat.render.rays import ray_caster
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface import SurfaceMaterials, surface_of_scene
from skyshine.mat.render.vertices import SeenVertices
from skyshine.mat.render.walls import WallKinds
from skyshine.schemas.arrays import Floats
from skyshine.schemas.progress import Progress, silent

DECIMALS = 6  # decimals of a slope and an azimuth [degree], to which tables of temperature are read
_DAY = 24.0  # [h]
_POINTS = 4096  # points of a picture, from which rays look for walls; chosen
Key = TypeVar("Key")


@dataclass(frozen=True, eq=False)
class SceneReads:
    """What the pixels of all frames read.

    Attributes
    ----------
    hours : (H,) array
        Local clock of the frames, each once, ascending.
    observer_altitude_km, elevation_deg : tuple of float
        Least and greatest, of all pixels.
    azimuth_deg : (H, 2) array
        Arc of azimuths of the lines of sight at each hour: its start and its length.
    range_km, surface_altitude_km : tuple of float or None
        Limits over the pixels that meet the surface; None where none does.
    air : float
        Share of the pixels that meet nothing.
    faces : dict of (float, float) to float
        Share in the pixels that meet the surface, of each slope and azimuth [degree], the largest first; 0 of faces
        that no pixel shows, but which hide the sky of some.
    materials : dict of str to float
        Likewise of each material that a pixel contains.
    level : bool
        All faces of the surface are level, whether they are seen or not, and no material has trees before its sky.
    named : tuple of str
        All materials that the surface names, whether they are seen or not.
    """

    hours: Floats
    observer_altitude_km: Span
    elevation_deg: Span
    azimuth_deg: Floats
    range_km: Span | None
    surface_altitude_km: Span | None
    air: float
    faces: dict[tuple[float, float], float]
    materials: dict[str, float]
    level: bool
    named: tuple[str, ...]

    @property
    def clock(self) -> Span:
        """First and last hour of the shortest part of the day that contains all frames; the first may be the later."""
        gaps = np.diff(np.append(self.hours, self.hours[0] + _DAY))
        widest = int(np.argmax(gaps))
        return float(self.hours[(widest + 1) % self.hours.size]), float(self.hours[widest])


def scene_reads(scene: LoadedScene, progress: Progress = silent) -> SceneReads:
    """Cast the rays of every camera of a scene.

    Raises
    ------
    InputError
        A file is missing or does not fit the others, the camera is below the surface, or a texel that is seen has
        no material.
    """
    surface = surface_of_scene(scene)
    caster = ray_caster(surface)
    check_above_ground(scene, surface, caster)
    clock = np.array(scene.hours)
    still = is_still(scene)
    pixels, hits = 0, 0
    spans: dict[str, list[Span]] = {name: [] for name in ("observer", "elevation", "range", "altitude")}
    faces: dict[tuple[float, float], float] = {}
    arcs: dict[float, list[Span]] = {}
    with SurfaceMaterials(scene, surface) as materials, progress(1 if still else clock.size, "casting rays") as advance:
        shares, walls = np.zeros(len(materials.names)), WallKinds(surface, materials)
        for number in range(1 if still else clock.size):
            rays = view_rays(scene, surface, number)
            points = SeenSurface.of(rays, surface, materials, caster)
            pixels, hits = pixels + rays.elevation.size, hits + len(points)
            altitude = [points.altitude]
            if scene.model.surface.vertices is not None:
                vertices = SeenVertices.of(points, surface, materials, scene.model.surface.vertices)
                altitude.append(vertices.points.altitude)
            for name, values in (
                ("observer", rays.altitude),
                ("elevation", rays.elevation),
                ("range", points.range),
                ("altitude", np.concatenate(altitude)),
            ):
                if values.size:
                    spans[name].append((float(values.min()), float(values.max())))
            for hour in clock if still else clock[number : number + 1]:
                arcs.setdefault(float(hour), []).append(_arc(rays))
            np.add.at(shares, points.materials.number.ravel() % shares.size, points.materials.share.ravel())
            open_sky(points.take(np.arange(0, len(points), max(1, len(points) // _POINTS))), caster, walls)
            for face, count in _faces(points).items():
                faces[face] = faces.get(face, 0.0) + count
            advance(1)
        for face in _faces(walls.faces()[0]):
            faces.setdefault(face, 0.0)
        named, in_shade = tuple(materials.names), materials.in_shade
    hours = np.array(sorted(arcs))
    seen_materials = {name: float(share) / hits for name, share in zip(named, shares, strict=True) if share > 0}
    observer, elevation, reach, heights = (_widest(spans[name]) for name in spans)
    assert observer is not None and elevation is not None  # a picture has pixels
    return SceneReads(
        hours,
        observer,
        elevation,
        np.array([_joined(arcs[float(hour)]) for hour in hours]),
        reach,
        heights,
        1 - hits / pixels,
        _largest_first({face: count / hits for face, count in faces.items()}),
        _largest_first(seen_materials),
        not in_shade and bool(np.all(np.isin(np.round(surface.slope, DECIMALS), (0.0, 180.0)))),
        named,
    )


def _faces(points: SeenSurface) -> dict[tuple[float, float], float]:
    """Number of pixels of each slope and azimuth; of level faces the azimuth is 0."""
    slope = np.round(points.slope, DECIMALS)
    level = (slope == 0) | (slope == 180)
    azimuth = np.where(level, 0.0, np.round(points.azimuth, DECIMALS) % 360.0)
    orientations, count = np.unique(np.stack([slope, azimuth], axis=-1), axis=0, return_counts=True)
    return {(float(slope), float(azimuth)): float(n) for (slope, azimuth), n in zip(orientations, count, strict=True)}


def _arc(rays: ViewRays) -> Span:
    """First azimuth and length of the shortest arc with all lines of sight [degree]."""
    return _shortest(np.unique(np.round(rays.azimuth, 2) % 360.0))


def _joined(arcs: Iterable[Span]) -> Span:
    """The shortest arc with the ends and the middles of all arcs, which are those of one hour."""
    angles = [(start + part * length) % 360.0 for start, length in arcs for part in np.linspace(0, 1, 17)]
    return _shortest(np.unique(angles))


def _shortest(azimuth: Floats) -> Span:
    """The shortest arc with all azimuths (n,), ascending."""
    gaps = np.diff(np.append(azimuth, azimuth[0] + 360.0))
    widest = int(np.argmax(gaps))
    return float(azimuth[(widest + 1) % azimuth.size]), float(360.0 - gaps[widest])


def _widest(spans: list[Span]) -> Span | None:
    return (min(low for low, _ in spans), max(high for _, high in spans)) if spans else None


def _largest_first(counts: dict[Key, float]) -> dict[Key, float]:
    return dict(sorted(counts.items(), key=lambda item: -item[1]))
