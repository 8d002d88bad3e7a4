"""Forty forms of image files, each made here: what it is taken to be, or the one true line that refuses it."""

import json
import re
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio
import pytest
import rasterio
import tifffile
from click.testing import CliRunner
from PIL import Image

from skyshine.tmm.cli import main
from skyshine.tmm.images.gdal import quiet

HEIGHT, WIDTH = 48, 64
SEEDS = {
    "grass_green": [[[4, 4], [20, 4], [20, 40], [4, 40]]],
    "asphalt_road": [[[40, 4], [60, 4], [60, 40], [40, 40]]],
}


def colours(dtype=np.uint8, white=255, channels=3, seed=0):
    """Grass on the left, asphalt on the right, with noise."""
    values = np.empty((HEIGHT, WIDTH, channels))
    values[:, : WIDTH // 2] = np.array([60, 140, 50, 200])[:channels]
    values[:, WIDTH // 2 :] = np.array([120, 120, 125, 60])[:channels]
    values = (values + np.random.default_rng(seed).normal(0, 6, values.shape)).clip(1, 254) / 255
    return values.astype(dtype) if np.dtype(dtype).kind == "f" else (values * white).astype(dtype)


def gdal(name, values, no_data=None, mask=None, **more):
    def write(folder):
        profile = {"driver": "GTiff", "height": HEIGHT, "width": WIDTH, "count": values.shape[2], "dtype": values.dtype}
        with quiet(), rasterio.open(folder / name, "w", nodata=no_data, **profile, **more) as file:
            file.write(np.moveaxis(values, -1, 0))
            if mask is not None:
                file.write_mask(mask)
        return name

    return write


def tiff(name, values, **more):
    return lambda folder: (tifffile.imwrite(folder / name, values, **more), name)[1]


def openimageio(name, values, kind=None):
    def write(folder):
        output = oiio.ImageOutput.create(str(folder / name))
        if output is None:
            pytest.skip(f"this OpenImageIO does not write {name}")
        spec = oiio.ImageSpec(
            WIDTH, HEIGHT, values.shape[2], kind or {"f": "float"}.get(values.dtype.kind, str(values.dtype))
        )
        assert output.open(str(folder / name), spec) and output.write_image(np.ascontiguousarray(values)), (
            output.geterror()
        )
        output.close()
        return name

    return write


def pillow(name, values, mode=None, **more):
    def write(folder):
        image = Image.fromarray(values)
        (image.quantize(16) if mode == "P" else image.convert(mode) if mode else image).save(folder / name, **more)
        return name

    return write


def raw(name, content):
    return lambda folder: ((folder / name).write_bytes(content), name)[1]


def cut(alpha):
    """Colours with a fourth channel."""
    return np.concatenate([colours(), alpha[..., np.newaxis].astype(np.uint8)], axis=2)


HOLE = np.zeros((HEIGHT, WIDTH), bool)
HOLE[:, 28:32] = True  # beside the seeds
HEIGHTS = np.linspace(20, 235, HEIGHT * WIDTH).reshape(HEIGHT, WIDTH)
COLLAR = np.where(HOLE[..., np.newaxis], 0, colours())
EDGED = colours()
EDGED[:3], EDGED[:, :2] = 0, 0
DEEP = np.concatenate([colours(np.uint16, 65535), np.full((HEIGHT, WIDTH, 1), 255, np.uint16)], axis=2)
DEEP[:, 28:32, 3] = 0
RGB = {"photometric": "rgb"}

# What writes a file; what `tmm check` says it is taken to be; the share of texels without data, by reason.
READ = {
    "8 bit PNG": (pillow("a.png", colours()), {}, {}),
    "grey PNG": (pillow("a.png", colours()[..., 0]), {"colours": "Y, Y, Y"}, {}),
    "PNG with cut-outs": (
        pillow("a.png", cut(255 * ~HOLE)),
        {"alpha": "A (the file says alpha, and it has two"},
        {"alpha": 1 / 16},
    ),
    "PNG that is transparent in part": (
        pillow("a.png", cut(np.where(HOLE, HEIGHTS, 255))),
        {"alpha": "A (the file says"},
        {"alpha": None},
    ),
    "albedo with heights in alpha": (
        pillow("a.png", cut(HEIGHTS)),
        {"not used": "A (the file says alpha, and 0 %"},
        {},
    ),
    "TGA with heights in alpha": (openimageio("a.tga", cut(HEIGHTS)), {"not used": "A"}, {}),
    "palette PNG": (pillow("a.png", colours(), "P"), {"colours": "R, G, B"}, {}),
    "palette TIFF": (pillow("a.tif", colours(), "P"), {"colours": "R, G, B"}, {}),
    "JPEG": (pillow("a.jpg", colours(), quality=95), {}, {}),
    "progressive JPEG": (pillow("a.jpg", colours(), quality=95, progressive=True), {}, {}),
    "BMP": (pillow("a.bmp", colours()), {}, {}),
    "WebP": (pillow("a.webp", colours(), lossless=True), {}, {}),
    "GIF": (pillow("a.gif", colours(), "P"), {}, {}),
    "PGM": (raw("a.pgm", b"P5\n64 48\n255\n" + colours()[..., 0].tobytes()), {"colours": "Y, Y, Y"}, {}),
    "PPM": (raw("a.ppm", b"P6\n64 48\n255\n" + colours().tobytes()), {}, {}),
    "EXR": (openimageio("a.exr", colours(np.float32), "half"), {"encoding": "linear"}, {}),
    "Radiance HDR": (openimageio("a.hdr", colours(np.float32)), {"encoding": "linear"}, {}),
    "16 bit PNG": (openimageio("a.png", colours(np.uint16, 65535)), {}, {}),
    "11 bit in 16": (tiff("a.tif", colours(np.uint16, 2047), **RGB), {"white": "2047 of 65535"}, {}),
    "12 bit in 16": (tiff("a.tif", colours(np.uint16, 4095), **RGB), {"white": "4095 of 65535"}, {}),
    "reflectance times 10,000": (tiff("a.tif", colours(np.uint16, 10000), **RGB), {"white": "10000 of 65535"}, {}),
    "16 bit with alpha to 255": (
        tiff("a.tif", DEEP, extrasamples=["unassalpha"], **RGB),
        {"alpha": "A"},
        {"alpha": 1 / 16},
    ),
    "RGB and near infrared by GDAL": (
        gdal("a.tif", colours(channels=4)),
        {"near infrared": "A (the file says alpha, and"},
        {},
    ),
    "RGB and an unnamed fourth": (
        tiff("a.tif", colours(channels=4), extrasamples=["unspecified"], **RGB),
        {"near infrared": ""},
        {},
    ),
    "RGB and a mask in the fourth": (
        tiff("a.tif", cut(255 * ~HOLE), extrasamples=["unspecified"], **RGB),
        {"alpha": ""},
        {"alpha": 1 / 16},
    ),
    "RGBA TIFF": (
        tiff("a.tif", cut(255 * ~HOLE), extrasamples=["unassalpha"], **RGB),
        {"alpha": ""},
        {"alpha": 1 / 16},
    ),
    "no-data value": (gdal("a.tif", COLLAR, no_data=0), {"no data": "0"}, {"no-data value": 1 / 16}),
    "mask of GDAL": (gdal("a.tif", colours(), mask=~HOLE), {"mask": "where it is 0"}, {"mask": 1 / 16}),
    "JPEG in TIFF with a collar": (
        gdal("a.tif", EDGED, no_data=0, compress="jpeg", photometric="ycbcr", interleave="pixel", jpeg_quality=75),
        {"no data": "0 and near it on the collar"},
        {"no-data value": None, "collar": None},
    ),
    "ZSTD": (gdal("a.tif", colours(), compress="zstd"), {}, {}),
    "LERC": (gdal("a.tif", colours(), compress="lerc"), {}, {}),
    "LZMA": (gdal("a.tif", colours(), compress="lzma"), {}, {}),
    "tiled deflate": (gdal("a.tif", colours(), compress="deflate", tiled=True, blockxsize=16, blockysize=16), {}, {}),
    "planes apart": (tiff("a.tif", np.moveaxis(colours(), -1, 0).copy(), planarconfig="separate", **RGB), {}, {}),
    "BigTIFF": (tiff("a.tif", colours(), bigtiff=True, **RGB), {}, {}),
    "float TIFF with holes": (
        tiff("a.tif", np.where(HOLE[..., np.newaxis], np.nan, colours(np.float32)), **RGB),
        {},
        {"not finite": 1 / 16},
    ),
    "on a map": (
        gdal("a.tif", colours(), crs="EPSG:5514", transform=rasterio.transform.from_origin(-6e5, -1.1e6, 0.2, 0.2)),
        {"place": "EPSG:5514"},
        {},
    ),
}
REFUSED = {
    "KTX 2": (
        raw("a.ktx2", b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(100)),
        "is a KTX 2 texture, which is not read; save its base level",
    ),
    "half a PNG": (
        raw("a.png", b"\x89PNG\r\n\x1a\n" + bytes(20)),
        "is not an image that can be read|damaged or cut short",
    ),
    "no image": (raw("a.png", b"nothing"), "is not an image that can be read"),
    "transparent everywhere": (pillow("a.png", cut(np.zeros((HEIGHT, WIDTH)))), "has no texel with data"),
    "transparent under seeds": (
        pillow("a.png", cut(np.where(np.arange(WIDTH) < 32, 0, 255) + np.zeros((HEIGHT, 1)))),
        "has no data at 100 % of the seeds of 'grass_green'",
    ),
}


def checked(folder, image, **more):
    (folder / "job.yaml").write_text(json.dumps({"textures": [{"image": image, "seeds": {"polygons": SEEDS}, **more}]}))
    return CliRunner().invoke(main, ["check", str(folder / "job.yaml"), "--json"])


@pytest.mark.parametrize("form", READ)
def test_what_is_read_and_what_it_is_taken_to_be(tmp_path, form):
    write, taken, lost = READ[form]
    result = checked(tmp_path, write(tmp_path))
    assert result.exit_code == 0 and not result.stderr, result.output
    (report,) = json.loads(result.stdout)["textures"]
    for key, text in taken.items():
        assert report["taken_as"].get(key, "missing").startswith(text), report["taken_as"]
    found = {reason: share["value"] for reason, share in report["without_data"].items()}
    assert found.keys() == lost.keys(), found
    for reason, share in lost.items():
        assert share is None or found[reason] == pytest.approx(share)
    assert ("white" in taken) == any("taken to be white" in warning for warning in report["warnings"])
    assert len(report["seed_texels"]) == 2


@pytest.mark.parametrize("form", REFUSED)
def test_what_is_refused_is_one_true_line(tmp_path, form):
    write, message = REFUSED[form]
    result = checked(tmp_path, write(tmp_path))
    assert result.exit_code == 2, result.output
    (line,) = result.stderr.strip().splitlines()
    assert re.search(message, line), line


@pytest.mark.parametrize("white", [2047, 4095, 10000])
def test_values_of_part_of_16_bits_are_those_of_8(read, tmp_path, white):
    tifffile.imwrite(tmp_path / "a.tif", colours(np.uint16, white), **RGB)
    scaled = read(tmp_path / "a.tif", white="auto").pixels / 65535
    np.testing.assert_allclose(scaled, colours(np.float64), atol=1 / white + 1e-4)


def test_cielab_is_turned_into_red_green_and_blue(read, tmp_path):
    """Of L* 53.2, a* 80.1, b* 67.2 sRGB is pure red (255, 0, 0)."""
    lab = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    lab[:] = round(53.24 * 255 / 100), 80, 67
    tifffile.imwrite(tmp_path / "a.tif", lab, photometric="cielab")
    red, green, blue = read(tmp_path / "a.tif").pixels[5, 5].astype(int)
    assert red > 235 and green < 40 and blue < 40


def test_a_palette_image_is_keyed_by_colour_or_by_index(tmp_path, build, library):
    from skyshine.tmm.job.model import TextureJob

    index = np.where(np.arange(WIDTH) < 32, 7, 3).astype(np.uint8) + np.zeros((HEIGHT, 1), np.uint8)
    image = Image.fromarray(index)
    image.putpalette([part for k in range(256) for part in (k, 255 - k, 9)])
    image.save(tmp_path / "a.png")
    for keys in ({"7": "grass_green", "3": "asphalt_road"}, {"#07F809": "grass_green", "#03FC09": "asphalt_road"}):
        code = build(TextureJob.model_validate({"image": "a.png", "palette": {"colours": keys}})).code
        assert (code[:, :32] == library["grass_green"].code).all() and (
            code[:, 32:] == library["asphalt_road"].code
        ).all()
    wrong = {"palette": {"colours": {"#000000": "grass_green"}}, "seeds": None}
    result = checked(tmp_path, "a.png", **wrong)
    assert result.exit_code == 2 and "has no colour of the palette (#000000); it has #0" in result.stderr


def test_libraries_write_nothing_to_the_terminal(tmp_path):
    image = gdal("a.tif", colours(channels=4), no_data=0)(tmp_path)
    (tmp_path / "job.yaml").write_text(json.dumps({"textures": [{"image": image, "seeds": {"polygons": SEEDS}}]}))
    command = [sys.executable, "-m", "skyshine.tmm.cli", "check", str(tmp_path / "job.yaml")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
