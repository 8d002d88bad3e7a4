"""Transfer coefficients of wind and of free convection against published laws and limits."""

import numpy as np
import pytest

from skyshine.mat.surface.convection import air_density, forced_coefficient, natural_coefficients
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
    warmer, colder = natural_coefficients(np.array([1.0, 0.0, -1.0]), 101325.0)
    assert warmer[0] == pytest.approx(1.52, abs=5e-3)
    assert colder[0] == pytest.approx(0.76, abs=5e-3)
    assert warmer[1] == pytest.approx(colder[1], rel=1e-3)
    assert (warmer[2], colder[2]) == (pytest.approx(colder[0]), pytest.approx(warmer[0]))


def test_a_rough_plate_has_the_larger_constant():
    """McAdams' table: 0.53 rough over 0.50 smooth, from a roughness of a thirtieth of a millimetre on."""
    smooth, rough = (
        forced_coefficient(5.0, 101325.0, 290.0, SurfaceProperties(length, 0.0, 0.0, False, False))
        for length in (2.9e-5, 3.1e-5)
    )
    assert rough / smooth == pytest.approx(0.53 / 0.50, rel=1e-9)


def test_thin_air_transfers_less():
    """A turbulent plate goes with density^0.8, the logarithmic law with density, free convection with density^(2/3)."""
    half = 0.5 * 101325.0
    plate = [forced_coefficient(5.0, pressure, 290.0, SMOOTH) for pressure in (half, 101325.0)]
    canopy = SurfaceProperties(0.05, 0.0, 0.0, True, False)
    log_law = [forced_coefficient(5.0, pressure, 290.0, canopy) for pressure in (half, 101325.0)]
    free = [natural_coefficients(1.0, pressure)[0] for pressure in (half, 101325.0)]
    assert plate[0] / plate[1] == pytest.approx(0.5**0.8)
    assert log_law[0] / log_law[1] == pytest.approx(0.5)
    assert free[0] / free[1] == pytest.approx(0.5 ** (2 / 3))


def test_rough_ground_takes_the_larger_law():
    """Over 10 cm of roughness the logarithmic law exceeds that of a plate, and no canopy is needed for it to hold."""
    ground = SurfaceProperties(0.1, 0.0, 0.0, False, False)
    value = forced_coefficient(3.0, 101325.0, 293.15, ground)
    assert value == pytest.approx(3 * 1.2041 * 1013 * 0.16 / (np.log(101) * np.log(1 + 20 * np.e**2)), rel=1e-3)
    assert value > 7.6 * (0.723 * 3.0) ** 0.78


def test_density_of_dry_air():
    """ISO 2533: 1.225 kg/m3 at 15 C and 101325 Pa; 8 % more at the Dead Sea's 106.5 kPa and 25 C than at 35 C and sea
    level."""
    assert air_density(101325.0, 288.15) == pytest.approx(1.225, abs=5e-5)
    assert air_density(106.5e3, 298.15) / air_density(101325.0, 308.15) == pytest.approx(1.0864, abs=1e-3)
