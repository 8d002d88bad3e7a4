"""Soil in the gaps of leaves: limits, gaps by quadrature, an independent march, energy, extremes, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from skyshine.mat.products.shade_error import stored_response
from skyshine.mat.surface import canopy as canopy_module
from skyshine.mat.surface import canopy_days as canopy_days_module
from skyshine.mat.surface import solver as solver_module
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.canopy import (
    CanopyBalance,
    gap_to_sky,
    gap_towards,
    mixed_absorptance,
    mixed_emissivity,
    seen_temperature,
    sunlit,
)
from skyshine.mat.surface.canopy_conduction import CanopyConduction
from skyshine.mat.surface.canopy_days import solve_canopy
from skyshine.mat.surface.column import from_scene
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction, surface_admittance
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import Canopy, SurfaceMaterial
from skyshine.mat.surface.response import response_table
from skyshine.mat.surface.solution import Method
from skyshine.mat.surface.solver import DAY, TOLERANCE, ConvergenceError, solve_columns
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.records import Back, Layer, PenetratingLight, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

SIGMA = 5.670374419e-8
LEAF, SPACE = Layer(0.001, 0.57, 700.0, 3800.0), Layer(0.5, 5.0, 4.0, 3800.0)
LOAM = Layer(0.12, 0.9, 1800.0, 1257.0)
STEPS = 192


def soil(**changes):
    """Bare loam over a constant deep temperature."""
    skin = Layer(0.002, 0.25, 1600.0, 890.0)
    stack = ThermalStack(skin, (Layer(0.05, 0.25, 1600.0, 890.0), LOAM), Back("fixed"))
    given = {"thermal": stack, "surface": SurfaceProperties(0.005, 0.0, 0.0, False, False)}
    return SurfaceMaterial(**({"name": "loam", "solar_absorptance": 0.8, "thermal_emissivity": 0.95} | given | changes))


def leaves(below=LOAM, wetness=1.0):
    """A low stand whose second layer is the ground of a closed one."""
    stack = ThermalStack(LEAF, (SPACE, below), Back("fixed"))
    surface = SurfaceProperties(0.1, wetness, 60.0, True, False)
    return SurfaceMaterial("stand", stack, surface, 0.85, 0.98)


def stand(leaf_area, above=None, below=None):
    canopy = Canopy(leaf_area, above or leaves(), below or soil())
    return replace(
        canopy.leaves,
        solar_absorptance=mixed_absorptance(canopy),
        thermal_emissivity=mixed_emissivity(canopy),
        canopy=canopy,
    )


@pytest.fixture
def scene(sun_path, weather, sky):
    return Scene(sun_path, weather, sky, np.array([0.0]), np.array([0.0, 30.0]), np.array([0.0, 180.0]))


def solved(material, scene):
    (columns, solution), *rest = solve_days(material, scene.days, steps=STEPS)
    assert not rest and len(columns) == 2
    return solution


def test_gaps_are_those_of_leaves_at_random():
    """A path through layers of ever less leaf area, each of which stops the share G dL / cos of the light; over the
    hemisphere by quadrature."""
    area, cosine = 1.7, 0.6
    layers = 20000
    assert gap_towards(area, cosine) == pytest.approx((1 - 0.5 * area / layers / cosine) ** layers, rel=1e-4)
    for leaf_area in (0.0, 0.3, 2.0, 8.0):
        hemisphere, _ = quad(lambda c, area=leaf_area: 2 * c * float(gap_towards(area, c)), 0, 1, epsabs=1e-12)
        assert gap_to_sky(leaf_area) == pytest.approx(hemisphere, rel=1e-6, abs=1e-12)
    assert gap_towards(3.0, [0.0, 1e-12]).max() == 0.0 and gap_towards(0.0, [0.0, 1.0]).min() == 1.0
    assert sunlit(2.0) == pytest.approx(2.0 * np.sqrt(0.5))  # Campbell and Norman (1998), equation 15.6


def test_temperature_seen_radiates_as_both_together():
    canopy = Canopy(1.0, leaves(), soil())
    seen = seen_temperature(canopy, np.array([[300.0, 330.0]]))
    gap = np.exp(-0.5)
    assert seen[0, 0] ** 4 == pytest.approx((1 - gap) * 300.0**4 + gap * 330.0**4, rel=1e-12)


def test_few_leaves_are_bare_soil(scene):
    bare = solved(soil(), scene)
    few = solved(stand(2e-6), scene)
    assert np.abs(few.temperature - bare.temperature).max() < 1e-3


def test_many_leaves_are_the_closed_stand(scene, monkeypatch):
    """Over the ground that the closed stand has, cut in two: but for the heat that soil beneath leaves gives to the air
    itself, which a closed stand does not know."""
    half = replace(LOAM, thickness=LOAM.thickness / 2)
    ground = soil(thermal=ThermalStack(replace(LOAM, thickness=0.0), (half, half), Back("fixed")))
    closed = solved(leaves(), scene)
    differences = [
        np.abs(solved(stand(area, below=ground), scene).temperature - closed.temperature).max()
        for area in (5, 10, 20, 40)
    ]
    assert differences[0] > 0.8 and max(differences[1:]) < 0.5
    monkeypatch.setattr(canopy_module, "CALM_SOIL", 0.0)
    without = solved(stand(40, below=ground), scene)
    assert np.abs(without.temperature - closed.temperature).max() < 1e-3


def test_soil_in_gaps_is_hotter_at_noon_and_makes_the_picture_hotter(scene):
    closed = solved(leaves(), scene).temperature[0].max()
    tops = [solved(stand(area), scene).temperature[0].max() for area in (0.5, 1.0, 2.0, 4.0)]
    assert np.all(np.diff(tops) < 0) and tops[0] > closed + 10 and tops[-1] < closed + 3
    noon = solved(stand(1.0), scene).sources[0].reshape(2, -1)[:, STEPS // 2]
    assert 8 < noon[1] - noon[0] < 30


def march(material, forcing, hours=24 * 4):
    """Leaves and soil by finite volumes and an implicit Runge-Kutta method, with gaps of its own: the heat balance of a
    skin is the solver's, per area of leaves and of soil seen."""
    canopy = material.canopy
    area, above, below = canopy.leaf_area, canopy.leaves, canopy.soil
    through = [
        2 * quad(lambda u, k=0.5 * a: np.exp(-k / u) * u, 0, 1, epsabs=1e-12)[0] for a in (area, np.sqrt(0.5) * area)
    ]
    gap, even = through
    cover = 1 - gap
    steps = forcing.shape[1]
    rows = {name: np.broadcast_to(np.atleast_2d(v), (1, steps))[0] for name, v in forcing.given.items()}
    with np.errstate(divide="ignore"):
        beam = np.where(rows["sun_cosine"] > 0, np.exp(-0.5 * np.sqrt(0.5) * area / rows["sun_cosine"]), 0.0)
    direct, spread = rows["shortwave_direct"], rows["shortwave_diffuse"] + rows["shortwave_reflected"]
    to_leaves = above.solar_absorptance * ((1 - beam) * direct + (1 - even) * spread)
    to_soil = below.solar_absorptance * (beam * direct + even * spread)
    ground, air_space = cells_of(below.thermal.layers, 40), cells_of(above.thermal.layers[:1], 16)
    deep = float(rows["air_temperature"].mean())
    leaf, skin = above.thermal.skin, below.thermal.skin
    leaf_capacity, soil_capacity = (part.thickness * part.density * part.heat_capacity for part in (leaf, skin))
    hour_of = np.arange(steps + 1) * (24.0 / steps)

    def at(values, second):
        return np.interp(second / 3600.0 % 24, hour_of, np.append(values, values[0]))

    def rate(second, state):
        now = Forcing(**{name: np.array([[at(row, second)]]) for name, row in rows.items()})
        lost = [
            float(Balance(unlit(now), part).loss(np.array([[kelvin]]))[0, 0])
            for part, kelvin in zip((above, below), state[:2], strict=True)
        ]
        space, earth = np.split(state[2:], [16])
        into_space, out_of_space, space_rate = air_space(space, state[0], state[1])
        into_ground, _, ground_rate = ground(earth, state[1], deep)
        air = at(rows["air_temperature"], second)
        calm = 0.004 * 1005.0 * at(rows["pressure"], second) / (287.05 * air) * (state[1] - air)
        leaf_gain = at(to_leaves, second) / cover - lost[0] - into_space
        soil_gain = at(to_soil, second) - gap * lost[1] + cover * (out_of_space - calm) - into_ground
        return np.concatenate([[leaf_gain / leaf_capacity, soil_gain / soil_capacity], space_rate, ground_rate])

    wanted = 3600.0 * (hours - 24 + 24.0 * np.arange(steps) / steps)
    start = np.full(2 + 16 + 80, deep)
    found = solve_ivp(rate, (0, wanted[-1]), start, "BDF", t_eval=wanted, rtol=3e-6, atol=3e-4, max_step=900.0)
    assert found.success
    return found.y[:2]


