"""Fixtures of the tests of jobs."""

import pytest

from skyshine.mat.job.load import load_job

WEATHER_JOB = """\
skyshine: 1
name: weather
site: {{latitude_deg: 39.7, longitude_deg: -105.2, date: 2026-06-22, utc_offset_h: -7, altitude_km: 1.8}}
states:
  - profile: midlatitude_summer
    weather: {weather}
bands: [{{wavelength_um: [8, 12]}}]
materials: [concrete]
"""


@pytest.fixture
def load_weather(tmp_path):
    """Loads a job in `tmp_path` with the weather given as YAML."""

    def load(weather):
        (tmp_path / "job.yaml").write_text(WEATHER_JOB.format(weather=weather), encoding="utf-8")
        return load_job(tmp_path / "job.yaml").trimmed

    return load
