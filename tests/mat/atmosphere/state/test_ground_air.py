"""Weather in the lowest part of a profile: the ground as asked, adiabats, inversions, no supersaturation, balance."""

import numpy as np
import pytest
from scipy import constants

from skyshine.mat.atmosphere.state.ground_air import (
    AIR_MASS_DEPTH,
    DRY_ADIABAT,
    INVERSION_HEIGHT,
    GroundAir,
    with_ground_air,
)
from skyshine.mat.atmosphere.state.levels import linear
from skyshine.mat.atmosphere.state.profiles import PROFILES, Profile, load_profile
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.errors import InputError


def weather(kelvin, mean=None, humidity=50.0, altitude=0.0, pressure=None):
    """Air of a relative humidity [percent] at the day's mean, of the same vapour pressure at the time."""
    mean = kelvin if mean is None else mean
    vapour = humidity / 100 * float(saturation_pressure(mean))
    return GroundAir(altitude, kelvin, mean, vapour, vapour, pressure)


def relative_humidity(profile):
    return profile.mole_fraction["H2O"] * profile.pressure / saturation_pressure(profile.temperature)


def mixing_ratio(profile):
    return profile.mole_fraction["H2O"] / (1 - profile.mole_fraction["H2O"])


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize("ground", [-430.0, 0.0, 2100.0])
def test_weather_of_the_profile_itself_changes_nothing(name, ground):
    """Temperature, pressure and all gases on the profile's own interpolation, to rounding."""
    profile = load_profile(name)
    kelvin = float(linear(ground, profile.altitude, profile.temperature))
    pressure = float(np.exp(linear(ground, profile.altitude, np.log(profile.pressure))))
    vapour = pressure * float(np.exp(linear(ground, profile.altitude, np.log(profile.mole_fraction["H2O"]))))
    same = with_ground_air(profile, ground, GroundAir(ground, kelvin, kelvin, vapour, vapour, pressure))
    assert same.altitude[0] == ground and same.altitude[-1] == profile.altitude[-1]
    assert same.temperature == pytest.approx(linear(same.altitude, profile.altitude, profile.temperature), abs=1e-10)
    for gas, fraction in profile.mole_fraction.items():
        expected = np.log(np.maximum(fraction, 1e-30))
        assert np.log(np.maximum(same.mole_fraction[gas], 1e-30)) == pytest.approx(
            linear(same.altitude, profile.altitude, expected), abs=1e-9
        ), gas
    logarithm = linear(same.altitude, profile.altitude, np.log(profile.pressure))
    assert np.log(same.pressure) == pytest.approx(logarithm, abs=1e-12)


def test_the_day_s_mean_moves_the_air_mass():
    """16 K at the ground, half of it at 5 km, nothing from 10 km on; pressure above by the weight of the warmer air."""
    profile = load_profile("midlatitude_winter")
    moved = with_ground_air(profile, 0.0, weather(272.2 + 16.0))
    before = linear(moved.altitude, profile.altitude, profile.temperature)
    share = np.maximum(1 - moved.altitude / AIR_MASS_DEPTH, 0)
    assert moved.temperature - before == pytest.approx(16.0 * share, abs=1e-9)
    high = moved.altitude >= AIR_MASS_DEPTH
    fixed = linear(moved.altitude, profile.altitude, np.log(profile.pressure))
    ratio = np.exp(np.log(moved.pressure) - fixed)
    assert ratio[0] == pytest.approx(1.0) and np.ptp(ratio[high]) < 1e-12
    # Water vapour: the factor at the ground, its square root at 5 km, none from 10 km on.
    own = linear(moved.altitude, profile.altitude, np.log(mixing_ratio(profile)))
    change = np.log(mixing_ratio(moved)) - own
    assert change[0] > 0.5 and change[high] == pytest.approx(0.0, abs=1e-4)
    assert np.interp(5e3, moved.altitude, change) == pytest.approx(0.5 * change[0], abs=0.01)
    # Hypsometric: the layer of 10 km is thicker by 8 K of some 250 K, so its pressure falls by 3 % less.
    assert ratio[-1] == pytest.approx(np.exp(9.80665 * 10e3 / 287.05 * 8 / 250.0**2), rel=0.02)


