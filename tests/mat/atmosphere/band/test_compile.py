"""Bands and their reduction: weights, tolerance, repeatability, gases left out."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band import compile as compile_module
from skyshine.mat.atmosphere.band.compile import (
    EVERYWHERE,
    AirTest,
    SharedPoints,
    choose_points,
    compile_band,
    fit_band,
    over_air,
    with_errors_of_own_air,
)
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.band.targets import KINDS
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.scene_lines import REGIONS
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.schemas.errors import InputError

GRID = PathGrid(
    range_km=[0.001, 0.3, 1.0, 5.0, 20.0, 100.0],
    altitude_km=[0.002, 1.0, 10.0],
    elevation_deg=[-90.0, -10.0, -1.0, 0.0, 5.0, 90.0],
    source_elevation_deg=[-10.0, 5.0, 60.0],
    source_azimuth_deg=[0.0, 180.0],
)


@pytest.fixture(scope="module")
def state():
    return AtmosphericState.from_profile("midlatitude_summer", gas_amounts=GasAmounts(ppm={"CO2": 420}))


@pytest.fixture(scope="module")
def band():
    response = SpectralResponse.rectangular(8.5, 9.2)
    return points_of_band(AbsorptionTable.open(), response)


PARTS = ("unlit", "ground", "light")
SETTINGS = {"tolerance": 1e-3, "max_points": 64, "seed": 0}


@pytest.fixture(scope="module")
def fitted(state, band):
    return fit_band(over_air(state), band, GRID, solar_irradiance(band.wavenumber), **SETTINGS)


@pytest.fixture(scope="module")
def compiled(state, band):
    return compile_band(state, band, GRID, solar_irradiance(band.wavenumber))


def test_weights_of_a_triangular_response(synthetic_points):
    response = SpectralResponse(np.array([10.0, 10.5, 11.0]), np.array([0.0, 1.0, 0.0]))
    edges = np.arange(900.0, 1010.1, 5.0)
    band = band_points(synthetic_points(edges, {"CO2": np.zeros(22)}), response)
    assert band.weight.sum() == pytest.approx(0.5, rel=1e-4)  # um
    assert np.all(band.weight > 0)
    assert band.weight.size == 19  # 909.1 to 1000 cm^-1
    # The same integral in wavenumbers: of the response over d(nu).
    nu = np.linspace(900, 1010, 20001)
    assert band.radiance_weight.sum() == pytest.approx(np.trapezoid(response.at_wavenumber(nu), nu), rel=1e-3)


def test_a_response_elsewhere_is_refused(synthetic_points):
    with pytest.raises(InputError, match="response is 0"):
        band_points(synthetic_points(np.array([900.0, 905.0]), {"CO2": [0.0]}), SpectralResponse.rectangular(3.0, 4.0))


def test_a_compiled_band_holds_its_tolerance(band, compiled):
    assert compiled.index.size <= 64 < compiled.total_points == band.weight.size
    assert compiled.band.weight.sum() == pytest.approx(band.weight.sum(), rel=1e-9)
    assert np.all(compiled.band.weight > 0)
    assert set(compiled.errors) == set(KINDS)
    for kind, error in compiled.errors.items():
        assert error["rms"] < 3e-3, kind
        assert error["rms"] <= error["max"] < 0.02, kind
    assert np.all(np.diff(compiled.ladder[[0, 3, 7, -1]]) < 0)


def test_the_same_band_compiles_to_the_same_points(state, band, compiled):
    again = compile_band(state, band, GRID, solar_irradiance(band.wavenumber))
    assert np.array_equal(again.index, compiled.index)
    assert np.array_equal(again.band.weight, compiled.band.weight)
    assert again.errors == compiled.errors


def test_a_looser_tolerance_takes_fewer_points(state, band, compiled):
    loose = compile_band(state, band, GRID, solar_irradiance(band.wavenumber), tolerance=0.02)
    assert loose.index.size < compiled.index.size


def test_night_needs_no_source(state, band):
    dark = compile_band(state, band, GRID, np.zeros(band.weight.size), max_points=12)
    assert "direct_irradiance" not in dark.errors
    assert dark.index.size <= 12


def test_two_sources_share_a_band(state, band, compiled):
    sun = solar_irradiance(band.wavenumber)
    moon = 1e-6 * sun * (band.wavenumber / band.wavenumber.mean()) ** 4
    both = compile_band(state, band, GRID, np.stack([sun, moon]))
    for kind, error in both.errors.items():
        assert error["rms"] < 3e-3, kind


@pytest.mark.parametrize(("warmer", "brighter"), [(-40.0, 0.97), (0.0, 1.0), (40.0, 1.04)])
def test_errors_in_a_state_of_the_same_air_are_those_computed_for_it(state, band, fitted, warmer, brighter):
    """With what all points and the few give over this very ground, computed anew."""
    state = replace(state, surface_temperature=state.surface_temperature + warmer)
    sun = brighter * solar_irradiance(band.wavenumber)
    own = fit_band(state, band, GRID, sun, **SETTINGS)
    light, brightness = sun[None], np.array([sun.mean()])
    exact = own.exact.mean(state.surface_temperature, light, brightness)
    found = fitted.exact.mean(state.surface_temperature, light, brightness)
    for kind, values in exact.items():
        assert found[kind] == pytest.approx(values, rel=1e-6), kind
    # The fitted points are as good there as points that are fitted there.
    there, anew = (fit.measured(state.surface_temperature, sun).errors for fit in (fitted, own))
    for kind in KINDS:
        assert there[kind]["rms"] < max(2 * anew[kind]["rms"], 1e-3), kind


def test_the_ground_shows_in_hazy_air_alone(state, band, fitted):
    sun = solar_irradiance(band.wavenumber)[None]
    cold, warm = (fitted.exact.mean(kelvin, sun, sun.mean(axis=1)) for kelvin in (250.0, 320.0))
    assert np.array_equal(cold["transmittance"], warm["transmittance"])
    assert np.all(cold["path_thermal"] <= warm["path_thermal"]) and np.any(cold["path_thermal"] < warm["path_thermal"])
    clear = fit_band(replace(over_air(state), aerosols=()), band, GRID, sun, **SETTINGS)
    assert not np.any(clear.exact.ground["path_thermal"])


def test_points_chosen_at_the_ends_of_a_span_of_airs_hold_between_them(band, monkeypatch):
    """Better than points chosen at one end, on paths that neither was fitted to."""
    sun = solar_irradiance(band.wavenumber)
    cold, mild, warm = (
        over_air(AtmosphericState.from_profile("midlatitude_summer", gas_amounts=GasAmounts(scale={"H2O": scale})))
        for scale in (0.5, 0.9, 1.5)
    )
    monkeypatch.setattr(compile_module, "_CHOICES", 1)
    shared, of_one_end = (choose_points(airs, [mild], band, GRID, sun, **SETTINGS) for airs in ([cold, warm], [warm]))
    errors, at_end = (points.measured(sun).errors for points in (shared, of_one_end))
    for kind in KINDS:
        assert errors[kind]["rms"] < 2e-3, kind
    assert errors["transmittance"]["rms"] < 0.75 * at_end["transmittance"]["rms"]


def test_shared_points_that_miss_the_tolerance_between_their_airs_are_chosen_by_a_finer_one(band, monkeypatch):
    sun = solar_irradiance(band.wavenumber)
    cold, mild, warm = (
        over_air(AtmosphericState.from_profile("midlatitude_summer", gas_amounts=GasAmounts(scale={"H2O": scale})))
        for scale in (0.5, 0.9, 1.5)
    )
    settings = SETTINGS | {"tolerance": 4e-3}
    monkeypatch.setattr(compile_module, "_CHOICES", 1)
    once = choose_points([cold, warm], [mild], band, GRID, sun, **settings)
    monkeypatch.setattr(compile_module, "_CHOICES", 3)
    asked = settings | {"tolerance": 0.8 * once.worst}
    again = choose_points([cold, warm], [mild], band, GRID, sun, **asked)
    assert again.worst <= asked["tolerance"] and again.chosen.index.size >= once.chosen.index.size


def test_errors_of_shared_points_are_the_largest_of_their_tests_and_follow_the_light_of_the_day(band, monkeypatch):
    """As those of a fit in the one air of a test, under a source twice as bright."""
    sun, mild = solar_irradiance(band.wavenumber), over_air(AtmosphericState.from_profile("midlatitude_summer"))
    fit = fit_band(mild, band, GRID, sun, **SETTINGS)
    dim = fit_band(over_air(AtmosphericState.from_profile("subarctic_winter")), band, GRID, sun, **SETTINGS)
    test, other = (
        AirTest.of(each, kelvin, sun[None]) for each, kelvin in ((fit, mild.surface_temperature), (dim, 250.0))
    )
    alone, both = (SharedPoints(fit.chosen, tests, np.array([sun.mean()])) for tests in ((test,), (test, other)))
    expected, found = fit.measured(mild.surface_temperature, 2 * sun), alone.measured(2 * sun)
    for kind, errors in expected.errors.items():
        assert found.errors[kind] == pytest.approx(errors, rel=1e-9, abs=1e-15)
        assert found.absolute[kind][0][EVERYWHERE] == pytest.approx(expected.absolute[kind][0][EVERYWHERE], rel=1e-9)
    of_other = SharedPoints(fit.chosen, (other,), alone.usual_brightness).measured(2 * sun)
    largest = both.measured(2 * sun)
    for kind in expected.errors:
        pair = (found.errors[kind]["rms"], of_other.errors.get(kind, {"rms": 0.0})["rms"])
        assert largest.errors[kind]["rms"] == max(pair)


def test_points_that_fail_in_a_state_are_found_by_its_own_transmittances(state, band):
    sun, air = solar_irradiance(band.wavenumber), over_air(state)
    fit = fit_band(air, band, GRID, sun, **SETTINGS)
    kind, good = KINDS[0], fit.measured(air.surface_temperature, sun)
    small = {name: 0.01 * value for name, value in good.errors[kind].items()}
    regions = {name: dict.fromkeys(("max", "p99", "p95", "rms"), 0.0) for name in good.absolute[kind][0]}
    shared = replace(good, errors=good.errors | {kind: small}, absolute=good.absolute | {kind: [regions]})
    own = with_errors_of_own_air(shared, air, band, GRID, 0)
    assert own.errors[kind]["rms"] == pytest.approx(good.errors[kind]["rms"], rel=1.0)
    assert own.errors[kind]["rms"] > small["rms"] and own.absolute[kind][0][EVERYWHERE]["max"] > 0
    assert {name: own.errors[name] for name in KINDS[1:]} == {name: good.errors[name] for name in KINDS[1:]}
    other = replace(air, mole_fraction=air.mole_fraction | {"H2O": 4 * air.mole_fraction["H2O"]})
    elsewhere = with_errors_of_own_air(shared, other, band, GRID, 0)
    assert elsewhere.errors[kind]["rms"] > 3 * own.errors[kind]["rms"]


def test_irradiance_that_varies_within_an_interval_is_refused(state, band, fitted):
    with pytest.raises(ValueError, match="same at all points of an interval"):
        fitted.measured(state.surface_temperature, np.linspace(1.0, 2.0, band.weight.size))


def test_errors_as_they_are_follow_the_light_of_each_source(state, band):
    """Direct light of a source a millionth as bright errs by a millionth; all are within the relative error of the
    brightest light, and above a tenth of it where errors count relative to that.
    """
    sun = solar_irradiance(band.wavenumber)
    both = compile_band(state, band, GRID, np.stack([sun, 1e-6 * sun]))
    of_sun, of_moon = (regions[EVERYWHERE] for regions in both.absolute["direct_irradiance"])
    assert {name: 1e6 * value for name, value in of_moon.items()} == pytest.approx(
        of_sun, rel=0.3
    )  # other paths in part
    assert both.absolute["path_thermal"][0] == both.absolute["path_thermal"][1]
    assert both.absolute["transmittance"][0][EVERYWHERE]["max"] <= both.errors["transmittance"]["max"]
    outside = float(band.radiance_weight @ sun)
    largest = both.errors["direct_irradiance"]["max"] * outside
    assert 0.05 * largest < of_sun["max"] <= largest


def test_errors_as_they_are_have_the_units_of_the_band(state, band, fitted):
    """Points that give nothing err by all that there is: a transmittance of 1, the radiance of a black body as warm as
    the air along a long level path, and the light of the source on a mountain.
    """
    sun = solar_irradiance(band.wavenumber)
    nothing = replace(
        fitted.approximate,
        **{part: {kind: 0 * values for kind, values in vars(fitted.approximate)[part].items()} for part in PARTS},
    )
    absolute = replace(fitted, approximate=nothing).measured(state.surface_temperature, sun).absolute
    largest = {kind: errors[0][EVERYWHERE]["max"] for kind, errors in absolute.items()}
    assert 0.95 < largest["transmittance"] <= 1
    black = float(band.radiance_weight @ planck_wavenumber(band.wavenumber, float(state.temperature.max())))
    assert 0.85 * black < largest["path_thermal"] <= black
    outside = float(band.radiance_weight @ sun)
    assert 0.85 * outside < largest["direct_irradiance"] <= outside


def test_errors_are_stated_where_they_are(state, band, fitted):
    """Points that give nothing err by all that there is: paths along the horizon are dark, those to the zenith and to
    the ground are not, and light of the source that comes to space through the sky has lost the least.
    """
    sun = solar_irradiance(band.wavenumber)
    none = {part: {kind: 0 * values for kind, values in vars(fitted.approximate)[part].items()} for part in PARTS}
    nothing = replace(fitted.approximate, **none)
    absolute = replace(fitted, approximate=nothing).measured(state.surface_temperature, sun).absolute
    through = absolute["transmittance"][0]
    assert set(through) == {EVERYWHERE, *REGIONS}
    assert through["sky"]["rms"] > through["limb"]["rms"]
    assert max(part["max"] for part in through.values()) == through[EVERYWHERE]["max"]
    emitted = absolute["path_thermal"][0]
    assert emitted["limb"]["rms"] > emitted["ground"]["rms"]
    # On lines that end above the air, direct light is that of the source outside it times the transmittance.
    beam, outside = absolute["direct_irradiance"][0]["sky"], float(band.radiance_weight @ sun)
    assert beam["max"] == pytest.approx(outside * through["sky"]["max"], rel=0.05)
