"""Meshes as programs write them: areas and texture coordinates in closed form, and what is refused by name.

Each file is a square of 40 m on the ground, two triangles, 1,600 m2, written in another of the ways that glTF and OBJ
allow.
"""

import json
import math
import struct

import numpy as np
import pytest

from skyshine.mat.render.gltf_surface import _parts
from skyshine.schemas.errors import InputError

CORNERS = np.array([[-20, 0, -20], [20, 0, -20], [20, 0, 20], [-20, 0, 20]], float)
INDEX = [0, 2, 1, 0, 3, 2]  # upward
UV = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
COMPONENT = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
KIND = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class Gltf:
    """A document that grows: one mesh on one node, its material "ground"."""

    def __init__(self, place=CORNERS, index=INDEX, uv=None, **primitive):
        self.content, self.accessors, self.views = b"", [], []
        self.primitive = {"attributes": {"POSITION": self.add(place)}, "material": 0, **primitive}
        if index is not None:
            self.primitive["indices"] = self.add(index, "uint16")
        if uv is not None:
            self.primitive["attributes"]["TEXCOORD_0"] = self.add(uv)
        self.document = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [self.primitive]}],
            "materials": [{"name": "ground"}],
            "accessors": self.accessors,
            "bufferViews": self.views,
        }

    def view(self, data):
        self.content += b"\0" * (-len(self.content) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.content), "byteLength": len(data)})
        self.content += data
        return len(self.views) - 1

    def add(self, values, kind="float32", **keys):
        values = np.asarray(values, kind)
        width = 1 if values.ndim == 1 else values.shape[1]
        shape = {"componentType": COMPONENT[kind], "count": len(values), "type": KIND[width]}
        self.accessors.append({"bufferView": self.view(values.tobytes()), **shape, **keys})
        return len(self.accessors) - 1

    def extension(self, name, required=True):
        self.document.setdefault("extensionsUsed", []).append(name)
        if required:
            self.document.setdefault("extensionsRequired", []).append(name)
        return self

    def write(self, path):
        document = self.document | {"buffers": [{"byteLength": len(self.content)}]}
        if path.suffix == ".gltf":
            document["buffers"][0]["uri"] = path.with_suffix(".bin").name.replace(" ", "%20")
            path.with_suffix(".bin").write_bytes(self.content)
            path.write_text(json.dumps(document), encoding="utf-8")
            return path
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        data = self.content + b"\0" * (-len(self.content) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
        path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
        return path


def area_vector(path):
    """Sum of the area vectors of all triangles: (0, A, 0) of a surface that faces up."""
    corners = np.concatenate([part for _, part, _ in _parts(path)])
    return 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)


def quantised(kind, normalized):
    """Positions as integers, which the node brings back to metres."""
    made = Gltf().extension("KHR_mesh_quantization")
    top = np.iinfo(kind).max
    signed = np.sign(CORNERS) * (top if normalized else 100)
    if kind.startswith("u"):
        signed = (np.sign(CORNERS) + 1) // 2 * (top if normalized else 100)
    signed = np.concatenate([signed, np.zeros((4, 1))], axis=1).astype(kind)  # padded to four bytes
    made.accessors[0] |= {"componentType": COMPONENT[kind], "normalized": normalized, "bufferView": 0}
    made.views[0] = made.views[made.view(signed.tobytes())] | {"byteStride": signed.itemsize * 4}
    step = (2 if kind.startswith("u") else 1) * (20 if normalized else 0.2)
    made.document["nodes"][0]["scale"] = [step] * 3
    return made


@pytest.mark.parametrize("kind", ["int8", "uint8", "int16", "uint16"])
@pytest.mark.parametrize("normalized", [True, False])
def test_quantised_positions(kind, normalized, tmp_path):
    path = quantised(kind, normalized).write(tmp_path / "a.glb")
    assert area_vector(path) == pytest.approx([0, 1600, 0], rel=1e-12)


@pytest.mark.parametrize(
    ("mode", "index"), [(5, [0, 3, 1, 2]), (6, [0, 3, 2, 1]), (4, INDEX), (4, None), (5, None), (6, None)]
)
def test_lists_strips_and_fans(mode, index, tmp_path):
    place = CORNERS
    if index is None:
        order = {4: INDEX, 5: [0, 3, 1, 2], 6: [0, 3, 2, 1]}[mode]
        place = CORNERS[order]
    path = Gltf(place, index, mode=mode).write(tmp_path / "a.glb")
    assert area_vector(path) == pytest.approx([0, 1600, 0])


def test_points_and_lines_beside_triangles_have_no_area(tmp_path):
    made = Gltf()
    made.document["meshes"][0]["primitives"] += [made.primitive | {"mode": mode} for mode in range(4)]
    assert area_vector(made.write(tmp_path / "a.glb")) == pytest.approx([0, 1600, 0])


