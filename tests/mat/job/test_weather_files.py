"""Weather of a job from EPW, TMY3 and CSV files: hours, units, and the place of what is wrong."""

from datetime import date
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.scene.surface import scene_inputs
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.schemas.errors import InputError


def test_epw_hours_end_where_the_file_says(tmp_path, epw):
    """Hour 14 of local standard time (UTC-7) is 15:00 on a clock that is an hour ahead (UTC-6)."""
    weather = read_weather(epw(tmp_path), date(2026, 6, 22), -6).hourly
    at = weather.time.index(15.0)
    assert (weather.air_temperature_c[at], weather.wind_speed_m_s[at]) == (14.0, 7.0)
    assert (weather.cloud_fraction[at], weather.pressure_hpa[at], weather.altitude_km) == (0.5, 820.0, 1.829)
    assert sorted(weather.time) == weather.time and len(weather.time) == 24


def said_of(job):
    """Warnings of a job but those of clocks: the air of the files made here is warmest at midnight."""
    return tuple(line for line in load_job(job).warnings if "zone" not in line)


@pytest.mark.parametrize(
    "day, change, message",
    [
        (date(2026, 6, 20), (), "test.epw: found 0 hours of 20 June; allowed: days from 6/21 to 6/22"),
        (
            date(2026, 6, 22),
            [(24 + 5, 6, "88.8")],
            "test.epw:38:17: air_temperature_c: found 88.8; allowed: numbers from -90 to 70",
        ),
        (
            date(2026, 6, 22),
            [(24 + hour, 6, "99.9") for hour in (5, 6, 7)],
            "test.epw:38: has no air_temperature_c in 3 of the 24 hours; allowed: gaps up to 3 h",
        ),
        (date(2026, 6, 21), [(2, 22, "11")], "test.epw:11:.*: cloud_fraction: found 11; allowed: numbers from 0 to 1"),
        (date(2026, 6, 21), [(2, 22, "nan")], "test.epw:11:.*: cloud_fraction: found 'nan'; allowed: a number"),
        (date(2026, 6, 21), [(0, 1, "June")], "test.epw:9:6: month: found 'June'; allowed: a whole number"),
        (
            date(2026, 6, 21),
            [(0, 3, "2")],
            "test.epw:10: found 24 readings of 21 June; allowed: 24; that of 2 h is there",
        ),
    ],
)
def test_wrong_epw_files_are_placed(tmp_path, day, change, message, epw):
    with pytest.raises(InputError, match=message):
        read_weather(epw(tmp_path, change), day, -7)


def test_short_gaps_of_an_epw_file_are_interpolated_and_said(tmp_path, epw):
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
            "has no pressure_hpa in 24 of 24 hours; that of the state's profile is taken",
        ),
        (21, "999", "wind_speed_m_s", "has no wind_speed_m_s in 24 of 24 hours; weather.wind_speed_m_s of the job"),
        (8, "999", "relative_humidity_percent", "in 24 of 24 hours; it follows from the dew point"),
    ],
)
def test_what_an_epw_file_lacks_all_day_is_replaced_and_said(tmp_path, column, code, name, note, epw):
    found = read_weather(epw(tmp_path, missing(column, code)), date(2026, 6, 22), -7)
    assert len(found.notes) == 1 and note in found.notes[0]
    if name == "relative_humidity_percent":  # 1 C of 11 C: 657.1 Pa of 1312.8 Pa (CRC Handbook)
        assert found.hourly.relative_humidity_percent[11] == pytest.approx(50.05, abs=0.1)
    else:
        assert getattr(found.hourly, name) is None


@pytest.mark.parametrize("cover", [0.0, 3.0, 10.0])
def test_cloud_of_pvgis_follows_from_the_longwave_of_its_sky(tmp_path, cover, epw):
    """99 tenths in all hours; the emissivity of Clark and Allen at a dew point of 1 C is 0.7876."""
    emissivity = 0.787 + 0.764 * np.log(274.15 / 273)
    emissivity *= 1 + 0.0224 * cover - 0.0035 * cover**2 + 0.00028 * cover**3
    change = missing(22, "99")
    for reading in range(48):
        kelvin = 273.15 + reading % 24 + 1
        change.append((reading, 12, f"{emissivity * 5.670374e-8 * kelvin**4:.3f}"))
    found = read_weather(epw(tmp_path, change), date(2026, 6, 22), -7)
    assert found.hourly.cloud_fraction == pytest.approx([cover / 10] * 24, abs=2e-3)
    assert "it follows from the longwave radiation of the sky" in found.notes[0]


def test_measured_light_that_is_missing_is_refused(tmp_path, epw):
    with pytest.raises(InputError, match=r"test.epw:33: has no direct_normal_w_m2 in 24 of the 24 hours"):
        read_weather(epw(tmp_path, missing(14, "9999")), date(2026, 6, 22), -7, radiation=True)
    found = read_weather(epw(tmp_path, missing(12, "9999")), date(2026, 6, 22), -7, radiation=True)
    assert found.hourly.longwave_down_w_m2 is None and "that of the state" in found.notes[0]


