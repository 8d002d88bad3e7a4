"""Nodes where the error is, against what is known of linear interpolation."""

import numpy as np
import pytest

from skyshine.mat.measure.surface_nodes import fewest_nodes, meets, read_temperature, refined_axes
from skyshine.schemas.errors import CheckFailed


def chord_error(places, values):
    def error(start, end):
        share = (places[start + 1 : end] - places[start]) / (places[end] - places[start])
        return values[start] * (1 - share) + values[end] * share - values[start + 1 : end]

    return error


def test_parabola_takes_as_many_cells_as_theory_says():
    """Linear interpolation of x^2 with cells of width h is wrong by h^2 / 4: 25 cells of 0.04 for 4e-4."""
    x = np.linspace(0.0, 1.0, 2001)
    nodes = fewest_nodes(x, chord_error(x, x**2), 2e-4)  # all but 1 % within it, none beyond twice
    widths = np.diff(x[nodes])
    assert np.all(widths <= 2 * np.sqrt(4e-4) + 1e-9)
    assert 25 <= len(widths) <= 36


def test_straight_line_takes_its_ends_alone():
    x = np.linspace(-3.0, 5.0, 100)
    assert list(fewest_nodes(x, chord_error(x, 2 * x + 1), 1e-9)) == [0, 99]


def test_kink_gets_a_node_beside_it():
    x = np.linspace(0.0, 1.0, 1001)
    nodes = x[fewest_nodes(x, chord_error(x, np.abs(x - 0.3)), 1e-3)]
    assert len(nodes) <= 5 and np.abs(nodes - 0.3).min() <= 0.005


def test_a_step_is_closed_in_and_refused_by_none():
    """Between neighbouring candidates nothing can be done: the step ends up there."""
    x = np.linspace(0.0, 1.0, 101)
    nodes = fewest_nodes(x, chord_error(x, np.where(x < 0.505, 0.0, 10.0)), 0.1)
    assert {50, 51} <= set(nodes) and len(nodes) <= 5


def test_holds_allows_one_in_a_hundred_up_to_twice():
    assert meets(np.array([0.0] * 99 + [1.9]), 1.0)
    assert not meets(np.array([0.0] * 99 + [2.1]), 1.0)
    assert not meets(np.array([0.0] * 98 + [1.5] * 2), 1.0)
    assert meets(np.array([np.nan]), 1.0)


BASE = {
    "altitude_km": [0.0, 3.0],
    "azimuth_deg": [0.0, 90.0, 180.0, 270.0],
    "slope_deg": [0.0, 45.0, 90.0],
    "time_h": [0.0, 8.0, 16.0],
}


def temperature(axes):
    """A smooth day of one material, with the shape of a temperature table."""
    altitude, azimuth, slope, time = np.meshgrid(*(np.asarray(v, float) for v in axes.values()), indexing="ij")
    day = (
        10
        * np.cos(np.pi * (time - 14) / 12)
        * (1 + 0.5 * np.sin(np.radians(slope)) * np.cos(np.radians(azimuth - 180)))
    )
    return (290 - 6.5 * altitude + day)[None]


@pytest.mark.parametrize("tolerance", [1.0, 0.3])
def test_surface_axes_hold_the_tolerance_elsewhere(tolerance):
    found = refined_axes(temperature, BASE, 1, tolerance, seed=5, max_nodes=10**7)
    generator = np.random.default_rng(11)
    places = {
        "altitude_km": generator.uniform(0, 3, 5),
        "azimuth_deg": generator.uniform(0, 360, 12),
        "slope_deg": generator.uniform(0, 90, 12),
        "time_h": generator.uniform(0, 24, 40),
    }
    error = np.abs(read_temperature(temperature(found.axes), found.axes, places) - temperature(places))
    assert np.percentile(error, 99) <= tolerance and error.max() <= 2 * tolerance
    assert found.axes["altitude_km"].size == 2  # linear: its ends are enough


def test_what_cannot_be_held_is_said():
    with pytest.raises(
        CheckFailed,
        match="surface_grid.tolerance 0.001 K cannot be held with 500 nodes: it takes .* most for the (azimuth|time), ",
    ):
        refined_axes(temperature, BASE, 1, 1e-3, seed=5, max_nodes=500)
