"""Tiles of a CDB cut by a texture's place on the ground: names, levels of detail, shares, mosaics, what is refused."""

import json
import re

import numpy as np
import pytest
import tifffile
from click.testing import CliRunner

from skyshine.schemas.errors import InputError
from skyshine.tmm import export, open_tmm
from skyshine.tmm.cli import main
from skyshine.tmm.database.levels import WEIGHT_TOTAL
from skyshine.tmm.exchange.cdb import read_cdb, to_image
from skyshine.tmm.exchange.cdb_materials import load_map
from skyshine.tmm.exchange.cdb_places import parse_tile, place_of
from skyshine.tmm.exchange.cdb_table import Composite, Substrate, write_table
from skyshine.tmm.exchange.export import CdbTarget
from skyshine.tmm.images.gdal import transformed
from skyshine.tmm.images.georeference import read_georeference
from skyshine.tmm.job.model import TextureJob

PALETTE = {"#0A0A0A": "asphalt_road", "#3C3C3C": "grass_green", "#787878": "soil_sand", "#B4B4B4": "water_fresh"}
GREY = np.array([255, 10, 60, 120, 180], np.uint8)  # of no material, and of each of these


@pytest.fixture
def sheet(tmp_path, build):
    """A database of a texture of materials by number (0 for none) that lies on a map."""

    def make(number, west, north, texel, crs=4326, name="sheet", turn=0.0):
        values = np.repeat(GREY[number][..., np.newaxis], 3, axis=2)
        key, model = (2048, 2) if crs in (4326, 4258, 4269, 4277) else (3072, 1)
        keys = (1, 1, 0, 3, 1024, 0, 1, model, 1025, 0, 1, 1, key, 0, 1, crs)
        across, down = texel * np.cos(turn), texel * np.sin(turn)
        matrix = (across, down, 0, west, down, -across, 0, north, *[0.0] * 7, 1.0)
        tags = [(34264, "d", 16, matrix, True), (34735, "H", 16, keys, True)]
        tifffile.imwrite(tmp_path / f"{name}.tif", values, photometric="rgb", extratags=tags)
        job = TextureJob.model_validate({"image": f"{name}.tif", "palette": {"colours": PALETTE}})
        return build(job, f"{name}.tmm.h5").path

    return make


def cut(path, folder, library, lod=None):
    """Rasters of indices of a CDB by the name of their tile, and all that was written."""
    written = export(path, "cdb", folder, library, target=CdbTarget(lod=lod))
    return {place_of(file.name).name: file for file in written if "_D005_S001_T001_" in file.name}, written


def shares(file, library):
    """Share of each of the four materials, (4, side, side), in a tile."""
    level = to_image(read_cdb(file), load_map(library)).level
    codes = [library[name].code for name in PALETTE.values()]
    return np.stack([np.where(level.mix_code == c, level.mix_weight, 0).sum(axis=-1) / WEIGHT_TOTAL for c in codes])


def one_hot(number):
    return (np.arange(1, 5)[:, np.newaxis, np.newaxis] == number).astype(float)


