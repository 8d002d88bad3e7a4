"""Materials that a job defines: those that `mat materials new` would write, built without an environment variable."""

import json
import re

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.api.own_material import new_material
from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.mat.job.load import load_job
from skyshine.mat.job.own_materials import job_materials, of_first_layer
from skyshine.mat.radiometry.reflectance import solar_absorptance
from skyshine.mat.scene.atmosphere import materials_digest
from skyshine.mat.scene.material_summary import material_summary
from skyshine.mat.scene.moisture import job_library
from skyshine.materials.library import load_library
from skyshine.materials.spectrum_files import Said, read_spectrum
from skyshine.schemas.errors import InputError

JOB = {
    "skyshine": 1,
    "name": "own",
    "site": {"latitude_deg": 47, "longitude_deg": 7, "date": "2026-06-21", "utc_offset_h": 2},
    "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [12, 26]}}],
    "bands": [],
    "surface_grid": {"altitude_km": [0], "azimuth_deg": [0, 180], "slope_deg": [0, 90]},
}
NUMBERS = {"conductivity": 0.7, "density": 1900.0, "heat_capacity": 700.0, "thickness": 0.05}
OWN = {"like": "concrete", "absorptance": 0.8, "emissivity": 0.6, **NUMBERS}


def loaded(**materials):
    return load_job({**JOB, "materials": materials}).trimmed


def test_it_is_the_material_that_the_command_writes(tmp_path):
    job = loaded(mine=OWN, asphalt_road=None)
    assert job.materials == ["mine", "asphalt_road"]
    own = job_materials(job.own_materials)["mine"]
    new_material(
        "mine", like="concrete", folder=tmp_path, absorptance=0.8, emissivity=0.6, values=of_first_layer(NUMBERS)
    )
    written = load_library(tmp_path)["mine"]
    assert (own.code, own.thermal, own.surface, own.transmits) == (1001, written.thermal, written.surface, False)
    np.testing.assert_allclose(own.reflectance, written.reflectance, atol=1e-5)
    np.testing.assert_allclose(own.absorptance, 1 - own.reflectance)
    assert own.sources["layers.1.density"] == "user" and own.sources["back.kind"] == written.sources["back.kind"][15:]
    like = load_library()["concrete"]
    assert own.thermal.layers[1] == like.thermal.layers[1] and own.thermal.skin.thickness == like.thermal.skin.thickness


def measured(folder):
    """A spectrum of 3 to 15 um with a step at 9 um."""
    file = folder / "measured.csv"
    rows = (f"{um / 20},{0.1 if um < 180 else 0.3}" for um in range(60, 301))
    file.write_text("\n".join(["wavelength_um,reflectance", *rows]) + "\n")
    return file


def test_a_measured_spectrum_is_that_of_the_command(tmp_path):
    measured(tmp_path)
    text = "skyshine: 1\n" + "".join(f"{key}: {json.dumps(value)}\n" for key, value in JOB.items() if key != "skyshine")
    job_file = tmp_path / "job.yaml"
    job_file.write_text(text + "materials: {mine: {like: concrete, absorptance: 0.7, spectrum: measured.csv}}\n")
    own = job_materials(load_job(job_file).trimmed.own_materials)["mine"]
    spectrum = read_spectrum(tmp_path / "measured.csv", Said())
    new_material("mine", like="concrete", folder=tmp_path / "own", absorptance=0.7, spectrum=spectrum)
    written = load_library(tmp_path / "own")["mine"]
    np.testing.assert_allclose(own.reflectance, written.reflectance, atol=1e-5)
    assert np.interp([5.0, 12.0], own.wavelength, own.reflectance) == pytest.approx([0.1, 0.3], abs=1e-3)
    assert [(r.kind, round(r.lower), round(r.upper)) for r in own.ranges][1][:2] == ("measured", 3)
    assert [r.kind for r in own.ranges] == ["proxy", "measured"]  # the nodes of concrete end there
    scaled = text + "materials: {mine: {like: concrete, spectrum: measured.csv, emissivity: 0.8}}\n"
    (tmp_path / "scaled.yaml").write_text(scaled)
    mean = job_materials(load_job(tmp_path / "scaled.yaml").trimmed.own_materials)["mine"]
    assert material_summary(mean)["thermal_emissivity"] == pytest.approx(0.8, abs=0.004)
    assert np.interp(12.0, mean.wavelength, mean.reflectance) > np.interp(5.0, mean.wavelength, mean.reflectance) + 0.05
    before = materials_digest(job_library(load_job(job_file).trimmed), ("mine",))
    (tmp_path / "measured.csv").write_text((tmp_path / "measured.csv").read_text().replace(",0.3", ",0.4"))
    assert materials_digest(job_library(load_job(job_file).trimmed), ("mine",)) != before  # files are built again


