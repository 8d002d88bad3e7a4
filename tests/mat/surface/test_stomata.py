"""Resistance of canopies: light opens leaves, dry, cold or hot air closes them."""

import numpy as np
import pytest

from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.stomata import CLOSED, canopy_resistance
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

GRASS, OAK = (40 / 3, 0.01), (20.0, 1.0)
LAYER = Layer(0.1, 0.3, 300.0, 3000.0)
STACK = ThermalStack(LAYER, (LAYER, LAYER), Back("fixed"))


def resistance(canopy, sunlight, kelvin=298.15, humidity=1.0):
    vapour = humidity * saturation_pressure(kelvin)
    return float(canopy_resistance(*canopy, np.array(sunlight), np.array(kelvin), (vapour, np.array(1e5))))


@pytest.mark.parametrize("canopy, half_open", [(GRASS, 300 / 1.1), (OAK, 150 / 1.1)])
def test_light_by_hand(canopy, half_open):
    """Noilhan and Planton: (1 + f) / (f + r_min / 5000) with r_min of the leaf; f = 1 at half-open light."""
    leaf = canopy[0] * (3 if canopy is GRASS else 5)
    assert resistance(canopy, half_open) == pytest.approx(canopy[0] * 2 / (1 + leaf / 5000))
    assert resistance(canopy, 1e6) == pytest.approx(canopy[0], rel=1e-3)


def test_leaves_without_light_are_closed():
    """r_s,max over the leaf area: 1,667 s/m of grass."""
    assert resistance(GRASS, 0.0) == pytest.approx(CLOSED / 3)
    assert resistance(GRASS, 0.0, 283.15) <= CLOSED


def test_dry_air_closes_leaves():
    """10 g/kg below saturation: 1 + 36.35 x 0.01 for grass; 25 C and 1000 hPa saturate at 0.622 x 3169.7 Pa."""
    humidity = 1 - 0.01 * 1e5 / (0.622 * 3169.7)
    assert resistance(GRASS, 800.0, humidity=humidity) / resistance(GRASS, 800.0) == pytest.approx(1.3635, rel=1e-3)


@pytest.mark.parametrize("kelvin", [283.15, 313.15])
def test_cold_and_heat_close_leaves(kelvin):
    """15 K from 25 C: 1 - 0.0016 x 225 = 0.64 of the conductance."""
    assert resistance(GRASS, 800.0, kelvin) / resistance(GRASS, 800.0) == pytest.approx(1 / 0.64)


def test_frost_and_furnace_stay_finite():
    for kelvin in (150.0, 250.0, 350.0):
        assert resistance(OAK, 800.0, kelvin) <= CLOSED


def test_meadow_transpires_by_day_alone():
    """At midnight less than 10 W/m2, where 3 to 8 are measured over forest; at noon what FAO Paper 56 has for grass in
    such air, r_s 50 s/m by day, within a third."""
    surface = SurfaceProperties(GRASS[1], 1.0, GRASS[0], True, False)
    material = SurfaceMaterial("meadow", STACK, surface, 0.8, 0.97)
    vapour = np.array([[0.7 * saturation_pressure(288.15), 0.5 * saturation_pressure(298.15)]])
    air = np.array([[288.15, 298.15]])
    zero = np.zeros((1, 2))
    sun = np.array([[0.0, 800.0]])
    forcing = Forcing(sun, zero, zero, zero + 350, zero, air, vapour, zero + 1e5, zero + 2, np.ones((1, 1)))
    night, noon = Balance(forcing, material).fluxes(air)["evaporation"][0]
    volumetric = 1e5 / (287.053 * 298.15) * 1013.0
    neutral = np.log1p(10 / 0.01) * np.log1p(2 * np.e**2 / 0.01) / (0.16 * 2)
    reference = volumetric / 66.5 * 0.5 * 3169.7 / (neutral + 50.0)
    assert 0 < night < 10
    assert noon == pytest.approx(reference, rel=0.33)