def unlit(forcing):
    zero = np.zeros((1, 1))
    return replace(forcing, shortwave_direct=zero, shortwave_diffuse=zero, shortwave_reflected=zero)


def cells_of(layers, count):
    """Flux in at the front, out at the back, and rates of the cells of some layers between two temperatures."""
    sizes = np.repeat([layer.thickness / count for layer in layers], count)
    conducts = np.repeat([layer.conductivity for layer in layers], count)
    holds = np.repeat([layer.density * layer.heat_capacity for layer in layers], count)
    inner = 1 / (0.5 * sizes[1:] / conducts[1:] + 0.5 * sizes[:-1] / conducts[:-1])
    first, last = 2 * conducts[0] / sizes[0], 2 * conducts[-1] / sizes[-1]

    def rates(cells, front, back):
        flows = np.concatenate([[first * (front - cells[0])], inner * -np.diff(cells), [last * (cells[-1] - back)]])
        return flows[0], flows[-1], -np.diff(flows) / (holds * sizes)

    return rates


def smooth(steps):
    """A summer day without corners."""
    hour = 24.0 * np.arange(steps) / steps
    height = np.maximum(np.cos(np.pi * (hour - 12) / 14), 0.0) ** 2
    air = 293.0 + 7.0 * np.cos(2 * np.pi * (hour - 15) / 24)
    rows = {
        "shortwave_direct": 780 * height,
        "shortwave_diffuse": 90 * height,
        "shortwave_reflected": 10 * height,
        "longwave_sky": 330 + 25 * np.cos(2 * np.pi * (hour - 15) / 24),
        "longwave_ground": 0.0 * hour,
        "air_temperature": air,
        "vapour_pressure": 1100 + 0 * hour,
        "pressure": 1e5 + 0 * hour,
        "wind_speed": 3 + np.cos(2 * np.pi * (hour - 14) / 24),
        "cos_slope": 1 + 0 * hour,
        "sun_cosine": 0.9 * np.sqrt(height),
    }
    return Forcing(**{name: row[None] for name, row in rows.items()})


