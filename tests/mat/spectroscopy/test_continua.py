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


@pytest.mark.parametrize("name, wavenumber", [("co2", 2200.0), ("n2", 2330.0), ("o2", 1560.0)])
def test_continua_grow_with_density(continua, name, wavenumber):
    function = getattr(continua, name)
    one, two = function(wavenumber, 5e4, 260.0), function(wavenumber, 1e5, 260.0)
    assert one > 0 and two == pytest.approx(2 * one, abs=0)


def test_water_is_the_stronger_partner_of_nitrogen(continua):
    assert continua.n2(2400.0, 1e5, 290.0, 0.03) > 1.05 * continua.n2(2400.0, 1e5, 290.0, 0.0)


def test_continua_vanish_outside_their_bands(continua):
    assert continua.n2(1000.0, 1e5, 290.0) == 0 and continua.o2(1000.0, 1e5, 290.0) == 0


def test_samples_are_met_and_never_overshot():
    steps = Coefficients(100.0, 10.0, np.array([0.0, 0.0, 0.0, 5.0, 5.0, 5.0]))
    assert steps.at(130.0) == 5.0 and steps.at(90.0) == 0.0 and steps.at(151.0) == 0.0
    between = steps.at(np.linspace(100.0, 150.0, 101))
    assert between.min() >= 0.0 and between.max() <= 5.0


def test_the_radiation_term_is_that_of_planck():
    # nu tanh(h c nu / 2 k T), with the constants of the SI.
    ratio = 6.62607015e-34 * 299792458.0 * 1e2 * 700.0 / (2 * 1.380649e-23 * 250.0)
    assert radiation_term(700.0, 250.0) == pytest.approx(700.0 * np.tanh(ratio), rel=1e-8)


@pytest.fixture(scope="module")
def published(shared_data):
    """The published sample of a continuum next to a wavenumber, and its wavenumber; without the code under test."""
    netCDF4 = pytest.importorskip("netCDF4")

    def sample(name, wavenumber):
        with netCDF4.Dataset(shared_data / "continua" / "mt_ckd_n2_o2_co2_o3.nc") as file:
            low, step = file[name].wavenumber_lower_bound, file[name].wavenumber_resolution
            number = round((wavenumber - low) / step)
            return low + number * step, float(file[name][number])

    return sample


def per_molecule(wavenumber, temperature):
    """m2 per molecule in air of 1013 hPa of a coefficient of 1 cm-1 amagat-2, radiation term included."""
    return np.tanh(1.438776877 * wavenumber / (2 * temperature)) * 273.15 / temperature / 2.68675e19 * 1e-4


def oxygen_on_nitrogen(temperature):
    """Lafferty et al. 1996: efficiency of oxygen over that of nitrogen."""
    return 1.294 - 0.4545 * temperature / 296


@pytest.mark.parametrize(("name", "temperature"), [("xn2_272", 272.0), ("xn2_228", 228.0)])
def test_nitrogen_is_as_measured_at_the_temperatures_of_its_measurements(continua, published, name, temperature):
    wavenumber, coefficient = published(name, 2330.0)
    partners = 0.78084 + 0.20946 * oxygen_on_nitrogen(temperature)
    expected = coefficient * partners * per_molecule(wavenumber, temperature)
    assert continua.n2(wavenumber, 101300.0, temperature) == pytest.approx(expected, rel=1e-4, abs=0)


def test_water_is_nine_sevenths_as_effective_for_nitrogen_as_the_table_says(continua, published):
    wavenumber, efficiency = published("a_h2o", 2330.0)
    dry, moist = (continua.n2(wavenumber, 101300.0, 272.0, q) for q in (0.0, 0.05))
    by_air = 0.78084 + 0.20946 * oxygen_on_nitrogen(272.0)
    assert moist / dry == pytest.approx(0.95 + 0.05 * 9 / 7 * efficiency / by_air, rel=1e-4)


def test_oxygen_in_air_has_the_measured_strength_at_1270_nm(continua, published):
    """Mate et al. 1999 measured 21 % oxygen in nitrogen: dry air is nearly that mixture."""
    wavenumber, coefficient = published("o2_inf1", 7880.0)
    expected = coefficient * per_molecule(wavenumber, 296.0)
    assert continua.o2(wavenumber, 101300.0, 296.0) == pytest.approx(expected, rel=0.006, abs=0)


def test_oxygen_at_1060_nm_has_the_strength_of_its_two_lorentzians(continua):
    """Mlawer et al. 1998, worked out by hand, with the factor 1.054, in 1e-20 cm2 per molecule at 1013 hPa and 296 K:
    7.164e-7 at 9375 cm-1 and 2.707e-08 at 9200 cm-1, where both Lorentzians are damped by exp(-distance / 176.1 cm-1).
    """
    found = continua.o2(np.array([9375.0, 9200.0]), 101300.0, 296.0)
    assert found == pytest.approx([7.164e-31, 2.707e-32], rel=2e-3, abs=0)


@pytest.mark.parametrize("at", [700.0, 2100.0])
def test_carbon_dioxide_is_as_tabulated_where_its_lines_stand_alone(continua, published, at):
    wavenumber, coefficient = published("bfco2", at)
    _, factor = published("x_factor_co2", at) if at > 1998 else (wavenumber, 1.0)
    expected = coefficient * factor * 1e-24 * 296 / 246 * wavenumber * np.tanh(1.438776877 * wavenumber / (2 * 246))
    assert continua.co2(wavenumber, 101300.0, 246.0) == pytest.approx(expected, rel=1e-6, abs=0)


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
    assert per_pair == pytest.approx(expected, rel=0.06, abs=0)


@pytest.mark.parametrize("wavenumber", [7880.0, 9390.0, 13100.0, 17330.0])
def test_oxygen_bands_of_sunlight_grow_with_density(continua, wavenumber):
    one, two = continua.o2(wavenumber, 5e4, 260.0), continua.o2(wavenumber, 1e5, 260.0)
    assert one > 0 and two == pytest.approx(2 * one, abs=0)
