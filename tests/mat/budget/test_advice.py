"""Error without the sources of each key: planted errors of sources whose sum is the error of the pixel."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.budget.advice import KEYS, NO_KEY, OF_THE_METHOD, described, gains, headline
from skyshine.mat.budget.budget import PIXEL_SOURCES
from skyshine.mat.budget.sizes import kelvin, measures, reported
from skyshine.mat.budget.summary import by_size
from skyshine.mat.radiometry.blackbody import SpectralResponse

COUNT = 400


def budget(sizes, response=(0.7, 0.9), near=None, **extra):
    """A budget whose sources err at random by given rms; below 2.5 um errors are told in radiance."""
    generator = np.random.default_rng(2)
    errors = {name: size * generator.standard_normal((COUNT, 1)) for name, size in sizes.items()}
    counted = {}
    if near is not None:
        counted = {name: ~near if name != "near_range" else near for name in sizes}
    pixel = sum(
        np.where(counted[name][:, None], error, 0.0) if name in counted else error for name, error in errors.items()
    )
    return SimpleNamespace(
        state=1,
        source="sun",
        response=SpectralResponse.rectangular(*response),
        radiance=np.full((COUNT, 1), 40.0),
        errors={**errors, "pixel": pixel, **extra},
        counted=counted,
    )


def test_every_source_of_a_pixel_has_one_place():
    named = [name for names in (*KEYS.values(), OF_THE_METHOD) for name in names]
    assert sorted(named) == sorted(PIXEL_SOURCES)


def test_without_a_key_the_rest_is_left():
    first, second, third = gains(budget({"temperature_table": 3.0, "solver_steps": 0.4, "shade": 1.0}))
    assert [first.key, second.key] == ["surface_grid: {tolerance: ...}", NO_KEY]
    assert first.before == pytest.approx(np.hypot(3, np.hypot(0.4, 1.0)), rel=0.1)
    assert first.after == pytest.approx(np.hypot(0.4, 1.0), rel=0.1)
    assert third.key == "accuracy: {solver_steps: ...}" and 0 < third.share < 0.05 < first.share


def test_sources_of_one_key_go_together():
    (gain,) = gains(budget({"beta_star_table": 2.0, "ambient_table": 1.0}))
    assert gain.sources == ("beta_star_table", "ambient_table") and gain.after == pytest.approx(0.0, abs=1e-12)


def test_a_source_counts_on_its_views_alone():
    """Beyond 100 m the tables of paths, within 100 m those near by: each is taken away where it counts."""
    near = np.arange(COUNT) % 4 == 0
    (gain,) = gains(budget({"beta_star_table": 1.0, "near_range": 5.0}, near=near))
    assert gain.after == pytest.approx(0.0, abs=1e-12)


def test_a_source_that_cancels_another_gains_nothing():
    one = budget({"solver_steps": 1.0, "temperature_table": 0.0})
    one.errors["temperature_table"] = -0.5 * one.errors["solver_steps"]
    one.errors["pixel"] = one.errors["solver_steps"] + one.errors["temperature_table"]
    by_key = {gain.key: gain for gain in gains(one)}
    assert by_key["surface_grid: {tolerance: ...}"].share == pytest.approx(-1.0)
    assert by_key["accuracy: {solver_steps: ...}"].share == pytest.approx(0.0)
    assert "no single key takes more than 0%" in headline([one])


def test_the_headline_names_the_worst_and_its_key():
    fine, rough = budget({"solver_steps": 0.1}), budget({"compiled_band": 2.0, "solver_steps": 0.1}, (8.0, 12.0))
    text = headline([fine, rough])
    assert "8-12 µm" in text and "accuracy: {spectral_tolerance: ...} could take that to" in text and " K rms" in text
    assert "which no key makes smaller" in headline([budget({"shade": 2.0, "solver_steps": 0.1})])
    assert "W m⁻² sr⁻¹" in headline([fine])
    assert headline([]) == "Nothing was measured."


def test_the_headline_is_the_row_as_a_runtime_has_it():
    """With 4.6 K in a frame's row and 0.3 K at each pixel, the former is named first."""
    fine = budget({"solver_steps": 0.3}, (8.0, 12.0))
    fine.errors["all"] = 20.0 * fine.errors["pixel"]
    frame, pixel = (_kelvin(fine, name) for name in ("all", "pixel"))
    text = headline([fine])
    assert (
        text.startswith(f"The error of a pixel is {frame:.2g} K rms and within ") and f"{pixel:.2g} K rms where" in text
    )


def test_few_pixels_have_no_percentile():
    few = budget({"solver_steps": 0.3}, (8.0, 12.0))
    few.errors = {name: error[:199] for name, error in few.errors.items()}
    few.radiance = few.radiance[:199]
    assert "99 %" not in headline([few]) and "99 %" in headline([budget({"solver_steps": 0.3}, (8.0, 12.0))])
    assert np.isnan(reported(np.ones(400), np.arange(400) < 150)["p99"])


def _kelvin(one, name):
    return measures(kelvin(one, one.errors[name]))["rms"]


def test_kelvin_where_they_mean_something():
    assert described(budget({"shade": 1.0}))[0]["pixel"]["units"] == "W m^-2 sr^-1"
    thermal = described(budget({"shade": 1.0}, (8.0, 12.0)))[0]
    # 1 W m^-2 sr^-1 of 40 in 8 to 12 um, near 305 K: by Planck's slope 1.5 to 1.7 % a kelvin
    assert thermal["pixel"]["units"] == "K" and 1.3 < thermal["pixel"]["value"] < 1.9


def test_errors_fall_after_what_stands_for_several():
    def error(rms, kelvin=True):
        return {"temperature": {"rms": {"value": rms if kelvin else None}}, "radiance": {"rms": {"value": rms}}}

    errors = {"shade": error(0.1), "pixel": error(1.0), "ambient_table": error(0.9), "all": error(2.0)}
    assert by_size(errors) == ["all", "pixel", "ambient_table", "shade"]
    assert by_size({name: error(rms, False) for name, rms in (("shade", 1), ("solver_steps", 2))}) == [
        "solver_steps",
        "shade",
    ]
