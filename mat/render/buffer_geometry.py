"""Axes of renderers, lines of sight of their cameras, distances and normals of their pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.render.camera import ViewRays, camera_axes
from skyshine.mat.render.frame_file import FrameModel, RendererName
from skyshine.mat.render.plan_surface import turned
from skyshine.schemas.arrays import Booleans, Floats

_ROTATION = 1e-3  # by which a matrix of single precision, or of printed digits, may differ from a rotation


@dataclass(frozen=True)
class Axes:
    """Conventions of a renderer.

    Attributes
    ----------
    ahead, right, up : tuple of float
        Of the camera, in its own axes.
    mirrored : tuple of float
        Factors on x, y and z of its world, by which it is right-handed with z up.
    x_azimuth : float
        Where the x axis points where nothing else is said [degree].
    kind : str
        What its depth is: planar or distance; empty where it writes both.
    sky : float
        Depth from which a pixel shows the sky [m].
    """

    ahead: tuple[float, float, float]
    right: tuple[float, float, float]
    up: tuple[float, float, float]
    mirrored: tuple[float, float, float] = (1.0, 1.0, 1.0)
    x_azimuth: float = 90.0
    kind: str = "planar"
    sky: float = 1e6


CARLA_FAR = 1000.0  # m, of the highest value of 24 bits (CARLA, sensors reference, depth camera)
_OPENGL = Axes((0, 0, -1), (1, 0, 0), (0, 1, 0))
AXES: dict[RendererName, Axes] = {
    "blender": _OPENGL,  # camera as in OpenGL; depth 1e10 m where there is nothing (manual, passes)
    "mitsuba": Axes((0, 0, 1), (-1, 0, 0), (0, 1, 0), kind="distance"),  # depth 0 where there is nothing
    # Unreal: left-handed, x ahead, y to the right; CARLA maps +y to the south.
    "carla": Axes((1, 0, 0), (0, 1, 0), (0, 0, 1), mirrored=(1, -1, 1), sky=CARLA_FAR * (1 - 1e-6)),
    # North, east, down, of the camera ahead, right, down; far depths are of 16-bit floats, 65504 at most.
    "airsim": Axes((1, 0, 0), (0, 1, 0), (0, 0, -1), mirrored=(1, -1, -1), x_azimuth=0.0, kind="", sky=65504.0),
    "isaac": Axes((0, 0, -1), (1, 0, 0), (0, 1, 0), kind=""),  # USD; infinite where there is nothing
    "gazebo": Axes((1, 0, 0), (0, -1, 0), (0, 0, 1)),  # frames of links (ROS, REP 103): x ahead, y to the left
    "opencv": Axes((0, 0, 1), (1, 0, 0), (0, -1, 0)),
}


def world(frame: FrameModel, vectors: npt.ArrayLike) -> Floats:
    """Vectors (..., 3) of the renderer's world to east, north and up."""
    axes = AXES[frame.renderer]
    standing: Floats = np.asarray(vectors, float) * axes.mirrored
    if frame.up == "y":
        standing = np.stack([standing[..., 0], -standing[..., 2], standing[..., 1]], axis=-1)
    azimuth = axes.x_azimuth if frame.x_azimuth_deg is None else frame.x_azimuth_deg
    return turned(standing, azimuth - 90.0)


@dataclass(frozen=True, eq=False)
class Pose:
    """A camera in the scene.

    Attributes
    ----------
    position : (3,) array
        To east, north and up [m].
    ahead, right, up : (3,) array
    turn : (3, 3) array
        From the camera's axes to east, north and up.
    """

    position: Floats
    turn: Floats
    ahead: Floats
    right: Floats
    up: Floats

    @classmethod
    def of_matrix(cls, frame: FrameModel, matrix: Floats) -> Pose:
        """The pose of a matrix (4, 4) from the camera's axes to the world's.

        Raises
        ------
        ValueError
            It is no rotation and place.
        """
        rotation, last = matrix[:3, :3], matrix[3]
        if not np.all(np.isfinite(matrix)) or not np.allclose(last, [0, 0, 0, 1], rtol=0, atol=_ROTATION):
            rows = np.allclose(matrix[:, 3], [0, 0, 0, 1], rtol=0, atol=_ROTATION)
            hint = "; it is one for rows of numbers, as USD has them: transpose it" if rows else ""
            raise ValueError(f"found a matrix whose last row is {last.tolist()}; allowed: 0, 0, 0, 1{hint}")
        if not np.allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=_ROTATION) or np.linalg.det(rotation) < 0:
            lengths = np.round(np.linalg.norm(rotation, axis=0), 4).tolist()
            raise ValueError(
                f"found a matrix whose axes have the lengths {lengths} or are not at right angles; allowed: a rotation"
                " and a place; remove scale and mirrors"
            )
        turn = world(frame, rotation.T).T
        axes = AXES[frame.renderer]
        ahead, right, up = (turn @ np.asarray(axis, float) for axis in (axes.ahead, axes.right, axes.up))
        return cls(world(frame, matrix[:3, 3]), turn, ahead, right, up)

    @classmethod
    def looking(cls, frame: FrameModel, position: npt.ArrayLike, look_at: npt.ArrayLike) -> Pose:
        """The pose of a level camera at a point, towards another."""
        at = world(frame, position)
        ahead, right, up = camera_axes(world(frame, look_at) - at)
        axes = AXES[frame.renderer]
        turn = np.stack([ahead, right, up], axis=-1) @ np.array([axes.ahead, axes.right, axes.up])
        return cls(at, turn, ahead, right, up)


