"""Texels without data: GDAL's no-data value, masks in a TIFF and beside an image."""

import numpy as np
import pytest
import tifffile

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.job.model import TextureJob


def _no_data(value):
    return {"extratags": [(42113, "s", 0, value, True)]}


def _masked(path, values, mask, between=False, **more):
    """A TIFF with its mask as GDAL writes one: one bit a texel, NewSubfileType 4; an overview may stand between."""
    with tifffile.TiffWriter(path) as file:
        file.write(values, photometric="rgb", metadata=None, **more)
        if between:
            file.write(values[::2, ::2], photometric="rgb", subfiletype=1, metadata=None)
        file.write(mask, photometric="mask", subfiletype=4, metadata=None)


@pytest.fixture
def pixels():
    return np.random.default_rng(3).integers(1, 255, (40, 60, 3)).astype(np.uint8)


def test_a_texel_whose_colours_are_all_the_value_has_no_data(tmp_path, pixels, read):
    pixels[3, 4], pixels[5, 6, :2] = 0, 0
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", **_no_data("0"))
    valid = read(tmp_path / "a.tif").valid
    assert np.argwhere(~valid).tolist() == [[3, 4]]
    assert read(tmp_path / "a.tif", alpha="ignore").valid.all()


@pytest.mark.parametrize(
    "kind, stored, text",
    [
        ("uint16", 65535, "65535"),
        ("int16", -32768, "-32768"),
        ("int16", -9999, "-9999"),
        ("float32", -9999, "-9999"),
        ("float32", -3.4028234663852886e38, "-3.4028234663852886e+38"),
        ("float64", -1.7976931348623157e308, "-1.7976931348623157e+308"),
        ("float32", np.nan, "nan"),
    ],
)
def test_values_of_all_types(tmp_path, read, kind, stored, text):
    values = np.linspace(0.1, 0.9, 20 * 30 * 3).reshape(20, 30, 3)
    values = values.astype(kind) if kind.startswith("float") else (values * np.iinfo(kind).max).astype(kind)
    values[7, 8] = stored
    tifffile.imwrite(tmp_path / "a.tif", values, photometric="rgb", **_no_data(text))
    assert np.argwhere(~read(tmp_path / "a.tif").valid).tolist() == [[7, 8]]


def test_a_value_that_no_texel_can_hold_or_that_is_no_number(tmp_path, pixels, read):
    for text in ("-9999", "none", "256"):
        tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", **_no_data(text))
        assert read(tmp_path / "a.tif").valid.all()


@pytest.mark.parametrize("between", [False, True])
def test_a_mask_in_the_file(tmp_path, pixels, read, between):
    mask = np.random.default_rng(4).random((40, 60)) < 0.5
    _masked(tmp_path / "a.tif", pixels, mask, between)
    texture = read(tmp_path / "a.tif")
    assert np.array_equal(texture.valid, mask) and np.array_equal(texture.pixels, pixels)
    assert read(tmp_path / "a.tif", alpha="ignore").valid.all()


def test_windows_of_a_mask(tmp_path, pixels):
    mask = np.random.default_rng(4).random((40, 60)) < 0.5
    _masked(tmp_path / "a.tif", pixels, mask)
    file = TextureFile(tmp_path / "a.tif")
    for rows, columns in ((slice(10, 20), slice(5, 50)), (slice(30, 40), slice(0, 60)), (slice(0, 1), slice(59, 60))):
        assert np.array_equal(file.window(rows, columns)[1], mask[rows, columns])


def test_a_mask_beside_an_image(tmp_path, pixels, write_image, read):
    image = tmp_path / write_image("a.png", pixels)
    mask = np.random.default_rng(4).random((40, 60)) < 0.5
    tifffile.imwrite(tmp_path / "a.png.msk", (255 * mask).astype(np.uint8), photometric="minisblack")
    assert np.array_equal(read(image).valid, mask)


def test_a_mask_of_another_size(tmp_path, pixels, write_image, read):
    image = tmp_path / write_image("a.png", pixels)
    tifffile.imwrite(tmp_path / "a.png.msk", np.ones((40, 61), np.uint8), photometric="minisblack")
    with pytest.raises(InputError, match=r"a.png.msk: has a mask of 61 x 40; allowed: the image's 60 x 40"):
        read(image)


def test_texels_without_data_have_no_material(tmp_path, pixels, build):
    mask = np.ones((40, 60), bool)
    mask[:, :6] = False
    _masked(tmp_path / "a.tif", pixels, mask)
    built = build(TextureJob.model_validate({"image": "a.tif", "material": "concrete"}))
    assert np.array_equal(built.code > 0, mask) and built.written.with_data == mask.sum()


def test_a_mask_that_comes_goes_or_changes_makes_a_database_old(tmp_path, pixels, write_image, build, library):
    from skyshine.tmm.mapping.write import is_current

    job = TextureJob.model_validate({"image": write_image("a.png", pixels), "material": "concrete"})
    mask = np.ones((40, 60), np.uint8)

    def current():
        return is_current(built.path, job, tmp_path, library.version)

    built = build(job)
    assert current()
    tifffile.imwrite(tmp_path / "a.png.msk", mask, photometric="minisblack")
    assert not current()
    built = build(job)
    assert current()
    mask[3] = 0
    tifffile.imwrite(tmp_path / "a.png.msk", mask, photometric="minisblack")
    assert not current()
    (tmp_path / "a.png.msk").unlink()
    assert not current()
