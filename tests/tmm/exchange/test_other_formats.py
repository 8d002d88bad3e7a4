"""Indexed PNG, DIRSIG and glTF, each decoded again by what its own specification says."""

import itertools
import json
import struct
from dataclasses import replace

import numpy as np
import pytest

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Level
from skyshine.tmm.exchange.dirsig import write_dirsig
from skyshine.tmm.exchange.gltf import write_gltf
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.indexed_png import write_png


@pytest.fixture
def image(library):
    """6 x 9 with no material, one, and mixtures."""
    names = {22: "asphalt_road", 68: "grass_green", 81: "water_sea"}
    mix_code = np.zeros((6, 9, 3), np.uint16)
    mix_weight = np.zeros((6, 9, 3), np.uint16)
    mix_code[..., 0] = np.array([0, 22, 68, 81, 22, 68, 81, 81, 22])
    mix_weight[..., 0] = WEIGHT_TOTAL
    mix_code[5, 1:, 1], mix_weight[5, 1:] = np.array([68, 81, 22, 68, 81, 22, 22, 68]), [WEIGHT_TOTAL - 16384, 16384, 0]
    return MaterialImage("patch", names, Level(mix_code[..., 0].copy(), mix_code, mix_weight))


def many(count: int) -> MaterialImage:
    codes = np.arange(1, count + 1, dtype=np.uint16)[np.newaxis]
    mix_code, mix_weight = (np.zeros((1, count, 3), np.uint16) for _ in range(2))
    mix_code[..., 0], mix_weight[..., 0] = codes, WEIGHT_TOTAL
    return MaterialImage("many", {k: f"m{k}" for k in range(1, count + 1)}, Level(codes, mix_code, mix_weight))


def test_indexed_png_gives_the_same_bytes(image, tmp_path):
    picture, legend = write_png(tmp_path, image)
    entries = json.loads(legend.read_text())["materials"]
    assert [entry["code"] for entry in entries.values()] == [22, 68, 81]
    first = [path.read_bytes() for path in (picture, legend)]
    assert [path.read_bytes() for path in write_png(tmp_path, image)] == first


def test_palette_colours_match_the_legend(image, tmp_path):
    import OpenImageIO as oiio

    picture, legend = write_png(tmp_path, image)
    colours = oiio.ImageBuf(str(picture)).get_pixels(oiio.UINT8)[..., :3]
    for entry in json.loads(legend.read_text())["materials"].values():
        shown = np.unique(colours[image.level.code == entry["code"]], axis=0)
        assert ["#{:02X}{:02X}{:02X}".format(*colour) for colour in shown] == [entry["colour"]]


def test_dirsig_maps(image, tmp_path):
    counts, table, cube, header, legend = write_dirsig(tmp_path, image)
    magic, size, maximum, rest = counts.read_bytes().split(b"\n", 3)
    assert (magic, size, maximum) == (b"P5", b"9 6", b"255")
    counted = np.frombuffer(rest, np.uint8).reshape(6, 9)
    labels = dict(line.split() for line in table.read_text().splitlines())
    assert {int(k): name for k, name in labels.items()} == {1: "asphalt_road", 2: "grass_green", 3: "water_sea"}
    for number, code in ((0, 0), (1, 22), (2, 68), (3, 81)):
        assert np.array_equal(counted == number, image.level.code == code)
    fields = dict(line.split(" = ") for line in header.read_text().splitlines()[1:])
    shape = tuple(int(fields[key]) for key in ("bands", "lines", "samples"))
    bands = np.fromfile(cube, "<f4").reshape(shape)
    assert fields["data type"] == "4" and fields["byte order"] == "0" and fields["interleave"] == "bsq"
    assert np.allclose(bands.sum(axis=0), image.level.code > 0)
    assert bands[1, 5, 1] == pytest.approx(0.25, abs=1e-4) and bands[0, 5, 1] == pytest.approx(0.75, abs=1e-4)
    assert json.loads(legend.read_text())["mixture"] == cube.name


