"""The packaged materials, a user's folder on top of them, and what is said of broken files."""

import itertools
import json
import re
import shutil

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine import materials
from skyshine.mat.cli import main
from skyshine.mat.surface.soil_moisture import conductivity
from skyshine.materials.files import load_thermal
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def library():
    return load_library()


def test_all_packaged_materials_load(library):
    loaded = list(library)
    assert len(loaded) == len(library) >= 182
    assert [material.code for material in loaded] == sorted({material.code for material in loaded})
    for material in loaded:
        assert library.by_code(material.code) is library[material.name] is material
        assert material.wavelength[0] <= 0.3 and material.wavelength[-1] >= 14.0
        assert np.all(np.diff(material.wavelength) > 0.0)
        for values in (material.reflectance, material.absorptance, material.reflectance + material.absorptance):
            assert np.all((values >= 0.0) & (values <= 1.0 + 1e-9))


def test_no_file_without_its_entry(library):
    for folder, ending in (("ht", ".yaml"), ("ref", ".csv"), ("spec", ".yaml")):
        names = {file.stem for file in materials.path(folder).glob(f"*{ending}")} - {"recipes"}
        assert names == set(library.names), folder


def test_every_number_has_a_source_whose_reference_is_given(library):
    for material in library:
        fields = [key for key in material.sources if key.startswith(("skin.", "layers.", "back.", "surface."))]
        assert len(fields) >= 3 * 4 + 2 + 5
        for field, text in material.sources.items():
            assert text.strip(), (material.name, field)
            if field != "reflectance":
                assert set(re.findall(r"\[(\w+)\]", text)) <= set(library.references), (material.name, field)


def test_every_wavelength_has_an_origin(library):
    for material in library:
        edges = [(stretch.lower, stretch.upper) for stretch in material.ranges]
        assert edges[0][0] == pytest.approx(material.wavelength[0], rel=1e-3)
        assert edges[-1][1] == pytest.approx(material.wavelength[-1], rel=1e-3)
        for (_, end), (start, _) in itertools.pairwise(edges):
            assert start == pytest.approx(end, rel=2e-3), material.name
        assert "sample:" in material.reflectance_note


def test_materials_of_one_spectrum_say_whose_it_is(library):
    """Between two of one spectrum there is no contrast in any band but that of temperature."""
    owner = {}
    for material in library:
        sample = re.search(r"^sample: (.*)$", material.reflectance_note, re.MULTILINE).group(1)
        said = re.match(r"the spectrum of (\w+): ", sample)
        values = material.reflectance.tobytes() + material.absorptance.tobytes()
        if said:
            assert np.array_equal(material.reflectance, library[said.group(1)].reflectance), material.name
        else:
            assert values not in owner, (material.name, owner.get(values))
            owner[values] = material.name
    assert len(owner) > 170


def test_sources_ask_for_their_credit_line(library):
    credit = "courtesy of the Jet Propulsion Laboratory"
    for material in library:
        if any("[ecostress]" in stretch.note or "[aster_jhu]" in stretch.note for stretch in material.ranges):
            assert credit in material.reflectance_note, material.name


def test_thermal_numbers_are_those_of_the_tables(library):
    """Diffusivity [m2 s-1] and admittance [J m-2 s-1/2 K-1] of Oke (1987), tables 2.1 and 7.4, to their two digits."""
    for name, layer, diffusivity, admittance in (
        ("sand_desert", 0, 0.24e-6, 620.0),
        ("concrete", 0, 0.72e-6, 1785.0),
        ("brick_red", 0, 0.61e-6, 1065.0),
        ("snow_fine", 0, 0.38e-6, 130.0),
    ):
        part = library[name].thermal.layers[layer]
        volumetric = part.density * part.heat_capacity
        assert part.conductivity / volumetric == pytest.approx(diffusivity, rel=0.04), name
        assert np.sqrt(part.conductivity * volumetric) == pytest.approx(admittance, rel=0.04), name


