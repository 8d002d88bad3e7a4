"""Cn2 over ground: the laws that its parts give together."""

import numpy as np
import pytest

from skyshine.mat.surface.convection import Wind
from skyshine.mat.surface.ground_turbulence import ground_turbulence

HEIGHT = np.array([1.0, 4.0, 16.0])
PRESSURE, AIR = np.array([101325.0]), np.array([290.0])


def cn2(difference, wind, roughness=0.01):
    return ground_turbulence(AIR + difference, AIR, Wind(np.array([wind])), PRESSURE, roughness, HEIGHT)[:, 0]


def test_windy_air_is_neutral():
    """T* = -0.4 dT / (ln(2 / z0) + 2) of the log law; 4.9 T*^2 z^(-2/3) (79e-6 P / T^2)^2: Andreas 1988."""
    scale = 0.4 * 0.5 / (np.log(2.0 / 0.01) + 2.0)
    slope = 79e-6 * 1013.25 / 290.0**2
    assert cn2(0.5, 40.0) == pytest.approx(4.9 * (slope * scale) ** 2 * HEIGHT ** (-2 / 3), rel=0.05, abs=0)


def test_hot_calm_ground_is_in_free_convection():
    values = cn2(30.0, 0.3)
    assert np.diff(np.log(values))[-1] / np.log(4) == pytest.approx(-4 / 3, abs=0.02)


def test_day_and_night_have_observed_sizes():
    """At 2 m 1e-13 to 1e-12 by day, 1e-15 to 1e-13 by night: Andreas 1988; Beland 1993, IR/EO Handbook, vol. 2."""
    assert 1e-13 < np.interp(2.0, HEIGHT, cn2(20.0, 3.0)) < 3e-12
    assert 1e-15 < np.interp(2.0, HEIGHT, cn2(-3.0, 3.0)) < 3e-13


def test_no_difference_no_turbulence_and_all_is_finite():
    assert np.all(cn2(0.0, 3.0) == 0)
    for difference in (-60.0, -1e-3, 1e-3, 80.0):
        for wind in (0.0, 0.2, 60.0):
            values = cn2(difference, wind)
            assert np.all(np.isfinite(values)) and np.all((values >= 0) & (values < 1e-9))
