"""Weather of a job from EPW, TMY3 and CSV files: hours, units, measured light, and the place of what is wrong."""

import re
from datetime import date
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job import ground_files
from skyshine.mat.job.ground import GroundYear, ground_of_latitude
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
    weather = read_weather(epw(tmp_path), date(2026, 6, 22), -6).hourly
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
            [(24 + 5, 6, "88.8")],
            "test.epw:38:17: air_temperature_c: found 88.8; allowed: numbers worth -90 to 70",
        ),
        (
            date(2026, 6, 22),
            [(24 + hour, 6, "99.9") for hour in (5, 6, 7)],
            "test.epw:38: has no air_temperature_c in 3 of the 24 hours; allowed: gaps up to 3 h",
        ),
        (date(2026, 6, 21), [(2, 22, "11")], "test.epw:11:.*: cloud_fraction: found 11; allowed: numbers worth 0 to 1"),
        (date(2026, 6, 21), [(2, 22, "nan")], "test.epw:11:.*: cloud_fraction: found 'nan'; allowed: a number"),
        (date(2026, 6, 21), [(0, 1, "June")], "test.epw:9:6: month: found 'June'; allowed: a whole number"),
        (date(2026, 6, 21), [(0, 3, "2")], "test.epw: found 24 hours of 21 June; allowed: the 24 of a day"),
    ],
)
def test_wrong_epw_files_are_placed(tmp_path, day, change, message):
    with pytest.raises(InputError, match=message):
        read_weather(epw(tmp_path, change), day, -7)


def test_short_gaps_of_an_epw_file_are_interpolated_and_said(tmp_path):
    file = epw(tmp_path, [(24 + 5, 6, "99.9"), (24 + 6, 6, "99.9"), (24 + 9, 21, "999")])
    found = read_weather(file, date(2026, 6, 22), -7)
    assert found.hourly.air_temperature_c[found.hourly.time.index(6.0)] == pytest.approx(6.0)
    assert found.hourly.wind_speed_m_s[found.hourly.time.index(10.0)] == pytest.approx(5.0)
    assert found.notes == (
        "has no air_temperature_c in 2 of 24 hours; interpolated",
        "has no wind_speed_m_s in 1 of 24 hours; interpolated",
    )


def missing(column, code):
    return [(reading, column, code) for reading in range(48)]


@pytest.mark.parametrize(
    "column, code, name, note",
    [
        (
            9,
            "999999",
            "pressure_hpa",
            "has no pressure_hpa in 24 of 24 hours; that of the state's profile stands for it",
        ),
        (21, "999", "wind_speed_m_s", "has no wind_speed_m_s in 24 of 24 hours; weather.wind_speed_m_s of the job"),
        (8, "999", "relative_humidity_percent", "in 24 of 24 hours; it follows from the dew point"),
    ],
)
def test_what_an_epw_file_lacks_all_day_is_replaced_and_said(tmp_path, column, code, name, note):
    found = read_weather(epw(tmp_path, missing(column, code)), date(2026, 6, 22), -7)
    assert len(found.notes) == 1 and note in found.notes[0]
    if name == "relative_humidity_percent":  # 1 C of 11 C: 657.1 Pa of 1312.8 Pa (CRC Handbook)
        assert found.hourly.relative_humidity_percent[11] == pytest.approx(50.05, abs=0.1)
    else:
        assert getattr(found.hourly, name) is None


@pytest.mark.parametrize("cover", [0.0, 3.0, 10.0])
def test_cloud_of_pvgis_follows_from_the_longwave_of_its_sky(tmp_path, cover):
    """99 tenths in all hours; the emissivity of Clark and Allen at a dew point of 1 C is .7876."""
    emissivity = 0.787 + 0.764 * np.log(274.15 / 273)
    emissivity *= 1 + 0.0224 * cover - 0.0035 * cover**2 + 0.00028 * cover**3
    change = missing(22, "99")
    for reading in range(48):
        kelvin = 273.15 + reading % 24 + 1
        change.append((reading, 12, f"{emissivity * 5.670374e-8 * kelvin**4:.3f}"))
    found = read_weather(epw(tmp_path, change), date(2026, 6, 22), -7)
    assert found.hourly.cloud_fraction == pytest.approx([cover / 10] * 24, abs=2e-3)
    assert "it follows from the longwave radiation of the sky" in found.notes[0]


