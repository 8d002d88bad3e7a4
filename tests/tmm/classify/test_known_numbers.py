"""Fits, calibration, quality and seeds against numbers worked out by hand."""

import numpy as np
import pytest
from scipy.ndimage import label

from skyshine.tmm.classify.calibration import Calibration, fit_calibration
from skyshine.tmm.classify.gaussian import fit
from skyshine.tmm.classify.trained import Network
from skyshine.tmm.images.texture import Texture
from skyshine.tmm.inputs.palette import palette_colour
from skyshine.tmm.inputs.seeds import _settle, places
from skyshine.tmm.job.model import Palette
from skyshine.tmm.mapping.ways import nearest_palette
from skyshine.tmm.quality.counts import Tally


def test_one_seed_of_each_material_takes_the_prior_spread():
    model = fit(np.array([[50.0, 0, 0], [20, 5, 5]]), np.array([0, 1]), ("a", "b"))
    # No scatter: the prior variance of 36, and 1 for the rounding of colours.
    np.testing.assert_allclose(model.covariances, np.stack([37 * np.eye(3)] * 2), rtol=1e-6)
    np.testing.assert_allclose(model.means, [[50, 0, 0], [20, 5, 5]])


def test_covariances_of_few_seeds_by_hand():
    lab = np.array([[0.0, 0, 0], [6, 0, 0], [100, 0, 0]])
    model = fit(lab, np.array([0, 0, 1]), ("a", "b"))
    # Scatter of a: 18 along L. Pooled: (18 + 4 x 36) / (3 - 2 + 4) along L, 144 / 5 across. Of a: (18 + 20 x 32.4) / 21
    # and 20 x 28.8 / 21; of b: 20 x 32.4 / 20 and 28.8; and 1 each.
    np.testing.assert_allclose(np.diag(model.covariances[0]), [1 + 666 / 21, 1 + 576 / 21, 1 + 576 / 21], rtol=1e-6)
    np.testing.assert_allclose(np.diag(model.covariances[1]), [33.4, 29.8, 29.8], rtol=1e-6)


def test_calibrated_confidence_by_hand():
    # Log-odds of 0.7 are 0.8473: 2 x 0.8473 + 0.5 = 2.1946, whose probability is 0.8998.
    found = Calibration(2.0, 0.5)(np.array([0, 0.7, 0.5], np.float32))
    np.testing.assert_allclose(found, [0, 0.8998, 0.6225], atol=2e-4)


def test_calibration_is_the_minimum_of_its_loss():
    """Against a search of the plane; the regions count once each, and two of three are right."""
    confidence = np.repeat([0.9, 0.8, 0.95], [30, 5, 2])
    right, region = np.repeat([True, True, False], [30, 5, 2]), np.repeat([0, 1, 2], [30, 5, 2])
    found = fit_calibration(confidence, right, region)
    odds = np.log([0.9 / 0.1, 0.8 / 0.2, 0.95 / 0.05])
    target = np.array([3 / 4, 3 / 4, 1 / 3])  # Platt 1999: (n + 1) / (n + 2) of those right, 1 / (n + 2) of those wrong
    slope, offset = np.meshgrid(np.linspace(-0.5, 1.5, 401), np.linspace(-1.5, 1.5, 601), indexing="ij")
    loss = ((slope - 1) ** 2 + offset**2) / 2
    for x, y in zip(odds, target, strict=True):
        z = slope * x + offset
        loss = loss - y * np.log(1 / (1 + np.exp(-z))) - (1 - y) * np.log(1 / (1 + np.exp(z)))
    best = np.unravel_index(loss.argmin(), loss.shape)
    assert found.slope == pytest.approx(slope[best], abs=0.01) and found.offset == pytest.approx(offset[best], abs=0.01)


def test_network_by_hand():
    network = Network(
        mean=np.array([1.0, 0], np.float32),
        scale=np.array([2.0, 1], np.float32),
        inner_weight=np.array([[1.0, -1], [0, 2]], np.float32),
        inner_offset=np.array([0.5, 0], np.float32),
        outer_weight=np.array([[1.0, 0], [0, 1]], np.float32),
        outer_offset=np.array([0.0, np.log(3)], np.float32),
    )
    # Features (3, 1): scaled (1, 1); hidden (1.5, 1); odds 1.5 and 1 + log 3.
    found = network.posterior(np.array([[3.0], [1.0]], np.float32))[:, 0]
    odds = np.exp([1.5, 1 + np.log(3)])
    np.testing.assert_allclose(found, odds / odds.sum(), rtol=1e-5)
    # A hidden unit below 0 gives nothing: scaled (1, -1), hidden (1.5, -3).
    odds = np.exp([1.5, np.log(3)])
    np.testing.assert_allclose(
        network.posterior(np.array([[3.0], [-1.0]], np.float32))[:, 0], odds / odds.sum(), rtol=1e-5
    )


