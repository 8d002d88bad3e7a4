"""`mat materials new`: what is written is read, has the numbers asked for, and says where they come from."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import skyshine.mat
from skyshine import materials
from skyshine.mat.api.own_material import new_material
from skyshine.mat.cli import main
from skyshine.mat.job.own_materials import of_first_layer
from skyshine.mat.scene.material_summary import material_summary
from skyshine.materials.files import load_thermal
from skyshine.materials.library import load_library
from skyshine.materials.spectrum_files import FileSpectrum
from skyshine.schemas.errors import InputError


def run(*arguments):
    return CliRunner().invoke(main, ["materials", "new", *map(str, arguments)])


@pytest.mark.parametrize(
    "absorptance, emissivity", [(0.32, 0.87), (0.02, 0.03), (0.98, 0.99), (0.95, 0.1), (0.1, 0.95)]
)
@pytest.mark.parametrize("like", ["paint_white_on_metal", "galvanised_new", "grass_green"])
def test_numbers_asked_for_are_those_of_the_material(tmp_path, like, absorptance, emissivity):
    numbers = {"absorptance": absorptance, "thermal_emissivity": emissivity}
    written = new_material("mine", like=like, folder=tmp_path, **numbers)
    material = load_library(tmp_path)["mine"]
    found = material_summary(material)
    assert found["solar_absorptance"] == pytest.approx(absorptance, abs=0.004)
    assert found["thermal_emissivity"] == pytest.approx(emissivity, abs=0.004)
    assert written.code == 1001 and material.group == load_library()[like].group
    assert material.thermal == load_library()[like].thermal and material.surface == load_library()[like].surface


@pytest.mark.parametrize("like", ["paint_olive_on_aluminium", "granite", "galvanised_new"])
def test_emissivity_is_that_of_every_band(tmp_path, like):
    """Scaled to its mean over 300 K, the olive paint kept 0.83 in 3-5 um where 0.93 was asked for."""
    answer = run("mine", "--like", like, "--emissivity", 0.93, "--absorptance", 0.4, "--out", tmp_path)
    assert "emissivity 0.93: beyond 2.5 um" in answer.output
    summary = material_summary(load_library(tmp_path)["mine"])
    for key in ("emissivity_3_5_um", "emissivity_8_12_um", "thermal_emissivity"):
        assert summary[key] == pytest.approx(0.93, abs=1e-4), key
    assert summary["solar_absorptance"] == pytest.approx(0.4, abs=0.004)


def test_emissivity_beside_a_spectrum_is_a_mean_and_says_so(tmp_path):
    file = tmp_path / "own.csv"
    file.write_text("um,emissivity\n" + "".join(f"{um / 4},{0.7 if um < 24 else 0.9}\n" for um in range(12, 61)))
    answer = run("mine", "--like", "concrete", "--spectrum", file, "--emissivity", 0.8, "--out", tmp_path / "own")
    assert "emissivity 0.8: the mean over radiation of 300 K" in answer.output
    summary = material_summary(load_library(tmp_path / "own")["mine"])
    assert summary["thermal_emissivity"] == pytest.approx(0.8, abs=0.004)
    assert summary["emissivity_3_5_um"] < 0.7 < summary["emissivity_8_12_um"]
    with pytest.raises(InputError, match="emissivity beside a spectrum or a thermal emissivity"):
        new_material("two", like="concrete", folder=tmp_path, emissivity=0.8, thermal_emissivity=0.9)


def test_what_is_not_given_stays(tmp_path):
    new_material(
        "mine", like="concrete", folder=tmp_path, values=of_first_layer({"conductivity": 1.1, "thickness": 0.3})
    )
    mine, pattern = load_library(tmp_path)["mine"], load_library()["concrete"]
    assert mine.reflectance == pytest.approx(pattern.reflectance, abs=1e-5)
    assert [mine.thermal.skin.conductivity, mine.thermal.layers[0].conductivity] == [1.1, 1.1]
    assert mine.thermal.layers[0].thickness == 0.3 and mine.thermal.skin.thickness == pattern.thermal.skin.thickness
    assert mine.thermal.layers[1] == pattern.thermal.layers[1] and mine.thermal.back == pattern.thermal.back
    assert mine.sources["layers.1.conductivity"] == "user"
    assert mine.sources["layers.2.conductivity"].startswith("like concrete: ")


def test_stand_of_leaves_goes_with_them_and_may_stand_elsewhere(tmp_path, monkeypatch):
    new_material("mine", like="shrub", folder=tmp_path, absorptance=0.8)
    file = tmp_path / "ht" / "mine.yaml"
    mine = load_library(tmp_path)["mine"]
    assert mine.stand == load_library()["shrub"].stand and mine.sources["stand.soil"].startswith("like shrub: ")
    for soil, message in (
        ("soil_sand", None),
        ("nowhere", "found mine on 'nowhere', which the library has not"),
        ("snow_fine", "found mine on 'snow_fine'; allowed: on ground without leaves"),
    ):
        rows = [line for line in file.read_text().splitlines() if not line.startswith("  soil: ")]
        file.write_text("\n".join([*rows, f"  soil: {soil}"]) + "\n")
        monkeypatch.setenv("MATERIALS_DATABASE", str(tmp_path))
        if message is None:
            assert load_library()["mine"].stand.soil == soil
            continue
        with pytest.raises(InputError, match=message):
            skyshine.mat.temperature("mine", job=skyshine.mat.example("starter"), leaf_area_index=1)


@pytest.mark.parametrize("like", ["sea_ice", "soil_loam_brown", "shrub"])
def test_light_within_pores_and_leaves_are_those_of_the_pattern(tmp_path, monkeypatch, like):
    """Without them ice is a wall to light, and soil does not know its moisture."""
    new_material("mine", like=like, folder=tmp_path, absorptance=0.5)
    monkeypatch.setenv("MATERIALS_DATABASE", str(tmp_path))
    mine, pattern = load_library()["mine"], load_library()[like]
    assert (mine.thermal.light, mine.soil, mine.stand) == (pattern.thermal.light, pattern.soil, pattern.stand)


def test_stand_needs_leaves_and_numbers_in_range(tmp_path):
    pattern = (materials.path("ht/concrete.yaml")).read_text()
    file = tmp_path / "mine.yaml"
    for stand, message in (
        ("{leaf_area_index: 1, soil: soil_sand}", "found a stand of a surface without leaves"),
        ("{leaf_area_index: 0, soil: soil_sand}", "greater than 0"),
        ("{leaf_area_index: 21, soil: soil_sand}", "less than or equal to 20"),
        ("{leaf_area_index: 1, soil: soil_sand, clumping: 1.5}", "less than or equal to 1"),
        ("{leaf_area_index: 1}", "soil"),
    ):
        file.write_text(f"{pattern}stand: {stand}\n")
        with pytest.raises(InputError, match=message):
            load_thermal(file)


def test_spectrum_stands_where_it_holds_values(tmp_path):
    x = np.concatenate([np.linspace(0.35, 2.5, 400), np.linspace(8, 14, 200)])
    own = FileSpectrum(x, np.where(x < 5, 0.4, 0.02), "sample 7", "columns, um, reflectance in fraction")
    written = new_material("mine", like="concrete", folder=tmp_path, spectrum=own)
    mine, pattern = load_library(tmp_path)["mine"], load_library()["concrete"]
    at = {um: np.argmin(np.abs(mine.wavelength - um)) for um in (0.31, 1.0, 5.0, 10.0, 14.8)}
    assert mine.reflectance[[at[1.0], at[10.0]]] == pytest.approx([0.4, 0.02], abs=1e-5)
    others = [at[0.31], at[5.0], at[14.8]]
    assert mine.reflectance[others] == pytest.approx(pattern.reflectance[others], abs=1e-5)
    assert [stretch.kind for stretch in mine.ranges] == ["proxy", "measured"] * 2 + ["proxy"]
    assert written.borrowed[1] == pytest.approx((2.5, 8.0), rel=0.02)
    assert "sample 7" in mine.reflectance_note and "ECOSTRESS" in mine.reflectance_note


def test_a_fine_spectrum_is_averaged_not_picked(tmp_path):
    x = np.linspace(0.3, 15, 200_001)
    own = FileSpectrum(x, 0.5 + 0.4 * np.sign(np.sin(9000 * x)), "comb", "columns")
    new_material("mine", like="concrete", folder=tmp_path, spectrum=own)
    assert load_library(tmp_path)["mine"].reflectance[1:-1] == pytest.approx(0.5, abs=0.06)


def test_material_of_ones_own_runs_through_a_day(tmp_path, monkeypatch):
    hot = new_material("hot", like="paint_white_on_metal", folder=tmp_path, absorptance=0.9)
    cool = new_material("cool", like="paint_white_on_metal", folder=tmp_path, absorptance=0.2)
    assert (hot.code, cool.code) == (1001, 1002)
    monkeypatch.setenv("MATERIALS_DATABASE", str(tmp_path))
    days = [skyshine.mat.temperature(name, job=skyshine.mat.example("starter")) for name in ("hot", "cool")]
    assert days[0].temperature.max() > days[1].temperature.max() + 15.0


def test_plain_numbers_of_a_file_are_taken(tmp_path):
    new_material("mine", like="concrete", folder=tmp_path)
    file = tmp_path / "ht" / "mine.yaml"
    lines = [line if "density" not in line else line.split(":")[0] + ": 2000" for line in file.read_text().splitlines()]
    file.write_text("\n".join(lines) + "\n")
    mine = load_library(tmp_path)["mine"]
    assert mine.thermal.layers[1].density == 2000 and mine.sources["layers.2.density"] == "user"


def test_no_packaged_number_is_a_users():
    for material in load_library():
        assert "user" not in material.sources.values(), material.name


@pytest.mark.parametrize(
    "arguments, message",
    [
        (("concrete", "--like", "tar"), "there is a material 'concrete'; choose another name"),
        (("mine", "--like", "glass_window"), "'glass_window' lets light pass"),
        (("mine", "--like", "concreet"), "did you mean 'concrete'"),
        (("mine", "--like", "concrete", "--code", "31"), "code 31 is that of 'brick_red'"),
        (("mine", "--like", "concrete", "--unit", "nm"), "without --spectrum; add the file"),
        (("mine", "--like", "concrete", "--absorptance", "1.2"), "1.2 is not in the range"),
        (("mine", "--like", "concrete", "--spectrum", "missing.csv"), "missing.csv"),
        (("Mine Own", "--like", "concrete"), "found 'Mine Own'"),
    ],
)
def test_what_cannot_be_made_is_refused_and_nothing_written(tmp_path, arguments, message):
    result = run(*arguments, "--out", tmp_path / "own")
    assert result.exit_code == 2 and message in result.output
    assert not (tmp_path / "own").exists()


def test_command_says_what_it_wrote(tmp_path):
    csv = tmp_path / "lab.csv"
    csv.write_text("wavelength nm,reflectance %\n" + "\n".join(f"{x},{30}" for x in range(400, 2500, 10)))
    result = run("mine", "--like", "concrete", "--spectrum", csv, "--out", tmp_path / "own", "--emissivity", "0.8")
    assert result.exit_code == 0, result.output
    assert "read columns, nm, reflectance in percent: 0.4 to 2.49 um" in result.output
    assert "from concrete" in result.output and "MATERIALS_DATABASE=" in result.output
    dumped = run("other", "--like", "concrete", "--absorptance", "0.5", "--out", tmp_path / "own", "--json")
    assert json.loads(dumped.output)["code"] == 1002
    with pytest.raises(InputError):
        new_material("other", like="concrete", folder=tmp_path / "own")


def test_a_description_with_quotes_and_lines_is_kept(tmp_path):
    new_material("mine", like="concrete", folder=tmp_path, description='wall "B": grey,\n#2 {old}')
    assert load_library(tmp_path)["mine"].description == 'wall "B": grey, #2 {old}'
