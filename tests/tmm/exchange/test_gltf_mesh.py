"""Material feature IDs in a mesh of the user's own, which trimesh writes and reads again."""

import base64
import io
import json
import struct

import numpy as np
import pytest
from PIL import Image

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import pure_level
from skyshine.tmm.exchange.gltf_mesh import write_mesh
from skyshine.tmm.exchange.image import MaterialImage

trimesh = pytest.importorskip("trimesh")

CODES = np.array([[22, 68, 0], [81, 81, 22]], np.uint16)
NAMES = {22: "asphalt_road", 68: "grass_green", 81: "water_sea"}


@pytest.fixture
def image():
    return MaterialImage("photo", NAMES, pure_level(CODES))


def scene(names=("photo",)):
    """A triangle for each of the photographs, and one without."""
    made = trimesh.Scene()
    for k, name in enumerate((*names, None)):
        corners = np.array([[0, 0, k], [1, 0, k], [0, 1, k]], float)
        mesh = trimesh.Trimesh(corners, [[0, 1, 2]], process=False)
        if name is not None:
            picture = Image.fromarray(np.full((2, 3, 3), 40 * (k + 1), np.uint8))
            picture.info["name"] = name
            material = trimesh.visual.material.PBRMaterial(baseColorTexture=picture, name=f"material {k}")
            mesh.visual = trimesh.visual.TextureVisuals(uv=corners[:, :2], material=material)
        made.add_geometry(mesh, geom_name=f"part {k}")
    return made


def parts(content):
    """Document and buffer of a .glb."""
    size = struct.unpack_from("<I", content, 12)[0]
    return json.loads(content[20 : 20 + size]), content[28 + size :]


def packed(document, buffer):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    buffer += b"\0" * (-len(buffer) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(buffer), 0x004E4942) + buffer
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


@pytest.fixture
def mesh(tmp_path):
    """A .glb whose images have names, changed as a test wants it."""

    def make(names=("photo",), change=lambda document: None):
        document, buffer = parts(scene(names).export(file_type="glb"))
        for each, name in zip(document["images"], names, strict=True):
            each["name"] = name
        change(document)
        path = tmp_path / "house.glb"
        path.write_bytes(packed(document, buffer))
        return path

    return make


def with_features(document):
    return [p for m in document["meshes"] for p in m["primitives"] if "EXT_mesh_features" in p.get("extensions", {})]


def test_ids_are_those_of_the_texels(image, mesh, tmp_path):
    (path,) = write_mesh(tmp_path / "out", image, mesh())
    assert path.name == "house.photo.glb"
    document, buffer = parts(path.read_bytes())
    (primitive,) = with_features(document)
    ids = primitive["extensions"]["EXT_mesh_features"]["featureIds"][0]
    view = document["bufferViews"][
        document["images"][document["textures"][ids["texture"]["index"]]["source"]]["bufferView"]
    ]
    start = view["byteOffset"]
    red = np.array(Image.open(io.BytesIO(buffer[start : start + view["byteLength"]])))[..., 0]
    codes = np.array([22, 68, 81, 0])
    assert (codes[red] == CODES).all() and ids["nullFeatureId"] == 3
    assert set(document["extensionsUsed"]) >= {"EXT_mesh_features", "EXT_structural_metadata"}


def test_the_mesh_stays_as_it_is(image, mesh, tmp_path):
    source = mesh()
    (path,) = write_mesh(tmp_path / "out", image, source)
    before, after = (trimesh.load(str(file), process=False) for file in (source, path))
    assert list(before.geometry) == list(after.geometry)
    for name in before.geometry:
        old, new = before.geometry[name], after.geometry[name]
        np.testing.assert_array_equal(old.vertices, new.vertices)
        np.testing.assert_array_equal(old.faces, new.faces)
        if getattr(old.visual, "uv", None) is not None:
            np.testing.assert_array_equal(old.visual.uv, new.visual.uv)
            shown = [np.asarray(part.visual.material.baseColorTexture) for part in (old, new)]
            np.testing.assert_array_equal(*shown)


def test_only_the_photograph_of_the_texture(image, mesh, tmp_path):
    (path,) = write_mesh(tmp_path / "out", image, mesh(("wall.png", "photo.png")))
    document, _ = parts(path.read_bytes())
    (primitive,) = with_features(document)
    colour = document["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorTexture"]
    assert document["images"][document["textures"][colour["index"]]["source"]]["name"] == "photo.png"
    other = write_mesh(tmp_path / "out", image, mesh(("wall.png", "photo.png")), "0")[0]
    document, _ = parts(other.read_bytes())
    (primitive,) = with_features(document)
    colour = document["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorTexture"]
    assert document["textures"][colour["index"]]["source"] == 0


