"""Largest mean posterior over boxes against sums in numpy, in both ways that it is found."""

import numpy as np
import pytest

from skyshine.tmm.classify.box import POSTERIOR_ONE, pairs_of, strongest


@pytest.mark.parametrize("materials", [1, 2, 5, 8])
@pytest.mark.parametrize("radius", [0, 2, 120])
def test_the_strongest_material_has_the_largest_mean(materials, radius):
    """Sums over boxes of radius 120 leave no bits free beside them for the material's number."""
    random = np.random.default_rng(materials)
    posterior = random.integers(0, POSTERIOR_ONE // materials, (materials, 9, 14)).astype(np.uint16)
    posterior[-1, 4:, 5:] = POSTERIOR_ONE // 2
    posterior[0, :, 12:] = posterior[-1, :, 12:]  # the first of equals is taken
    whole = slice(0, 9), slice(0, 14)
    pairs = (pair for pair in pairs_of(posterior))
    material, confidence = strongest(pairs, (materials + 1) // 2, np.ones((9, 14), bool), radius, whole)
    for row, column in np.ndindex(9, 14):
        box = np.s_[:, max(row - radius, 0) : row + radius + 1, max(column - radius, 0) : column + radius + 1]
        total = posterior[box].astype(np.int64).sum(axis=(1, 2))
        assert material[row, column] == total.argmax()
        mean = total.max() / (POSTERIOR_ONE * posterior[box][0].size)
        assert confidence[row, column] == pytest.approx(mean, rel=1e-5)
