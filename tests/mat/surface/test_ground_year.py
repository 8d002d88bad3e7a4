"""The annual wave in the ground: textbook depths, planted harmonics, and backs of ground that follow it."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.back_boundary import back_drive
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.ground_year import (
    YEAR,
    GroundSeason,
    annual_harmonic,
    damping,
    damping_depths,
    spans_year,
)
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError


def test_damping_depth_is_that_of_a_textbook():
    """Hillel (1998), Environmental Soil Physics, chapter 12: 10 cm for the day are 1.9 m for the year, by sqrt(365)."""
    diffusivity = 0.1**2 * np.pi / 86400.0  # of a daily damping depth of 10 cm
    assert 1 / damping(1.0, diffusivity) == pytest.approx(1.91, abs=0.01)


def test_a_damping_depth_weakens_and_delays_the_wave():
    season = GroundSeason(10.0, 8.0, np.linspace(0, YEAR, 36526))
    wave = season.below(1.0)
    assert np.ptp(wave) == pytest.approx(16.0 / np.e, rel=1e-6)
    assert season.since_coldest[np.argmin(wave)] == pytest.approx(YEAR / (2 * np.pi), abs=0.01)  # 58 days
    assert GroundSeason(10.0, 8.0, 0.0).below(0.0) == pytest.approx(2.0)
    assert GroundSeason(10.0, 8.0, 0.0).below(50.0) == pytest.approx(10.0)


@pytest.mark.parametrize("coldest", [1.5, 22.0, 197.0, 365.9])
def test_a_planted_harmonic_comes_back_from_hours_with_a_daily_wave(coldest):
    day = 1 + np.arange(8766) / 24
    celsius = 9.0 - 7.0 * np.cos(2 * np.pi * (day - coldest) / YEAR) + 5 * np.sin(2 * np.pi * day)
    celsius[1000:1100] = np.nan
    mean, amplitude, found = annual_harmonic(day, celsius)
    assert (mean, amplitude) == (pytest.approx(9.0, abs=0.01), pytest.approx(7.0, abs=0.01))
    assert (found - coldest + YEAR / 2) % YEAR - YEAR / 2 == pytest.approx(0.0, abs=0.2)
    assert 1 <= found < YEAR + 1


def test_a_part_of_the_year_has_no_harmonic():
    assert not spans_year(np.arange(1.0, 320.0)) and spans_year(np.arange(1.0, 366.0))
    with pytest.raises(InputError, match="found temperatures of a part of the year; allowed: of all its twelfths"):
        annual_harmonic(np.arange(1.0, 320.0), np.zeros(319))


@pytest.fixture
def scene(sun_path, weather, sky):
    return Scene(sun_path, weather, sky, np.array([0.0, 1000.0]), np.array([0.0, 30.0]), np.zeros(2))


def surface(name):
    (found,) = surface_materials([load_library()[name]])
    return found


def test_backs_of_ground_follow_the_season_and_the_altitude(scene):
    soil = surface("soil_loam_brown")
    season = GroundSeason(285.0, 9.0, 120.0)
    warm = replace(scene, weather=replace(scene.weather, ground=season))
    drive = back_drive(soil, warm.forcing(24), np.arange(24.0))
    want = season.below(damping_depths(soil.thermal)) - 6.5 * (np.array([0, 0, 1, 1]) - scene.weather.altitude / 1e3)
    assert drive[:, 0] == pytest.approx(want)
    of_air = back_drive(soil, scene.forcing(24), np.arange(24.0))
    assert of_air[0, 0] == pytest.approx(scene.forcing(24).air_temperature[0].mean())


def test_a_back_that_is_given_does_not_follow_the_season(scene):
    wall = surface("brick_red")
    warm = replace(scene, weather=replace(scene.weather, ground=GroundSeason(285.0, 9.0, 120.0)))
    assert np.array_equal(*(back_drive(wall, each.forcing(24), np.arange(24.0)) for each in (scene, warm)))


def test_colder_ground_makes_a_colder_surface_by_what_the_stack_conducts(scene):
    """Per kelvin at 1 m under soil of conductance G, beside a loss of some 15 W/m2/K: G / (G + 15)."""
    soil = surface("soil_loam_brown")
    surfaces = []
    for mean in (285.0, 275.0):
        cold = replace(scene, weather=replace(scene.weather, ground=GroundSeason(mean, 0.0, 0.0)))
        ((_, solution),) = solve_columns(soil, cold.forcing)
        surfaces.append(solution.temperature[0].mean())
    conductance = 1 / sum(layer.thickness / layer.conductivity for layer in soil.thermal.layers)
    assert surfaces[0] - surfaces[1] == pytest.approx(10 * conductance / (conductance + 15), rel=0.5)
