"""Weights of tabulated source functions along a ray: quadratics inside cut layers, cubics between directions."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS, direction_weights
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.line_weights import source_weights_along, straight_weights
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments

LEVELS = np.array([0.0, 100.0, 300.0])
PARTS = LayerParts(np.array([1, 4]))


def segments_of(altitude):
    """Vertical segments between altitudes, of even air of 1 molecule m^-2 for each metre."""
    altitude = np.asarray(altitude, float)
    middle = 0.5 * (altitude[1:] + altitude[:-1])
    layer = np.searchsorted(LEVELS, middle) - 1
    share = (middle - LEVELS[layer]) / np.diff(LEVELS)[layer]
    air, still = np.abs(np.diff(altitude)), np.zeros(altitude.size)
    return Segments(
        np.arange(layer.size),
        layer,
        air * (1 - share),
        air * share,
        altitude,
        still,
        still,
        abs(altitude - altitude[0]),
    )


def places():
    """Altitude of each place, m."""
    layer, _ = PARTS.inside
    inside = [LEVELS[k] + PARTS.shares(k) * np.diff(LEVELS)[k] for k in np.unique(layer)]
    return np.concatenate([LEVELS, *inside])


@pytest.mark.parametrize("altitude", [[0, 100, 300], [300, 100, 0], [100, 130, 290], [260, 110], [20, 70]])
@pytest.mark.parametrize("depth", [1e-6, 0.03, 0.5, 20.0])
def test_a_source_quadratic_in_a_cut_layer_is_integrated_exactly(altitude, depth):
    """Depths are counted from the observer, all extinction being delta-scaled; the whole layer's source is linear."""
    segments, extinction = segments_of(altitude), np.full((3, 1), depth / 100)

    def source(height, layer):
        return np.where(layer == 0, 1 + height / 100, 3 + (height / 100 - 2) ** 2)

    depths, functions = Depths(segments.column(extinction)), np.ones((segments.index.size, 1))
    weights = source_weights_along(segments, depths, depths, LEVELS, extinction, PARTS, functions)
    table = source(places(), np.array([0, 0, 1, *PARTS.inside[0]]))  # the level between belongs to the whole layer
    found = np.sum(weights.weight[:, 0] * table[weights.place])
    wanted, before = 0.0, 0.0
    for low, high in pairwise(altitude):
        whole = abs(high - low) * depth / 100

        def light(t, low=low, high=high, whole=whole):
            return float(source(low + (high - low) * t, int(low + high > 200))) * np.exp(-t * whole) * whole

        wanted += np.exp(-before) * quad(light, 0, 1, epsabs=0, epsrel=1e-10, points=[min(1, 1 / max(whole, 1))])[0]
        before += whole
    assert found == pytest.approx(wanted, rel=1e-6)


def test_light_scattered_straight_forward_is_what_all_extinction_leaves_less_of():
    segments, extinction = segments_of([0, 100, 300]), np.full((3, 1), 0.01)
    angles = np.array(DIRECTIONS)
    depths = Depths(segments.column(extinction))
    weights = straight_weights(segments, depths, Depths(0.4 * depths.per_segment), LEVELS, angles)
    total = np.zeros(2)
    np.add.at(total, weights.segment, weights.weight[:, 0] * weights.factor.sum(axis=1))
    assert total == pytest.approx([np.exp(-0.4) - np.exp(-1), np.exp(-1) * (np.exp(-0.8) - np.exp(-2))], rel=1e-12)
    none = straight_weights(segments, depths, depths, LEVELS, angles)
    assert not np.any(none.weight)


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


def test_parts_are_places_beyond_the_levels():
    assert PARTS.places == 3 + 5 and PARTS.is_cut and not LayerParts.whole(4).is_cut
    assert PARTS.first_place.tolist() == [-1, 3]
    for share in (0.0, 0.2, 0.6, 1.0):
        place, weight = PARTS.at(1, share)
        assert weight @ places()[place] == pytest.approx(100 + 200 * share)
    thick = LayerParts.of(np.array([[0.001], [0.5], [90.0]]), np.array([[5.0], [0.5], [100.0]]))
    assert thick.count.tolist() == [1, 2, 16]
