"""Cameras of a scene as rays through the middles of its pixels, or of the parts of each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from skyshine.mat.render.plan_surface import turned
from skyshine.mat.render.rays import RayCaster
from skyshine.mat.render.scene_file import LoadedScene, Perspective, PlanView
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class ViewRays:
    """Rays of the n = rows x columns pixels of one frame, or of their parts, row by row from the top.

    Attributes
    ----------
    size : tuple
        Columns and rows of the rays: those of the picture times the samples of its pixels.
    origin, direction : (n, 3) array
        [m], unit vectors; to east, north and up.
    altitude : (n,) array
        Altitude of the observer [km].
    spread : (n,) array
        Side of the pixel at 1 m [rad]; of a plan view 0.
    side : float
        Pixel size of a plan view [m]; 0 for a perspective.
    """

    size: tuple[int, int]
    origin: Floats
    direction: Floats
    altitude: Floats
    spread: Floats
    side: float

    @cached_property
    def elevation(self) -> Floats:
        """Elevation of the lines of sight (n,) [degree]."""
        up = self.direction[:, 2]
        elevation: Floats = np.degrees(np.arctan2(up, np.hypot(self.direction[:, 0], self.direction[:, 1])))
        return elevation

    @cached_property
    def azimuth(self) -> Floats:
        """Azimuth of the lines of sight (n,), clockwise from north [degree]."""
        azimuth: Floats = np.mod(np.degrees(np.arctan2(self.direction[:, 0], self.direction[:, 1])), 360.0)
        return azimuth


def view_rays(scene: LoadedScene, surface: SurfaceMesh, frame: int) -> ViewRays:
    """Rays of a frame, counted from 0 as the hours of the scene are."""
    camera = scene.model.camera
    if camera.plan_view is not None:
        return _plan_rays(scene, surface, camera.plan_view)
    assert camera.perspective is not None
    return _perspective_rays(surface.altitude, camera.perspective, *station(camera.perspective, frame))


def station(camera: Perspective, frame: int) -> tuple[Floats, Floats]:
    """Position and the point looked at (3,) [m] in a frame."""
    position = camera if camera.track is None else camera.track[frame]
    return np.asarray(position.position_m, float), np.asarray(position.look_at_m, float)


def is_still(scene: LoadedScene) -> bool:
    """Whether all frames of a scene have the same rays."""
    perspective = scene.model.camera.perspective
    return perspective is None or perspective.track is None


def check_above_ground(scene: LoadedScene, surface: SurfaceMesh, caster: RayCaster) -> None:
    """Refuse cameras below the surface.

    Raises
    ------
    InputError
        The surface is above a camera, and there is none below it.
    """
    camera, up = scene.model.camera, np.array([[0.0, 0.0, 1.0]])
    if camera.plan_view is not None:
        if camera.plan_view.height_m <= surface.bounds[1, 2]:
            raise scene.error(
                ("camera", "plan_view", "height_m"),
                f"found {camera.plan_view.height_m:g} m; allowed: above the surface, whose highest point is at"
                f" {surface.bounds[1, 2]:g} m; raise it",
            )
        return
    assert camera.perspective is not None
    for number in range(len(camera.perspective.track or [None])):
        position, _ = station(camera.perspective, number)
        if caster.blocked(position[None], up)[0] and not caster.blocked(position[None], -up)[0]:
            track: tuple[str | int, ...] = () if camera.perspective.track is None else ("track", number)
            above = caster.first(position[None], up).distance[0]
            raise scene.error(
                ("camera", "perspective", *track, "position_m"),
                f"found a camera {above:.3g} m below the surface; allowed: above it; raise it to more than"
                f" {position[2] + above:.6g} m",
            )


def _plan_rays(scene: LoadedScene, surface: SurfaceMesh, view: PlanView) -> ViewRays:
    columns, rows = (count * view.samples for count in view.size)
    plan = scene.model.surface.plan
    top = view.top_azimuth_deg
    if top is None:
        top = 0.0 if plan is None else plan.top_azimuth_deg
    centre = np.array([*view.centre_m, 0.0])
    width = view.width_m
    if width is None:
        extent = turned(surface.triangles.reshape(-1, 3) - centre, -top)
        across, up = 2.0 * np.abs(extent[:, :2]).max(axis=0)
        width = float(max(across, up * columns / rows))
    side = width / columns
    x, y = np.meshgrid((np.arange(columns) + 0.5) * side - width / 2, (rows / 2 - np.arange(rows) - 0.5) * side)
    origin = turned(np.stack([x, y, np.full_like(x, view.height_m)], axis=-1).reshape(-1, 3), top) + centre
    down = np.broadcast_to([0.0, 0.0, -1.0], origin.shape)
    altitude = np.full(len(origin), surface.altitude + view.height_m * 1e-3)
    return ViewRays((columns, rows), origin, down, altitude, np.zeros(len(origin)), side)


def _perspective_rays(base_km: float, camera: Perspective, position: Floats, look_at: Floats) -> ViewRays:
    columns, rows = (count * camera.samples for count in camera.size)
    ahead, right, up = camera_axes(look_at - position)
    half = np.tan(np.radians(camera.field_of_view_deg) / 2)
    x, y = np.meshgrid(
        ((np.arange(columns) + 0.5) / columns * 2 - 1) * half,
        (1 - (np.arange(rows) + 0.5) / rows * 2) * half * rows / columns,
    )
    along = (ahead + x[..., None] * right + y[..., None] * up).reshape(-1, 3)
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    origin = np.broadcast_to(position, along.shape)
    altitude = np.full(len(along), base_km + position[2] * 1e-3)
    return ViewRays((columns, rows), origin, along / length, altitude, 2 * half / columns / length[:, 0], 0.0)


def camera_axes(ahead: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Unit vectors ahead, to the right and up of a camera held level; one that looks straight up or down has north (or
    south) at the top.
    """
    forward = np.asarray(ahead, float)
    forward = forward / np.linalg.norm(forward)
    level = np.array([forward[1], -forward[0], 0.0])
    right = level / np.linalg.norm(level) if np.linalg.norm(level) > 1e-9 else np.array([1.0, 0.0, 0.0])
    return forward, right, np.cross(right, forward)
