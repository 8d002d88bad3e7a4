"""The radiance of the pixels of a scene.

Usage: python -m runtime SCENE.json

The scene and the result are described in ../../README.md.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from .axis import SceneError
from .database import Database
from .pixel import pixel
from .texture import Texture


def compute(path: Path) -> str:
    """The result of a scene, as JSON."""
    folder, scene = path.parent, json.loads(path.read_text(encoding="utf-8"))
    clamped = scene.get("clamp", [])
    surface = Database(folder / scene["surface"], ["htt"], clamped)
    band = Database(folder / scene["band"], ["band"], clamped)
    air = Database(folder / scene["atmosphere"], ["atmq", "lunar_atmq"], clamped)
    air.part_light(band)
    texture = Texture(folder / scene["texture"]) if "texture" in scene else None
    return json.dumps({"pixels": [pixel(scene, surface, band, air, texture, given) for given in scene["pixels"]]})


def main(path: str) -> None:
    try:
        print(compute(Path(path)))
    except KeyError as error:
        sys.exit(f"the scene lacks {error}")
    except (SceneError, OSError, ValueError, TypeError) as error:
        # Texts of a file may hold what ends a line.
        sys.exit("".join(character if character.isprintable() else "?" for character in str(error)))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m runtime SCENE.json")
    main(sys.argv[1])
