"""Sunlight absorbed within ice: closed forms, a march of finite volumes, energy, and days before."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.products.shade_error import stored_response
from skyshine.mat.surface.column import from_scene
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.penetrating_light import (
    absorbed_sunlight,
    delayed_light,
    light_at_depth,
    light_response,
    penetrating_light_matrix,
)
from skyshine.mat.surface.response import response_table
from skyshine.mat.surface.solver import DAY, solve_columns
from skyshine.mat.surface.symbolic_balance import SymbolicMaterial
from skyshine.mat.tables.response import FORCING_STEPS
from skyshine.materials.records import Back, Layer, PenetratingLight, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

ICE = {"conductivity": 2.2, "density": 917.0, "heat_capacity": 2100.0}
SKIN = Layer(0.001, **ICE)


def stack(*light, depths=(0.1, 0.2), back=None):
    layers = tuple(Layer(depth, **ICE) for depth in depths)
    return ThermalStack(SKIN, layers, back or Back("fixed", 271.35), light)


def ice(thermal, snow=False):
    return SurfaceMaterial("ice", thermal, SurfaceProperties(1e-3, 0.0, 0.0, False, snow), 0.5, 0.96)


@pytest.mark.parametrize("extinction", [0.1, 1.5, 20.0, 300.0])
def test_endless_ice_passes_a_wave_as_its_closed_form(extinction):
    """The integral of k exp(-k z) exp(-g z) over all depths is k / (k + g)."""
    s = 2j * np.pi * np.array([0.0, 1.0, 8.0, 96.0]) / DAY
    deep = stack(PenetratingLight(0.4, extinction), depths=(0.1, np.inf))
    g = np.sqrt(s * ICE["density"] * ICE["heat_capacity"] / ICE["conductivity"])
    assert light_response(deep, s) == pytest.approx(0.4 * (extinction / (extinction + g) - 1), abs=2e-5)


def test_steady_light_in_a_slab_over_water_arrives_by_its_distance_from_it():
    """A linear profile: heat at depth z of d reaches the surface by 1 - z / d."""
    k, d = 6.4, 0.3
    z = (np.arange(200000) + 0.5) / 200000 * d
    weight = k * np.exp(-k * z) / (1 - np.exp(-k * d))
    arriving = float(np.mean(weight * (1 - z / d)) * d)
    found = light_response(stack(PenetratingLight(0.5, k)), np.zeros(1, complex))
    assert found.real == pytest.approx([0.5 * (arriving - 1)], abs=1e-6)


def test_all_steady_light_leaves_ice_on_a_closed_back_at_its_surface():
    closed = stack(PenetratingLight(0.7, 3.0), back=Back("adiabatic"))
    assert abs(light_response(closed, np.zeros(1, complex))[0]) < 1e-9


@pytest.mark.parametrize("extinction", [0.1, 6.4, 300.0])
@pytest.mark.parametrize("depth", [0.01, 0.1, 1.0])
def test_light_warms_endless_ice_at_a_depth_as_its_closed_form(extinction, depth):
    """k T'' - c s T = -a exp(-a z), T = 0 at the surface: T = a (exp(-a z) - exp(-g z)) / (k (g^2 - a^2))."""
    s = 2j * np.pi * np.array([1.0, 8.0, 96.0]) / DAY
    deep = stack(PenetratingLight(0.4, extinction), depths=(0.3, np.inf))
    g = np.sqrt(s * ICE["density"] * ICE["heat_capacity"] / ICE["conductivity"])
    shape = (np.exp(-extinction * depth) - np.exp(-g * depth)) / (g**2 - extinction**2)
    expected = 0.4 * extinction / ICE["conductivity"] * shape
    assert light_at_depth(deep, s, depth) == pytest.approx(expected, rel=2e-3, abs=1e-6)


@pytest.mark.parametrize("depth", [0.0, 0.05, 0.1, 0.25, 0.3])
def test_steady_light_warms_a_slab_over_water_by_its_parabola_and_one_on_a_closed_back_by_what_is_below(depth):
    """k T'' = -1 / d within d = 0.3 m: T = z (d - z) / (2 k d) over water, z (d - z / 2) / (k d) on a closed back."""
    k, d, even = ICE["conductivity"], 0.3, 1e-6
    for back, expected in (
        (Back("fixed", 271.35), depth * (d - depth) / (2 * k * d)),
        (Back("adiabatic"), depth * (d - depth / 2) / (k * d)),
    ):
        found = light_at_depth(stack(PenetratingLight(1.0, even), back=back), np.zeros(1, complex), depth)
        assert found.real == pytest.approx([expected], abs=1e-7)


def test_the_temperature_at_a_depth_of_ice_leads_to_that_of_its_surface(cold):
    """Close to the surface it is that of the surface; in the light it is warmer than without."""
    lit = ice(stack(PenetratingLight(0.47, 6.4), PenetratingLight(0.26, 69.0)))
    sun, weather, sky = cold.sun, cold.weather, cold.sky
    found = {depth: from_scene(lit, sun, weather, sky, 0.0, 0.0, 0.0, depth) for depth in (0.0, 1e-4, 0.05)}
    surface = found[0.0].temperature
    assert np.abs(found[0.0].depth_temperature - surface).max() < 1e-9
    assert np.abs(found[1e-4].depth_temperature - surface).max() < 0.05
    dark = from_scene(replace(lit, thermal=replace(lit.thermal, light=())), sun, weather, sky, 0.0, 0.0, 0.0, 0.05)
    lift = (found[0.05].depth_temperature - surface) - (dark.depth_temperature - dark.temperature)
    assert lift.max() > 0.5


def marched(thermal, light, air, coefficient, cells=300, days=6, steps=576):
    """Finite volumes by the trapezium rule: a skin that absorbs the rest, light in each cell, a linear loss."""
    depth = sum(layer.thickness for layer in thermal.layers)
    width = depth / cells
    capacity = ICE["density"] * ICE["heat_capacity"]
    edges = np.arange(cells + 1) * width
    absorbed = sum(
        part.share
        * (np.exp(-part.extinction * edges[:-1]) - np.exp(-part.extinction * edges[1:]))
        / (1 - np.exp(-part.extinction * depth))
        for part in thermal.light
    )
    at_surface = 1 - sum(part.share for part in thermal.light)
    between = ICE["conductivity"] / width * np.array([2.0, *np.ones(cells - 1), 2.0])  # skin, cells, water
    matrix = -np.diag([coefficient + between[0], *(between[:-1] + between[1:])])
    matrix += np.diag(between[:-1], 1) + np.diag(between[:-1], -1)
    storage = capacity * np.array([SKIN.thickness, *np.full(cells, width)])
    steady = np.zeros(cells + 1)
    steady[0], steady[-1] = coefficient * air, between[-1] * thermal.back.temperature
    sun = np.array([at_surface, *absorbed])
    step = DAY / steps
    implicit = np.linalg.inv(np.diag(storage / step) - matrix / 2)
    state, surface = np.full(cells + 1, 266.0), []
    for number in range(days * steps):
        drive = steady + sun * 0.5 * (light(number * step) + light((number + 1) * step))
        state = implicit @ (storage / step * state + matrix @ state / 2 + drive)
        surface.append(state[0])
    return np.roll(surface[-steps:], 1)


def test_a_day_of_ice_agrees_with_a_march_of_finite_volumes():
    thermal = stack(PenetratingLight(0.47, 6.4), PenetratingLight(0.26, 69.0))

    def sunlight(seconds):
        return 300.0 * np.maximum(-np.cos(2 * np.pi * seconds / DAY), 0.0)

    march = marched(thermal, sunlight, 260.0, 12.0, cells=120, days=4)
    steps = 288
    conduction = Conduction(thermal, steps, DAY, "spectral")
    light = sunlight(np.arange(steps) * DAY / steps)
    source = light + penetrating_light_matrix(conduction) @ light + 12.0 * 260.0 + conduction.steady_transfer * 271.35
    solved = conduction.relax(source[None, :], 12.0)[0]
    at = np.interp(np.arange(steps) / steps, np.arange(march.size) / march.size, march)
    assert np.abs(solved - at).max() < 0.02
    bare = conduction.relax((source - penetrating_light_matrix(conduction) @ light)[None, :], 12.0)[0]
    assert np.abs(bare - at).max() > 2.0  # the light at the surface alone


@pytest.mark.parametrize("scheme", ["bdf2", "euler"])
def test_delayed_light_sums_to_the_matrix_of_a_period(scheme):
    thermal, steps = stack(PenetratingLight(0.6, 8.0)), 48
    response = delayed_light(thermal, DAY / steps, 12 * steps, scheme)
    folded = response.reshape(12, steps).sum(axis=0)
    assert folded == pytest.approx(penetrating_light_matrix(Conduction(thermal, steps, DAY, scheme))[:, 0], abs=1e-6)


@pytest.fixture
def cold(sun_path, weather, sky):
    air = replace(weather, air_temperature=weather.air_temperature - 40.0, vapour_pressure=np.full(1, 50.0))
    return Scene(sun_path, air, sky, np.zeros(1), np.array([0.0, 60.0]), np.array([0.0, 180.0]))


def test_equal_days_before_leave_the_day_that_repeats(cold):
    material = ice(stack(PenetratingLight(0.5, 3.0)))
    forcing = cold.days[0]
    ((_, once),) = solve_columns(material, forcing, steps=192, scheme="bdf2")
    ((_, often),) = solve_days(material, [forcing] * 4)
    assert once.temperature == pytest.approx(often.temperature, abs=0.02)


def test_sunlight_of_the_day_before_warms_the_morning_after(cold):
    """The last day is dark: what is left of yesterday's light came from within."""
    day = cold.days[0]

    def night(steps):
        forcing = day(steps)
        none = np.zeros(forcing.shape)
        dark = dict.fromkeys(("shortwave_direct", "shortwave_diffuse", "shortwave_reflected"), none)
        return replace(forcing, **dark)

    deep, bare = ice(stack(PenetratingLight(0.8, 8.0), depths=(0.5, 1.0))), ice(stack(depths=(0.5, 1.0)))
    ((_, first),) = solve_days(deep, [day, day, night])
    ((_, second),) = solve_days(bare, [day, day, night])
    change = (first.temperature - second.temperature)[0]
    assert change[0] > 0.02  # heat that was let in arrives later than heat at the surface


