"""Weights of nodes: exact for cubics, of each part its own, the node itself at a node."""

import numpy as np
import pytest
from numpy_light import direction_weights
from scipy.interpolate import BarycentricInterpolator

from skyshine.mat.atmosphere.transfer.node_cubics import NodeCubics

KNOWN = np.array([0.0, 0.3, 1.0, 1.5, 2.7, 3.0])


def interpolated(cubics, values, places):
    first, weight = cubics.weights(np.asarray(places, float))
    return np.sum(weight * values[first[:, None] + np.arange(weight.shape[1])], axis=1)


def test_a_cubic_is_exact_between_nodes():
    places = np.array([0.0, 0.1, 0.3, 0.9, 2.0, 2.9, 3.0])

    def cubic(x):
        return 1 - 2 * x + 0.3 * x**2 + 0.7 * x**3

    assert interpolated(NodeCubics.of(KNOWN), cubic(KNOWN), places) == pytest.approx(cubic(places), rel=1e-12)


def test_the_four_nodes_around_count():
    values = np.sin(3 * KNOWN)
    for place, low in ((0.1, 0), (0.4, 0), (1.2, 1), (2.0, 2), (2.9, 2)):
        wanted = BarycentricInterpolator(KNOWN[low : low + 4], values[low : low + 4])(place)
        assert interpolated(NodeCubics.of(KNOWN), values, [place]) == pytest.approx([float(wanted)], rel=1e-12)


@pytest.mark.parametrize("count", [2, 3])
def test_few_nodes_have_straight_lines_and_one_node_a_constant(count):
    values = np.array([4.0, 1.0, 7.0])[:count]
    places = np.linspace(0, KNOWN[count - 1], 9)
    found = interpolated(NodeCubics.of(KNOWN[:count]), values, places)
    assert found == pytest.approx(np.interp(places, KNOWN[:count], values))
    assert interpolated(NodeCubics.of(KNOWN[:1]), values, [0.0]).tolist() == [4.0]


def test_parts_do_not_see_each_other():
    values = np.array([1.0, 2.0, 9.0, 8.0, 7.0, 6.0])
    changed = np.array([1.0, 2.0, 0.0, 0.0, 0.0, 0.0])
    cubics = NodeCubics.of(KNOWN, [2])
    assert interpolated(cubics, values, [0.0, 0.2, 0.3]) == pytest.approx([1, 1 + 2 / 3, 2])
    assert interpolated(cubics, changed, [0.0, 0.2, 0.3]) == pytest.approx([1, 1 + 2 / 3, 2])
    assert interpolated(cubics, values, KNOWN) == pytest.approx(values)


def weights_of(cosine, angles):
    first, near = direction_weights(np.array(cosine), np.array(angles))
    weight = np.zeros((len(cosine), len(angles)))
    np.put_along_axis(weight, first[:, None] + np.arange(near.shape[1]), near, axis=1)
    return weight


def test_directions_of_one_hemisphere_serve_all_and_beyond_the_last_they_are_held():
    assert weights_of([1.0, 0.5, -0.3], [1.0]).tolist() == [[1.0]] * 3
    up = weights_of([1.0, np.cos(0.4), 1e-9, -0.5], [0.2, 0.4])
    assert up == pytest.approx(np.array([[1, 0], [0, 1], [0, 1], [0, 1]]), abs=1e-12)
    down = weights_of([0.5, -np.cos(0.2), -1e-9], [np.pi - 0.4, np.pi - 0.2])
    assert down == pytest.approx(np.array([[1, 0], [0, 1], [1, 0]]), abs=1e-12)
    both = weights_of([np.cos(0.3), 1e-9, 0.0, -1.0], [0.3, 1.2, np.pi - 1.2])
    assert both == pytest.approx(np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1]]), abs=1e-12)
