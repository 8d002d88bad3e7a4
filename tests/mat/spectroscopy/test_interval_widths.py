"""Intervals of the band model by wavenumber."""

import numpy as np
import pytest

from skyshine.mat.spectroscopy.widths import interval_edges, max_points
from skyshine.schemas.errors import InputError


def test_intervals_tile_everything_from_10_to_33400():
    edges = interval_edges(10, 33400)
    assert edges[0, 0] == 10 and edges[-1, 1] == 33400
    np.testing.assert_array_equal(edges[1:, 0], edges[:-1, 1])
    assert np.diff(edges, axis=1).min() == 5 and np.diff(edges, axis=1).max() == 100


def test_a_range_is_widened_to_whole_intervals():
    np.testing.assert_array_equal(interval_edges(1001, 1006), [[1000, 1005], [1005, 1010]])
    np.testing.assert_array_equal(interval_edges(4996, 5001), [[4995, 5000], [5000, 5020]])
    assert max_points(5000.0) < max_points(4995.0)


@pytest.mark.parametrize(
    "low, high, message", [(800, 750, "no range"), (5, 20, "not within"), (33000, 40000, "not within")]
)
def test_ranges_that_cannot_be_are_refused(low, high, message):
    with pytest.raises(InputError, match=message):
        interval_edges(low, high)
