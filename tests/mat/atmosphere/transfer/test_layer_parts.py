"""Places inside cut layers, and quadratics through them."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts

LEVELS = np.array([0.0, 100.0, 300.0])
PARTS = LayerParts(np.array([1, 4]))


def places():
    """Altitude of each place, m."""
    layer, _ = PARTS.inside
    inside = [LEVELS[k] + PARTS.shares(k) * np.diff(LEVELS)[k] for k in np.unique(layer)]
    return np.concatenate([LEVELS, *inside])


def test_parts_are_places_beyond_the_levels():
    assert PARTS.places == 3 + 5 and PARTS.is_cut and not LayerParts.whole(4).is_cut
    assert PARTS.first_place.tolist() == [-1, 3]
    for share in (0.0, 0.2, 0.6, 1.0):
        place, weight = PARTS.at(1, share)
        assert weight @ places()[place] == pytest.approx(100 + 200 * share)
    thick = LayerParts.of(np.array([[0.001], [0.5], [90.0]]), np.array([[5.0], [0.5], [100.0]]))
    assert thick.count.tolist() == [1, 2, 16]
