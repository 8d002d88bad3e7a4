"""Axes of renderers, lines of sight of their cameras, distances and normals of their pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.render.camera import ViewRays, camera_axes
from skyshine.mat.render.frame_file import FrameModel, LoadedFrame, RendererName
from skyshine.mat.render.plan_surface import turned
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.errors import InputError

_ROTATION = 1e-3  # by which a matrix of single precision, or of printed digits, may differ from a rotation


@dataclass(frozen=True)
class Axes:
    """Conventions of a renderer.

    Attributes
    ----------
    ahead, right, up : tuple of float
        Directions of the camera, in its own axes.
    mirrored : tuple of float
        Factors on x, y and z of its world, by which it is right-handed with z up.
    x_azimuth : float
        Default azimuth of the x axis [degree].
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
        Position to east, north and up [m].
    ahead, right, up : (3,) array
    turn : (3, 3) array
        Rotation from the camera's axes to east, north and up.
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
        rotation, bottom_row = matrix[:3, :3], matrix[3]
        if not np.all(np.isfinite(matrix)) or not np.allclose(bottom_row, [0, 0, 0, 1], rtol=0, atol=_ROTATION):
            rows = np.allclose(matrix[:, 3], [0, 0, 0, 1], rtol=0, atol=_ROTATION)
            hint = "; it is one for rows of numbers, as USD has them: transpose it" if rows else ""
            raise ValueError(f"found a matrix whose last row is {bottom_row.tolist()}; allowed: 0, 0, 0, 1{hint}")
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


def poses_of(frame: LoadedFrame) -> list[Pose]:
    """Poses of the frames: one of all, or one for each.

    Raises
    ------
    InputError
        A matrix is no pose, or their number is not that of the frames.
    """
    camera, model = frame.model.camera, frame.model
    if camera.look_at is not None:
        assert camera.position is not None
        return [Pose.looking(model, camera.position, camera.look_at)]
    if camera.poses is not None:
        key: tuple[str, ...] = ("camera", "poses")
        matrices = _matrices(frame)
    elif camera.pose is not None:
        key, matrices = ("camera", "pose"), np.array([camera.pose], float)
    else:
        key = ("camera", "quaternion")
        if not np.linalg.norm(camera.quaternion or 0.0) > 0:
            raise frame.error(key, "found a quaternion of length 0; allowed: w, x, y, z of a rotation")
        matrices = quaternion_matrix(camera.position or 0.0, camera.quaternion or 0.0)[None]
    poses = []
    for matrix in matrices:
        try:
            poses.append(Pose.of_matrix(model, matrix))
        except ValueError as error:
            raise frame.error(key, str(error)) from None
    return poses


def _matrices(frame: LoadedFrame) -> Floats:
    """Matrices (m, 4, 4) of the files of poses."""
    key, marks = ("camera", "poses"), frame.marks
    files = dict.fromkeys(frame.path(key, mark) for mark in marks)
    arrays = []
    for file in files:
        try:
            read = (
                np.load(file, allow_pickle=False) if file.suffix == ".npy" else file.read_text(encoding="utf-8").split()
            )
            arrays.append(np.asarray(read, float).reshape(-1, 4, 4))
        except (OSError, ValueError, EOFError, TypeError) as error:
            raise InputError(f"has no matrices of 4 x 4 numbers ({error}); save them so", file=file) from None
    matrices = np.concatenate(arrays)
    if len(matrices) not in (1, len(marks)) or len(matrices) == 0:
        raise frame.error(key, f"found {len(matrices)} matrices and {len(marks)} frames; allowed: one, or one a frame")
    return matrices


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


@dataclass(frozen=True, eq=False)
class CameraView:
    """Lines of sight of the pixels of a frame.

    Attributes
    ----------
    length : (rows, columns) array
        Length of each line of sight at 1 m along the axis.
    across, upward : (columns,) and (rows,) arrays
        Tangents of the pixels from the axis, to the right and up.
    """

    rays: ViewRays
    length: Floats
    across: Floats
    upward: Floats