def test_gltf_feature_ids_lead_to_names(image, tmp_path):
    document, content, picture = _load_gltf(write_gltf(tmp_path, image))
    assert set(document["extensionsUsed"]) == {"EXT_mesh_features", "EXT_structural_metadata"}
    primitive = document["meshes"][0]["primitives"][0]
    ids = primitive["extensions"]["EXT_mesh_features"]["featureIds"][0]
    sampler = document["samplers"][document["textures"][ids["texture"]["index"]]["sampler"]]
    assert sampler["magFilter"] == sampler["minFilter"] == 9728  # NEAREST: IDs must not be interpolated
    metadata = document["extensions"]["EXT_structural_metadata"]
    table = metadata["propertyTables"][ids["propertyTable"]]
    described = metadata["schema"]["classes"][table["class"]]["properties"]
    assert set(table["properties"]) == set(described) and table["count"] == ids["featureCount"] == 3
    read = sum(picture[..., channel].astype(int) << 8 * k for k, channel in enumerate(ids["texture"]["channels"]))
    names = _strings(document, content, table["properties"]["name"], table["count"])
    codes = np.frombuffer(_view(document, content, table["properties"]["code"]["values"]), "<u2")
    for k, (code, name) in enumerate(zip(codes, names, strict=True)):
        assert image.materials[code] == name and np.array_equal(read == k, image.level.code == code)
    assert np.array_equal(read == ids["nullFeatureId"], image.level.code == 0)
    for view in document["bufferViews"]:
        assert (
            view["byteOffset"] % 8 == 0
            and view["byteOffset"] + view["byteLength"] <= document["buffers"][0]["byteLength"]
        )
    share = np.frombuffer(_view(document, content, table["properties"]["share"]["values"]), "<f4")
    assert share.sum() == pytest.approx(8 / 9)


def test_gltf_counts_beyond_one_channel(tmp_path):
    document, _, picture = _load_gltf(write_gltf(tmp_path, many(300)))
    ids = document["meshes"][0]["primitives"][0]["extensions"]["EXT_mesh_features"]["featureIds"][0]
    assert ids["texture"]["channels"] == [0, 1] and ids["nullFeatureId"] == 300
    assert np.array_equal(picture[0, :, 0] + 256 * picture[0, :, 1].astype(int), np.arange(300))


def test_too_many_materials(tmp_path):
    for write in (write_png, write_dirsig):
        with pytest.raises(InputError, match="'many' has 256 materials; allowed .*: 255"):
            write(tmp_path, many(256))
        write(tmp_path, many(255))


def test_unwritable_folder(image, tmp_path):
    (tmp_path / "file").write_text("")
    for write in (write_png, write_dirsig, write_gltf):
        with pytest.raises(InputError, match="cannot be written"):
            write(tmp_path / "file", replace(image, name="x"))


def _load_gltf(paths):
    import io

    from PIL import Image

    raw = paths[0].read_bytes()
    magic, version, length = struct.unpack_from("<4sII", raw)
    assert (magic, version, length) == (b"glTF", 2, len(raw))
    size, kind = struct.unpack_from("<I4s", raw, 12)
    assert kind == b"JSON" and size % 4 == 0
    document = json.loads(raw[20 : 20 + size])
    rest, kind = struct.unpack_from("<I4s", raw, 20 + size)
    assert kind == b"BIN\0" and rest % 4 == 0 and 28 + size + rest == len(raw)
    content = raw[28 + size :]
    picture = np.array(Image.open(io.BytesIO(_view(document, content, document["images"][0]["bufferView"]))))
    return document, content, picture


def _view(document, content, number) -> bytes:
    view = document["bufferViews"][number]
    return content[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]


def _strings(document, content, stored, count) -> list[str]:
    offsets = np.frombuffer(_view(document, content, stored["stringOffsets"]), "<u4")
    text = _view(document, content, stored["values"])
    assert stored["stringOffsetType"] == "UINT32" and len(offsets) == count + 1
    return [text[a:b].decode() for a, b in itertools.pairwise(offsets)]
