"""The last of consecutive days against a record that repeats, a finite-volume march, and a day that repeats."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.bench.marching import march
from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface import solver
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction, delayed_responses
from skyshine.mat.surface.days import OneDay, solve_days
from skyshine.mat.surface.solution import Method
from skyshine.mat.surface.solver import DAY, TOLERANCE, solve_columns
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

# Mean air temperature [K], sunlight at noon [W m^-2], wind [m/s] of days as unlike as April has them.
APRIL = [(293.0, 800.0, 2.0), (281.0, 200.0, 6.0), (285.0, 600.0, 1.0), (297.0, 850.0, 3.0), (283.0, 150.0, 5.0)]


def library(name):
    return surface_materials([load_library()[name]])[0]


def a_day(mean, noon, wind):
    """Two columns, the second with less sunlight."""

    def forcing(steps):
        hours = 24.0 * np.arange(steps) / steps
        even = np.ones((2, steps))
        sun = np.maximum(np.sin(np.pi * (hours - 6) / 12), 0.0)
        air = mean + 5.0 * np.sin(np.pi * (hours - 9) / 12)
        values = {
            "shortwave_direct": noon * sun * np.array([[1.0], [0.4]]),
            "shortwave_diffuse": 60.0 * sun * even,
            "shortwave_reflected": 0.0 * even,
            "longwave_sky": (300.0 + 4.0 * (mean - 288.0)) * even,
            "longwave_ground": 0.0 * even,
            "air_temperature": air * even,
            "vapour_pressure": 800.0 * even,
            "pressure": 1e5 * even,
            "wind_speed": wind * even,
        }
        return Forcing(**values, cos_slope=np.ones((2, 1)))

    return forcing


DAYS = [a_day(*of_day) for of_day in APRIL]


def last_day(material, days, **options):
    ((_, solution),) = solve_days(material, days, **options)
    return solution


def joined(days, steps):
    parts = [day(steps) for day in days]
    return Forcing(
        **{
            name: np.concatenate([np.broadcast_to(getattr(part, name), (2, steps)) for part in parts], axis=1)
            for name in parts[0].given
        }
    )


@pytest.mark.parametrize("name", ["concrete", "grass_green", "steel_bare", "water_fresh", "wood_pine"])
def test_a_record_that_goes_round_ends_as_one_that_repeats(name):
    material = library(name)
    steps = 192
    ((_, record),) = solve_columns(
        material,
        lambda _: joined(DAYS, steps),
        steps=steps * len(DAYS),
        fine_steps=None,
        period=DAY * len(DAYS),
        scheme="bdf2",
    )
    solution = last_day(material, DAYS * 5)
    assert solution.temperature == pytest.approx(record.temperature[:, -steps:], abs=2e-3)
    assert np.all(solution.bound_excess == 0) and np.all(np.abs(solution.energy_closure) < TOLERANCE)


def test_a_march_in_finite_volumes_ends_alike():
    """The march knows one day: here that day is the whole record, of layers that store so much less."""
    material, steps = library("concrete"), 288
    days = [DAYS[0]] * 10 + DAYS  # the march begins at the mean air
    thermal = material.thermal

    def slower(layer):
        return replace(layer, heat_capacity=layer.heat_capacity / len(days))

    stack = replace(thermal, skin=slower(thermal.skin), layers=tuple(slower(layer) for layer in thermal.layers))
    marched = march(replace(material, thermal=stack), joined(days, steps), steps * len(days), 1, 120, 1.0)
    difference = np.abs(last_day(material, days, steps=steps).temperature - marched[:, -steps:])
    # The weather jumps at midnight, where the march, of first order, is half a step late.
    assert np.quantile(difference, 0.98) < 0.08 and difference[:, 12:].max() < 0.08


def test_one_day_and_the_same_days_repeat():
    material = library("asphalt_road")
    ((_, periodic),) = solve_columns(material, DAYS[0])
    assert np.array_equal(last_day(material, DAYS[:1]).temperature, periodic.temperature)
    ((_, periodic),) = solve_columns(material, DAYS[0], steps=192, scheme="bdf2")
    assert last_day(material, [DAYS[0]] * 4).temperature == pytest.approx(periodic.temperature, abs=1e-3)


def test_yesterday_counts_by_kelvin_and_last_week_by_tenths():
    """Half a metre of concrete remembers a day at its surface to a tenth, and a fortnight to hundredths."""
    material = library("concrete")
    warm, cold = DAYS[3], DAYS[1]
    today = last_day(material, [cold, cold, cold]).temperature
    after_one = last_day(material, [cold, warm, cold]).temperature - today
    after_week = last_day(material, [cold, warm, *[cold] * 7]).temperature - today
    assert after_one[0, 0] > 4.0 and 0.3 < after_one[0, -1] < 3.0
    assert np.all(after_week >= -1e-3) and after_week.max() < 0.1 * after_one.max()


def test_delayed_responses_add_up_to_the_periodic_matrix():
    material = library("concrete")
    for scheme in ("bdf2", "euler"):
        periodic = Conduction(material.thermal, 96, DAY, scheme)
        responses = delayed_responses(material.thermal, DAY / 96, 96 * 60, scheme)
        for response, matrix in zip(responses, (periodic.matrix, periodic.back_matrix), strict=True):
            assert response.reshape(60, 96).sum(axis=0) == pytest.approx(matrix[:, 0], abs=1e-6)
    one = OneDay(material.thermal, 96, DAY)
    assert np.array_equal(np.triu(one.matrix, 1), np.zeros((96, 96)))
    step = np.where(np.arange(96) >= 40, 1.0, 0.0)[None]
    assert np.all(one.flux(step)[0, :40] == 0) and one.flux(step)[0, 40] > 0
    assert one.mean_flux(step) == pytest.approx(one.flux(step).mean(axis=1))


def test_snow_that_melted_yesterday_is_at_its_melting_point_no_longer_than_its_heat():
    solution = last_day(library("snow_medium"), [DAYS[0], DAYS[1]])
    assert np.all(solution.temperature <= 273.15 + 1e-9) and np.all(solution.residual <= TOLERANCE)


def test_what_breaks_its_bounds_is_solved_again_through_all_days(monkeypatch):
    monkeypatch.setattr(solver, "BOUND_TOLERANCE", -1.0)
    material = library("concrete")
    euler = last_day(material, DAYS)
    monkeypatch.undo()
    assert np.all(euler.method == Method.EULER)
    assert euler.temperature == pytest.approx(last_day(material, DAYS).temperature, abs=0.6)


def test_a_day_with_bad_numbers_is_named_before_anything_is_solved():
    def nothing(steps):
        forcing = DAYS[0](steps)
        return Forcing(**{name: np.full_like(values, np.nan) for name, values in forcing.given.items()})

    with pytest.raises(InputError, match="found shortwave_direct = nan"):
        solve_days(library("concrete"), [nothing, DAYS[1]])