def view_of(frame: FrameModel, pose: Pose, size: tuple[int, int]) -> CameraView:
    """Lines of sight of a frame of columns and rows."""
    columns, rows = size
    if frame.camera.intrinsics is not None:
        (focal_x, _, centre_x), (_, focal_y, centre_y), _ = frame.camera.intrinsics
    else:
        assert frame.camera.field_of_view_deg is not None
        focal_x = focal_y = columns / 2 / math.tan(math.radians(frame.camera.field_of_view_deg) / 2)
        centre_x, centre_y = columns / 2, rows / 2
    across = np.asarray((np.arange(columns) + 0.5 - centre_x) / focal_x, np.float64)
    upward = np.asarray((centre_y - np.arange(rows) - 0.5) / focal_y, np.float64)
    length = np.sqrt(1.0 + across**2 + upward[:, None] ** 2)
    along = (pose.ahead + upward[:, None] * pose.up)[:, None] + (across[:, None] * pose.right)[None]
    along /= length[..., None]
    rays = ViewRays(
        size,
        np.broadcast_to(pose.position, (rows * columns, 3)),
        along.reshape(-1, 3),
        np.full(rows * columns, frame.altitude_km + pose.position[2] * 1e-3),
        1 / np.sqrt(focal_x * focal_y) / length.ravel(),
        0.0,
    )
    return CameraView(rays, length, across, upward)


def distances(frame: FrameModel, depth: Floats, length: Floats) -> Floats:
    """Distances from the camera [m] of depths, with the length of each line of sight at 1 m on the axis."""
    kind = frame.buffers.depth.kind or AXES[frame.renderer].kind
    if kind == "planar":
        return depth * length
    if frame.renderer != "mitsuba":
        return depth
    # A ray of Mitsuba begins on the plane of near_clip, from which its depth counts (src/sensors/perspective.cpp).
    near = 0.01 if frame.camera.near_clip_m is None else frame.camera.near_clip_m
    return depth + near * length


def normals_from_depth(view: CameraView, pose: Pose, planar: Floats) -> Floats:
    """Unit normals (rows, columns, 3) to east, north and up of the surfaces that a depth shows, of either side; upward
    where a pixel has no neighbour.

    On a plane the inverse of the planar depth is linear in the tangents x and y of a line of sight: 1/z = n . (x, y, 1)
    with a normal n to the right, up and ahead. Of both neighbours along a side the one of the nearer depth counts, so
    that few normals bridge an edge.

    Parameters
    ----------
    planar : (rows, columns) array
        Depth along the axis [m]; infinite for the sky.
    """
    inverse = 1.0 / planar
    right, is_wide = _gradient(inverse, view.across)
    up, is_high = _gradient(inverse.T, view.upward)
    up, valid = up.T, is_wide & is_high.T
    ahead = inverse - view.across * right - view.upward[:, None] * up
    length = np.sqrt(right**2 + up**2 + ahead**2)
    valid &= length > 0
    scale = np.where(valid, 1.0 / np.where(valid, length, 1.0), 0.0)
    axes = np.stack([pose.right, pose.up, pose.ahead])
    in_camera: Floats = np.stack([right * scale, up * scale, ahead * scale], axis=-1)
    normal: Floats = in_camera @ axes
    normal[~valid] = [0.0, 0.0, 1.0]
    return normal


def _gradient(inverse: Floats, tangent: Floats) -> tuple[Floats, Booleans]:
    """Derivative of an inverse depth (n, m) by the tangent (m,) of its second axis, and where there is one."""
    change, between = np.diff(inverse, axis=1), np.diff(tangent)
    # The inverse of a pixel of the sky is 0, which is no neighbour.
    change[(inverse[:, 1:] == 0) | (inverse[:, :-1] == 0)] = np.inf
    border = np.full((len(inverse), 1), np.inf)
    change /= between
    forward, backward = np.concatenate([change, border], axis=1), np.concatenate([border, change], axis=1)
    gradient = np.where(np.abs(forward) <= np.abs(backward), forward, backward)
    finite = np.isfinite(gradient)
    return np.where(finite, gradient, 0.0), finite


def lengths(vectors: Floats) -> Floats:
    """Lengths of vectors (..., 3); a tenth of the time of `numpy.linalg.norm`."""
    length: Floats = np.sqrt(np.einsum("...x,...x->...", vectors, vectors))
    return length
