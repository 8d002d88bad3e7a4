"""Imported materials as databases: mip levels of mixtures, provenance, and what is kept of a CDB."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.tables.verify import problems
from skyshine.tmm.cli import main
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Level, pure_level
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.database.usage import read_usage
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.imported import coarser_levels, import_texture, write_imported

NAMES = {22: "asphalt_road", 68: "grass_green", 81: "water_sea"}


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.mark.parametrize("shape", [(8, 8), (7, 5), (1, 6)])
def test_levels_of_pure_texels_are_those_of_classified_ones(shape):
    from skyshine.tmm.database.levels import LevelStream

    code = np.random.default_rng(5).choice(np.array([0, 22, 68, 81], np.uint16), shape)
    stream = LevelStream(*shape, np.array([22, 68, 81], np.uint16))
    expected = {}
    for level, _, part in stream.add(code):
        expected.setdefault(level, []).append(part)
    found = coarser_levels(MaterialImage("x", NAMES, pure_level(code)))
    assert len(found) == len(expected)
    for k, level in enumerate(found, 1):
        weights = np.concatenate([part.mix_weight for part in expected[k]])
        assert np.abs(level.mix_weight.astype(int) - weights).max() <= 1
        clear = weights[..., 0] > weights[..., 1] + 2  # elsewhere two materials share the texel evenly
        assert np.array_equal(level.code[clear], np.concatenate([part.code for part in expected[k]])[clear])


def test_levels_of_mixtures_are_means():
    mix_code = np.zeros((2, 2, 3), np.uint16)
    mix_weight = np.zeros((2, 2, 3), np.uint16)
    mix_code[...], mix_weight[..., 0] = [22, 68, 0], WEIGHT_TOTAL
    mix_weight[0, 0] = [WEIGHT_TOTAL - 16384, 16384, 0]  # three quarters, one quarter; the others are pure
    top = coarser_levels(MaterialImage("x", NAMES, Level(mix_code[..., 0].copy(), mix_code, mix_weight)))[-1]
    assert top.mix_code.tolist() == [[[22, 68, 0]]]
    assert top.mix_weight[0, 0] / WEIGHT_TOTAL == pytest.approx([15 / 16, 1 / 16, 0], abs=2e-5)


def imported(folder, name, code, library):
    """A database of codes (h, w) as an import writes it."""
    from PIL import Image

    Image.fromarray(code.astype(np.uint8)).save(folder / f"{name}.png")
    used = {key: NAMES[key] for key in NAMES if (code == key).any()}
    palette = {str(key): value for key, value in used.items()}
    path = folder / f"{name}.tmm.h5"
    write_imported(MaterialImage(name, used, pure_level(code)), folder / f"{name}.png", palette, path, library.version)
    return path


def test_an_imported_database_is_like_any_other(library, tmp_path):
    code = np.random.default_rng(2).choice(np.array([0, 22, 68], np.uint16), (20, 30))
    path = imported(tmp_path, "patch", code, library)
    assert not problems(path)
    with open_tmm(path) as file:
        assert np.array_equal(file.array("levels/0/code"), code)
        assert np.array_equal(file.array("levels/0/confidence"), code > 0)
    assert read_usage(path)["grass_green"] == pytest.approx((code == 68).sum() / (code > 0).sum())
    first = path.read_bytes()
    assert imported(tmp_path, "patch", code, library).read_bytes() == first
    preview = run("preview", path, "--out", tmp_path / "p.png", "--image", tmp_path / "patch.png")
    assert preview.exit_code == 0, preview.output


def test_all_levels_of_a_model_texture_share_one_table(library, tmp_path):
    from skyshine.tmm.exchange.cdb import read_cdb, to_image
    from skyshine.tmm.exchange.cdb_materials import load_map

    code = np.random.default_rng(7).choice(np.array([22, 68, 81], np.uint16), (16, 8))
    imported(tmp_path, "wall", code, library)
    result = run(
        "export",
        tmp_path / "wall.tmm.h5",
        "--to",
        "cdb",
        "--out",
        tmp_path / "cdb",
        "--model",
        "Wall",
        "--lod",
        2,
        "--json",
    )
    assert result.exit_code == 0, result.output
    written = json.loads(result.output)["written"]
    assert len([name for name in written if name.endswith("Wall.xml")]) == 1
    folder = tmp_path / "cdb" / "GTModel" / "504_GTModelMaterial" / "W" / "A" / "Wall"
    with open_tmm(tmp_path / "wall.tmm.h5") as file:
        for k, lod in enumerate(("L02", "L01", "L00", "LC01", "LC02")):
            level = to_image(read_cdb(folder / f"D504_S001_T001_{lod}_Wall.tif"), load_map(library)).level
            assert np.array_equal(level.mix_code, file.array(f"levels/{k}/mix_code"))
            assert np.abs(level.mix_weight.astype(int) - file.array(f"levels/{k}/mix_weight")).max() <= 1


def test_usage_counts_materials_that_are_never_first(library, tmp_path, write_image):
    mix_code = np.tile(np.array([22, 68, 0], np.uint16), (4, 4, 1))
    mix_weight = np.tile(np.array([WEIGHT_TOTAL - 13107, 13107, 0], np.uint16), (4, 4, 1))
    image = MaterialImage("mixed", {22: NAMES[22], 68: NAMES[68]}, Level(mix_code[..., 0].copy(), mix_code, mix_weight))
    source = tmp_path / write_image("s.png", np.zeros((4, 4, 3), np.uint8))
    write_imported(image, source, {"0": "asphalt_road"}, tmp_path / "m.tmm.h5", library.version)
    assert read_usage(tmp_path / "m.tmm.h5") == pytest.approx({"asphalt_road": 0.8, "grass_green": 0.2})


@pytest.mark.shared_data
@pytest.mark.parametrize("tile", ["L00", "LC02"])
def test_a_real_cdb_comes_back_with_its_names_and_codes(tile, shared_data, tmp_path):
    from skyshine.tmm.exchange.cdb import read_cdb

    place = f"Tiles/N12/E044/005_RMTexture/{'LC' if tile.startswith('LC') else tile}/U0/N12E044_D005_S001_T001_{tile}_U0_R0.tif"  # noqa: E501
    source = shared_data / "cdb" / "yemen" / place
    assert run("export", "--to", "tmm", source, "--out", tmp_path).exit_code == 0
    path = tmp_path / f"N12E044_{tile}_U0_R0.tmm.h5"
    assert not problems(path)
    assert run("export", path, "--to", "cdb", "--out", tmp_path / "cdb").exit_code == 0
    original, again = read_cdb(source), read_cdb(tmp_path / "cdb" / place)
    assert np.array_equal(again.index, original.index)
    assert again.table == original.table  # indices, names, base materials and weights
    other = run("export", path, "--to", "cdb", "--out", tmp_path / "other", "--tile", f"N13E044_{tile}_U0_R0")
    assert other.exit_code == 0 and "Tiles/N13/E044" in other.output


@pytest.mark.parametrize(
    "name, message",
    [
        ("a.jpg", "is not named as a CDB raster"),
        ("a.tif", "is not named as a CDB raster"),
        ("N12E044_D005_S001_T001_L00_U0_R0.tif", "is not in its place in a CDB"),
        ("Tiles/N12/E044/005_RMTexture/L00/U0/N12E044_D005_S001_T001_L00_U0_R0.tif", "does not exist"),
    ],
)
def test_wrong_files(name, message, tmp_path):
    result = run("export", "--to", "tmm", tmp_path / name, "--out", tmp_path / "out")
    assert result.exit_code == 2 and message in result.output and result.output.count("\n") == 1, result.output
    assert not (tmp_path / "out").exists()


def test_too_large_for_an_exchange(library, tmp_path, monkeypatch):
    code = np.full((20, 30), 22, np.uint16)
    arguments = ("export", imported(tmp_path, "patch", code, library), "--to", "png", "--out", tmp_path)
    monkeypatch.setattr("skyshine.tmm.exchange.image.MAX_TEXELS", 599)
    result = run(*arguments)
    assert result.exit_code == 2 and "has 30 x 20 texels; allowed in an exchange: 599" in result.output, result.output
    assert result.output.count("\n") == 1
    assert run(*arguments, "--level", 1).exit_code == 0


TABLE = """<Composite_Material_Table>
 <Composite_Material index="4"><Name>Verge</Name><Primary_Substrate>
  <Material><Name>BM_ASPHALT</Name><Weight>60</Weight></Material>
  <Material><Name>BM_SAND</Name><Weight>40</Weight></Material></Primary_Substrate></Composite_Material>
 <Composite_Material index="9"><Name>Sand</Name><Primary_Substrate>
  <Material><Name>BM_SAND</Name><Weight>100</Weight></Material></Primary_Substrate></Composite_Material>
