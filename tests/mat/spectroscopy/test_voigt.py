"""The Voigt function against scipy's Faddeeva function."""

import numpy as np
import pytest
from scipy.special import wofz

voigt = pytest.importorskip("skyshine.mat.spectroscopy.voigt", reason="needs numba")


@pytest.mark.parametrize("y", [1e-6, 1e-4, 1e-2, 0.3, 1.0, 5.0, 14.0, 16.0, 100.0, 1e4])
def test_voigt_agrees_with_faddeeva(y):
    x = np.concatenate([np.linspace(0.0, 6.0, 200), np.geomspace(6.0, 1e4, 200)])
    ours = np.array([voigt.voigt(float(value), y) for value in x])
    expected = wofz(x + 1j * y).real
    np.testing.assert_allclose(ours, expected, rtol=1e-4)


def test_chi_is_one_near_the_centre_and_falls_off():
    decay = voigt.chi_decay(296.0)
    values = [voigt.chi_co2(distance, decay) for distance in (0.0, 3.0, 10.0, 25.0)]
    assert values[:2] == [1.0, 1.0]
    assert 1.0 > values[2] > values[3] > 0.0
    # Perrin and Hartmann 1989, equation 5: exp(-B1 (distance - 3)), B1(296 K) = 0.3031 cm.
    assert voigt.chi_co2(4.0, decay) == pytest.approx(np.exp(-0.3031), rel=1e-3)


def test_chi_decay_of_perrin_and_hartmann_at_room_temperature():
    # Perrin and Hartmann 1989, equation 6 with the constants of CO2-N2: B1(296 K) = 0.416 - 0.354 exp(-1.1426)
    assert voigt.chi_decay(296.0) == pytest.approx(0.416 - 0.354 * 0.31900, abs=1e-4)
