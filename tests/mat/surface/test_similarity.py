"""Optical turbulence of the surface layer: published laws and limits."""

import numpy as np
import pytest
from scipy.constants import g

from skyshine.mat.surface.similarity import index_structure

KELVIN, PASCAL = 300.0, 101325.0
SLOPE = (79e-8 * PASCAL / KELVIN**2) ** 2  # of the index by temperature, squared


def test_free_convection_has_kaimals_law():
    """C_T^2 = 2.67 Q^(4/3) (g / T)^(-2/3) z^(-4/3): Kaimal et al. 1976, J. Atmos. Sci. 33, 2152."""
    height, flux, friction = np.array([20.0, 80.0]), 0.2, 0.01
    cn2 = index_structure(height, friction, -flux / friction, 0.0, KELVIN, PASCAL)
    kaimal = 2.67 * flux ** (4 / 3) * (g / KELVIN) ** (-2 / 3) * height ** (-4 / 3) * SLOPE
    assert cn2 == pytest.approx(kaimal, rel=0.02, abs=0)
    assert np.log(cn2[1] / cn2[0]) / np.log(4) == pytest.approx(-4 / 3, abs=1e-3)


def test_neutral_and_unstable_air_have_wyngaards_law():
    """T*^2 z^(-2/3) 4.9 (1 - 7 z/L)^(-2/3): Wyngaard et al. 1971; Andreas 1988 refits 7 to 6.1."""
    friction, scale = 0.4, -0.3
    length = KELVIN * friction**2 / (0.4 * g * scale)
    for height in (0.5, 2.0, 30.0):
        wyngaard = SLOPE * scale**2 * height ** (-2 / 3) * 4.9 * (1 - 7 * height / length) ** (-2 / 3)
        assert index_structure(height, friction, scale, 0.0, KELVIN, PASCAL) == pytest.approx(wyngaard, rel=0.1, abs=0)


def test_stable_air_has_wyngaards_law():
    friction, scale, height = 0.2, 0.05, 4.0
    length = KELVIN * friction**2 / (0.4 * g * scale)
    law = SLOPE * scale**2 * height ** (-2 / 3) * 4.9 * (1 + 2.2 * (height / length) ** (2 / 3))
    assert index_structure(height, friction, scale, 0.0, KELVIN, PASCAL) == pytest.approx(law, rel=1e-9, abs=0)


def test_humidity_raises_turbulence_by_wesely():
    """(1 + 0.03 / B)^2 at a Bowen ratio B of 0.5, with L of the same buoyancy."""
    scale = -0.1
    humidity = scale * 1005 / (0.5 * 2.45e6)
    dry, moist = (index_structure(1.0, 5.0, scale, q, KELVIN, PASCAL) for q in (0.0, humidity))
    assert moist / dry == pytest.approx(1.06**2, rel=2e-3)


def test_no_flux_no_turbulence_and_all_is_finite():
    assert index_structure(2.0, 0.3, 0.0, 0.0, KELVIN, PASCAL) == 0
    values = index_structure(np.geomspace(0.1, 1e3, 9)[:, None], 1e-3, np.array([-20.0, 0.0, 20.0]), -1e-3, 250.0, 2e4)
    assert np.all(np.isfinite(values)) and np.all(values >= 0)
