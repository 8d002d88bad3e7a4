"""Errors of atmospheric quantities in kelvin and percent."""

import numpy as np
import pytest

from skyshine.mat.measure.scale import PERCENT_PER_KELVIN, REFLECTANCE, Scale
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance

WINDOW, NEAR = SpectralResponse.rectangular(8, 12), SpectralResponse.rectangular(0.9, 1.7)
ONE = np.ones(1)


def test_a_kelvin_is_that_of_a_black_body_at_300_k():
    change = float(np.diff(band_radiance(WINDOW, np.array([300.0, 300.01])))[0])
    error = Scale.of_unit("K", WINDOW, 0.0).error("path_radiance_ratio", ONE + change, ONE, 0 * ONE, ONE)
    assert error == pytest.approx(0.01, rel=1e-3)


def test_a_percent_is_of_a_black_body_where_it_emits_and_of_sunlight_where_it_does_not():
    whole = float(band_radiance(WINDOW, 300.0))
    assert Scale.of_unit("%", WINDOW, 50.0).error("path_radiance_ratio", ONE + whole, ONE, 0 * ONE, ONE) == (
        pytest.approx(100.0)
    )
    sunlit = 0.3 * 50.0 / np.pi  # W m^-2 sr^-1 of a matt surface under 50 W m^-2
    for unit, hundredth in (("%", 1.0), ("K", 1 / 3)):
        scale = Scale.of_unit(unit, NEAR, 50.0)
        assert scale.error("path_radiance_ratio", ONE + 0.01 * sunlit, ONE, 0 * ONE, ONE) == pytest.approx(hundredth)
    # Direct light all lost is the whole surface; nothing seen through the path is that surface's light too.
    assert Scale.of_unit("%", NEAR, 50.0).error("direct_radiance", 0 * ONE, ONE * 50 / np.pi, ONE, ONE) == (
        pytest.approx(-100.0)
    )
    assert (REFLECTANCE, PERCENT_PER_KELVIN) == (0.3, 3.0)  # as the job's keys say


def test_percent_of_a_path_that_is_brighter_than_the_scene_are_of_its_own_light():
    scale = Scale.of_unit("%", NEAR, 50.0)
    aureole = ONE * 40 * scale.background
    for through in (0.0, 0.5):
        path = aureole * (1 - through)
        error = scale.error("path_radiance_ratio", 1.02 * aureole, aureole, through * ONE, ONE)
        assert error == pytest.approx(2.0)
        assert path[0] > scale.background
    # Kelvin are of the scene at 300 K, whatever is in front of it.
    kelvin, bright = Scale.kelvin(WINDOW), ONE * 4 * Scale.kelvin(WINDOW).background
    one, two = (kelvin.error("path_radiance_ratio", base + 0.1, base, 0 * ONE, ONE) for base in (ONE, bright))
    assert one == pytest.approx(two)


def test_radiance_counts_as_it_is_and_other_units_are_refused():
    assert Scale.of_unit("W m^-2 sr^-1", NEAR, 1.0).factor == 1
    with pytest.raises(ValueError, match="unit 'F'; known: K, %, W m"):
        Scale.of_unit("F", NEAR, 1.0)


def test_percent_of_no_light_are_not_a_number():
    assert np.isnan(Scale.of_unit("%", NEAR, 0.0).factor) and np.isnan(Scale.of_unit("K", NEAR, 0.0).factor)