def test_quality_by_hand():
    tally = Tally(3)
    # 10 texels of material 0: 6 right, 3 found as 1, 1 unknown; 5 of material 1: all right; none of material 2.
    true = np.array([0] * 10 + [1] * 5)
    assigned = np.array([0] * 6 + [1] * 3 + [-1] + [1] * 5)
    tally.add(true, assigned, np.full(15, 0.95))
    quality = tally.quality()
    assert quality.tested == 15 and quality.overall_accuracy == pytest.approx(11 / 15)
    np.testing.assert_allclose(quality.intersection_over_union, [6 / 10, 5 / 8, 0])
    assert quality.mean_iou == pytest.approx((6 / 10 + 5 / 8) / 2)
    # One bin: 11 of 14 right at a confidence of 0.95.
    assert quality.calibration_error == pytest.approx(0.95 - 11 / 14)


def test_confidences_fall_into_fifteen_bins():
    tally = Tally(1)
    tally.add(np.zeros(4, int), np.zeros(4, int), np.array([0.0, 0.0666, 0.0667, 1.0]))
    number = tally.quality().bins[0]
    assert len(number) == 15 and number[0] == 2 and number[1] == 1 and number[14] == 1


def test_places_of_texels_are_those_of_connected_pieces():
    """Against scipy's labels of each material's mask, by eight neighbours; a shape joins what lies apart."""
    random = np.random.default_rng(2)
    for _ in range(20):
        material = random.integers(-2, 2, (9, 13))
        rows, columns = np.nonzero(material >= 0)
        kind, none = material[rows, columns], np.full(len(rows), -1)
        found = places(rows, columns, kind, none)
        for k in range(2):
            number = label(material == k, np.ones((3, 3)))[0][rows, columns][kind == k]
            assert (
                len(set(zip(number, found[kind == k], strict=True))) == len(set(number)) == len(set(found[kind == k]))
            )
        assert not {*found[kind == 0]} & {*found[kind == 1]}
        assert len(set(places(rows, columns, kind, none + 1))) == 2


def test_palette_colours_of_16_bit_are_257_times_those_of_8_bit(tmp_path):
    # As PNG defines it: 255 becomes 65535.
    assert palette_colour("#FF8001", np.dtype(np.uint16), tmp_path) == (65535, 32896, 257)
    assert palette_colour("#FF8001", np.dtype(np.uint8), tmp_path) == (255, 128, 1)
    assert palette_colour("300", np.dtype(np.uint16), tmp_path) == (300, 300, 300)


def test_texels_of_two_materials_are_no_seeds(tmp_path):
    texture = Texture(np.zeros((2, 3, 3), np.uint8), np.ones((2, 3), bool), "srgb")
    # Texel 1 is claimed by both materials, texels 0 and 5 by one each.
    claims = np.array([[0, 1, 5], [0, 0, 1], [0, 1, 1], [0, 0, 1], [0, 0, 0]])
    seeds = _settle("a", ("a", "b"), {"a", "b"}, texture, tmp_path, claims)
    assert seeds.rows.tolist() == [0, 1] and seeds.columns.tolist() == [0, 2] and seeds.material.tolist() == [0, 1]
    assert seeds.conflicting == 1


def test_the_spread_of_a_palette_is_a_standard_deviation(tmp_path):
    texture = Texture(np.zeros((1, 1, 3), np.uint8), np.ones((1, 1), bool), "srgb")
    palette = Palette(colours={"#000000": "a", "#FFFFFF": "b"}, match="nearest", spread=3.0)
    model, material = nearest_palette(palette, ("a", "b"), texture, tmp_path)
    np.testing.assert_allclose(model.covariances, np.stack([9 * np.eye(3)] * 2))
    np.testing.assert_allclose(model.means, [[0, 0, 0], [100, 0, 0]], atol=0.02)
    assert material.tolist() == [0, 1]
