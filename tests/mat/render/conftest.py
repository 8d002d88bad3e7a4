"""Textures, meshes and scenes of a few pixels."""

import json
import struct

import numpy as np
import pytest
from PIL import Image

from skyshine.mat.render.scene_file import load_scene
from skyshine.materials.library import load_library
from skyshine.tmm import TextureJob, map_texture, write_texture


@pytest.fixture(scope="session")
def plain_texture(tmp_path_factory):
    """Path of a texture of 8 x 4 texels, all of asphalt."""
    folder = tmp_path_factory.mktemp("texture")
    Image.new("RGB", (8, 4), (90, 90, 90)).save(folder / "road.png")
    job = TextureJob(image="road.png", material="asphalt_road")
    path = folder / "road.tmm.h5"
    write_texture(map_texture(job, folder, load_library()), path)
    return path


def halves(folder, colours):
    """Path of a texture of 8 x 4 texels, red in its left half and green in its right, by materials of colours."""
    image = Image.new("RGB", (8, 4), (200, 0, 0))
    image.paste((0, 200, 0), (4, 0, 8, 4))
    image.save(folder / "halves.png")
    job = TextureJob(image="halves.png", palette={"colours": colours})
    write_texture(map_texture(job, folder, load_library()), folder / "halves.tmm.h5")
    return folder / "halves.tmm.h5"


@pytest.fixture(scope="session")
def two_materials(tmp_path_factory):
    """Path of a texture, its left half of asphalt and its right half of grass."""
    return halves(tmp_path_factory.mktemp("halves"), {"#C80000": "asphalt_road", "#00C800": "grass_green"})


@pytest.fixture(scope="session")
def half_known(tmp_path_factory):
    """Path of a texture, its left half of asphalt and its right half of no material."""
    return halves(tmp_path_factory.mktemp("half_known"), {"#C80000": "asphalt_road"})


def glb(parts, path):
    """Write a binary glTF file of parts: (material name, corners (F, 3, 3), texture coordinates or None)."""
    blob, views, accessors, meshes, materials = b"", [], [], [], []
    for name, corners, uv in parts:
        attributes = {}
        for key, values, kind in (("POSITION", corners, "VEC3"), ("TEXCOORD_0", uv, "VEC2")):
            if values is None:
                continue
            flat = np.asarray(values, "<f4").reshape(-1, 3 if kind == "VEC3" else 2)
            attributes[key] = len(accessors)
            accessor = {"bufferView": len(views), "componentType": 5126, "count": len(flat), "type": kind}
            limits = {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()} if len(flat) else {}
            accessors.append(accessor | limits)
            views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": flat.nbytes})
            blob += flat.tobytes()
        meshes.append({"primitives": [{"attributes": attributes, "material": len(materials)}]})
        materials.append({"name": name})
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [{"mesh": number} for number in range(len(meshes))],
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x004E4942) + blob
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
    return path


@pytest.fixture(scope="session")
def write_glb():
    return glb


@pytest.fixture
def scene_of(plain_texture):
    """Factory of a loaded scene: a plan of the plain texture, with changes of its top keys."""

    def make(**changes):
        content = {
            "skyshine_scene": 1,
            "name": "test",
            "surface": {"altitude_km": 0.1, "plan": {"texture": str(plain_texture), "metres_per_texel": 2.0}},
            "camera": {"plan_view": {"height_m": 500.0, "size": [8, 4]}},
        }
        return load_scene(content | changes)

    return make


@pytest.fixture(scope="session")
def one_material(tiny_job, build_once):
    """Folder of the databases of asphalt alone, whose tables hold the Sun at every hour."""
    text = tiny_job().replace("source_elevation_deg: [-20, 60]", "source_elevation_deg: [-20, 0, 30, 60, 90]")
    return build_once("one_material", text.replace("[00:00, 12:00]", "[00:00, 04:00, 08:00, 12:00, 16:00, 20:00]"))
