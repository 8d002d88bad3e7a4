"""OGC CDB: tables and rasters both ways, the real ones of the reference data, and broken ones."""

import datetime
import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.schemas.errors import InputError
from skyshine.tmm.cli import main
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Level
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.exchange.cdb import from_image, read_cdb, to_image, write_cdb
from skyshine.tmm.exchange.cdb_bases import bases_of, read_bases, write_bases
from skyshine.tmm.exchange.cdb_materials import load_map
from skyshine.tmm.exchange.cdb_places import model_texture, parse_tile
from skyshine.tmm.exchange.cdb_table import Composite, Substrate, largest_remainders, read_table, write_table
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.rasters import read_plane, write_tiff

YEMEN = "cdb/yemen/Tiles/N12/E044"
TILE = parse_tile("N12E044_LC05_U0_R0")  # 32 x 32


@pytest.fixture(scope="module")
def materials(request):
    return load_map(request.getfixturevalue("library"))


@pytest.fixture
def image(library):
    """32 x 32: a third material in a few texels, some without any."""
    random = np.random.default_rng(3)
    codes = np.array([22, 68, 81], np.uint16)
    mix_code = np.zeros((32, 32, 3), np.uint16)
    mix_weight = np.zeros((32, 32, 3), np.uint16)
    mix_code[...] = random.permuted(np.broadcast_to(codes, (32, 32, 3)), axis=-1)
    parts = np.sort(random.integers(1, 20_000, (32, 32, 2)), axis=-1)[..., ::-1]
    mix_weight[..., 1:], mix_weight[..., 0] = parts, WEIGHT_TOTAL - parts.sum(axis=-1)
    mix_code[:4], mix_weight[:4] = [0, 0, 0], [WEIGHT_TOTAL, 0, 0]
    names = {int(code): library.by_code(int(code)).name for code in codes}
    return MaterialImage("field", names, Level(mix_code[..., 0].copy(), mix_code, mix_weight))


def test_image_survives_writing_and_reading(image, materials, tmp_path):
    written = write_cdb(tmp_path, from_image(image, TILE, materials))
    assert [path.name for path in written] == [
        f"N12E044_D005_S{component:03d}_T{layer:03d}_LC05_U0_R0.tif" for layer in (1, 2, 3) for component in (1, 2)
    ] + ["N12E044_D006_S001_T001_LC05_U0_R0.xml"]
    assert written[0].parent == tmp_path / "Tiles/N12/E044/005_RMTexture/LC/U0"
    again = to_image(read_cdb(written[0]), materials)
    assert again.materials == image.materials
    for name in ("code", "mix_code", "mix_weight"):
        assert np.array_equal(getattr(again.level, name), getattr(image.level, name)), name


def test_same_bytes_and_no_layer_left_behind(image, materials, tmp_path):
    write_cdb(tmp_path, from_image(image, TILE, materials))
    first = {path: path.read_bytes() for path in write_cdb(tmp_path, from_image(image, TILE, materials))}
    assert len(first) == 7 and all(path.read_bytes() == content for path, content in first.items())
    this_year = str(datetime.date.today().year).encode()
    assert not any(this_year in content for content in first.values())  # no clock in any of them
    pure = replace(
        image,
        level=Level(
            image.level.code, image.level.mix_code * [1, 0, 0], (image.level.mix_weight > 0) * [WEIGHT_TOTAL, 0, 0]
        ),
    )
    written = write_cdb(tmp_path, from_image(pure, TILE, materials))
    assert len(written) == 2 and read_cdb(written[0]).index.shape == (1, 32, 32)


@pytest.mark.parametrize("kind, tags", [(np.uint8, (5, 8)), (np.uint16, (5, 16)), (np.float32, (1, 32))])
def test_tiff_is_compressed_where_it_holds_integers(kind, tags, tmp_path):
    from PIL import Image

    values = (np.arange(48).reshape(6, 8) / 48 * (1 if kind is np.float32 else 200)).astype(kind)
    write_tiff(tmp_path / "a.tif", values, **({} if kind is np.float32 else {"compress": "lzw"}))
    assert np.array_equal(read_plane(tmp_path / "a.tif"), values)
    with Image.open(tmp_path / "a.tif") as picture:
        assert (picture.tag_v2[259], *picture.tag_v2[258]) == tags  # TIFF 6.0: Compression (5 is LZW), BitsPerSample


