"""Rain, soil moisture by time, albedo and age of snow, in jobs and records."""

from importlib import resources

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.api.temperature import surface_material
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.moisture import film_skin, optics
from skyshine.mat.surface.measured_skin import read_measured
from skyshine.mat.surface.weather import Wetting
from skyshine.mat.surface.weather_readings import read_record
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

HOURS = range(24)


def job(hourly=None, **weather):
    air = [18 + 7 * np.cos(2 * np.pi * (hour - 15) / 24) for hour in HOURS]
    table = {"time": [f"{hour:02d}:00" for hour in HOURS], "air_temperature_c": [round(float(t), 2) for t in air]}
    return {
        "skyshine": 1,
        "name": "water",
        "site": {"latitude_deg": 45, "longitude_deg": 5, "date": "2026-06-28", "utc_offset_h": 2},
        "states": [
            {
                "profile": "midlatitude_summer",
                "ground_material": "asphalt_road",
                "weather": {"hourly": table | (hourly or {}), **weather},
            }
        ],
        "bands": [],
        "materials": ["soil_sand", "asphalt_road", "snow_fine"],
    }


def day(material, hourly=None, **weather):
    return skyshine.mat.temperature(material, job=job(hourly, **weather))


def test_rain_of_a_table_cools_a_road_and_leaves_a_film():
    rain = [2.0 if hour in (9, 10) else 0.0 for hour in HOURS]
    wet, dry = day("asphalt_road", {"rain_mm_h": rain}), day("asphalt_road")
    assert dry.film is None and 0.4 < wet.film.max() <= 0.48
    # A row counts for the hour before it: rain falls from 8 to 10 h.
    hours = np.array(wet.time)
    assert wet.film[hours < 7.9].max() < 0.1 and wet.film[(hours > 8.5) & (hours < 9.9)].min() > 0.3
    assert (dry.temperature - wet.temperature).max() > 5


def test_rain_is_millimetres_an_hour():
    """.2 mm in the hour before 9 leave at most that, and most of it in the morning."""
    film = day("asphalt_road", {"rain_mm_h": [0.2 if hour == 9 else 0.0 for hour in HOURS]}).film
    assert 0.05 < film.max() < 0.25


def test_leaves_under_a_film_absorb_as_if_dry():
    grass = load_library()["grass_green"]
    found = film_skin(grass)
    assert (found.solar_absorptance, found.thermal_emissivity) == optics(grass)
    road = load_library()["asphalt_road"]
    assert film_skin(road).solar_absorptance > optics(road)[0]


def test_soil_moisture_of_a_table_is_that_of_the_job_where_it_is_even():
    even = day("soil_sand", {"soil_moisture_m3_m3": [0.1] * 24}).temperature
    key = skyshine.mat.temperature("soil_sand", job=job() | {"soil_moisture": 0.1}).temperature
    np.testing.assert_allclose(even, key, atol=0.02)
    drying = day("soil_sand", {"soil_moisture_m3_m3": [0.15 - 0.1 * hour / 23 for hour in HOURS]}).temperature
    assert np.abs(drying - even).max() > 1
    rock = day("asphalt_road", {"soil_moisture_m3_m3": [0.1] * 24}).temperature
    np.testing.assert_array_equal(rock, day("asphalt_road").temperature)


def test_old_snow_is_warmer():
    cold = {"air_temperature_c": [-12.0] * 24}
    fresh, same, old = (day("snow_fine", cold, snow_age_days=age).temperature for age in (0.0, None, 10.0))
    np.testing.assert_allclose(fresh, same, atol=1e-6)
    assert old.max() > fresh.max() + 1 and old.mean() > fresh.mean()


def test_only_what_is_written_is_part_of_the_identity():
    dry, wet = (load_job(job(hourly)).trimmed.states[0].weather for hourly in ({}, {"rain_mm_h": [0.0] * 24}))
    assert dry.water == {} and wet.water == {"rain_mm_h": [[0.0] * 24]}
    assert dry.model_dump() == wet.model_dump()


RECORD = "time,air_temperature[C],relative_humidity,wind_speed,sw_down,lw_down{head}\n"


def record(tmp_path, head="", cells=lambda hour: ""):
    rows = [
        f"2026-06-{28 + hour // 24:02d}T{hour % 24:02d}:00Z,{18 + 7 * np.cos((hour - 15) * 0.2618):.2f},50,2,"
        f"{max(0, 800 * np.cos((hour - 12) * 0.2618)):.1f},320{cells(hour)}"
        for hour in range(48)
    ]
    file = tmp_path / "record.csv"
    file.write_text(RECORD.format(head=head) + "\n".join(rows) + "\n")
    return file


