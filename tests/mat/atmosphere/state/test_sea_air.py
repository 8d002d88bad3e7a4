"""The surface layer of a sea in a state: its air, its rays, its spray."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.sea_air import SeaAir, bending_near_water, with_sea_air
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS
from skyshine.schemas.errors import InputError

AIR = float(load_profile("us_standard").temperature[0])


def state(difference, wind=7.0, aerosol="none"):
    return AtmosphericState.from_profile(
        "us_standard", sea=SeaAir(AIR + difference, wind, 10.0, 2.0), aerosol=Aerosol(aerosol)
    )


@pytest.mark.parametrize("difference", [-12.0, -3.0, 0.0, 3.0, 12.0])
def test_air_leads_from_the_sea_to_the_profile(difference):
    air = state(difference)
    assert air.temperature_at(2.0) == pytest.approx(AIR, abs=0.02)
    assert air.surface_temperature == AIR + difference
    near = air.temperature_at(np.array([0.1, 0.5, 2.0])) - AIR
    assert np.all(np.diff(near * np.sign(difference)) <= 0.03)  # ever nearer to the water's
    plain = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))
    assert air.temperature_at(5000.0) == pytest.approx(plain.temperature_at(5000.0), abs=0.02)
    assert np.all(np.diff(air.altitude) > 0) and np.all(np.abs(np.diff(air.temperature)[:20]) < 8)


def test_the_profile_above_follows_the_layer_and_fades_to_its_own():
    profile = load_profile("us_standard")
    with_sea, _ = with_sea_air(profile, 0.0, SeaAir(AIR + 8.0, 5.0, 10.0, 2.0))
    departure = [
        float(
            np.interp(z, with_sea.altitude, with_sea.temperature) - np.interp(z, profile.altitude, profile.temperature)
        )
        for z in (50.0, 240.0, 1000.0, 3000.0)
    ]
    assert abs(departure[0]) > 0.5
    assert departure[1:] == pytest.approx([0.8 * departure[0], 0.0, 0.0], abs=1e-6)


def test_air_above_the_sea_is_humid():
    """Humidity rises from that of the air to 98 % at the water, of which 0.1 m has most (same temperature)."""
    humidity = state(0.0).relative_humidity
    plain = AtmosphericState.from_profile("us_standard").relative_humidity[0]
    at_two = np.interp(2.0, state(0.0).altitude, humidity)
    assert at_two == pytest.approx(plain, abs=0.5)
    assert plain + 10 < humidity[0] < 98


def geometric_horizon(curvature):
    return np.sqrt(2 * 9.9 * EARTH_RADIUS / (1 - curvature))


def test_a_standard_atmosphere_bends_as_known():
    """17 % of the Earth's curvature at a fall of 6.5 K/km (refraction coefficient 0.17: Bomford 1980, Geodesy)."""
    altitude = np.array([0.0, 50.0, 100.0])
    bending = bending_near_water(altitude, 101325 * np.exp(-altitude / 8435), 288.15 - 0.0065 * altitude)
    assert bending.curvature == pytest.approx(0.17, abs=0.01)
    assert bending.duct == 0
    # The ray is level at 0.1 m: sqrt(2 R h / (1 - k)) from there.
    assert bending.horizon == pytest.approx(geometric_horizon(bending.curvature), rel=0.03)


@pytest.mark.parametrize(("gradient", "sign"), [(-0.0342, 0), (-0.2, -1), (0.1, 1)])
def test_gradients_bend_rays_by_the_law(gradient, sign):
    """k = 503 P / T^2 (0.0342 + dT/dz) in hPa and K, per metre: level rays are straight at -34.2 K/km."""
    altitude = np.array([0.0, 2.0, 10.0, 100.0])
    bending = bending_near_water(altitude, 101325 * np.exp(-altitude / 8435), 288.15 + gradient * altitude)
    assert bending.curvature == pytest.approx(503 * 1013.25 / 288.15**2 * (0.0342 + gradient), abs=0.02)
    assert np.sign(round(bending.curvature, 2)) == sign


def test_warm_and_cold_seas_show_their_mirages():
    warm, cold = (bending_near_water(a.altitude, a.pressure, a.temperature) for a in (state(4.0), state(-6.0)))
    assert warm.lowest_curvature < 0 and warm.duct == 0 and warm.horizon < geometric_horizon(0.0)
    assert cold.duct > 1 and cold.horizon == np.inf


def test_the_horizon_is_that_of_the_traced_ray():
    """A ray of the transfer's own tracing, level at 0.1 m, reaches 10 m at the stated distance."""
    from skyshine.mat.atmosphere.transfer.geometry import Shells, trace

    air = state(3.0)
    shells = Shells.of(air.altitude, air.number_density, 1000.0)
    rays = trace(shells, np.array([0.1]), np.array([0.0]), np.array([np.inf]))
    distance = np.interp(10.0, rays.altitude[0], rays.distance[0])
    bending = bending_near_water(air.altitude, air.pressure, air.temperature)
    assert bending.horizon == pytest.approx(distance, rel=0.05)


def test_spray_belongs_to_maritime_aerosols():
    names = [part.model.name for part in state(2.0, aerosol="navy_maritime").aerosols]
    assert "water cloud" in names
    assert "water cloud" not in [part.model.name for part in state(2.0, aerosol="rural").aerosols]


def test_a_frozen_or_boiling_sea_is_refused():
    for kelvin in (260.0, 320.0, np.nan):
        with pytest.raises(InputError, match=r"allowed: 270.15 to 315.15 K"):
            with_sea_air(load_profile("tropical"), 0.0, SeaAir(kelvin, 5.0, 10.0, 2.0))
