"""Largest mean posterior over boxes against sums in numpy, and cells against the texels that they hold."""

import numpy as np
import pytest

from skyshine.tmm.classify.box import POSTERIOR_ONE, Cells, at_texels, strongest


@pytest.mark.parametrize("materials", [1, 2, 5])
@pytest.mark.parametrize("radius", [0, 2, 120])
def test_the_strongest_material_has_the_largest_mean(materials, radius):
    random = np.random.default_rng(materials)
    posterior = random.integers(0, POSTERIOR_ONE // materials, (materials, 9, 14)).astype(np.uint16)
    posterior[-1, 4:, 5:] = POSTERIOR_ONE // 2
    posterior[0, :, 12:] = posterior[-1, :, 12:]  # the first of equals is taken
    valid = random.random((9, 14)) > 0.2
    valid[4, 5] = True
    material, confidence = strongest(posterior, valid, radius, (slice(0, 9), slice(0, 14)))
    for row, column in zip(*np.nonzero(valid), strict=True):
        box = np.s_[max(row - radius, 0) : row + radius + 1, max(column - radius, 0) : column + radius + 1]
        total = posterior[(slice(None), *box)][:, valid[box]].astype(np.int64).sum(axis=1)
        assert material[row, column] == total.argmax()
        assert confidence[row, column] == pytest.approx(total.max() / (POSTERIOR_ONE * valid[box].sum()), rel=1e-5)


@pytest.mark.parametrize("side", [1, 2, 5])
def test_cells_hold_their_texels(side):
    size = 23
    for start, stop in ((0, 23), (4, 9), (7, 8), (20, 23)):
        cells = Cells(start, stop, size, side, 2)
        numbers = np.arange(-(-size // side))[cells.wide][cells.inner]
        line = Cells(0, 1, 1, side, 0)
        found = at_texels(np.repeat(numbers[:, np.newaxis], 1, axis=1), side, cells, line)[:, 0]
        np.testing.assert_array_equal(found, np.arange(start, stop) // side)
        assert cells.wide.start == max(start // side - 2, 0)
