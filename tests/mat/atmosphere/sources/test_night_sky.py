"""Airglow and starlight against published brightness."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.sources.night_sky import (
    EARTH_RADIUS,
    SQUARE_ARCSECOND,
    airglow_radiance,
    starlight_radiance,
    van_rhijn,
)

VEGA_V = 3.631e-8  # W m^-2 um^-1 (Bessell, Castelli and Plez 1998)


def per_um(radiance, wavelength):
    return radiance * (1e4 / wavelength) ** 2 * 1e-4


def zenith(wavelength):
    """Whole radiance in the zenith, W m^-2 sr^-1 um^-1."""
    nu = np.atleast_1d(1e4 / np.asarray(wavelength, float))
    return per_um(airglow_radiance(nu) + starlight_radiance(nu, nu / 7), 1e4 / nu)


def test_brightness_of_a_dark_site():
    """21.4 to 21.9 mag arcsec^-2 in V at dark sites (Leinert et al. 1998, table 9; Patat 2003: 21.6 +- 0.2), which lie
    under somewhat fewer stars than the mean of the sky.
    """
    magnitude = -2.5 * np.log10(zenith(0.545)[0] * SQUARE_ARCSECOND / VEGA_V)
    assert 21.1 < magnitude < 21.9


def test_starlight_in_stars_of_magnitude_10():
    """1 S10(V) of the Sun's colour is 1.28e-8 W m^-2 sr^-1 um^-1 at 0.5 um (Leinert et al. 1998, table 2)."""
    nu = np.array([2e4])
    assert per_um(starlight_radiance(nu, 2000.0), 0.5)[0] / 215 == pytest.approx(1.28e-8, rel=0.06)


def test_airglow_holds_the_lines_of_oxygen_and_sodium():
    """[O I] 0.5577 alone has 250 rayleigh (Leinert et al. 1998): airglow of 0.5 to 0.6 um has more, by no more than the
    continuum of 0.3 to 0.8 rayleigh per angstrom beside it.
    """
    wavelength = np.linspace(0.5, 0.6, 101)
    photon = 6.62607015e-34 * 299792458 / (wavelength * 1e-6)
    rayleigh = np.mean(per_um(airglow_radiance(1e4 / wavelength), wavelength) / photon) * 0.1 * 4 * np.pi / 1e10
    assert 250 + 100 < rayleigh < 250 + 100 + 1.5 * 1000


def test_hydroxyl_makes_the_infrared_brightest():
    """OH: some ten times as bright in H as in I, thirty times as in V; in all 4.5e6 rayleigh, of which the first
    overtones from 1.4 to 2.2 um hold a tenth to a third.
    """
    v, i, h = zenith([0.545, 0.798, 1.63])
    assert 5 < h / i < 30 and 10 < h / v < 60
    wavelength = np.linspace(1.4, 1.8, 201)
    photon = 6.62607015e-34 * 299792458 / (wavelength * 1e-6)
    rayleigh = np.mean(per_um(airglow_radiance(1e4 / wavelength), wavelength) / photon) * 0.4 * 4 * np.pi / 1e10
    assert 1e5 < rayleigh < 1.5e6


def test_nothing_beyond_2_5_um():
    nu = 1e4 / np.array([2.49, 2.51, 4.0, 10.0])
    for radiance in (airglow_radiance(nu), starlight_radiance(nu)):
        assert radiance[0] > 0 and np.all(radiance[1:] == 0)


def test_van_rhijn():
    """1 in the zenith; a layer at 90 km is 1.93 times as bright at 30 degrees, 6.05 at the horizon, where a flat one
    has 2 and no bound.
    """
    assert van_rhijn(1.0) == pytest.approx(1.0)
    assert van_rhijn(0.5) == pytest.approx(1.93, abs=0.01)
    assert van_rhijn(0.0) == pytest.approx(1 / np.sqrt(1 - (EARTH_RADIUS / (EARTH_RADIUS + 90e3)) ** 2))
    assert np.all(np.diff(van_rhijn(np.linspace(0, 1, 50))) < 0)
    assert van_rhijn(0.0, 10e3) > van_rhijn(0.0)
