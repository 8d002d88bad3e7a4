"""The MT_CKD continua: laws that they obey."""

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("netCDF4")
pytestmark = pytest.mark.shared_data

from skyshine.mat.spectroscopy.continua import Coefficients, Continua, radiation_term
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def continua(shared_data):
    return Continua(shared_data / "continua")


def test_water_self_continuum_in_the_window(continua):
    # MT_CKD gives 1 to 2.5e-22 cm2 molecule-1 atm-1 at 1000 cm-1 and 296 K; Burch and Alt 1984 measured 1.8e-22.
    self_continuum, foreign, exponent = continua.water_coefficients(np.array([1000.0]))
    value = self_continuum[0] * radiation_term(1000.0, 296.0) * 1e4
    assert 1.0e-22 < value < 2.5e-22
    assert foreign[0] < self_continuum[0] / 100 and 4.0 < exponent[0] < 7.0


@pytest.mark.parametrize("name, wavenumber", [("co2", 2400.0), ("n2", 2330.0), ("o2", 1560.0)])
def test_continua_grow_with_density(continua, name, wavenumber):
    function = getattr(continua, name)
    one, two = function(wavenumber, 5e4, 260.0), function(wavenumber, 1e5, 260.0)
    assert one > 0 and two == pytest.approx(2 * one)


def test_water_is_the_stronger_partner_of_nitrogen(continua):
    assert continua.n2(2400.0, 1e5, 290.0, 0.03) > 1.05 * continua.n2(2400.0, 1e5, 290.0, 0.0)


def test_continua_vanish_outside_their_bands(continua):
    assert continua.n2(1000.0, 1e5, 290.0) == 0 and continua.o2(1000.0, 1e5, 290.0) == 0


def test_samples_are_met_and_never_overshot():
    steps = Coefficients(100.0, 10.0, np.array([0.0, 0.0, 0.0, 5.0, 5.0, 5.0]))
    assert steps.at(130.0) == 5.0 and steps.at(90.0) == 0.0 and steps.at(151.0) == 0.0
    between = steps.at(np.linspace(100.0, 150.0, 101))
    assert between.min() >= 0.0 and between.max() <= 5.0


def test_notice_travels(continua):
    assert "Atmospheric and Environmental Research" in continua.notice and "redistributed" in continua.notice


def test_missing_folder_is_named(tmp_path):
    with pytest.raises(InputError, match="--continua needs"):
        Continua(tmp_path)


@pytest.mark.parametrize(
    "nanometres, expected",
    # Binary cross sections of O2-O2, cm5 molecule-2: Thalman and Volkamer 2013 (Phys. Chem. Chem. Phys. 15, 15371), 295
    # K.
    [(477.0, 6.6e-46), (577.2, 1.10e-45), (630.0, 7.2e-46)],
)
def test_oxygen_pairs_in_the_visible(continua, nanometres, expected):
    grid = 1e7 / np.linspace(nanometres - 3, nanometres + 3, 200)
    density = 101325.0 / (1.380649e-23 * 295.0)
    per_pair = continua.o2(grid, 101325.0, 295.0).max() / (density * 0.20946) * 1e10
    assert per_pair == pytest.approx(expected, rel=0.06)


@pytest.mark.parametrize("wavenumber", [7880.0, 9390.0, 13100.0, 17330.0])
def test_oxygen_bands_of_sunlight_grow_with_density(continua, wavenumber):
    one, two = continua.o2(wavenumber, 5e4, 260.0), continua.o2(wavenumber, 1e5, 260.0)
    assert one > 0 and two == pytest.approx(2 * one)
