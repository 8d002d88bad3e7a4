"""Light of the night sky under the air."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.sources.night_sky import airglow_radiance, starlight_radiance, van_rhijn
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.night_light import night_irradiance
from skyshine.mat.quantities.sky_table import SkyTable
from skyshine.schemas.errors import InputError

EDGES = np.array([12000.0, 12005.0, 17000.0, 17005.0])


@pytest.fixture(scope="module")
def air(synthetic_points, isothermal):
    def make(night_sky=1.0, absorption=0.0, aerosol="rural"):
        state = replace(isothermal(aerosol=Aerosol(aerosol)), night_sky=night_sky)
        return SpectralAir.of(state, synthetic_points(EDGES, {"CO2": [absorption] * 3}))

    return make


def above(air, altitude=0.0):
    """Irradiance without any air: the integral over the hemisphere."""
    nu = air.optics.wavenumber
    sine = (np.arange(4000) + 0.5) / 4000
    glow = 2 * np.pi * np.mean(sine * van_rhijn(sine, altitude)) * airglow_radiance(nu)
    return glow + np.pi * starlight_radiance(nu)


def test_clear_air_loses_what_it_scatters_back(air):
    """Rayleigh optical depths of 0.02 to 0.08 send half of what they scatter back: of isotropic light about the optical
    depth itself; without the half that comes down twice as much would be missing.
    """
    clear = air(aerosol="none")
    through = night_irradiance(clear, np.zeros(1))[0] / above(clear)
    column = clear.source_paths.optical_depth(np.zeros(1), np.ones((1, 1)))[0, 0]
    np.testing.assert_allclose(1 - through, 1.05 * column, rtol=0.35)
    assert through[0] > through[-1]  # 12,000 before 17,000 cm^-1


def test_haze_scatters_most_of_what_it_takes_down_again(air):
    hazy = air()
    dark = replace(hazy, scatters=False)
    direct, whole = (night_irradiance(one, np.zeros(1))[0] for one in (dark, hazy))
    assert np.all(whole > 1.25 * direct) and np.all(whole < above(hazy))


def test_high_up_there_is_the_whole_of_it(air):
    clear = air(aerosol="none")
    np.testing.assert_allclose(night_irradiance(clear, np.array([60e3]))[0], above(clear, 60e3), rtol=0.02)


def test_absorbing_air_lets_little_through(air):
    ratio = night_irradiance(air(absorption=2e-25), np.zeros(1)) / night_irradiance(air(), np.zeros(1))
    assert np.all((ratio > 0) & (ratio < 0.2))


def test_airglow_goes_with_its_factor_and_starlight_does_not(air):
    one, two, three = (night_irradiance(air(factor), np.zeros(1)) for factor in (1.0, 2.0, 3.0))
    np.testing.assert_allclose(two - one, three - two, rtol=1e-9)
    assert np.all(two < 2 * one)


def test_without_it_there_is_none(air):
    assert not night_irradiance(air(0.0), np.zeros(2)).any()


def test_it_is_in_the_sky_of_tables(air):
    lit, dark = (SkyTable.of(air(factor), np.zeros(1), np.radians([30.0]), np.zeros(3)) for factor in (1.0, 0.0))
    difference = lit.at(np.zeros(1))[0, 0] - dark.at(np.zeros(1))[0, 0]
    np.testing.assert_allclose(difference, night_irradiance(air(), np.zeros(1))[0], rtol=1e-6)


def test_a_moonless_night_has_some_thousandths_of_a_lux():
    """RCA Electro-Optics Handbook (1974): clear night without the Moon, 1e-3 lux."""
    line = skyshine.mat.spectrum(wavelength=(0.45, 0.68), elevation=90, source="none", night_sky=1.0)
    sensitivity = np.exp(-0.5 * ((line.wavelength - 0.559) / 0.0425) ** 2)  # of the eye by day, within some percent
    lux = 683 * np.sum(line.sky_irradiance * sensitivity * np.gradient(line.wavenumber))
    assert 4e-4 < lux < 3e-3


def test_behind_lines_into_space_alone():
    place = {"wavelength": (0.55, 0.56), "source": "none", "night_sky": 1.0}
    up = skyshine.mat.spectrum(elevation=60, **place)
    low = skyshine.mat.spectrum(elevation=5, aerosol="none", **place)
    clear = skyshine.mat.spectrum(elevation=60, aerosol="none", **place)
    assert np.all(up.night_sky > 0) and "night_sky" in up.columns
    assert np.all(up.night_sky < clear.night_sky)
    assert np.all(low.night_sky / low.transmittance > 1.5 * clear.night_sky / clear.transmittance)
    for other in ({"elevation": -10}, {"elevation": 60, "range": 10}):
        line = skyshine.mat.spectrum(altitude=1.0, **other, **place)
        assert not line.night_sky.any() and "night_sky" not in line.columns
    assert "night_sky" not in skyshine.mat.spectrum(elevation=60, wavelength=(0.55, 0.56), source="none").columns


@pytest.mark.parametrize("factor", [-1.0, 1e3, np.nan])
def test_bad_factors_are_refused(factor):
    with pytest.raises(InputError, match="night_sky: found"):
        skyshine.mat.spectrum(wavelength=(0.55, 0.56), night_sky=factor)
