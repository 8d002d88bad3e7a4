"""Makes the street's mesh: a road between houses, from east to west, with a gap through which the noon Sun comes.

Run ``python make_street.py FOLDER`` to write FOLDER/street.glb; it needs trimesh. All measures are in metres: x to the
east, y to the north, z up.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

Box = tuple[tuple[float, float, float], tuple[float, float, float]]  # least and greatest corner

# Each body with the materials of its walls and of its top; none has a bottom.
BODIES: tuple[tuple[Box, str, str], ...] = (
    (((-60, -4, -0.05), (60, 4, 0.0)), "asphalt", "asphalt"),  # the road
    (((-60, -7, -0.05), (60, -4, 0.15)), "kerb", "pavement"),
    (((-60, 4, -0.05), (60, 7, 0.15)), "kerb", "pavement"),
    (((-60, -19, -0.05), (-26, -7, 12.0)), "brick", "roof"),  # houses on the south side
    (((-16, -19, -0.05), (14, -7, 12.0)), "brick", "roof"),
    (((28, -19, -0.05), (60, -7, 8.0)), "brick", "roof"),
    (((-60, 7, -0.05), (-5, 19, 9.0)), "plaster", "roof"),  # on the north side
    (((10, 7, -0.05), (60, 19, 9.0)), "plaster", "roof"),
    (((18, -3.6, 0.35), (23, -1.6, 2.3)), "van", "van"),  # parked in the Sun that comes through the gap
    (((-10, 1.6, 0.35), (-5, 3.6, 2.3)), "van", "van"),
)
GRASS: Box = ((-1000, -1000, -0.05), (1000, 1000, -0.05))
SIDES = ((0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))  # corners of the walls, seen from outside
TOP = (4, 5, 7, 6)


def corners(box: Box) -> np.ndarray:
    """The eight corners of a box, x fastest and z slowest, (8, 3)."""
    low, high = np.array(box, float)
    choice = np.array([[number & 1, number >> 1 & 1, number >> 2] for number in range(8)])
    points: np.ndarray = low + choice * (high - low)
    return points


def triangles(points: np.ndarray, sides: tuple[tuple[int, ...], ...]) -> np.ndarray:
    """Two triangles of each side of four corners, (F, 3, 3)."""
    return np.array([points[[side[0], *pair]] for side in sides for pair in (side[1:3], side[2:4])])


def parts() -> dict[str, np.ndarray]:
    """Triangles (F, 3, 3) of each material of the mesh."""
    grown: dict[str, list[np.ndarray]] = {"grass": [triangles(corners(GRASS), (TOP,))]}
    for box, walls, top in BODIES:
        grown.setdefault(walls, []).append(triangles(corners(box), SIDES))
        grown.setdefault(top, []).append(triangles(corners(box), (TOP,)))
    return {name: np.concatenate(pieces) for name, pieces in grown.items()}


def street() -> Any:
    """The mesh as a scene of trimesh, with y up as glTF says."""
    import trimesh
    from trimesh.visual.material import PBRMaterial

    scene = trimesh.Scene()
    for name, faces in parts().items():
        points = np.stack([faces[..., 0], faces[..., 2], -faces[..., 1]], axis=-1).reshape(-1, 3)
        numbers = np.arange(len(points)).reshape(-1, 3)
        visual = trimesh.visual.TextureVisuals(material=PBRMaterial(name=name))
        mesh = trimesh.Trimesh(points, numbers, visual=visual, process=False)
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    return scene


if __name__ == "__main__":
    Path(sys.argv[1], "street.glb").write_bytes(street().export(file_type="glb"))
