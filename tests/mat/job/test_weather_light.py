"""Measured light in weather files and tables."""

from datetime import date
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.scene.surface import scene_inputs
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.sun_path import SUN_STEPS
from skyshine.schemas.errors import InputError

HOURS = np.arange(1.0, 25.0)


EACH = SUN_STEPS // 24


def hourly_means(values):
    """Means over the hours that end at 1 to 24; the time at which one ends is in it."""
    return np.roll(values, -1).reshape(24, EACH).mean(axis=1)


def test_measured_light_of_greensboro():
    """pvlib's own sample: the day's sum of direct light is the sum of the file's hours, each to its end."""
    file = Path(pvlib.__file__).parent / "data" / "723170TYA.CSV"
    if not file.is_file():
        pytest.skip("this pvlib comes without its sample file")
    rows = [row.split(",") for row in file.read_text().splitlines()[2 + 24 * 171 : 2 + 24 * 172]]
    measured = read_weather(file, date(2026, 6, 21), -5, radiation=True).hourly
    assert measured.longwave_down_w_m2 is None
    at = measured.time.index(14.0)
    assert (measured.direct_normal_w_m2[at], measured.diffuse_w_m2[at]) == (float(rows[13][7]), float(rows[13][10]))
    assert sum(measured.direct_normal_w_m2) == sum(float(row[7]) for row in rows) > 1000


def test_a_job_takes_measured_light_from_a_table(tmp_path, load_weather):
    light = np.where((HOURS > 6) & (HOURS < 19), 600.0, 0.0)
    rows = [f"{hour % 24:02d}:00,20,{light[hour - 1]:g},{light[hour - 1] / 6:g},350" for hour in (24, *range(1, 24))]
    (tmp_path / "day.csv").write_text(
        "\n".join(["time,air_temperature[C],direct_normal,diffuse,lw_down", *rows]) + "\n"
    )
    sun_path, weather, sky = scene_inputs(load_weather("{file: day.csv, radiation: measured}"), 1)
    forcing = Scene(sun_path, weather, sky, np.array([1800.0]), np.array([0.0]), np.array([0.0])).forcing(SUN_STEPS)
    assert hourly_means(forcing.shortwave_diffuse[0])[11] == pytest.approx(100.0, rel=0.01)
    assert forcing.longwave_sky[0, SUN_STEPS // 2] == pytest.approx(350.0, rel=1e-9)
    _, computed, _ = scene_inputs(load_weather("{file: day.csv, radiation: computed}"), 1)
    assert computed.radiation is None
    _, default, _ = scene_inputs(load_weather("{file: day.csv}"), 1)
    np.testing.assert_array_equal(default.radiation.direct, weather.radiation.direct)


EIGHT = "[00:00, 03:00, 06:00, 09:00, 12:00, 15:00, 18:00, 21:00]"


TABLE = f"time: {EIGHT}, air_temperature_c: {[20] * 8}"


@pytest.mark.parametrize(
    "weather, message",
    [
        (
            "{air_temperature_c: 20, radiation: measured}",
            "found radiation: measured without direct_normal_w_m2 and diffuse_w_m2",
        ),
        (
            f"{{hourly: {{{TABLE}}}, radiation: measured}}",
            "found radiation: measured without direct_normal_w_m2 and diffuse_w_m2",
        ),
        (
            f"{{hourly: {{{TABLE}, direct_normal_w_m2: {[0] * 8}}}, radiation: measured}}",
            "found one of direct_normal_w_m2 and diffuse_w_m2",
        ),
        (
            f"{{hourly: {{{TABLE}, longwave_down_w_m2: {[300] * 8}}}}}",
            "found longwave_down_w_m2 by hour without sunlight",
        ),
        (
            f"{{hourly: {{{TABLE}, direct_normal_w_m2: {[0] * 7}, diffuse_w_m2: {[0] * 8}}}, radiation: measured}}",
            "found 7 values of direct_normal",
        ),
    ],
)
def test_radiation_that_does_not_fit_is_placed_in_the_job(tmp_path, load_weather, weather, message):
    with pytest.raises(InputError, match=rf"job.yaml:6:\d+: .*{message}"):
        load_weather(weather)


def test_a_file_without_light_is_named(tmp_path, load_weather):
    (tmp_path / "day.csv").write_text(
        "time,air_temperature[C]\n" + "".join(f"{hour:02d}:00,20\n" for hour in range(0, 24, 3))
    )
    with pytest.raises(InputError, match="day.csv.*direct_normal"):
        load_weather("{file: day.csv, radiation: measured}")
