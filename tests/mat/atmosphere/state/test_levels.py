"""Levels of a state: from the ground to the top, fine where the air changes, and interpolation between them."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.state.levels import TOP, exponential, level_altitudes, linear
from skyshine.mat.atmosphere.state.profiles import Profile

NODES = np.array([0.0, 1.0, 3.0])


def profile(altitude, temperature, water=None):
    altitude = np.array(altitude, float)
    water = np.full(altitude.size, 1e-3) if water is None else np.array(water)
    pressure = 101325.0 * np.exp(-altitude / 8e3)
    return Profile("made", altitude, pressure, np.array(temperature, float), {"H2O": water})


# A lapse of 6.5 K per km is one straight line: the profile asks for no level of its own.
PLAIN = profile([0.0, 10e3, 100e3], [288.0, 223.0, 223.0])


def test_linear_goes_on_below_and_stays_above():
    found = linear([-1.0, 0.0, 0.5, 2.0, 3.0, 9.0], NODES, np.array([10.0, 20.0, 0.0]))
    assert found == pytest.approx([0.0, 10.0, 15.0, 10.0, 0.0, 0.0])


def test_exponential_halves_in_equal_steps_and_keeps_nothing():
    found = exponential([-1.0, 0.5, 1.0, 2.0], NODES, np.array([16.0, 4.0, 1.0]))
    assert found == pytest.approx([64.0, 8.0, 4.0, 2.0])
    assert exponential([0.0, 2.0], NODES, np.array([5.0, 0.0, 0.0]))[1] == 0.0


@pytest.mark.parametrize("ground", [-430.0, 0.0, 137.0, 2950.0, 5300.0])
def test_levels_run_from_the_ground_to_the_top_without_gaps(ground):
    levels = level_altitudes(ground, PLAIN)
    assert levels[0] == ground and levels[-1] == TOP
    steps = np.diff(levels)
    assert steps.min() > 0 and steps[levels[:-1] < ground + 2.9e3].max() <= 250.0 + 1e-9
    assert steps[levels[:-1] < 11.9e3].max() <= 500.0 + 1e-9 and steps.max() <= 10e3 + 1e-9


def test_edges_are_levels_and_no_level_stands_close_by():
    levels = level_altitudes(0.0, PLAIN, edges=[510.0, 1375.0, 200e3, -5.0])
    assert {510.0, 1375.0} <= set(levels.tolist()) and 200e3 not in levels and levels[0] == 0.0
    assert 500.0 not in levels  # 10 m from an edge: it gives way
    ends = level_altitudes(0.0, PLAIN, edges=[20.0, TOP - 20.0])
    assert ends[:2].tolist() == [0.0, 20.0] and ends[-2:].tolist() == [TOP - 20.0, TOP]


def test_an_inversion_between_the_levels_is_followed_within_half_a_kelvin():
    sharp = profile([0.0, 600.0, 660.0, 720.0, 10e3, 100e3], [288.0, 284.1, 294.0, 293.8, 223.0, 223.0])
    levels = level_altitudes(0.0, sharp)
    plain = level_altitudes(0.0, PLAIN)
    assert levels.size > plain.size
    read = np.interp(sharp.altitude, levels, linear(levels, sharp.altitude, sharp.temperature))
    assert np.abs(read - sharp.temperature).max() <= 0.5
    missed = np.interp(sharp.altitude, plain, linear(plain, sharp.altitude, sharp.temperature))
    assert np.abs(missed - sharp.temperature).max() > 3


@pytest.mark.parametrize("apart", [2.0, 10.0, 20.0, 39.0])
def test_levels_of_a_sounding_close_to_each_other_do_not_push_one_another_out(apart):
    """An inversion of 9 K within a few metres, as radiosondes find above stratus."""
    base = 615.0
    altitude = [0.0, base, base + apart, base + 2 * apart, base + 3 * apart, 2e3, 10e3, 100e3]
    sharp = profile(altitude, [288.0, 284.0, 289.0, 293.0, 292.8, 284.0, 223.0, 223.0])
    levels = level_altitudes(0.0, sharp)
    read = np.interp(sharp.altitude, levels, linear(levels, sharp.altitude, sharp.temperature))
    assert np.abs(read - sharp.temperature).max() <= 0.5
    assert set(levels) <= {*level_altitudes(0.0, PLAIN), *altitude}


@pytest.mark.parametrize("ground", [0.0, 370.0, 2100.0])
def test_levels_of_random_soundings_follow_them_within_half_a_kelvin(ground):
    generator = np.random.default_rng(3)
    for _ in range(20):
        altitude = np.concatenate([[0.0], np.cumsum(generator.choice([5.0, 30.0, 300.0, 900.0], 25)), [60e3, 100e3]])
        sharp = profile(altitude, 288.0 - 2e-3 * altitude.clip(0, 20e3) + generator.normal(0, 2.0, altitude.size))
        levels = level_altitudes(ground, sharp)
        inside = (altitude > ground) & (altitude < 20e3)
        read = np.interp(altitude, levels, linear(levels, altitude, sharp.temperature))
        assert np.abs(read - sharp.temperature)[inside].max() <= 0.5 and np.all(np.diff(levels) > 0)


def test_a_dry_layer_is_followed_within_a_tenth():
    water = [1e-2, 8e-3, 1e-3, 8e-3, 1e-5, 1e-6]
    dry = profile([0.0, 3600.0, 3700.0, 3800.0, 10e3, 100e3], [288.0, 264.6, 263.95, 263.3, 223.0, 223.0], water)
    levels = level_altitudes(0.0, dry)
    read = np.interp(dry.altitude, levels, linear(levels, dry.altitude, np.log(water)))
    assert np.abs(read - np.log(water))[dry.altitude < 20e3].max() <= 0.1 < np.log(8)