def test_every_instance_is_there(tmp_path):
    """Three instances: as it is, twice as large and turned over by half a turn about x, half as large."""
    made = Gltf().extension("EXT_mesh_gpu_instancing")
    attributes = {
        "TRANSLATION": made.add([[0, 0, 0], [100, 0, 0], [0, 0, 100]]),
        "ROTATION": made.add([[0, 0, 0, 127], [127, 0, 0, 0], [0, 0, 0, 127]], "int8", normalized=True),
        "SCALE": made.add([[1, 1, 1], [2, 2, 2], [0.5, 0.5, 0.5]]),
    }
    made.document["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    path = made.write(tmp_path / "a.glb")
    assert area_vector(path) == pytest.approx([0, 1600 * (1 - 4 + 0.25), 0], abs=1e-9)
    middles = [corners.reshape(-1, 3).mean(axis=0) for _, corners, _ in _parts(path)]
    assert middles == [pytest.approx(place, abs=1e-5) for place in ([0, 0, 0], [100, 0, 0], [0, 0, 100])]


def test_a_sparse_accessor_replaces_its_values(tmp_path):
    """Half of the square's corners are written over: 40 m become 80 m along x."""
    made = Gltf()
    where, new = made.view(np.array([1, 2], "<u1").tobytes()), CORNERS[1:3] + np.array([40, 0, 0])
    sparse = {"bufferView": where, "componentType": 5121}, {"bufferView": made.view(new.astype("<f4").tobytes())}
    made.accessors[0]["sparse"] = {"count": 2, "indices": sparse[0], "values": sparse[1]}
    assert area_vector(made.write(tmp_path / "a.glb")) == pytest.approx([0, 3200, 0])


def test_morph_targets_count_by_their_weights(tmp_path):
    made = Gltf()
    made.primitive["targets"] = [{"POSITION": made.add(CORNERS)}, {"POSITION": made.add(9 * CORNERS)}]
    made.document["meshes"][0]["weights"] = [0.5, 0.0]
    assert area_vector(made.write(tmp_path / "a.glb")) == pytest.approx([0, 1600 * 1.5**2, 0])


def test_a_file_without_scenes_shows_all_its_roots(tmp_path):
    made = Gltf()
    del made.document["scenes"], made.document["scene"]
    made.document["nodes"] = [{"mesh": 0}, {"scale": [2, 1, 1], "children": [0]}, {"mesh": 0, "scale": [3, 1, 1]}]
    assert area_vector(made.write(tmp_path / "a.glb")) == pytest.approx([0, 1600 * (2 + 3), 0])


def test_nodes_turn_move_and_mirror(tmp_path):
    """A matrix in a node with children; a mirror keeps the upper side up."""
    half = math.sqrt(0.5)
    made = Gltf()
    made.document["nodes"] = [
        {"children": [1, 2], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]},
        {"mesh": 0, "scale": [-1, 1, 1]},
        {"mesh": 0, "rotation": [0, 0, half, half]},
    ]
    path = made.write(tmp_path / "a.glb")
    (_, level, _), (_, wall, _) = _parts(path)
    assert area_vector(path) == pytest.approx([-1600, 1600, 0], abs=1e-9)
    assert level.reshape(-1, 3).mean(axis=0) == pytest.approx([5, 6, 7])
    assert np.ptp(wall[..., 1]) == pytest.approx(40) and np.ptp(wall[..., 0]) == pytest.approx(0, abs=1e-9)


def transformed(tmp_path, **transform):
    made = Gltf(uv=UV).extension("KHR_texture_transform")
    made.primitive["attributes"]["TEXCOORD_3"] = made.add(UV + 7.0)
    reference = {"index": 0, "texCoord": 3, "extensions": {"KHR_texture_transform": transform}}
    made.document["materials"][0]["pbrMetallicRoughness"] = {"baseColorTexture": reference}
    ((_, _, uv),) = _parts(made.write(tmp_path / "a.glb"))
    return uv[0, 0], uv[0, 1]  # of the coordinates (0, 0) and (1, 1)


def test_the_transform_of_the_base_colour_moves_texture_coordinates(tmp_path):
    """Scale, then rotation, then offset, as the matrices of the specification."""
    origin, far = transformed(tmp_path, scale=[4, 2], offset=[0.5, 0.25], rotation=math.pi / 2, texCoord=0)
    assert origin == pytest.approx([0.5, 0.25]) and far == pytest.approx([0.5 - 2, 0.25 + 4])
    origin, far = transformed(tmp_path, offset=[1, 0])
    assert origin == pytest.approx([8, 7]) and far == pytest.approx([9, 8])


