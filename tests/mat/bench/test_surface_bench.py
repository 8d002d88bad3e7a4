"""The bench of surface temperatures: its marching schemes against closed forms and the solver, its peer's input."""

import numpy as np
import pytest

from skyshine.mat.bench import energyplus
from skyshine.mat.bench.marching import Grid, march
from skyshine.mat.surface.balance import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
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
