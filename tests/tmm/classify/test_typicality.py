"""Typicality by the colour and contrast of boxes: what a box holds, what is learnt of it, and what is found by it."""

import numpy as np
import pytest
from scipy import stats

from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.classify.typicality import (
    FLOOR,
    OWN_REGIONS,
    PRIOR_REGIONS,
    Boxes,
    Typicality,
    fit_boxes,
    prior_covariance,
)
from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.images.texture import Texture
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.training.seed_boxes import SeedBoxes, seed_boxes

GREEN, GREY = "grass_green", "asphalt_road"


def _boxes(pixels, valid=None, radius=8):
    texture = Texture(pixels, np.ones(pixels.shape[:2], bool) if valid is None else valid, "srgb")
    return Boxes(texture, DistinctColours(texture), radius)


def _noise(shape, seed=0, low=0, high=256, dtype=np.uint8):
    return np.random.default_rng(seed).integers(low, high, shape, dtype=dtype)


# Side of a cell, texels from one sample to the next, and cells to each side, of each radius.
LAYOUT = {0: (1, 1, 0), 1: (1, 1, 1), 3: (1, 1, 3), 4: (2, 1, 2), 7: (2, 1, 3), 8: (4, 2, 2), 40: (20, 10, 2)}


@pytest.mark.parametrize("radius", LAYOUT)
@pytest.mark.parametrize("channels, dtype", [(3, np.uint8), (3, np.uint16), (4, np.uint8)])
def test_boxes_against_texel_by_texel(radius, channels, dtype):
    cell, step, reach = LAYOUT[radius]
    pixels = _noise((23, 31, channels), high=np.iinfo(dtype).max, dtype=dtype)
    valid = np.random.default_rng(1).random((23, 31)) > 0.2
    boxes = _boxes(pixels, valid, radius)
    features, known = boxes.features(slice(0, boxes.rows), slice(0, boxes.columns))
    values = to_coordinates(pixels.reshape(-1, channels), "srgb").reshape(23, 31, channels)
    sampled = np.zeros((23, 31), bool)
    sampled[::step, ::step] = valid[::step, ::step]
    assert known.shape == (-(-23 // cell), -(-31 // cell))
    for row, column in np.ndindex(known.shape):
        box = np.s_[
            max((row - reach) * cell, 0) : (row + reach + 1) * cell,
            max((column - reach) * cell, 0) : (column + reach + 1) * cell,
        ]
        inside = values[box][sampled[box]]
        assert known[row, column] == (len(inside) > 0)
        if len(inside):
            expected = np.concatenate([inside.mean(axis=0), np.log1p(inside.std(axis=0))])
            np.testing.assert_allclose(features[:, row, column], expected, atol=0.03 if len(inside) < 9 else 0.01)


def test_part_of_the_boxes_is_part_of_all():
    boxes = _boxes(_noise((90, 70, 3)))
    whole, _ = boxes.features(slice(0, boxes.rows), slice(0, boxes.columns))
    part, _ = boxes.features(slice(3, 11), slice(5, boxes.columns))
    np.testing.assert_array_equal(part, whole[:, 3:11, 5:])


def _model(mean, covariance=None):
    covariances = np.stack([np.diag([20.0, 9, 9, 0.1, 0.1, 0.1]) if covariance is None else covariance])
    return GaussianModel(("a",), np.atleast_2d(mean).astype(float), covariances, np.zeros(1))


@pytest.mark.parametrize("radius", [0, 3, 8, 11])
def test_windows_do_not_show(radius):
    valid = np.random.default_rng(2).random((90, 70)) > 0.1
    boxes = _boxes(_noise((90, 70, 3)), valid, radius)
    typicality = Typicality(boxes, _model([50, 0, 0, 3, 3, 3], np.diag([900.0, 900, 900, 1, 1, 1])))
    whole = typicality.window(0, 90, 0, 70)
    assert whole.dtype == np.float32 and len(np.unique(whole)) > 20
    for top in range(0, 90, 17):
        for left in range(0, 70, 23):
            at = np.s_[top : min(top + 17, 90), left : min(left + 23, 70)]
            part = typicality.window(at[0].start, at[0].stop, at[1].start, at[1].stop)
            np.testing.assert_array_equal(part, whole[at])


def test_a_flat_texture_against_chi_squared():
    grey = np.full((40, 40, 3), 120, np.uint8)
    lightness = to_coordinates(grey[:1, 0], "srgb")[0, 0]
    typicality = Typicality(_boxes(grey), _model([lightness + 10, 0, 0, 0, 0, 0]))
    found = typicality.window(0, 40, 0, 40)
    np.testing.assert_allclose(found, stats.chi2.sf(100 / 20, 6), rtol=2e-3)


def test_of_several_materials_the_most_typical_counts():
    grey = np.full((40, 40, 3), 120, np.uint8)
    lightness = to_coordinates(grey[:1, 0], "srgb")[0, 0]
    near = _model([lightness + 5, 0, 0, 0, 0, 0])
    both = GaussianModel(
        ("a", "b"),
        np.stack([near.means[0] + [70, 0, 0, 0, 0, 0], near.means[0]]),
        np.repeat(near.covariances, 2, axis=0),
        np.zeros(2),
    )
    expected = Typicality(_boxes(grey), near).window(0, 40, 0, 40)
    np.testing.assert_array_equal(Typicality(_boxes(grey), both).window(0, 40, 0, 40), expected)


def test_without_data_nothing_is_typical():
    valid = np.zeros((64, 64), bool)
    valid[:8, :8] = True
    found = Typicality(_boxes(_noise((64, 64, 3)), valid), _model([50, 0, 0, 3, 3, 3])).window(0, 64, 0, 64)
    assert np.isfinite(found).all() and (found[40:, 40:] == 0).all()


def test_bright_floats_stay_finite():
    pixels = np.full((40, 40, 3), 3e38, np.float32)
    pixels[20:] = 0
    found = Typicality(_boxes(pixels), _model([50, 0, 0, 3, 3, 3])).window(0, 40, 0, 40)
    assert np.isfinite(found).all() and (found >= 0).all() and (found <= 1).all()


def test_one_region_of_one_box_has_the_prior():
    """Of one region the covariance is the prior's, doubled for its mean; worked out by hand."""
    feature = np.array([[50.0, 1, 2, 0.5, 0.4, 0.3]])
    model = fit_boxes(feature, np.zeros(1, int), np.zeros(1, int))
    prior = prior_covariance(3)
    np.testing.assert_allclose(model.means, feature)
    np.testing.assert_allclose(model.covariances[0], (2 + FLOOR) * prior, rtol=1e-5)


def test_two_materials_by_hand():
    """Two regions of one feature each, +-1 about their means: own scatter 1 in each feature, fully correlated."""
    features = np.array([[1.0] * 6, [-1.0] * 6, [11.0] * 6, [9.0] * 6])
    model = fit_boxes(features, np.array([0, 0, 1, 1]), np.arange(4))
    ones, prior = np.ones((6, 6)), prior_covariance(3)
    pooled = (2 * ones + 2 * ones + PRIOR_REGIONS * prior) / (4 - 2 + PRIOR_REGIONS)
    expected = (2 * ones + OWN_REGIONS * pooled) / (1 + OWN_REGIONS) * 1.5 + FLOOR * prior
    np.testing.assert_allclose(model.means, [[0] * 6, [10] * 6])
    np.testing.assert_allclose(model.covariances, [expected, expected], rtol=1e-5)


def test_two_boxes_of_one_region_by_hand():
    features, prior = np.array([[1.0] * 6, [-1.0] * 6]), prior_covariance(3)
    model = fit_boxes(features, np.zeros(2, int), np.zeros(2, int))
    pooled = np.ones((6, 6)) / PRIOR_REGIONS + prior
    expected = (np.ones((6, 6)) + OWN_REGIONS * pooled) / OWN_REGIONS * 2 + FLOOR * prior
    np.testing.assert_allclose(model.covariances[0], expected, rtol=1e-5)


def test_many_regions_have_their_own_covariance():
    random = np.random.default_rng(3)
    covariance = prior_covariance(3) * 2
    features = random.multivariate_normal(np.zeros(6), covariance, 40_000)
    model = fit_boxes(features, np.zeros(len(features), int), np.arange(len(features)))
    np.testing.assert_allclose(model.covariances[0], covariance, atol=0.03 * covariance.max())


def test_boxes_of_one_region_count_once():
    features = np.random.default_rng(4).normal(0, 0.2, (64, 6))
    alike = fit_boxes(features, np.zeros(64, int), np.zeros(64, int))
    apart = fit_boxes(features, np.zeros(64, int), np.arange(64))
    assert np.linalg.slogdet(alike.covariances[0])[1] > np.linalg.slogdet(apart.covariances[0])[1] + 1


def test_prior_covariance_is_one_of_near_infrared_too():
    for channels in (3, 4):
        covariance = prior_covariance(channels)
        assert (np.linalg.eigvalsh(covariance) > 0).all() and covariance.shape == (2 * channels, 2 * channels)
    np.testing.assert_array_equal(prior_covariance(4)[:3, :3], prior_covariance(3)[:3, :3])


def test_seeds_are_told_by_their_boxes():
    pixels = _noise((300, 300, 3))
    boxes = _boxes(pixels)
    rows, columns = np.array([0, 1, 9, 9, 290, 291]), np.array([0, 2, 250, 250, 7, 9])
    material, region = np.array([0, 0, 0, 1, 1, 1]), np.array([5, 5, 6, 6, 7, 7])
    seeds = SeedTexels(("a", "b"), rows, columns, material, region, pixels[rows, columns], 0, np.zeros(len(rows), bool))
    found = seed_boxes(boxes, seeds)
    whole, _ = boxes.features(slice(0, boxes.rows), slice(0, boxes.columns))
    # (0, 0) and (1, 2) stand in one cell, (9, 250) is in one of each material, columns 7 and 9 are in two.
    assert sorted(found.seed.tolist()) == [0, 2, 3, 4, 5]
    for feature, seed in zip(found.features, found.seed, strict=True):
        np.testing.assert_array_equal(feature, whole[:, rows[seed] // 4, columns[seed] // 4])
    np.testing.assert_array_equal(found.material, material[found.seed])
    np.testing.assert_array_equal(found.region, region[found.seed])
    chosen = material == 1
    pixel_model = found.typicality(chosen)
    part = fit_boxes(found.features[chosen[found.seed]], np.zeros(3, int), np.array([6, 7, 7]))
    np.testing.assert_array_equal(pixel_model.window(0, 300, 0, 300), Typicality(boxes, part).window(0, 300, 0, 300))


@pytest.fixture
def contrasts(write_image):
    """Three strips of one mean colour in linear steps of value: even, even and another colour, and speckled."""
    random = np.random.default_rng(5)
    values = np.empty((120, 300, 3))
    values[:, :100], values[:, 100:200], values[:, 200:] = (70, 130, 60), (128, 128, 130), (128, 128, 130)
    values += random.normal(0, 3, values.shape)
    values[:, 200:] += random.choice([-50, 50], (120, 100))[..., np.newaxis]
    return write_image("contrasts.png", np.clip(values, 0, 255).astype(np.uint8))


def _squares(left):
    return [
        [[left + x, y], [left + x + 12, y], [left + x + 12, y + 12], [left + x, y + 12]]
        for x in (15, 35, 55, 75)
        for y in (10, 50, 90)
    ]


@pytest.mark.parametrize("settings", [{}, {"classifier": {"speed": "fast", "radius": 4}}, {"model": "library"}])
def test_what_has_the_colour_but_not_the_contrast_is_unknown(job, contrasts, build, settings):
    result = build(job(contrasts, {GREEN: _squares(0), GREY: _squares(100)}, **settings))
    unknown = result.code == 0
    # A box that reaches into the even strip is typical of it: the speckle is found from a box's width on.
    assert unknown[:, 230:].mean() > 0.98
    # The border of two materials with seeds is like neither, and is not unknown.
    assert unknown[:, :180].mean() < 0.02


def test_with_few_places_nothing_is_unknown(job, contrasts, build):
    polygons = {GREEN: _squares(0)[:2], GREY: _squares(100)[:2]}
    result = build(job(contrasts, polygons))
    assert result.map.seeds.separate_places.tolist() == [2, 2] and (result.code > 0).all()


@pytest.mark.parametrize("speed", ["best", "fast"])
def test_seeds_of_unknown_make_what_looks_like_them_unknown(job, contrasts, build, speed):
    polygons = {GREEN: _squares(0)[:1], GREY: _squares(100)[:1], "unknown": _squares(200)[:2]}
    result = build(job(contrasts, polygons, classifier={"speed": speed}))
    unknown = result.code == 0
    assert unknown[:, 230:].mean() > 0.9 and unknown[:, :180].mean() < 0.02
    assert result.map.names == tuple(sorted((GREEN, GREY), key=result.map.names.index))
    assert result.map.quality.quality.tested == 0


def test_with_seeds_of_the_contrast_nothing_is_unknown(job, contrasts, build):
    polygons = {GREEN: _squares(0), GREY: _squares(100), "gravel_limestone": _squares(200)}
    assert np.mean(build(job(contrasts, polygons)).code == 0) < 0.02


@pytest.mark.parametrize("places, rank", [(18, 0), (19, 1), (38, 1), (39, 2)])
def test_the_threshold_lets_one_place_in_twenty_fall_below(monkeypatch, places, rank):
    typicality = np.random.default_rng(1).random(places)
    monkeypatch.setattr(SeedBoxes, "of_places", lambda _: typicality)
    found = SeedBoxes(None, None, None, None, None).threshold()
    assert found == (np.sort(typicality)[rank - 1] if rank else 0)


def test_places_are_as_typical_as_the_others_have_it():
    random = np.random.default_rng(4)
    features = random.normal(0, 1, (40, 6)) * np.sqrt(np.diag(prior_covariance(3)))
    features[:10] += 100
    material, region = np.repeat([0, 1], 20), np.repeat([0, 1, 2, 3], 10)
    boxes = SeedBoxes(_boxes(_noise((60, 60, 3))), features, np.arange(40), material, region)
    found = boxes.of_places()
    model = fit_boxes(features[10:], material[10:], region[10:])
    expected = stats.chi2.sf(np.median(model.squared_distance(features[:10]).min(axis=0)), 6)
    assert found[0] == pytest.approx(expected, abs=1e-12) and found[0] < 1e-6 < found[2:].min()


def test_up_to_a_border_within_a_cell_a_material_is_as_typical_as_inside():
    """Grey up to column 41, the second of its cell of four, then red: the box one cell beyond holds grey alone."""
    pixels = np.full((64, 80, 3), 120, np.uint8)
    pixels[:, 42:] = (200, 40, 40)
    lightness = to_coordinates(pixels[:1, 0], "srgb")[0, 0]
    found = Typicality(_boxes(pixels), _model([lightness + 5, 0, 0, 0, 0, 0])).window(0, 64, 0, 80)
    np.testing.assert_array_equal(found[:, :42], found[0, 0])
    assert (found[:, 60:] < 0.01 * found[0, 0]).all()


def test_answers_to_what_was_asked_have_no_threshold_and_are_not_held_out(contrasts, build, tmp_path):
    """Nine places a material, as many as have one elsewhere."""
    answers = [
        f"  - {{number: {i}, x: {x}, y: {y}, radius: 6, material: {name}}}"
        for i, (name, x, y) in enumerate(
            (
                (name, left + x, y)
                for name, left in ((GREEN, 0), (GREY, 100))
                for x in (20, 50, 80)
                for y in (15, 60, 100)
            ),
            1,
        )
    ]
    (tmp_path / "answers.yaml").write_text("\n".join(["answers:", *answers]) + "\n")
    result = build(TextureJob.model_validate({"image": contrasts, "seeds": {"suggested": "answers.yaml"}}))
    assert result.map.seeds.separate_places.tolist() == [9, 9] and result.map.thresholds == (0.0, 0.0)
    assert (result.code > 0).all() and result.map.quality.areas == 0
