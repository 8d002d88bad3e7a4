"""The nodes of one axis: the closed-form error of linear interpolation of a parabola, twilight, angles that exist."""

import numpy as np
import pytest

from skyshine.mat.measure.axis_profile import AxisProfile
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.grid import PathGrid, ScatteringGrid
from skyshine.mat.quantities.results import AtmosphericQuantities

PLACES = np.linspace(0.0, 1.0, 257)
# Errors count as those of the value itself: a white surface seen through clear air.
PLAIN = Scale(1.0, 1.0, 1.0)


def profile(values, places=PLACES, counts=None, logarithmic=False):
    values = np.atleast_2d(values)
    ones = np.ones(values.shape)
    counts = ones.astype(bool) if counts is None else counts
    return AxisProfile("ambient_radiance", logarithmic, places, values, ones, ones, counts, PLAIN)


def test_a_straight_line_takes_the_ends_and_the_middle():
    nodes = profile(3 + 2 * PLACES).nodes(1e-6)
    assert nodes.tolist() == [0.0, 0.5, 1.0]


@pytest.mark.parametrize("cells", [4, 8, 16])
def test_cells_of_a_parabola_have_the_width_of_the_closed_form(cells):
    """x^2 between nodes h apart errs by at most h^2 / 4."""
    nodes = profile(1 + PLACES**2).nodes(0.25 / cells**2 * (1 + 1e-9))
    # One place in a hundred may be worse, so that a cell may be a little wider.
    assert cells + 1 - cells // 4 <= nodes.size <= cells + 1
    assert np.diff(nodes).max() < 1.45 / cells


def test_what_lies_behind_the_ground_asks_for_no_nodes():
    bent = 1 + 9 * np.abs(PLACES - 0.6)
    counts = (PLACES < 0.6)[None]
    assert profile(bent).nodes(1e-3).size > profile(bent, counts=counts).nodes(1e-3).size == 3


def test_equal_nodes_as_good_as_given_equal_ones_are_as_many():
    """The search grows by a quarter at a time, so it may pass the number by as much."""
    line = profile(1 + PLACES**2)
    assert 17 <= line.uniform(np.linspace(0.0, 1.0, 17)) <= 17 * 1.25 + 1


def test_equal_nodes_of_a_narrow_peak_are_many_more_than_placed_ones():
    peak = profile(1 + np.exp(-(((PLACES - 0.3) / 0.01) ** 2)))
    nodes = peak.nodes(0.02)
    assert peak.uniform(nodes) > 2 * nodes.size


def test_an_axis_of_one_node_stays_one():
    one = profile([[4.0]], places=np.array([2.0]))
    assert one.nodes(1e-9).tolist() == [2.0] and one.uniform(one.places) == 1


def quantities(grid, name):
    """beta* rises with range as its logarithm; path radiance is 1 at scattering angles that exist."""
    shape = grid.shape
    beta = 10 + np.log(grid.range_km)[:, None, None] + np.zeros(shape[:3])
    valid = np.broadcast_to(grid.elevation_deg >= -45, shape[:3])
    return AtmosphericQuantities(beta, np.ones(shape), np.ones(shape[:4]), np.ones(shape[:4]), valid, 0 * beta + 0.5)


AXES = ([0.1, 20.0], [0.0, 1.0], [-90.0, 0.0, 90.0], [-30.0, 20.0, 60.0], [0.0, 90.0, 180.0])


def test_a_profile_along_range_runs_over_its_logarithm_at_places_of_the_others():
    along = AxisProfile.of("beta_star", 0, quantities, PathGrid(*AXES), PLAIN, np.random.default_rng(1))
    assert along.logarithmic and (along.places[0], along.places[-1]) == pytest.approx((0.1, 20.0))
    np.testing.assert_allclose(along.values, np.broadcast_to(10 + np.log(along.places), along.values.shape))
    np.testing.assert_allclose(along.distance, np.broadcast_to(along.places, along.values.shape))
    # A quarter of the elevations looks below -45 degrees, where nothing counts.
    assert np.mean(along.counts) == pytest.approx(0.75, abs=0.1) and np.all(along.counts == along.counts[:, :1])


def test_source_elevations_lie_closest_in_twilight():
    along = AxisProfile.of("ambient_radiance", 3, quantities, PathGrid(*AXES), PLAIN, np.random.default_rng(1))
    steps, middle = np.diff(along.places), 0.5 * (along.places[1:] + along.places[:-1])
    twilight = (middle > -10) & (middle < 0)
    assert steps[twilight].max() < 0.3 < 2 < steps[~twilight].min()
    assert {-30.0, -10.0, 0.0, 20.0, 60.0} <= set(along.places.tolist())


def test_only_scattering_angles_count_that_some_azimuth_gives():
    """The source at elevation s lies between |e - s| and 180 - |e + s| from a line at e (triangle on the sphere)."""
    grid = ScatteringGrid(*AXES[:2], [-20.0, 30.0], [-30.0, 60.0], [0.0, 180.0])
    along = AxisProfile.of("path_radiance_ratio", 4, quantities, grid, PLAIN, np.random.default_rng(1))
    assert not np.any(along.counts[:, [0, -1]])  # neither 0 nor 180 degree but for equal or opposite elevations
    share = along.counts.mean(axis=1)
    assert np.all(share > 0) and np.all(share < 1)
    by_azimuth = PathGrid(*AXES[:2], [0.0, 30.0], [9.0, 60.0], [0.0, 180.0])
    whole = AxisProfile.of("path_radiance_ratio", 4, quantities, by_azimuth, PLAIN, np.random.default_rng(1))
    assert np.all(whole.counts)
