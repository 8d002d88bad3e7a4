"""Surfaces of sea water in a state that gives the sea's temperature."""

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.products.temperature import state_solver
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.surface import given_temperatures

AT_NOON = {"altitude_km": [0.0], "azimuth_deg": [0.0], "slope_deg": [0.0], "time_h": [12.0]}


def job(sea=10.0, **keys):
    state = {
        "profile": "midlatitude_summer",
        "ground_material": "water_sea",
        "weather": {"air_temperature_c": [17, 20], "relative_humidity_percent": 70, "wind_speed_m_s": 6},
    }
    content = {
        "skyshine": 1,
        "name": "sea",
        "site": {"latitude_deg": 45, "longitude_deg": -20, "altitude_km": 0, "utc_offset_h": -1, "date": "2026-04-20"},
        "states": [state if sea is None else {**state, "sea_temperature_c": sea}],
        "bands": [{"wavelength_um": [8, 12]}],
        "materials": ["water_sea", "water_coastal", "water_fresh"],
        "output": {"folder": "built"},
    }
    return load_job(content | keys).trimmed


def noon(job):
    """Temperatures [Celsius] by material."""
    library = job_library(job)
    solver = state_solver(job.on_date_of_state(1), [library[name] for name in job.materials], 1)
    kelvin = np.squeeze(solver.table({name: np.array(nodes) for name, nodes in AT_NOON.items()}, 48).temperature)
    return dict(zip(job.materials, kelvin - 273.15, strict=True))


def test_sea_water_has_the_seas_temperature_and_a_lake_its_own():
    with_sea, without = noon(job()), noon(job(None))
    assert with_sea["water_sea"] == pytest.approx(10, abs=1e-3)
    assert with_sea["water_coastal"] == pytest.approx(10, abs=1e-3)
    assert with_sea["water_fresh"] > 17
    assert without["water_sea"] > 17


def test_a_job_that_names_the_material_decides():
    state = job().states[0]
    given = job(temperatures_c={"water_sea": 13.0}, operated={"water_coastal": {"kind": "fixed", "temperature_c": 5.0}})
    assert given_temperatures(given, state) == {"water_sea": pytest.approx(286.15)}
    assert set(given_temperatures(job(), state)) == {"water_sea", "water_coastal"}
