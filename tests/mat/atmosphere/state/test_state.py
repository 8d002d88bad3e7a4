"""Columns of the standard states against published ones, and the limits of states."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import RAYLEIGH_550, Aerosol
from skyshine.mat.atmosphere.particles.angstrom import AngstromModel
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import Shells, trace
from skyshine.mat.atmosphere.transfer.optics import particle_sections
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.errors import InputError


# Water [kg m^-2] and ozone [DU] of the profiles of Anderson et al. 1986, as MODTRAN's users know them.
@pytest.mark.parametrize(
    ("profile", "water", "ozone"),
    [
        ("tropical", 41.1, 277),
        ("midlatitude_summer", 29.2, 332),
        ("midlatitude_winter", 8.5, 377),
        ("subarctic_summer", 20.8, 345),
        ("subarctic_winter", 4.2, 376),
        ("us_standard", 14.2, 344),
    ],
)
def test_columns_of_the_profiles(profile, water, ozone):
    state = AtmosphericState.from_profile(profile)
    assert state.precipitable_water(0.0) == pytest.approx(water, rel=0.015)
    assert state.ozone_column(0.0) == pytest.approx(ozone, rel=0.015)


def test_columns_fall_with_altitude_and_end_at_the_top():
    state = AtmosphericState.from_profile("tropical")
    altitude = np.linspace(0, 110e3, 300)
    for column in (
        state.precipitable_water(altitude),
        state.ozone_column(altitude),
        state.aerosol_optical_depth(500, altitude),
    ):
        assert np.all(np.diff(column) <= 1e-12 * column[0])
        assert column[-1] == 0.0
    inside = np.linspace(100.0, 900.0, 5)
    fresh = AtmosphericState.from_profile("tropical", surface_altitude=500.0)
    assert fresh.precipitable_water(700.0) == pytest.approx(state.precipitable_water(700.0), rel=2e-3)
    assert np.all(np.diff(state.pressure_at(inside)) < 0)


def test_hydrostatic_weight_of_the_air():
    state = AtmosphericState.from_profile("us_standard")
    assert state._column(state.number_density, 0.0) == pytest.approx(
        2.1535e29, rel=3e-3
    )  # 101325 Pa / (28.964 g/mol * 9.79)


def test_visibility_gives_the_extinction_at_the_ground():
    for visibility in (0.1, 5.0, 23.0, 300.0):
        state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol(visibility_km=visibility))
        total = sum(component.extinction_550[0] for component in state.aerosols) + RAYLEIGH_550
        assert total * visibility * 1e3 == pytest.approx(3.912, rel=1e-6)
    hazy, clear = (
        AtmosphericState.from_profile("us_standard", aerosol=Aerosol(visibility_km=v)).aerosol_optical_depth(500, 0.0)
        for v in (5, 50)
    )
    assert hazy > 2 * clear > 0
    assert AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none")).aerosol_optical_depth(500, 0.0) == 0.0


# IAPWS formulation of 1995 (Wagner and Pruss 2002, J. Phys. Chem. Ref. Data 31, 387) at 0.01, 20, 40, 60 and 80 C.
@pytest.mark.parametrize(
    ("temperature", "pascal", "tolerance"),
    [
        (273.16, 611.657, 1e-5),
        (293.15, 2339.3, 2e-4),
        (313.15, 7384.9, 2e-4),
        (333.15, 19946.0, 1e-3),
        (353.15, 47414.0, 3e-3),
    ],
)
def test_saturation_pressure_is_that_of_water(temperature, pascal, tolerance):
    assert saturation_pressure(temperature) == pytest.approx(pascal, rel=tolerance)


def test_scaled_humidity_stops_at_saturation():
    state = AtmosphericState.from_profile("tropical", gas_amounts=GasAmounts(scale={"H2O": 10.0}))
    vapour = state.mole_fraction["H2O"] * state.pressure
    assert np.all(vapour <= saturation_pressure(state.temperature) * (1 + 1e-12))
    assert np.all(state.relative_humidity <= 100.0)
    dry = AtmosphericState.from_profile("tropical", gas_amounts=GasAmounts(scale={"H2O": 0.0}))
    assert dry.precipitable_water(0.0) == 0.0


def test_carbon_dioxide_is_that_at_the_ground():
    assert AtmosphericState.from_profile("tropical", gas_amounts=GasAmounts(ppm={"CO2": 420})).mole_fraction["CO2"][
        0
    ] == pytest.approx(420e-6)
    assert AtmosphericState.from_profile("tropical").mole_fraction["CO2"][0] == pytest.approx(330e-6)


@pytest.mark.parametrize("ground", [-430.0, 0.0, 1609.0, 5000.0])
def test_ground_altitude_begins_the_levels(ground):
    state = AtmosphericState.from_profile("midlatitude_summer", surface_altitude=ground)
    assert state.altitude[0] == ground
    assert state.altitude[-1] == 100e3
    assert np.all(np.diff(state.altitude) > 50)
    assert np.all(np.diff(state.pressure) < 0)
    assert state.surface_temperature == state.temperature[0]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"surface_altitude": 9000.0}, "surface altitude"),
        ({"gas_amounts": GasAmounts(scale={"H2O": -1.0})}, "amount -1.0 of H2O"),
        ({"gas_amounts": GasAmounts(scale={"H2O": float("nan")})}, "amount nan of H2O"),
        ({"aerosol": Aerosol(visibility_km=0.01)}, "visibility"),
        ({"aerosol": Aerosol("rurl")}, "rural"),
        ({"surface_albedo": 1.5}, "albedo"),
        ({"surface_temperature": -5.0}, "surface temperature"),
        ({"surface_temperature": 99.0}, "outside 100 to 500 K"),
        ({"surface_temperature": 501.0}, "outside 100 to 500 K"),
        ({"gas_amounts": GasAmounts(ppm={"CO2": float("inf")})}, "finite"),
    ],
)
def test_bad_settings_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        AtmosphericState.from_profile("tropical", **settings)


def test_repeated_altitudes_are_refused():
    levels = np.array([0.0, 1e3, 1e3, 2e3])
    ones = np.ones(4)
    with pytest.raises(InputError, match="without repetition"):
        AtmosphericState("x", levels, ones * 1e5, ones * 280, {"H2O": ones * 0}, (), 280.0, 0.1)


def vertical_depth(state, wavelength_um):
    """Of aerosol alone, along a vertical ray from the ground to space as lines of sight count it."""
    shells = Shells.of(state.altitude, state.number_density, 1e4)
    rays = trace(shells, state.altitude[:1], np.array([np.pi / 2]))
    sections = sum(particle_sections(state, part, 1e4 / np.atleast_1d(wavelength_um))[0] for part in state.aerosols)
    return Segments.of(rays, 0).column(sections).sum(axis=0)


@pytest.mark.parametrize("model", ["rural", "desert", "navy_maritime", "fog_advection"])
@pytest.mark.parametrize(("depth", "ground"), [(0.12, 0.0), (5.0, 1609.0), (0.003, -400.0)])
def test_a_vertical_beam_has_the_optical_depth_that_is_asked_for(model, depth, ground):
    aerosol = Aerosol(model, optical_depth=depth)
    state = AtmosphericState.from_profile("midlatitude_summer", surface_altitude=ground, aerosol=aerosol)
    assert np.exp(-vertical_depth(state, 0.55)[0]) == pytest.approx(np.exp(-depth), rel=1e-6)
    assert state.aerosol_optical_depth(550.0, ground) == pytest.approx(depth, rel=1e-12)


def test_an_optical_depth_keeps_the_shape_of_the_profile():
    plain, scaled = (
        AtmosphericState.from_profile("us_standard", aerosol=Aerosol("rural", optical_depth=depth))
        for depth in (None, 0.1)
    )
    factor = 0.1 / plain.aerosol_optical_depth(550.0, 0.0)
    for before, after in zip(plain.aerosols, scaled.aerosols, strict=True):
        np.testing.assert_allclose(after.extinction_550, factor * before.extinction_550, rtol=1e-12)


def test_no_optical_depth_is_no_aerosol():
    assert AtmosphericState.from_profile("us_standard", aerosol=Aerosol(optical_depth=0.0)).aerosols == ()


@pytest.mark.parametrize("model", ["rural", "desert", "fog_radiation"])
@pytest.mark.parametrize("exponent", [-0.3, 0.0, 1.3, 2.2])
def test_the_angstrom_exponent_is_the_slope_of_the_column(model, exponent):
    aerosol = Aerosol(model, optical_depth=0.2, angstrom_exponent=exponent)
    state = AtmosphericState.from_profile("tropical", aerosol=aerosol)
    wavelength = np.array([0.34, 0.44, 0.55, 0.87, 1.02, 1.64])
    np.testing.assert_allclose(vertical_depth(state, wavelength), 0.2 * (wavelength / 0.55) ** -exponent, rtol=1e-6)


def test_beyond_sunlight_the_angstrom_exponent_keeps_the_model():
    """Albedo everywhere, the spectrum of extinction from 1.64 um on; its own exponent changes nothing there."""
    wavelength = np.array([0.4, 0.55, 0.87, 1.64, 1.641, 3.9, 9.2, 11.0])
    rural = AerosolModel.load("rural")
    plain, steep = (model.optics(1e4 / wavelength, [70.0]) for model in (rural, AngstromModel(rural, 2.0)))
    np.testing.assert_array_equal(steep.single_scattering_albedo, plain.single_scattering_albedo)
    np.testing.assert_array_equal(steep.asymmetry, plain.asymmetry)
    ratio = (steep.extinction / plain.extinction)[0]
    np.testing.assert_allclose(ratio[4:], ratio[3], rtol=1e-12)
    assert ratio[3] < 0.6
    own = np.log(plain.extinction[0, 1] / plain.extinction[0, 3]) / np.log(1.64 / 0.55)
    same = AngstromModel(rural, own).optics(1e4 / wavelength, [70.0])
    np.testing.assert_allclose(same.extinction[0, 3:], plain.extinction[0, 3:], rtol=1e-9)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"optical_depth": -0.1}, "optical depth -0.1 is outside 0 to 100"),
        ({"optical_depth": float("nan")}, "optical depth nan is outside"),
        ({"optical_depth": 0.1, "visibility_km": 23.0}, "23 km and an aerosol optical depth of 0.1; allowed: one"),
        ({"model": "none", "optical_depth": 0.1}, "name a model"),
        ({"angstrom_exponent": float("nan")}, "exponent nan is outside -1 to 4"),
        ({"angstrom_exponent": 4.5}, "exponent 4.5 is outside -1 to 4"),
    ],
)
def test_bad_optical_depths_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        AtmosphericState.from_profile("tropical", aerosol=Aerosol(**settings))
