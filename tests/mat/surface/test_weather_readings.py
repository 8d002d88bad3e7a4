"""Readings in CSV: units, gaps, equal steps, and the place of what is wrong."""

import numpy as np
import pytest

from skyshine.mat.surface.weather_readings import WEATHER_COLUMNS, read_record
from skyshine.schemas.errors import InputError

HEADER = "time,sw_down,lw_down,air_temperature[C],relative_humidity,wind_speed,pressure[hPa]"


def write(folder, *rows, header=HEADER):
    file = folder / "weather.csv"
    file.write_text("\n".join(["# a record", header, *rows]) + "\n")
    return file


def hourly(days=1, row="{sun:.1f},300,20,40,2.0,950"):
    for hour in range(24 * days):
        sun = 800 * max(0.0, np.sin(np.pi * (hour % 24 - 6) / 12))
        yield f"2026-06-{21 + hour // 24:02d}T{hour % 24:02d}:00:00Z," + row.format(sun=sun)


def test_units_and_zones(tmp_path):
    rows = ["2026-06-21T02:00:00+02:00,-3.5,300,20,40,36,950"] + [
        f"2026-06-21T{hour:02d}:00,100,300,20,102,36,950" for hour in range(1, 6)
    ]
    record = read_record(write(tmp_path, *rows, header=HEADER.replace("wind_speed", "wind_speed[km/h]")))
    assert record.start == np.datetime64("2026-06-21T00:00:00")
    assert (record.step, record.steps) == (3600.0, 6)
    assert record.values["air_temperature"] == pytest.approx(293.15)
    assert record.values["wind_speed"] == pytest.approx(10.0)
    assert record.values["pressure"] == pytest.approx(95000.0)
    assert record.values["sw_down"][0] == 0.0 and record.values["relative_humidity"][1] == 100.0


# A cell in each unit, and its value in SI units.
CELLS = {
    "sw_down": {"W/m2": ("800", 800.0)},
    "lw_down": {"W/m2": ("300", 300.0)},
    "direct_normal": {"W/m2": ("900", 900.0)},
    "diffuse": {"W/m2": ("100", 100.0)},
    "cloud_fraction": {"1": ("0.5", 0.5), "%": ("50", 0.5)},
    "air_temperature": {"K": ("300", 300.0), "C": ("25", 298.15), "F": ("32", 273.15)},
    "relative_humidity": {"%": ("40", 40.0), "percent": ("40", 40.0), "1": ("0.5", 50.0)},
    "wind_speed": {"m/s": ("5", 5.0), "km/h": ("18", 5.0), "kt": ("1", 0.514444)},
    "pressure": {"Pa": ("101325", 101325.0), "hPa": ("1013.25", 101325.0), "kPa": ("101.325", 101325.0)},
    "wind_height": {"m": ("10", 10.0)},
    "air_height": {"m": ("1.5", 1.5)},
    "rain": {"mm/h": ("2.5", 2.5)},
    "soil_moisture": {"m3/m3": ("0.2", 0.2), "%": ("20", 0.2)},
}


@pytest.mark.parametrize(
    ("name", "unit"), [(name, unit) for name, column in WEATHER_COLUMNS.items() for unit in column.units]
)
def test_each_unit_is_converted(name, unit):
    cell, value = CELLS[name][unit]
    assert WEATHER_COLUMNS[name].to_si(cell, unit) == pytest.approx(value, rel=1e-6)


def test_missing_hours_are_bridged(tmp_path):
    rows = list(hourly())
    record = read_record(write(tmp_path, *rows[:9], *rows[10:]))
    assert record.steps == 24
    assert record.values["sw_down"][9] == pytest.approx(
        0.5 * (record.values["sw_down"][8] + record.values["sw_down"][10])
    )


GOOD = "2026-06-21T{:02d}:00:00Z,0,300,20,40,2.0,950"


@pytest.mark.parametrize(
    "row, message",
    [
        ("2026-06-21T02:00:00Z,0,abc,20,40,2.0,950", r"weather.csv:5:24: lw_down: found 'abc'"),
        ("2026-06-21T02:00:00Z,0,300,293,40,2.0,950", r"weather.csv:5:28: air_temperature: found '293'; allowed"),
        ("2026-06-21T02:00:00Z,0,300,20,40,2.0,nan", r"weather.csv:5:38: pressure: found 'nan'"),
        ("2026-06-21T02:00:00Z,-9999,300,20,40,2.0,950", r"weather.csv:5:22: sw_down: found '-9999'"),
        ("yesterday,0,300,20,40,2.0,950", r"weather.csv:5:1: time: found 'yesterday'; allowed: ISO 8601"),
        ("2026-06-21T02:00:00Z,0,300,20,40,2.0", r"weather.csv:5:1: found 6 cells; allowed: 7"),
        ("2026-06-20T02:00:00Z,0,300,20,40,2.0,950", r"weather.csv:5:1: found a time that is not after"),
        ("2026-06-21T14:00:00Z,0,300,20,40,2.0,950", r"weather.csv:5:1: found a gap of 13.0 h"),
    ],
)
def test_wrong_rows_are_placed(tmp_path, row, message):
    later = [GOOD.format(hour) for hour in ((15, 16) if "T14" in row else (3, 4))]
    with pytest.raises(InputError, match=message):
        read_record(write(tmp_path, GOOD.format(0), GOOD.format(1), row, *later))


@pytest.mark.parametrize(
    "header, message",
    [
        (HEADER.replace("lw_down", "lw_dwn"), r"weather.csv:2:14: found the column 'lw_dwn'; did you mean 'lw_down'"),
        (HEADER.replace("[C]", "[Celsius]"), r"weather.csv:2:22: found the unit 'Celsius' of air_temperature"),
        (HEADER.replace("lw_down", "sw_down"), r"weather.csv:2:14: found the column 'sw_down' twice"),
        (HEADER.replace(",wind_speed", ""), r"weather.csv:2:1: the column 'wind_speed' is missing"),
    ],
)
def test_wrong_headers_are_placed(tmp_path, header, message):
    with pytest.raises(InputError, match=message):
        read_record(write(tmp_path, *hourly(), header=header))


def test_heights_of_measurement_are_those_of_the_file_or_of_wmo(tmp_path):
    rows = list(hourly())
    plain = read_record(write(tmp_path, *rows)).values
    assert np.all(plain["wind_height"] == 10.0) and np.all(plain["air_height"] == 2.0)
    masts = write(tmp_path, *(row + ",3,1.5" for row in rows), header=HEADER + ",wind_height,air_height")
    given = read_record(masts).values
    assert np.all(given["wind_height"] == 3.0) and np.all(given["air_height"] == 1.5)
