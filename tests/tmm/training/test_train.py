"""Classifiers on texture, model files, calibration."""

import h5py
import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize

from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group, Header, write_file
from skyshine.tmm.classify.calibration import IDENTITY, Calibration, fit_calibration
from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.classify.model_file import read_model, write_model
from skyshine.tmm.classify.trained import Network, TrainedModel
from skyshine.tmm.features.textured import MARGIN, SHADOW_LIGHT, features, in_shadow, light_planes, names
from skyshine.tmm.job.model import TextureJob, TmmJob
from skyshine.tmm.training.library import train_library

GREEN, GREY = "grass_green", "asphalt_road"


def _stack(pixels, encoding="srgb"):
    lab, linear = light_planes(pixels.reshape(-1, 3), encoding)
    return features(
        lab.reshape(3, *pixels.shape[:2]), linear.reshape(3, *pixels.shape[:2]), np.ones(pixels.shape[:2], bool)
    )


def test_features_of_a_flat_texture():
    stack = dict(zip(names(), _stack(np.full((40, 40, 3), (200, 100, 50), np.uint8)), strict=True))
    for radius in (2, 6, 16):
        np.testing.assert_allclose(stack[f"L_{radius}"], stack["L_0"], atol=1e-3)
        # Variance and gradient are 0: what is left is the floor under the logarithm, 0.5 ln 1e-4.
        np.testing.assert_allclose(stack[f"log_deviation_{radius}"], -4.605, atol=0.01)


def test_coherence_tells_stripes_from_noise():
    random = np.random.default_rng(0)
    stripes = np.repeat(random.integers(40, 200, (1, 60, 1), dtype=np.uint8), 60, axis=0).repeat(3, axis=2)
    noise = random.integers(40, 200, (60, 60, 1), dtype=np.uint8).repeat(3, axis=2)
    of = names().index("coherence_12")
    assert _stack(stripes)[of].min() > 0.95 and _stack(noise)[of].max() < 0.5


def test_windows_with_margin_have_the_same_features():
    pixels = np.random.default_rng(1).integers(0, 255, (120, 110, 3), dtype=np.uint8)
    part = _stack(pixels[20:100, 10:90].copy())[:, MARGIN:-MARGIN, MARGIN:-MARGIN]
    whole = _stack(pixels)[:, 20 + MARGIN : 100 - MARGIN, 10 + MARGIN : 90 - MARGIN]
    np.testing.assert_allclose(part, whole, atol=2e-3)


def test_shadow_dims_by_the_skylight_share():
    pixels = np.full((90, 90, 3), 188, np.uint8)
    linear, shadow = in_shadow(pixels, "srgb", np.random.default_rng(2))
    left = linear[shadow].min(axis=0) / linear.max(axis=(0, 1))
    assert 0.3 < shadow.mean() < 0.7
    assert (left > 0.3 * np.array(SHADOW_LIGHT)).all() and (left < 3 * np.array(SHADOW_LIGHT)).all()
    assert left[2] > left[0]


