"""Makes frames in the layout of CARLA: raw depth and semantic tags as PNG, and the transforms of the camera.

CARLA needs a graphics card; this script draws the boxes of `yard.py` in its place, so that the example runs anywhere.
What it saves is what these lines of a client save, after each `world.tick()`:

    depth_image.save_to_disk(f"depth/{frame:06d}.png", carla.ColorConverter.Raw)
    tags_image.save_to_disk(f"tags/{frame:06d}.png", carla.ColorConverter.Raw)
    transforms.append(camera.get_transform().get_matrix())   # numpy.save("transforms.npy", transforms) at the end

Run ``python make_carla.py FOLDER``; it needs numpy and Pillow.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image
from yard import BOXES, FIELD_OF_VIEW

FRAMES, STEP_M = 8, 1.0  # the car drives east
SIZE = (640, 512)
# Tags of CARLA 0.9.14 and later (ref_sensors, semantic segmentation camera); other versions have others.
TAGS = {
    "asphalt": 1,
    "pavement": 2,
    "brick": 3,
    "roof": 3,
    "grass": 10,
    "clothes": 12,
    "skin": 12,
    "car": 14,
    "glass": 14,
    "bonnet": 14,
    "tyre": 14,
}
SKY_TAG, FAR = 11, 1000.0


def draw(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Planar depth [m] and tags, (rows, columns) each, of a camera that looks east."""
    columns, rows = SIZE
    focal = columns / 2 / np.tan(np.radians(FIELD_OF_VIEW) / 2)
    across, up = np.meshgrid(
        (np.arange(columns) + 0.5 - columns / 2) / focal, (rows / 2 - np.arange(rows) - 0.5) / focal
    )
    ray = np.stack([np.ones_like(across), -across, up], axis=-1)  # 1 along the axis, so that lengths are planar
    depth, tags = np.full(across.shape, FAR), np.full(across.shape, SKY_TAG, np.uint8)
    with np.errstate(divide="ignore"):
        inverse = 1.0 / ray
    for name, low, high in BOXES:
        first, last = (low - position) * inverse, (high - position) * inverse
        enter, leave = np.minimum(first, last).max(axis=-1), np.maximum(first, last).min(axis=-1)
        seen = (enter > 0) & (enter <= leave) & (enter < depth)
        depth[seen], tags[seen] = enter[seen], TAGS[name]
    return depth, tags


def main(folder: Path) -> None:
    for name in ("depth", "tags"):
        (folder / "carla" / name).mkdir(parents=True, exist_ok=True)
    transforms = []
    for frame in range(FRAMES):
        east, north, height = -14.0 + STEP_M * frame, -0.5, 1.6
        depth, tags = draw(np.array([east, north, height]))
        value = np.rint(depth / FAR * (2**24 - 1)).astype(np.uint32)
        raw = np.stack([value & 255, value >> 8 & 255, value >> 16], axis=-1).astype(np.uint8)
        red = np.stack([tags, np.zeros_like(tags), np.zeros_like(tags)], axis=-1)
        Image.fromarray(raw).save(folder / "carla" / "depth" / f"{frame:06d}.png")
        Image.fromarray(red).save(folder / "carla" / "tags" / f"{frame:06d}.png")
        # Unreal's world is left-handed: y to the south.
        transforms.append([[1, 0, 0, east], [0, 1, 0, -north], [0, 0, 1, height], [0, 0, 0, 1]])
    np.save(folder / "carla" / "transforms.npy", np.array(transforms, float))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
