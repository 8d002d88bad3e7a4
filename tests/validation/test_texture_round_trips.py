"""What is exported, read by other programs: PIL, tifffile, rasterio (GDAL) and pyproj; and a folder of 50 textures."""

import json

import numpy as np
import pytest
import tifffile
from click.testing import CliRunner

from skyshine.materials.library import load_library
from skyshine.tmm import export, map_texture, open_tmm, write_texture
from skyshine.tmm.cli import main
from skyshine.tmm.exchange.cdb import read_cdb
from skyshine.tmm.exchange.cdb_places import parse_tile, place_of
from skyshine.tmm.job.model import TextureJob

pytestmark = pytest.mark.validation

PALETTE = {"#0A0A0A": "asphalt_road", "#3C3C3C": "grass_green", "#787878": "soil_sand"}
PLACES = {  # number of the system, its key in the directory, corner and texel
    "utm": (32633, 3072, (412000.0, 5499000.0), 0.5),
    "south": (32733, 3072, (412000.0, 6500000.0), 2.0),
    "etrs": (25832, 3072, (500000.0, 5600000.0), 1.0),
    "degrees": (4326, 2048, (-110.5, 44.5), 1e-5),
    "mercator": (3857, 3072, (-12300000.0, 5500000.0), 4.0),
}


@pytest.fixture(params=PLACES)
def sheet(request, tmp_path):
    """A database of 90 x 70 texels of three materials and none, on a map; its numbers and its place."""
    crs, key, corner, texel = PLACES[request.param]
    number = np.random.default_rng(1).integers(0, 4, (70, 90))
    values = np.repeat(np.array([255, 10, 60, 120], np.uint8)[number][..., np.newaxis], 3, axis=2)
    keys = (1, 1, 0, 3, 1024, 0, 1, 2 if key == 2048 else 1, 1025, 0, 1, 1, key, 0, 1, crs)
    tags = [
        (33550, "d", 3, (texel, texel, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, *corner, 0.0), True),
        (34735, "H", 16, keys, True),
    ]
    tifffile.imwrite(tmp_path / "sheet.tif", values, photometric="rgb", extratags=tags)
    job = TextureJob.model_validate({"image": "sheet.tif", "palette": {"colours": PALETTE}})
    library = load_library(None)
    write_texture(map_texture(job, tmp_path, library), tmp_path / "sheet.tmm.h5")
    codes = np.array([0, *(library[name].code for name in PALETTE.values())])
    return tmp_path, library, codes[number], crs


def test_geotiff_in_rasterio_and_tifffile(sheet):
    rasterio = pytest.importorskip("rasterio")
    folder, library, code, crs = sheet
    written = export(folder / "sheet.tmm.h5", "geotiff", folder / "out", library)
    with rasterio.open(folder / "sheet.tif") as image, rasterio.open(written[0]) as found:
        assert found.crs == image.crs and found.crs.to_epsg() == crs
        assert found.transform.almost_equals(image.transform, precision=1e-9) and found.nodata == 0
        np.testing.assert_array_equal(found.read(1), code)
        np.testing.assert_array_equal(found.read_masks(1) > 0, code > 0)
        named = found.tags(1)
    assert {named[str(library[name].code)] for name in PALETTE.values()} == set(PALETTE.values())
    np.testing.assert_array_equal(tifffile.imread(written[0]), code)
    confidence = tifffile.imread(next(path for path in written if path.name.endswith("confidence.tif")))
    np.testing.assert_array_equal(np.isnan(confidence), code == 0)


def test_indexed_png_and_masks_in_pil(sheet):
    from PIL import Image

    folder, library, code, _ = sheet
    export(folder / "sheet.tmm.h5", "png", folder / "out", library)
    with Image.open(folder / "out/sheet.png") as image:
        assert image.mode == "P"
        index = np.asarray(image)
    legend = json.loads((folder / "out/sheet.legend.json").read_text())
    code_of = np.zeros(256, int)
    for number, entry in legend["materials"].items():
        code_of[int(number)] = entry["code"]
    np.testing.assert_array_equal(code_of[index], code)
    export(folder / "sheet.tmm.h5", "masks", folder / "out", library)
    for name in PALETTE.values():
        with Image.open(folder / f"out/sheet.{name}.png") as mask:
            np.testing.assert_array_equal(np.asarray(mask) == 255, code == library[name].code)