@pytest.fixture
def striped(write_image):
    """Two materials of one mean colour: stripes on the left, noise of the same values on the right."""
    random = np.random.default_rng(4)
    values = random.integers(60, 180, (96, 128, 1), dtype=np.uint8)
    values[:, :64] = np.where(np.arange(64)[np.newaxis, :, np.newaxis] // 3 % 2, 70, 170)
    return write_image("striped.png", values.repeat(3, axis=2))


POLYGONS = {
    GREEN: [[[5, 5], [15, 5], [15, 20], [5, 20]], [[40, 70], [50, 70], [50, 88], [40, 88]]],
    GREY: [[[100, 5], [110, 5], [110, 20], [100, 20]], [[85, 70], [95, 70], [95, 88], [85, 88]]],
}


def test_texture_tells_what_colour_cannot(build, striped, library):
    job = {"image": striped, "seeds": {"polygons": POLYGONS}, "held_out": {"folds": 2}}
    result = build(TextureJob.model_validate(job))
    truth = np.where(np.arange(128) < 64, library[GREEN].code, library[GREY].code)
    assert np.mean(result.code == truth) > 0.95
    assert result.map.quality.quality.overall_accuracy > 0.95


def test_model_file(build, striped, library, tmp_path):
    pytest.importorskip("sklearn")
    job = TextureJob.model_validate({"image": striped, "seeds": {"polygons": POLYGONS}, "classifier": {"radius": 2}})
    model, held = train_library(TmmJob(textures=(job, job.model_copy(update={"name": "again"}))), tmp_path, library)
    assert held.quality.tested > 0
    digest = write_model(model, tmp_path / "a.tmm-model.h5", "job", "1", {})
    again = read_model(tmp_path / "a.tmm-model.h5")
    assert write_model(again, tmp_path / "b.tmm-model.h5", "job", "1", {}) == digest
    assert problems(tmp_path / "a.tmm-model.h5") == []
    assert (tmp_path / "a.tmm-model.h5").read_bytes() == (tmp_path / "b.tmm-model.h5").read_bytes()
    result = build(TextureJob.model_validate({"image": striped, "model": "a.tmm-model.h5"}))
    assert "a.tmm-model.h5" in result.map.files and set(result.map.names) == {GREEN, GREY}
    truth = np.where(np.arange(128) < 64, library[GREEN].code, library[GREY].code)
    assert np.mean(result.code == truth) > 0.9


@pytest.mark.parametrize("kind", ["one texel", "one row", "flat", "grey", "one seed each", "16 bit", "holes"])
def test_hard_cases_of_seeds(build, write_image, library, kind):
    random = np.random.default_rng(8)
    values = random.integers(0, 90, (20, 40, 3)) + np.where(np.arange(40) < 20, 20, 140)[:, np.newaxis]
    polygons = {GREEN: [[[2, 2], [12, 2], [12, 15]]], GREY: [[[25, 3], [38, 3], [38, 12]]]}
    name, form = "a.png", "uint8"
    if kind == "one texel":
        values, polygons = values[:1, :1], {GREEN: [[[0, 0]]]}
    elif kind == "one row":
        values, polygons = values[:1], {GREEN: [[[3, 0]]], GREY: [[[30, 0]]]}
    elif kind == "flat":
        values[:] = 100
    elif kind == "grey":
        values = values[..., :1]
    elif kind == "one seed each":
        polygons = {GREEN: [[[3.5, 4.5]]], GREY: [[[30, 10]]]}
    elif kind == "16 bit":
        values, form = values * 257, "uint16"
    elif kind == "holes":
        name, form, values = "a.tif", "float", values / 255
        values[5, 5], values[6, 30], values[:, 39] = np.nan, np.inf, 3e38
    image = write_image(
        name, np.ascontiguousarray(values.astype({"uint16": np.uint16, "float": np.float32}.get(form, np.uint8))), form
    )
    result = build(TextureJob.model_validate({"image": image, "seeds": {"polygons": polygons}}))
    holes = np.zeros(result.code.shape, bool)
    if kind == "holes":
        holes[5, 5] = holes[6, 30] = True
    assert ((result.code == 0) == holes).all() and np.isin(result.code[~holes], result.map.codes).all()
    assert np.isfinite(result.confidence).all() and (result.confidence >= 0).all() and (result.confidence <= 1).all()


def test_a_model_that_was_changed_is_refused(tmp_path):
    colour = GaussianModel(("a", "b"), np.zeros((2, 3)), np.stack([np.eye(3)] * 2), np.log([0.5, 0.5]))
    file = tmp_path / "a.tmm-model.h5"
    wide = len(names())
    layers = np.zeros(wide), np.ones(wide), np.zeros((wide, 1)), np.zeros(1), np.zeros((1, 2)), np.zeros(2)
    network = Network(*(layer.astype(np.float32) for layer in layers))
    write_model(TrainedModel(("a", "b"), colour, network), file, "job", "1", {})
    assert read_model(file).names == ("a", "b") and problems(file) == []
    with h5py.File(file, "r+") as content:
        content["calibration"].attrs["slope"] = 2.0
    with pytest.raises(InputError, match="content_sha256 does not match"):
        read_model(file)
    with h5py.File(file, "r+") as content:
        content["colour/covariance"][1] = -np.eye(3)
    assert any("form a positive definite matrix" in line for line in problems(file))


def test_not_a_model(tmp_path, build, striped):
    (tmp_path / "a.tmm-model.h5").write_bytes(b"nothing")
    with pytest.raises(InputError, match="not a readable HDF5 file"):
        read_model(tmp_path / "a.tmm-model.h5")
    write_file(tmp_path / "b.tmm-model.h5", Group(), Header("tmm-model", "", ""))
    with pytest.raises(InputError, match="lacks a part of a classifier"):
        read_model(tmp_path / "b.tmm-model.h5")
    write_file(tmp_path / "c.tmm-model.h5", Group(), Header("tmm-model", "", ""))
    with h5py.File(tmp_path / "c.tmm-model.h5", "r+") as file:
        file.attrs["format_version"] = "2.0.0"
    with pytest.raises(InputError, match="format_version '2.0.0'"):
        build(TextureJob.model_validate({"image": striped, "model": "c.tmm-model.h5"}))


def test_calibration_recovers_a_known_distortion():
    random = np.random.default_rng(5)
    odds = random.normal(0.5, 1.5, 40_000)
    right = random.random(40_000) < stats.logistic.cdf(odds)
    said = stats.logistic.cdf(odds * 3)  # three times too sure
    found = fit_calibration(said, right, np.arange(40_000))
    assert found.slope == pytest.approx(1 / 3, abs=0.02) and found.offset == pytest.approx(0, abs=0.05)
    assert np.abs(found(said) - stats.logistic.cdf(odds)).mean() < 0.01


@pytest.mark.parametrize("case", range(6))
def test_calibration_is_where_an_optimiser_finds_it(case):
    """Of the same regularised loss, by scipy within the same limits; in the last cases some limits hold."""
    random = np.random.default_rng(case)
    said = random.uniform(0.3, 0.99, 400)
    right = random.random(400) < (said**2 if case < 4 else 0.0 if case == 4 else 1 - said)
    odds, n = np.log(said / (1 - said)), right.sum()
    target = np.where(right, (n + 1) / (n + 2), 1 / (400 - n + 2))

    def loss(parameters):
        z = parameters[0] * odds + parameters[1]
        return np.sum(np.logaddexp(0, z) - target * z) + 0.5 * ((parameters[0] - 1) ** 2 + parameters[1] ** 2)

    wanted = minimize(loss, [1.0, 0.0], bounds=[(0, 10), (-10, 10)], method="L-BFGS-B", options={"ftol": 1e-15}).x
    found = fit_calibration(said, right, np.arange(400))
    np.testing.assert_allclose([found.slope, found.offset], wanted, atol=1e-3)
    assert (found.slope == 0) == (case >= 4)


def test_calibration_of_nothing_and_of_little():
    assert fit_calibration(np.empty(0), np.empty(0, bool), np.empty(0, int)) == IDENTITY
    # One region, however many texels it has, moves what the classifier says no further than to two right in three.
    one = fit_calibration(np.full(5000, 0.9), np.ones(5000, bool), np.zeros(5000, int))
    assert 0.75 < one(np.array([0.9], np.float32))[0] < 0.95
    assert Calibration(2.0, -1.0)(np.array([0.0, 0.5, 1.0], np.float32)) == pytest.approx(
        [0, 1 / (1 + np.e), 1], abs=1e-3
    )


def test_a_model_does_not_learn_what_is_unknown(striped, library, tmp_path):
    pytest.importorskip("sklearn")
    polygons = POLYGONS | {"unknown": [[[60, 30], [70, 30], [70, 40]]]}
    job = TextureJob.model_validate({"image": striped, "seeds": {"polygons": polygons}})
    model, _ = train_library(TmmJob(textures=(job,)), tmp_path, library)
    assert set(model.names) == {GREEN, GREY}
