"""Renders the yard with Mitsuba 3: depth, normals and shapes in one EXR; names of the shapes, and the mesh as OBJ.

Run ``python make_mitsuba.py FOLDER`` with the package mitsuba. The variant scalar_rgb numbers shapes from 1, in the
order of `scene.shapes()`, which is not that of the scene's description; 0 is the sky.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import mitsuba
from yard import BOXES, CAMERA, FIELD_OF_VIEW, LOOK_AT, write_obj

SIZE = (320, 256)


def scene() -> dict[str, object]:
    """The boxes as a scene of Mitsuba, whose integrator draws buffers and no light."""
    transform = mitsuba.ScalarTransform4f
    shapes = {}
    for number, (name, low, high) in enumerate(BOXES):
        middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        half = [(b - a) / 2 for a, b in zip(low, high, strict=True)]
        shapes[f"{number:02d}_{name}"] = {"type": "cube", "to_world": transform().translate(middle).scale(half)}
    film = {
        "type": "hdrfilm",
        "width": SIZE[0],
        "height": SIZE[1],
        "rfilter": {"type": "box"},
        "component_format": "float32",
    }
    sensor = {
        "type": "perspective",
        "fov": FIELD_OF_VIEW,
        "fov_axis": "x",
        "to_world": transform().look_at(CAMERA, LOOK_AT, [0, 0, 1]),
        "film": film,
        # One sample in the middle of the pixel: buffers are no light, and means of them are nothing.
        "sampler": {"type": "stratified", "sample_count": 1, "jitter": False},
    }
    integrator = {"type": "aov", "aovs": "depth:depth,normal:sh_normal,shape:shape_index"}
    return {"type": "scene", "integrator": integrator, "sensor": sensor, **shapes}


def main(folder: Path) -> None:
    (folder / "mitsuba").mkdir(parents=True, exist_ok=True)
    mitsuba.set_variant("scalar_rgb")
    loaded = mitsuba.load_dict(scene())
    mitsuba.render(loaded)
    loaded.sensors()[0].film().write(str(folder / "mitsuba" / "yard.exr"))
    write_obj(folder / "mitsuba" / "yard.obj")
    names = {number: shape.id().partition("_")[2] for number, shape in enumerate(loaded.shapes(), start=1)}
    (folder / "mitsuba" / "shapes.json").write_text(json.dumps(names), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
