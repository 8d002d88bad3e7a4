"""Weather of a job from EPW, TMY3 and CSV files: hours, units, measured light, and the place of what is wrong."""

from datetime import date
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.scene.surface import scene_inputs
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.sun_path import SUN_STEPS, sun_hours
from skyshine.schemas.errors import InputError

HOURS = np.arange(1.0, 25.0)
EACH = SUN_STEPS // 24


def hourly_means(values):
    """Means over the hours that end at 1 to 24; the time at which one ends is in it."""
    return np.roll(values, -1).reshape(24, EACH).mean(axis=1)


EPW_STATION = "LOCATION,Test,CO,USA,TMY3,724666,39.74,-105.18,-7.0,1829.0"


def epw(folder, change=()):
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


def test_epw_hours_end_where_the_file_says(tmp_path):
    """Hour 14 of local standard time (UTC-7) is 15:00 on a clock that is an hour ahead (UTC-6)."""
    weather = read_weather(epw(tmp_path), date(2026, 6, 22), -6)
    at = weather.time.index(15.0)
    assert (weather.air_temperature_c[at], weather.wind_speed_m_s[at]) == (14.0, 7.0)
    assert (weather.cloud_fraction[at], weather.pressure_hpa[at], weather.altitude_km) == (0.5, 820.0, 1.829)
    assert sorted(weather.time) == weather.time and len(weather.time) == 24


@pytest.mark.parametrize(
    "day, change, message",
    [
        (date(2026, 6, 20), (), "test.epw: found 0 hours of 20 June; allowed: the 24 of a day"),
        (
            date(2026, 6, 22),
            [(24 + 5, 6, "99.9")],
            "test.epw:38: temp_air: found 99.9; allowed: numbers worth -90 to 70",
        ),
        (date(2026, 6, 21), [(2, 22, "99")], "test.epw:11: total_sky_cover: found 99"),
        (date(2026, 6, 21), [(0, 1, "June")], "is not a file that pvlib reads as EPW"),
    ],
)
def test_wrong_epw_files_are_placed(tmp_path, day, change, message):
    with pytest.raises(InputError, match=message):
        read_weather(epw(tmp_path, change), day, -7)


def test_tmy3_of_greensboro():
    """pvlib's own sample file; its reading of 21 June 14:00 stands in line 4120."""
    file = Path(pvlib.__file__).parent / "data" / "723170TYA.CSV"
    if not file.is_file():
        pytest.skip("this pvlib comes without its sample file")
    cells = file.read_text().splitlines()[2 + 24 * 171 + 13].split(",")
    assert cells[:2] == ["06/21/1988", "14:00"] or (cells[0].startswith("06/21") and cells[1] == "14:00")
    weather = read_weather(file, date(2026, 6, 21), -5)
    at = weather.time.index(14.0)
    assert weather.air_temperature_c[at] == float(cells[31]) and weather.altitude_km == 0.273


def csv(folder, rows, header="time,air_temperature[C],wind_speed[km/h],cloud_fraction[%]"):
    file = folder / "day.csv"
    file.write_text("\n".join([header, *rows]) + "\n")
    return file


def test_csv_by_time_of_day(tmp_path):
    weather = read_weather(
        csv(tmp_path, [f"{hour:02d}:00,{hour},36,50" for hour in range(0, 24, 3)]), date(2026, 6, 21), 0
    )
    assert weather.air_temperature_c == pytest.approx(np.arange(0, 24, 3)) and weather.relative_humidity_percent is None
    assert weather.wind_speed_m_s == pytest.approx([10.0] * 8) and weather.cloud_fraction == pytest.approx([0.5] * 8)


@pytest.mark.parametrize(
    "rows, message",
    [
        ([f"{hour:02d}:00,20,5,0" for hour in (0, 3, 6, 12, 15, 18, 21, 23)], r"day.csv:5:1: found a gap of 6.0 h"),
        ([f"{hour:02d}:00,20,5,0" for hour in range(4, 24, 2)], r"day.csv:2:1: found a gap of 6.0 h"),
        ([f"{hour:02d}:00,20,5,{40 * hour}" for hour in range(9)], r"day.csv:5:12: cloud_fraction: found '120'"),
        (["2026-06-21T00:00,20,5,0"] * 8, r"day.csv:2:1: time: found '2026-06-21T00:00'; allowed: a time of day"),
    ],
)
def test_wrong_csv_files_are_placed(tmp_path, rows, message):
    with pytest.raises(InputError, match=message):
        read_weather(csv(tmp_path, rows), date(2026, 6, 21), 0)


