"""Days before the date: from files with dates, with their own midnights, Sun, cloud and light, and what they cost."""

from datetime import date

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.plan.cost import PLACED_TABLE, estimate
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.scene.surface import check_measured_light, scene_inputs
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

EPW_STATION = "LOCATION,Test,CO,USA,TMY3,724666,39.74,-105.18,-7.0,1829.0"


def csv(folder, rows, header="time,air_temperature[C],wind_speed[km/h],cloud_fraction[%]"):
    file = folder / "day.csv"
    file.write_text("\n".join([header, *rows]) + "\n")
    return file


def epw_of(folder, first, days, per_hour, name="june.epw"):
    """An EPW file of June whose temperature grows by `per_hour` every hour of local standard time since it began."""
    rows = []
    for day in range(days):
        for hour in range(1, 25):
            celsius = f"{per_hour * (24 * day + hour):.2f}"
            cells = ["1999", "6", str(first + day), str(hour), "0", "?", celsius, "1.0", "40", "82000"]
            rows.append(cells + ["0"] * 11 + ["2.0", "5", "4", *["0"] * 11])
    file = folder / name
    file.write_text("\n".join([EPW_STATION, *["HEADER"] * 7, *(",".join(row) for row in rows)]) + "\n")
    return file


def three_days(folder):
    """21 to 23 June: the tenth of the hours."""
    return epw_of(folder, 21, 3, 0.1)


def epw_of_june(folder):
    """Thirty days: the hundredth of the hours."""
    return epw_of(folder, 1, 30, 0.01)


def test_days_before_of_a_typical_year_begin_at_the_end_of_the_day_before(tmp_path):
    file = three_days(tmp_path)
    found = read_weather(file, date(2026, 6, 23), -7, days_before=1)
    for day, table in enumerate([*found.before, found.hourly], 1):
        assert table.time == list(range(24))
        assert table.air_temperature_c == pytest.approx(0.1 * (24 * day + np.arange(24)))
    alone = read_weather(file, date(2026, 6, 23), -7).hourly
    assert alone.air_temperature_c[0] == pytest.approx(7.2) and alone.air_temperature_c[1:] == pytest.approx(
        found.hourly.air_temperature_c[1:]
    )


@pytest.mark.parametrize("ahead", [-1.0, 0.5, 1.0])
def test_days_of_another_clock_take_readings_of_the_days_beside_them(tmp_path, ahead):
    found = read_weather(three_days(tmp_path), date(2026, 6, 22), -7 + ahead, days_before=0)
    assert len(found.hourly.time) == 24
    hours = read_weather(epw_of_june(tmp_path), date(2026, 6, 23), -7 + ahead, days_before=2)
    for day, table in enumerate([*hours.before, hours.hourly], 20):
        since = 24.0 * day + np.array(table.time) - ahead
        assert table.air_temperature_c == pytest.approx(0.01 * since)


DATED = [f"2026-06-{20 + day}T{hour:02d}:00Z,{10 * day + hour},36,50" for day in range(3) for hour in range(0, 24, 2)]


def test_a_csv_file_with_dates_holds_days(tmp_path):
    file = csv(tmp_path, DATED)
    found = read_weather(file, date(2026, 6, 22), 0, days_before=2)
    tables = [*found.before, found.hourly]
    assert [table.air_temperature_c[0] for table in tables] == pytest.approx([0, 10, 20])
    assert tables[1].time == list(range(0, 24, 2))
    assert read_weather(file, date(2026, 6, 21), 0).hourly == tables[1]
    assert read_weather(file, date(2026, 6, 21), 2).hourly.air_temperature_c[:2] == pytest.approx([22, 10])


@pytest.mark.parametrize(
    "rows, days, message",
    [
        (DATED, 3, "day.csv: found no reading of 2026-06-19; allowed: days of the file, 2026-06-20 to 2026-06-22"),
        (
            [row.split("T")[1].replace("Z", "") for row in DATED[:12]],
            1,
            "day.csv:2:1: found a time of day; allowed: dates too where",
        ),
        (
            [DATED[0].split("T")[1].replace("Z", ""), *DATED[1:]],
            0,
            "day.csv:2:1: found a time of day; allowed: dates too",
        ),
        (
            [*DATED[:5], *DATED[8:]],
            2,
            "day.csv:7:1: found a gap of 8.0 h before this reading; allowed: 3 h",
        ),
        (
            [row.replace("Z", "") for row in DATED],
            0,
            "day.csv:2:1: time: found '2026-06-20T00:00', which names no zone; allowed: with one; write"
            r" 2026-06-20T00:00:00\+00:00, or Z",
        ),
        (["2026-06-31T00:00,1,2,3", *DATED], 0, "day.csv:2:1: time: found '2026-06-31T00:00'; allowed: a time such as"),
    ],
)
def test_days_that_a_csv_file_lacks_are_placed(tmp_path, rows, days, message):
    with pytest.raises(InputError, match=message):
        read_weather(csv(tmp_path, rows), date(2026, 6, 22), 0, days_before=days)


