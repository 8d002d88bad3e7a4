"""Temperatures between the solver's times: Akima's cubic against scipy's, and what a step leaves alone."""

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator

from skyshine.mat.surface.reading import at_hours_of_day, in_steps

STEPS = 48


def test_random_days_are_read_as_by_scipy():
    values = np.random.default_rng(1).uniform(280, 310, (4, STEPS))
    hours = np.random.default_rng(2).uniform(0, 24, 100)
    times = np.arange(-STEPS, 2 * STEPS) * (24 / STEPS)
    exact = Akima1DInterpolator(times, np.tile(values, 3), axis=1)(hours)
    assert at_hours_of_day(values, hours) == pytest.approx(exact, abs=1e-10)
    single = at_hours_of_day(values.astype(np.float32), hours)
    assert single.dtype == np.float32 and single == pytest.approx(exact, abs=2e-3)


def test_a_smooth_day_is_read_far_better_than_by_lines():
    def day(hours):
        return 290 + 9 * np.cos(2 * np.pi * hours / 24) + 2 * np.sin(4 * np.pi * hours / 24)

    hours, times = np.linspace(0, 24, 321), np.arange(STEPS) * 24 / STEPS
    read = at_hours_of_day(day(times)[None], hours)[0]
    lines = np.interp(hours, times, day(times), period=24)
    assert np.abs(read - day(hours)).max() < 0.15 * np.abs(lines - day(hours)).max()


def test_a_jump_bends_its_neighbours_alone_and_what_is_level_stays_level():
    values = np.where(np.arange(STEPS) < 20, 280.0, 300.0)[None]
    fine = in_steps(values, 6 * STEPS)[0]
    assert fine.min() == 280.0 and fine.max() == 300.0
    assert np.all(fine[: 19 * 6] == 280.0) and np.all(fine[20 * 6 : 47 * 6] == 300.0)


def test_at_the_solver_s_own_times_values_are_as_they_are_in_every_day():
    values = np.random.default_rng(3).uniform(280, 310, (2, STEPS))
    assert np.array_equal(at_hours_of_day(values, np.array([0.0, 24.0, 12.5, 36.5])), values[:, [0, 0, 25, 25]])
