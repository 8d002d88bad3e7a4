"""The classifier: posteriors, box average, thresholds, and the cases at its edges."""

import numpy as np
import pytest
from scipy import stats

from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.gaussian import GaussianModel, fit
from skyshine.tmm.classify.mapper import SAMPLES, ColourMapper
from skyshine.tmm.features.colour import DistinctColours, to_lab
from skyshine.tmm.images.texture import Texture

GREEN, GREY = "grass_green", "asphalt_road"


@pytest.fixture
def model():
    random = np.random.default_rng(5)
    factors = random.normal(size=(4, 3, 3))
    covariances = factors @ factors.transpose(0, 2, 1) * 20 + np.eye(3)
    return GaussianModel(tuple("abcd"), random.uniform(20, 80, (4, 3)), covariances, np.log([0.1, 0.2, 0.3, 0.4]))


def test_posterior_against_scipy(model):
    lab = np.random.default_rng(6).uniform(0, 100, (500, 3))
    joint = np.stack(
        [stats.multivariate_normal(m, c).logpdf(lab) for m, c in zip(model.means, model.covariances, strict=True)]
    )
    joint += model.log_prior[:, np.newaxis]
    expected = joint - np.logaddexp.reduce(joint, axis=0)
    np.testing.assert_allclose(model.log_posterior(model.squared_distance(lab)), expected, rtol=1e-9, atol=1e-9)


def test_posterior_far_from_everything_is_finite(model):
    posterior = np.exp(model.log_posterior(model.squared_distance(np.array([[1e6, -1e6, 1e6]]))))
    assert np.isfinite(posterior).all() and posterior.sum() == pytest.approx(1)


def test_many_seeds_give_the_sample_covariance():
    random = np.random.default_rng(7)
    covariance = np.array([[90.0, 10, 5], [10, 40, -3], [5, -3, 20]])
    lab = random.multivariate_normal([50, 0, 0], covariance, 200_000)
    model = fit(lab, np.zeros(len(lab), int), ("a",), "equal")
    np.testing.assert_allclose(model.covariances[0], covariance + np.eye(3), atol=1.0)


@pytest.mark.parametrize(
    "prior, expected", [("equal", [0.5, 0.5]), ("seeds", [0.75, 0.25]), ({"b": 3.0}, [0.25, 0.75])]
)
def test_priors(prior, expected):
    model = fit(np.arange(12.0).reshape(4, 3), np.array([0, 0, 0, 1]), ("a", "b"), prior)
    np.testing.assert_allclose(np.exp(model.log_prior), expected)


def _classifier(pixels, valid, radius, encoding="srgb", model=None):
    texture = Texture(pixels, valid, encoding)
    if model is None:
        means = to_lab(np.array([[40, 40, 40], [120, 130, 100], [220, 200, 210]], np.uint8), "srgb")
        model = GaussianModel(tuple("abc"), means, np.stack([np.diag([400.0, 50, 50])] * 3), np.log(np.ones(3) / 3))
    return ColourMapper(texture, DistinctColours(texture), model, radius)


