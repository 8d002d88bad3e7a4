"""Reading of textures: types, encodings, transparency, and files that are no textures."""

import shutil
import struct
import zlib

import numpy as np
import pytest

from skyshine.schemas.errors import InputError
from skyshine.tmm.features.colour import DistinctColours, to_lab
from skyshine.tmm.images.texture import Texture


@pytest.mark.parametrize("ending", ["png", "tif"])
@pytest.mark.parametrize("kind", ["uint8", "uint16"])
def test_integers_come_back_as_stored(write_image, tmp_path, ending, kind, read):
    values = np.random.default_rng(0).integers(0, np.iinfo(kind).max, (7, 9, 3), dtype=kind)
    texture = read(tmp_path / write_image(f"a.{ending}", values, kind))
    assert texture.pixels.dtype == kind and texture.encoding == "srgb" and texture.valid.all()
    np.testing.assert_array_equal(texture.pixels, values)


def test_jpeg_is_read(write_image, tmp_path, read):
    texture = read(tmp_path / write_image("a.jpg", np.full((16, 16, 3), 128, np.uint8)))
    assert np.abs(texture.pixels.astype(int) - 128).max() <= 2


def test_float_is_linear_and_not_finite_is_no_data(write_image, tmp_path, read):
    values = np.full((4, 5, 3), 0.5, np.float32)
    values[1, 2, 0], values[3, 4, 2] = np.nan, np.inf
    texture = read(tmp_path / write_image("a.tif", values, "float"))
    assert texture.encoding == "linear"
    assert sorted(zip(*np.nonzero(~texture.valid), strict=True)) == [(1, 2), (3, 4)]


def test_transparent_texels_keep_their_colour_and_have_no_data(write_image, tmp_path, read):
    values = np.full((2, 3, 4), 200, np.uint8)
    values[..., 3] = [[0, 127, 128], [255, 255, 255]]
    name = write_image("a.tif", values)
    texture = read(tmp_path / name)
    np.testing.assert_array_equal(texture.valid, [[False, False, True], [True, True, True]])
    assert read(tmp_path / name, alpha="ignore").valid.all()


def test_colours_are_not_multiplied_by_alpha(tmp_path, read):
    row = bytes([0, 200, 100, 50, 64])
    _write_png(tmp_path / "a.png", 1, 1, 6, row)
    np.testing.assert_array_equal(read(tmp_path / "a.png").pixels[0, 0], [200, 100, 50])


def _write_png(path, width, height, colour_type, raw, chunks=()):
    def chunk(tag, data):
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    header = struct.pack(">IIBBBBB", width, height, 8, colour_type, 0, 0, 0)
    parts = [
        chunk(b"IHDR", header),
        *(chunk(*c) for c in chunks),
        chunk(b"IDAT", zlib.compress(raw)),
        chunk(b"IEND", b""),
    ]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))


def _dds(values):
    """An uncompressed DDS of (H, W, 4) uint8, blue first in the file (Microsoft, "DDS_HEADER structure")."""
    height, width, _ = values.shape
    masks = (0x00FF0000, 0x0000FF00, 0x000000FF, 0xFF000000)
    pixel_format = struct.pack("<8I", 32, 0x40 | 0x1, 0, 32, *masks)  # RGB with alpha, 32 bits
    flags = 0x1 | 0x2 | 0x4 | 0x8 | 0x1000  # caps, height, width, pitch, pixel format
    header = (
        struct.pack("<7I44x", 124, flags, height, width, 4 * width, 0, 0)
        + pixel_format
        + struct.pack("<5I", 0x1000, 0, 0, 0, 0)
    )
    return b"DDS " + header + values[..., [2, 1, 0, 3]].tobytes()