def test_model_textures(image, materials, tmp_path):
    place = model_texture("Wall_7", 4)
    written = write_cdb(tmp_path, from_image(image, place, materials))
    assert written[0] == tmp_path / "GTModel/504_GTModelMaterial/W/A/Wall_7/D504_S001_T001_L04_Wall_7.tif"
    assert written[-1] == tmp_path / "GTModel/505_GTModelCMT/W/A/Wall_7/D505_S001_T001_Wall_7.xml"
    assert np.array_equal(to_image(read_cdb(written[0]), materials).level.code, image.level.code)


def test_tile_sizes_by_level_of_detail():
    # OGC 15-113, clause 2.1.2: 1024 x 1024 from level 0, halved with each negative level, one texel at -10.
    sides = [parse_tile(f"N12E044_{lod}_U0_R0").side for lod in ("L23", "L00", "LC01", "LC02", "LC10")]
    assert sides == [1024, 1024, 512, 256, 1]


def test_weights_of_a_table_are_whole_percents_in_descending_order(tmp_path):
    assert largest_remainders([1, 1, 1]) == [34, 33, 33] and largest_remainders([95, 5]) == [95, 5]
    path = tmp_path / "t.xml"
    path.write_text(
        "<T><Composite_Material index='7'><Primary_Substrate><Material><Name> BM_SAND"
        " </Name><Weight>1</Weight></Material>"
        "<Material><Name>BM_SOIL</Name><Weight>2</Weight></Material></Primary_Substrate></Composite_Material></T>"
    )
    assert read_table(path) == {7: Composite(7, "CM_7", Substrate((("BM_SOIL", 67), ("BM_SAND", 33))))}


def test_every_material_is_written_and_comes_back(library, materials):
    for material in library:
        composite = materials.composite(material.name, 1)
        assert materials.mixture(composite) == {material.code: 1.0}
        stranger = replace(composite, name="of another tool")
        assert sum(materials.mixture(stranger).values()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "composite, expected",
    [
        (
            Composite(
                1,
                "CITY",
                Substrate((("BM_CONCRETE", 40), ("BM_FOLIAGE-DECIDUOUS", 20), ("BM_ASPHALT", 20), ("BM_SHINGLE", 20))),
            ),
            {"concrete": 0.5, "asphalt_road": 0.25, "roof_shingle_asphalt_grey": 0.25},
        ),
        (Composite(1, "x", Substrate((("BM_SOIL", 95), ("BM_MOISTURE", 5)))), {"soil_loam_brown": 1.0}),
        (Composite(1, "x", Substrate((("BM_SAND", 80), ("BM_MOISTURE", 20)))), {"sand_wet": 1.0}),
        (
            Composite(1, "x", Substrate((("BM_METAL-ALUMINIUM", 100),)), Substrate((("BM_PAINT", 100),))),
            {"paint_grey_on_metal": 1.0},
        ),
    ],
)
def test_composites_of_other_names(composite, expected, materials, library):
    found = {library.by_code(code).name: share for code, share in materials.mixture(composite).items()}
    assert found == pytest.approx(expected)


@pytest.mark.shared_data
@pytest.mark.parametrize("tile", ["L00", "LC01", "LC02"])
def test_real_tiles_keep_names_and_codes(tile, shared_data, materials, tmp_path):
    folder = "LC" if tile.startswith("LC") else tile
    source = shared_data / YEMEN / "005_RMTexture" / folder / "U0" / f"N12E044_D005_S001_T001_{tile}_U0_R0.tif"
    raster = read_cdb(source)
    written = write_cdb(tmp_path, raster)
    again = read_cdb(written[0])
    assert np.array_equal(again.index, raster.index) and again.table == raster.table
    _validate(written[-1], shared_data)
    names = [composite.name for composite in raster.table.values()]
    assert names[:3] == ["OCEAN", "DRYGROUND", "CALCAREOUS"] and len(names) == len(raster.table)
    _validate(
        write_cdb(tmp_path / "ours", from_image(to_image(raster, materials), raster.location, materials))[-1],
        shared_data,
    )


