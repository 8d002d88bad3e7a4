"""Surfaces between ground and walls: what they receive, and the temperatures of what they see."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import Stefan_Boltzmann
from scipy.optimize import brentq

from skyshine.mat.surface import enclosed
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.enclosed import AIR, GivenEmitter, solved_enclosure
from skyshine.mat.surface.enclosure import Emitter, Enclosure
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.horizon import Horizon
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.response import response_table
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.sun_path import SUN_STEPS
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.table import temperature_table
from skyshine.mat.surface.weather import from_hours
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import CheckFailed, InputError

SLOPES, AZIMUTHS = np.array([0.0, 30.0, 90.0, 90.0, 150.0, 180.0]), np.array([0.0, 180.0, 90.0, 270.0, 0.0, 0.0])
HEIGHTS = np.array([0.0, 1000.0])
CANYON = Horizon((0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0), (0.0, 40.0, 60.0, 40.0) * 2)
LAYER = Layer(0.1, 1.0, 2000.0, 1000.0)


def material(absorptance=0.7, emissivity=0.9, thickness=0.1, back="fixed"):
    layer = replace(LAYER, thickness=thickness)
    stack = ThermalStack(layer, (layer, layer), Back(back))
    return SurfaceMaterial("plate", stack, SurfaceProperties(1e-3, 0.0, 0.0, False, False), absorptance, emissivity)


@pytest.fixture
def plain(sun_path, weather, sky):
    return Scene(sun_path, weather, sky, HEIGHTS, SLOPES, AZIMUTHS)


def within(scene, enclosure):
    return replace(scene, sky=replace(scene.sky, enclosure=enclosure))


def black(temperature, planes, albedo=0.0, emissivity=1.0):
    """An emitter of one temperature all day."""
    return Emitter(emissivity, albedo, np.full((1, planes, SUN_STEPS), temperature))


def dark(sky):
    """A sky without sunlight, as bright in longwave as a black body at air temperature."""
    zero = 0 * sky.direct
    return replace(sky, direct=zero, diffuse=zero, emissivity=np.ones_like(sky.emissivity))


def still_air(kelvin=290.0):
    return from_hours(0.0, np.arange(24.0), np.full(24, kelvin), 50.0, 2.0, 0.0)


def test_black_ground_at_air_temperature_on_an_open_plain_is_what_surfaces_see_without_an_enclosure(plain):
    """But for the mean of the fourth power over a step, which is not that of the mean: 1e-3 W m^-2."""
    open_plain = Enclosure(Emitter(1.0, plain.sky.ground_albedo), Emitter(0.5, 0.5))
    found = within(plain, open_plain).forcing(96)
    for name, values in plain.forcing(96).given.items():
        np.testing.assert_allclose(
            getattr(found, name),
            values,
            rtol=1e-12,
            atol=2e-3,
            err_msg=name,
        )


@pytest.mark.parametrize("horizon", [Horizon(), CANYON, Horizon((0.0,), (90.0,))])
@pytest.mark.parametrize("sky_view", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("emissivity", [1.0, 0.05])
def test_in_an_isothermal_enclosure_a_surface_has_its_temperature(sun_path, sky, horizon, sky_view, emissivity):
    """Second law: walls, ground, sky and air at 290 K, no Sun; foil or black, the surface has 290 K."""
    emitters = black(290.0, 1, 0.3, emissivity), black(290.0, 8, 0.3, emissivity)
    around = replace(dark(sky), enclosure=Enclosure(*emitters, horizon, sky_view))
    scene = Scene(sun_path, still_air(), around, np.zeros(1), SLOPES, AZIMUTHS)
    forcing = scene.forcing(96)
    assert forcing.longwave_sky + forcing.longwave_ground == pytest.approx(Stefan_Boltzmann * 290.0**4, rel=1e-12)
    for _, solution in solve_columns(material(emissivity=0.6), scene.forcing):
        assert solution.temperature == pytest.approx(290.0, abs=1e-3)


def test_a_level_facet_that_sees_half_a_wall_gets_half_of_its_longwave(plain):
    for horizon, sky_view in ((Horizon(), 0.5), (Horizon((0.0,), (45.0,)), 1.0)):
        walled = within(plain, Enclosure(black(300.0, 1), black(320.0, 8), horizon, sky_view)).forcing(96)
        assert walled.longwave_ground[0] == pytest.approx(0.5 * Stefan_Boltzmann * 320.0**4, rel=1e-9)
        np.testing.assert_allclose(walled.longwave_sky[0], 0.5 * plain.forcing(96).longwave_sky[0], rtol=1e-9)


def test_a_hanging_face_sees_the_ground_alone(plain):
    walled = within(plain, Enclosure(black(310.0, 1), black(250.0, 8), CANYON)).forcing(96)
    last = len(SLOPES) - 1
    assert walled.longwave_ground[last] == pytest.approx(Stefan_Boltzmann * 310.0**4, rel=1e-12)
    assert np.all(walled.longwave_sky[last] == 0) and np.all(walled.shortwave_diffuse[last] == 0)


def test_leaves_open_to_the_light_that_the_horizon_leaves(plain):
    """Behind a horizon of 90 degrees only the light of the sky is left of that on open level ground."""
    open_plain = within(plain, Enclosure(black(300.0, 1), Emitter(1.0, 0.0))).forcing(96)
    pit = within(plain, Enclosure(black(300.0, 1), black(300.0, 8), Horizon((0.0,), (90.0,)))).forcing(96)
    level = open_plain.shortwave_direct[0] + open_plain.shortwave_diffuse[0]
    np.testing.assert_allclose(open_plain.open_light[0], level, rtol=0.02, atol=2.0)
    noon = int(np.argmax(level))
    assert pit.open_light[0, noon] == pytest.approx(level[noon] - open_plain.shortwave_direct[0, noon], rel=0.02)
    assert 0.02 < pit.open_light[0, noon] / level[noon] < 0.5


def test_grey_ground_reflects_the_sky_above_it(plain):
    """A wall over foil at 300 K on an open plain: half of 0.05 sigma T^4 + 0.95 of the sky."""
    ground = within(plain, Enclosure(black(300.0, 1, emissivity=0.05), Emitter(1.0, 0.0))).forcing(96)
    sky = plain.forcing(96).longwave_sky[0]
    np.testing.assert_allclose(
        ground.longwave_ground[2], 0.5 * (0.05 * Stefan_Boltzmann * 300.0**4 + 0.95 * sky), rtol=1e-12
    )


def test_no_light_comes_into_a_pit(plain):
    forcing = within(plain, Enclosure(Emitter(1.0, 1.0), Emitter(1.0, 0.99), Horizon((0.0,), (90.0,)))).forcing(96)
    for name in ("shortwave_direct", "shortwave_diffuse", "shortwave_reflected", "longwave_sky"):
        assert np.abs(getattr(forcing, name)).max() < 1e-9


def test_the_horizon_ends_direct_light_and_nothing_else_does(plain):
    walled = within(plain, Enclosure(Emitter(1.0, 0.2), Emitter(1.0, 0.0), CANYON)).forcing(SUN_STEPS)
    lit = plain.forcing(SUN_STEPS)
    hidden = CANYON.hides(plain.sun.solar_elevation, plain.sun.solar_azimuth)
    assert 0 < np.count_nonzero(hidden & (plain.sun.solar_elevation > 0)) < SUN_STEPS
    assert np.all(walled.shortwave_direct[:, hidden] == 0)
    assert np.array_equal(walled.shortwave_direct[:, ~hidden], lit.shortwave_direct[:, ~hidden])
    assert np.all(walled.shortwave_diffuse <= lit.shortwave_diffuse + 1e-9)


def test_of_sunlight_between_black_walls_only_that_of_sky_and_ground_is_left(plain):
    """Level ground of albedo 0.3 under a rim of 45 degree: a wall gets half of 0.3 times what the ground gets."""
    rim = Enclosure(Emitter(1.0, 0.3), Emitter(1.0, 0.0), Horizon((0.0,), (45.0,)))
    forcing = within(plain, rim).forcing(96)
    level = forcing.shortwave_direct[0] + forcing.shortwave_diffuse[0]
    np.testing.assert_allclose(forcing.shortwave_reflected[2], 0.5 * 0.3 * level, rtol=1e-12)
    assert np.all(forcing.shortwave_reflected[0] == 0)
    even, low = 0.5 * plain.forcing(96).shortwave_diffuse[0], forcing.shortwave_direct[0] == 0
    np.testing.assert_allclose(forcing.shortwave_diffuse[0, low], 0.7 * even[low], rtol=1e-9)
    high = plain.sun.solar_elevation[:: SUN_STEPS // 96] > 50
    np.testing.assert_allclose(forcing.shortwave_diffuse[0, high], (0.7 + 2 * 0.3) * even[high], rtol=1e-6)


def test_in_the_morning_the_walls_that_the_sun_meets_light_faces_to_the_west(plain):
    """Sun in the east: walls in the west are lit, and a face to the west sees them."""
    walls = Enclosure(Emitter(1.0, 0.0), Emitter(1.0, 0.5), Horizon((0.0,), (5.0,)))
    forcing = within(plain, walls).forcing(96)
    morning = 28
    east, west = forcing.shortwave_reflected[2, morning], forcing.shortwave_reflected[3, morning]
    assert west > 1.5 * east > 0


def test_a_shadow_and_a_wall_of_its_own_add_to_the_enclosure(plain):
    """`Surroundings` take their share of the sky that the enclosure leaves."""
    enclosure = Enclosure(black(290.0, 1), black(300.0, 8), Horizon((0.0,), (45.0,)))
    walled = within(plain, enclosure)
    hidden = replace(walled, surroundings=Surroundings(((0, 24),), 0.5, 320.0, 1.0)).forcing(96)
    assert np.all(hidden.shortwave_direct == 0)
    np.testing.assert_allclose(hidden.longwave_sky, 0.5 * walled.forcing(96).longwave_sky, rtol=1e-12)
    # In the shade no plane has more than its view of an evenly bright sky, also one that faces the Sun.
    even = np.outer(enclosure.views(SLOPES, AZIMUTHS).sky, plain.forcing(96).shortwave_diffuse[0])
    assert np.all(hidden.shortwave_diffuse[: len(SLOPES)] <= 0.5 * even * (1 + 1e-6) + 1e-9)
    level = 0.5 * Stefan_Boltzmann * 300.0**4 + 0.25 * Stefan_Boltzmann * 320.0**4
    np.testing.assert_allclose(hidden.longwave_ground[0], level, rtol=1e-9)


def test_walls_between_two_altitudes_have_temperatures_between_theirs(plain):
    by_height = np.stack([np.full((8, SUN_STEPS), 280.0), np.full((8, SUN_STEPS), 300.0)])
    enclosure = Enclosure(
        Emitter(1.0, 0.2), Emitter(1.0, 0.2, by_height), Horizon((0.0,), (45.0,)), altitude=np.array([0.0, 1000.0])
    )
    air = np.full((4, SUN_STEPS), 270.0)
    kelvin = enclosure.temperature(np.array([-50.0, 0.0, 250.0, 2000.0]), air)
    assert kelvin[:, 1, 0].tolist() == [280.0, 280.0, 285.0, 300.0] and np.all(kelvin[:, 0] == 270.0)


def test_solved_walls_and_ground_are_those_of_a_table_between_them(plain, weather, sun_path, sky):
    """The table, which solves the same faces in the finished enclosure, gives the temperatures it was made with."""
    brick, street = material(0.6, 0.93), material(0.9, 0.95, 0.3)
    enclosure = solved_enclosure(
        sun_path,
        weather,
        sky,
        HEIGHTS,
        ground=GivenEmitter(0.95, 0.1, street),
        walls=GivenEmitter(0.93, 0.4, brick),
        horizon=CANYON,
    )
    times = np.arange(24.0)
    around = replace(sky, enclosure=enclosure)
    table = temperature_table(
        [street, brick], sun_path, weather, around, list(HEIGHTS), [0.0, 90.0, 225.0], [0.0, 90.0], list(times)
    ).temperature
    at_hours = slice(0, SUN_STEPS, SUN_STEPS // 24)
    for height in (0, 1):
        assert table[0, height, 0, 0] == pytest.approx(enclosure.ground.temperature[height, 0, at_hours], abs=0.05)
        for column, aspect in enumerate((0, 2, 5)):
            wall = enclosure.walls.temperature[height, aspect, at_hours]
            assert table[1, height, column, 1] == pytest.approx(wall, abs=0.05)


def test_walls_beside_hot_ground_have_the_temperature_of_a_scalar_balance(sun_path, sky):
    """Steady and dark: eight equal walls that see ground at 350 K and each other; the root of one wall's balance."""
    air, wall = still_air(280.0), material(0.5, 0.8, thickness=1e-3, back="adiabatic")
    pit = Horizon((0.0,), (90.0,))
    enclosure = solved_enclosure(
        sun_path,
        air,
        dark(sky),
        [0.0],
        ground=GivenEmitter(0.9, 0.2, 350.0),
        walls=GivenEmitter(0.8, 0.5, wall),
        horizon=pit,
    )
    scene = Scene(sun_path, air, replace(dark(sky), enclosure=enclosure), np.zeros(1), np.array([90.0]), np.zeros(1))
    forcing = scene.forcing(96).times(np.array([0]))
    black_ground, to_ground = Stefan_Boltzmann * 350.0**4, 0.5

    def loss(kelvin):
        own = Stefan_Boltzmann * kelvin**4
        # Radiosities: wall w = e s + (1 - e) (g + w) / 2, ground g = 0.9 b + 0.1 w.
        left = np.array([[1 - 0.2 * (1 - to_ground), -0.2 * to_ground], [-0.1, 1.0]])
        wall_light, ground_light = np.linalg.solve(left, [0.8 * own, 0.9 * black_ground])
        incident = to_ground * ground_light + (1 - to_ground) * wall_light
        given = replace(forcing, longwave_ground=np.array([[incident]]), longwave_sky=np.zeros((1, 1)))
        return Balance(given, wall).loss(np.array([[kelvin]]))[0, 0]

    assert enclosure.walls.temperature == pytest.approx(brentq(loss, 250.0, 400.0), abs=0.03)


