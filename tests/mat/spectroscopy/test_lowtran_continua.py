"""The continua of LOWTRAN7: against measurements, against MT_CKD, and in a band model that is built with them."""

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

pytest.importorskip("numba")

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.commands.lines import command
from skyshine.mat.spectroscopy.continua import Continua, radiation_term
from skyshine.mat.spectroscopy.lowtran_continua import LowtranContinua


@pytest.fixture(scope="module")
def continua():
    return LowtranContinua()


def test_the_coefficients_of_water_vapour_are_those_of_the_source(continua):
    """Figures of BLOCK DATA SF296, SF260 and BFH2O, 1e-20 cm3, at 100 cm-1: S296, S260; no correction is near."""
    self_continuum, _, exponent = continua.water_coefficients(np.array([100.0]))
    correction = 1 - 0.2333 * 200**2 / (950**2 + 200**2)
    assert self_continuum[0] == pytest.approx(1.3115e-1 * 1e-24 * correction * 1013 / 1013.25, rel=1e-4, abs=0)
    assert (296 / 260) ** exponent[0] == pytest.approx(1.9712e-1 / 1.3115e-1, rel=1e-4)


def test_the_self_continuum_of_the_window_is_that_of_burch():
    # Burch and Alt 1984 measured 1.8e-22 cm2 molecule-1 atm-1 at 1000 cm-1 and 296 K.
    value = LowtranContinua().water_coefficients(np.array([1000.0]))[0][0]
    assert value * radiation_term(1000.0, 296.0) * 1e4 == pytest.approx(1.8e-22, rel=0.2, abs=0)


def test_the_far_wings_are_added_to_the_foreign_continuum(continua):
    """SUBROUTINE FUDGE at 2500 cm-1, by hand: 1.5553e-8 1e-20 cm3; the table adds 5.03e-11."""
    _, foreign, _ = continua.water_coefficients(np.array([2500.0]))
    assert foreign[0] == pytest.approx(1.5603e-8 * 1e-24 * 1013 / 1013.25, rel=5e-4, abs=0)


@pytest.mark.shared_data
@pytest.mark.parametrize(
    ("gas", "temperature", "low", "high", "largest"),
    [("n2", 273.15, 2200, 2500, 0.35), ("o2", 273.15, 1450, 1650, 0.2), ("o2", 220.0, 1450, 1650, 0.25)],
)
def test_induced_bands_are_near_those_of_mt_ckd(continua, shared_data, gas, temperature, low, high, largest):
    wavenumber = np.arange(low, high, 5.0)
    theirs = getattr(Continua(shared_data / "continua"), gas)(wavenumber, 101325.0, temperature)
    ours = getattr(continua, gas)(wavenumber, 101325.0, temperature)
    assert np.abs(ours / theirs - 1).max() < largest
    assert np.abs(ours.mean() / theirs.mean() - 1) < largest / 2


def test_nitrogen_follows_density_and_the_root_of_temperature(continua):
    """LOWTRAN7's amount of nitrogen is that of the gas, times the pressure, times (273.15 K / T)^0.5."""
    at = continua.n2(2330.0, 101325.0, 273.15)
    assert continua.n2(2330.0, 50662.5, 273.15) == pytest.approx(at / 2, abs=0)
    assert continua.n2(2330.0, 101325.0, 4 * 273.15) == pytest.approx(at / 2, abs=0)
    assert at * 2.6868e25 * 1e3 == pytest.approx(0.169, rel=1e-6)  # C4 at 2330 cm-1, per km


def test_oxygen_has_the_strengths_of_drayson_at_220_kelvin(continua):
    # BLOCK DATA BO2C at 1550 cm-1: 0.148E-5 for air of 20.946 % oxygen, cm-1 per atm-cm and atm; A = -0.899E-2 K-1,
    # B = 0.243E-4 K-2.
    at = continua.o2(1555.0, 101325.0, 220.0)
    assert at * 2.6868e25 * 0.20946 * 1e-2 == pytest.approx(0.148e-5, rel=1e-4, abs=0)
    warmer = continua.o2(1555.0, 101325.0, 260.0) / at
    assert warmer == pytest.approx(np.exp(-0.899e-2 * 40 + 0.243e-4 * 1600), rel=1e-4)


def test_continua_are_zero_outside_their_bands(continua):
    assert continua.n2(2000.0, 1e5, 290.0) == 0 and continua.o2(1800.0, 1e5, 290.0) == 0
    assert np.all(np.array(continua.water_coefficients(np.array([20001.0]))) == 0)


@pytest.mark.validation  # twenty seconds of sums of lines
@pytest.mark.shared_data
def test_a_band_model_built_with_them_names_them_and_holds_nothing_of_mt_ckd(shared_data, tmp_path):
    pytest.importorskip("hapi")
    out = tmp_path / "table.h5"
    arguments = ["build", "--lines", str(shared_data / "lines"), "--continua", "lowtran7", "--points", "4"]
    arguments += ["--wavenumber", "2400:2405", "--out", str(out)]
    CliRunner().invoke(command, arguments, catch_exceptions=False)
    table = AbsorptionTable.open(out, water_continuum="lowtran7")
    assert table.content == AbsorptionTable.open(out).content and table.name == "hitran2012-lowtran7"
    points = table.points(2400, 2405)
    sections = points.cross_sections([101325.0], [273.15], [0.0], gases=["N2", "H2O_continuum"])
    expected = LowtranContinua().n2(points.wavenumber, 101325.0, 273.15)
    # Between the few lines of N2 the continuum is all there is.
    assert np.median(sections["N2"][0] / expected) == pytest.approx(1.0, abs=2e-3)
    humid = points.cross_sections([101325.0], [296.0], [0.0], gases=["H2O_continuum"])["H2O_continuum"][0]
    foreign = LowtranContinua().water_coefficients(points.wavenumber)[1] * radiation_term(points.wavenumber, 296.0)
    assert humid == pytest.approx(foreign * 101325 / 101300, rel=1e-4, abs=0)
    texts = []
    with h5py.File(out) as file:
        file.visititems(lambda name, item: texts.extend(str(value) for value in item.attrs.values()))
        texts += [str(value) for value in file.attrs.values()]
    assert not [text for text in texts if "CKD" in text.upper()]
