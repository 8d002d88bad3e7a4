"""GeoTIFF, read again by tifffile and by the reader of georeferences."""

import json

import numpy as np
import pytest
import tifffile

from skyshine.schemas.errors import InputError
from skyshine.tmm import export, open_tmm
from skyshine.tmm.images.georeference import read_georeference
from skyshine.tmm.job.model import TextureJob

SCALE = [(33550, "d", 3, (0.5, 0.25, 0.0), True), (33922, "d", 6, (0.0, 0.0, 0.0, 500000.0, 5500000.0, 0.0), True)]
TURNED = [(34264, "d", 16, (0.4, 0.3, 0, 500000, 0.3, -0.4, 0, 5500000, 0, 0, 0, 0, 0, 0, 0, 1), True)]
DEGREES = [(33550, "d", 3, (1e-5, 1e-5, 0.0), True), (33922, "d", 6, (0.0, 0.0, 0.0, -110.5, 44.5, 0.0), True)]
UTM = [(34735, "H", 16, (1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633), True)]
WGS84 = [(34735, "H", 16, (1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326), True)]
LOCAL = [
    (34735, "H", 20, (1, 1, 0, 4, 1024, 0, 1, 32767, 1025, 0, 1, 1, 1026, 34737, 10, 0, 3076, 0, 1, 9001), True),
    (34737, "s", 0, "Test site|", True),
]


@pytest.fixture
def database(tmp_path, build):
    """A texture of 8 x 12 texels, grass on the left, nothing in one texel, with these tags."""

    def make(tags):
        values = np.full((8, 12, 3), 60, np.uint8)
        values[:, 6:] = 120
        values[0, 0] = 200
        tifffile.imwrite(tmp_path / "a.tif", values, photometric="rgb", extratags=tags)
        palette = {"colours": {"#3C3C3C": "grass_green", "#787878": "asphalt_road"}}
        return build(TextureJob.model_validate({"image": "a.tif", "palette": palette})).path

    return make


@pytest.mark.parametrize("tags", [SCALE + UTM, TURNED + UTM, DEGREES + WGS84, SCALE + LOCAL, []])
def test_the_place_is_that_of_the_image(database, tmp_path, library, tags):
    if not tags:
        (tmp_path / "a.tfw").write_text("0.5 0 0 -0.25 100.25 199.875")
    for path in export(database(tags), "geotiff", tmp_path / "out", library):
        if path.suffix == ".tif":
            wanted, found = read_georeference(tmp_path / "a.tif"), read_georeference(path)
            np.testing.assert_allclose(found.affine, wanted.affine, rtol=1e-12)
            assert found.crs == wanted.crs


@pytest.mark.parametrize(
    "tags, model, key", [(SCALE + UTM, 1, "ProjectedCSTypeGeoKey"), (DEGREES + WGS84, 2, "GeographicTypeGeoKey")]
)
def test_the_kind_of_system(database, tmp_path, library, tags, model, key):
    code = export(database(tags), "geotiff", tmp_path, library)[0]
    with tifffile.TiffFile(code) as file:
        keys = file.pages[0].geotiff_tags
    assert int(keys["GTModelTypeGeoKey"]) == model and int(keys[key]) in (32633, 4326)


def test_codes_and_confidence(database, tmp_path, library):
    path = database(SCALE + UTM)
    code, legend, confidence = export(path, "geotiff", tmp_path / "out", library)
    with open_tmm(path) as file:
        codes, sure = file.array("levels/0/code"), file.array("levels/0/confidence")
    with tifffile.TiffFile(code) as file:
        assert np.array_equal(file.asarray(), codes) and file.asarray().dtype == np.uint16
        assert file.pages[0].tags[42113].value == "0"
        assert (
            f'<Item name="{library["grass_green"].code}" sample="0">grass_green</Item>'
            in file.pages[0].tags[42112].value
        )
    read = tifffile.imread(confidence)
    assert read.dtype == np.float32 and np.isnan(read[0, 0]) and np.isnan(read).sum() == 1
    np.testing.assert_allclose(read[codes > 0], sure[codes > 0])
    assert read[codes > 0].min() > 0 and read[codes > 0].max() <= 1
    names = {entry["name"] for entry in json.loads(legend.read_text())["materials"].values()}
    assert names == {"grass_green", "asphalt_road"}
    first = [file.read_bytes() for file in (code, legend, confidence)]
    assert [file.read_bytes() for file in export(path, "geotiff", tmp_path / "out", library)] == first


def test_a_mip_level_covers_the_same_ground(database, tmp_path, library):
    path = database(SCALE + UTM)
    code, _ = export(path, "geotiff", tmp_path / "out", library, level=1)
    assert tifffile.imread(code).shape == (4, 6)
    assert read_georeference(code).affine == (1.0, 0.0, 500000.0, 0.0, -0.5, 5500000.0)


def test_no_place_on_a_map(build, two_halves, tmp_path, library):
    path = build(TextureJob.model_validate({"image": two_halves, "material": "concrete"})).path
    with pytest.raises(InputError, match="has no place on a map"):
        export(path, "geotiff", tmp_path, library)
