"""Weather that can hardly be of its place and clock, with numbers, and silence where it can."""

import re
from datetime import date

import numpy as np
import pytest

from skyshine.mat.job.plausibility import doubts, standard_pressure_hpa, zone_doubt
from skyshine.mat.job.site import Site
from skyshine.mat.job.surface import Weather
from skyshine.mat.surface.weather_readings import WEATHER_COLUMNS
from skyshine.schemas.errors import InputError

SITE = Site(latitude_deg=45, longitude_deg=15, date=date(2026, 6, 21), utc_offset_h=1, altitude_km=0.5)
HOURS = np.arange(24)
SUN = np.maximum(np.sin(np.pi * (HOURS - 4.5) / 15), 0) * ((HOURS > 4) & (HOURS < 20))  # up from 4:20 to 19:40


def weather(**changes):
    hourly = {
        "time": [f"{hour:02d}:00" for hour in HOURS],
        "air_temperature_c": list(20 + 6 * np.sin(np.pi * (HOURS - 9) / 12)),  # warmest at 15 h
        "relative_humidity_percent": [60] * 24,
        "wind_speed_m_s": [3] * 24,
        "pressure_hpa": [955] * 24,
        "global_horizontal_w_m2": list(900 * SUN),
    }
    return Weather.model_validate({"hourly": hourly | changes})


def test_a_day_that_can_be_is_not_doubted():
    assert doubts(SITE, weather()) == []
    assert doubts(SITE, Weather.model_validate({"air_temperature_c": [10, 20]})) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"global_horizontal_w_m2": list(900 * np.roll(SUN, 9))},
            r"has \d+ W m\^-2 of sunlight in the time to \d\d:00 on 2026-06-21, when the Sun is \d+ degrees or more",
        ),
        (
            {"global_horizontal_w_m2": list(900 * SUN * (HOURS < 10))},
            r"has the middle of its light on 2026-06-21 \d\.\d h before that of the Sun",
        ),
        (
            {"air_temperature_c": list(20 + 6 * np.sin(np.pi * (HOURS - 18) / 12))},
            "has its warmest air, 26.0 C, at 00:00 on 2026-06-21, when the Sun is 22 degrees below the horizon",
        ),
        ({"pressure_hpa": [1015] * 24}, None),
        (
            {"pressure_hpa": [700] * 24},
            "has a pressure of 700 hPa at 500 m, where 955 hPa is usual: its unit may be an",
        ),
        (
            {"relative_humidity_percent": [0.6] * 24},
            "a relative humidity of at most 0.6 percent: it may be a share of 1",
        ),
        ({"wind_speed_m_s": [45] * 24}, "has wind of 45 m/s: its unit may be another"),
        ({"air_temperature_c": [62] * 24}, "has air of 62.0 to 62.0 C; on record are -89.2 to 56.7 C: its unit may be"),
    ],
)
def test_what_can_hardly_be_is_said_once(changes, words):
    lines = doubts(SITE, weather(**changes))
    if words is None:
        assert lines == []
        return
    (line,) = lines
    assert re.search(words, line), line


def test_pressure_reduced_to_sea_level_at_a_high_station():
    (line,) = doubts(SITE.model_copy(update={"altitude_km": 1.6}), weather(pressure_hpa=[1013] * 24))
    assert line == "has a pressure of 1013 hPa at 1600 m, where 835 hPa is usual: it may be reduced to sea level"


@pytest.mark.parametrize(("altitude", "pressure"), [(0, 1013.25), (1000, 898.75), (5000, 540.2), (8000, 356.0)])
def test_the_standard_atmosphere(altitude, pressure):
    """ISO 2533, table of geopotential altitudes."""
    assert standard_pressure_hpa(altitude) == pytest.approx(pressure, rel=1e-4)


@pytest.mark.parametrize(
    ("offset", "longitude", "apart"),
    [
        (1, 15, None),
        (8, 76, None),
        (14, -157, None),
        (-12, 178, None),
        (-7, 105, 14.0 - 24),
        (-8, 9, 8.6),
        (0, 60, 4.0),
    ],
)
def test_clocks_far_from_the_sun(offset, longitude, apart):
    """Kashgar, Kiritimati and the date line keep clocks that are near enough; a wrong sign is not."""
    line = zone_doubt(offset, longitude, "site:")
    assert bool(line) == (apart is not None)
    if apart is not None:
        assert f"{abs(apart):.1f} h from the Sun's time at longitude {longitude:g}" in line


def test_hectopascal_in_a_column_of_pascal_are_refused():
    with pytest.raises(ValueError, match="found '1013'; allowed: numbers from 20000 to 120000 Pa"):
        WEATHER_COLUMNS["pressure"].to_si("1013", "Pa")


def test_a_file_of_another_zone_is_said_and_its_light_not_taken(load_weather, epw, tmp_path):
    """Two June days under a header that puts them nine hours off: light is computed, and measured light refused."""
    from skyshine.mat.job.load import load_job
    from skyshine.mat.scene.check import check_scene

    light = 900 * SUN
    change = [(24 * day + n, column, f"{light[n]:.0f}") for day in (0, 1) for n in range(24) for column in (14, 15)]
    change += [(24 * day + n, 12, "330") for day in (0, 1) for n in range(24)]
    epw(tmp_path, change)
    text = (tmp_path / "test.epw").read_text()
    (tmp_path / "test.epw").write_text(text.replace("-105.18,-7.0", "-105.18,2.0"))
    assert not load_weather("{file: test.epw}").states[0].weather.measured
    lines = load_job(tmp_path / "job.yaml").warnings
    assert any("in its header the clock is UTC+2 h, 9.0 h from the Sun's time" in line for line in lines)
    assert any("has light at night, so that light is computed" in line for line in lines)
    load_weather("{file: test.epw, radiation: measured}")
    with pytest.raises(InputError, match="when the Sun is down"):
        check_scene(load_job(tmp_path / "job.yaml"))