def test_measured_light_that_is_missing_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"test.epw:33: has no direct_normal_w_m2 in 24 of the 24 hours"):
        read_weather(epw(tmp_path, missing(14, "9999")), date(2026, 6, 22), -7, radiation=True)
    found = read_weather(epw(tmp_path, missing(12, "9999")), date(2026, 6, 22), -7, radiation=True)
    assert found.hourly.longwave_down_w_m2 is None and "that of the state" in found.notes[0]


def test_a_job_s_own_keys_stand_for_what_the_file_lacks(tmp_path, load_weather):
    epw(tmp_path, missing(22, "99") + missing(12, "9999"))
    load_weather("{file: test.epw}")
    (warning,) = load_job(tmp_path / "job.yaml").warnings
    assert warning == (
        "state 1: weather file test.epw has no cloud_fraction in 24 of 24 hours; weather.cloud_fraction of the job, or"
        " its default, a clear sky, stands for it"
    )
    job = load_weather("{file: test.epw, cloud_fraction: 0.7}")
    assert load_job(tmp_path / "job.yaml").warnings == ()
    assert np.all(scene_inputs(job, 1)[1].cloud_fraction == 0.7)


def test_places_in_latin_1_and_leap_days(tmp_path):
    file = epw(tmp_path)
    text = file.read_text().replace("LOCATION,Test", "LOCATION,Z\u00fcrich")
    file.write_bytes(text.replace(",6,22,", ",2,28,").encode("latin-1"))
    found = read_weather(file, date(2028, 2, 29), -7)
    assert found.notes == ("has no 29 February; the 28th stands for it",) and found.station.altitude == 1829
    file.write_bytes(text.replace(",6,22,", ",2,29,").replace(",6,21,", ",2,28,").encode("latin-1"))
    found = read_weather(file, date(2028, 2, 29), -7)
    assert found.notes == () and len(found.hourly.time) == 24


def test_a_file_of_several_years_is_read_in_the_year_of_the_day(tmp_path):
    file = epw(tmp_path)
    lines = file.read_text().splitlines()
    later = [line.replace("1999,", "2000,", 1).replace(",40,", ",77,") for line in lines[8:]]
    file.write_text("\n".join(lines + later) + "\n")
    assert read_weather(file, date(2000, 6, 22), -7).hourly.relative_humidity_percent[0] == 77
    assert read_weather(file, date(1999, 6, 22), -7).hourly.relative_humidity_percent[0] == 40
    with pytest.raises(InputError, match="found 0 hours of 22 June"):
        read_weather(file, date(2026, 6, 22), -7)


@pytest.mark.parametrize(
    "content, message",
    [
        (b"", "year.epw:1: found no place and time zone in the first line"),
        (b"\0\xff" * 50, "year.epw:1: found no place"),
        (EPW_STATION.encode() + b"\n" * 9, "found 0 hours of 22 June"),
        (EPW_STATION.encode() + b"\n" * 8 + b"1999,6,22,1\n", "year.epw:9:1: found 4 cells; allowed: 23 or more"),
        (EPW_STATION.replace("-7.0", "nan").encode(), "found no place and time zone"),
        (EPW_STATION.replace("39.74", "3974").encode(), "found latitude 3974, .*allowed: a place on Earth"),
    ],
)
def test_hostile_epw_files_are_refused_in_one_line(tmp_path, content, message):
    (tmp_path / "year.epw").write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_weather(tmp_path / "year.epw", date(2026, 6, 22), -7)
    assert "\n" not in str(caught.value)