def test_given_temperatures_stay_and_the_air_is_taken_where_there_are_none(sun_path, weather, sky):
    hours = tuple(280.0 + hour for hour in range(24))
    enclosure = solved_enclosure(
        sun_path, weather, sky, [0.0, 500.0], ground=GivenEmitter(0.9, 0.2, hours), horizon=Horizon((0.0,), (30.0,))
    )
    assert enclosure.walls.temperature is None
    assert enclosure.ground.temperature[:, 0, :: SUN_STEPS // 24] == pytest.approx(np.tile(hours, (2, 1)))


def test_polar_night_between_foil_walls_settles(make_sun_path, sky):
    night, foil = make_sun_path(85.0, -23.0), material(0.1, 0.05, thickness=1e-4, back="adiabatic")
    assert night.solar_elevation.max() < 0
    air = from_hours(0.0, np.arange(24.0), np.full(24, 235.0), 80.0, 0.0, 0.0)
    enclosure = solved_enclosure(
        night,
        air,
        sky,
        [0.0],
        ground=GivenEmitter(0.98, 0.8, material(0.2, 0.98)),
        walls=GivenEmitter(0.05, 0.9, foil),
        horizon=CANYON,
    )
    for emitter in (enclosure.ground, enclosure.walls):
        assert 190 < emitter.temperature.min() <= emitter.temperature.max() < 236


def test_walls_that_do_not_settle_are_refused(sun_path, weather, sky, monkeypatch):
    calls = iter(range(10_000))
    monkeypatch.setattr(enclosed, "_temperature", lambda *_: np.full((1, 8, SUN_STEPS), 280.0 + next(calls) % 2))
    with pytest.raises(CheckFailed, match="still change by 1 K after 60 passes; give the walls a temperature_c"):
        solved_enclosure(
            sun_path, weather, sky, [0.0], ground=AIR, walls=GivenEmitter(0.9, 0.2, material()), horizon=CANYON
        )


def test_the_response_is_taken_about_temperatures_in_the_enclosure(plain):
    """Its slope is the day's mean of the heat loss's, by differences of a kelvin about the solution among the walls."""
    plate, warmest = material(), []
    hot = within(plain, Enclosure(black(330.0, 1), black(330.0, 8), Horizon((0.0,), (80.0,))))
    for scene in (plain, hot):
        level = Scene(scene.sun, scene.weather, scene.sky, [0.0], [0.0], [0.0])
        [(_, solution)] = solve_columns(plate, level.forcing)
        temperature = solution.temperature
        balance = Balance(level.forcing(temperature.shape[1]), plate)
        slope = (balance.loss(temperature + 0.5) - balance.loss(temperature - 0.5)).mean()
        stored = response_table([plate], scene).loss_slope[0, 0, 0]
        assert stored == pytest.approx(np.full(24, slope), rel=0.02)
        warmest.append((temperature.mean(), slope))
    (open_air, loose), (warm, stiff) = warmest
    assert warm > open_air + 2
    assert stiff > 1.03 * loose


def test_of_the_open_air_the_horizon_takes_the_sun_and_its_surroundings_alone(plain):
    rim = Enclosure(Emitter(1.0, 0.2), Emitter(1.0, 0.2), Horizon((0.0,), (30.0,)))
    direct, diffuse, longwave, air, around = within(plain, rim).open_air(SUN_STEPS)
    whole = plain.open_air(SUN_STEPS)
    assert np.all(direct[:, plain.sun.solar_elevation <= 30] == 0)
    assert np.array_equal(direct[:, plain.sun.solar_elevation > 30], whole[0][:, plain.sun.solar_elevation > 30])
    for part, of_all in zip((longwave, air), whole[2:4], strict=True):
        assert np.array_equal(part, of_all)
    hidden = plain.sun.solar_elevation <= 30
    assert np.all(around[:, hidden] == 0) and np.array_equal(around[:, ~hidden], whole[4][:, ~hidden])
    np.testing.assert_allclose(diffuse[:, ~hidden], whole[1][:, ~hidden], rtol=1e-12)
    np.testing.assert_allclose(diffuse[:, hidden], ((1 - whole[4]) * whole[1])[:, hidden], rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Emitter(0.0, 0.2), "found emissivity 0 of ground or walls; allowed: above 0"),
        (lambda: Emitter(1.2, 0.2), "found emissivity 1.2"),
        (lambda: Emitter(0.9, -0.1), "found albedo -0.1"),
        (lambda: Enclosure(Emitter(1.0, 0.2), Emitter(1.0, 1.0)), "found albedo 1 of walls; allowed: 0 to 0.99"),
        (lambda: Enclosure(Emitter(1.0, 0.2), Emitter(1.0, 0.2), sky_view=1.5), "found sky_view 1.5"),
    ],
)
def test_impossible_ground_and_walls_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
