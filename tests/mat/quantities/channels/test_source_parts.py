"""The few fields of scattered light that a file has."""

import numpy as np
import pytest

from skyshine.mat.quantities.channels.source_parts import leading_parts


@pytest.fixture
def light():
    """Factors (8, 5, 6) and fields (8, 4, 3, 7) whose sums fall by a factor of ten with each rank."""
    draw = np.random.default_rng(5)
    directions, nodes = (np.linalg.qr(draw.normal(size=(count, 8)))[0] for count in (30, 84))
    mix = draw.normal(size=(8, 8))  # the chosen directions are no singular vectors
    size = 10.0 ** -np.arange(8)
    return (directions @ np.linalg.inv(mix)).T.reshape(8, 5, 6), (mix @ (nodes * size).T).reshape(8, 4, 3, 7)


def total(factor, fields):
    return np.tensordot(factor, fields, axes=(0, 0))


@pytest.mark.parametrize("allowed", [1.5e-4, 1.5e-6, 0.0])
def test_leading_fields_give_the_light_within_the_error_and_one_fewer_do_not(light, allowed):
    factor, fields = leading_parts(*light, allowed)
    error = total(factor, fields) - total(*light)
    assert np.sqrt(np.mean(error**2)) <= allowed + 1e-12
    assert np.abs(factor).max(axis=(1, 2)) == pytest.approx(1)
    if allowed:
        assert len(factor) < 8
        fewer = total(factor[:-1], fields[:-1]) - total(*light)
        assert np.sqrt(np.mean(fewer**2)) > allowed


def test_light_of_one_node_under_one_direction_is_kept_though_hardly_any_mean_has_it():
    """The aureole of a low Sun."""
    factor, fields = np.zeros((2, 5, 6)), np.zeros((2, 10, 4, 21))
    factor[0], fields[0] = 1.0, 1.0
    factor[1, 2, 3] = fields[1, 0, 0, 0] = 1.0
    rms = 1 / np.sqrt(30 * 840)
    assert len(leading_parts(factor, fields, 1.3 * rms)[0]) == 2
    assert len(leading_parts(factor, fields, 0.9)[0]) == 1


def test_one_field_or_none_is_left_as_it_is():
    for count in (0, 1):
        factor, fields = np.ones((count, 2, 2)), np.ones((count, 1, 1, 1))
        assert leading_parts(factor, fields, 0.1) == (factor, fields)
