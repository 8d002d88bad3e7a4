"""A street drawn by `mat render` and by `mat render --buffers` from frames of Mitsuba and Blender, pixel by pixel.

The renderers cast their own rays at the same triangles with the same camera; skipped without the packages mitsuba 3 and
bpy. About a minute each.

Run: python -m pytest -m validation -s tests/validation/test_mitsuba_frame.py
"""

import json
import math
import runpy
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

import skyshine
from skyshine.mat.cli import main
from skyshine.schemas.documents import read_yaml

pytestmark = pytest.mark.validation

STREET = Path(__file__).parents[2] / "examples" / "street"
HOUR, SIZE = 13.0, (240, 160)
MATERIALS = {
    "grass": "grass_green",
    "asphalt": "asphalt_road",
    "pavement": "concrete",
    "kerb": "concrete",
    "brick": "brick_red",
    "plaster": "concrete",
    "roof": "paint_white_on_metal",
    "van": "paint_white_on_metal",
}
PARTS = runpy.run_path(str(STREET / "make_street.py"))["parts"]()
VIEW = {"position": [66, -2, 22], "look_at": [0, 0, 2], "field_of_view_deg": 60}


@pytest.fixture(scope="module")
def street(tmp_path_factory):
    """Folder of the built street, and its picture by the rays of this project."""
    folder = tmp_path_factory.mktemp("frame") / "street"
    runner = CliRunner()
    assert runner.invoke(main, ["init", str(folder), "--example", "street"]).exit_code == 0
    job = dict(read_yaml(folder / "job.yaml").data) | {"output": {"folder": "built", "pictures": False}}
    (folder / "job.yaml").write_text(yaml.safe_dump(job | {"bands": job["bands"][1:]}))
    done = runner.invoke(main, ["build", str(folder / "job.yaml")], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    scene = dict(read_yaml(folder / "scene.yaml").data) | {"hours": [HOUR]}
    scene["camera"]["perspective"] |= {"size": list(SIZE), "samples": 1}
    return folder, next(skyshine.Scene(scene, folder=folder).frames())


def frame_of(folder, renderer, buffers, materials):
    """The picture of a frame in the folder of the street."""
    model = {
        "skyshine_frame": 1,
        "name": renderer,
        "databases": "built",
        "renderer": renderer,
        "altitude_km": 0.171,
        "camera": VIEW,
        "buffers": buffers,
        "materials": materials,
        "mesh": {"file": "street.glb", "materials": MATERIALS},
        "hours": [HOUR],
    }
    ((_, picture),) = skyshine.Frame(model, folder=folder).pictures()
    return picture


def compare(name, drawn, picture):
    """Print and judge the differences away from edges: where no neighbour of a pixel differs by more than 1 K."""
    kelvin = drawn.apparent_temperature
    edge = np.zeros(kelvin.shape, bool)
    for axis in (0, 1):
        step = np.abs(np.diff(kelvin, axis=axis)) > 1.0
        for after in (0, 1):
            widths = [(0, 0), (0, 0)]
            widths[axis] = (after, 1 - after)
            edge |= np.pad(step, widths)
    difference = picture.apparent_temperature - kelvin
    inside = np.sqrt(np.mean(difference[~edge] ** 2))
    print(
        f"\n{name}: rms {inside:.5f} K in {np.mean(~edge):.1%} of the pixels, away from edges; of all"
        f" {np.sqrt(np.mean(difference**2)):.5f} K, largest {np.abs(difference).max():.3f} K"
    )
    assert np.mean(~edge) > 0.85 and inside <= 0.05


def test_a_frame_of_mitsuba_is_the_picture_of_the_street(street):
    mitsuba = pytest.importorskip("mitsuba")
    mitsuba.set_variant("scalar_rgb")
    folder, drawn = street
    shapes = {}
    for name, triangles in PARTS.items():
        points = triangles.reshape(-1, 3).astype(np.float32)
        mesh = mitsuba.Mesh(name, len(points), len(triangles))
        values = mitsuba.traverse(mesh)
        values["vertex_positions"], values["faces"] = points.ravel(), np.arange(len(points), dtype=np.uint32)
        values.update()
        mesh.write_ply(str(folder / f"{name}.ply"))
        shapes[name] = {"type": "ply", "filename": str(folder / f"{name}.ply"), "face_normals": True}
    film = {
        "type": "hdrfilm",
        "width": SIZE[0],
        "height": SIZE[1],
        "rfilter": {"type": "box"},
        "component_format": "float32",
    }
    looking = mitsuba.ScalarTransform4f().look_at(VIEW["position"], VIEW["look_at"], [0, 0, 1])
    sensor = {"type": "perspective", "fov": 60, "fov_axis": "x", "to_world": looking, "film": film}
    sensor["sampler"] = {"type": "stratified", "sample_count": 1, "jitter": False}
    integrator = {"type": "aov", "aovs": "depth:depth,normal:sh_normal,shape:shape_index"}
    scene = mitsuba.load_dict({"type": "scene", "integrator": integrator, "sensor": sensor, **shapes})
    mitsuba.render(scene)
    scene.sensors()[0].film().write(str(folder / "mitsuba.exr"))
    names = {number: shape.id() for number, shape in enumerate(scene.shapes(), start=1)}
    (folder / "shapes.json").write_text(json.dumps(names))
    layers = {"depth": "depth", "normals": "normal", "ids": "shape"}
    buffers = {key: {"file": "mitsuba.exr", "layer": layer} for key, layer in layers.items()}
    buffers["ids"]["labels"] = "shapes.json"
    compare("Mitsuba", drawn, frame_of(folder, "mitsuba", buffers, MATERIALS))


def test_a_frame_of_blender_is_the_picture_of_the_street(street):
    bpy = pytest.importorskip("bpy")
    from mathutils import Vector

    folder, drawn = street
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, layer = bpy.context.scene, bpy.context.view_layer
    for number, (name, triangles) in enumerate(PARTS.items(), start=1):
        mesh = bpy.data.meshes.new(name)
        points = triangles.reshape(-1, 3)
        mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
        mesh.materials.append(bpy.data.materials.new(name))
        mesh.materials[0].pass_index = number
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    lens = bpy.data.cameras.new("camera")
    lens.angle, lens.clip_end = math.radians(VIEW["field_of_view_deg"]), 1e4
    scene.camera = bpy.data.objects.new("camera", lens)
    scene.collection.objects.link(scene.camera)
    scene.camera.location = VIEW["position"]
    ahead = Vector(VIEW["look_at"]) - Vector(VIEW["position"])
    scene.camera.rotation_euler = ahead.to_track_quat("-Z", "Y").to_euler()
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01  # rays through the middles of pixels
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_material_index = True
    layer.use_pass_cryptomatte_material = True
    settings = scene.render.image_settings
    settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    scene.render.filepath = str(folder / "blender.exr")
    bpy.ops.render.render(write_still=True)
    exr = {"file": "blender.exr"}
    buffers = {"depth": exr | {"layer": "ViewLayer.Depth"}, "normals": exr | {"layer": "ViewLayer.Normal"}}
    named = exr | {"layer": "ViewLayer.CryptoMaterial", "encoding": "cryptomatte"}
    compare("Blender, Cryptomatte", drawn, frame_of(folder, "blender", buffers | {"ids": named}, MATERIALS))
    numbers = {number: MATERIALS[name] for number, name in enumerate(PARTS, start=1)}
    numbered = exr | {"layer": "ViewLayer.Material Index"}
    compare("Blender, IndexMA", drawn, frame_of(folder, "blender", buffers | {"ids": numbered}, numbers))
