"""Directions at which radiance is tabulated: cubics between them, in each hemisphere alone."""

import numpy as np
import pytest
from numpy_light import direction_weights

from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS


def test_radiance_near_the_horizon_is_met_between_directions():
    """That of thin and of thick even layers, 1 - exp(-depth / cosine), and of azimuthal moments near the vertical."""
    cosine = np.concatenate([np.linspace(0.021, 1, 200), -np.linspace(0.021, 1, 200)])
    angles = np.array(DIRECTIONS)
    first, near = direction_weights(cosine, angles)
    weight, tabulated = np.zeros((400, angles.size)), np.cos(angles)
    np.put_along_axis(weight, first[:, None] + np.arange(4), near, axis=1)
    assert weight.sum(axis=1) == pytest.approx(np.ones(400), abs=1e-12)
    for depth in (0.01, 0.1, 1.0):
        found = weight @ -np.expm1(-depth / np.abs(tabulated))
        assert found == pytest.approx(-np.expm1(-depth / np.abs(cosine)), rel=4e-3)
    for moment in (1, 2, 5):
        assert (weight @ np.sqrt(1 - tabulated**2) ** moment) == pytest.approx(
            np.sqrt(np.maximum(1 - cosine**2, 0)) ** moment, abs=5e-3 if moment < 5 else 1.2e-2
        )
    up, down = tabulated > 0, tabulated < 0
    assert not np.any(weight[:200, down]) and not np.any(weight[200:, up])
