"""Measured light in place of the computed: means that are kept, nights, other altitudes, files and jobs that lack
it.
"""

from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.scene.surface import scene_inputs
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.measured import MeasuredRadiation
from skyshine.mat.surface.sun_path import SUN_STEPS
from skyshine.schemas.errors import InputError

HOURS = np.arange(1.0, 25.0)
EACH = SUN_STEPS // 24


def hourly_means(values):
    """Means over the hours that end at 1 to 24; the time at which one ends is in it."""
    return np.roll(values, -1).reshape(24, EACH).mean(axis=1)


@pytest.fixture
def clear(sun_path, sky):
    direct, diffuse = sky.irradiance(sun_path, 0.0, np.array([0.0]))
    return direct[0], diffuse[0]


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0, 1.3])
def test_every_interval_keeps_its_mean(sun_path, clear, share):
    means = [share * hourly_means(part) for part in clear]
    sunlight = MeasuredRadiation(HOURS, *means).sunlight(sun_path, *clear)
    for light, mean, part in zip(sunlight, means, clear, strict=True):
        assert hourly_means(light) == pytest.approx(mean, rel=1e-12)
        assert light == pytest.approx(share * part, rel=1e-9)  # the clear sky's share of each hour is one number


def test_diffuse_light_of_a_dull_dawn_is_spread_while_the_sun_is_up(sun_path, clear):
    """Far more than the clear sky has in the hour of sunrise: kept as it is, without a peak."""
    rise = int(np.argmax(hourly_means(clear[1]) > 0))
    means = np.zeros(24)
    means[rise] = 40 * hourly_means(clear[1])[rise]
    light = MeasuredRadiation(HOURS, np.zeros(24), means).sunlight(sun_path, *clear)[1]
    assert hourly_means(light)[rise] == pytest.approx(means[rise]) and np.unique(light).size == 2


def test_direct_light_at_night_is_refused_and_a_little_is_stray(sun_path, clear):
    direct = np.zeros(24)
    direct[1] = 5.0
    assert np.all(MeasuredRadiation(HOURS, direct, np.zeros(24)).sunlight(sun_path, *clear)[0] == 0)
    direct[1] = 300.0
    with pytest.raises(
        InputError, match=r"found 300 W m\^-2 of direct light in the time to 2 h, when the Sun is down; check date"
    ):
        MeasuredRadiation(HOURS, direct, np.zeros(24)).sunlight(sun_path, *clear)


def test_diffuse_light_at_night_is_refused(sun_path, clear):
    diffuse = np.zeros(24)
    diffuse[1] = 80.0
    with pytest.raises(InputError, match="of diffuse light in the time to 2 h, when the Sun is down"):
        MeasuredRadiation(HOURS, np.zeros(24), diffuse).sunlight(sun_path, *clear)


def test_polar_night_is_dark(make_sun_path, sky):
    sun_path = make_sun_path(85.0, -23.0)
    dark = [part[0] for part in sky.irradiance(sun_path, 0.0, np.array([0.0]))]
    sunlight = MeasuredRadiation(HOURS, np.zeros(24), np.full(24, 2.0)).sunlight(sun_path, *dark)
    assert all(np.all(part == 0) for part in sunlight)


def test_longwave_goes_through_the_middles_of_the_intervals():
    falling = 400.0 - HOURS
    sunlight = MeasuredRadiation(HOURS, np.zeros(24), np.zeros(24), falling).sky_longwave()
    assert sunlight[EACH // 2 :: EACH] == pytest.approx(falling)
    assert sunlight.min() >= falling.min() and sunlight.max() <= falling.max()


def test_measured_clear_light_gives_the_forcing_of_the_clear_sky(sun_path, weather, sky, clear):
    """At the altitude of the weather and above it, sky longwave included."""
    heights, planes = np.array([0.0, 2000.0]), np.array([0.0, 90.0])
    longwave = hourly_means(
        Scene(sun_path, weather, sky, heights[:1], planes, planes).forcing(SUN_STEPS).longwave_sky[0]
    )
    measured = replace(weather, radiation=MeasuredRadiation(HOURS, *(hourly_means(part) for part in clear), longwave))
    computed, other = (
        Scene(sun_path, w, sky, heights, planes, 180 + 0 * planes).forcing(96) for w in (weather, measured)
    )
    for name in ("shortwave_direct", "shortwave_diffuse", "shortwave_reflected"):
        assert getattr(other, name) == pytest.approx(getattr(computed, name), abs=2.0), name
    assert other.longwave_sky == pytest.approx(computed.longwave_sky, rel=0.01)


def test_measured_light_is_no_longer_dimmed_by_cloud(sun_path, make_weather, sky, clear):
    dull = replace(make_weather(1.0), radiation=MeasuredRadiation(HOURS, *(hourly_means(part) for part in clear)))
    forcing = Scene(sun_path, dull, sky, np.array([0.0]), np.array([0.0]), np.array([0.0])).forcing(96)
    assert forcing.shortwave_direct[0, 48] > 500
    assert np.all(forcing.longwave_sky > 300)  # not measured: the state's, with the cloud


def test_tmy3_of_greensboro():
    """pvlib's own sample: the day's sum of direct light is the sum of the file's hours, each to its end."""
    file = Path(pvlib.__file__).parent / "data" / "723170TYA.CSV"
    if not file.is_file():
        pytest.skip("this pvlib comes without its sample file")
    rows = [row.split(",") for row in file.read_text().splitlines()[2 + 24 * 171 : 2 + 24 * 172]]
    plain, measured = (read_weather(file, date(2026, 6, 21), -5, radiation=given) for given in (False, True))
    assert plain.direct_normal_w_m2 is None and measured.longwave_down_w_m2 is None
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
    _, computed, _ = scene_inputs(load_weather("{file: day.csv}"), 1)
    assert computed.radiation is None


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
            "found longwave_down_w_m2 by hour and radiation: computed",
        ),
        (
            f"{{hourly: {{{TABLE}, direct_normal_w_m2: {[0] * 7}, diffuse_w_m2: {[0] * 8}}}, radiation: measured}}",
            "found 7 values of direct_normal",
        ),
    ],
)
def test_what_does_not_fit_is_placed_in_the_job(tmp_path, load_weather, weather, message):
    with pytest.raises(InputError, match=rf"job.yaml:6:\d+: .*{message}"):
        load_weather(weather)


def test_a_file_without_light_is_named(tmp_path, load_weather):
    (tmp_path / "day.csv").write_text(
        "time,air_temperature[C]\n" + "".join(f"{hour:02d}:00,20\n" for hour in range(0, 24, 3))
    )
    with pytest.raises(InputError, match="day.csv.*direct_normal"):
        load_weather("{file: day.csv, radiation: measured}")
