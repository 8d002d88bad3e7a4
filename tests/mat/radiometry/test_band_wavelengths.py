"""Spectra at few wavelengths: what they stand for, against means over the band computed on the spectra themselves."""

import numpy as np
import pytest

from skyshine.mat.radiometry.band_wavelengths import (
    band_wavelengths,
    emission_shares,
    parted,
    reflectance_spectra,
)
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.mat.radiometry.reflectance import band_reflectance
from skyshine.materials.library import load_library

FILTER = SpectralResponse([2.9, 3.3, 3.4, 4.6, 4.7, 5.2], [0.0, 0.1, 0.9, 1.0, 0.4, 0.0])
BANDS = [SpectralResponse.rectangular(3.0, 5.0), SpectralResponse.rectangular(8.0, 12.0), FILTER]
KELVIN = np.array([200.0, 300.0, 1000.0])


@pytest.mark.parametrize("response", BANDS, ids=["3-5", "8-12", "filter"])
def test_materials_reflect_thermal_light_as_their_spectra_do(response):
    library = load_library()
    materials = [library[name] for name in library.names]
    spectra, shares = reflectance_spectra(materials, response), emission_shares(response, KELVIN)
    exact = np.array([band_reflectance(material, response, "planck", KELVIN) for material in materials])
    assert spectra @ shares.T == pytest.approx(exact, abs=1.5e-3)


def test_a_spectrum_that_is_linear_between_the_wavelengths_is_itself():
    response = BANDS[0]
    material = load_library()["concrete"]
    nodes = band_wavelengths(response)
    values = np.linspace(0.1, 0.6, nodes.size) ** 2
    replaced = type("Spectrum", (), {"wavelength": nodes, "reflectance": values, "name": material.name})()
    assert reflectance_spectra([replaced], response)[0] == pytest.approx(values, abs=1e-6)


def test_the_mean_of_a_spectrum_with_a_narrow_line_is_kept():
    """A line of a third of the distance between two wavelengths, from 0.1 to 0.9."""
    response = BANDS[0]
    nodes = band_wavelengths(response)
    step, line = nodes[1] - nodes[0], nodes[3] + 0.5 * (nodes[1] - nodes[0])
    wavelength = np.linspace(nodes[0], nodes[-1], 20_001)
    values = np.where(np.abs(wavelength - line) < step / 6, 0.9, 0.1)
    narrow = type("Spectrum", (), {"wavelength": wavelength, "reflectance": values, "name": "line"})()
    read = np.interp(wavelength, nodes, reflectance_spectra([narrow], response)[0])
    assert read.mean() == pytest.approx(values.mean(), abs=2e-3) and values.mean() > 0.105


def test_the_parts_sum_to_the_whole_even_beyond_the_ends():
    nodes = band_wavelengths(BANDS[0])
    shares = parted(np.array([0.3, 3.0, 3.03, 4.9999, 5.0, 80.0]), nodes)
    assert np.all(shares >= 0) and shares.sum(axis=1) == pytest.approx(1.0)
    assert shares[0, 0] == shares[-1, -1] == 1.0
    assert shares @ nodes == pytest.approx([3.0, 3.0, 3.03, 4.9999, 5.0, 5.0])


def test_emission_lies_where_planck_has_it():
    """The share of 4 to 5 um in 3 to 5 um at 300 K, by radiances of the two bands."""
    response = BANDS[0]
    nodes = band_wavelengths(response)
    share = emission_shares(response, np.array([300.0]))[0]
    above = np.clip((nodes - 4.0) / (nodes[1] - nodes[0]) + 0.5, 0.0, 1.0)
    part = band_radiance(SpectralResponse.rectangular(4.0, 5.0), 300.0) / band_radiance(response, 300.0)
    assert share @ above == pytest.approx(float(part), abs=5e-3)


@pytest.mark.parametrize("kelvin", [0.5, 20.0, 5.0e4])
def test_the_coldest_and_the_hottest_emit_finite_shares(kelvin):
    for response in BANDS:
        shares = emission_shares(response, np.array([kelvin]))
        assert np.all(np.isfinite(shares)) and np.all(shares >= 0) and shares.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(("low", "high"), [(10.0, 10.001), (0.3, 30.0), (0.4, 0.7)])
def test_narrow_and_wide_bands_have_a_bounded_number(low, high):
    nodes = band_wavelengths(SpectralResponse.rectangular(low, high))
    assert 9 <= nodes.size <= 65
    assert (nodes[0], nodes[-1]) == (low, high)