def test_air_of_days_is_linear_over_midnight(tmp_path, load_weather):
    """The hundredth of the hours grows on through every midnight; its days have their own Sun."""
    epw_of_june(tmp_path)
    job = load_weather("{file: june.epw, history_days: 3}")
    sun, air, _ = scene_inputs(job, 1)
    day = job.site.date.day - 1
    assert len(air.before) == 3 and job.states[0].weather.history_days == 3
    for number, (_, before) in enumerate(air.before):
        begin = 24.0 * (day - 3 + number)
        assert before.air_temperature - 273.15 == pytest.approx(0.01 * (begin + sun_hours()), abs=1e-9)
    inner = sun_hours() <= 23
    assert air.air_temperature[inner] - 273.15 == pytest.approx(0.01 * (24.0 * day + sun_hours()[inner]), abs=1e-9)
    noon = [path.solar_elevation.max() for path, _ in air.before] + [sun.solar_elevation.max()]
    assert len(set(noon)) == 4


@pytest.mark.parametrize(
    "weather, message",
    [
        ("{air_temperature_c: 20, history_days: 2}", "found history_days: 2 without a file; allowed: with a file"),
        ("{air_temperature_c: 20, days_before: [{time: [], air_temperature_c: []}]}", "time"),
        ("{file: june.epw, history_days: 31}", "history_days: found 31; input should be less"),
        ("{file: june.epw, history_days: 30}", "june.epw: found 0 hours of"),
    ],
)
def test_history_that_cannot_be_is_refused(tmp_path, load_weather, weather, message):
    epw_of_june(tmp_path)
    with pytest.raises(InputError, match=message):
        load_weather(weather)


def test_a_day_that_repeats_is_linear_over_its_own_midnight(tmp_path, load_weather):
    """Readings at 1 to 22 h: midnight lies half-way between the last and the first of the day itself."""
    csv(tmp_path, [f"{hour:02d}:00,{hour},36,50" for hour in range(1, 23)])
    _, air, _ = scene_inputs(load_weather("{file: day.csv}"), 1)
    expected = np.interp(sun_hours(), [-2, 1, 22, 25], [22, 1, 22, 1])
    assert air.air_temperature - 273.15 == pytest.approx(expected, abs=1e-9)


@pytest.mark.validation  # 7 s: skies of two jobs of two days
def test_layers_of_cloud_take_the_place_of_a_fraction_on_the_days_before_too(tmp_path, load_weather):
    epw_of_june(tmp_path)  # 5 tenths of cloud on all days
    broken = load_weather("{file: june.epw, history_days: 1}")
    text = (tmp_path / "job.yaml").read_text()
    clouds = "    clouds: [{type: stratus, height_km: [2.4, 2.8]}]\n"
    (tmp_path / "job.yaml").write_text(text.replace("    weather:", f"{clouds}    weather:"))
    for job, fraction in ((broken, 0.5), (load_job(tmp_path / "job.yaml").trimmed, 0.0)):
        _, air, _ = scene_inputs(job, 1)
        for day in (*(before for _, before in air.before), air):
            assert np.all(day.cloud_fraction == fraction)


def test_light_at_night_on_a_day_before_is_refused_by_the_check(tmp_path, load_weather):
    """The file's clock is three hours off on the day before alone."""
    hours = np.arange(24)

    def rows(day, noon):
        sun = 800 * np.maximum(np.sin(np.pi * (hours - noon + 6) / 12), 0.0)
        return [f"2026-06-{day}T{hour:02d}:00-07:00,20,{sun[hour]:.0f},{0.1 * sun[hour]:.0f}" for hour in hours]

    header = "time,air_temperature[C],direct_normal,diffuse"
    weather = "{file: day.csv, history_days: 1, radiation: measured}"
    csv(tmp_path, [*rows(21, 13), *rows(22, 13)], header)
    check_measured_light(load_weather(weather), 1)
    csv(tmp_path, [*rows(21, 19), *rows(22, 13)], header)
    with pytest.raises(InputError, match="of direct light in the time to .* h, when the Sun is down"):
        check_measured_light(load_weather(weather), 1)


def test_days_before_cost_as_many_columns(tmp_path, load_weather):
    epw_of_june(tmp_path)
    seconds = []
    for days in (0, 3):
        load_weather(f"{{file: june.epw, history_days: {days}}}")
        loaded = load_job(tmp_path / "job.yaml")
        seconds.append(estimate(loaded, make_plan(loaded, load_library())))
    columns = seconds[1]["temperature"] - seconds[0]["temperature"]
    assert columns == pytest.approx(3 * PLACED_TABLE)  # of one material
    assert seconds[1]["shade"] > seconds[0]["shade"] and seconds[1]["atmosphere"] == seconds[0]["atmosphere"]
