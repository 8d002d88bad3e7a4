"""A table of temperatures whose axes the job leaves to the default: what it holds, and how many nodes that takes."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.table import temperature_table

JOB = """\
skyshine: 1
name: default temperatures
site: {{{site}}}
states: [{{profile: {profile}, weather: {{{weather}}}}}]
bands: [{{wavelength_um: [10.5, 10.6]}}]
sources: [sun]
materials: {materials}
needs: {{shade: false}}
output: {{pictures: false}}
"""
SCENES = {
    "Atacama in November": (
        "latitude_deg: -23.5, longitude_deg: -68.2, date: 2026-11-09, utc_offset_h: -3, altitude_km: 2.4",
        "midlatitude_summer",
        "air_temperature_c: [7, 25], relative_humidity_percent: 15, wind_speed_m_s: 3",
        ["asphalt_road", "galvanised_weathered", "grass_dry"],
    ),
    "Tromso in May": (
        "latitude_deg: 69.6, longitude_deg: 18.9, date: 2026-05-05, utc_offset_h: 2, altitude_km: 0.02",
        "subarctic_summer",
        "air_temperature_c: [1, 9], relative_humidity_percent: 60, wind_speed_m_s: 4, cloud_fraction: 0.2",
        ["snow_medium"],
    ),
}


@pytest.mark.parametrize("scene", ["Tromso in May", pytest.param("Atacama in November", marks=pytest.mark.validation)])
def test_a_job_that_says_nothing_keeps_half_a_kelvin(build_surface, tmp_path, scene):
    site, profile, weather, materials = SCENES[scene]
    text = JOB.format(site=site, profile=profile, weather=weather, materials=materials)
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    table = skyshine.mat.open(build_surface(loaded, tmp_path))
    stated = table.error("temperature")
    assert 0 < stated["p99_kelvin"] <= 0.5 and stated["maximum_kelvin"] < 3
    job, library = loaded.trimmed, job_library(loaded.trimmed)
    draw = np.random.default_rng(20)
    height, azimuth, slope, time = (
        np.sort(draw.uniform(low, high, count))
        for low, high, count in (
            (job.site.altitude_km, job.site.altitude_km + 3, 2),
            (0, 360, 4),
            (0, 180, 4),
            (0, 24, 60),
        )
    )
    codes = [library[name].code for name in table.root.variables["material_name"].data]
    exact = temperature_table(
        surface_materials([library[name] for name in table.root.variables["material_name"].data], {}),
        *scene_inputs(job, 1),
        list(1e3 * height),
        list(azimuth),
        list(slope),
        list(time),
    ).temperature
    mesh = np.meshgrid(np.array(codes), height, azimuth, slope, time, indexing="ij")
    read = table.temperature(**dict(zip(("material", "altitude", "azimuth", "slope", "time"), mesh, strict=True)))
    error = np.abs(read - exact)
    assert np.percentile(error, 99) < 0.6 and error.max() < 3
