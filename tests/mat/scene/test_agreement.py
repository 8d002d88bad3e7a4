"""Warnings with numbers where weather, profile and sounding disagree, and silence where they agree."""

import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.agreement import air_warnings

JOB = {
    "skyshine": 1,
    "name": "agreement",
    "site": {"latitude_deg": 45, "longitude_deg": 10, "date": "2026-07-15", "utc_offset_h": 1},
    "bands": [{"wavelength_um": [8, 12]}],
    "materials": ["concrete"],
}
AGREES = {"air_temperature_c": [16, 26], "relative_humidity_percent": 76}


@pytest.fixture
def warnings(tmp_path, monkeypatch):
    (tmp_path / "sounding.csv").write_text(
        "altitude[m],pressure[hPa],temperature[C],relative_humidity[%]\n0,1013,21,76\n1000,902,16.5,66\n2000,802,12,55\n"
    )
    monkeypatch.chdir(tmp_path)
    return lambda *states: air_warnings(load_job(JOB | {"states": list(states)}).trimmed)


@pytest.mark.parametrize(
    "more", [{}, {"air": "profile"}, {"sounding": "sounding.csv"}, {"air_times": ["04:00", "14:00"]}]
)
def test_air_that_agrees_is_not_warned_of(warnings, more):
    assert warnings({"weather": AGREES, **more}) == []


def test_weather_16_k_from_the_profile(warnings):
    """Midlatitude summer has 294.2 K and 18,750 ppmv of vapour at sea level (Anderson et al. 1986)."""
    cold = {"air_temperature_c": 5, "relative_humidity_percent": 76}
    (temperature,) = warnings({"weather": cold})
    assert temperature.startswith("state 1: weather of 278.1 K at the ground")
    assert "midlatitude_summer of 294.2 K there are 16.1 K apart" in temperature
    assert "paths follow the weather" in temperature
    temperature, vapour = warnings({"weather": AGREES}, {"weather": cold, "air": "profile"})
    assert temperature.startswith("state 2: ") and "paths do not follow the weather" in temperature
    assert "weather with 6.6 hPa" in vapour and "profile midlatitude_summer with 19.0 hPa" in vapour


def test_weather_that_a_sounding_does_not_have(warnings):
    hot = {"air_temperature_c": 30, "relative_humidity_percent": 45}
    (warning,) = warnings({"weather": hot, "sounding": "sounding.csv"})
    assert "the sounding sounding.csv of 294.1 K there are 9.0 K apart; paths do not follow the weather" in warning
    (warning,) = warnings({"weather": hot, "sounding": "sounding.csv", "air": "weather"})
    assert "9.0 K apart; paths follow the weather" in warning


def test_water_vapour_that_the_job_states_against_the_weather(warnings):
    (warning,) = warnings(*[{"weather": AGREES, "humidity_scale": 0.25}] * 3)
    assert warning.startswith("states 1 to 3: weather with 18.9 hPa")
    assert "humidity_scale or gases.H2O with 4.8 hPa" in warning


@pytest.mark.parametrize(("aloft", "said"), [(66, False), (0.05, True)])
def test_a_sounding_that_is_dry_aloft_only(tmp_path, warnings, aloft, said):
    """13.9 g m^-3 at the ground, and next to nothing above: half of the first 100 m has 0.7 mm, a height of 50 m."""
    rows = f"0,1013,21,76\n100,1001,20.5,{aloft}\n1000,902,16.5,{aloft}\n2000,802,12,{aloft}\n9000,310,-40,{aloft}\n"
    (tmp_path / "sounding.csv").write_text("altitude[m],pressure[hPa],temperature[C],relative_humidity[%]\n" + rows)
    texts = [text for text in warnings({"weather": AGREES, "sounding": "sounding.csv"}) if "mm of water above" in text]
    assert len(texts) == said
    if said:
        assert "the sounding sounding.csv has 0." in texts[0] and "a height of 0.1 km (usual: 0.7 to 7 km)" in texts[0]
