"""Ends of bent paths: against traced rays, and what their heights are worth."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells
from skyshine.mat.quantities.channels.coordinates import RayCoordinates

HEIGHTS = np.linspace(0.0, 100 ** (1 / 3), 12)
EARTH = EARTH_RADIUS / 1e3


def rays(density, ground=0.0):
    """Coordinates in air whose density falls by e in 8 km."""
    altitude = ground + np.linspace(0.0, 100e3, 201)
    return RayCoordinates.of(Shells.of(altitude, density * np.exp(-altitude / 8e3), 1000.0), HEIGHTS)


@pytest.mark.parametrize("ground", [0.0, -400.0, 3000.0])
def test_a_straight_line_ends_where_a_circle_has_it(ground):
    reach, up, root = np.array([0.0, 1.0, 300.0, 5000.0]), np.radians(2.0), 2.0
    radius = EARTH + ground / 1e3 + root**3
    end = np.sqrt(radius**2 + reach**2 + 2 * radius * reach * np.sin(up)) - EARTH - ground / 1e3
    assert rays(2.5e25, ground).straight_height(reach, root, 2.0) == pytest.approx(end, abs=1e-9)


def test_a_line_into_the_earth_ends_below_the_ground():
    assert rays(1.0).straight_height(np.array([3.0]), 1.0, -90.0) == pytest.approx(-2.0, abs=1e-9)


def test_without_air_the_sphere_has_the_straight_ends():
    reach = np.array([0.0, 10.0, 500.0])
    vacuum = rays(1.0)
    assert vacuum.locate(reach, 8.0, 1.0).end_height == pytest.approx(vacuum.straight_height(reach, 2.0, 1.0), rel=1e-5)
