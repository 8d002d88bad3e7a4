"""The temperature of a black body against Planck's law, integrated adaptively."""

from pathlib import Path

import numpy as np
import pytest
from scipy import constants
from scipy.integrate import quad

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.mat.tables.axes import EXACT, table_axis
from skyshine.mat.tables.band import TEMPERATURES, BandTable, band_radiance
from skyshine.schemas.hdf5 import Axis, Group, Variable

NAMES = np.array(["asphalt_road", "grass_green"], object)
BAND = SpectralResponse([8.0, 12.0], [1.0, 1.0])
RADIANCE = "W m^-2 sr^-1"


def band(reflectance) -> BandTable:
    axes = {
        "wavelength": Axis(BAND.wavelength, "um", ""),
        "temperature": table_axis(TEMPERATURES, "K", ""),
        "material": table_axis(np.array([22, 68], np.int32), "1", "", interpolation=EXACT),
    }
    variables = {
        "blackbody_radiance": Variable(("temperature",), band_radiance(BAND, TEMPERATURES), RADIANCE, ""),
        "reflectance": Variable(("material",), np.asarray(reflectance, float), "1", ""),
        "material_name": Variable(("material",), NAMES, "1", ""),
    }
    return BandTable(Path("b01.band.h5"), "band", Group(axes, variables), {})


def planck(kelvin: float) -> float:
    """Radiance of a black body from 8 to 12 um, by adaptive quadrature in SI units."""
    h, c, k = constants.h, constants.c, constants.k
    return quad(
        lambda x: 2 * h * c**2 / x**5 / np.expm1(h * c / (x * k * kelvin)), 8e-6, 12e-6, epsabs=0, epsrel=1e-10
    )[0]


def test_equivalent_temperature_below_the_table_and_of_nothing():
    table = band([0.0, 0.0])
    assert equivalent_temperature(table, np.array([planck(140.0)]))[0] == pytest.approx(140.0, abs=0.3)
    assert equivalent_temperature(table, np.array([0.0]))[0] == 0.0


def test_equivalent_temperature_within_the_table():
    assert equivalent_temperature(band([0.0, 0.0]), np.array([planck(300.0)]))[0] == pytest.approx(300.0, abs=2e-3)