def blocks(plane, side):
    return plane.reshape(len(plane), plane.shape[1] // side, side, plane.shape[2] // side, side).mean(axis=(2, 4))


def test_a_geocell_that_the_texture_fills(sheet, library, tmp_path):
    """32 texels a degree are those of level -5: codes stay as they are and coarser levels are means of blocks."""
    number = np.random.default_rng(2).choice([1, 2, 3], (32, 32))
    tiles, written = cut(sheet(number, 44.0, 13.0, 1 / 32), tmp_path / "cdb", library)
    assert list(tiles) == [f"N12E044_LC{lod:02d}_U0_R0" for lod in (5, 6, 7, 8, 9, 10)]
    first = tmp_path / "cdb/Tiles/N12/E044/005_RMTexture/LC/U0/N12E044_D005_S001_T001_LC05_U0_R0.tif"
    table = tmp_path / "cdb/Tiles/N12/E044/006_RMDescriptor/LC/U0/N12E044_D006_S001_T001_LC05_U0_R0.xml"
    assert tiles["N12E044_LC05_U0_R0"] == first and table in written
    for lod in range(5, 11):
        found = shares(tiles[f"N12E044_LC{lod:02d}_U0_R0"], library)
        np.testing.assert_allclose(found, blocks(one_hot(number), 1 << (lod - 5)), atol=2e-5)
    place = read_georeference(first)
    assert place.crs == "EPSG:4326" and place.affine == (1 / 32, 0, 44, 0, -1 / 32, 13)


@pytest.mark.parametrize("west, north, finer", [(44.0, 13.0, "U1_R0"), (44.5, 12.5, "U0_R1"), (44.75, 12.75, "U1_R1")])
def test_a_coarser_tile_has_its_finer_ones_where_they_lie(sheet, library, tmp_path, west, north, finer):
    number = np.random.default_rng(7).choice([1, 2], (64, 64))
    tiles, _ = cut(sheet(number, west, north, 1 / 2048), tmp_path / "cdb", library)
    assert f"N12E044_L01_{finer}" in tiles
    row, column = round((13 - north) * 1024), round((west - 44) * 1024)
    found = shares(tiles["N12E044_L00_U0_R0"], library)
    np.testing.assert_allclose(found[:, row : row + 32, column : column + 32], blocks(one_hot(number), 2), atol=2e-5)
    assert found.sum() == pytest.approx(32 * 32)


def test_four_geocells_about_the_origin(sheet, library, tmp_path):
    number = np.random.default_rng(3).integers(1, 5, (16, 16))
    tiles, _ = cut(sheet(number, -1.0, 1.0, 1 / 8), tmp_path / "cdb", library)
    quarters = {"N00W001": np.s_[:8, :8], "N00E000": np.s_[:8, 8:], "S01W001": np.s_[8:, :8], "S01E000": np.s_[8:, 8:]}
    assert {name[:7] for name in tiles} == set(quarters)
    for cell, part in quarters.items():
        found = shares(tiles[f"{cell}_LC07_U0_R0"], library)
        np.testing.assert_allclose(found, one_hot(number)[(slice(None), *part)], atol=2e-5)
        south, west = (1 if s in "NE" else -1 for s in (cell[0], cell[3]))
        affine = read_georeference(tiles[f"{cell}_LC07_U0_R0"]).affine
        assert (affine[2], affine[5]) == ((0 if west > 0 else -1), (1 if south > 0 else 0))


def test_the_map_goes_on_at_180_degrees(sheet, library, tmp_path):
    number = np.array([[1, 1, 2, 2]] * 4)
    tiles, _ = cut(sheet(number, 179.75, 0.5, 1 / 8), tmp_path / "cdb", library)
    assert {name[:7] for name in tiles} == {"N00E179", "N00W180"}
    assert shares(tiles["N00E179_LC07_U0_R0"], library)[0, 4:, 6:].all()
    assert shares(tiles["N00W180_LC07_U0_R0"], library)[1, 4:, :2].all()


@pytest.mark.parametrize(
    "south, west, cell, width",
    [(49, 7.25, "N49E007", 1), (50, 7.25, "N50E006", 2), (-51, -7.75, "S51W008", 2), (70, 7.25, "N70E006", 3)],
)
def test_geocells_are_wider_to_the_poles(sheet, library, tmp_path, south, west, cell, width):
    tiles, _ = cut(sheet(np.full((4, 4), 2), west, south + 0.75, 1 / 16), tmp_path / "cdb", library)
    assert {name[:7] for name in tiles} == {cell}
    file = tiles[f"{cell}_LC06_U0_R0"]
    place = read_georeference(file).affine
    assert place[0] == width / 16 and place[4] == -1 / 16
    found = shares(file, library)[1]
    y, x = (at.mean() + 0.5 for at in np.nonzero(found))
    assert (found > 0).sum() >= 4 * 4 / width
    # Of what is found the middle is that of the texture, which is a quarter of a degree high and wide.
    assert place[2] + place[0] * x == pytest.approx(west + 0.125, abs=width / 32)
    assert place[5] + place[4] * y == pytest.approx(south + 0.625, abs=1e-9)


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_utm_sheets_lie_where_they_are(sheet, library, tmp_path, turn):
    """Texels of 4 m in zone 33, to the north or turned: each texel of a tile has the material at its own place."""
    number = np.add.outer(np.arange(96) // 12, np.arange(96) // 16) % 4 + 1
    path = sheet(number, 412000.0, 5499000.0, 4.0, 32633, turn=turn)
    tiles, _ = cut(path, tmp_path / "cdb", library)
    finest = [name for name in tiles if "_L05_" in name]
    assert finest and not any("_L06_" in name for name in tiles)  # 1 degree / 1024 / 2^5 is 3.4 m
    tried = 0
    for name in finest:
        a, _, c, _, e, f = read_georeference(tiles[name]).affine
        found = shares(tiles[name], library)
        rows, columns = np.nonzero(found.max(axis=0) > 0.99)
        x, y = transformed("EPSG:4326", "EPSG:32633", c + a * (columns + 0.5), f + e * (rows + 0.5))
        east, north, cos, sin = (x - 412000) / 4, (y - 5499000) / 4, np.cos(turn), np.sin(turn)
        column, row = (np.floor(at).astype(int) for at in (east * cos + north * sin, east * sin - north * cos))
        inside = (row >= 0) & (row < 96) & (column >= 0) & (column < 96)
        tried += inside.sum()
        np.testing.assert_array_equal(
            found[:, rows, columns].argmax(axis=0)[inside] + 1, number[row[inside], column[inside]]
        )
    assert tried > 0.7 * 96 * 96 * 16 / (3.4 * 2.2)


@pytest.mark.parametrize("lod", [None, 9, 3, 0, -4])
def test_every_tile_has_all_that_are_coarser(sheet, library, tmp_path, lod):
    """20 texels of 1 m: at level -10 they are 4e-8 of their texel, and all that it knows of."""
    number = np.random.default_rng(5).choice([0, 2, 3], (20, 20), p=[0.2, 0.5, 0.3])
    path = sheet(number, 412345.0, 5499000.0, 1.0, 32633)
    tiles, _ = cut(path, tmp_path / "cdb", library, lod)
    places = [parse_tile(name) for name in tiles]
    assert max(place.lod for place in places) == (7 if lod is None else lod)
    names = set(tiles)
    for place in places:
        if place.lod > -10:
            half = 2 if place.lod > 0 else 1
            coarser = f"{place.cell}_{'LC' if place.lod < 1 else 'L'}{abs(place.lod - 1):02d}"
            assert f"{coarser}_U{place.up // half}_R{place.right // half}" in names
    (top,) = [file for name, file in tiles.items() if "_LC10_" in name]
    expected = [(number == k).sum() / (number > 0).sum() for k in (2, 3)]
    np.testing.assert_allclose(shares(top, library)[1:3, 0, 0], expected, atol=0.02)  # sixteen points a texel


def test_a_finest_level_far_coarser_than_the_texture(sheet, library, tmp_path):
    """Shares of tile texels are those of the area they cover."""
    number = np.random.default_rng(6).integers(1, 5, (256, 256))
    tiles, _ = cut(sheet(number, 10.0, 5.0, 1 / 256), tmp_path / "cdb", library, -5)
    found = shares(tiles["N04E010_LC05_U0_R0"], library)
    exact = blocks(one_hot(number), 8)
    rank = np.sort(exact, axis=0)
    three = np.where(exact >= rank[1], exact, 0)
    one_left_out = np.isclose(rank[1], rank[0]).sum(axis=0) == 0  # of equals the lower code stays
    np.testing.assert_allclose(found[:, one_left_out], (three / three.sum(axis=0))[:, one_left_out], atol=2e-5)


def test_sheets_of_a_mosaic_share_their_tiles(sheet, library, tmp_path):
    left, right = np.full((32, 16), 1), np.full((32, 16), 2)
    left[:, :2] = 0
    one = sheet(left, 44.0, 13.0, 1 / 32, name="left")
    two = sheet(right, 44.5, 13.0, 1 / 32, name="right")
    cut(one, tmp_path / "cdb", library)
    tiles, _ = cut(two, tmp_path / "cdb", library)
    found = shares(tiles["N12E044_LC05_U0_R0"], library)
    assert found[0, :, 2:16].all() and found[1, :, 16:].all() and not found[:, :, :2].any()
    before = {file: file.read_bytes() for file in (tmp_path / "cdb").rglob("*.*") if file.is_file()}
    cut(one, tmp_path / "cdb", library)
    cut(two, tmp_path / "cdb", library)
    assert all(file.read_bytes() == content for file, content in before.items())


def test_a_tile_of_others_is_not_overwritten(sheet, library, tmp_path):
    path = sheet(np.full((4, 4), 1), 44.0, 13.0, 1 / 32)
    tiles, _ = cut(path, tmp_path / "cdb", library)
    place = parse_tile("N12E044_LC05_U0_R0")
    write_table(place.table(tmp_path / "cdb"), [Composite(1, "Old wall", Substrate((("BM_ASPHALT", 100),)))])
    before = tiles[place.name].read_bytes()
    with pytest.raises(InputError, match="contains 'Old wall', which is no material of the library, and would be lost"):
        cut(path, tmp_path / "cdb", library)
    assert tiles[place.name].read_bytes() == before


def test_import_and_named_tile_agree_with_what_was_cut(sheet, library, tmp_path):
    number = np.random.default_rng(2).choice([0, 1, 2, 3], (32, 32))
    path = sheet(number, 44.0, 13.0, 1 / 32)
    tiles, _ = cut(path, tmp_path / "cut", library)
    named = export(path, "cdb", tmp_path / "named", library, target=CdbTarget(tile="N12E044_LC05_U0_R0"))
    for file in named:
        assert (tmp_path / "cut" / file.relative_to(tmp_path / "named")).read_bytes() == file.read_bytes()
    result = CliRunner().invoke(
        main, ["export", "--to", "tmm", str(tiles["N12E044_LC05_U0_R0"]), "--out", str(tmp_path / "again")]
    )
    assert result.exit_code == 0, result.output
    with open_tmm(tmp_path / "again/N12E044_LC05_U0_R0.tmm.h5") as again, open_tmm(path) as first:
        np.testing.assert_array_equal(again.array("levels/0/code"), first.array("levels/0/code"))


@pytest.mark.shared_data
def test_tables_are_valid(sheet, library, tmp_path, shared_data):
    from lxml import etree

    schema = etree.XMLSchema(etree.parse(shared_data / "cdb" / "Composite_Material_Table.xsd"))
    number = np.random.default_rng(5).integers(0, 5, (40, 40))
    _, written = cut(sheet(number, 412345.0, 5499000.0, 2.0, 32633), tmp_path / "cdb", library)
    tables = [file for file in written if file.suffix == ".xml" and file.parent.name != "Metadata"]
    assert len(tables) > 15
    for table in tables:
        schema.assertValid(etree.parse(table))


@pytest.mark.shared_data
def test_names_and_tags_are_those_of_a_real_cdb(sheet, library, tmp_path, shared_data):
    """The tile of level 0 of a geocell in Yemen: the same path, size, type, compression and place."""
    number = np.full((64, 64), 1)
    tiles, _ = cut(sheet(number, 44.0, 13.0, 1 / 64), tmp_path, library, 0)
    for name, file in (("N12E044_L00_U0_R0", None), ("N12E044_LC01_U0_R0", None), ("N12E044_LC02_U0_R0", None)):
        file = tiles[name]
        real = shared_data / "cdb/yemen" / file.relative_to(tmp_path)
        assert real.is_file() and read_georeference(file) == read_georeference(real)
        with tifffile.TiffFile(file) as own, tifffile.TiffFile(real) as other:
            assert own.pages[0].shape == other.pages[0].shape and own.pages[0].dtype == other.pages[0].dtype
            assert own.pages[0].compression == other.pages[0].compression
        table = parse_tile(name).table(tmp_path)
        assert table.is_file() and (shared_data / "cdb/yemen" / table.relative_to(tmp_path)).is_file()


@pytest.mark.parametrize(
    "west, north, texel, crs, options, message",
    [
        (44.0, 91.0, 0.1, 4326, [], "lies beyond latitudes of -90 to 90 degrees"),
        (44.0, np.inf, 0.1, 4326, [], "GeoTIFF tags that cannot be read|place"),
        (-170.0, 20.0, 50.0, 4326, [], "lies beyond latitudes|more than 180 degrees wide"),
        (44.0, 13.0, 0.1, 4326, ["--lod", "24"], "found the level of detail 24; allowed: -10 to 23"),
        (44.0, 13.0, 0.1, 4326, ["--lod", "12"], r"would make \d+ tiles of level 12; allowed: 16384"),
        (44.0, 13.0, 0.1, 4326, ["--level", "1"], "--level goes with --tile"),
    ],
)
def test_what_cannot_be_cut_is_one_line(sheet, tmp_path, west, north, texel, crs, options, message):
    try:
        path = sheet(np.full((4, 4), 1), west, north, texel, crs)
    except InputError as error:  # the place is refused before a database is written
        assert re.search(message, str(error))
        return
    result = CliRunner().invoke(main, ["export", str(path), "--to", "cdb", "--out", str(tmp_path / "cdb"), *options])
    (line,) = result.stderr.strip().splitlines()
    assert result.exit_code == 2 and re.search(message, line), line
    assert not (tmp_path / "cdb").exists()


def test_nothing_known_and_one_texel(sheet, library, tmp_path):
    with pytest.raises(InputError, match="has no texel with a material|has no colour of the palette"):
        cut(sheet(np.zeros((4, 4), int), 44.0, 13.0, 0.1), tmp_path / "none", library)
    tiles, _ = cut(sheet(np.full((1, 1), 3), 44.0, 13.0, 1e-6, name="one"), tmp_path / "one", library)
    assert len(tiles) == 10 + 11  # level 10 and all that are coarser
    assert shares(tiles["N12E044_LC10_U0_R0"], library)[2, 0, 0] == 1
    result = CliRunner().invoke(
        main,
        ["export", str(tmp_path / "one.tmm.h5"), "--to", "cdb", "--out", str(tmp_path / "c"), "--json", "--lod=-9"],
    )
    assert len(json.loads(result.stdout)["written"]) == 5  # two tiles of two files, and the base materials


def test_a_projection_by_somebody_elses_number():
    """The worked example of transverse Mercator in IOGP's guidance note 7-2: the British grid, from its own degrees."""
    east, north = transformed("EPSG:4277", "EPSG:27700", np.array([0.5]), np.array([50.5]))
    assert east[0] == pytest.approx(577274.99, abs=0.01) and north[0] == pytest.approx(69740.50, abs=0.01)


def test_tags_of_all_tiles_are_their_place(library, tmp_path):
    """The edges of a tile by its name, at levels below and above 0 and in all quarters of the globe."""
    for name, bounds in {
        "N12E044_L02_U1_R3": (12.25, 44.75, 12.5, 45.0),
        "S33W151_L01_U0_R1": (-33.0, -150.5, -32.5, -150.0),
        "N50E006_L01_U1_R1": (50.5, 7.0, 51.0, 8.0),
        "S90W012_LC10_U0_R0": (-90.0, -12.0, -89.0, 0.0),
    }.items():
        assert parse_tile(name).bounds == bounds