def test_by_day_a_layer_is_mixed_from_the_ground_to_where_its_parcel_meets_the_profile():
    """Midlatitude summer cools by 4.5 K/km: 10 K are used up by 9.76 - 4.5 K/km in 1.9 km (parcel method), less what
    the air mass adds.
    """
    profile = load_profile("midlatitude_summer")
    mixed = with_ground_air(profile, 0.0, weather(304.2, mean=294.2))
    gradient = -np.diff(mixed.temperature) / np.diff(mixed.altitude)
    top = mixed.altitude[1:][gradient > DRY_ADIABAT * (1 - 1e-9)].max()
    assert top == pytest.approx(10.0 / (DRY_ADIABAT - 4.5e-3), rel=1e-6)
    inside = mixed.altitude <= top
    assert np.all(gradient[: inside.sum() - 1] == pytest.approx(DRY_ADIABAT))
    assert np.ptp(mixing_ratio(mixed)[inside]) < 1e-12
    assert mixed.temperature[~inside] == pytest.approx(
        linear(mixed.altitude[~inside], profile.altitude, profile.temperature)
    )
    assert np.all(mixing_ratio(mixed)[~inside] < mixing_ratio(mixed)[0])


def test_at_night_an_inversion_blends_into_the_air_mass():
    profile = load_profile("midlatitude_summer")
    night = with_ground_air(profile, 0.0, weather(286.2, mean=294.2))
    low = night.altitude < INVERSION_HEIGHT
    departure = night.temperature - linear(night.altitude, profile.altitude, profile.temperature)
    assert departure[0] == pytest.approx(-8.0) and departure[~low] == pytest.approx(0.0, abs=1e-9)
    assert np.interp(250.0, night.altitude, departure) == pytest.approx(-1.0)
    assert np.all(np.diff(night.temperature[night.altitude <= 150.0]) > 0)  # warmer upwards: an inversion


@pytest.mark.parametrize("humidity", [0.0, 1.0, 50.0, 100.0])
@pytest.mark.parametrize("kelvin", [200.0, 240.0, 273.15, 300.0, 330.0])
@pytest.mark.parametrize("name", ["tropical", "subarctic_winter"])
def test_air_of_any_weather_is_sound(name, kelvin, humidity):
    """No supersaturation beyond the profile's own, no gradient beyond the dry adiabat, pressure that falls; the ground
    as the weather has it; a state can be made of it.
    """
    profile = load_profile(name)
    for time in (kelvin - 10.0, kelvin, kelvin + 5.0):
        air = with_ground_air(profile, 0.0, weather(time, mean=kelvin, humidity=humidity))
        assert air.temperature[0] == pytest.approx(time, abs=1e-9)
        assert np.all(np.diff(air.pressure) < 0) and np.all(np.isfinite(np.stack(list(air.mole_fraction.values()))))
        assert np.all(relative_humidity(air) <= 1 + 1e-12) and np.all(air.mole_fraction["H2O"] >= 0)
        gradient = -np.diff(air.temperature) / np.diff(air.altitude)
        assert np.all(gradient[air.altitude[1:] <= 10e3] <= DRY_ADIABAT + 6.6e-3)
        assert np.all(gradient[:10] <= DRY_ADIABAT * (1 + 1e-9))
        state = AtmosphericState.from_profile(air)
        expected = min(humidity / 100 * saturation_pressure(kelvin), saturation_pressure(time))
        assert state.mole_fraction["H2O"][0] * state.pressure[0] == pytest.approx(expected, rel=1e-9)
        assert np.all((air.temperature > 150.0) & (air.temperature < 350.0) | (air.altitude > 90e3))


@pytest.mark.parametrize("name", ["tropical", "midlatitude_summer", "us_standard"])
@pytest.mark.parametrize(("kelvin", "humidity"), [(283.0, 60.0), (293.0, 30.0), (300.0, 50.0), (303.0, 80.0)])
def test_columns_follow_the_humidity_at_the_ground(name, kelvin, humidity):
    """Leckner (1978), Solar Energy 20, 143: 0.00493 e / T [mm, with e in Pa and T in K, 10 kg/m2 a cm]; his formula
    scatters by a quarter between climates.
    """
    vapour = humidity / 100 * saturation_pressure(kelvin)
    state = AtmosphericState.from_profile(name, ground_air=weather(kelvin, humidity=humidity))
    assert state.precipitable_water(0.0) == pytest.approx(10 * 0.493 * vapour / kelvin, rel=0.3)


