"""The film of water on surfaces: mass, bounds, limits, and the heat that it takes."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from showers import random_rain
from surface_oracle import solve_oracle

from skyshine.mat.surface.balance import Balance, skin_of
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.film import LATENT_HEAT, TOLERANCE, _root, aitken, evaporated, film_of
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import DAY, solve_columns
from skyshine.mat.surface.stress import random_forcing, random_material
from skyshine.mat.surface.vapour import saturation_pressure, surface_vapour
from skyshine.mat.surface.wet_skin import FilmSkin, aged_albedo, film_capacity
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

SLAB = Layer(0.05, 1.15, 2110.0, 920.0)
STACK = ThermalStack(Layer(0.002, 1.15, 2110.0, 920.0), (SLAB, replace(SLAB, thickness=0.4)), Back("fixed"))
ROAD = SurfaceMaterial("road", STACK, SurfaceProperties(0.001, 0.0, 0.0, False, False), 0.88, 0.95)
WET = replace(ROAD, film=FilmSkin(0.93, 0.97, 0.48))
RAIN = 3.0 / 3600.0  # kg m^-2 s^-1


def forcing(steps, rain=None, slopes=(1.0, 0.5, 0.0, -1.0), humid=0.6, hours=None):
    """A summer day with rain from 8 to 10 h."""
    hours = np.arange(steps) * (24.0 / steps) if hours is None else hours
    sun = 800 * np.maximum(np.cos(np.pi * (hours - 12) / 14), 0) * (np.abs(hours - 12) < 7)
    air = 290 + 6 * np.cos(2 * np.pi * (hours - 15) / 24)
    zero = np.zeros((1, len(hours)))
    cosine = np.array(slopes)[:, None]
    return Forcing(
        shortwave_direct=sun[None] * np.maximum(cosine, 0.1),
        shortwave_diffuse=0.1 * sun[None],
        shortwave_reflected=zero,
        longwave_sky=0.75 * 5.67e-8 * air[None] ** 4,
        longwave_ground=zero,
        air_temperature=air[None],
        vapour_pressure=np.minimum(humid * saturation_pressure(290.0), saturation_pressure(air))[None],
        pressure=zero + 1e5,
        wind_speed=zero + 2.0,
        cos_slope=cosine,
        rain=None if rain is None else np.where((hours > 8) & (hours <= 10), rain, 0.0)[None],
    )


def solved(material, rain, **options):
    ((_, solution),) = solve_columns(material, lambda steps: forcing(steps, rain, **options), steps=96)
    return solution


def balance_of_water(solution, given):
    """Rain and dew less evaporation and growth of the film in each step [kg m^-2]: what runs off."""
    share, step = WET.film.share(solution.film), DAY / given.shape[1]
    flux = evaporated(WET, given, solution.temperature)
    gain = given.rain * np.maximum(given.cos_slope, 0) + np.maximum(-flux, 0) - share * np.maximum(flux, 0)
    return gain * step - (solution.film - np.roll(solution.film, 1, axis=1))


@pytest.mark.parametrize("humid", [0.3, 0.95])
def test_water_is_neither_made_nor_lost(humid):
    solution, given = solved(WET, RAIN, humid=humid), forcing(96, RAIN, humid=humid)
    assert solution.film.min() >= 0 and solution.film.max() <= WET.film.capacity * (1 + 1e-12)
    off = balance_of_water(solution, given)
    full = solution.film > WET.film.capacity * (1 - 1e-9)
    assert np.abs(off[~full]).max() < 2e-7 and off.min() > -2e-7
    assert off[0].sum() > 4.0  # of 6 mm the film holds half a millimetre


def test_latent_heat_is_that_of_the_water_lost():
    solution, given = solved(WET, RAIN), forcing(96, RAIN)
    wet = solution.under(given, WET)
    latent = Balance(wet, WET).fluxes(solution.temperature)["evaporation"]
    flux = evaporated(WET, given, solution.temperature)
    lost = np.where(flux > 0, WET.film.share(solution.film), 1.0) * flux
    _, ratio = surface_vapour(solution.temperature)
    np.testing.assert_allclose(latent, lost * LATENT_HEAT * ratio, rtol=1e-9, atol=1e-9)
    assert np.abs(solution.energy_closure).max() < 1e-3 and solution.residual.max() <= TOLERANCE


def test_a_wet_road_is_colder_and_a_wall_stays_dry():
    wet, dry = solved(WET, RAIN, humid=0.3), solved(ROAD, None, humid=0.3)
    fall = dry.temperature - wet.temperature
    assert fall[0].max() > 5 and np.abs(fall[2]).max() < 0.1 and np.abs(fall[3]).max() < 0.1
    np.testing.assert_allclose(wet.film[2:], 0.0, atol=1e-12)


def test_no_rain_and_no_dew_is_the_dry_surface():
    wet, dry = solved(WET, 0.0, humid=0.2), solved(ROAD, None, humid=0.2)
    assert np.array_equal(wet.temperature, dry.temperature) and wet.film.max() < 1e-12


def test_without_rain_in_the_forcing_nothing_is_done():
    a, b = solved(WET, None), solved(ROAD, None)
    assert np.array_equal(a.temperature, b.temperature) and a.film is None


def test_more_rain_never_dries():
    films = [solved(WET, rain, humid=0.5).film[0] for rain in (0.0, 1e-5, 1e-4, 1e-3)]
    for less, more in pairwise(films):
        assert np.all(more >= less - 1e-3)


def test_a_film_that_dries_by_a_constant_flux():
    """dw/dt = -E (w / c)^(2/3): w^(1/3) falls linearly, (c^(1/3) - E t / (3 c^(2/3)))^3."""
    skin, steps, step = FilmSkin(0.9, 0.97, 0.5), 20000, 1.0
    film, share = film_of(skin, np.zeros((1, steps)), np.full((1, steps), 1e-4), step, np.array([0.5]))
    time = np.arange(1, steps + 1) * step
    exact = np.maximum(0.5 ** (1 / 3) - 1e-4 * time / (3 * 0.5 ** (2 / 3)), 0) ** 3
    np.testing.assert_allclose(film[0], exact, atol=2e-4)
    np.testing.assert_allclose(share[0], (film[0] / 0.5) ** (2 / 3), rtol=1e-9, atol=1e-100)


def test_a_film_returns_after_the_day():
    """Dew by night and not enough Sun by day: the film that returns is found, whatever the memory."""
    steps = 48
    gain = np.where(np.arange(steps) < 24, 2e-6, 0.0)[None].repeat(3, 0)
    potential = np.where(np.arange(steps) >= 24, 1.0, 0.0)[None] * np.array([[1e-9], [3e-6], [1e-4]])
    film, _ = film_of(WET.film, gain, potential, 1800.0, None)
    again, _ = film_of(WET.film, gain, potential, 1800.0, film[:, -1])
    np.testing.assert_allclose(again, film, atol=3e-7)
    assert film[0, -1] == pytest.approx(WET.film.capacity, rel=1e-3) and film[2, -1] < 1e-3


def test_rain_of_the_day_before_is_still_there():
    def day(rain):
        return lambda steps: replace(
            forcing(steps, 0.0, slopes=(1.0,), humid=0.5),
            rain=np.where(np.arange(steps) >= steps * 23 // 24, rain, 0.0)[None],
        )

    ((_, after_rain),) = solve_days(WET, [day(0.0), day(RAIN), day(0.0)], steps=96)
    ((_, after_none),) = solve_days(WET, [day(0.0), day(0.0), day(0.0)], steps=96)
    assert after_rain.film[0, 0] > 0.4 and after_rain.film[0, 0] > after_none.film[0, 0] + 0.1


def test_the_oracle_agrees_under_the_same_film():
    """The same shares of film, as numbers, in the symbolic balance."""
    solution = solved(WET, RAIN, slopes=(1.0,))
    share = WET.film.share(solution.film)[0]
    known = np.arange(96) / 96

    def at(seconds):
        day = seconds / DAY
        return replace(forcing(0, RAIN, (1.0,), hours=24 * day), film=np.interp(day, known, share, period=1.0)[None])

    oracle = solve_oracle(WET, at)
    ((_, fine),) = solve_columns(
        WET, lambda steps: replace(at(np.arange(steps) * DAY / steps), rain=None), steps=1152, fine_steps=None
    )
    found = np.interp(oracle.time, np.arange(1152) * DAY / 1152, fine.temperature[0], period=DAY)
    assert np.abs(found - oracle.surface).max() < 0.06 and np.sqrt(np.mean((found - oracle.surface) ** 2)) < 0.015


def test_half_a_film_is_half_of_each_skin():
    skin = skin_of(WET, replace(forcing(4, RAIN), film=np.full((1, 4), 0.5)))
    np.testing.assert_allclose(skin.solar_absorptance, 0.5 * (0.88 + 0.93))
    np.testing.assert_allclose(skin.thermal_emissivity, 0.5 * (0.95 + 0.97))


def test_the_slope_of_a_film_over_a_moist_surface_is_that_of_its_loss():
    moist = replace(WET, surface=SurfaceProperties(0.001, 0.4, 100.0, False, False))
    balance = Balance(replace(forcing(8, RAIN), film=np.full((1, 8), 0.3)), moist)
    for offset in (-3.0, 2.0, 9.0):  # dew and evaporation, stable and unstable air
        surface = np.broadcast_to(balance.air_temperature + offset, balance.shape).copy()
        difference = (balance.loss(surface + 1e-4) - balance.loss(surface - 1e-4)) / 2e-4
        np.testing.assert_allclose(balance.loss_and_slope(surface)[1], difference, rtol=1e-5)


def test_capacities():
    """Grimmond and Oke (1991): pavement 0.48, buildings 0.25, grass 1.9, trees 1.3 mm; nothing on snow and water."""
    base = ROAD.surface
    assert film_capacity(base, None) == 0.48
    assert film_capacity(replace(base, exposure="roof"), None) == 0.25
    assert film_capacity(replace(base, canopy=True), None) == 1.9
    assert film_capacity(replace(base, roughness_length=0.8, canopy=True), None) == 1.3
    assert film_capacity(replace(base, snow=True), None) == film_capacity(replace(base, wetness=1.0), None) == 0.0


def test_snow_grows_old():
    """Verseghy (1991): 0.01 an hour: after a day 0.785 of the excess over 0.70 (dry) or 0.50 (melting) is left."""
    cold, warm = np.full((1, 4), 263.0), np.full((1, 4), 275.0)
    assert aged_albedo(0.85, np.array([[1.0]]), cold)[0, 0] == pytest.approx(0.70 + 0.15 * np.exp(-0.24))
    assert aged_albedo(0.85, np.array([[1.0]]), warm)[0, 0] == pytest.approx(0.50 + 0.35 * np.exp(-0.24))
    assert aged_albedo(0.85, np.array([[0.0]]), warm)[0, 0] == pytest.approx(0.85)
    assert aged_albedo(0.45, np.array([[9.0]]), warm)[0, 0] == pytest.approx(0.45)  # darker than old snow already


def test_aitken_finds_the_end_of_a_series_that_turns():
    """A way that turns to -2.3 of itself, whole, is 0 where 1 / 3.3 of it is gone; a way that stays is gone whole."""
    way = np.array([[1.0, -0.5]])
    assert aitken(np.array([[0.5]]), way, way * (1 - 0.5 * 3.3)) == pytest.approx(1 / 3.3)
    assert aitken(np.array([[0.5]]), way, 0.9 * way) == pytest.approx(1.0)
    assert aitken(np.array([[0.5]]), way, -9.0 * way) == pytest.approx(0.05)
    assert np.isfinite(aitken(np.array([[0.5]]), 0 * way, 0 * way)).all()


def test_film_settles_on_a_column_that_turns_from_wet_to_dry_round_by_round():
    """Foil that a film makes bright: wet it is so cold that dew falls, dry so warm that nothing stays."""
    generator = np.random.default_rng([7, 183])
    ((_, solution),) = [
        (rows, part)
        for rows, part in solve_columns(*random_rain(generator, random_material(generator), random_forcing(generator)))
        if len(rows)
    ]
    assert solution.residual[0] <= TOLERANCE


@pytest.mark.parametrize("loss", [0.0, 1e-12, 1e-3, 1.0, 30.0, 1e6])
@pytest.mark.parametrize("share", [0.0, 1e-12, 1e-6, 0.01, 0.5, 1.0])
def test_the_share_of_a_step_closes_its_water_where_numbers_are_extreme(loss, share):
    water = np.array([share**1.5 + loss * share])
    assert _root(np.array([loss]), water) ** 2 == pytest.approx(share, rel=1e-9, abs=1e-18)
