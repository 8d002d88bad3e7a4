"""Random coordinates on an axis: inside it, every cell as likely as every other."""

import numpy as np
import pytest

from skyshine.mat.measure.sampling import random_coordinates


def test_every_cell_is_as_likely_whatever_its_width():
    nodes = np.array([0.0, 1.0, 10.0, 1000.0, 1000.5])
    places = random_coordinates(nodes, 40_000, np.random.default_rng(1))
    counts = np.histogram(places, nodes)[0]
    # Binomial: 10,000 with a standard deviation of 87.
    assert counts.sum() == 40_000 and counts == pytest.approx([10_000] * 4, abs=5 * 87)


def test_places_are_even_inside_a_cell():
    places = random_coordinates([2.0, 4.0], 40_000, np.random.default_rng(2))
    assert places.min() >= 2 and places.max() < 4
    # Moments of the uniform distribution: mean 3, variance 1/3.
    assert places.mean() == pytest.approx(3.0, abs=0.02) and places.var() == pytest.approx(1 / 3, abs=0.01)


def test_an_axis_of_one_node_gives_that_node():
    assert random_coordinates([7.5], 3, np.random.default_rng(3)).tolist() == [7.5] * 3
