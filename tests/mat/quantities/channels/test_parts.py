"""Columns that stand for others: ranks that are known."""

import numpy as np
import pytest

from skyshine.mat.quantities.channels.parts import absorbers, fitted_parts, pivots


def test_columns_of_a_low_rank_come_back_from_as_many():
    generator = np.random.default_rng(1)
    values = generator.normal(size=(60, 3)) @ generator.normal(size=(3, 20))
    parts = fitted_parts(values, pivots(values)[:3])
    assert parts.count == 3
    assert values[:, parts.index] @ parts.factor.T == pytest.approx(values, abs=1e-4)


def test_the_first_pivot_is_the_largest_column():
    values = np.eye(3) * [1.0, 5.0, 2.0]
    assert pivots(values).tolist() == [1, 2, 0]


def test_weights_decide_which_rows_are_right():
    values = np.array([[1.0, 2.0], [1.0, 4.0]])
    weight = np.array([[1.0, 1.0], [1.0, 1e-6]])
    assert fitted_parts(values, np.array([0]), weight).factor[1, 0] == pytest.approx(2.0, rel=1e-6)


def test_gases_of_two_profiles_take_two_absorbers():
    generator = np.random.default_rng(2)
    amounts = generator.uniform(0.1, 10.0, size=(200, 2))
    sections = generator.uniform(0.0, 1.0, size=(2, 30))
    depth = amounts @ sections
    found = absorbers(depth, np.ones(200), np.ones(30), 1e-9)
    assert found.count == 4  # the least
    assert depth[:, found.index] @ found.factor.T == pytest.approx(depth, rel=1e-3)


def test_points_that_absorb_nothing_change_nothing():
    depth = np.column_stack([np.linspace(0.1, 2.0, 50), np.zeros(50), np.linspace(0.2, 4.0, 50)])
    found = absorbers(depth, np.ones(50), np.ones(3), 1e-9)
    assert depth[:, found.index] @ found.factor.T == pytest.approx(depth, abs=1e-6)


def test_no_path_of_the_sample_errs_far_more_than_the_others():
    """A few paths through other air among many hardly count in the root mean square."""
    generator = np.random.default_rng(4)
    gases = np.exp(generator.normal(size=(3, 30)))
    depth = generator.uniform(0.01, 0.3, (400, 3)) @ gases
    depth[[7, 90, 200, 333]] += 0.1 * np.exp(generator.normal(size=(4, 30)))
    chosen = absorbers(depth, np.ones(400), np.ones(30), 1e-3)
    found = np.exp(-np.maximum(depth[:, chosen.index] @ chosen.factor.T, 0.0)).mean(axis=1)
    assert np.abs(found - np.exp(-depth).mean(axis=1)).max() <= 5e-3