def quaternion_matrix(position: npt.ArrayLike, quaternion: npt.ArrayLike) -> Floats:
    """Matrix (4, 4) of a place and a quaternion w, x, y, z of any length but 0."""
    w, x, y, z = np.asarray(quaternion, float) / np.linalg.norm(quaternion)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, 3] = position
    return matrix


def view_of(frame: FrameModel, pose: Pose, size: tuple[int, int]) -> tuple[ViewRays, Floats]:
    """Rays of the pixels, and the length (n,) of each line of sight where it is 1 m along the axis.

    Parameters
    ----------
    frame : FrameModel
    pose : Pose
    size : tuple
        Columns and rows.
    """
    columns, rows = size
    if frame.camera.intrinsics is not None:
        (focal_x, _, centre_x), (_, focal_y, centre_y), _ = frame.camera.intrinsics
    else:
        assert frame.camera.field_of_view_deg is not None
        focal_x = focal_y = columns / 2 / np.tan(np.radians(frame.camera.field_of_view_deg) / 2)
        centre_x, centre_y = columns / 2, rows / 2
    across, upward = np.meshgrid(
        (np.arange(columns) + 0.5 - centre_x) / focal_x, (centre_y - np.arange(rows) - 0.5) / focal_y
    )
    along = (pose.ahead + across[..., None] * pose.right + upward[..., None] * pose.up).reshape(-1, 3)
    length = lengths(along)
    rays = ViewRays(
        size,
        np.broadcast_to(pose.position, along.shape),
        along / length[:, None],
        np.full(len(along), frame.altitude_km + pose.position[2] * 1e-3),
        1 / np.sqrt(focal_x * focal_y) / length,
        0.0,
    )
    return rays, length


def distances(frame: FrameModel, depth: Floats, length: Floats) -> Floats:
    """Distances (n,) from the camera [m] of depths (n,), with the length of each line of sight at 1 m on the axis."""
    kind = frame.buffers.depth.kind or AXES[frame.renderer].kind
    if kind == "planar":
        return depth * length
    if frame.renderer != "mitsuba":
        return depth
    # A ray of Mitsuba begins on the plane of near_clip, from which its depth counts (src/sensors/perspective.cpp).
    near = 0.01 if frame.camera.near_clip_m is None else frame.camera.near_clip_m
    return depth + near * length


def normals_from_points(points: Floats, met: Booleans) -> Floats:
    """Unit normals (rows, columns, 3) of a surface through the points of its pixels, either side; upward where a pixel
    has no neighbour.

    Along each axis the neighbour that is nearer in space counts, so that few normals bridge an edge.

    Parameters
    ----------
    points : (rows, columns, 3) array
        [m]
    met : (rows, columns) bool array
        Pixels with a point.
    """
    normal = np.cross(_step(points, met), _step(points.swapaxes(0, 1), met.T).swapaxes(0, 1))
    length = lengths(normal)
    normal[length == 0] = [0.0, 0.0, 1.0]
    normal /= np.where(length > 0, length, 1.0)[..., None]
    return normal


def lengths(vectors: Floats) -> Floats:
    """Of vectors (..., 3); a tenth of the time of `numpy.linalg.norm`."""
    length: Floats = np.sqrt(np.einsum("...x,...x->...", vectors, vectors))
    return length


def _step(points: Floats, met: Booleans) -> Floats:
    """From one point to the next along the second axis, by the nearer of both neighbours; 0 where neither is there."""
    rows, columns = met.shape
    steps, squares = np.zeros((rows, columns + 1, 3)), np.full((rows, columns + 1), np.inf)
    np.subtract(points[:, 1:], points[:, :-1], out=steps[:, 1:-1])
    between = np.einsum("rcx,rcx->rc", steps[:, 1:-1], steps[:, 1:-1])
    squares[:, 1:-1] = np.where(met[:, 1:] & met[:, :-1], between, np.inf)
    forward, backward = squares[:, 1:], squares[:, :-1]
    step: Floats = np.where((forward <= backward)[..., None], steps[:, 1:], steps[:, :-1])
    step[np.isinf(forward) & np.isinf(backward)] = 0.0
    return step