@pytest.mark.shared_data
def test_indices_are_resolved_in_their_own_table(shared_data, materials):
    paths = [
        f"{folder}/U0/N12E044_D005_S001_T001_{tile}_U0_R0.tif" for folder, tile in (("L00", "L00"), ("LC", "LC01"))
    ]
    fine, coarse = (read_cdb(shared_data / YEMEN / "005_RMTexture" / path) for path in paths)
    assert fine.table[4].name == "SAND" and coarse.table[4].name == "CITY"
    texel = tuple(np.argwhere(coarse.index[0] == 4)[0])
    assert to_image(coarse, materials).level.code[texel] == materials.library["concrete"].code


@pytest.mark.shared_data
def test_example_of_the_standard_keeps_its_substrates(shared_data, tmp_path):
    table = read_table(shared_data / "cdb" / "CMT_Example.xml")
    assert list(table) == [3, 19, 174, 395, 412, 999999] and len(table[3].secondary) == 2
    table.pop(999999)  # its base material "BM_ xyz" is no name that the schema of base materials allows
    write_table(tmp_path / "t.xml", list(table.values()))
    assert read_table(tmp_path / "t.xml") == table
    _validate(tmp_path / "t.xml", shared_data)


@pytest.mark.shared_data
def test_map_names_base_materials_of_the_standard(shared_data, materials):
    known = (shared_data / "cdb" / "Materials.xml").read_text()
    named = {*materials.recipes.bases}
    for name in materials.library.names:
        composite = materials.composite(name, 1)
        named |= {base for part in (composite.surface, composite.primary) if part for base, _ in part.materials}
    assert all(f"<Name>{name}</Name>" in known for name in named)


def _validate(path, shared_data) -> None:
    from lxml import etree

    etree.XMLSchema(etree.parse(shared_data / "cdb" / "Composite_Material_Table.xsd")).assertValid(etree.parse(path))


ROW = (
    "<Composite_Material"
    " index='1'><Primary_Substrate><Material><Name>BM_SAND</Name></Material></Primary_Substrate></Composite_Material>"
)


@pytest.mark.parametrize(
    "text, message",
    [
        ("<T>", r"t.xml:1:4: is not XML"),
        ("", "is not XML"),
        ("<T/>", "contains no Composite_Material"),
        (f"<T>\n{ROW}\n{ROW}\n</T>", "t.xml:3: index 1 occurs twice"),
        (f"<T>{ROW.replace(chr(39) + '1', chr(39) + '-1')}</T>", "index: found '-1'; allowed: a whole number"),
        ("<T><Composite_Material index='1'/></T>", "has no Primary_Substrate"),
        (f"<T>{ROW.replace('<Name>BM_SAND</Name>', '')}</T>", "names no base material"),
        (f"<T>{ROW.replace('</Name>', '</Name><Weight>much</Weight>')}</T>", "Weight: found 'much'"),
        (f"<T>{ROW.replace('</Name>', '</Name><Weight>0</Weight>')}</T>", "all 0"),
        ('<!DOCTYPE T [<!ENTITY a "BM_X"><!ENTITY b "&a;&a;">]><T>&b;</T>', "contains no Composite_Material"),
    ],
)
def test_broken_tables(text, message, tmp_path):
    path = tmp_path / "t.xml"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_table(path)


@pytest.mark.parametrize(
    "composite, message",
    [
        (Composite(1_000_000, "x", Substrate((("BM_SAND", 100),))), "found index 1000000"),
        (Composite(1, "x", Substrate((("SAND", 100),))), "base material 'SAND'"),
        (Composite(1, "x", Substrate((("BM_SAND", 100),), "0")), "Thickness: found '0'"),
    ],
)
def test_tables_that_the_schema_forbids_are_not_written(composite, message, tmp_path):
    with pytest.raises(InputError, match=message):
        write_table(tmp_path / "t.xml", [composite])
    assert not list(tmp_path.iterdir())


