"""Vapour pressure over water and ice against published values."""

import numpy as np
import pytest

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.vapour import saturation_pressure, surface_vapour, surface_vapour_and_slopes


@pytest.mark.parametrize(
    ("celsius", "pascal", "tolerance"),
    # IAPWS formulation of 1995 (Wagner and Pruss 2002, J. Phys. Chem. Ref. Data 31, 387); supercooled: Smithsonian.
    [
        (-20, 125.4, 5e-3),
        (0.01, 611.657, 1e-5),
        (20, 2339.3, 2e-4),
        (40, 7384.9, 2e-4),
        (60, 19946.0, 1e-3),
        (80, 47414.0, 3e-3),
    ],
)
def test_saturation_pressure_over_water(celsius, pascal, tolerance):
    assert saturation_pressure(celsius + 273.15) == pytest.approx(pascal, rel=tolerance)


def test_over_liquid_water_a_surface_has_the_saturation_pressure_of_the_air():
    kelvin = np.linspace(273.16, 350.0, 50)
    assert surface_vapour(kelvin)[0] == pytest.approx(saturation_pressure(kelvin), rel=1e-14)


@pytest.mark.parametrize("celsius, pascal", [(-10, 259.9), (-20, 103.26), (-40, 12.84), (5, 872.6)])
def test_vapour_pressure_of_frost(celsius, pascal):
    """Murphy and Koop (2005) over ice; the IAPWS value over water."""
    vapour, latent_heat = surface_vapour(np.array([celsius + 273.15]))
    assert vapour[0] == pytest.approx(pascal, rel=3e-3)
    assert latent_heat[0] == pytest.approx(1.133 if celsius < 0 else 1.0, abs=1e-3)


@pytest.mark.parametrize("celsius", [-35.0, -1.5, -0.5, 0.5, 25.0])
def test_slopes_are_the_derivatives(celsius):
    around = celsius + ZERO_CELSIUS + np.array([-1e-4, 0.0, 1e-4])
    pressure, latent_heat = surface_vapour(around)
    latent_heat = latent_heat + np.zeros(3)
    same, same_heat, slope, latent_slope = surface_vapour_and_slopes(around)
    latent_slope = latent_slope + np.zeros(3)
    assert np.allclose(same, pressure, rtol=1e-14) and np.allclose(same_heat, latent_heat, rtol=1e-14)
    assert slope[1] == pytest.approx((pressure[2] - pressure[0]) / 2e-4, rel=1e-5)
    assert latent_slope[1] == pytest.approx((latent_heat[2] - latent_heat[0]) / 2e-4, rel=1e-4, abs=1e-9)


def test_half_of_the_water_is_frozen_in_the_middle_of_the_range():
    """One degree below zero the latent heat lies halfway between 1 and 2.834 / 2.501."""
    _, latent_heat = surface_vapour(np.array([ZERO_CELSIUS - 1.0]))
    assert latent_heat[0] == pytest.approx(0.5 * (1 + 2.834 / 2.501))


def test_no_vapour_leaves_a_surface_of_deep_cold():
    pressure, _ = surface_vapour(np.array([40.0, 100.0, 150.0]))
    assert np.all(pressure == pressure[2]) and pressure[2] < 2e-5
    assert np.all(surface_vapour_and_slopes(np.array([40.0, 100.0]))[2] == 0)
