"""The bench of surface temperatures: its marching schemes against closed forms and the solver, its peer's input."""

import numpy as np
import pytest

from mat.maintain.bench import energyplus
from mat.maintain.bench import surface_ladder as bench
from mat.maintain.bench.surface_ladder import Case, batch_planes, case_of, forcing_between, measured
from skyshine.mat.api.examples import starter_files
from skyshine.mat.bench.marching import Grid, march
from skyshine.mat.scene.surface import surface_inputs, surface_materials
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.library import load_library
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

LAYERS = (Layer(0.05, 1.4, 2100.0, 880.0), Layer(0.05, 0.5, 1500.0, 1000.0))
DRY = SurfaceProperties(1e-3, 0.0, 0.0, False, False)


def wall(back):
    return SurfaceMaterial("wall", ThermalStack(Layer(2e-3, 1.4, 2100.0, 880.0), LAYERS, back), DRY, 0.7, 0.9)


def day(steps):
    hours = np.arange(steps) * 24.0 / steps
    sun = 700 * np.maximum(np.cos(np.pi * (hours - 12) / 14), 0) * (np.abs(hours - 12) < 7)
    air = 290 + 6 * np.cos(np.pi * (hours - 15) / 12)
    rows = [sun, 0 * sun, 0 * sun, 0 * sun + 300, 0 * sun, air, 0 * sun + 900, 0 * sun + 1e5, 0 * sun + 2]
    return Forcing(*(row[None, :] for row in rows), cos_slope=np.array([[1.0]]))


def test_grid_keeps_capacity_and_resistance():
    grid = Grid.of(wall(Back("convective", 293.0, 8.0)), 7)
    assert grid.capacity.sum() == pytest.approx(2e-3 * 2100 * 880 + 0.05 * 2100 * 880 + 0.05 * 1500 * 1000)
    assert (1 / grid.conductance).sum() == pytest.approx(0.05 / 1.4 + 0.05 / 0.5 + 1 / 8)
    assert grid.exchange.sum(axis=1) == pytest.approx([0] * 14 + [grid.conductance[-1]], abs=1e-9)


@pytest.mark.parametrize("theta, limit", [(1.0, 0.4), (0.5, 0.15)])
def test_marching_comes_to_the_periodic_solution(theta, limit):
    chosen = wall(Back("convective", 293.0, 8.0))
    found = march(chosen, day(288), 288, 8, 10, theta)
    ((_, exact),) = solve_columns(chosen, day, steps=288)
    assert np.abs(found - exact.temperature).max() < limit


def test_explicit_steps_are_stable_where_the_grid_says():
    chosen = wall(Back("adiabatic"))
    steps = Grid.of(chosen, 3).explicit_steps
    found = march(chosen, day(96), steps, 12, 3, 0.0)
    ((_, exact),) = solve_columns(chosen, day, steps=96)
    assert np.abs(found[:, :: steps // 96] - exact.temperature).max() < 1.5


def test_energyplus_is_asked_for_a_closed_prism():
    text = energyplus.model(1, walls=6)
    assert text.count("Wall, wall, inside, , Outdoors") == 6 and text.count("Roof") == 1
    assert "6, 21, 2017, 6, 21, 2017" in text and "12, 31, 2017" in energyplus.model(energyplus.YEAR)


@pytest.fixture(scope="module")
def inputs():
    """Sun, weather and sky of the starter job."""
    (job,) = (file for file in starter_files() if file.name == "job.yaml")
    return surface_inputs(job)[1]


def test_forcing_between_the_times_of_a_day_is_linear_and_closes_over_midnight():
    forcing_at = forcing_between(day(24), 0)
    at = forcing_at(np.array([12.0, 12.5, 13.0, 23.5]) * 3600)
    sun, air = at.shortwave_direct[0], at.air_temperature[0]
    assert sun[0] == 700 and sun[1] == pytest.approx((sun[0] + sun[2]) / 2)
    assert air[3] == pytest.approx(290 + 3 * np.cos(8 * np.pi / 12) + 3 * np.cos(9 * np.pi / 12))


def test_the_oracle_and_the_solver_agree_on_a_wall_in_the_sun_of_the_starter_job(inputs):
    (material,) = surface_materials([load_library()["concrete"]])
    case = case_of(material, inputs, intervals=96, cells=12)
    ((_, solution),) = (part for part in solve_columns(material, case.oracle_forcing, steps=192) if len(part[0]))
    every = case.reference.shape[1] // 96
    assert np.abs(solution.temperature[:, ::2] - case.reference[:, ::every]).max() < 0.1
    assert case.oracle_seconds > 0


@pytest.mark.validation  # 40 s a material
@pytest.mark.parametrize("name", bench.MATERIALS)
def test_the_error_of_the_solver_falls_with_its_steps_to_that_of_the_oracle(inputs, name):
    """Level, on a wall and on a slope: an oracle that has another law than the solver ends the fall early."""
    (material,) = surface_materials([load_library()[name]])
    case = case_of(material, inputs)
    errors = {}
    for steps in (96, 192, 576):
        ((_, solution),) = solve_columns(material, case.oracle_forcing, steps=steps, fine_steps=None)
        errors[steps] = np.abs(solution.temperature - case.reference[:, :: 576 // steps]).max(axis=1)
    assert np.abs(case.reference_error).max() < 0.005
    assert np.all(errors[96] > 1.5 * errors[192]) and np.all(errors[192] > 2 * errors[576])
    assert errors[576].max() < 0.015
    ((_, sturdy),) = solve_columns(material, case.oracle_forcing, steps=96, fine_steps=None, scheme="bdf2")
    assert np.all(errors[96] < 0.9 * np.abs(sturdy.temperature - case.reference[:, ::6]).max(axis=1))


def test_an_error_that_is_planted_is_the_error_that_is_measured(inputs):
    """A method 2 K too warm at every time errs by 2 K, whatever steps it gives."""
    (material,) = surface_materials([load_library()["concrete"]])
    reference = np.full((2, 96), 290.0)
    case = Case(material, lambda steps: day(steps), lambda steps: day(steps), reference, 0.0 * reference, 1.0)
    calls = []
    rung = measured("warm", "marching", lambda material, forcing: np.full((2, 48), 292.0), [case], calls.append)
    assert rung.rms == rung.largest == 2.0 and calls == [1] and rung.columns == len(batch_planes())
