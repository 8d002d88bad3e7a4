"""Sky irradiance: the flux of an isothermal slab, and its interpolation over altitude."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expn

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.quantities.sky_table import SKY_HEIGHTS, SkyTable

EDGES = np.array([900.0, 1000.0])
KELVIN = 270.0


@pytest.fixture(scope="module")
def air(synthetic_points, isothermal):
    points = synthetic_points(EDGES, {"CO2": np.array([3e-28, 3e-27, 3e-26, 1e-23])})
    return replace(SpectralAir.of(isothermal(KELVIN), points), scatters=False)


def table(air, altitude, *irradiance):
    return SkyTable(air, np.array(altitude), np.log(np.array(irradiance))[:, None, None])


def test_flux_of_an_isothermal_slab(air):
    """pi B (1 - 2 E3(tau)) of a plane layer; the Earth's roundness shortens the slant paths, by little."""
    planck = 1.191042972e-8 * 950.0**3 / np.expm1(1.438776877 * 950.0 / KELVIN)
    state = air.state
    column = np.trapezoid(state.number_density * state.mole_fraction["CO2"], state.altitude)
    expected = np.pi * planck * (1 - 2 * expn(3, column * np.array([3e-28, 3e-27, 3e-26, 1e-23])))
    found = SkyTable.of(air, np.array([0.0]), np.zeros(1), np.zeros(4)).at(np.array([0.0]))[0, 0]
    assert expected[0] < 0.1 * expected[-1]
    assert found == pytest.approx(expected, rel=0.03)


def test_nodes_are_sorted_once_and_end_at_the_top(air):
    nodes = SkyTable.of(air, np.array([5e3, 0.0, 5e3, 900e3]), np.zeros(1), np.zeros(4)).altitude
    assert nodes.tolist() == [0.0, 5e3, air.shells.top]


def test_heights_count_from_the_ground(air):
    found = SkyTable.over_ground(air, np.zeros(1), np.zeros(4))
    assert found.altitude == pytest.approx(air.state.surface_altitude + np.array(SKY_HEIGHTS))
    sky = np.exp(found.log_irradiance[:, 0])
    assert np.all(np.diff(sky[:, :2], axis=0) < 0)  # thinner air above, a darker sky


def test_between_nodes_it_is_exponential(air):
    found = table(air, [0.0, 1000.0, 3000.0], 8.0, 2.0, 0.5).at(np.array([0.0, 500.0, 1000.0, 2000.0, 3000.0]))
    assert found.ravel() == pytest.approx([8.0, 4.0, 2.0, 1.0, 0.5])


def test_above_the_highest_node_it_falls_with_pressure_to_nothing_in_space(air):
    one = table(air, [2000.0], 6.0)
    height = np.array([2000.0, 7000.0, 12000.0, 500e3])
    found = one.at(height).ravel()
    # US Standard Atmosphere 1976: 795.01, 411.05 and 193.99 hPa at 2, 7 and 12 km.
    assert found[:3] == pytest.approx(6.0 * np.array([795.01, 411.05, 193.99]) / 795.01, rel=5e-3)
    assert found[3] == 0.0


def test_one_node_holds_below_itself(air):
    assert table(air, [2000.0], 6.0).at(np.array([0.0])).ravel() == pytest.approx([6.0])