def test_tmy3_of_greensboro():
    """pvlib's own sample file; its reading of 21 June 14:00 stands in line 4120."""
    file = Path(pvlib.__file__).parent / "data" / "723170TYA.CSV"
    if not file.is_file():
        pytest.skip("this pvlib comes without its sample file")
    cells = file.read_text().splitlines()[2 + 24 * 171 + 13].split(",")
    assert cells[:2] == ["06/21/1988", "14:00"] or (cells[0].startswith("06/21") and cells[1] == "14:00")
    weather = read_weather(file, date(2026, 6, 21), -5).hourly
    at = weather.time.index(14.0)
    assert weather.air_temperature_c[at] == float(cells[31]) and weather.altitude_km == 0.273


def csv(folder, rows, header="time,air_temperature[C],wind_speed[km/h],cloud_fraction[%]"):
    file = folder / "day.csv"
    file.write_text("\n".join([header, *rows]) + "\n")
    return file


def test_csv_by_time_of_day(tmp_path):
    weather = read_weather(
        csv(tmp_path, [f"{hour:02d}:00,{hour},36,50" for hour in range(0, 24, 3)]), date(2026, 6, 21), 0
    ).hourly
    assert weather.air_temperature_c == pytest.approx(np.arange(0, 24, 3)) and weather.relative_humidity_percent is None
    assert weather.wind_speed_m_s == pytest.approx([10.0] * 8) and weather.cloud_fraction == pytest.approx([0.5] * 8)


