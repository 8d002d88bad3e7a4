"""Solar absorptance of the heat balance: the mean over sunlight as it reaches the ground."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.sources.solar import ground_sunlight, solar_irradiance
from skyshine.mat.scene.material_summary import material_summary
from skyshine.mat.scene.surface import surface_materials
from skyshine.materials.library import load_library


def test_sunlight_of_the_standard_is_a_kilowatt_without_what_water_vapour_takes():
    """ASTM G173 global tilted: 1000.4 W m^-2; nearly nothing is left at 1.38 um, which water vapour absorbs."""
    wavelength, irradiance = ground_sunlight()
    assert np.trapezoid(irradiance, wavelength) == pytest.approx(1000.4, abs=0.5)
    above = solar_irradiance(1e4 / np.array([0.55, 1.38])) * 1e4 / np.array([0.55, 1.38]) ** 2
    assert np.interp([0.55, 1.38], wavelength, irradiance) / above == pytest.approx([0.82, 0.0], abs=0.06)


@pytest.mark.parametrize(
    "name, above_the_air, at_the_ground",
    [("snow_fine", 0.183, 0.153), ("wood_pine", 0.426, 0.393), ("tar", 0.949, 0.949)],
)
def test_heat_balance_weighs_by_it(name, above_the_air, at_the_ground):
    """Snow and wood absorb the near infrared, of which water vapour has taken a part."""
    material = load_library()[name]
    (surface,) = surface_materials([material])
    assert surface.solar_absorptance == pytest.approx(at_the_ground, abs=0.002)
    assert material_summary(material)["solar_absorptance"] == pytest.approx(surface.solar_absorptance, abs=1e-12)
    assert surface.solar_absorptance < above_the_air + 0.001
