"""Aerosols of known components: against the files of OPAC, LOWTRAN7's tables and their own moments."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles import tables
from skyshine.mat.atmosphere.particles.aerosol import OF_KNOWN_COMPONENTS, AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol, default_visibility
from skyshine.mat.atmosphere.particles.opac import TYPES, opac_extinction, opac_model
from skyshine.mat.atmosphere.state.state import AtmosphericState

VISIBLE = 1e4 / 0.55


@pytest.mark.parametrize(
    ("component", "humidity", "wavelength", "extinction", "albedo", "asymmetry"),
    [  # OPAC's own files waso80 and suso99: km^-1 of one particle per cm^3
        ("waso", 80.0, 0.25, 2.169e-5, 0.9223, 0.748),
        ("waso", 80.0, 0.55, 9.584e-6, 0.9843, 0.704),
        ("waso", 80.0, 0.90, 4.347e-6, 0.9600, 0.653),
        ("suso", 99.0, 0.55, 1.209e-3, 1.0, 0.797),
        ("suso", 99.0, 3.75, 2.435e-4, 0.9384, 0.674),
        ("suso", 99.0, 10.0, 4.688e-5, 0.2018, 0.448),
        ("suso", 99.0, 25.0, 7.012e-5, 0.04817, 0.197),
    ],
)
def test_components_scatter_as_in_the_files_of_opac(component, humidity, wavelength, extinction, albedo, asymmetry):
    table = tables.scattering_table(f"opac_{component}")
    at = int(np.flatnonzero(table.node == humidity)[0]), int(np.flatnonzero(table.wavelength == wavelength)[0])
    assert 1e-3 * table.extinction[at] == pytest.approx(extinction, rel=0.004)
    assert 1 - table.absorption[at] / table.extinction[at] == pytest.approx(albedo, abs=0.001)
    assert table.moments[1][at] == pytest.approx(asymmetry, abs=0.0015)


def test_the_polluted_continent_is_that_of_opac():
    """Output of OPAC 3.1 for 80 % (0.55 um): extinction 0.1746 km^-1, albedo 0.8925, asymmetry 0.6977."""
    name = "opac_continental_polluted"
    optics = opac_model(name).optics([VISIBLE], [80.0])
    assert opac_extinction(name, 80.0) == pytest.approx(0.1746, rel=0.002)
    assert optics.single_scattering_albedo[0, 0] == pytest.approx(0.8925, abs=5e-4)
    assert optics.asymmetry[0, 0] == pytest.approx(0.6977, abs=5e-4)


@pytest.mark.parametrize("name", TYPES)
def test_types_are_whole(name):
    """At all humidities and wavelengths: mean 1, moments that begin with 1, albedo between 0 and 1."""
    model = opac_model(name)
    wavenumber, humidity = 1e4 / np.array([0.3, 0.55, 1.06, 2.2, 4.0, 8.7, 10.6, 30.0, 100.0]), [0.0, 63.0, 92.0, 100.0]
    optics = model.optics(wavenumber, humidity)
    assert np.all(optics.extinction > 0) and np.all(np.abs(optics.asymmetry) < 1)
    assert np.all((optics.single_scattering_albedo >= 0) & (optics.single_scattering_albedo <= 1))
    theta = np.radians(np.unique(np.append(np.geomspace(1e-3, 180, 3000), np.linspace(0, 180, 3001))))
    phase = model.phase_function(np.cos(theta), wavenumber, humidity)
    mean = np.trapezoid(0.5 * phase * np.sin(theta)[:, None, None], theta, axis=0)
    np.testing.assert_allclose(mean, 1.0, atol=0.003)
    moments = model.phase_moments(wavenumber, humidity)
    np.testing.assert_allclose(moments[0], 1.0, rtol=2e-4)
    cosine = np.trapezoid(0.5 * phase * (np.cos(theta) * np.sin(theta))[:, None, None], theta, axis=0)
    np.testing.assert_allclose(cosine, moments[1], atol=0.01)


@pytest.mark.parametrize("name", OF_KNOWN_COMPONENTS)
def test_moments_of_mie_theory_have_the_asymmetry_of_lowtran7(name):
    """The components are those of LOWTRAN7's tables, which list one wrong number: urban, 99 %, 1.536 um. Their index
    of 2.7 um is not in the table of the components.
    """
    model = AerosolModel.load(name)
    wavelength = model.wavelength[(model.wavelength >= 0.3) & (model.wavelength <= 25)]
    wavelength = wavelength[np.abs(wavelength - 2.7) > 0.01]
    expected = model.optics(1e4 / wavelength, model.humidity).asymmetry
    found = model.phase_moments(1e4 / wavelength, model.humidity)[1]
    difference = np.abs(found - expected)
    if name == "urban":
        difference[-1, np.argmin(np.abs(wavelength - 1.536))] = 0.0
    assert difference.max() < 0.02 and np.median(difference) < 0.001


def test_visibility_follows_amount_and_humidity():
    """Koschmieder's of 0.1746 km^-1 and of the molecules; humid air is murkier."""
    name = "opac_continental_polluted"
    assert default_visibility(name, relative_humidity=80.0) == pytest.approx(3.912 / (0.1746 + 0.01159), rel=0.002)
    seen = [default_visibility(name, relative_humidity=humidity) for humidity in (0.0, 50.0, 90.0, 99.0)]
    assert seen == sorted(seen, reverse=True)


def test_dust_is_grey_and_smoke_is_blue():
    """Angstrom exponents (0.44 to 0.87 um): below 0.4 of desert and clean sea, above 1 of the continents."""
    for name, low, high in (
        ("opac_desert", 0.0, 0.4),
        ("opac_maritime_clean", -0.1, 0.4),
        ("opac_continental_average", 1.0, 1.6),
        ("opac_urban", 1.0, 1.6),
    ):
        first, second = opac_model(name).optics(1e4 / np.array([0.44, 0.87]), [50.0]).extinction[0]
        assert low < np.log(first / second) / np.log(0.87 / 0.44) < high


def test_a_column_of_opac_takes_a_measured_optical_depth():
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("opac_desert", optical_depth=0.3))
    assert state.aerosol_optical_depth(550.0, 0.0) == pytest.approx(0.3, rel=1e-6)