def test_roads_and_basalt_conduct_as_measured_ones(library):
    """Asphalt of 2300 kg m-3 1.15 W m-1 K-1 (ASHRAE), hot mix 0.90 (Carlson et al. 2010, J. Mater. Civ. Eng. 22, 186);
    basalt 1.5 to 2.0 in the collections of Saptadji (2002)."""
    for name in ("asphalt_road", "asphalt_runway_black", "asphalt_concrete", "tar"):
        assert 0.9 <= library[name].thermal.layers[0].conductivity <= 2.0
    assert 1.5 <= library["basalt"].thermal.layers[0].conductivity <= 2.0


def test_loose_stone_conducts_as_measured_beds_do(library):
    """Railway ballast 0.35 W m-1 K-1 (Adv. Mater. Sci. Eng. 2021, 5548638, table 3), beds of crushed rock 0.4 to 0.9;
    2.0 is the design value of compacted, moist gravel."""
    for name in ("gravel_limestone", "ballast_granite", "roof_gravel", "gravel_road"):
        layer = library[name].thermal.layers[0]
        assert 0.35 <= layer.conductivity <= 0.9 and 1400 < layer.density < 2000, name
        soil = library[name].soil
        if soil is not None:
            assert conductivity(soil, 0.0) == pytest.approx(layer.conductivity, abs=0.21), name


def test_backs_in_operation_have_sources_and_are_no_colder_than_at_rest(library):
    operated = [material for material in library if material.operated]
    assert {material.name for material in operated} >= {"engine_deck", "exhaust_pipe", "tyre", "ship_funnel"}
    for material in operated:
        for name, back in material.operated.items():
            assert material.sources[f"operated.{name}.kind"].startswith("definition: ")
            assert back.kind == "convective" and 320.0 < back.temperature < 800.0, (material.name, name)


def test_derived_thicknesses_are_what_their_source_says(library):
    derived = 0
    for material in library:
        for key, layer in (("skin", material.thermal.skin), ("layers.2", material.thermal.layers[1])):
            source = material.sources[f"{key}.thickness"]
            diffusivity = layer.conductivity / (layer.density * layer.heat_capacity)
            if found := re.match(r"derived: heat crosses it in (\S+) s", source):
                seconds = layer.thickness**2 / diffusivity
                assert seconds == pytest.approx(float(found.group(1)), rel=0.06) and seconds < 600.0, material.name
                derived += 1
            elif found := re.match(r"derived: (\S+) damping depths of the day", source):
                depths = layer.thickness / np.sqrt(86_400.0 * diffusivity / np.pi)
                assert depths == pytest.approx(float(found.group(1)), rel=0.06) and depths > 2.0, material.name
                derived += 1
    assert derived > 80


def test_flags_mark_what_they_should(library):
    for material in library:
        assert material.surface.snow == (material.group in ("snow", "ice"))
        if material.surface.canopy:
            assert material.group == "vegetation"
            leaves = material.thermal.skin
            assert leaves.thickness * leaves.density * leaves.heat_capacity < 10_000.0  # J m^-2 K^-1


def test_codes_and_groups_are_those_of_the_materials(library):
    assert [library.code(name) for name in library.names] == [material.code for material in library]
    assert [library.group(name) for name in library.names] == [material.group for material in library]
    with pytest.raises(InputError, match="unknown material 'asphalt_rode'.*asphalt_road"):
        library.code("asphalt_rode")


def test_unknown_name_and_code(library):
    with pytest.raises(
        InputError,
        match="unknown material 'concret'; did you mean 'concrete'.*to add it: 'mat materials new concret --like",
    ):
        library["concret"]
    with pytest.raises(InputError, match="no material of code 60000"):
        library.by_code(60000)