def test_broken_rasters(image, materials, tmp_path):
    raster = from_image(image, TILE, materials)
    path = write_cdb(tmp_path, raster)[0]
    with pytest.raises(InputError, match="the index 3, which .* has not; allowed: 1, 2"):
        write_table(raster.location.table(tmp_path), [raster.table[1], raster.table[2]])
        read_cdb(path)
    with pytest.raises(InputError, match="is not in its place in a CDB"):
        read_cdb(path.rename(tmp_path / path.name))
    with pytest.raises(InputError, match="is not named as a CDB raster"):
        read_cdb(tmp_path / "a.tif")
    with pytest.raises(InputError, match="no material for the base material 'BM_GOLD'"):
        materials.mixture(Composite(1, "x", Substrate((("BM_GOLD", 100),))))
    with pytest.raises(InputError, match="'field' is 32 x 32; allowed for a tile of LC04: 64 x 64"):
        from_image(image, parse_tile("N12E044_LC04_U0_R0"), materials)


@pytest.mark.parametrize("name", ["N12E044_L01_U2_R0", "N12E044_LC11_U0_R0", "N12E044_L00", "../N12E044_L00_U0_R0"])
def test_tiles_that_are_not(name):
    with pytest.raises(InputError, match="found the tile"):
        parse_tile(name)


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("BM_TAR: tar", "BM_TAR: tarr", r"\d+:\d+: unknown material 'tarr'; did you mean 'tar'"),
        ("tar: {primary: BM_TAR}", "tar: {primary: {BM_TAR: 50}}", r"\d+:\d+: .*sum to 50"),
        ("tar: {primary: BM_TAR}", "tar: {primary: TAR}", r"\d+:\d+: .*allowed: BM_NAME"),
    ],
)
def test_broken_maps(old, new, message, library, tmp_path):
    from skyshine import materials

    path = tmp_path / "map.yaml"
    text = materials.path("exchange/cdb.yaml").read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message):
        load_map(library, path)


def test_command(tmp_path, demo):
    run = CliRunner()
    export = ["export", str(demo[0]), "--to", "cdb", "--out", str(tmp_path / "cdb")]
    for options, message in (
        ([], "has no place on a map, which the tiles of a CDB are cut by"),
        (["--level", "2"], "--level goes with --tile"),
        (["--tile", "N44W111_L00_U0_R0", "--lod", "3"], "--tile excludes these"),
        (["--tile", "N44W111_L00_U0_R0"], "is 960 x 540; allowed for a tile of L00: 1024 x 1024"),
        (["--model", "road"], "--model needs --lod"),
        (["--model", "road", "--lod", "3"], "powers of two"),
        (["--tile", "N44W111_LC10_U0_R0", "--map", "nowhere.yaml"], "nowhere.yaml: cannot be read"),
    ):
        result = run.invoke(main, export + options)
        assert result.exit_code == 2 and message in result.output and result.output.count("\n") == 1, result.output
    assert not (tmp_path / "cdb").exists()
    result = run.invoke(
        main, [*export, "--tile", "N44W111_LC10_U0_R0", "--json"]
    )  # the last level, one texel of three materials
    assert result.exit_code == 0 and len(json.loads(result.output)["written"]) == 8


# The Base Material Table of a CDB.


@pytest.fixture
def painted(library, tmp_path):
    """A database of 32 x 32 texels: asphalt, and tar in one corner."""
    from PIL import Image

    colours = np.zeros((32, 32, 3), np.uint8)
    colours[20:, 20:] = 255
    Image.fromarray(colours).save(tmp_path / "field.png")
    job = "skyshine: 1\ntextures: [{image: field.png, palette: {colours: {'#000000': asphalt_road, '#FFFFFF': tar}}}]\n"
    (tmp_path / "job.yaml").write_text(job)
    assert CliRunner().invoke(main, ["classify", str(tmp_path / "job.yaml")]).exit_code == 0
    return tmp_path / "build" / "field.tmm.h5"