def test_tiles_of_a_cdb_in_rasterio(sheet):
    """Tiles lie where GDAL says they do, and GDAL's own resampling of the codes agrees with those of the finest."""
    rasterio = pytest.importorskip("rasterio")
    from rasterio.warp import Resampling, reproject

    folder, library, code, _ = sheet
    written = export(folder / "sheet.tmm.h5", "cdb", folder / "cdb", library)
    code_raster = export(folder / "sheet.tmm.h5", "geotiff", folder / "out", library)[0]
    rasters = [path for path in written if "_D005_S001_T001_" in path.name]
    finest = max(parse_tile(place_of(path.name).name).lod for path in rasters)
    agreed, compared = 0, 0
    for path in rasters:
        tile = place_of(path.name)
        with rasterio.open(path) as found:
            assert found.crs.to_epsg() == 4326
            south, west, north, east = tile.bounds
            assert found.bounds == pytest.approx((west, south, east, north), abs=1e-12)
            if tile.lod != finest:
                continue
            index = found.read(1)
            warped = np.zeros(index.shape, np.uint16)
            with rasterio.open(code_raster) as source:
                reproject(
                    rasterio.band(source, 1),
                    warped,
                    dst_transform=found.transform,
                    dst_crs=found.crs,
                    dst_nodata=0,
                    resampling=Resampling.nearest,
                    tolerance=0,
                )
        own = np.zeros(index.max() + 1, int)
        for number, composite in read_cdb(path).table.items():
            if number < len(own):
                own[number] = library[composite.name].code
        either = (index > 0) | (warped > 0)
        agreed += int((own[index] == warped)[either].sum())
        compared += int(either.sum())
    print(f"\n{agreed} of {compared} texels as GDAL has them")
    assert compared > 0.5 * code.size and agreed >= 0.995 * compared


def test_a_folder_of_fifty_textures_with_one_damaged(tmp_path):
    from PIL import Image

    (tmp_path / "sheets").mkdir()
    random = np.random.default_rng(3)
    for number in range(50):
        values = np.kron(random.choice([10, 60, 120], (8, 8)), np.ones((8, 8))).astype(np.uint8)
        Image.fromarray(np.repeat(values[..., np.newaxis], 3, axis=2)).save(tmp_path / f"sheets/s{number:02d}.png")
    bad = tmp_path / "sheets/s31.png"
    whole = bad.read_bytes()
    bad.write_bytes(whole[: len(whole) // 2])
    colours = ", ".join(f'"{key}": {name}' for key, name in PALETTE.items())
    (tmp_path / "tmm.yaml").write_text(f"textures: [{{image: sheets, palette: {{colours: {{{colours}}}}}}}]\n")
    run = CliRunner()
    first = run.invoke(main, ["classify", str(tmp_path / "tmm.yaml"), "--json"])
    lines = first.stderr.strip().splitlines()
    assert first.exit_code == 2 and sum("s31" in line for line in lines) == 1 and len(lines) == 2, first.stderr
    built = sorted((tmp_path / "build").glob("*.tmm.h5"))
    assert len(built) == 49
    times = {path: path.stat().st_mtime_ns for path in built}
    bad.write_bytes(whole)
    second = run.invoke(main, ["classify", str(tmp_path / "tmm.yaml"), "--json"])
    states = [entry["state"] for entry in json.loads(second.stdout)["textures"]]
    assert second.exit_code == 0 and states.count("kept") == 49 and states.count("written") == 1
    assert all(path.stat().st_mtime_ns == time for path, time in times.items())
    with open_tmm(tmp_path / "build/s31.tmm.h5") as file:
        assert file.width == 64
