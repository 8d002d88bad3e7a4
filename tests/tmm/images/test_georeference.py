"""Georeferences: GeoTIFF tags as tifffile writes them, world files, and what is wrong with them."""

import numpy as np
import pytest
import tifffile

from skyshine.schemas.errors import InputError
from skyshine.tmm import open_tmm
from skyshine.tmm.images.georeference import read_georeference
from skyshine.tmm.job.model import TextureJob


def _geotiff(path, raster_type, **more):
    keys = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, raster_type, 3072, 0, 1, 32633]
    tags = [
        (33550, "d", 3, (0.5, 0.25, 0.0), True),
        (33922, "d", 6, (2.0, 3.0, 0.0, 500000.0, 5500000.0, 0.0), True),
        (34735, "H", len(keys), tuple(keys), True),
    ]
    tifffile.imwrite(path, np.full((8, 9, 3), 90, np.uint8), photometric="rgb", extratags=tags, **more)


@pytest.mark.parametrize("raster_type, shift", [(1, (0, 0)), (2, (0.25, 0.125))])
def test_geotiff(tmp_path, raster_type, shift):
    _geotiff(tmp_path / "a.tif", raster_type)
    found = read_georeference(tmp_path / "a.tif")
    a, b, c, d, e, f = found.affine
    assert found.crs == "EPSG:32633" and (a, b, d, e) == (0.5, 0, 0, -0.25)
    # The tie point, texel (2, 3), lies at (500000, 5500000): its corner, or its centre where a pixel is a point.
    assert a * 2 + c == pytest.approx(500000 - shift[0]) and e * 3 + f == pytest.approx(5500000 + shift[1])


def test_kept_in_the_database(tmp_path, build):
    _geotiff(tmp_path / "a.tif", 1, tile=(16, 16))
    result = build(TextureJob.model_validate({"image": "a.tif", "material": "concrete"}))
    with open_tmm(result.path) as file:
        assert file.attributes["geo_crs"] == "EPSG:32633"
        np.testing.assert_allclose(file.attributes["geo_affine"], [0.5, 0, 499999, 0, -0.25, 5500000.75])


@pytest.mark.parametrize("ending", ["pgw", "PGW", "pngw", "wld"])
def test_world_file(tmp_path, write_image, ending):
    path = tmp_path / write_image("a.png", np.zeros((4, 4, 3), np.uint8))
    assert read_georeference(path) is None
    path.with_suffix(f".{ending}").write_text("2.0\n0.0\n0.0\n-2.0\n101.0\n199.0\n")
    # The numbers give the centre of the first texel; its corner is one unit to the left and above.
    assert read_georeference(path).affine == (2.0, 0.0, 100.0, 0.0, -2.0, 200.0)


@pytest.mark.parametrize(
    "text, message", [("1 2 3", "six numbers"), ("a b c d e f", "six numbers"), ("1 0 0 0 5 5", "to a line")]
)
def test_wrong_world_file(tmp_path, write_image, text, message):
    path = tmp_path / write_image("a.png", np.zeros((4, 4, 3), np.uint8))
    path.with_suffix(".pgw").write_text(text)
    with pytest.raises(InputError, match=message):
        read_georeference(path)