</Composite_Material_Table>
"""


@pytest.fixture
def indexed(tmp_path):
    """An image of the indices 4, 9 and 0, and its table, in no CDB."""
    from PIL import Image

    (tmp_path / "verge.xml").write_text(TABLE)
    Image.fromarray(np.repeat(np.uint8([[4, 9, 0, 4]]), 4, axis=0)).save(tmp_path / "index.png")
    return tmp_path


def test_composites_of_a_table_outside_a_cdb(indexed, library):
    from skyshine.tmm.exchange.cdb_materials import load_map

    bases = load_map(library).recipes.bases
    path = import_texture(indexed / "index.png", indexed, library, table=indexed / "verge.xml")
    with open_tmm(path) as file:
        codes, shares = file.mixture(0.5, 0.5)
        assert [file.materials[int(code)] for code in codes[:2]] == [bases["BM_ASPHALT"], bases["BM_SAND"]]
        assert shares == pytest.approx([0.6, 0.4, 0], abs=1e-5)
        assert file.code(2.5, 0.5) == 0
        # Over the columns 4, 9, 0, 4: asphalt 0.6 + 0.6 of 3 texels with a material.
        codes, shares = file.mixture(0.5, 0.5, level=2)
        assert shares == pytest.approx([1.8 / 3, 1.2 / 3, 0] if bases["BM_ASPHALT"] else [], abs=2e-5)


def test_wrong_images_and_tables(indexed, library):
    from click.testing import CliRunner
    from PIL import Image

    from skyshine.tmm.cli import main

    def fails(image, table, message):
        arguments = [
            "export",
            "--to",
            "tmm",
            str(indexed / image),
            "--table",
            str(indexed / table),
            "--out",
            str(indexed / "out"),
        ]
        result = CliRunner().invoke(main, arguments)
        (line,) = result.stderr.strip().splitlines()
        assert result.exit_code == 2 and message in line, line

    fails("index.png", "absent.xml", "cannot be read")
    Image.fromarray(np.full((2, 2), 5, np.uint8)).save(indexed / "five.png")
    fails("five.png", "verge.xml", "has the index 5, which verge.xml has not; allowed: 4, 9")
    Image.fromarray(np.full((2, 2), np.nan, np.float32)).save(indexed / "floats.tif")
    fails("floats.tif", "verge.xml", "contains floats; allowed: unsigned integers")
    (indexed / "unknown.xml").write_text(TABLE.replace("BM_ASPHALT", "BM_ASPHALD"))
    fails("index.png", "unknown.xml", "has no material for the base material 'BM_ASPHALD' of the composite 'Verge'")
