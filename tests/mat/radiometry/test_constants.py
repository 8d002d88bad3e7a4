"""Physical constants against those of CODATA that scipy carries."""

import pytest
from scipy import constants as codata

from skyshine.mat.radiometry import constants


def test_exact_constants_of_the_si_are_those_of_codata():
    ours = constants.PLANCK, constants.LIGHT_SPEED, constants.BOLTZMANN, constants.ZERO_CELSIUS
    assert ours == (codata.h, codata.c, codata.k, codata.zero_Celsius)


def test_radiation_constants_are_those_of_codata():
    first, second = (
        codata.value("first radiation constant for spectral radiance"),
        codata.value("second radiation constant"),
    )
    assert pytest.approx(first * 1e8, rel=1e-8, abs=0) == constants.C1_WAVENUMBER
    assert pytest.approx(first * 1e24, rel=1e-8, abs=0) == constants.C1_WAVELENGTH
    assert pytest.approx(second * 1e2, rel=1e-9, abs=0) == constants.C2_WAVENUMBER
    assert pytest.approx(second * 1e6, rel=1e-9, abs=0) == constants.C2_WAVELENGTH


def test_the_short_second_radiation_constant_is_the_exact_one_cut_after_ten_digits():
    assert constants.C2 <= constants.C2_WAVENUMBER < constants.C2 + 1e-9
