"""Temperatures at single places: thermal equilibrium, the table's own nodes, time between the solver's steps."""

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator

from skyshine.mat.budget.truth import temperatures_at
from skyshine.mat.surface.forcing import Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.sun_path import SunPath, sun_hours
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.table import temperature_table
from skyshine.mat.surface.weather import from_extremes
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

LAYER = Layer(0.02, 0.5, 1500.0, 900.0)
DRY = SurfaceProperties(1e-3, 0.0, 0.0, False, False)
DARK, BRIGHT = (
    SurfaceMaterial(name, ThermalStack(Layer(2e-3, 0.5, 1500.0, 900.0), (LAYER, LAYER), Back("adiabatic")), DRY, a, 0.9)
    for name, a in (("dark", 0.9), ("bright", 0.2))
)
HEIGHT = np.array([0.0, 3000.0])


def world(elevation, low, high, emissivity):
    """Air and sky of a day with the Sun at elevations [degree], in the south at noon."""
    sun = SunPath(0.0, elevation, np.mod(15 * sun_hours(), 360.0))
    degrees = np.arange(-5.0, 91.0)
    direct = np.where(degrees > 0, 900.0, 0.0) * np.ones((2, 1))
    pressure, aureole = 101325 * np.exp(-HEIGHT / 8e3), 0 * degrees
    sky = Sky(HEIGHT, pressure, degrees, direct, 0.1 * direct, aureole, np.full(2, emissivity), 0.2)
    return sun, from_extremes(sun, low, high, 30.0, 2.0, 0.0), sky


DAY = world(60.0 * np.cos(np.radians(15 * (sun_hours() - 12))), 288.0, 300.0, 0.8)
PLACES = {"altitude_km": 0.0, "azimuth_deg": 180.0, "slope_deg": 30.0, "time_h": 12.0}


def at(inputs=DAY, materials=(DARK, BRIGHT), count=1, **places):
    columns = [np.broadcast_to(np.asarray(places.get(name, value), float), count) for name, value in PLACES.items()]
    return temperatures_at(materials, inputs, *columns, steps=96)


def test_in_the_dark_under_a_black_sky_of_the_same_temperature_nothing_warms_or_cools():
    """Air and sky at 285 K, no Sun: every level surface is at 285 K, whatever its material."""
    night = world(np.full(sun_hours().size, -40.0), 285.0, 285.0, 1.0)
    found = at(night, count=3, slope_deg=0.0, time_h=[0.0, 11.1, 23.9])
    assert found == pytest.approx(np.full((3, 2), 285.0), abs=0.01)


def test_nodes_of_a_table_are_its_values():
    altitude, azimuth, slope, time = [0.0, 1000.0], [90.0, 180.0], [0.0, 45.0], [6.0, 12.0, 18.25]
    table = temperature_table([DARK, BRIGHT], *DAY, altitude, azimuth, slope, time, steps=96).temperature
    z, a, s, t = (axis.ravel() for axis in np.meshgrid([0, 1], [0, 1], [0, 1], [0, 1, 2], indexing="ij"))
    found = at(
        count=z.size,
        altitude_km=np.array(altitude)[z] / 1e3,
        azimuth_deg=np.array(azimuth)[a],
        slope_deg=np.array(slope)[s],
        time_h=np.array(time)[t],
    )
    np.testing.assert_allclose(found, table[:, z, a, s, t].T, atol=2e-3)
    assert np.ptp(found) > 15


def test_more_places_than_a_batch_are_each_as_alone():
    draw = np.random.default_rng(8)
    places = {
        "altitude_km": draw.uniform(0, 2, 30),
        "azimuth_deg": draw.uniform(0, 360, 30),
        "slope_deg": draw.uniform(0, 90, 30),
        "time_h": draw.uniform(0, 24, 30),
    }
    together = at(count=30, **places)
    for row in (0, 23, 24, 29):
        alone = at(**{name: values[row] for name, values in places.items()})
        assert together[row] == pytest.approx(alone[0], abs=2e-3)


def test_between_steps_of_the_solver_time_is_read_by_akima_and_the_day_closes():
    hours = np.array([10.0, 10.1, 10.25, 24.0, 0.0, 23.875, 23.75, -0.25])
    found = at(count=hours.size, time_h=hours)[:, 0]
    day = at(count=96, time_h=np.arange(96) / 4)[:, 0]
    akima = Akima1DInterpolator(np.arange(-96, 192) / 4, np.tile(day, 3))
    assert found[[1, 5]] == pytest.approx(akima([10.1, 23.875]), abs=1e-5)
    assert found[3] == pytest.approx(found[4], abs=1e-9) and found[6] == pytest.approx(found[7], abs=1e-9)


def test_each_place_has_its_own_shadows_and_walls():
    """In the shade all day a black sky and a wall of 285 K give 285 K; beside it the open place is in the Sun."""
    noon = world(60.0 * np.cos(np.radians(15 * (sun_hours() - 12))), 285.0, 285.0, 1.0)
    around = [Surroundings(((0.0, 24.0),), 0.0, 285.0, 1.0), Surroundings(), Surroundings(((6.0, 9.0),))]
    columns = [np.full(3, value) for value in (0.0, 180.0, 0.0, 12.0)]
    shaded, open_air, before = temperatures_at([DARK], noon, *columns, steps=96, surroundings=around)[:, 0]
    assert shaded == pytest.approx(285.0, abs=0.01)
    assert shaded + 5 < before < open_air - 0.1


def test_a_given_temperature_replaces_the_solution():
    hourly = tuple(280.0 + hour for hour in range(24))
    columns = [np.full(2, value) for value in (0.0, 180.0, 30.0)]
    found = temperatures_at(
        [DARK, BRIGHT], DAY, *columns, [6.5, 23.5], steps=96, material_temperatures={"bright": hourly}
    )
    assert found[:, 1] == pytest.approx([286.5, 0.5 * (303 + 280)])
    assert found[0, 0] == pytest.approx(at(time_h=6.5)[0, 0], abs=2e-3)