@pytest.fixture
def own(tmp_path):
    """A user's folder with a copy of brick_red and an added material."""
    for folder, ending in (("ht", "yaml"), ("ref", "csv"), ("spec", "yaml")):
        (tmp_path / folder).mkdir()
        for target in ("brick_red", "hangar_roof"):
            shutil.copy(materials.path(f"{folder}/brick_red.{ending}"), tmp_path / folder / f"{target}.{ending}")
    (tmp_path / "mat.yaml").write_text(
        "data_version: 2.3.4\n"
        "materials:\n"
        "  - {code: 31, name: brick_red, group: brick, description: our brick}\n"
        "  - {code: 1001, name: hangar_roof, group: roofing, description: hangar}\n"
    )
    return tmp_path


def replace(file, old, new):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def test_own_folder_replaces_and_adds(own, monkeypatch, library):
    monkeypatch.setenv("MATERIALS_DATABASE", str(own))
    mine = load_library()
    assert mine["brick_red"].description == "our brick"
    assert mine.by_code(1001).name == "hangar_roof"
    assert len(mine) == len(library) + 1
    assert mine.version == f"{library.version}+{own.name}-2.3.4"


def test_a_library_is_read_again_where_a_file_has_changed(own):
    before = load_library(own)
    assert load_library(own) is before
    old = before["hangar_roof"].thermal
    replace(own / "ht" / "hangar_roof.yaml", "density: {value: 1830", "density: {value: 2830")
    assert load_library(own)["hangar_roof"].thermal != old == before["hangar_roof"].thermal


def test_own_folder_must_not_take_a_code(own):
    replace(own / "mat.yaml", "code: 1001", "code: 26")
    with pytest.raises(InputError, match=r"mat\.yaml:4.*code 26 of 'hangar_roof' is that of 'concrete'.*free code"):
        load_library(own)


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("code: 1001", "code: 31", r"mat\.yaml:4:\d+: code 31 occurs twice \(first at line 3\)"),
        ("name: hangar_roof", "name: brick_red", r"mat\.yaml:4:\d+: name brick_red occurs twice"),
        ("code: 1001", "code: 0", r"mat\.yaml:4:\d+: materials\.1\.code: found 0"),
        ("code: 1001", "code: 65536", r"mat\.yaml:4:\d+: materials\.1\.code: found 65536"),
        ("code: 1001", "kode: 1001", r"mat\.yaml:4:\d+: .*unknown key 'kode'; did you mean 'code'"),
        ("2.3.4", "2.3", r"mat\.yaml:1:\d+: data_version: .*semantic version"),
    ],
)
def test_broken_index(own, old, new, message):
    replace(own / "mat.yaml", old, new)
    with pytest.raises(InputError, match=message):
        load_library(own)


def test_missing_folder_and_index(tmp_path):
    with pytest.raises(InputError, match="not a folder"):
        load_library(tmp_path / "none")
    with pytest.raises(InputError, match=r"mat\.yaml: cannot be read"):
        load_library(tmp_path)