def test_columns_of_a_record(tmp_path):
    plain = skyshine.mat.temperature("asphalt_road", forcing=record(tmp_path))
    rainy = skyshine.mat.temperature(
        "asphalt_road", forcing=record(tmp_path, ",rain", lambda hour: ",3" if hour in (9, 10) else ",0")
    )
    assert plain.film is None and rainy.film.max() == pytest.approx(0.48)
    assert (plain.temperature - rainy.temperature).max() > 4
    white = skyshine.mat.temperature("asphalt_road", forcing=record(tmp_path, ",albedo[%]", lambda hour: ",80"))
    assert plain.temperature.max() - white.temperature.max() > 15
    moist = skyshine.mat.temperature("soil_sand", forcing=record(tmp_path, ",soil_moisture[%]", lambda hour: ",12"))
    dry = skyshine.mat.temperature("soil_sand", forcing=record(tmp_path))
    assert np.ptp(moist.temperature) < np.ptp(dry.temperature) - 10


def test_rain_of_a_record_is_neither_lost_nor_made_where_rows_are_missing(tmp_path):
    """6 mm/h since the row three hours before are 18 mm, at 6 mm/h in each of three steps; the row after is dry."""
    file = record(tmp_path, ",rain", lambda hour: ",6" if hour == 12 else ",0")
    lines = file.read_text().splitlines()
    del lines[11:13]  # 10 and 11 h
    file.write_text("\n".join(lines) + "\n")
    rain = read_record(file).values["rain"]
    np.testing.assert_allclose(rain[[9, 10, 11, 12, 13]], [0, 6, 6, 6, 0], atol=1e-12)


def test_given_optics_of_a_wet_surface(tmp_path):
    """A roof of 0.3 is darker wet, by what Lekner and Dorf have for rough ground; leaves of 0.3 stay 0.3."""
    wet, dry = Wetting(rain=True), {"solar_absorptance": 0.3, "thermal_emissivity": None}
    road = surface_material("asphalt_road", {}, dry, wetting=wet)
    assert 0.35 < road.film.solar_absorptance < 0.6 and road.solar_absorptance == 0.3
    assert road.film.thermal_emissivity == surface_material("asphalt_road", {}, {}, wetting=wet).film.thermal_emissivity
    assert surface_material("grass_green", {}, dry, wetting=wet).film.solar_absorptance == 0.3
    both = {"solar_absorptance": 0.3, "thermal_emissivity": 0.2}
    file = resources.files("skyshine") / "materials" / "ht" / "asphalt_road.yaml"
    own = surface_material(file, {}, both, wetting=wet).film
    assert own.solar_absorptance == road.film.solar_absorptance and own.thermal_emissivity > 0.95


def test_a_fit_refuses_water_and_says_so(tmp_path):
    file = record(tmp_path, ",surface_temperature[C],rain", lambda hour: ",20,0")
    with pytest.raises(InputError, match="found the column rain; allowed: .*remove the column"):
        read_measured(file)


@pytest.mark.parametrize(
    ("head", "cell", "words", "line", "column"),
    [
        (",rain", ",-1", "rain: found '-1'; allowed: numbers from 0 to 2000 mm/h", 2, None),
        (",soil_moisture", ",1.2", "soil_moisture: found '1.2'", 2, None),
        (",albedo,snow_age", ",.8,3", "found albedo and snow_age; allowed: one of them", 1, 77),
        (",rain[in]", ",1", "found the unit 'in' of rain", 1, 70),
    ],
)
def test_impossible_columns_are_refused_at_their_place(tmp_path, head, cell, words, line, column):
    file = record(tmp_path, head, lambda hour: cell)
    with pytest.raises(InputError) as refused:
        skyshine.mat.temperature("snow_fine", forcing=file)
    assert words in str(refused.value) and refused.value.line == line
    assert column is None or refused.value.column == column


def test_water_of_a_job_is_refused_where_it_does_not_fit():
    with pytest.raises(InputError, match="rain_mm_h"):
        load_job(job({"rain_mm_h": [-1.0] * 24}))
    with pytest.raises(InputError, match="23 values of rain_mm_h"):
        load_job(job({"rain_mm_h": [1.0] * 23}))
