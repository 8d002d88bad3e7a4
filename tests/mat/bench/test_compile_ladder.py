"""The ladder of compiled bands: more points err less, in kelvin of a pixel; shared points cost their test alone."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.compile import fit_band
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.bench import compile_ladder as bench
from skyshine.mat.bench.ladders import GRID
from skyshine.mat.bench.whole import compile_ladders
from skyshine.mat.measure.scale import Scale
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table

BAND = (10.5, 10.6)
LIMITS = {"max_points": 64, "seed": 0}


def test_a_smaller_tolerance_takes_more_points_and_errs_less():
    rms, percentile = compile_ladders([BAND], (0.05, 1e-3))
    loose, default, shared = (rung.name for rung in rms.rungs)
    assert loose.startswith("tolerance 0.05, ") and shared.startswith("shared with similar days, ")
    points = [int(name.split(", ")[1].removesuffix(" points")) for name in (loose, default, shared)]
    assert points[0] < points[1] <= 64 and points[0] < points[2] <= 64
    for ladder in (rms, percentile):
        assert 0 < ladder.rungs[1].error < ladder.rungs[0].error and 0 < ladder.rungs[2].error < ladder.rungs[0].error
        assert [rung.default for rung in ladder.rungs] == [False, True, False]
    assert all(one.error < other.error for one, other in zip(rms.rungs, percentile.rungs, strict=True))


def test_the_errors_of_a_pixel_are_those_of_what_is_seen_through_the_path_and_of_the_path():
    response = SpectralResponse.rectangular(*BAND)
    band = band_points(absorption_table().points(*response.wavenumber_range), response)
    sun, state, scale = solar_irradiance(band.wavenumber, band.width), bench._day(290.0, 0.7), Scale.kelvin(response)
    fit = fit_band(state, band, GRID, sun, tolerance=1e-3, **LIMITS)
    same = replace(fit, approximate=replace(fit.exact, first=np.arange(fit.exact.first.size)))
    few = replace(fit.chosen, index=fit.exact.first)
    assert np.all(bench.pixel_errors(replace(same, chosen=few), state.surface_temperature, sun, scale) == 0)
    # One hundredth less transmittance takes a hundredth of what a black body at 300 K sends.
    darker = {**same.approximate.unlit, "transmittance": same.approximate.unlit["transmittance"] - 0.01}
    less = replace(same, approximate=replace(same.approximate, unlit=darker), chosen=few)
    errors = bench.pixel_errors(less, state.surface_temperature, sun, scale)
    assert errors == pytest.approx(0.01 * scale.background * scale.factor)
    assert 0.3 < errors[0] < 1.0  # K: dT = T^2 lambda / c2 of 1 % at 300 K and 10.55 um is .66 K