def test_no_light_inside_leaves_the_solution_as_it_is(cold):
    ((_, plain),) = solve_columns(ice(stack()), cold.forcing)
    ((_, tiny),) = solve_columns(ice(stack(PenetratingLight(1e-9, 5.0))), cold.forcing)
    ((_, steep),) = solve_columns(ice(stack(PenetratingLight(1.0, 1000.0))), cold.forcing)
    assert plain.temperature == pytest.approx(tiny.temperature, abs=1e-4)
    assert plain.temperature == pytest.approx(steep.temperature, abs=0.35)  # a millimetre below
    assert max(plain.bound_excess.max(), tiny.bound_excess.max(), steep.bound_excess.max()) < 1e-6


def test_deep_light_cools_the_surface_and_breaks_no_bound(cold):
    ((_, plain),) = solve_columns(ice(stack()), cold.forcing)
    ((_, deep),) = solve_columns(ice(stack(PenetratingLight(0.6, 2.0))), cold.forcing)
    assert (plain.temperature - deep.temperature).max() > 2.0
    assert deep.bound_excess.max() < 1e-6 and deep.residual.max() < 1e-3
    assert np.abs(deep.energy_closure).max() < 1e-3


def test_the_response_to_shade_is_that_of_less_sunlight(cold):
    """A tenth of the sunlight less, for some hours; the heat loss hardly bends over so little."""
    material = ice(stack(PenetratingLight(0.8, 5.0), depths=(0.2, 0.3)))
    response = stored_response(response_table([material], cold))
    faces = [np.ones(1, int), np.zeros(1), np.zeros(1), np.zeros(1)]  # code, altitude, azimuth, slope
    forcing = cold.forcing(FORCING_STEPS).columns(np.array([0]))
    hidden = np.where(np.abs(np.arange(FORCING_STEPS) / FORCING_STEPS - 0.5) < 0.1, 0.1, 0.0)[None, :]
    less = {name: getattr(forcing, name) * (1 - hidden) for name in ("shortwave_direct", "shortwave_diffuse")}
    less["shortwave_reflected"] = forcing.shortwave_reflected * (1 - hidden)
    surfaces = []
    for each in (forcing, replace(forcing, **less)):
        ((_, solution),) = solve_columns(material, lambda _, each=each: each, steps=FORCING_STEPS)
        surfaces.append(solution.temperature)
    absorbed = -hidden * absorbed_sunlight(material, forcing)
    change = response.changes(faces, absorbed, surfaces[0], np.full(1, 1e4))
    want = surfaces[1] - surfaces[0]
    assert want.min() < -0.15
    assert change == pytest.approx(want, abs=0.06 * np.abs(want).max())


def test_equations_that_do_not_know_it_refuse_it():
    with pytest.raises(InputError, match="material 'ice': lets sunlight in; allowed: others; take another"):
        SymbolicMaterial.of(ice(stack(PenetratingLight(0.5, 3.0))))
