"""`leaf_area_index` of a job: what it opens, what it leaves, what tables and messages say of it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.atmosphere import materials_digest
from skyshine.mat.scene.moisture import job_library, moist
from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.soil_moisture import TEXTURES
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

RECORD = "time,sw_down,lw_down,air_temperature[C],relative_humidity,wind_speed,pressure[hPa]"


def job(**keys):
    return {
        "skyshine": 1,
        "name": "dry scrub",
        "site": {"latitude_deg": 40, "longitude_deg": 5, "date": "2026-07-15", "utc_offset_h": 2},
        "states": [
            {
                "profile": "midlatitude_summer",
                "ground_material": "soil_loam_brown",
                "weather": {"air_temperature_c": [16, 32], "relative_humidity_percent": 35},
            }
        ],
        "bands": [],
        "materials": ["shrub", "grass_dry", "soil_loam_brown"],
        **keys,
    }


def library_of(**keys):
    return job_library(load_job(job(**keys)).trimmed)


def digest(name, **keys):
    return materials_digest(library_of(**keys), (name,))


@pytest.mark.validation  # 5 s
def test_sparse_shrub_is_much_hotter_at_noon_and_says_of_what():
    dense = skyshine.mat.temperature("shrub", job=job())
    sparse = skyshine.mat.temperature("shrub", job=job(leaf_area_index={"shrub": 0.8}))
    noon = int(np.argmax(sparse.temperature))
    assert 6 < sparse.temperature[noon] - dense.temperature[noon] < 14
    assert 8 < sparse.soil_temperature[noon] - sparse.leaf_temperature[noon] < 25
    here = skyshine.mat.temperature("shrub", job=job(), leaf_area_index=0.8)
    np.testing.assert_array_equal(here.temperature, sparse.temperature)
    held = sparse.to_xarray()
    np.testing.assert_array_equal(held["soil_temperature"], sparse.soil_temperature)


def test_no_leaves_are_the_soil_to_the_bit():
    bare = skyshine.mat.temperature("soil_loam_brown", job=job())
    none = skyshine.mat.temperature("shrub", job=job(leaf_area_index={"shrub": 0}))
    np.testing.assert_array_equal(none.temperature, bare.temperature)
    material, soil = library_of(leaf_area_index={"shrub": 0})["shrub"], load_library()["soil_loam_brown"]
    at = np.interp(soil.wavelength, material.wavelength, material.reflectance)
    np.testing.assert_allclose(at, soil.reflectance, rtol=1e-12)


def test_soil_below_leaves_may_be_wet_although_no_material_shows_it():
    shrub = {"materials": ["shrub"], "leaf_area_index": 0.8}
    dry = skyshine.mat.temperature("shrub", job=job(**shrub))
    wet = skyshine.mat.temperature("shrub", job=job(**shrub, soil_moisture="wet"))
    assert dry.soil_temperature.max() - wet.soil_temperature.max() > 5
    with pytest.raises(InputError, match="of which none has soil"):
        load_job(job(materials=["concrete"], soil_moisture="wet", states=[{"weather": {"air_temperature_c": 20}}]))


def test_without_the_key_stands_have_the_leaves_of_the_library():
    for keys in ({}, {"leaf_area_index": "library"}):
        day = skyshine.mat.temperature("grass_dry", job=job(**keys))
        assert day.soil_temperature.max() > day.leaf_temperature.max() + 5
    assert digest("grass_dry") == digest("grass_dry", leaf_area_index="library")


def test_stands_are_closed_where_there_is_no_air_or_a_job_operates_them(tmp_path):
    operated = job(materials=["shrub", "grass_dry"], operated={"shrub": {"kind": "fixed", "temperature_c": 20}})
    library = job_library(load_job(operated).trimmed)
    assert library["shrub"].opened is None and library["grass_dry"].opened is not None
    file = tmp_path / "record.csv"
    rows = [f"2026-07-15T{hour:02d}:00Z,300,340,25,40,2,1000" for hour in range(24)]
    for names, more in ((RECORD, ""), (RECORD + ",rain", ",0")):
        file.write_text("\n".join([names, *(row + more for row in rows)]) + "\n")
        day = skyshine.mat.temperature("shrub", forcing=file)
        assert day.leaf_temperature is not None and (day.film is not None) == bool(more)
    assert skyshine.mat.temperature("shrub", forcing=file, depth=0.1).leaf_temperature is None
    file.write_text("\n".join([RECORD, *(row.replace(",1000", ",0") for row in rows)]) + "\n")
    assert skyshine.mat.temperature("shrub", forcing=file).leaf_temperature is None  # no air
    with pytest.raises(InputError, match="where there is no air; allowed: a closed skin; remove leaf_area_index"):
        skyshine.mat.temperature("shrub", forcing=file, leaf_area_index=1, latitude=40, longitude=5)
    assert skyshine.mat.temperature("shrub", job=job(), depth=0.1).leaf_temperature is None


def test_ground_of_watered_stands_is_at_field_capacity_unless_a_job_says_otherwise():
    """Carsel and Parrish's loam at 33 kPa: 0.165 m3/m3."""
    ground = job_library(load_job(job(materials=["grass_green"])).trimmed)["grass_green"].opened.soil
    assert ground.surface == moist(load_library()["soil_loam_brown"], 0.165).surface
    soil = TEXTURES["loam"]
    drained = (1 + (3.3 * soil.alpha) ** soil.n) ** (1 / soil.n - 1)
    assert soil.residual + (soil.saturated - soil.residual) * drained == pytest.approx(0.165, abs=0.002)
    for value in ("dry", 0.3):
        other = load_job(job(materials=["grass_green"], soil_moisture={"soil_loam_brown": value})).trimmed
        ground = job_library(other)["grass_green"].opened.soil
        known = load_library()["soil_loam_brown"]
        assert ground.surface == moist(known, 0.3 if value == 0.3 else 0.0).surface


