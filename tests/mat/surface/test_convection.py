"""Transfer coefficients of wind and of free convection against published laws and limits."""

import numpy as np
import pytest

from skyshine.mat.surface.convection import forced_coefficient, natural_coefficients
from skyshine.materials.records import SurfaceProperties

SMOOTH = SurfaceProperties(1e-6, 0.0, 0.0, False, False)


@pytest.mark.parametrize("speed", [0.0, 1.0, 3.0, 10.0, 30.0])
def test_plate_in_wind(speed):
    """Jürges' smooth plate, 7.17 V^0.78 with V at the plate: 0.723 of the wind at 10 m."""
    value = forced_coefficient(speed, 101325.0, 293.15, SMOOTH)
    assert value == pytest.approx(7.17 * (0.723 * speed) ** 0.78, rel=3e-3)


def test_canopy_takes_the_logarithmic_law():
    """Short grass (z0 = 1 cm), wind at 10 m, air at 2 m: rho cp k^2 / (ln 1000 ln 1478) a m/s. With FAO Paper 56's
    r_a = 208 / u2 its grass of 12 cm has 11.7 W/m2K at 2 m/s; this one, shorter and so smoother, has less."""
    grass = SurfaceProperties(0.01, 0.0, 0.0, True, False)
    value = forced_coefficient(2.0, 101325.0, 293.15, grass)
    assert value == pytest.approx(2 * 1.204 * 1013 * 0.16 / (np.log(1001) * np.log(1479)), rel=2e-3)
    fao = SurfaceProperties(0.123 * 0.12, 0.0, 0.0, True, False)
    assert value < forced_coefficient(2.0 / 0.748, 101325.0, 293.15, fao) == pytest.approx(11.7, rel=0.1)


def test_natural_convection_by_tilt():
    """A wall does not care which way heat flows; a warm roof loses twice what a cold one takes."""
    warm, cold = natural_coefficients(np.array([1.0, 0.0, -1.0]), 101325.0)
    assert warm[0] == pytest.approx(1.52, abs=5e-3)
    assert cold[0] == pytest.approx(0.76, abs=5e-3)
    assert warm[1] == pytest.approx(cold[1], rel=1e-3)
    assert (warm[2], cold[2]) == (pytest.approx(cold[0]), pytest.approx(warm[0]))