@pytest.mark.parametrize(
    ("content", "complaint"),
    [("wavelength_um,reflectance\n3,0.1\n", "materials.mine: measured.csv: found"), (None, "which is no file")],
)
def test_a_spectrum_that_is_none_is_refused_at_its_line(tmp_path, content, complaint):
    if content:
        (tmp_path / "measured.csv").write_text(content)
    job_file = tmp_path / "job.yaml"
    text = "skyshine: 1\n" + "".join(f"{key}: {json.dumps(value)}\n" for key, value in JOB.items() if key != "skyshine")
    job_file.write_text(text + "materials: {mine: {like: concrete, spectrum: measured.csv}}\n")
    with pytest.raises(InputError, match=re.escape(complaint)) as error:
        load_job(job_file)
    assert str(error.value).startswith(f"{job_file}:7:")


def test_codes_follow_each_other_and_the_library_stays():
    job = loaded(
        second={"like": "grass_dry"}, first={"like": "sand_dry" if "sand_dry" in load_library() else "concrete"}
    )
    library = job_materials(job.own_materials)
    assert [library.code(name) for name in ("second", "first")] == [1001, 1002]
    assert library.by_code(1002).name == "first"
    assert "second" not in load_library() and library.version == f"{load_library().version}+job"
    assert job_library(job)["second"].opened is not None  # stands have gaps as those of the library


def test_a_job_builds_them_as_check_says(builds_here, tmp_path):
    job = {**JOB, "materials": {"mine": OWN, "like_concrete": {"like": "concrete"}, "concrete": None}}
    planned = skyshine.mat.check(job)
    assert sorted(planned.materials) == ["concrete", "like_concrete", "mine"]
    built = skyshine.mat.build(job, out=tmp_path)
    assert list(built.files) == planned.files
    table = built.open("s01.htt")
    place = {"altitude": 0.0, "azimuth": 180.0, "slope": 0.0, "time": np.array([5.0, 14.0])}
    own, same, like = (table.temperature(material=name, **place) for name in ("mine", "like_concrete", "concrete"))
    np.testing.assert_allclose(same, like, atol=1e-6)
    assert own[1] > like[1] + 3  # it absorbs 0.8 of sunlight and emits 0.6 of a black body's heat
    day = skyshine.mat.temperature("mine", job=job)
    np.testing.assert_allclose(own, np.interp(place["time"], day.time, day.temperature), atol=1.0)


def test_soil_moisture_reaches_them():
    soil = next(material.name for material in load_library() if material.soil is not None)
    job = load_job({**JOB, "materials": {"mine": {"like": soil, "absorptance": 0.5}}, "soil_moisture": "wet"}).trimmed
    wet = job_library(job)["mine"]
    assert wet.moisture and wet.dry is not None and wet.dry.name == "mine" and wet.dry.moisture is None
    dry = job_materials(job.own_materials)["mine"]
    assert solar_absorptance(dry, *ground_sunlight()) == pytest.approx(0.5, abs=1e-3)
    assert solar_absorptance(wet, *ground_sunlight()) > 0.52
