"""A summer day at 40 degrees north, by the textbook formulae for the Sun."""

import numpy as np
import pytest

from skyshine.mat.surface.forcing import Sky
from skyshine.mat.surface.sun_path import SunPath, sun_hours
from skyshine.mat.surface.weather import from_extremes


def sun(latitude: float, declination: float) -> tuple[np.ndarray, np.ndarray]:
    """Elevation and azimuth of the Sun at `sun_hours()`, solar noon at 12 [degree]."""
    hour = np.radians(15 * (sun_hours() - 12))
    lat, dec = np.radians(latitude), np.radians(declination)
    up = np.sin(lat) * np.sin(dec) + np.cos(lat) * np.cos(dec) * np.cos(hour)
    east = -np.cos(dec) * np.sin(hour)
    north = np.cos(lat) * np.sin(dec) - np.sin(lat) * np.cos(dec) * np.cos(hour)
    return np.degrees(np.arcsin(up)), np.degrees(np.arctan2(east, north)) % 360


@pytest.fixture(scope="session")
def make_sun_path():
    return lambda latitude=40.0, declination=20.0: SunPath(0.0, *sun(latitude, declination))


@pytest.fixture(scope="session")
def sun_path(make_sun_path):
    return make_sun_path()


@pytest.fixture(scope="session")
def make_weather(sun_path):
    return lambda cloud_fraction=0.0: from_extremes(sun_path, 285.0, 301.0, 50.0, 2.0, cloud_fraction)


@pytest.fixture(scope="session")
def weather(make_weather):
    return make_weather()


@pytest.fixture(scope="session")
def sky():
    """One optical depth for direct light, a tenth of it in diffuse light, and drier air higher up."""
    z, elevation = np.linspace(0.0, 4000.0, 9), np.arange(-5.0, 91.0)
    sine = np.maximum(np.sin(np.radians(elevation)), 1e-3)
    direct = np.where(elevation > 0, 1361.0 * np.exp(-0.35 * np.exp(-z / 8000)[:, None] / sine), 0.0)
    pressure, aureole = 101325 * np.exp(-z / 8000), np.full(elevation.size, 0.3)
    return Sky(z, pressure, elevation, direct, 0.2 * direct * sine, aureole, 0.8 - z / 4e4, 0.2)