def test_water_that_the_job_states_is_mixed_but_not_changed_in_amount():
    """The column below the mixing height stays (trapezium rule on levels of some 250 m)."""
    profile = load_profile("midlatitude_summer")
    mixed = with_ground_air(profile, 0.0, GroundAir(0.0, 304.2, 294.2))
    columns = [AtmosphericState.from_profile(one).precipitable_water(0.0) for one in (profile, mixed)]
    assert columns[1] == pytest.approx(columns[0], rel=0.04)
    still = with_ground_air(profile, 0.0, GroundAir(0.0, 294.2, 294.2))
    assert np.log(still.mole_fraction["H2O"]) == pytest.approx(
        linear(still.altitude, profile.altitude, np.log(profile.mole_fraction["H2O"])), abs=1e-9
    )


def test_air_is_carried_from_the_station_to_the_ground():
    """A station 1 km above the site: 6.5 K warmer at the ground, the same mole fraction of vapour, its pressure kept at
    its altitude as far as the profile's thickness goes.
    """
    profile = load_profile("us_standard")
    there = float(np.exp(linear(1000.0, profile.altitude, np.log(profile.pressure))))
    air = with_ground_air(profile, 0.0, weather(280.0, altitude=1000.0, pressure=1.01 * there))
    assert air.temperature[0] == pytest.approx(286.5)
    assert air.pressure[0] == pytest.approx(1.01 * profile.pressure[0])
    assert air.mole_fraction["H2O"][0] == pytest.approx(0.5 * saturation_pressure(280.0) / (1.01 * there))


def test_the_weight_of_the_air_is_its_pressure():
    """g times the mass above the ground, against the pressure there, within what the profile itself holds."""

    def excess(profile):
        density = 28.9647e-3 * profile.pressure / (constants.R * profile.temperature)
        gravity = constants.g * (6356766 / (6356766 + profile.altitude)) ** 2
        fine = np.linspace(0, 60e3, 60001)
        weight = np.exp(np.interp(fine, profile.altitude, np.log(density * gravity)))
        return np.trapezoid(weight, fine) / (profile.pressure[0] - np.interp(60e3, profile.altitude, profile.pressure))

    profile = load_profile("midlatitude_winter")
    for air in (weather(292.0), weather(255.0), weather(285.0, mean=275.0)):
        assert excess(with_ground_air(profile, 0.0, air)) == pytest.approx(excess(profile), abs=2e-3)


@pytest.mark.parametrize(
    ("air", "message"),
    [
        (weather(346.0), r"found air of 346.0 K at the ground by the weather; allowed: 140 to 335 K"),
        (weather(300.0, mean=130.0), "found air of 130.0 K"),
        (weather(330.0, altitude=5000.0, humidity=0.0), "found air of 362.5 K"),
        (weather(290.0, pressure=115e3), "found air of 1150 hPa at the ground by the weather; allowed: at most 1100"),
        (weather(334.0, humidity=100.0, pressure=25e3), "found air of 250 hPa that has water vapour of 208 hPa"),
    ],
)
def test_air_of_no_place_is_refused_in_one_line(air, message):
    with pytest.raises(InputError, match=message) as refusal:
        with_ground_air(load_profile("us_standard"), 0.0, air)
    assert "\n" not in str(refusal.value)


def test_humidity_over_a_profile_without_water_is_refused():
    profile = load_profile("us_standard")
    dry = Profile(
        "dry",
        profile.altitude,
        profile.pressure,
        profile.temperature,
        profile.mole_fraction | {"H2O": np.zeros_like(profile.altitude)},
    )
    with pytest.raises(InputError, match="the profile has no water vapour at the ground"):
        with_ground_air(dry, 0.0, weather(290.0))
    assert np.all(with_ground_air(dry, 0.0, weather(290.0, humidity=0.0)).mole_fraction["H2O"] == 0)
