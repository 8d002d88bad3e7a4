"""Renders the yard with Blender's Cycles: depth, normals and Cryptomatte in one EXR, and the mesh as OBJ.

Run ``python make_blender.py FOLDER`` with the package bpy, or
``blender --background --python make_blender.py -- FOLDER``. A scene of your own needs `render` alone.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent))
from yard import BOXES, CAMERA, FIELD_OF_VIEW, LOOK_AT, NAMES

SIZE, SAMPLES = (320, 256), 8
TANK = ("car", (9.0, -6.0, 1.3), 1.3)  # a painted tank: material, centre, radius


def build() -> None:
    """The boxes and the tank, with a material for each name."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = {name: bpy.data.materials.new(name) for name in NAMES}
    for name, low, high in BOXES:
        middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        bpy.ops.mesh.primitive_cube_add(size=1, location=middle)
        bpy.context.object.scale = [b - a for a, b in zip(low, high, strict=True)]
        bpy.context.object.data.materials.append(materials[name])
    name, centre, radius = TANK
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius, location=centre)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(materials[name])


def place_camera() -> None:
    lens = bpy.data.cameras.new("camera")
    lens.angle = math.radians(FIELD_OF_VIEW)
    camera = bpy.data.objects.new("camera", lens)
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    camera.location = CAMERA
    camera.rotation_euler = (Vector(LOOK_AT) - Vector(CAMERA)).to_track_quat("-Z", "Y").to_euler()


def render(file: Path) -> None:
    """One EXR with the passes that a frame file reads."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", SAMPLES
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_cryptomatte_material = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # Blender 5
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)


def main(folder: Path) -> None:
    (folder / "blender").mkdir(parents=True, exist_ok=True)
    build()
    place_camera()
    bpy.ops.wm.obj_export(filepath=str(folder / "blender" / "yard.obj"), forward_axis="Y", up_axis="Z")
    render(folder / "blender" / "yard.exr")


if __name__ == "__main__":
    main(Path(sys.argv[-1]).resolve())
