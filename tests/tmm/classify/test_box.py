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


@pytest.mark.parametrize("radius", [44, 46])
def test_boxes_that_are_full_of_one_material(radius):
    """91 x 91 texels of the highest posterior leave 3 bits beside their sum no longer, 89 x 89 still do."""
    size = 2 * radius + 1
    posterior = np.zeros((8, size, size), np.uint16)
    posterior[5] = POSTERIOR_ONE
    whole = slice(0, size), slice(0, size)
    pairs = (pair for pair in pairs_of(posterior))
    material, confidence = strongest(pairs, 4, np.ones((size, size), bool), radius, whole)
    assert np.all(material == 5) and confidence == pytest.approx(1.0)
