"""`snow_on` of a job: what lies below, what is seen, and what it is refused on."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.products.band import BandProduct
from skyshine.mat.scene.atmosphere import materials_digest
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.notes import surface_notes
from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.conduction import surface_admittance
from skyshine.materials.library import load_library

DAY = 86400.0


def job(**keys):
    weather = {"air_temperature_c": [-12, -4], "relative_humidity_percent": 70, "wind_speed_m_s": 2}
    return {
        "skyshine": 1,
        "name": "winter",
        "site": {"latitude_deg": 48, "longitude_deg": 11, "date": "2026-01-20", "utc_offset_h": 1},
        "states": [{"profile": "midlatitude_winter", "weather": weather}],
        "bands": [],
        "materials": ["roof_tile_cement", "car_paint_white", "pv_module", "snow_fine", "grass_green"],
        **keys,
    }


def test_a_layer_of_snow_lies_on_the_whole_stack():
    """At rest the snow's resistance is in series with the roof's; waves of minutes know the snow alone."""
    roof, snow = load_library()["roof_tile_cement"], load_library()["snow_fine"]
    covered = job_library(load_job(job(snow_on={"roof_tile_cement": {"depth_m": 0.2}})).trimmed)["roof_tile_cement"]
    steady = surface_admittance(covered.thermal, 0.0)[0].real
    skin, layer = roof.thermal.skin, snow.thermal.layers[0]
    resistance = 0.2 / layer.conductivity + skin.thickness / skin.conductivity
    assert 1 / steady == pytest.approx(1 / surface_admittance(roof.thermal, 0.0)[0].real + resistance, rel=1e-9)
    minutes = np.array([2j * np.pi / 600.0])
    assert surface_admittance(covered.thermal, minutes) == pytest.approx(surface_admittance(snow.thermal, minutes))
    assert covered.surface.exposure == "roof" and covered.surface.snow and covered.code == roof.code
    np.testing.assert_array_equal(covered.reflectance, snow.reflectance)


@pytest.mark.validation  # 3 s
def test_a_warm_roof_melts_its_snow_from_below_and_a_cold_one_does_not():
    def noon(operated, depth):
        keys = {"snow_on": {"roof_tile_cement": {"depth_m": depth}}, "operated": operated}
        return skyshine.mat.temperature("roof_tile_cement", job=job(**keys)).temperature

    heated = {"roof_tile_cement": {"kind": "convective", "temperature_c": 25, "coefficient_w_m2_k": 8}}
    thin, thick, unheated = noon(heated, 0.01), noon(heated, 0.3), noon({}, 0.01)
    assert thin.min() - thick.min() > 3 and thin.max() <= 273.16 and unheated.max() < thin.max() + 1e-6


def test_snow_on_a_module_takes_its_power_and_answers_to_its_age():
    keys = {"snow_on": {"pv_module": {"depth_m": 0.05, "snow": "snow_medium"}}}
    loaded = load_job(job(**keys))
    (covered,) = surface_materials([job_library(loaded.trimmed)["pv_module"]])
    assert covered.surface.delivered == 0.0 and covered.solar_absorptance < 0.3
    young = skyshine.mat.temperature("pv_module", job=job(**keys)).temperature.max()
    old = job(**keys)
    old["states"][0]["weather"]["snow_age_days"] = 20
    assert skyshine.mat.temperature("pv_module", job=old).temperature.max() > young + 0.3


def test_the_job_s_tables_and_notes_know_of_it():
    loaded = load_job(job(snow_on={"roof_tile_cement": {"depth_m": 0.2}}))
    assert "snow_on: roof_tile_cement under 0.2 m of snow_fine" in surface_notes(
        loaded.trimmed, ["roof_tile_cement", "pv_module"]
    )
    names = ("roof_tile_cement",)
    digests = {
        materials_digest(job_library(load_job(job(**keys)).trimmed), names)
        for keys in ({}, *({"snow_on": {"roof_tile_cement": {"depth_m": depth}}} for depth in (0.1, 0.2)))
    }
    assert len(digests) == 3 and BandProduct is not None
    clear = job_library(load_job(job()).trimmed)["roof_tile_cement"]
    np.testing.assert_array_equal(clear.reflectance, load_library()["roof_tile_cement"].reflectance)