def _exported(database, root):
    arguments = ["export", str(database), "--to", "cdb", "--tile", "N12E044_LC05_U0_R0", "--out", str(root)]
    return CliRunner().invoke(main, arguments)


def test_a_cdb_without_a_base_material_table_gets_one(painted, tmp_path, materials):
    done = _exported(painted, tmp_path / "cdb")
    assert done.exit_code == 0, done.output
    table = tmp_path / "cdb" / "Metadata" / "Materials.xml"
    assert str(table) in done.output.splitlines()
    assert read_bases(table) == set(materials.recipes.bases)
    written = {name for path in (tmp_path / "cdb").rglob("*D006*.xml") for name in bases_of(read_table(path).values())}
    assert written == {"BM_ASPHALT", "BM_TAR"} and written <= read_bases(table)
    before = table.read_bytes()
    assert str(table) not in _exported(painted, tmp_path / "cdb").output and table.read_bytes() == before


@pytest.mark.shared_data
def test_the_base_material_table_is_the_standard_s(painted, tmp_path, shared_data):
    from lxml import etree

    assert _exported(painted, tmp_path / "cdb").exit_code == 0
    table = tmp_path / "cdb" / "Metadata" / "Materials.xml"
    etree.XMLSchema(etree.parse(shared_data / "cdb" / "Base_Material_Table.xsd")).assertValid(etree.parse(table))
    assert read_bases(table) == read_bases(shared_data / "cdb" / "Materials.xml")


def test_a_base_material_table_must_have_what_is_written(painted, tmp_path):
    table = tmp_path / "cdb" / "Metadata" / "Materials.xml"
    write_bases(table, ["BM_ASPHALT", "BM_SOIL"])
    before = table.read_bytes()
    refused = _exported(painted, tmp_path / "cdb")
    assert refused.exit_code == 2
    assert f"{table}: lacks the base material 'BM_TAR', which would be written" in refused.stderr
    assert "--map" in refused.stderr and len(refused.stderr.splitlines()) == 1
    assert table.read_bytes() == before and not (tmp_path / "cdb" / "Tiles").exists()
    write_bases(table, ["BM_TAR", "BM_ASPHALT"])
    assert _exported(painted, tmp_path / "cdb").exit_code == 0


@pytest.mark.parametrize(
    "text, line",
    [
        ("<Base_Material_Table/>", "contains no Base_Material"),
        ("<Base_Material_Table><Base_Material/></Base_Material_Table>", "contains no Base_Material"),
        ("<Base_Material_Table>", "Materials.xml:1:22: is not XML"),
    ],
)
def test_a_broken_base_material_table_is_one_line(painted, tmp_path, text, line):
    table = tmp_path / "cdb" / "Metadata" / "Materials.xml"
    table.parent.mkdir(parents=True)
    table.write_text(text)
    refused = _exported(painted, tmp_path / "cdb")
    assert refused.exit_code == 2 and line in refused.stderr and len(refused.stderr.splitlines()) == 1


def test_a_tile_whose_own_table_is_elsewhere(image, materials, tmp_path, library):
    written = write_cdb(tmp_path / "cdb", from_image(image, TILE, materials))
    whole = to_image(read_cdb(written[0]), materials)
    written[-1].rename(tmp_path / "table.xml")
    alone = CliRunner().invoke(main, ["export", "--to", "tmm", str(written[0]), "--out", str(tmp_path / "out")])
    assert alone.exit_code == 2 and len(alone.stderr.splitlines()) == 1
    assert f"{written[-1]}: is not there" in alone.stderr and "--table" in alone.stderr
    arguments = [
        "export",
        "--to",
        "tmm",
        str(written[0]),
        "--out",
        str(tmp_path / "out"),
        "--table",
        str(tmp_path / "table.xml"),
    ]
    assert CliRunner().invoke(main, arguments).exit_code == 0
    with open_tmm(tmp_path / "out" / f"{TILE.name}.tmm.h5") as file:
        np.testing.assert_array_equal(file.array("levels/0/mix_code"), whole.level.mix_code)  # all three layers
        np.testing.assert_array_equal(file.array("levels/0/mix_weight"), whole.level.mix_weight)