@pytest.mark.parametrize("leaf_area", [0.8])
def test_independent_march_agrees(leaf_area):
    thin = ThermalStack(
        Layer(0.002, 0.25, 1600.0, 890.0),
        (Layer(0.04, 0.25, 1600.0, 890.0), Layer(0.06, 0.9, 1800.0, 1257.0)),
        Back("fixed"),
    )
    material = stand(leaf_area, below=soil(thermal=thin))
    ((_, solution),) = solve_canopy(material, [smooth], steps=STEPS)
    truth = march(material, smooth(STEPS))
    found = solution.sources[0].reshape(2, -1)
    assert np.ptp(truth[1]) > 25 and np.abs(truth[0] - truth[1]).max() > 5
    assert np.abs(found - truth).max() < 0.02


def test_energy_of_both_sources_closes(scene):
    """What the ground takes through the day is what its mean temperatures conduct to the back; what leaves and soil
    give each other is lost by one and gained by the other."""
    material = stand(1.0)
    solution = solved(material, scene)
    balance = CanopyBalance(scene.forcing(STEPS), material)
    leaf_loss, soil_loss = np.split(balance.loss(solution.sources), 2, axis=1)
    leaf, ground = (part.mean(axis=1) for part in np.split(solution.sources, 2, axis=1))
    deep = scene.forcing(STEPS).air_temperature.mean(axis=1)
    conductance = surface_admittance(material.canopy.soil.thermal, 0.0)[0].real
    between = SPACE.conductivity / SPACE.thickness * (leaf - ground)
    cover = 1 - gap_to_sky(1.0)
    assert np.abs(leaf_loss.mean(axis=1) + between).max() < 2e-3
    assert np.abs(soil_loss.mean(axis=1) - cover * between + conductance * (ground - deep)).max() < 2e-3
    assert np.abs(solution.energy_closure).max() < 2e-3


