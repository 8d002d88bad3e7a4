"""Kelvin per radiance against the derivative of Planck's law."""

import numpy as np
import pytest

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import kelvin_per_radiance, reference_radiance


@pytest.mark.parametrize("wavelength", [2.6, 4.0, 10.0])
def test_a_narrow_band_follows_the_derivative_of_plancks_law(wavelength):
    """dL/dT = L x exp(x) / (T (exp(x) - 1)) with x = c2 / (wavelength T), by the radiation constants of CODATA 2018."""
    x, width = 14387.76877 / (wavelength * 300.0), 1e-3
    radiance = 1.191042972e8 / wavelength**5 / np.expm1(x) * width
    response = SpectralResponse.rectangular(wavelength - width / 2, wavelength + width / 2)
    assert reference_radiance(response) == pytest.approx(radiance, rel=1e-5)
    assert 1 / kelvin_per_radiance(response) == pytest.approx(-radiance * x / (300.0 * np.expm1(-x)), rel=2e-4)


def test_a_band_that_ends_before_two_and_a_half_micrometres_has_no_equivalent_temperature():
    assert np.isnan(kelvin_per_radiance(SpectralResponse.rectangular(2.0, 2.49)))
    assert kelvin_per_radiance(SpectralResponse.rectangular(2.0, 2.51)) > 0