def test_dds(tmp_path, read):
    values = np.random.default_rng(1).integers(1, 256, (12, 8, 4), dtype=np.uint8)
    (tmp_path / "a.dds").write_bytes(_dds(values))
    texture = read(tmp_path / "a.dds", alpha="no-data")
    np.testing.assert_array_equal(texture.pixels, values[..., :3])
    np.testing.assert_array_equal(texture.valid, values[..., 3] >= 127.5)
    (tmp_path / "b.dds").write_bytes(_dds(values)[:200])
    with pytest.raises(InputError, match="damaged or cut short|is not an image"):
        read(tmp_path / "b.dds")


def test_gamma_of_the_file_is_honoured(tmp_path, read):
    _write_png(tmp_path / "a.png", 1, 1, 2, bytes([0, 128, 128, 128]), [(b"gAMA", struct.pack(">I", 45455))])
    texture = read(tmp_path / "a.png")
    lab = to_lab(texture.pixels[0], texture.encoding)
    # CIE lightness of a grey of luminance (128/255)^2.2.
    assert lab[0, 0] == pytest.approx(116 * (128 / 255) ** (2.2 / 3) - 16, abs=0.01)


def test_grey_image_is_repeated(write_image, tmp_path, read):
    texture = read(tmp_path / write_image("a.png", np.full((3, 3, 1), 7, np.uint8)))
    assert texture.pixels.shape == (3, 3, 3) and (texture.pixels == 7).all()


def test_ending_does_not_matter(write_image, tmp_path, read):
    shutil.copy(tmp_path / write_image("a.jpg", np.full((8, 8, 3), 90, np.uint8)), tmp_path / "b.png")
    assert read(tmp_path / "b.png").pixels.shape == (8, 8, 3)


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif"])
def test_cut_short(write_image, tmp_path, name, capfd, read):
    values = np.random.default_rng(0).integers(0, 255, (80, 80, 3), dtype=np.uint8)
    path = tmp_path / write_image(name, values)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(InputError, match="damaged or cut short|is not an image") as caught:
        read(path)
    assert "\n" not in str(caught.value) and capfd.readouterr().err == ""


@pytest.mark.parametrize("name, content", [("a.png", b"hello"), ("a.tif", b""), ("a.txt", b"text"), ("a", b"text")])
def test_not_an_image(tmp_path, name, content, read):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match="is not an image"):
        read(tmp_path / name)


def test_missing(tmp_path, read):
    with pytest.raises(InputError, match="does not exist"):
        read(tmp_path / "a.png")


@pytest.mark.parametrize(
    "rgb, lab",
    [
        ((255, 255, 255), (100, 0, 0)),
        ((0, 0, 0), (0, 0, 0)),
        ((255, 0, 0), (53.24, 80.09, 67.20)),
        ((0, 255, 0), (87.73, -86.18, 83.18)),
        ((0, 0, 255), (32.30, 79.19, -107.86)),
    ],
)
def test_lab_of_the_srgb_primaries(rgb, lab):
    # Published CIELAB (D65) coordinates of the sRGB primaries; linear light of the same colours agrees.
    np.testing.assert_allclose(to_lab(np.array([rgb], np.uint8), "srgb")[0], lab, atol=0.02)
    np.testing.assert_allclose(to_lab(np.array([rgb], np.float32) / 255, "linear")[0], lab, atol=0.02)


@pytest.mark.parametrize("kind", ["uint8", "uint16", "float32"])
def test_distinct_colours_give_back_each_texel(kind):
    random = np.random.default_rng(3)
    pixels = random.integers(0, 6, (30, 20, 3)).astype(kind) * (40 if kind != "float32" else 0.1)
    pixels = pixels.astype(kind)
    texture = Texture(pixels, np.ones((30, 20), bool), "srgb")
    colours = DistinctColours(texture)
    shared, index = colours.of(*texture.window(slice(5, 25), slice(2, 19)))
    shared = colours.colours if shared is None else shared
    np.testing.assert_array_equal(shared[index], pixels[5:25, 2:19])
    if kind != "float32":
        assert len(np.unique(shared, axis=0)) == len(shared)