def test_fluxes_of_a_column_are_those_of_both(sun_path, weather, sky):
    result = from_scene(stand(1.0), sun_path, weather, sky, 0.0, 0.0, 0.0)
    fluxes = result.fluxes
    scene = Scene(sun_path, weather, sky, np.array([0.0]), np.array([0.0]), np.array([0.0]))
    forcing = scene.forcing(result.temperature.size)
    light = forcing.shortwave_direct, forcing.shortwave_diffuse + forcing.shortwave_reflected
    most = 0.85 * (light[0] + light[1])[0]
    assert np.all(fluxes["shortwave_absorbed"] <= most + 1e-9)
    noon = int(np.argmax(fluxes["shortwave_absorbed"]))
    beam = np.exp(-0.5 * np.sqrt(0.5) / forcing.sun_cosine[0, noon])
    even = gap_to_sky(np.sqrt(0.5))
    by_hand = 0.85 * ((1 - beam) * light[0] + (1 - even) * light[1]) + 0.8 * (beam * light[0] + even * light[1])
    assert fluxes["shortwave_absorbed"][noon] == pytest.approx(by_hand[0, noon], rel=1e-9)
    gap = gap_to_sky(1.0)
    emitted = SIGMA * ((1 - gap) * 0.98 * result.leaf_temperature**4 + gap * 0.95 * result.soil_temperature**4)
    np.testing.assert_allclose(fluxes["longwave_emitted"], emitted, rtol=1e-6)
    spent = sum(fluxes[name] for name in ("longwave_emitted", "convection", "evaporation", "conduction", "melt"))
    np.testing.assert_allclose(fluxes["shortwave_absorbed"] + fluxes["longwave_absorbed"], spent, rtol=1e-9)
    with pytest.raises(InputError, match="depth and leaf_area_index"):
        from_scene(stand(1.0), sun_path, weather, sky, 0.0, 0.0, 0.0, depth=0.1)


def test_wet_soil_evaporates_through_calm_air_beneath_closed_leaves(sun_path, weather, sky):
    """By hand, with the psychrometer constant of FAO Paper 56, equation 8: 250 s/m of calm air (Norman et al. 1995) and
    100 s/m of the soil in series; dry leaves give nothing."""
    wet = soil(surface=SurfaceProperties(0.005, 1.0, 100.0, False, False))
    result = from_scene(stand(20.0, leaves(wetness=0.0), wet), sun_path, weather, sky, 0.0, 0.0, 0.0)
    forcing = Scene(sun_path, weather, sky, np.array([0.0]), np.array([0.0]), np.array([0.0])).forcing(STEPS)
    air, pressure, vapour = (
        np.broadcast_to(values, (1, STEPS))[0]
        for values in (forcing.air_temperature, forcing.pressure, forcing.vapour_pressure)
    )
    heat = 1005.0 * pressure / (287.05 * air)
    expected = heat / (0.665e-3 * pressure) * (saturation_pressure(result.soil_temperature) - vapour) / 350.0
    noon = STEPS // 2
    assert 40 < expected[noon] < 200
    assert result.fluxes["evaporation"][noon] == pytest.approx(expected[noon], rel=0.02)


def test_conduction_is_that_of_the_whole_stack_where_the_soil_gives_nothing_else():
    """Leaves that cover all over soil that only conducts: eliminated, the soil is the stack's second layer."""
    half = replace(LOAM, thickness=LOAM.thickness / 2)
    ground = soil(thermal=ThermalStack(replace(LOAM, thickness=0.0), (half, half), Back("fixed")))
    matrix = CanopyConduction(Canopy(1e3, leaves(), ground), 48, DAY).matrix
    upper, across, back, lower = matrix[:48, :48], matrix[:48, 48:], matrix[48:, :48], matrix[48:, 48:]
    whole = upper - across @ np.linalg.solve(lower, back)
    np.testing.assert_allclose(whole, Conduction(leaves().thermal, 48, DAY).matrix, rtol=1e-9, atol=1e-9)


