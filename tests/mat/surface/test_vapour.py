"""Vapour pressure over water and ice against published values."""

import numpy as np
import pytest

from skyshine.mat.surface.vapour import saturation_pressure, surface_vapour


@pytest.mark.parametrize("celsius, pascal", [(0, 611.2), (10, 1228.0), (20, 2339.2), (30, 4246.9), (-20, 125.4)])
def test_saturation_pressure_over_water(celsius, pascal):
    """Smithsonian and IAPWS values; Magnus' form is within 0.2 % of them (0.5 % over supercooled water)."""
    assert saturation_pressure(celsius + 273.15) == pytest.approx(pascal, rel=5e-3)


@pytest.mark.parametrize("celsius, pascal", [(-10, 259.9), (-20, 103.26), (-40, 12.84), (5, 872.6)])
def test_vapour_pressure_of_frost(celsius, pascal):
    """Murphy and Koop (2005) over ice; the IAPWS value over water."""
    found, latent_heat = surface_vapour(np.array([celsius + 273.15]))
    assert found[0] == pytest.approx(pascal, rel=3e-3)
    assert latent_heat[0] == pytest.approx(1.133 if celsius < 0 else 1.0, abs=1e-3)
