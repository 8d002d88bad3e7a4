"""Buffers of a scene as other renderers write them, by definitions of their own."""

import numpy as np
from PIL import Image

COLUMNS, ROWS, FIELD = 24, 16, 50.0
POSITION, LOOK_AT = np.array([-11.0, -25.0, 30.0]), np.array([3.0, 1.0, 0.0])
FAR = {"blender": 1e10, "mitsuba": 0.0, "carla": 1000.0, "airsim": 65504.0}  # depth of the sky; else infinite


def camera_vectors():
    """Ahead, right and up of the camera, to east, north and up."""
    ahead = (LOOK_AT - POSITION) / np.linalg.norm(LOOK_AT - POSITION)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return ahead, right, np.cross(right, ahead)


def to_world(renderer, vectors):
    """East, north and up in the axes of a renderer's world."""
    east, north, up = np.moveaxis(np.asarray(vectors, float), -1, 0)
    if renderer == "carla":
        return np.stack([east, -north, up], axis=-1)  # left-handed: x east, y south
    if renderer == "airsim":
        return np.stack([north, east, -up], axis=-1)
    return np.stack([east, north, up], axis=-1)


def camera_columns(renderer):
    """The camera's x, y and z axes, to east, north and up."""
    ahead, right, up = camera_vectors()
    return {
        "blender": (right, up, -ahead),
        "isaac": (right, up, -ahead),
        "mitsuba": (-right, up, ahead),
        "opencv": (right, -up, ahead),
        "gazebo": (ahead, -right, up),
        "carla": (ahead, right, up),
        "airsim": (ahead, right, -up),
    }[renderer]


def pose(renderer):
    matrix = np.eye(4)
    matrix[:3, :3] = to_world(renderer, np.stack(camera_columns(renderer))).T
    matrix[:3, 3] = to_world(renderer, POSITION)
    return matrix


def stored_depth(renderer, distance, kind):
    """Depth (rows, columns) as a renderer stores distances [m], infinite for the sky."""
    half = np.tan(np.radians(FIELD / 2))
    x = ((np.arange(COLUMNS) + 0.5) / COLUMNS * 2 - 1) * half
    y = (1 - (np.arange(ROWS) + 0.5) / ROWS * 2) * half * ROWS / COLUMNS
    length = np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    depth = distance / length if kind == "planar" else distance
    if renderer == "mitsuba":
        depth = depth - 0.25 * length  # near_clip_m of the tests
    return np.where(np.isfinite(distance), depth, FAR.get(renderer, np.inf))


def save_carla(path, depth):
    value = np.rint(np.minimum(depth, 1000.0) / 1000.0 * (2**24 - 1)).astype(int)
    raw = np.stack([value % 256, value // 256 % 256, value // 65536], axis=-1)
    Image.fromarray(raw.astype(np.uint8)).save(path)


def save_exr(path, layers, attributes=()):
    """One part of float channels: {name of a channel: (rows, columns)}."""
    import OpenImageIO as oiio

    rows, columns = next(iter(layers.values())).shape
    spec = oiio.ImageSpec(columns, rows, len(layers), "float")
    spec.channelnames = tuple(layers)
    for name, value in dict(attributes).items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create("exr")
    assert output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(np.stack(list(layers.values()), axis=-1), np.float32))
    assert output.close()
