"""Cells of weather: which states of a job share the points of their bands, and for which airs these are chosen."""

from itertools import pairwise

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.air_cells import HUMIDITIES, TEMPERATURES, air_cell, airs_of_cell, shared_cell, shared_cells
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.materials.library import load_library

BAND = SpectralResponse.rectangular(10.0, 10.2)


def day(low, high, humidity=60, **keys):
    weather = {"air_temperature_c": [low, high], "relative_humidity_percent": humidity}
    return {"profile": "midlatitude_summer", "weather": weather, **keys}


@pytest.fixture
def job_of(tmp_path):
    def of(*states):
        job = {
            "skyshine": 1,
            "name": "cells",
            "site": {"latitude_deg": 50, "longitude_deg": 10, "date": "2026-06-28", "utc_offset_h": 1},
            "states": list(states),
            "bands": [{"wavelength_um": [10.0, 10.2]}],
            "materials": ["asphalt_road"],
        }
        return load_job(job, folder=tmp_path).requested

    return of


def test_days_of_like_weather_share_a_cell_and_a_day_alone_has_none(job_of):
    job = job_of(day(12, 20), day(14, 24), day(-4, 0))
    first, second, third = job.states
    assert shared_cell(job, first) == shared_cell(job, second) == air_cell(job.site, first)
    assert shared_cell(job, third) is None and air_cell(job.site, third) is not None
    assert shared_cells(job) == [shared_cell(job, state) for state in job.states]


def test_the_same_air_twice_is_one_air(job_of):
    job = job_of(day(12, 20), day(12, 20, date="2026-06-29"))
    assert shared_cells(job) == [None, None]


def test_a_cell_does_not_depend_on_the_other_states_in_it(job_of):
    few, many = job_of(day(12, 20), day(14, 24)), job_of(day(8, 12), day(12, 20), day(20, 26), day(14, 24))
    state = few.states[0]
    assert shared_cell(few, state) == shared_cell(many, state)
    for one, other in zip(
        airs_of_cell(few.site, state, shared_cell(few, state), BAND, load_library()).corners,
        airs_of_cell(many.site, many.states[3], shared_cell(many, state), BAND, load_library()).corners,
        strict=True,
    ):
        assert np.array_equal(one.temperature, other.temperature)
        assert np.array_equal(one.mole_fraction["H2O"], other.mole_fraction["H2O"])


def test_what_else_the_air_follows_from_separates_cells(job_of):
    plain = day(12, 20)
    changes = [
        {"profile": "tropical"},
        {"visibility_km": 5},
        {"co2_ppm": 500},
        {"aerosol": "urban"},
        {"ground_material": "grass_green"},
    ]
    job = job_of(plain, *(plain | change for change in changes))
    cells = [air_cell(job.site, state) for state in job.states]
    assert len(set(cells)) == len(cells)
    assert shared_cells(job) == [None] * len(cells)


def test_air_that_does_not_follow_the_weather_or_lies_outside_has_no_cell(job_of):
    job = job_of(
        day(12, 20, air="profile"),
        day(12, 20, humidity=0),
        day(-80, -76),
        day(12, 20, humidity_scale=2.0),
    )
    assert [air_cell(job.site, state) for state in job.states] == [None] * 4


def test_times_of_a_day_share_the_cell_of_its_mean(job_of):
    job = job_of(day(12, 24, air_times=["04:00", "14:00"]))
    assert len(job.states) == 2
    first, second = shared_cells(job)
    assert first == second is not None


def test_blends_of_profiles_that_change_with_the_date_share_a_cell(job_of):
    days = [day(12, 20, date=f"2026-06-{number:02d}") for number in (1, 20)]
    for state in days:
        del state["profile"]
    job = job_of(*days)
    assert job.states[0].profile != job.states[1].profile
    assert shared_cells(job)[0] is not None and len(set(shared_cells(job))) == 1


@pytest.mark.parametrize(("low", "high", "humidity"), [(12, 20, 60), (-5, 1, 95), (28, 38, 15)])
def test_the_corners_enclose_temperature_and_vapour_of_the_states_of_a_cell(job_of, low, high, humidity):
    job = job_of(day(low, high, humidity), day(low + 1, high + 1, humidity))
    state = job.states[0]
    cell = shared_cell(job, state)
    assert cell.temperature in pairwise(TEMPERATURES)
    assert cell.humidity in pairwise(HUMIDITIES)
    own = atmospheric_state(job.site, state)
    airs = airs_of_cell(job.site, state, cell, BAND, load_library())
    kelvin, inside = ([air.temperature[0] for air in part] for part in (airs.corners, airs.inside))
    vapour = [corner.mole_fraction["H2O"][0] * corner.pressure[0] for corner in airs.corners]
    assert len(kelvin) == 4 and min(kelvin) < min(inside) < max(inside) < max(kelvin)
    assert min(kelvin) == pytest.approx(cell.temperature[0]) and max(kelvin) == pytest.approx(cell.temperature[1])
    assert min(kelvin) <= own.temperature[0] <= max(kelvin)
    assert min(vapour) <= own.mole_fraction["H2O"][0] * own.pressure[0] <= max(vapour)