def test_a_job_takes_a_file_and_its_own_keys_before_it(tmp_path, load_weather):
    epw(tmp_path)
    job = load_weather("{file: test.epw, cloud_fraction: 0}")
    _, weather, _ = scene_inputs(job, 1)
    noon = 12 * len(sun_hours()) // 24
    assert weather.air_temperature[noon] == pytest.approx(273.15 + 12) and weather.altitude == 1829.0
    assert np.all(weather.cloud_fraction == 0) and weather.pressure[noon] == pytest.approx(82e3)
    assert job.states[0].weather.mean_air_temperature_c == pytest.approx(12.5, abs=0.3)


def test_a_job_takes_one_temperature_for_the_day(tmp_path, load_weather):
    _, weather, _ = scene_inputs(load_weather("{air_temperature_c: 20}"), 1)
    assert np.all(weather.air_temperature == 293.15) and weather.altitude == 1800.0


def test_a_missing_file_is_placed_in_the_job(tmp_path, load_weather):
    with pytest.raises(InputError, match=r"job.yaml:6:21: states.0.weather.file: found 'none.epw', which is no file"):
        load_weather("{file: none.epw}")


def test_a_tmy3_file_with_times_that_are_numbers_is_refused_in_one_line(tmp_path):
    file = tmp_path / "year.csv"
    file.write_text(
        "723170,TEST,NC,-5.0,36.1,-79.95,273\nDate (MM/DD/YYYY),Time (HH:MM),ETR (W/m^2)\n06/21/1988,1400,0\n"
    )
    with pytest.raises(InputError, match="year.csv: is not a file that pvlib reads as TMY3: .*; check it"):
        read_weather(file, date(2026, 6, 21), -5)


def test_measured_light_of_greensboro():
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
def test_radiation_that_does_not_fit_is_placed_in_the_job(tmp_path, load_weather, weather, message):
    with pytest.raises(InputError, match=rf"job.yaml:6:\d+: .*{message}"):
        load_weather(weather)


def test_a_file_without_light_is_named(tmp_path, load_weather):
    (tmp_path / "day.csv").write_text(
        "time,air_temperature[C]\n" + "".join(f"{hour:02d}:00,20\n" for hour in range(0, 24, 3))
    )
    with pytest.raises(InputError, match="day.csv.*direct_normal"):
        load_weather("{file: day.csv, radiation: measured}")


def test_a_file_of_another_place_is_warned_of_with_its_distance(tmp_path, load_weather):
    """The station lies at 39.74 N, 105.18 W, 1829 m; a degree of latitude is 111 km."""
    epw(tmp_path)
    load_weather("{file: test.epw}")
    text = (tmp_path / "job.yaml").read_text(encoding="utf-8")
    assert load_job(tmp_path / "job.yaml").warnings == ()
    for old, new, message in (
        ("latitude_deg: 39.7", "latitude_deg: 41.74", "222 km from the site and 29 m above it"),
        ("longitude_deg: -105.2", "longitude_deg: 105.18", "km from the site"),
        ("altitude_km: 1.8", "altitude_km: 2.5", "5 km from the site and 671 m below it"),
    ):
        assert old in text
        (tmp_path / "job.yaml").write_text(text.replace(old, new), encoding="utf-8")
        (warning,) = load_job(tmp_path / "job.yaml").warnings
        assert warning.startswith("state 1: weather file test.epw was measured at latitude 39.74, longitude -105.18")
        assert message in warning


def test_a_table_by_time_of_day_has_no_place(tmp_path, load_weather):
    csv(tmp_path, [f"{hour:02d}:00,{hour},36,50" for hour in range(0, 24, 3)])
    load_weather("{file: day.csv}")
    assert load_job(tmp_path / "job.yaml").warnings == ()
