"""The season of the ground: of a file's year, its header, the latitude or the job."""

import re
from datetime import date

import pytest

from skyshine.mat.job import ground_files
from skyshine.mat.job.ground import GroundYear, ground_of_latitude
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.surface import scene_inputs
from skyshine.schemas.errors import InputError


@pytest.mark.parametrize(
    "key, expected",
    [
        ("", (12.0, 9.0, 30.0)),  # the air of a whole year, as nothing is said
        (", ground: file", (12.0, 9.0, 30.0)),
        # 7 K at 0.5 m, coldest at 1.5 months; damping depth 2.46 m: 7 exp(0.203) K at the surface, 11.8 d earlier
        (", ground: epw", (10.0, 8.6, 45.7 - 11.8)),
        # Tropical and midlatitude air, 0.177 and 0.823 of them, 11.7 K colder at 1.8 km.
        (", ground: latitude", (1.3, 9.05, 15.0)),
        (", ground: {mean_c: 3, amplitude_c: 4, coldest_day: 99}", (3.0, 4.0, 99.0)),
    ],
)
def test_the_season_of_the_ground_is_that_of_file_header_latitude_or_job(
    tmp_path, load_weather, key, expected, epw_year
):
    epw_year(tmp_path)
    job = load_weather(f"{{file: year.epw{key}}}")
    year = job.states[0].weather.ground
    assert (year.mean_c, year.amplitude_c, year.coldest_day) == pytest.approx(expected, abs=0.6)
    ground = scene_inputs(job, 1)[1].ground
    assert ground.mean == pytest.approx(year.mean_c + 273.15)
    assert ground.since_coldest == pytest.approx((173 - year.coldest_day) % 365.25)  # 22 June


def test_the_season_is_said_where_it_is_asked_for_and_air_or_part_of_a_year_leaves_it_out(
    tmp_path, load_weather, epw_year
):
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
def test_wrong_seasons_are_placed(tmp_path, load_weather, weather, message, epw_year, ground_header):
    epw_year(tmp_path)
    epw_year(tmp_path, months=11, name="part.epw")
    epw_year(tmp_path, ground="ground_header TEMPERATURES,0", name="bare.epw")
    epw_year(tmp_path, ground=ground_header.replace("8,6,5,5", "8,six,5,5"), name="wrong.epw")
    with pytest.raises(InputError, match=message):
        load_weather(weather)


def test_the_default_season_of_the_south_is_half_a_year_later(tmp_path, load_weather):
    given = GroundYear(mean_c=10, amplitude_c=5)
    north, south = (given.at_latitude(latitude).on(date(2026, 7, 16)).since_coldest for latitude in (50.0, -50.0))
    assert (north, south) == (pytest.approx(182.0), pytest.approx(364.6, abs=0.3))
    assert ground_of_latitude(-45, 1.0).mean_c == pytest.approx(ground_of_latitude(45, 0).mean_c - 6.5, abs=0.11)
    loaded = load_weather("{air_temperature_c: 20, ground: {mean_c: 10, amplitude_c: 5}}")
    assert loaded.states[0].weather.ground.text == "mean 10 C, amplitude 5 K, coldest on day 15"


def test_the_ground_of_the_latitude_lies_at_the_station_of_the_weather(tmp_path, load_weather, epw_year):
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
        ((100, 6), "88.8", r"contains no year of the ground; .* \(in line 109: air_temperature_c: found 88.8; allowed"),
        (
            (100, 1),
            "13",
            r"contains no year of the ground; .* \(in line 109: found month 13, day 5, hour 5",
        ),
    ],
)
def test_a_wrong_reading_of_another_day_is_said_and_stops_none_but_who_asks_for_the_year(
    tmp_path, load_weather, place, text, remark, epw_year
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


def test_a_series_reads_its_year_once(tmp_path, load_weather, monkeypatch, epw_year):
    count = []
    whole = ground_files.annual_harmonic
    monkeypatch.setattr(ground_files, "annual_harmonic", lambda *readings: count.append(1) or whole(*readings))
    file = epw_year(tmp_path, name="once.epw")
    assert len({id(ground_files.ground_of_file(file, -7)) for _ in range(30)}) == 1 and len(count) == 1
