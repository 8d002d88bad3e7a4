"""Weather through the day: extremes, tables by hour, other altitudes, and files with the place of what is wrong."""

from datetime import date
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.scene.surface import scene_inputs
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather import air_temperature, from_extremes, from_hours
from skyshine.schemas.errors import InputError

HOURS = np.arange(24.0)


def test_air_temperature_reaches_its_extremes(sun_path):
    """Lowest at sunrise, highest two hours after noon, smooth and periodic."""
    series = air_temperature(sun_path, 280.0, 300.0)
    sunrise = sun_hours()[np.argmax(sun_path.solar_elevation > 0)]
    assert sun_hours()[series.argmin()] == pytest.approx(sunrise, abs=0.05)
    assert sun_hours()[series.argmax()] == pytest.approx(14.0, abs=0.05)
    assert (series.min(), series.max()) == (pytest.approx(280.0, abs=1e-3), pytest.approx(300.0, abs=1e-3))
    assert np.abs(np.diff(np.append(series, series[0]))).max() < 0.2


@pytest.mark.parametrize("declination", [-23.0, 23.0])
def test_air_temperature_without_sunrise(make_sun_path, declination):
    series = air_temperature(make_sun_path(80.0, declination), 240.0, 250.0)
    assert sun_hours()[series.argmin()] == pytest.approx(0.0, abs=0.05)
    assert series.max() == pytest.approx(250.0, abs=1e-3)


def test_hourly_values_are_linear_and_periodic():
    weather = from_hours(500.0, HOURS, 280 + HOURS, 60.0, 1 + 0.5 * HOURS, HOURS / 24, 95e3 + HOURS)
    at = np.searchsorted(sun_hours(), [6.0, 6.5, 23.5])
    assert weather.air_temperature[at] == pytest.approx([286.0, 286.5, 291.5])
    assert weather.wind_speed[at] == pytest.approx([4.0, 4.25, 6.75])
    assert weather.pressure[at] == pytest.approx([95006.0, 95006.5, 95011.5])
    assert weather.vapour_pressure[at[0]] == pytest.approx(0.6 * saturation_pressure(286.0))
    assert np.all(weather.vapour_pressure <= saturation_pressure(weather.air_temperature))


def test_altitude_changes_air_and_sun(sun_path, sky):
    """From a station at 500 m to a summit at 2500 m: 13 K colder, thinner air that keeps its mixing ratio, more sun."""
    weather = from_hours(500.0, HOURS, np.full(24, 290.0), 40.0, 2.0, 0.0, np.full(24, 96e3))
    scene = Scene(sun_path, weather, sky, np.array([500.0, 2500.0]), np.array([0.0]), np.array([0.0]))
    forcing = scene.forcing(96)
    assert forcing.air_temperature[:, 0] == pytest.approx([290.0, 277.0])
    assert forcing.pressure[:, 0] == pytest.approx([96e3, 96e3 * np.exp(-2000 / 8000)], rel=1e-9)
    mixing = forcing.vapour_pressure[:, 0] / forcing.pressure[:, 0]
    assert mixing[0] == pytest.approx(mixing[1])
    noon = forcing.shortwave_direct[:, 48]
    assert noon[1] > 1.05 * noon[0]


def test_cloud_of_the_afternoon_darkens_the_afternoon(sun_path, sky):
    cloud = np.where((HOURS >= 14) & (HOURS <= 17), 1.0, 0.0)
    weather = from_hours(0.0, HOURS, np.full(24, 290.0), 50.0, 2.0, cloud)
    forcing = Scene(sun_path, weather, sky, np.array([0.0]), np.array([0.0]), np.array([0.0])).forcing(96)
    assert forcing.shortwave_direct[0, 10 * 4] > 500 and forcing.shortwave_direct[0, 15 * 4] == 0
    assert forcing.longwave_sky[0, 15 * 4] > forcing.longwave_sky[0, 10 * 4] + 50


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


def test_humidity_of_the_extremes_holds_at_their_mean(sun_path):
    """50 % at 20 C between 10 and 30 C: 0.5 x 2339.2 Pa all day, saturated where that exceeds what cold air holds."""
    air = from_extremes(sun_path, 283.15, 303.15, 50.0, 3.0, 0.25)
    assert air.vapour_pressure == pytest.approx(1169.6, rel=4e-3)
    assert np.all(air.wind_speed == 3.0) and np.all(air.cloud_fraction == 0.25) and air.pressure is None
    humid = from_extremes(sun_path, 283.15, 303.15, 90.0, 3.0, 0.0)
    assert humid.vapour_pressure.min() == pytest.approx(1228.0, rel=5e-3)
    assert humid.vapour_pressure.max() == pytest.approx(0.9 * 2339.2, rel=4e-3)


def test_air_temperature_is_half_cosines(sun_path):
    """Half way up in time from sunrise to two hours after noon, and half way down again, lies the mean."""
    series, hours = air_temperature(sun_path, 280.0, 300.0), sun_hours()
    coldest, warmest = hours[series.argmin()], hours[series.argmax()]
    up, down = 0.5 * (coldest + warmest), 0.5 * (warmest + coldest + 24.0) % 24.0
    assert np.interp([up, down], hours, series) == pytest.approx([290.0, 290.0], abs=0.1)
    quarter = coldest + 0.25 * (warmest - coldest)
    assert np.interp(quarter, hours, series) == pytest.approx(290 - 10 * np.cos(np.pi / 4), abs=0.1)


def test_air_carried_upwards_keeps_to_saturation(sun_path):
    """Saturated air at 0 m, 3 km higher: 19.5 K colder, so that it holds less than its mixing ratio would give."""
    air = from_hours(0.0, HOURS, np.full(24, 293.15), 100.0, 2.0, 0.0)
    temperature, vapour, pressure = air.at(np.array([3000.0]), np.array([7e4, 1e5]))
    assert temperature[0, 0] == pytest.approx(273.65) and pressure[0, 0] == pytest.approx(7e4)
    assert vapour[0, 0] == pytest.approx(saturation_pressure(273.65)) and vapour[0, 0] < 0.7 * 2339.2


def test_vapour_between_hours_is_at_most_saturated():
    """Fog of -20 and +20 C in turn: a straight line between both pressures would exceed saturation in between."""
    temperature = np.where(HOURS % 2 == 0, 253.15, 293.15)
    air = from_hours(0.0, HOURS, temperature, 100.0, 2.0, 0.0)
    half = np.searchsorted(sun_hours(), 6.5)
    assert air.air_temperature[half] == pytest.approx(273.15)
    assert air.vapour_pressure[half] == pytest.approx(611.2, rel=1e-6)