@pytest.mark.parametrize("radius", [0, 1, 3, 8, 20])
def test_against_texel_by_texel(radius):
    """Boxes of radius 8 and 20 are averaged over every second and fifth row and column, from the corner on."""
    step = max(radius // SAMPLES, 1)
    reach = radius // step
    random = np.random.default_rng(8)
    pixels = random.integers(0, 256, (23, 31, 3), dtype=np.uint8)
    valid = random.random((23, 31)) > 0.2
    classifier = _classifier(pixels, valid, radius)
    result = classifier.window(0, 23, 0, 31)
    distance = classifier.model.squared_distance(to_lab(pixels.reshape(-1, 3), "srgb"))
    posterior = np.exp(classifier.model.log_posterior(distance)).reshape(3, 23, 31)
    typical = stats.chi2.sf(distance, 3).max(axis=0).reshape(23, 31)
    for row, column in zip(*np.nonzero(valid), strict=True):
        ends = [(max(at // step - reach, 0) * step, (at // step + reach) * step + 1) for at in (row, column)]
        box = tuple(slice(first, last, step) for first, last in ends)
        mean = posterior[(slice(None), *box)][:, valid[box]].mean(axis=1)
        found = result.material[row, column]
        assert mean[found] >= mean.max() - 1e-4
        assert result.confidence[row, column] == pytest.approx(mean[found], abs=1e-4)
        # To the 16 bits in which typicality is averaged, but for single texels.
        exact = {"rel": 1e-4, "abs": 1e-30 if radius == 0 else 1e-5}
        assert result.typicality[row, column] == pytest.approx(typical[box][valid[box]].mean(), **exact)
    assert (result.material[~valid] == -1).all() and (result.confidence[~valid] == 0).all()


@pytest.mark.parametrize("kind", ["uint8", "uint16", "float32"])
def test_distinct_colours_equal_each_texel_for_itself(kind):
    # The same colours as 8 bit, 16 bit and floats go three ways through the code.
    pixels = np.random.default_rng(9).integers(0, 256, (50, 40, 3), dtype=np.uint8)
    other = {"uint8": pixels, "uint16": pixels.astype(np.uint16) * 257, "float32": (pixels / 255).astype(np.float32)}[
        kind
    ]
    valid = np.ones((50, 40), bool)
    expected, result = (_classifier(values, valid, 2).window(0, 50, 0, 40) for values in (pixels, other))
    np.testing.assert_array_equal(result.material, expected.material)
    np.testing.assert_allclose(result.confidence, expected.confidence, atol=1e-4)


@pytest.mark.parametrize("radius", [4, 12])
def test_windows_do_not_show(radius):
    pixels = np.random.default_rng(10).integers(0, 256, (90, 33, 3), dtype=np.uint8)
    classifier = _classifier(pixels, np.ones((90, 33), bool), radius)
    whole = classifier.window(0, 90, 0, 33)
    for top in range(0, 90, 20):
        for left in range(0, 33, 7):
            at = np.s_[top : min(top + 20, 90), left : min(left + 7, 33)]
            part = classifier.window(at[0].start, at[0].stop, at[1].start, at[1].stop)
            for name in ("material", "confidence", "typicality"):
                np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[at])


def test_two_halves(job, two_halves, build, library):
    result = build(job(two_halves))
    code = result.code
    assert (code[:, :17] == library[GREEN].code).all() and (code[:, 23:] == library[GREY].code).all()
    assert dict(zip(result.map.names, result.written.usage, strict=True))[GREEN] == pytest.approx(0.5, abs=0.05)
    # One polygon a material: its parts are alike and would tell nothing.
    assert result.map.quality.quality.tested == 0 and 0.85 < result.written.confidence_of_known <= 1


def test_separate_places_are_held_out(job, two_halves, build):
    polygons = {
        GREEN: [[[2, 2], [6, 2], [6, 8]], [[2, 12], [8, 12], [8, 18]]],
        GREY: [[[25, 3], [38, 3], [38, 8]], [[25, 12], [30, 18], [38, 12]]],
    }
    quality = build(job(two_halves, polygons)).map.quality
    assert quality.quality.overall_accuracy == 1 and quality.areas == 4


def test_sixteen_bits(job, write_image, build, library):
    values = np.random.default_rng(12).normal(0, 1500, (20, 40, 3))
    values[:, :20] += (15000, 36000, 13000)
    values[:, 20:] += (31000, 31000, 32000)
    image = write_image("deep.tif", values.astype(np.uint16), "uint16")
    code = build(job(image)).code
    assert (code[:, :12] == library[GREEN].code).all() and (code[:, 28:] == library[GREY].code).all()


def test_known_truth_is_found_again(job, write_image, build, library):
    random = np.random.default_rng(11)
    truth = np.kron(random.integers(0, 3, (6, 8)), np.ones((16, 16), int))
    colours = np.array([[70, 110, 60], [130, 125, 120], [170, 150, 110]])
    pixels = np.clip(colours[truth] + random.normal(0, 14, (*truth.shape, 3)), 0, 255).astype(np.uint8)
    names = [GREEN, GREY, "soil_sand"]
    polygons = {}
    for k, name in enumerate(names):
        rows, columns = np.nonzero(truth[8::16, 8::16] == k)
        polygons[name] = [
            [[16 * c + 4, 16 * r + 4], [16 * c + 11, 16 * r + 4], [16 * c + 11, 16 * r + 11], [16 * c + 4, 16 * r + 11]]
            for r, c in list(zip(rows, columns, strict=True))[:4]
        ]
    image = write_image("patches.png", pixels)
    result = build(job(image, polygons, classifier={"radius": 2}))
    codes = np.array([library[name].code for name in names])
    assert np.mean(result.code == codes[truth]) > 0.93
    assert result.map.quality.quality.overall_accuracy > 0.97 and result.map.quality.quality.mean_iou > 0.95


def test_one_seed_texel_each(job, two_halves, build, library):
    result = build(job(two_halves, {GREEN: [[[3.5, 4.5]]], GREY: [[[30, 10]]]}))
    assert len(result.map.seeds.rows) == 2 and result.map.quality.quality.tested == 0
    code = result.code
    assert np.mean(code[:, :20] == library[GREEN].code) > 0.9 and np.mean(code[:, 20:] == library[GREY].code) > 0.9
    assert np.isfinite(result.confidence).all()


def test_flat_texture(job, write_image, build, library):
    image = write_image("flat.png", np.full((20, 40, 3), 100, np.uint8))
    result = build(job(image))
    assert np.isin(result.code, result.map.codes).all()
    assert (result.confidence < 0.7).all()  # the seeds pull what lies beside them


def test_grey_texture(job, write_image, build, library):
    values = np.where(np.arange(40) < 20, 60, 180).astype(np.uint8)
    image = write_image("grey.png", np.broadcast_to(values[:, np.newaxis], (20, 40, 1)).copy())
    code = build(job(image)).code
    assert (code[:, :19] == library[GREEN].code).all() and (code[:, 21:] == library[GREY].code).all()


def test_high_dynamic_range_with_holes(job, write_image, build, library):
    values = np.full((20, 40, 3), 0.05, np.float32)
    values[:, 20:] = 3e4
    values[:, 30:] = 3e38
    values[5, 5], values[6, 30] = np.nan, np.inf
    result = build(job(write_image("sky.tif", values, "float")))
    code = result.code
    assert code[5, 5] == 0 and code[6, 30] == 0 and np.count_nonzero(code == 0) == 2
    assert np.isfinite(result.confidence).all()
    assert (code[:, :11][code[:, :11] > 0] == library[GREEN].code).all()


def test_one_texel(job, write_image, build, library):
    image = write_image("dot.png", np.full((1, 1, 3), 100, np.uint8))
    result = build(job(image, {GREEN: [[[0, 0]]]}))
    assert result.code.tolist() == [[library[GREEN].code]]
    assert result.confidence[0, 0] == 1


def test_fully_transparent(job, write_image, build, library):
    image = write_image("none.png", np.zeros((20, 40, 4), np.uint8))
    with pytest.raises(InputError, match="no texel with data"):
        build(job(image))


def test_thresholds_give_unknown(job, two_halves, build, library):
    strict = job(two_halves, classifier={"typicality_threshold": 0.2, "speed": "fast", "radius": 0})
    result = build(strict)
    unknown = result.code == 0
    assert unknown.any() and not unknown.all()
    ((_, _, _, found),) = result.map.windows()
    assert (found.typicality[unknown] < 0.2).all() and (found.typicality[~unknown] >= 0.2).all()
    assert result.written.usage.sum() == pytest.approx(1 - unknown.mean())
    sure = build(job(two_halves, classifier={"speed": "fast", "confidence_threshold": 1.0}))
    assert (sure.code[:, 18:22] == 0).any()