@pytest.mark.parametrize(
    "file, old, new, message",
    [
        ("ht", "conductivity: {value: 0.83", "conductivity: {value: -0.83", r"yaml:7:\d+: skin\.conductivity\.value"),
        ("ht", "density: {value: 1830", "density: {value: heavy", r"yaml:8:\d+: skin\.density\.value: found 'heavy'"),
        (
            "ht",
            "heat_capacity: {value: 750",
            "heatcapacity: {value: 750",
            r"yaml:9:.*'heatcapacity'; did you mean 'heat_capacity'",
        ),
        ("ht", "kind: {value: convective", "kind: {value: fixed", r"'fixed' takes no 'coefficient'"),
        ("ht", "value: 0.003, source: ", "value: 0.003, sauce: ", r"yaml:6:\d+: .*'sauce'; did you mean 'source'"),
        ("ht", 'source: "[oke1987] table 7.4, brick"', 'source: " "', r"yaml:7:\d+: skin\.conductivity\.source: "),
        ("spec", "lobe_fwhm: {value: 60", "lobe_fwhm: {value: 360", r"yaml:3:\d+: lobe_fwhm\.value: found 360"),
        ("spec", "specular_fraction: {value: 0.05", "specular_fraction: {value: 5", r"fraction\.value: found 5"),
        ("ref", "wavelength_um,reflectance", "um,percent", r"csv:\d+:1: found the column names 'um,percent'; allowed"),
        ("ref", "\n0.3,0.0", "\n0.3,3.0", r"csv:\d+:5: reflectance: found 3\.\d+; allowed: 0 to 1; divide by 100"),
        ("ref", "\n0.3,0.0", "\n0.9,0.0", r"csv:\d+:1: wavelength_um: found 0\.30\d+ after 0\.9"),
        ("ref", "\n0.3,0.0", "\n0.3,nan,0.0", r"csv:\d+:1: found 3 cells; allowed: 2"),
        ("ref", " held", " hold", r"csv:\d+:1: range: found '.*hold'; did you mean 'held'"),
        ("ref", "# range: 0.3 ", "# range: low ", r"csv:\d+:1: found 'range: low .*allowed: 'range: LOWER UPPER KIND"),
    ],
)
def test_broken_material_file(own, file, old, new, message):
    path = next((own / file).glob("hangar_roof.*"))
    replace(path, old, new)
    library = load_library(own)
    library["brick_red"]  # the other material is untouched
    with pytest.raises(InputError, match=message) as caught:
        library["hangar_roof"]
    assert str(caught.value).startswith(str(path))


def test_missing_material_file(own):
    (own / "ref" / "hangar_roof.csv").unlink()
    with pytest.raises(InputError, match=r"hangar_roof\.csv: does not exist; check the path"):
        load_library(own)["hangar_roof"]


def test_transmitting_table_must_leave_room(own):
    path = own / "ref" / "hangar_roof.csv"
    path.write_text("wavelength_um,reflectance,absorptance\n0.3,0.5,0.6\n14,0.1,0.1\n")
    with pytest.raises(InputError, match=r"csv:2:5: found reflectance \+ absorptance = 1\.1"):
        load_library(own)["hangar_roof"]


def test_command_lists_and_shows(library):
    run = CliRunner()
    listed = json.loads(run.invoke(main, ["materials", "--json"]).output)
    assert [entry["name"] for entry in listed["materials"]] == list(library.names)
    assert all(0.0 < entry["thermal_emissivity"]["value"] <= 1.0 for entry in listed["materials"])
    shown = json.loads(run.invoke(main, ["materials", "water_sea", "--json"]).output)
    assert shown["emissivity_8_12_um"]["value"] == pytest.approx(0.987, abs=0.006)
    assert "coxmunk1954" in shown["references"] and shown["values"]["lobe_fwhm"]["source"]
    by_code = run.invoke(main, ["materials", str(shown["code"])])
    assert by_code.exit_code == 0 and "[coxmunk1954]" in by_code.output
    assert run.invoke(main, ["materials", "watr"]).exit_code == 2


def test_shares_of_light_beyond_all_of_it_are_placed(tmp_path):
    text = materials.path("ht/sea_ice.yaml").read_text(encoding="utf-8").replace("value: 0.18", "value: 0.7")
    extra = '  - share: {value: 0.4, source: "a"}\n    extinction: {value: 2, source: "b"}\nsurface:\n'
    file = tmp_path / "ice.yaml"
    file.write_text(text.replace("surface:\n", extra), encoding="utf-8")
    with pytest.raises(InputError, match="ice.yaml:.*found shares of light with a sum of 1.1; allowed: 1 at most"):
        load_thermal(file)
    stack, *_ = load_thermal(materials.path("ht/sea_ice.yaml"))
    assert [(part.share, part.extinction) for part in stack.light] == [(0.18, 1.5)]