@pytest.mark.parametrize("kind", ["uint8", "uint16"])
def test_texture_coordinates_as_integers(kind, tmp_path):
    made = Gltf()
    made.primitive["attributes"]["TEXCOORD_0"] = made.add(UV * np.iinfo(kind).max, kind, normalized=True)
    ((_, _, uv),) = _parts(made.write(tmp_path / "a.glb"))
    assert uv.reshape(-1, 2) == pytest.approx(UV[INDEX])


def test_the_name_of_a_buffer_is_percent_encoded(tmp_path):
    assert area_vector(Gltf().write(tmp_path / "a square.gltf")) == pytest.approx([0, 1600, 0])


def test_names_of_materials_and_extensions_that_change_no_triangle(tmp_path):
    made = Gltf().extension("KHR_materials_unlit").extension("KHR_lights_punctual").extension("ACME_anything", False)
    assert [name for name, _, _ in _parts(made.write(tmp_path / "a.glb"))] == ["ground"]


def packed(made):
    made.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    made.extension("KHR_draco_mesh_compression")


def beside_a_plain_one(made):
    packed(made)
    plain = {key: value for key, value in made.primitive.items() if key != "extensions"}
    made.document["meshes"][0]["primitives"].insert(0, plain)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (packed, "uses KHR_draco_mesh_compression, which is not read; decompress it, as `npx @gltf-transform/cli copy"),
        (beside_a_plain_one, "uses KHR_draco_mesh_compression, which is not read; decompress it"),
        (lambda made: made.extension("EXT_meshopt_compression"), "uses EXT_meshopt_compression.*gltf-transform"),
        (lambda made: made.extension("ACME_voxels"), "uses ACME_voxels, which is not read; allowed: KHR_mesh_quanti"),
        (lambda made: made.document["nodes"][0].update(skin=0), "mesh '0' has a skin.*apply the armature"),
        (lambda made: made.primitive.update(indices=made.add([0, 1, 9], "uint16")), "index 9; allowed: 0 to 3"),
        (lambda made: made.primitive["attributes"].update(POSITION=-1), "a part refers to one that is not there"),
        (lambda made: made.accessors[0].update(count=5), "a part refers to one that is not there"),
        (lambda made: made.accessors[0].update(type="VEC2"), "a part refers to one that is not there"),
        (lambda made: made.accessors[0].update(count=10**12), "a part refers to one that is not there"),
        (lambda made: made.accessors[0].update(componentType=5130), "a part refers to one that is not there"),
        (lambda made: made.views[0].update(byteStride=1), "a part refers to one that is not there"),
        (lambda made: made.views[0].update(byteLength=10**6), "a buffer view reaches beyond its buffer"),
        (lambda made: made.views[0].update(byteOffset=-4), "a buffer view reaches beyond its buffer"),
        (lambda made: made.document["nodes"][0].update(children=[0]), "node 0 has two parents"),
        (lambda made: made.document.update(scene=4), "a part refers to one that is not there"),
        (lambda made: made.document.update(nodes=3), "a part refers to one that is not there"),
        (lambda made: made.document["nodes"][0].update(rotation=[0, 0, 0, 0]), "a part refers to one that"),
        (lambda made: made.primitive.update(mode=1), "has no triangle"),
    ],
)
def test_what_is_not_understood_is_one_line(change, words, tmp_path):
    made = Gltf()
    change(made)
    with pytest.raises(InputError, match=words) as caught:
        _parts(made.write(tmp_path / "a.glb"))
    assert "\n" not in str(caught.value)


