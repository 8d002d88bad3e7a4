"""Interpolation on tables: exact for multilinear functions, periodic and folded axes, what lies outside."""

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from skyshine.mat.tables.axes import EXACT, FOLDED, PERIODIC, AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.schemas.errors import InputError


def test_it_agrees_with_scipy_in_five_axes():
    generator = np.random.default_rng(3)
    nodes = [np.sort(generator.random(n)) for n in (4, 3, 5, 2, 6)]
    values = generator.random([n.size for n in nodes])
    rules = [AxisRule(name, n) for name, n in zip("abcde", nodes, strict=True)]
    points = np.stack([generator.uniform(n[0], n[-1], 200) for n in nodes])
    expected = RegularGridInterpolator(nodes, values)(points.T)
    np.testing.assert_allclose(
        interpolate(values, rules, dict(zip("abcde", points, strict=True))), expected, rtol=1e-12
    )


def test_nodes_give_their_values_exactly_and_arguments_broadcast():
    values = np.arange(12.0).reshape(3, 4)
    rules = [AxisRule("x", np.array([0.0, 1.0, 5.0])), AxisRule("y", np.array([-1.0, 0.0, 2.0, 3.0]))]
    read = interpolate(values, rules, {"x": rules[0].nodes[:, None], "y": rules[1].nodes})
    np.testing.assert_array_equal(read, values)


def test_a_periodic_axis_closes():
    rule = AxisRule("time", np.array([0.0, 6.0, 12.0, 18.0]), PERIODIC, 24.0)
    values = np.array([1.0, 2.0, 3.0, 4.0])
    read = interpolate(values, [rule], {"time": np.array([21.0, -3.0, 45.0, 24.0, 0.0])})
    np.testing.assert_allclose(read, [2.5, 2.5, 2.5, 1.0, 1.0])


def test_a_periodic_axis_that_starts_late_closes_too():
    rule = AxisRule("time", np.array([5.0, 17.0]), PERIODIC, 24.0)
    np.testing.assert_allclose(
        interpolate(np.array([0.0, 1.0]), [rule], {"time": np.array([2.0, 23.0, 17.0, 29.0])}), [0.25, 0.5, 1.0, 0.0]
    )


def test_a_folded_axis_is_even():
    rule = AxisRule("azimuth", np.array([0.0, 90.0, 180.0]), FOLDED, 360.0)
    read = interpolate(np.array([0.0, 1.0, 4.0]), [rule], {"azimuth": np.array([45.0, -45.0, 315.0, 270.0, 540.0])})
    np.testing.assert_allclose(read, [0.5, 0.5, 0.5, 1.0, 4.0])


def test_codes_are_read_exactly():
    rule = AxisRule("material", np.array([3, 5, 9]), EXACT)
    np.testing.assert_array_equal(interpolate(np.array([1.0, 2.0, 3.0]), [rule], {"material": [9, 3]}), [3.0, 1.0])
    with pytest.raises(InputError, match="material: found 4; allowed: 3, 5, 9"):
        interpolate(np.array([1.0, 2.0, 3.0]), [rule], {"material": 4})


@pytest.mark.parametrize("value", [-0.001, 2.5, np.inf, np.nan])
def test_outside_is_an_error_by_default(value):
    rule = AxisRule("range", np.array([0.0, 1.0, 2.0]))
    with pytest.raises(InputError, match="range: found"):
        interpolate(np.zeros(3), [rule], {"range": value})


def test_outside_is_clamped_on_request_but_never_what_is_not_a_number():
    rule = AxisRule("range", np.array([0.0, 1.0, 2.0]), out_of_range="clamp")
    values = np.array([5.0, 6.0, 8.0])
    np.testing.assert_array_equal(interpolate(values, [rule], {"range": np.array([-4.0, 7.0])}), [5.0, 8.0])
    with pytest.raises(InputError, match="not finite"):
        interpolate(values, [rule], {"range": np.nan})


def test_axes_must_be_named_unless_they_hold_one_node():
    rules = [AxisRule("x", np.array([0.0, 1.0])), AxisRule("y", np.array([3.0]))]
    assert interpolate(np.array([[1.0], [2.0]]), rules, {"x": 0.5}) == 1.5
    with pytest.raises(InputError, match="'x' is missing"):
        interpolate(np.array([[1.0], [2.0]]), rules, {})
    with pytest.raises(InputError, match="found the axis 'z'"):
        interpolate(np.array([[1.0], [2.0]]), rules, {"x": 0.5, "z": 1})
