"""Fixtures of the tests of jobs."""

import numpy as np
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


EPW_STATION = "LOCATION,Test,CO,USA,TMY3,724666,39.74,-105.18,-7.0,1829.0"
GROUND = "GROUND TEMPERATURES,2,2,,,,8,6,5,5,7,9,11,13,14,14,13,11,.5,1.2,1600,1250," + ",".join(
    f"{10 - 7 * np.cos(2 * np.pi * (month + 0.5 - 1.5) / 12):.3f}" for month in range(12)
)


def _epw(folder, change=()):
    """Two June days: the temperature is the hour, the wind half of it; `change` puts cells (reading, column, text)."""
    rows = []
    for day in (21, 22):
        for hour in range(1, 25):
            cells = ["1999", "6", str(day), str(hour), "0", "?", str(float(hour)), "1.0", "40", "82000"]
            cells += ["0"] * 11 + [str(0.5 * hour), "5", "4", *["0"] * 11]
            rows.append(cells)
    for reading, column, text in change:
        rows[reading][column] = text
    file = folder / "test.epw"
    file.write_text("\n".join([EPW_STATION, *["HEADER"] * 7, *(",".join(row) for row in rows)]) + "\n")
    return file


def _epw_year(folder, ground=GROUND, months=12, name="year.epw"):
    """Readings of the first 28 days of each month; the air is coldest at the end of January."""
    rows = []
    for month in range(months):
        for day in range(1, 29):
            celsius = 12 - 9 * np.cos(2 * np.pi * ((month + day / 30.4) / 12 - 1 / 12))
            for hour in range(1, 25):
                cells = ["1999", str(month + 1), str(day), str(hour), "0", "?", f"{celsius:.2f}", "1.0", "40", "82000"]
                rows.append([*cells, *["0"] * 11, "2", "5", "4", *["0"] * 11])
    file = folder / name
    file.write_text("\n".join([EPW_STATION, "A", "B", ground, *["C"] * 4, *(",".join(row) for row in rows)]) + "\n")
    return file


def _csv(folder, rows, header="time,air_temperature[C],wind_speed[km/h],cloud_fraction[%]"):
    file = folder / "day.csv"
    file.write_text("\n".join([header, *rows]) + "\n")
    return file


@pytest.fixture(scope="session")
def epw_station():
    """First line of an EPW file."""
    return EPW_STATION


@pytest.fixture(scope="session")
def ground_header():
    """Line of ground temperatures of an EPW file, at three depths."""
    return GROUND


@pytest.fixture(scope="session")
def epw():
    """Writes an EPW file of two days into a folder; see `_epw`."""
    return _epw


@pytest.fixture(scope="session")
def epw_year():
    """Writes an EPW file of a year into a folder; see `_epw_year`."""
    return _epw_year


@pytest.fixture(scope="session")
def csv():
    """Writes a table of a day into a folder."""
    return _csv
