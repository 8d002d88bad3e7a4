"""Discrete ordinates: functions of the directions, light scattered from direction to direction."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.ordinates import ordinates


@pytest.mark.parametrize("nodes", [2, 4, 8, 16])
def test_the_functions_are_orthogonal_over_both_hemispheres(nodes):
    directions = ordinates(nodes)
    both = 2 * np.swapaxes(directions.at_nodes[:, :, None] * directions.weight, 1, 2)[:, 0]
    same = np.add.outer(np.arange(2 * nodes), np.arange(2 * nodes)) % 2 == 0  # the others cancel
    product = (both @ np.swapaxes(directions.at_nodes, 1, 2)) * same
    order = np.arange(2 * nodes)
    for m in range(directions.azimuthal):
        # Gauss's rule of one hemisphere is exact to degree 2 n - 1: the products of degrees below it.
        exact = (np.add.outer(order, order) < 2 * nodes) & (np.minimum.outer(order, order) >= m)
        wanted = np.diag(2 / directions.factor)
        assert product[m][exact] == pytest.approx(wanted[exact], abs=1e-12)


def test_isotropic_scattering_gives_the_mean_radiance_in_all_directions():
    directions = ordinates(4, 1)
    generator = np.random.default_rng(1)
    rising, falling = generator.random((2, 3, 1, 4, 2, 5))
    weighted = np.zeros((3, 8, 5))
    weighted[:, 0] = 0.7
    mean = 0.5 * np.einsum("i,kmiup->kup", directions.weight, rising + falling)
    into = directions.scattered_into(weighted, rising, falling, np.array([-1.0, -0.2, 0.0, 1.0]))
    assert into == pytest.approx(np.broadcast_to(0.7 * mean[:, None, None], into.shape), rel=1e-12)
    for nodes in directions.from_moments(weighted, *directions.moments_at_levels(rising, falling)):
        assert nodes == pytest.approx(np.broadcast_to(0.7 * mean[:, None, None], nodes.shape), rel=1e-12)


def test_the_beam_scatters_as_the_phase_function_says():
    directions, sine, asymmetry = ordinates(8, 16), np.array([0.3, 0.8]), 0.4
    weighted = np.broadcast_to((directions.factor * asymmetry ** np.arange(16))[None, :, None], (1, 16, 1))
    light = directions.out_of_beam(weighted, sine)[0, ..., 0]  # (M, 2 n, U)
    outgoing = np.concatenate([directions.node, -directions.node])
    for azimuth in (0.0, 1.0, 3.0):
        across = np.sqrt(1 - outgoing[:, None] ** 2) * np.sqrt(1 - sine**2) * np.cos(azimuth)
        cosine = across - outgoing[:, None] * sine  # the beam goes down
        phase = (1 - asymmetry**2) / (1 + asymmetry**2 - 2 * asymmetry * cosine) ** 1.5
        total = np.tensordot(np.cos(azimuth * np.arange(16)), light, 1)
        assert total == pytest.approx(phase / (4 * np.pi), rel=2e-4)
