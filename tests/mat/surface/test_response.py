"""Response to other heat: closed forms of lumps and foils, whole solutions, surfaces without air."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.response import response_planes, response_table, surface_response
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

SURFACE = SurfaceProperties(0.005, 0.0, 0.0, False, False)
WEIGHTLESS = Layer(1e-4, 1.0, 1e-3, 1.0)


def lump(capacity, name="lump"):
    """A skin of a heat capacity [J m^-2 K^-1] before nothing."""
    skin = Layer(0.001, 1e6, capacity / 0.001 / 1000.0, 1000.0)
    return SurfaceMaterial(name, ThermalStack(skin, (WEIGHTLESS, WEIGHTLESS), Back("adiabatic")), SURFACE, 0.8, 0.9)


def steady(pressure=101325.0, longwave=330.0):
    """Weather that does not change, at any number of steps."""
    values = {
        "shortwave_direct": 0.0,
        "shortwave_diffuse": 100.0,
        "shortwave_reflected": 0.0,
        "longwave_sky": longwave,
        "longwave_ground": 0.0,
        "air_temperature": 288.0,
        "vapour_pressure": 900.0,
        "pressure": pressure,
        "wind_speed": 3.0,
    }
    return lambda steps: Forcing(
        **{name: np.full((1, steps), value) for name, value in values.items()}, cos_slope=np.array([[1.0]])
    )


@pytest.mark.parametrize("capacity", [2e4, 2e5])
def test_a_lump_forgets_heat_exponentially(capacity):
    """C dT/dt = q - s T: a cell of lag from a to b holds (exp(-s a / C) - exp(-s b / C)) / s."""
    response = surface_response(lump(capacity), [steady()])
    slope = response.loss_slope[0, 0]
    seconds = 3600 * np.append(LAG_STARTS, LAG_STARTS[0] + 24)
    left = np.exp(-np.maximum(seconds, 0) * slope / capacity)
    expected = (left[:-1] - left[1:]) / slope
    expected /= 1 - np.exp(-86400 * slope / capacity)  # of all days before
    np.testing.assert_allclose(response.kernel[0], np.tile(expected, (24, 1)), atol=0.06 / slope)
    np.testing.assert_allclose(response.kernel[0].sum(axis=1), 1 / slope, rtol=1e-9)


def test_a_foil_follows_at_once():
    response = surface_response(lump(50.0), [steady()])
    np.testing.assert_allclose(response.kernel[0, :, 0] * response.loss_slope[0], 1.0, atol=0.12)
    np.testing.assert_allclose(response.kernel[0].sum(axis=1) * response.loss_slope[0], 1.0, rtol=1e-9)


@pytest.mark.parametrize("pressure", [101325.0, 0.0])
def test_little_heat_moves_the_whole_solution_by_the_response(pressure):
    """With air and in vacuum: 1 W m^-2 all day."""
    material = lump(1e5)
    response = surface_response(material, [steady(pressure)])
    ((_, cold),), ((_, warm),) = (
        solve_columns(material, steady(pressure, longwave), steps=288) for longwave in (330.0, 330.0 + 1 / 0.9)
    )
    moved = (warm.temperature - cold.temperature)[0, ::12]
    np.testing.assert_allclose(response.kernel[0].sum(axis=1), moved, rtol=0.01)
    assert np.all(np.isfinite(response.loss_excess)) and np.all(response.loss_slope > 0)


def test_the_excess_of_the_loss_is_none_at_the_temperature_itself_and_bends_as_radiation():
    """In vacuum f = e s T^4, whose excess over its tangent is e s (6 T^2 x^2 + 4 T x^3 + x^4)."""
    response = surface_response(lump(1e5), [steady(0.0)])
    temperature = response.temperature[0, :, None]
    bend = 0.9 * 5.670374419e-8 * (6 * temperature**2 * OFFSETS**2 + 4 * temperature * OFFSETS**3 + OFFSETS**4)
    np.testing.assert_allclose(response.loss_excess[0], bend, rtol=1e-9, atol=1e-8)


def test_materials_of_given_temperature_do_not_respond(sun_path, weather, sky):
    scene = Scene(sun_path, weather, sky, np.array([0.0, 500.0, 2000.0]), np.array([0.0, 45.0]), np.zeros(2))
    materials = [lump(1e5), lump(1e5, "hot"), replace(lump(1e5), name="twin")]
    table = response_table(materials, scene, prescribed=["hot"])
    assert table.kernel.shape == (3, 4, 2, 24, LAG_STARTS.size)
    assert table.altitudes_m.tolist() == [0, 500, 1250, 2000]  # one between those more than 1 km apart
    assert not table.kernel[1].any() and not table.loss_excess[1].any() and np.all(table.loss_slope[1] == 1)
    assert np.array_equal(table.kernel[0], table.kernel[2]) and table.kernel[0].any()


@pytest.mark.parametrize(
    ("slopes", "planes"),
    [
        ([0], [0]),
        ([0, 30], [0, 90]),
        ([0, 90], [0, 90]),
        ([90], [90]),
        ([10, 100], [0, 90, 180]),
        ([95, 180], [90, 180]),
    ],
)
def test_only_the_planes_around_the_slopes_are_solved(sun_path, slopes, planes):
    chosen, azimuths = response_planes(sun_path, np.array(slopes, float))
    assert chosen.tolist() == planes and np.allclose(azimuths, 180, atol=0.5)