def test_only_stands_answer_to_the_key():
    for name in ("soil_loam_brown", "hay", "concrete"):
        assert digest(name, leaf_area_index="library") == digest(name)
    assert len({digest("shrub", **keys) for keys in ({}, {"leaf_area_index": 1}, {"leaf_area_index": 2})}) == 3
    assert digest("shrub", leaf_area_index={"grass_dry": 1}) != digest("shrub")  # then it alone has gaps
    moist = {"leaf_area_index": 1, "soil_moisture": "moist"}
    assert digest("shrub", **moist) != digest("shrub", leaf_area_index=1)  # the soil below answers


def test_spectra_are_those_of_leaves_and_soil_seen_from_above():
    library = load_library()
    mixed = library_of(leaf_area_index=1)["shrub"]
    gap = np.exp(-0.5)
    for micron in (0.55, 0.86, 9.0):
        parts = [
            np.interp(micron, part.wavelength, part.reflectance) for part in (mixed.opened.leaves, mixed.opened.soil)
        ]
        known = [np.interp(micron, library[n].wavelength, library[n].reflectance) for n in ("shrub", "soil_loam_brown")]
        assert parts == known
        expected = (1 - gap) * parts[0] + gap * parts[1]
        assert np.interp(micron, mixed.wavelength, mixed.reflectance) == pytest.approx(expected, rel=1e-9)
    (surface,) = surface_materials([mixed])
    assert surface.canopy.leaf_area == 1.0 and surface.canopy.soil.name == "soil_loam_brown"


def test_own_leaf_area_of_the_library_is_by_word():
    word = library_of(leaf_area_index="library")["grass_dry"]
    assert word.opened.leaf_area == load_library()["grass_dry"].stand.leaf_area_index


def test_each_stand_of_the_library_stands_on_a_soil_of_it():
    library = load_library()
    stands = {material.name: material.stand for material in library if material.stand is not None}
    without = {"hay", "green_roof", "deciduous_leafless"}  # cut, on insulation, without leaves
    assert set(stands) == {material.name for material in library if material.surface.canopy} - without
    for stand in stands.values():
        assert 1 < stand.leaf_area_index < 7 and not library[stand.soil].surface.canopy


def test_check_says_how_much_soil_is_seen():
    lines = skyshine.mat.check(job(leaf_area_index={"shrub": 0.8})).surfaces
    assert lines == [
        "leaf_area_index: shrub with 0.8 m2/m2 of leaves: 67.0% of the ground seen from above is soil_loam_brown",
        "leaf_area_index: grass_dry without gaps between its leaves",
    ]


