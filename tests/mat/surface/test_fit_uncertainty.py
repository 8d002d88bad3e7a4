"""Standard errors under noise that hangs together, against closed forms and against many draws."""

import numpy as np
import planted_skin
import pytest

from skyshine.mat.surface.fit_uncertainty import not_identified, uncertainty
from skyshine.mat.surface.free_parameters import FreeParameter
from skyshine.mat.surface.skin_errors import skin_errors

COUNT, STEP = 2000, 1800.0
DAILY = np.sin(2 * np.pi * np.arange(COUNT) / 48)


def left_of(noise, slopes):
    """Residuals of a linear fit to noise, and the parameters that it finds."""
    found = np.linalg.lstsq(slopes, noise, rcond=None)[0]
    return noise - slopes @ found, found


def test_white_noise_has_the_errors_of_the_textbook():
    slopes = np.stack([np.ones(COUNT), DAILY], axis=1)
    residual, _ = left_of(np.random.default_rng(1).normal(size=COUNT), slopes)
    found = uncertainty(residual, slopes, STEP)
    assert found.standard == pytest.approx([COUNT**-0.5, (COUNT / 2) ** -0.5], rel=0.15)
    assert found.effective > 0.8 * COUNT and abs(found.correlation[0, 1]) < 0.05
    assert found.factor == pytest.approx(2.81, abs=0.01)  # normal quantile of 1 - 0.01 / 4


def test_mean_of_an_autoregression():
    """Its variance is (1 + a) / (1 - a) / n of the noise's: Bayley and Hammersley (1946)."""
    decay, slopes = 0.9, np.ones((COUNT, 1))
    residual, _ = left_of(planted_skin.autoregression(COUNT, decay, 3), slopes)
    found = uncertainty(residual, slopes, STEP)
    assert found.effective == pytest.approx(COUNT * (1 - decay) / (1 + decay), rel=0.25)
    assert found.standard[0] == pytest.approx((COUNT * (1 - decay) / (1 + decay)) ** -0.5, rel=0.15)


def test_errors_are_those_of_many_draws():
    """Short records, part of them without readings: 95 % of draws lie within 1.96 standard errors."""
    known = np.ones(288, bool)
    known[100:130] = False
    slopes = np.stack([np.ones(288), DAILY[:288]], axis=1)
    within = []
    for seed in range(200):
        noise = planted_skin.autoregression(288, 0.88, seed)
        residual, found = left_of(noise[known], slopes[known])
        whole = np.full(288, np.nan)
        whole[known] = residual
        within += list(np.abs(found) < 1.96 * uncertainty(whole, slopes, STEP).standard)
    assert 0.9 < np.mean(within) < 0.98


def test_errors_that_a_fit_of_many_parameters_takes_are_given_back():
    """Seven parameters take half of the slow errors of five days: without their share errors would be too small."""
    turns = 2 * np.pi * np.arange(240)[:, None] / 240 * [1, 2, 5]
    slopes = np.hstack([np.ones((240, 1)), np.sin(turns), np.cos(turns)])
    known = np.arange(240) % 48 < 40
    squares = []
    for seed in range(150):
        noise = planted_skin.autoregression(240, 0.9, seed)
        residual, found = left_of(noise[known], slopes[known])
        whole = np.full(240, np.nan)
        whole[known] = residual
        squares.append((found / uncertainty(whole, slopes, STEP).standard) ** 2)
    assert 0.8 < np.mean(squares) < 1.2


def test_what_the_record_cannot_tell_is_named():
    parameters = [FreeParameter(name, "1", 0.5, 0.0, 1.0, False) for name in ("wetness", "albedo", "emissivity")]
    random = np.random.default_rng(2)
    alike = DAILY + 0.01 * random.normal(size=COUNT)
    slopes = np.stack([DAILY, alike, 1e-3 * np.ones(COUNT)], axis=1)
    residual, _ = left_of(random.normal(size=COUNT), slopes)
    notes = not_identified(parameters, np.array([0.5, 1.0, 0.5]), uncertainty(residual, slopes, STEP))
    text = "\n".join(notes)
    assert "wetness and albedo cannot be distinguished by this record: correlation -1.000; fix one of them" in text
    assert "albedo ended at its bound 1; fix it, or ask what else is wrong" in text
    assert "emissivity is not identified by this record: its interval spans 100 % of its bounds; fix it" in text


def test_a_parameter_without_effect_is_uncertain_not_wrong():
    slopes = np.stack([np.ones(COUNT), np.zeros(COUNT)], axis=1)
    found = uncertainty(np.random.default_rng(1).normal(size=COUNT), slopes, STEP)
    assert found.standard[0] < 0.1 and found.standard[1] > 1e4


def test_bias_and_rms_by_day_and_night():
    measured = np.array([280.0, 290.0, np.nan, 300.0])
    parts = {"fitted": np.array([True, True, True, False]), "held out": np.array([False, False, False, True])}
    errors = skin_errors(measured, {"fit": np.array([283.0, 291.0, 1.0, 298.0])}, np.array([0.0, 500, 500, 500]), parts)
    found = {(each.part, each.hours): (each.bias, each.rms, each.count) for each in errors}
    assert found["fitted", "all"] == pytest.approx((2.0, np.sqrt(5.0), 2))
    assert found["fitted", "day"] == (1.0, 1.0, 1) and found["fitted", "night"] == (3.0, 3.0, 1)
    assert found["held out", "all"] == (-2.0, 2.0, 1) and ("held out", "night") not in found
