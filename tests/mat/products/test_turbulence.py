"""Cn2 of a state's record: over its ground by hour, and over a sea."""

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.products.temperature import _turbulence, state_solver
from skyshine.mat.surface.sea_surface import sea_surface, specific_humidity
from skyshine.mat.surface.similarity import index_structure
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.library import load_library

AXES = {"altitude_km": np.zeros(1), "azimuth_deg": np.zeros(1), "slope_deg": np.zeros(1), "time_h": np.arange(24.0)}


@pytest.fixture(scope="module")
def library():
    return load_library()


def fields(library, **keys):
    weather = {"air_temperature_c": [18, 36], "relative_humidity_percent": 30, "wind_speed_m_s": 3}
    job = load_job(
        {
            "skyshine": 1,
            "name": "turbulence",
            "site": {"latitude_deg": 34.1, "longitude_deg": -111, "date": "2026-06-21", "utc_offset_h": -7},
            "states": [{"profile": "midlatitude_summer", "weather": weather, **keys}],
            "bands": [{"wavelength_um": [8, 12]}],
            "materials": ["sand_desert"],
        }
    ).trimmed
    return _turbulence(state_solver(job, [library["sand_desert"]], 1), job.states[0], AXES, 96)


def test_ground_is_turbulent_at_noon_and_calm_at_the_crossings(library):
    axes, variables = fields(library, ground_material="sand_desert")
    cn2 = variables["cn2"].data
    assert cn2.shape == (1, 14, 24) and list(axes) == ["cn2_height", "cn2_hour"]
    at_two = cn2[0, 4]
    assert 1e-13 < at_two[12] < 3e-12 and np.argmax(at_two) in range(8, 17)
    assert min(at_two[4:9].min(), at_two[16:21].min()) < 0.1 * at_two[12]  # the flux of heat changes its sign
    assert np.all(np.diff(cn2, axis=1) <= 0)


def test_a_sea_has_the_turbulence_of_its_own_scales(library):
    weather = {"air_temperature_c": [15, 15], "relative_humidity_percent": 80, "wind_speed_m_s": 6}
    _, variables = fields(library, sea_temperature_c=18, weather=weather)
    vapour = 0.8 * float(saturation_pressure(288.15))
    sea = sea_surface(
        291.15, 288.15, specific_humidity(vapour, 101300.0), 6.0, 101300.0, wind_height=10.0, air_height=2.0
    )
    scales = sea.friction_velocity, sea.temperature_scale, sea.humidity_scale
    expected = index_structure(0.5, *scales, 288.15, 101300.0)
    assert variables["cn2"].data[0, 0] == pytest.approx(np.full(24, expected), rel=0.01, abs=0)