def test_record_needs_the_sun_for_gaps_and_takes_it(tmp_path):
    rows = [
        f"2026-07-{day}T{hour:02d}:00Z,{max(0, 800 * np.sin((hour - 4) / 16 * np.pi)):.1f},340,25,40,2,1000"
        for day in (15, 16)
        for hour in range(24)
    ]
    file = tmp_path / "record.csv"
    file.write_text("\n".join([RECORD, *rows]) + "\n")
    with pytest.raises(InputError, match="gaps of leaves.*give latitude and longitude"):
        skyshine.mat.temperature("shrub", forcing=file, leaf_area_index=1)
    place = {"forcing": file, "latitude": 40.0, "longitude": 5.0}
    closed, sparse, bare = (
        skyshine.mat.temperature("shrub", **place, **given).temperature.max()
        for given in ({"leaf_area_index": 20}, {"leaf_area_index": 1}, {"leaf_area_index": 0})
    )
    assert closed + 3 < sparse < bare
    assert bare == pytest.approx(skyshine.mat.temperature("soil_loam_brown", **place).temperature.max(), abs=0.05)


@pytest.mark.parametrize(
    ("material", "value", "message"),
    [
        ("concrete", 1, "found 'concrete', which has no stand of leaves"),
        ("shrub", 21, "found 21; allowed: 0 to 20 m2/m2, or library"),
        ("shrub", float("nan"), "found nan"),
        ("shrub", -1, "found -1"),
        ("shrub", "some", "some"),
    ],
)
def test_wrong_leaf_area_is_one_line(material, value, message):
    with pytest.raises(InputError, match=message) as caught:
        skyshine.mat.temperature(material, job=job(), leaf_area_index=value)
    assert "\n" not in str(caught.value)


def test_a_job_and_an_argument_are_not_both_taken():
    with pytest.raises(InputError, match="which the job has too"):
        skyshine.mat.temperature("shrub", job=job(leaf_area_index=1), leaf_area_index=1)


def test_command_gives_leaves_and_soil(tmp_path):
    file = tmp_path / "job.yaml"
    file.write_text(json.dumps(job()))
    run = CliRunner().invoke(
        main, ["temperature", "--material", "shrub", "--job", str(file), "--leaf-area-index", "0.8", "--json"]
    )
    assert run.exit_code == 0, run.output
    found = json.loads(run.output)
    assert max(found["soil_temperature"]["values"]) > max(found["leaf_temperature"]["values"]) + 5
    bad = CliRunner().invoke(
        main, ["temperature", "--material", "shrub", "--job", str(file), "--leaf-area-index", "much"]
    )
    assert bad.exit_code == 2 and "leaf_area_index: found much; allowed" in bad.output
    shown = CliRunner().invoke(main, ["materials", "shrub"])
    assert "stand.leaf_area_index" in shown.output and "answers to leaf_area_index" in shown.output


def test_a_built_table_holds_what_is_seen_and_is_built_anew_for_other_leaves(builds_here, tmp_path):
    """One temperature a material, as of closed stands, and its response to shade."""
    grid = {"altitude_km": [0], "azimuth_deg": [0, 180], "slope_deg": [0, 30]}
    given = {"surface_grid": grid, "materials": ["shrub"], "output": {"folder": "built", "pictures": False}}
    file, place = tmp_path / "job.yaml", {"material": 114, "altitude": 0.0, "azimuth": 0.0, "slope": 0.0}
    hours = np.arange(0.0, 24.0, 1.5)
    noons = []
    for leaf_area in (4.0, 0.8):
        file.write_text(json.dumps(job(leaf_area_index={"shrub": leaf_area}, **given)))
        skyshine.mat.build(file)
        table = skyshine.mat.open(tmp_path / "built" / "s01.htt.h5")
        noons.append(float(table.temperature(**place, time=13.0)))
    day = skyshine.mat.temperature("shrub", job=file)
    read = table.temperature(**place, time=hours)
    assert np.abs(read - np.interp(hours, day.time, day.temperature)).max() < 0.5
    assert noons[1] > noons[0] + 4
    shaded = float(table.shaded_temperature(**place, time=13.0))
    whole = skyshine.mat.temperature("shrub", job=file, shade="00:00-24:00")
    exact = np.interp(13.0, whole.time, whole.temperature)
    assert exact < noons[1] - 8 and abs(shaded - exact) < 2.5
