"""Power that modules deliver: the law of cells, and a module beside a formula fitted to measured ones."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.library import load_library

AIR = 293.15  # K


def module(**surface):
    (material,) = surface_materials([load_library()["pv_module"]])
    return replace(material, surface=replace(material.surface, **surface))


def forcing(sunlight, wind, steps=48):
    """A steady clear noon over a module that faces the Sun at 35 degrees."""

    def row(value):
        return np.full((1, steps), float(value))

    cosine = np.cos(np.radians(35.0))
    black = 5.670374e-8 * AIR**4
    return Forcing(
        row(sunlight),
        row(0),
        row(0),
        row(0.5 * (1 + cosine) * (black - 90)),
        row(0.5 * (1 - cosine) * black),
        row(AIR),
        row(1200),
        row(1e5),
        row(wind),
        np.array([[cosine]]),
    )


def test_power_follows_the_law_of_evans():
    """19 % of 800 W/m2 at 25 C are 152 W/m2, 30 K warmer 0.0035 of that less by each kelvin: 136.04; slopes as well."""
    sky, with_power, without = forcing(800, 2), module(), module(delivered=0.0)
    for kelvin, power in ((298.15, 152.0), (328.15, 136.04)):
        temperature = np.full((1, 48), kelvin)
        delivering, idle = (Balance(sky, material) for material in (with_power, without))
        np.testing.assert_allclose(delivering.loss(temperature) - idle.loss(temperature), power, atol=1e-6)
        net, slope = delivering.loss_and_slope(temperature)
        np.testing.assert_allclose(net, delivering.loss(temperature), atol=1e-9)
        np.testing.assert_allclose(slope - idle.loss_and_slope(temperature)[1], -0.0035 * 152, atol=1e-9)
        absorbed = (part.fluxes(temperature)["shortwave_absorbed"] for part in (idle, delivering))
        np.testing.assert_allclose(-np.diff([*absorbed], axis=0), power, atol=1e-6)


@pytest.mark.parametrize("sunlight", [400.0, 700.0, 1000.0])
@pytest.mark.parametrize("wind", [1.0, 2.0, 4.0, 7.0])
def test_module_is_as_warm_as_measured_ones(sunlight, wind):
    """Faiman (2008), Prog. Photovolt. 16, 307-315: modules on racks are G / (25.0 + 6.84 v) above the air, fitted to a
    year of measurements, v the wind beside them. Without power ours is 2 to 9 K warmer."""
    beside = wind * np.log(2.0 / 0.03) / np.log(10.0 / 0.03)
    measured = sunlight / (25.0 + 6.84 * beside)
    ((_, solution),) = solve_columns(module(), lambda steps: forcing(sunlight, wind, steps), steps=48)
    assert abs(solution.temperature[0, 0] - AIR - measured) < 1.5
    assert abs(solution.energy_closure[0]) < 1e-2