def test_a_job_s_own_keys_stand_for_what_the_file_lacks(tmp_path, load_weather, epw):
    epw(tmp_path, missing(22, "99") + missing(12, "9999"))
    load_weather("{file: test.epw}")
    (warning,) = said_of(tmp_path / "job.yaml")
    assert warning == (
        "state 1: weather file test.epw has no cloud_fraction in 24 of 24 hours; weather.cloud_fraction of the job, or"
        " its default, a clear sky, is taken"
    )
    job = load_weather("{file: test.epw, cloud_fraction: 0.7}")
    assert said_of(tmp_path / "job.yaml") == ()
    assert np.all(scene_inputs(job, 1)[1].cloud_fraction == 0.7)


def test_places_in_latin_1_and_leap_days(tmp_path, epw):
    file = epw(tmp_path)
    text = file.read_text().replace("LOCATION,Test", "LOCATION,Z\u00fcrich")
    file.write_bytes(text.replace(",6,22,", ",2,28,").encode("latin-1"))
    found = read_weather(file, date(2028, 2, 29), -7)
    assert found.notes == ("has no 29 February; the 28th is taken",) and found.station.altitude == 1829
    file.write_bytes(text.replace(",6,22,", ",2,29,").replace(",6,21,", ",2,28,").encode("latin-1"))
    found = read_weather(file, date(2028, 2, 29), -7)
    assert found.notes == () and len(found.hourly.time) == 24


def test_a_file_of_several_years_is_read_in_the_year_of_the_day(tmp_path, epw):
    file = epw(tmp_path)
    lines = file.read_text().splitlines()
    later = [line.replace("1999,", "2000,", 1).replace(",40,", ",77,") for line in lines[8:]]
    file.write_text("\n".join(lines + later) + "\n")
    assert read_weather(file, date(2000, 6, 22), -7).hourly.relative_humidity_percent[0] == 77
    assert read_weather(file, date(1999, 6, 22), -7).hourly.relative_humidity_percent[0] == 40
    with pytest.raises(InputError, match="found 0 hours of 22 June"):
        read_weather(file, date(2026, 6, 22), -7)


@pytest.mark.parametrize(
    "content, change, message",
    [
        (b"", (), "year.epw:1: found no place and time zone in the first line"),
        (b"\0\xff" * 50, (), "year.epw:1: found no place"),
        (b"STATION" + b"\n" * 9, (), "found 0 hours of 22 June"),
        (b"STATION" + b"\n" * 8 + b"1999,6,22,1\n", (), "year.epw:9:1: found 4 cells; allowed: 23 or more"),
        (b"STATION", ("-7.0", "nan"), "found no place and time zone"),
        (b"STATION", ("39.74", "3974"), "found latitude 3974, .*allowed: a place on Earth"),
    ],
)
def test_hostile_epw_files_are_refused_in_one_line(tmp_path, epw_station, content, change, message):
    station = epw_station.replace(*change) if change else epw_station
    (tmp_path / "year.epw").write_bytes(content.replace(b"STATION", station.encode()))
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


def test_csv_by_time_of_day(tmp_path, csv):
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
def test_wrong_csv_files_are_placed(tmp_path, rows, message, csv):
    with pytest.raises(InputError, match=message):
        read_weather(csv(tmp_path, rows), date(2026, 6, 21), 0)


def test_a_job_takes_a_file_and_its_own_keys_before_it(tmp_path, load_weather, epw):
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


def test_a_file_of_another_place_is_warned_of_with_its_distance(tmp_path, load_weather, epw):
    """The station lies at 39.74 N, 105.18 W, 1829 m; a degree of latitude is 111 km."""
    epw(tmp_path)
    load_weather("{file: test.epw}")
    text = (tmp_path / "job.yaml").read_text(encoding="utf-8")
    assert said_of(tmp_path / "job.yaml") == ()
    for old, new, message in (
        ("latitude_deg: 39.7", "latitude_deg: 41.74", "222 km from the site and 29 m above it"),
        ("longitude_deg: -105.2", "longitude_deg: 105.18", "km from the site"),
        ("altitude_km: 1.8", "altitude_km: 2.5", "5 km from the site and 671 m below it"),
    ):
        assert old in text
        (tmp_path / "job.yaml").write_text(text.replace(old, new), encoding="utf-8")
        (warning,) = said_of(tmp_path / "job.yaml")
        assert warning.startswith("state 1: weather file test.epw was measured at latitude 39.74, longitude -105.18")
        assert message in warning


def test_a_table_by_time_of_day_has_no_place(tmp_path, load_weather, csv):
    csv(tmp_path, [f"{hour:02d}:00,{hour},36,50" for hour in range(0, 24, 3)])
    load_weather("{file: day.csv}")
    assert said_of(tmp_path / "job.yaml") == ()
