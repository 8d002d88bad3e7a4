"""The yard of the three examples: a road, a house, a car whose engine runs, and two people, as boxes.

Metres; x to the east, y to the north, z up. The origin lies 170 m above the sea.
"""

from __future__ import annotations

from pathlib import Path

Corner = tuple[float, float, float]

# Name of the material, and least and greatest corner. Grass ends at the horizon of the pictures.
BOXES: tuple[tuple[str, Corner, Corner], ...] = (
    ("grass", (-400, -400, -0.5), (400, 400, 0.0)),
    ("asphalt", (-400, -4, 0.0), (400, 4, 0.02)),
    ("pavement", (-400, 4, 0.0), (400, 7, 0.15)),
    ("brick", (-4, 9, 0.0), (14, 19, 6.0)),
    ("roof", (-4.5, 8.5, 6.0), (14.5, 19.5, 6.3)),
    ("brick", (22, 8, 0.0), (34, 18, 9.0)),
    ("roof", (21.5, 7.5, 9.0), (34.5, 18.5, 9.3)),
    ("brick", (8, -22, 0.0), (26, -9, 7.0)),
    ("roof", (7.5, -22.5, 7.0), (26.5, -8.5, 7.3)),
    ("car", (6.0, -2.9, 0.45), (10.3, -1.1, 1.0)),
    ("glass", (7.6, -2.8, 1.0), (9.9, -1.2, 1.55)),
    ("bonnet", (6.0, -2.85, 1.0), (7.5, -1.15, 1.04)),
    ("tyre", (6.4, -2.95, 0.02), (7.1, -2.7, 0.65)),
    ("tyre", (6.4, -1.3, 0.02), (7.1, -1.05, 0.65)),
    ("tyre", (9.2, -2.95, 0.02), (9.9, -2.7, 0.65)),
    ("tyre", (9.2, -1.3, 0.02), (9.9, -1.05, 0.65)),
    ("clothes", (3.0, 5.2, 0.15), (3.3, 5.7, 1.55)),
    ("skin", (3.05, 5.33, 1.55), (3.25, 5.57, 1.85)),
    ("clothes", (15.0, 2.0, 0.02), (15.3, 2.5, 1.45)),
    ("skin", (15.05, 2.13, 1.45), (15.25, 2.37, 1.75)),
)
NAMES = tuple(dict.fromkeys(name for name, _, _ in BOXES))

CAMERA, LOOK_AT, FIELD_OF_VIEW = (-12.0, 0.5, 2.2), (12.0, 1.5, 1.6), 50.0  # m, m, degree


def write_obj(file: Path) -> None:
    """The boxes as a mesh, which casts the shadows of a frame."""
    sides = ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6))
    lines = []
    for number, (name, low, high) in enumerate(BOXES):
        lines += [f"usemtl {name}"]
        lines += [
            f"v {x:g} {y:g} {z:g}" for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])
        ]
        lines += ["f " + " ".join(str(8 * number + corner) for corner in side) for side in sides]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
