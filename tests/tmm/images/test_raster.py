"""Images that are not kept whole give the same bytes; every format is read by rows."""

import numpy as np
import OpenImageIO as oiio
import pytest

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.raster import Raster, read_channels
from skyshine.tmm.job.model import TextureJob

GREEN, GREY = "grass_green", "asphalt_road"


@pytest.fixture
def by_rows(monkeypatch):
    """Makes every image too large to keep."""
    monkeypatch.setattr("skyshine.tmm.images.raster.KEPT_BYTES", 0)
    monkeypatch.setattr("skyshine.tmm.images.raster.PIECE_ROWS", 7)


def _photograph():
    """140 x 170 texels: no power of two."""
    random = np.random.default_rng(0)
    values = random.integers(0, 40, (140, 170, 3))
    values[:, :85] += (60, 140, 50)
    values[:, 85:] += (120, 120, 125)
    return values.astype(np.uint8)


@pytest.mark.parametrize("speed", ["fast", "best"])
def test_same_bytes(build, write_image, monkeypatch, speed):
    # Windows are of whole chunks.
    sizes = {"mapping.texture_map.BAND": 64, "mapping.texture_map.STRIP": 48}
    for name, size in (sizes | {"database.layout.CHUNK": 16, "mapping.write.CHUNK": 16}).items():
        monkeypatch.setattr(f"skyshine.tmm.{name}", size)
    seeds = {
        "polygons": {
            GREEN: [[[5, 5], [15, 5], [15, 20]], [[70, 130]]],
            GREY: [[[165, 5], [150, 60], [150, 70]], [[100, 135]]],
        }
    }
    settings = {"speed": speed, "radius": 3}
    job = TextureJob.model_validate(
        {"image": write_image("a.png", _photograph()), "seeds": seeds, "classifier": settings}
    )
    kept = build(job, "kept.h5")
    monkeypatch.setattr("skyshine.tmm.images.raster.KEPT_BYTES", 0)
    rows = build(job, "rows.h5")
    assert rows.written.digest == kept.written.digest
    assert rows.path.read_bytes() == kept.path.read_bytes()


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.tga", "a.rgb", "a.sgi", "a.bmp", "a.exr", "a.jp2"])
def test_rows_of_every_format(tmp_path, by_rows, name):
    output = oiio.ImageOutput.create(name)
    if output is None:
        pytest.skip(f"this OpenImageIO does not write {name}")
    values = np.random.default_rng(1).integers(0, 256, (90, 33, 3), dtype=np.uint8)
    spec = oiio.ImageSpec(33, 90, 3, "float" if name == "a.exr" else "uint8")
    assert output.open(str(tmp_path / name), spec) and output.write_image(values)
    output.close()
    expected = oiio.ImageBuf(str(tmp_path / name)).get_pixels(oiio.FLOAT if name == "a.exr" else oiio.UINT8)
    raster = Raster(tmp_path / name)
    for start, stop in ((0, 20), (10, 45), (60, 90), (5, 6), (0, 90)):
        np.testing.assert_array_equal(raster.rows(start, stop), expected[start:stop])


@pytest.mark.parametrize("texels", [100, 1 << 21])
def test_tiles(tmp_path, by_rows, monkeypatch, texels):
    monkeypatch.setattr("skyshine.tmm.images.raster.PIECE_TEXELS", texels)
    values = np.random.default_rng(2).integers(0, 256, (90, 33, 3), dtype=np.uint8)
    spec = oiio.ImageSpec(33, 90, 3, "uint8")
    spec.tile_width = spec.tile_height = 16
    output = oiio.ImageOutput.create("a.tif")
    assert output.open(str(tmp_path / "a.tif"), spec) and output.write_image(values)
    output.close()
    raster = Raster(tmp_path / "a.tif")
    for start, stop in ((0, 20), (10, 45), (40, 70), (60, 90), (5, 6)):
        np.testing.assert_array_equal(raster.rows(start, stop), values[start:stop])


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.tga", "a.exr"])
def test_cut_short_leaves_nothing_half_written(build, write_image, tmp_path, by_rows, name):
    image = write_image(name, _photograph(), "float" if name == "a.exr" else "uint8")
    path = tmp_path / image
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    before = set(tmp_path.iterdir())
    with pytest.raises(InputError, match="damaged or cut short|is not an image"):
        build(TextureJob.model_validate({"image": image, "material": GREY}))
    assert set(tmp_path.iterdir()) == before


def test_two_dimensional_offsets_of_an_exr(tmp_path, by_rows):
    # The data window of an EXR may start anywhere.
    values = np.random.default_rng(3).random((12, 9, 3), dtype=np.float32)
    spec = oiio.ImageSpec(9, 12, 3, "float")
    spec.x, spec.y = 5, -7
    output = oiio.ImageOutput.create("a.exr")
    assert output.open(str(tmp_path / "a.exr"), spec) and output.write_image(values)
    output.close()
    np.testing.assert_array_equal(read_channels(tmp_path / "a.exr"), values)
    np.testing.assert_array_equal(Raster(tmp_path / "a.exr").rows(3, 9), values[3:9])
