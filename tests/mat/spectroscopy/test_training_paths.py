"""The atmospheres and paths on which spectral points are chosen."""

import numpy as np
import pytest

from skyshine.mat.spectroscopy.training import (
    HELD_OUT_PROFILE,
    TRAINING_PROFILES,
    held_out_states,
    training_states,
)
from skyshine.mat.surface.vapour import saturation_pressure


@pytest.fixture(scope="module")
def states():
    return training_states() + held_out_states()


def test_vertical_column_of_air(states):
    # Hydrostatic: p / (m g) = 101300 Pa / (28.96 u x 9.8 m s-2) = 2.15e29 molecules m-2, to the trapezoids' accuracy.
    assert states[0].columns[0].sum() == pytest.approx(2.15e29, rel=0.02)


def test_water_vapour_is_never_far_above_saturation(states):
    for state in states:
        limit = saturation_pressure(np.maximum(state.temperature, 200.0)) / state.pressure
        assert np.all(state.h2o_fraction <= limit * 1.0001)


def test_paths_are_finite_positive_and_varied(states):
    for state in states:
        assert np.all(np.isfinite(state.columns)) and state.columns.min() >= 0
        assert np.all(state.columns.sum(axis=1) > 0)
        for slabs in state.emission:
            assert np.all(slabs.sum(axis=1) > 0)
    totals = np.concatenate([state.columns.sum(axis=1) for state in states])
    assert totals.max() / totals.min() > 1e5


def test_the_held_out_profile_is_not_trained_on():
    assert HELD_OUT_PROFILE not in TRAINING_PROFILES


def test_states_repeat():
    for one, two in zip(training_states(perturbed=1), training_states(perturbed=1), strict=True):
        np.testing.assert_array_equal(one.columns, two.columns)
        np.testing.assert_array_equal(one.temperature, two.temperature)