@pytest.mark.parametrize(
    "rows, message",
    [
        ([f"{hour:02d}:00,20,5,0" for hour in (0, 3, 6, 12, 15, 18, 21, 23)], r"day.csv:5:1: found a gap of 6.0 h"),
        ([f"{hour:02d}:00,20,5,0" for hour in range(4, 24, 2)], r"day.csv:2:1: found a gap of 6.0 h"),
        ([f"{hour:02d}:00,20,5,{40 * hour}" for hour in range(9)], r"day.csv:5:12: cloud_fraction: found '120'"),
        (["06/21/2026 00:00,20,5,0"] * 8, r"day.csv:2:1: time: found '06/21/2026 00:00'; allowed: a time of day"),
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
        "723170,TEST,NC,-5.0,36.1,-79.95,273\nDate (MM/DD/YYYY),Time (HH:MM),Dry-bulb (C)\n06/21/1988,1400,0\n"
    )
    with pytest.raises(InputError, match="year.csv:3:1: found '06/21/1988 1400'; allowed: MM/DD/YYYY and HH:MM"):
        read_weather(file, date(2026, 6, 21), -5)


def test_measured_light_of_greensboro():
    """pvlib's own sample: the day's sum of direct light is the sum of the file's hours, each to its end."""
    file = Path(pvlib.__file__).parent / "data" / "723170TYA.CSV"
    if not file.is_file():
        pytest.skip("this pvlib comes without its sample file")
    rows = [row.split(",") for row in file.read_text().splitlines()[2 + 24 * 171 : 2 + 24 * 172]]
    plain, measured = (read_weather(file, date(2026, 6, 21), -5, radiation=given).hourly for given in (False, True))
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


GROUND = "GROUND TEMPERATURES,2,2,,,,8,6,5,5,7,9,11,13,14,14,13,11,.5,1.2,1600,1250," + ",".join(
    f"{10 - 7 * np.cos(2 * np.pi * (month + 0.5 - 1.5) / 12):.3f}" for month in range(12)
)


def epw_year(folder, ground=GROUND, months=12, name="year.epw"):
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


@pytest.mark.parametrize(
    "key, expected",
    [
        ("", (12.0, 9.0, 30.0)),  # the air of a whole year, as nothing is said
        (", ground: file", (12.0, 9.0, 30.0)),
        # 7 K at .5 m, coldest at 1.5 months; damping depth 2.46 m: 7 exp(.203) K at the surface, 11.8 d earlier
        (", ground: epw", (10.0, 8.6, 45.7 - 11.8)),
        # Tropical and midlatitude air, .177 and .823 of them, 11.7 K colder at 1.8 km.
        (", ground: latitude", (1.3, 9.05, 15.0)),
        (", ground: {mean_c: 3, amplitude_c: 4, coldest_day: 99}", (3.0, 4.0, 99.0)),
    ],
)
def test_the_season_of_the_ground_is_that_of_file_header_latitude_or_job(tmp_path, load_weather, key, expected):
    epw_year(tmp_path)
    job = load_weather(f"{{file: year.epw{key}}}")
    year = job.states[0].weather.ground
    assert (year.mean_c, year.amplitude_c, year.coldest_day) == pytest.approx(expected, abs=0.6)
    ground = scene_inputs(job, 1)[1].ground
    assert ground.mean == pytest.approx(year.mean_c + 273.15)
    assert ground.since_coldest == pytest.approx((173 - year.coldest_day) % 365.25)  # 22 June


def test_the_season_is_said_where_it_is_asked_for_and_air_or_part_of_a_year_leaves_it_out(tmp_path, load_weather):
    epw_year(tmp_path)
    epw_year(tmp_path, months=11, name="part.epw")
    for key, said in ((", ground: file", True), ("", False)):
        load_weather(f"{{file: year.epw{key}}}")
        lines = load_job(tmp_path / "job.yaml").warnings
        assert any("ground by file: mean 12 C" in line for line in lines) == said
    for weather in ("{file: year.epw, ground: air}", "{file: part.epw}", "{air_temperature_c: 20}"):
        job = load_weather(weather)
        assert job.states[0].weather.ground_year is None and scene_inputs(job, 1)[1].ground is None


@pytest.mark.parametrize(
    "weather, message",
    [
        ("{air_temperature_c: 20, ground: file}", r"job.yaml:6:.*found ground: file without a file; allowed: with"),
        ("{file: part.epw, ground: file}", "part.epw: found temperatures of a part of the year; allowed: of all its"),
        ("{file: bare.epw, ground: epw}", "bare.epw: found no ground temperatures in its header; allowed: an EPW with"),
        ("{file: wrong.epw, ground: epw}", "wrong.epw:4:23: found ground temperatures that are no numbers; allowed"),
        ("{file: year.epw, ground: {mean_c: 3}}", r"job.yaml:6:.*the key 'amplitude_c' is missing; add it$"),
        (
            "{file: year.epw, ground: sea}",
            r"found 'sea'; input should be 'air', 'file', 'epw' or 'latitude'$",
        ),
    ],
)
def test_wrong_seasons_are_placed(tmp_path, load_weather, weather, message):
    epw_year(tmp_path)
    epw_year(tmp_path, months=11, name="part.epw")
    epw_year(tmp_path, ground="GROUND TEMPERATURES,0", name="bare.epw")
    epw_year(tmp_path, ground=GROUND.replace("8,6,5,5", "8,six,5,5"), name="wrong.epw")
    with pytest.raises(InputError, match=message):
        load_weather(weather)


def test_the_default_season_of_the_south_is_half_a_year_later(tmp_path, load_weather):
    given = GroundYear(mean_c=10, amplitude_c=5)
    north, south = (given.at_latitude(latitude).on(date(2026, 7, 16)).since_coldest for latitude in (50.0, -50.0))
    assert (north, south) == (pytest.approx(182.0), pytest.approx(364.6, abs=0.3))
    assert ground_of_latitude(-45, 1.0).mean_c == pytest.approx(ground_of_latitude(45, 0).mean_c - 6.5, abs=0.11)
    loaded = load_weather("{air_temperature_c: 20, ground: {mean_c: 10, amplitude_c: 5}}")
    assert loaded.states[0].weather.ground.text == "mean 10 C, amplitude 5 K, coldest on day 15"


def test_the_ground_of_the_latitude_lies_at_the_station_of_the_weather(tmp_path, load_weather):
    """The station stands at 1,829 m, the site at 1,800: what differs is the lapse between them, of a rounded tenth."""
    (tmp_path / "high.epw").write_text(epw_year(tmp_path).read_text().replace("1829.0", "3800.0"))
    means = [
        load_weather(f"{{file: {name}, ground: latitude}}").states[0].weather.ground.mean_c
        for name in ("year.epw", "high.epw")
    ]
    assert means[0] - means[1] == pytest.approx(6.5 * (3.8 - 1.829), abs=0.11)


@pytest.mark.parametrize(
    "place, text, remark",
    [
        ((100, 6), "88.8", r"tells no year of the ground, .* \(in line 109: air_temperature_c: found 88.8; allowed"),
        (
            (100, 1),
            "13",
            r"tells no year of the ground, .* \(in line 109: found month 13, day 5, hour 5",
        ),
    ],
)
def test_a_wrong_reading_of_another_day_is_said_and_stops_none_but_who_asks_for_the_year(
    tmp_path, load_weather, place, text, remark
):
    lines = epw_year(tmp_path).read_text().splitlines()
    row, column = place
    cells = lines[8 + row].split(",")
    cells[column] = text
    (tmp_path / "year.epw").write_text("\n".join([*lines[: 8 + row], ",".join(cells), *lines[9 + row :]]) + "\n")
    assert load_weather("{file: year.epw}").states[0].weather.ground is None
    (warning,) = (line for line in load_job(tmp_path / "job.yaml").warnings if "ground" in line)
    assert re.search(remark, warning)
    with pytest.raises(InputError, match="year.epw:109:"):
        load_weather("{file: year.epw, ground: file}")


def test_a_series_reads_its_year_once(tmp_path, load_weather, monkeypatch):
    count = []
    whole = ground_files.annual_harmonic
    monkeypatch.setattr(ground_files, "annual_harmonic", lambda *readings: count.append(1) or whole(*readings))
    file = epw_year(tmp_path, name="once.epw")
    assert len({id(ground_files.ground_of_file(file, -7)) for _ in range(30)}) == 1 and len(count) == 1


def rainy(*readings):
    """Changes of `epw`: (reading, depth, hours over which it fell)."""
    return [change for at, depth, hours in readings for change in ((at, 33, depth), (at, 34, hours))]


def rain_of(weather):
    return dict(zip(weather.time, weather.rain_mm_h, strict=True))


def test_rain_of_an_epw_file_is_read_where_the_job_asks_for_it(tmp_path, load_weather):
    """3 mm in the hour that ends at 5, 6 mm in the three that end at 12 of which .6 in that which ends at 11."""
    file = epw(tmp_path, rainy((24 + 4, "3", "1"), (24 + 10, "0.6", "1"), (24 + 11, "6.0", "3")))
    found = rain_of(read_weather(file, date(2026, 6, 22), -7, rain="file").hourly)
    fallen = {hour: depth for hour, depth in found.items() if depth}
    assert fallen == pytest.approx({5: 3.0, 10: 2.7, 11: 0.6, 12: 2.7})
    silent = read_weather(file, date(2026, 6, 22), -7)
    assert silent.hourly.rain_mm_h is None and any("9.0 mm of rain" in note for note in silent.notes)
    assert read_weather(file, date(2026, 6, 22), -7, rain="none").notes == ()
    loaded = load_weather({"file": "test.epw", "rain": "file", "ground": "air"})
    assert sum(loaded.states[0].weather.hourly.rain_mm_h) == pytest.approx(9)


@pytest.mark.parametrize("code", ["999", "-9900", "-9999", ""])
def test_missing_depths_of_rain_are_none_and_said(tmp_path, code):
    file = epw(tmp_path, rainy((2, code, "1"), (3, code, "99"), (7, "1.5", "99"), (8, "2", "0")))
    weather = read_weather(file, date(2026, 6, 21), -7, rain="file")
    found = rain_of(weather.hourly)
    assert (found[3], found[4], found[8], found[9]) == (0, 0, 1.5, 2)
    assert "tells no rain in 2 of 24 hours; none stands for it" in weather.notes


def test_a_file_that_ends_before_its_rain_or_tells_none_is_refused_where_rain_is_asked(tmp_path):
    file = epw(tmp_path, [change for hour in range(48) for change in rainy((hour, "999", "99"))])
    with pytest.raises(InputError, match=r"test.epw: tells no liquid precipitation on 21 June, which rain: file asks"):
        read_weather(file, date(2026, 6, 21), -7, rain="file")
    assert read_weather(file, date(2026, 6, 21), -7).notes == ()
    short = "\n".join(",".join(line.split(",")[:33]) for line in file.read_text().splitlines())
    file.write_text(short + "\n")
    with pytest.raises(InputError, match="tells no liquid precipitation"):
        read_weather(file, date(2026, 6, 21), -7, rain="file")
    assert read_weather(file, date(2026, 6, 21), -7).hourly.rain_mm_h is None


def test_a_wrong_depth_of_rain_is_placed_and_stops_only_who_asks_for_it(tmp_path):
    file = epw(tmp_path, rainy((4, "rain", "1")))
    with pytest.raises(InputError, match=r"test.epw:13:\d+: rain_mm: found 'rain'; allowed: a number"):
        read_weather(file, date(2026, 6, 21), -7, rain="file")
    assert read_weather(file, date(2026, 6, 21), -7).hourly.rain_mm_h is None
    with pytest.raises(InputError, match=r"rain_mm: found 700; allowed: numbers worth 0 to 500"):
        read_weather(epw(tmp_path, rainy((4, "700", "1"))), date(2026, 6, 21), -7, rain="file")


def test_rain_of_a_tmy3_file_is_that_of_its_column():
    """Greensboro: pvlib reads the same file; depths of one hour."""
    file = Path(pvlib.__file__).parent / "data" / "723170TYA.CSV"
    table, _ = pvlib.iotools.read_tmy3(file, map_variables=True)
    depth = table.iloc[:, next(number for number, name in enumerate(table.columns) if "Lprecip depth" in name)]
    wettest = depth.where(depth > 0).idxmax()
    day = (depth.index - np.timedelta64(1, "h")).date
    chosen = (wettest - np.timedelta64(1, "h")).date()
    found = read_weather(file, chosen, -5, rain="file").hourly.rain_mm_h
    expected = np.maximum(depth[day == chosen].to_numpy(float), 0)
    assert sum(found) > 5
    np.testing.assert_allclose(sorted(found), sorted(expected))


@pytest.mark.parametrize("rain", ["file", "none"])
def test_rain_of_a_csv_is_read_by_default(tmp_path, rain):
    rows = [f"{hour:02d}:00,20,{2 if hour == 5 else 0}" for hour in range(24)]
    file = csv(tmp_path, rows, header="time,air_temperature[C],rain[mm/h]")
    assert max(read_weather(file, date(2026, 6, 21), -7).hourly.rain_mm_h) == pytest.approx(2)
    found = read_weather(file, date(2026, 6, 21), -7, rain=rain).hourly.rain_mm_h
    assert (found is None) == (rain == "none")
    dry = csv(tmp_path, [row.rsplit(",", 1)[0] for row in rows], header="time,air_temperature[C]")
    with pytest.raises(InputError, match="has no column 'rain', which rain: file asks for"):
        read_weather(dry, date(2026, 6, 21), -7, rain="file")


def test_rain_without_a_file_is_placed_in_the_job(load_weather):
    with pytest.raises(InputError, match="found rain: file without a file; allowed: with a file"):
        load_weather({"air_temperature_c": 20, "rain": "file"})
