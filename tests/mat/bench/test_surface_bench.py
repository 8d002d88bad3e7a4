"""Peers of surface temperatures: marching schemes against closed forms and the solver, the solver against the oracle,
EnergyPlus's input.
"""

from functools import lru_cache

import numpy as np
import pytest
from surface_oracle import solve_oracle

from skyshine.mat.api.examples import starter_files
from skyshine.mat.bench import energyplus
from skyshine.mat.bench.marching import Grid, march
from skyshine.mat.scene.surface import surface_inputs, surface_materials
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.sun_path import SUN_STEPS
from skyshine.materials.library import load_library
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

LAYERS = (Layer(0.05, 1.4, 2100.0, 880.0), Layer(0.05, 0.5, 1500.0, 1000.0))
DRY = SurfaceProperties(1e-3, 0.0, 0.0, False, False)
MATERIALS = (
    "soil_sand",
    "soil_loam_wet",
    "concrete",
    "asphalt_road",
    "wood_pine_weathered",
    "aluminium_weathered",
    "grass_green",
    "deciduous",
    "water_fresh",
)
PLANES = ((0.0, 0.0), (90.0, 90.0), (30.0, 180.0))  # slope, azimuth


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


def test_energyplus_is_asked_for_a_closed_prism():
    text = energyplus.model(4, 25, 0.4, walls=6)
    assert text.count("Wall, wall, inside, , Outdoors") == 6 and text.count("Roof") == 1
    assert "Timestep, 4;" in text and "0.4, MinimalShadowing, 25" in text


@pytest.fixture(scope="module")
def inputs():
    """Sun, weather and sky of the starter job."""
    (job,) = (file for file in starter_files() if file.name == "job.yaml")
    return surface_inputs(job)[1]


def forcing_between(forcing, column):
    """Forcing of one column at any times [s], linear between its own times of the day."""
    one = forcing.columns(np.array([column]))
    times = np.arange(forcing.shape[1]) * (86400.0 / forcing.shape[1])

    def forcing_at(seconds):
        series = {name: np.asarray(values, float) for name, values in one.given.items()}
        moving = {name for name, values in series.items() if values.shape[-1] > 1}
        at_times = {name: np.interp(seconds, times, series[name][0], period=86400.0)[None, :] for name in moving}
        return Forcing(**series | at_times)

    return forcing_at


def forcing_of(inputs):
    """Forcing of `PLANES` at the site by steps a day."""
    slope, azimuth = np.transpose(PLANES)
    return lru_cache(maxsize=None)(Scene(*inputs, np.array([inputs[0].altitude]), slope, azimuth).forcing)


def by_oracle(material, forcing, intervals, degree, cells):
    """The oracle's temperatures (planes, intervals), from midnight on."""
    columns = [forcing_between(forcing(SUN_STEPS), column) for column in range(len(PLANES))]
    ends = [solve_oracle(material, at, intervals=intervals, degree=degree, cells=cells).surface for at in columns]
    return np.roll(np.array(ends), 1, axis=1)


def test_forcing_between_the_times_of_a_day_is_linear_and_closes_over_midnight():
    forcing_at = forcing_between(day(24), 0)
    at = forcing_at(np.array([12.0, 12.5, 13.0, 23.5]) * 3600)
    sun, air = at.shortwave_direct[0], at.air_temperature[0]
    assert sun[0] == 700 and sun[1] == pytest.approx((sun[0] + sun[2]) / 2)
    assert air[3] == pytest.approx(290 + 3 * np.cos(8 * np.pi / 12) + 3 * np.cos(9 * np.pi / 12))


def test_the_oracle_and_the_solver_agree_on_a_wall_in_the_sun_of_the_starter_job(inputs):
    (material,) = surface_materials([load_library()["concrete"]])
    forcing = forcing_of(inputs)
    ((_, solution),) = (part for part in solve_columns(material, forcing, steps=192) if len(part[0]))
    reference = by_oracle(material, forcing, 96, 3, 12)
    assert np.abs(solution.temperature[:, ::2] - reference).max() < 0.1


@pytest.mark.validation  # 40 s a material
@pytest.mark.parametrize("name", MATERIALS)
def test_the_error_of_the_solver_falls_with_its_steps_to_that_of_the_oracle(inputs, name):
    """Level, on a wall and on a slope: an oracle that has another law than the solver ends the fall early.

    The oracle's error in cells falls with their square, so that it differs by its own error from a solution in
    1 / sqrt(2) of them.
    """
    (material,) = surface_materials([load_library()[name]])
    forcing = forcing_of(inputs)
    reference = by_oracle(material, forcing, SUN_STEPS, 3, 56)
    errors = {}
    for steps in (96, 192, 576):
        ((_, solution),) = solve_columns(material, forcing, steps=steps, fine_steps=None)
        errors[steps] = np.abs(solution.temperature - reference[:, :: 576 // steps]).max(axis=1)
    assert np.abs(by_oracle(material, forcing, SUN_STEPS, 2, 40) - reference).max() < 0.005
    assert np.all(errors[96] > 1.5 * errors[192]) and np.all(errors[192] > 1.5 * errors[576])
    assert errors[576].max() < 0.015
    ((_, sturdy),) = solve_columns(material, forcing, steps=96, fine_steps=None, scheme="bdf2")
    assert np.all(errors[96] < 0.9 * np.abs(sturdy.temperature - reference[:, ::6]).max(axis=1))
