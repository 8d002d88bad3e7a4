"""A ground whose reflectance depends on wavelength, in every part of the light."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import cloud_type
from skyshine.mat.atmosphere.state.ground_albedo import SpectralAlbedo
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.bounds import Scattering
from skyshine.mat.atmosphere.transfer.sky import sky_irradiance
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalSource
from skyshine.mat.quantities.radiance_field import GroundReflection
from skyshine.schemas.errors import InputError

ALBEDO = SpectralAlbedo(np.array([0.5, 0.667, 1.0]), np.array([0.05, 0.9, 0.4]), 0.5)


@pytest.fixture(scope="module")
def air_over(synthetic_points, isothermal):
    edges = np.array([9990.0, 9995.0, 14995.0, 15000.0, 19995.0, 20000.0])

    def make(albedo):
        state = isothermal(aerosol=Aerosol("rural", visibility_km=10.0), clouds=[cloud_type("cirrus")])
        points = synthetic_points(edges, {"CO2": [0.0] * (edges.size - 1)})
        return SpectralAir.of(replace(state, surface_albedo=albedo), points)

    return make


def parts(air):
    """All that a ground changes, with the points along the last axis."""
    elevation = np.radians([30.0])
    sky = sky_irradiance(air, np.zeros(1), elevation)
    ground = GroundReflection.of(air, elevation)
    thermal = ThermalSource.of(air.state, air.shells, air.optics)
    bound = Scattering.of(air)
    return [sky.scattered, sky.thermal, ground.thermal, ground.scattered, thermal.field.source, bound.light]


def test_each_point_sees_the_reflectance_of_its_wavelength(air_over):
    """At the darkest and at the brightest point the light is that over a grey ground of this reflectance."""
    spectral = air_over(ALBEDO)
    albedo = np.interp(1e4 / spectral.optics.wavenumber, ALBEDO.wavelength, ALBEDO.reflectance)
    assert np.ptp(albedo) > 0.5
    found = parts(spectral)
    for point in (np.argmin(albedo), np.argmax(albedo)):
        for values, expected in zip(found, parts(air_over(float(albedo[point]))), strict=True):
            np.testing.assert_allclose(values[..., point], expected[..., point], rtol=1e-6)


def test_a_flat_spectrum_is_a_number(air_over):
    flat = SpectralAlbedo(np.array([0.5, 1.0]), np.array([0.3, 0.3]), 0.3)
    for values, expected in zip(parts(air_over(flat)), parts(air_over(0.3)), strict=True):
        np.testing.assert_array_equal(values, expected)


def test_ends_of_a_spectrum_hold_beyond_it():
    np.testing.assert_array_equal(ALBEDO.at(1e4 / np.array([0.3, 5.0])), [0.05, 0.4])


@pytest.mark.parametrize(
    ("wavelength", "reflectance", "message"),
    [([1.0, 0.5], [0.1, 0.2], "increase"), ([0.5, 1.0], [0.1], "increase"), ([0.5, 1.0], [0.1, 1.2], "0 to 1"),
     ([0.5, 1.0], [np.nan, 0.2], "0 to 1")],
)  # fmt: skip
def test_bad_spectra_are_refused(wavelength, reflectance, message):
    with pytest.raises(InputError, match=message):
        SpectralAlbedo(np.array(wavelength), np.array(reflectance), 0.1)
