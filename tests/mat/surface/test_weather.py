"""Weather through the day: extremes, tables by hour, other altitudes, saturation."""

import numpy as np
import pytest

from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather import air_temperature, from_extremes, from_hours

HOURS = np.arange(24.0)


def test_air_temperature_reaches_its_extremes(sun_path):
    """Lowest at sunrise, highest two hours after noon, smooth and periodic."""
    series = air_temperature(sun_path, 280.0, 300.0)
    sunrise = sun_hours()[np.argmax(sun_path.solar_elevation > 0)]
    assert sun_hours()[series.argmin()] == pytest.approx(sunrise, abs=0.05)
    assert sun_hours()[series.argmax()] == pytest.approx(14.0, abs=0.05)
    assert (series.min(), series.max()) == (pytest.approx(280.0, abs=1e-3), pytest.approx(300.0, abs=1e-3))
    assert np.abs(np.diff(np.append(series, series[0]))).max() < 0.2


@pytest.mark.parametrize("declination", [-23.0, 23.0])
def test_air_temperature_without_sunrise(make_sun_path, declination):
    series = air_temperature(make_sun_path(80.0, declination), 240.0, 250.0)
    assert sun_hours()[series.argmin()] == pytest.approx(0.0, abs=0.05)
    assert series.max() == pytest.approx(250.0, abs=1e-3)


def test_hourly_values_are_linear_and_periodic():
    weather = from_hours(500.0, HOURS, 280 + HOURS, 60.0, 1 + 0.5 * HOURS, HOURS / 24, 95e3 + HOURS)
    at = np.searchsorted(sun_hours(), [6.0, 6.5, 23.5])
    assert weather.air_temperature[at] == pytest.approx([286.0, 286.5, 291.5])
    assert weather.wind_speed[at] == pytest.approx([4.0, 4.25, 6.75])
    assert weather.pressure[at] == pytest.approx([95006.0, 95006.5, 95011.5])
    assert weather.vapour_pressure[at[0]] == pytest.approx(0.6 * saturation_pressure(286.0))
    assert np.all(weather.vapour_pressure <= saturation_pressure(weather.air_temperature))


def test_altitude_changes_air_and_sun(sun_path, sky):
    """From a station at 500 m to a summit at 2500 m: 13 K colder, thinner air that keeps its mixing ratio, more sun."""
    weather = from_hours(500.0, HOURS, np.full(24, 290.0), 40.0, 2.0, 0.0, np.full(24, 96e3))
    scene = Scene(sun_path, weather, sky, np.array([500.0, 2500.0]), np.array([0.0]), np.array([0.0]))
    forcing = scene.forcing(96)
    assert forcing.air_temperature[:, 0] == pytest.approx([290.0, 277.0])
    assert forcing.pressure[:, 0] == pytest.approx([96e3, 96e3 * np.exp(-2000 / 8000)], rel=1e-9)
    mixing = forcing.vapour_pressure[:, 0] / forcing.pressure[:, 0]
    assert mixing[0] == pytest.approx(mixing[1])
    noon = forcing.shortwave_direct[:, 48]
    assert noon[1] > 1.05 * noon[0]


def test_cloud_of_the_afternoon_darkens_the_afternoon(sun_path, sky):
    cloud = np.where((HOURS >= 14) & (HOURS <= 17), 1.0, 0.0)
    weather = from_hours(0.0, HOURS, np.full(24, 290.0), 50.0, 2.0, cloud)
    forcing = Scene(sun_path, weather, sky, np.array([0.0]), np.array([0.0]), np.array([0.0])).forcing(96)
    assert forcing.shortwave_direct[0, 10 * 4] > 500 and forcing.shortwave_direct[0, 15 * 4] == 0
    assert forcing.longwave_sky[0, 15 * 4] > forcing.longwave_sky[0, 10 * 4] + 50


def test_humidity_of_the_extremes_holds_at_their_mean(sun_path):
    """50 % at 20 C between 10 and 30 C: 0.5 x 2339.2 Pa all day, saturated where that exceeds what cold air holds."""
    air = from_extremes(sun_path, 283.15, 303.15, 50.0, 3.0, 0.25)
    assert air.vapour_pressure == pytest.approx(1169.6, rel=4e-3)
    assert np.all(air.wind_speed == 3.0) and np.all(air.cloud_fraction == 0.25) and air.pressure is None
    humid = from_extremes(sun_path, 283.15, 303.15, 90.0, 3.0, 0.0)
    assert humid.vapour_pressure.min() == pytest.approx(1228.0, rel=5e-3)
    assert humid.vapour_pressure.max() == pytest.approx(0.9 * 2339.2, rel=4e-3)


def test_air_temperature_is_half_cosines(sun_path):
    """Half way up in time from sunrise to two hours after noon, and half way down again, lies the mean."""
    series, hours = air_temperature(sun_path, 280.0, 300.0), sun_hours()
    coldest, warmest = hours[series.argmin()], hours[series.argmax()]
    up, down = 0.5 * (coldest + warmest), 0.5 * (warmest + coldest + 24.0) % 24.0
    assert np.interp([up, down], hours, series) == pytest.approx([290.0, 290.0], abs=0.1)
    quarter = coldest + 0.25 * (warmest - coldest)
    assert np.interp(quarter, hours, series) == pytest.approx(290 - 10 * np.cos(np.pi / 4), abs=0.1)


def test_air_carried_upwards_keeps_to_saturation(sun_path):
    """Saturated air at 0 m, 3 km higher: 19.5 K colder, so that it holds less than its mixing ratio would give."""
    air = from_hours(0.0, HOURS, np.full(24, 293.15), 100.0, 2.0, 0.0)
    temperature, vapour, pressure = air.at(np.array([3000.0]), np.array([7e4, 1e5]))
    assert temperature[0, 0] == pytest.approx(273.65) and pressure[0, 0] == pytest.approx(7e4)
    assert vapour[0, 0] == pytest.approx(saturation_pressure(273.65)) and vapour[0, 0] < 0.7 * 2339.2


def test_vapour_between_hours_is_at_most_saturated():
    """Fog of -20 and +20 C in turn: a straight line between both pressures would exceed saturation in between."""
    temperature = np.where(HOURS % 2 == 0, 253.15, 293.15)
    air = from_hours(0.0, HOURS, temperature, 100.0, 2.0, 0.0)
    half = np.searchsorted(sun_hours(), 6.5)
    assert air.air_temperature[half] == pytest.approx(273.15)
    assert air.vapour_pressure[half] == pytest.approx(611.21, rel=1e-5)