def test_flux_by_matrix_and_by_waves_agree():
    rng = np.random.default_rng(3)
    conduction = CanopyConduction(Canopy(1.2, leaves(), soil()), 400, DAY)
    temperature = rng.normal(size=(3, 800))
    np.testing.assert_allclose(conduction.flux(temperature), temperature @ conduction.matrix.T, atol=1e-9)
    flux = conduction.flux(temperature) + 7.0 * temperature
    np.testing.assert_allclose(conduction.relax(flux, 7.0), temperature, atol=1e-9)


def test_days_before_that_repeat_are_the_day_that_repeats(scene):
    material = stand(1.0)
    ((_, thrice),) = solve_days(material, [scene.days[0]] * 3, steps=STEPS)
    ((_, once),) = solve_canopy(material, scene.days, steps=STEPS, scheme="bdf2")
    assert np.abs(thrice.sources - once.sources).max() < 2e-3


def test_a_cool_day_before_is_remembered_by_the_soil(scene):
    def dull(steps):
        forcing = scene.forcing(steps)
        return replace(
            forcing,
            shortwave_direct=0 * forcing.shortwave_direct,
            air_temperature=forcing.air_temperature - 6.0,
        )

    material = stand(1.0)
    once = solved(material, scene)
    ((_, after),) = solve_days(material, [dull, scene.days[0]], steps=STEPS)
    bare = solve_days(soil(), [dull, scene.days[0]], steps=STEPS)[0][1].temperature - solved(soil(), scene).temperature
    colder = np.split(after.sources - once.sources, 2, axis=1)[1]
    assert colder[0, 0] < -2 and abs(colder[0, -1]) < 0.7 * abs(colder[0, 0])
    few = solve_days(stand(2e-6), [dull, scene.days[0]], steps=STEPS)[0][1].temperature
    np.testing.assert_allclose(few - solved(soil(), scene).temperature, bare, atol=2e-3)


@pytest.mark.parametrize("leaf_area", [0.01, 1.0, 20.0, 500.0])
@pytest.mark.parametrize("declination", [-23.4, 0.0, 23.4])
def test_extremes_stay_finite_and_bounded(leaf_area, declination, make_sun_path, sky, weather):
    """Polar night and day at 80 degrees, all slopes, calm air, wet soil."""
    sun = make_sun_path(80.0, declination)
    calm = replace(weather, wind_speed=np.zeros_like(weather.wind_speed))
    scene = Scene(sun, calm, sky, np.array([0.0]), np.array([0.0, 60.0, 90.0, 180.0]), np.array([0.0, 0.0, 180.0, 0.0]))
    wet = soil(surface=SurfaceProperties(0.005, 1.0, 10.0, False, False))
    for columns, solution in solve_days(stand(leaf_area, below=wet), scene.days, steps=STEPS):
        low, high = (part(np.split(solution.sources, 2, axis=1), axis=0) for part in (np.min, np.max))
        assert np.all(np.isfinite(solution.sources)) and low.min() > 200 and high.max() < 360
        assert np.all((solution.temperature >= low - 1e-9) & (solution.temperature <= high + 1e-9))
        assert solution.residual.max() <= TOLERANCE and solution.bound_excess.max() <= 0.1 and columns.size


def test_columns_beyond_their_bounds_go_to_backward_euler(scene, monkeypatch):
    material = stand(1.0)
    first = solved(material, scene)
    monkeypatch.setattr(solver_module, "BOUND_TOLERANCE", -1.0)
    second = solved(material, scene)
    assert set(first.method) == {Method.SPECTRAL} and set(second.method) == {Method.EULER}
    assert 0 < np.abs(second.temperature - first.temperature).max() < 1.5
    ((_, after),) = solve_days(material, [scene.days[0]] * 2, steps=STEPS)
    assert np.abs(after.sources - second.sources).max() < 2e-3


def test_a_column_that_does_not_settle_is_named(scene, monkeypatch):
    """Which one has rounding of its last digits decide."""
    monkeypatch.setattr(canopy_days_module, "TOLERANCE", 0.0)
    monkeypatch.setattr(solver_module, "TOLERANCE", 0.0)
    with pytest.raises(ConvergenceError, match=r"'stand', column \d: damped Newton with 384 steps"):
        solved(stand(1.0), scene)


