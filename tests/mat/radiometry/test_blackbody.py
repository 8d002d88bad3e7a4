"""Blackbody radiance and band responses against published constants, quadrature and their own bounds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import constants
from scipy.integrate import quad

from skyshine.mat.radiometry.blackbody import (
    SpectralResponse,
    band_radiance,
    brightness_temperature,
    planck_wavelength,
    planck_wavenumber,
)
from skyshine.schemas.errors import InputError

LWIR = SpectralResponse.rectangular(8.0, 12.0)
MWIR = SpectralResponse.rectangular(3.0, 5.0)


@pytest.mark.parametrize("temperature", [3.0, 300.0, 6000.0])
def test_all_wavelengths_give_stefan_boltzmann(temperature):
    everything = SpectralResponse.rectangular(100.0 / temperature, 3e7 / temperature)
    radiance = band_radiance(everything, temperature)
    assert radiance == pytest.approx(constants.Stefan_Boltzmann * temperature**4 / np.pi, rel=1e-6)


@pytest.mark.parametrize("product, fraction", [(2000.0, 0.066728), (3000.0, 0.273232), (6000.0, 0.737818)])
def test_blackbody_fractions_agree_with_the_published_table(product, fraction):
    """Fraction of blackbody radiation below a wavelength-temperature product [um K]; Incropera, table 12.1."""
    temperature = 500.0
    below = SpectralResponse.rectangular(100.0 / temperature, product / temperature)
    total = constants.Stefan_Boltzmann * temperature**4 / np.pi
    assert band_radiance(below, temperature) / total == pytest.approx(fraction, abs=2e-4)


def test_the_peak_follows_wiens_displacement_law():
    wavelength = np.linspace(9.0, 10.0, 100_001)
    peak = wavelength[np.argmax(planck_wavelength(wavelength, 300.0))]
    assert peak * 300.0 == pytest.approx(2897.771955, abs=0.01)  # CODATA


def test_wavenumber_and_wavelength_forms_agree():
    wavelength = np.geomspace(0.3, 100.0, 50)
    per_wavenumber = planck_wavenumber(1e4 / wavelength, 300.0)
    assert per_wavenumber * 1e4 / wavelength**2 == pytest.approx(planck_wavelength(wavelength, 300.0), rel=1e-12, abs=0)


def test_radiance_of_extreme_temperatures_is_finite():
    with np.errstate(all="raise", under="ignore"):
        values = planck_wavelength(np.array([[0.1], [100.0]]), np.array([0.0, 3.0, 300.0, 6000.0]))
        band_radiance(SpectralResponse.rectangular(0.1, 100.0), np.array([0.0, 3.0, 6000.0]))
    assert np.all(np.isfinite(values)) and np.all(values >= 0.0)
    assert np.all(values[:, 0] == 0.0)


@pytest.mark.parametrize("temperature", [-1.0, np.nan, np.inf])
def test_impossible_temperatures_are_refused(temperature):
    with pytest.raises(InputError, match="finite and not negative"):
        planck_wavenumber(1000.0, temperature)
    with pytest.raises(InputError, match="finite and not negative"):
        band_radiance(LWIR, [300.0, temperature])


@pytest.mark.parametrize("temperature", [50.0, 150.0, 300.0, 1500.0])
def test_band_radiance_agrees_with_adaptive_quadrature(temperature):
    table = SpectralResponse([3.0, 3.4, 4.1, 4.4, 5.0], [0.0, 0.8, 2.0, 0.5, 0.3])

    def integrand(wavelength):
        return planck_wavelength(wavelength, temperature) * np.interp(
            wavelength, [3.0, 3.4, 4.1, 4.4, 5.0], [0.0, 0.4, 1.0, 0.25, 0.15]
        )

    exact = quad(integrand, 3.0, 5.0, points=[3.4, 4.1, 4.4], epsabs=0.0, epsrel=1e-11, limit=200)[0]
    assert band_radiance(table, temperature) == pytest.approx(exact, rel=1e-9, abs=0)


@given(st.floats(20.0, 3000.0))
def test_brightness_temperature_inverts_band_radiance(temperature):
    for response in (LWIR, MWIR):
        assert brightness_temperature(response, band_radiance(response, temperature)) == pytest.approx(
            temperature, rel=1e-12
        )


def test_brightness_temperature_is_monotone_and_keeps_shape():
    radiance = np.concatenate([[0.0], np.geomspace(1e-300, 1e9, 2000)])
    temperature = brightness_temperature(MWIR, radiance)
    assert temperature[0] == 0.0 and np.all(np.diff(temperature) > 0.0) and np.all(np.isfinite(temperature))
    assert brightness_temperature(MWIR, radiance[1:].reshape(20, 100)).shape == (20, 100)
    assert brightness_temperature(MWIR, np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(("lower", "upper"), [(0.1, 0.2), (0.1, 100.0), (900.0, 1000.0)])
def test_enormous_radiances_follow_the_law_of_rayleigh_and_jeans(lower, upper):
    """Far above h c / (k wavelength) a band shines with 2 c k T times the integral of wavelength^-4."""
    per_kelvin = 2 * constants.c * constants.k * 1e18 * (lower**-3 - upper**-3) / 3
    temperature = np.geomspace(1e15, 1e240, 200)
    response = SpectralResponse.rectangular(lower, upper)
    assert brightness_temperature(response, temperature * per_kelvin) == pytest.approx(temperature, rel=1e-9)


@pytest.mark.parametrize("radiance", [-1e-9, np.nan, np.inf])
def test_impossible_radiances_are_refused(radiance):
    with pytest.raises(InputError, match="brightness temperature"):
        brightness_temperature(LWIR, radiance)


def test_response_edges_belong_to_the_band():
    for lower, upper in [(8.0, 12.0), (3.0, 5.0), (3.3, 4.7), (7.7, 13.1)]:
        response = SpectralResponse.rectangular(lower, upper)
        assert np.all(response.at_wavenumber(1e4 / np.array([lower, upper])) == 1.0)
        assert np.all(response.at_wavenumber(1e4 / np.array([lower - 1e-6, upper + 1e-6])) == 0.0)
        assert np.all(response.at_wavenumber(response.wavenumber_range) == 1.0)


def test_a_band_from_8_to_12_and_a_half_um_reaches_from_800_to_1250_waves_in_a_centimetre():
    assert SpectralResponse.rectangular(8.0, 12.5).wavenumber_range == pytest.approx((800.0, 1250.0), rel=1e-12)


def test_response_is_scaled_to_its_peak():
    assert np.max(SpectralResponse([8.0, 9.0, 10.0], [0.0, 37.0, 5.0]).response) == 1.0


@pytest.mark.parametrize(
    "wavelength, response, message",
    [
        ([8.0], [1.0], "two equally long"),
        ([8.0, 9.0], [1.0], "two equally long"),
        ([9.0, 8.0], [1.0, 1.0], "strictly increasing"),
        ([8.0, 8.0], [1.0, 1.0], "strictly increasing"),
        ([0.0, 8.0], [1.0, 1.0], "above 0"),
        ([8.0, 9.0], [1.0, -0.1], "not negative"),
        ([8.0, 9.0], [1.0, np.nan], "finite"),
        ([8.0, 9.0], [0.0, 0.0], "0 everywhere"),
    ],
)
def test_tables_that_are_no_response_are_refused(wavelength, response, message):
    with pytest.raises(InputError, match=message):
        SpectralResponse(wavelength, response)


@pytest.mark.parametrize("lower, upper", [(12.0, 8.0), (8.0, 8.0), (-1.0, 8.0), (np.nan, 8.0), (8.0, np.inf)])
def test_bands_that_are_empty_or_reversed_are_refused(lower, upper):
    with pytest.raises(InputError, match="from a lower to a higher"):
        SpectralResponse.rectangular(lower, upper)
