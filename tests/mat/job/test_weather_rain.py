"""Rain in weather files and tables."""

from datetime import date
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job.weather_files import read_weather
from skyshine.schemas.errors import InputError


def rainy(*readings):
    """Changes of `epw`: (reading, depth, hours over which it fell)."""
    return [change for at, depth, hours in readings for change in ((at, 33, depth), (at, 34, hours))]


def rain_of(weather):
    return dict(zip(weather.time, weather.rain_mm_h, strict=True))


def test_rain_of_an_epw_file_is_read_where_it_falls(tmp_path, load_weather, epw):
    """3 mm in the hour that ends at 5, 6 mm in the three that end at 12 of which 0.6 in that which ends at 11."""
    file = epw(tmp_path, rainy((24 + 4, "3", "1"), (24 + 10, "0.6", "1"), (24 + 11, "6.0", "3")))
    found = rain_of(read_weather(file, date(2026, 6, 22), -7, rain="file").hourly)
    fallen = {hour: depth for hour, depth in found.items() if depth}
    assert fallen == pytest.approx({5: 3.0, 10: 2.7, 11: 0.6, 12: 2.7})
    unasked = read_weather(file, date(2026, 6, 22), -7)
    assert rain_of(unasked.hourly) == found and any("9.0 mm of rain" in note for note in unasked.notes)
    assert read_weather(file, date(2026, 6, 21), -7).hourly.rain_mm_h is None  # a dry day knows no film
    assert read_weather(file, date(2026, 6, 22), -7, rain="none").notes == ()
    loaded = load_weather({"file": "test.epw", "rain": "file", "ground": "air"})
    assert sum(loaded.states[0].weather.hourly.rain_mm_h) == pytest.approx(9)


@pytest.mark.parametrize("code", ["999", "-9900", "-9999", ""])
def test_missing_depths_of_rain_are_none_and_said(tmp_path, code, epw):
    file = epw(tmp_path, rainy((2, code, "1"), (3, code, "99"), (7, "1.5", "99"), (8, "2", "0")))
    weather = read_weather(file, date(2026, 6, 21), -7, rain="file")
    found = rain_of(weather.hourly)
    assert (found[3], found[4], found[8], found[9]) == (0, 0, 1.5, 2)
    assert "has no rain value in 2 of 24 hours; these are taken as dry" in weather.notes


def test_a_file_that_ends_before_its_rain_or_tells_none_is_refused_where_rain_is_asked(tmp_path, epw):
    file = epw(tmp_path, [change for hour in range(48) for change in rainy((hour, "999", "99"))])
    with pytest.raises(InputError, match=r"test.epw: tells no liquid precipitation on 21 June, which rain: file asks"):
        read_weather(file, date(2026, 6, 21), -7, rain="file")
    assert read_weather(file, date(2026, 6, 21), -7).notes == ()
    short = "\n".join(",".join(line.split(",")[:33]) for line in file.read_text().splitlines())
    file.write_text(short + "\n")
    with pytest.raises(InputError, match="tells no liquid precipitation"):
        read_weather(file, date(2026, 6, 21), -7, rain="file")
    assert read_weather(file, date(2026, 6, 21), -7).hourly.rain_mm_h is None


def test_a_wrong_depth_of_rain_is_placed_and_stops_only_who_asks_for_it(tmp_path, epw):
    file = epw(tmp_path, rainy((4, "rain", "1")))
    with pytest.raises(InputError, match=r"test.epw:13:\d+: rain_mm: found 'rain'; allowed: a number"):
        read_weather(file, date(2026, 6, 21), -7, rain="file")
    assert read_weather(file, date(2026, 6, 21), -7).hourly.rain_mm_h is None
    with pytest.raises(InputError, match=r"rain_mm: found 700; allowed: numbers from 0 to 500"):
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
def test_rain_of_a_csv_is_read_by_default(tmp_path, rain, csv):
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
