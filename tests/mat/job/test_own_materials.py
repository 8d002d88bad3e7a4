"""Materials that a job defines: those that `mat materials new` would write, built without an environment variable."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.api.own_material import new_material
from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.mat.job.load import load_job
from skyshine.mat.job.own_materials import job_materials, of_first_layer
from skyshine.mat.radiometry.reflectance import solar_absorptance
from skyshine.mat.scene.moisture import job_library
from skyshine.materials.library import load_library

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