def test_instances_beyond_the_limit_of_triangles_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("skyshine.mat.render.gltf_triangles.MAX_TRIANGLES", 7)
    made = Gltf().extension("EXT_mesh_gpu_instancing")
    attributes = {"TRANSLATION": made.add(np.zeros((4, 3)))}
    made.document["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    with pytest.raises(InputError, match="has 8 triangles or more"):
        _parts(made.write(tmp_path / "a.glb"))


VERTICES = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
LIBRARY = "newmtl ground\nKd 0.5 0.5 0.5\nmap_Kd -s 4 2 -o 0.5 photo.png\n\nnewmtl dark wall\nKd 0 0 0\n"


def obj(tmp_path, text, library=LIBRARY):
    (tmp_path / "a.obj").write_bytes(text.encode())
    if library is not None:
        (tmp_path / "my materials.mtl").write_text(library, encoding="utf-8")
    return tmp_path / "a.obj"


@pytest.mark.parametrize(
    "faces",
    [
        "f 1 4 3 2\n",
        "f 1/1 4/4 3/3 2/2\n",
        "f 1//1 4//1 3//1\nf 1//1 3//1 2//1\n",
        "f -4 -1 -2 -3\n",
        "f 1 4 \\\n3 2\n",
        "f\t1\t4\t3\t2  # a comment\n",
        "o one\nf 1 4 3\ng two\ns off\nf 1 3 2\n",
        "v 0 0 20 1 0 0\nf 1 4 5 3 2\n",  # a corner on an edge; colours of vertices
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_faces_of_obj(faces, end, tmp_path):
    path = obj(tmp_path, (VERTICES + faces).replace("\n", end))
    assert area_vector(path) == pytest.approx([0, 1600, 0])


@pytest.mark.parametrize("first", range(5))
def test_a_concave_face_keeps_its_area(first, tmp_path):
    """A square of 2 without the triangle above (1, 0.5): 4 - 1.5; a fan from the wrong corner gives 3.5."""
    ring = [[0, 0], [2, 0], [2, 2], [1, 0.5], [0, 2]]
    text = "".join(f"v {x} {y} 0\n" for x, y in ring[first:] + ring[:first]) + "f 1 2 3 4 5\n"
    ((_, corners, _),) = _parts(obj(tmp_path, text))
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert areas.sum() == pytest.approx(2.5) and np.all(areas >= 0)


def test_relative_numbers_count_from_their_line(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n"
    ((_, corners, _),) = _parts(obj(tmp_path, text))
    assert corners[:, :, 2].tolist() == [[0, 0, 0], [5, 5, 5]]


def test_materials_of_obj_and_their_texture_scales(tmp_path):
    """Texture coordinates count from the top left; those of "ground" are scaled and moved as the library says."""
    text = f"mtllib my materials.mtl\n{VERTICES}usemtl ground\nf 1/1 4/4 3/3\nusemtl dark wall\nf 1/1 3/3 2/2\n"
    parts = {name: uv for name, _, uv in _parts(obj(tmp_path, text))}
    assert parts["dark wall"][0] == pytest.approx(np.array([[0, 1], [1, 0], [1, 1]]))
    assert parts["ground"][0] == pytest.approx(np.array([[0.5, 1], [0.5, -1], [4.5, -1]]))
    without = {name: uv for name, _, uv in _parts(obj(tmp_path, text.replace("my mat", "no mat")))}
    assert sorted(without) == ["dark wall", "ground"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (VERTICES + "f 1 2 9\n", r"a\.obj:9: found 'f 1 2 9'; allowed: numbers, and vertices above this line"),
        (VERTICES + "f 1 2 0\n", r"a\.obj:9: "),
        ("f 1 2 3\n" + VERTICES, r"a\.obj:1: "),
        ("v 0 0\n", r"a\.obj:1: found 'v 0 0'"),
        ("v 0 0 nan\n", r"a\.obj:1: found 'v 0 0 nan'"),
        (VERTICES + "f 1 2\n", r"a\.obj:9: "),
        (VERTICES + "usemtl ground\nf 1/1 2/2 3/3\nf 1 3 4\n", "'ground' has corners with and without texture"),
        (VERTICES + "surf 0 1 0 1 1 2 3 4\n", r"a\.obj:9: found 'surf', a free-form curve or surface"),
        (VERTICES, "has no triangle"),
        ("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 1 1 0\nv 3 2 0\nv 3 3 0\nv 0 4 0\nv 1 3 0\nf 1 2 4 3 5 7 6 8\n", "triangulate"),
    ],
)
def test_a_wrong_obj_is_one_line(text, words, tmp_path):
    with pytest.raises(InputError, match=words):
        _parts(obj(tmp_path, text))


@pytest.mark.parametrize("names", ["a" * 300, "a" * 300 + " in.mtl", "\0", "../in.mtl"])
def test_a_library_of_materials_that_no_file_can_be_is_left_alone(names, tmp_path):
    file = tmp_path / "in.obj"
    file.write_text(f"mtllib {names}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    (part,) = _parts(file)
    assert part[1].shape == (1, 3, 3)


def test_corners_on_a_line_before_a_turn_keep_the_polygon_whole(tmp_path):
    """A concave polygon of 7 corners, two of them on an edge: its area, wherever it begins; all parts turn alike."""
    ring = [(0, 0), (2, 0), (4, 0), (4, 4), (2, 1), (0, 4), (0, 2)]
    area = 0.5 * sum(a * d - b * c for (a, b), (c, d) in zip(ring, ring[1:] + ring[:1], strict=True))
    for first in range(len(ring)):
        turned = ring[first:] + ring[:first]
        text = "".join(f"v {x} {y} 0\n" for x, y in turned) + "f 1 2 3 4 5 6 7\n"
        ((_, corners, _),) = _parts(obj(tmp_path, text))
        areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
        assert areas.sum() == pytest.approx(area) and np.all(areas >= 0)