def test_what_an_open_canopy_does_not_know_is_refused(scene):
    forcing, material = scene.forcing(STEPS), stand(1.0)
    for change, message in (
        ({"pressure": np.zeros((2, 1))}, "no air"),
        ({"sun_cosine": None}, "place the Sun"),
        ({"air_temperature": np.full((2, STEPS), np.nan)}, "found air_temperature = nan"),
    ):
        given = replace(forcing, **change)
        with pytest.raises(InputError, match=message):
            solve_days(material, [lambda _, given=given: given], steps=STEPS)
    with pytest.raises(InputError, match="see `solve_canopy`"):
        solve_columns(material, scene.days[0])
    snow = soil(surface=SurfaceProperties(0.001, 0.0, 0.0, False, True))
    ice = soil(thermal=replace(soil().thermal, light=(PenetratingLight(0.5, 2.0),)))
    for bad in (snow, ice, stand(1.0)):
        with pytest.raises(InputError, match="in a canopy"):
            Canopy(1.0, leaves(), bad)
    for area in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="leaf area"):
            Canopy(area, leaves(), soil())


def test_given_optics_are_those_of_leaves_and_soil():
    material = stand(1.0).with_optics(solar_absorptance=0.7)
    assert material.solar_absorptance == material.canopy.leaves.solar_absorptance == 0.7
    assert material.canopy.soil.solar_absorptance == 0.7 and material.canopy.soil.thermal_emissivity == 0.95


@pytest.mark.parametrize("leaf_area", [0.5, 2.0])
def test_response_to_a_small_shadow_is_the_derivative(leaf_area, sun_path, weather, sky):
    """Of the temperature seen, at the level plane whose response is stored, under a shadow of a hundredth of the light
    from 10 to 14 h."""
    material = stand(leaf_area)
    level = Scene(sun_path, weather, sky, np.array([0.0, 1.0]), np.array([0.0]), np.array([0.0]))
    response = stored_response(response_table([material], level))
    one = replace(level, altitude=np.array([0.0]))
    forcing = one.forcing(288)
    hours = np.arange(288) / 12
    lit = 1 - 0.01 * ((hours > 10) & (hours < 14))
    shaded = replace(forcing, shortwave_direct=forcing.shortwave_direct * lit)
    (_, before), (_, after) = (solve_days(material, [lambda _, f=f: f], steps=288)[0] for f in (forcing, shaded))
    truth = 100 * (after.temperature - before.temperature)
    absorbed = Balance(shaded, material).absorbed - Balance(forcing, material).absorbed
    faces = [np.array([1]), np.array([0.0]), np.array([0.0]), np.array([0.0])]  # code, altitude, azimuth, slope
    found = 100 * response.changes(faces, absorbed, before.temperature, np.array([1e4]))
    assert truth.min() < -8 and np.sqrt(np.mean((found - truth) ** 2)) < 0.06 * np.abs(truth).max()


@pytest.mark.parametrize(
    ("around", "changed", "allowed"),
    [
        (Surroundings(((0.0, 24.0),), 0.6), 10.0, 0.3),
        # Longwave all night, of which leaves have more than of sunlight, and by the slopes of calm air: 0.26 K with
        # the day's mean slopes and the shares of sunlight.
        (Surroundings((), 0.6, 300.0), 2.0, 0.15),
    ],
)
def test_a_wall_is_near_the_whole_solution(sun_path, weather, sky, around, changed, allowed):
    material = stand(2.9)
    level = Scene(sun_path, weather, sky, np.array([0.0, 1.0]), np.array([0.0]), np.array([0.0]))
    response = stored_response(response_table([material], level))
    open_scene = replace(level, altitude=np.array([0.0]))
    beside = replace(open_scene, surroundings=around)
    (_, before), (_, after) = (solve_days(material, each.days, steps=288)[0] for each in (open_scene, beside))
    absorbed = Balance(beside.forcing(288), material).absorbed - Balance(open_scene.forcing(288), material).absorbed
    faces = [np.array([1]), np.array([0.0]), np.array([0.0]), np.array([0.0])]  # code, altitude, azimuth, slope
    error = (
        before.temperature + response.changes(faces, absorbed, before.temperature, np.array([1e4])) - after.temperature
    )
    assert np.ptp(after.temperature - before.temperature) > changed and np.sqrt(np.mean(error**2)) < allowed