def test_repetition_transform_and_set_of_coordinates_are_those_of_the_photograph(image, mesh, tmp_path):
    transform = {"offset": [0.1, 0.2], "scale": [2, 2]}

    def change(document):
        document["samplers"] = [{"wrapS": 33648, "wrapT": 33071, "magFilter": 9729}]
        document["extensionsUsed"] = ["KHR_texture_transform"]
        for texture in document["textures"]:
            texture["sampler"] = 0
        for material in document["materials"]:
            if colour := material.get("pbrMetallicRoughness", {}).get("baseColorTexture"):
                colour |= {"texCoord": 1, "extensions": {"KHR_texture_transform": transform}}

        for part in document["meshes"]:
            for primitive in part["primitives"]:
                if "TEXCOORD_0" in primitive["attributes"]:
                    primitive["attributes"]["TEXCOORD_1"] = primitive["attributes"]["TEXCOORD_0"]

    document, _ = parts(write_mesh(tmp_path / "out", image, mesh(change=change))[0].read_bytes())
    (primitive,) = with_features(document)
    texture = primitive["extensions"]["EXT_mesh_features"]["featureIds"][0]["texture"]
    assert texture["extensions"]["KHR_texture_transform"] == transform and texture["texCoord"] == 1
    sampler = document["samplers"][document["textures"][texture["index"]]["sampler"]]
    assert (sampler["wrapS"], sampler["wrapT"], sampler["magFilter"], sampler["minFilter"]) == (
        33648,
        33071,
        9728,
        9728,
    )


def test_buffers_and_images_of_their_own_are_taken_in(image, mesh, tmp_path):
    source = mesh()
    document, buffer = parts(source.read_bytes())
    view = document["bufferViews"][document["images"][0].pop("bufferView")]
    start = view.get("byteOffset", 0)
    (tmp_path / "photo file.png").write_bytes(buffer[start : start + view["byteLength"]])
    document["images"][0] = {"uri": "photo%20file.png"}
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    (tmp_path / "house.gltf").write_text(json.dumps(document))
    (path,) = write_mesh(tmp_path / "out", image, tmp_path / "house.gltf")
    after, _ = parts(path.read_bytes())
    assert after["images"][0]["name"] == "photo file" and "uri" not in after["images"][0]
    shown = trimesh.load(str(path), process=False).geometry["part 0"].visual.material.baseColorTexture
    assert np.asarray(shown).reshape(-1)[0] == 40
    assert len(with_features(after)) == 1


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda d: d.update(extensionsUsed=["EXT_mesh_features"]), "has EXT_mesh_features; allowed: a mesh without it"),
        (lambda d: d.update(asset={"version": "1.0"}), "is no glTF 2.0"),
        (lambda d: d["images"].clear(), "has no image 'photo'; its images: none"),
        (lambda d: d["materials"].clear(), "is damaged: a part refers to one that is not there"),
        (lambda d: d["buffers"][0].update(byteLength=10**9), "buffer 0 has .* bytes; stated: 1000000000"),
        (lambda d: d["bufferViews"][0].update(byteLength=10**6), "a buffer view reaches beyond its buffer"),
        (lambda d: d["images"][0].update(uri="../secret.png"), "leads out of the job's folder"),
        (
            lambda d: d["images"][0].update(uri="nowhere.png"),
            "does not exist; house.glb names it; put",
        ),
        (lambda d: d.update(meshes=[]), "no primitive has the photograph as its base colour"),
    ],
)
def test_a_wrong_mesh_is_one_clear_line(image, mesh, tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        write_mesh(tmp_path / "out", image, mesh(change=change))
    assert not (tmp_path / "out").exists()


def test_two_images_of_other_names(image, mesh, tmp_path):
    with pytest.raises(InputError, match="its images: a, b; say which is the photograph with --photograph"):
        write_mesh(tmp_path / "out", image, mesh(("a", "b")))


@pytest.mark.parametrize("size", [0, 3, 11, 30, 200])
def test_a_file_that_is_cut_short(image, mesh, tmp_path, size):
    path = mesh()
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(InputError, match="is cut short|is no glTF 2.0"):
        write_mesh(tmp_path / "out", image, path)
