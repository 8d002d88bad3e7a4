"""Louis' stability factor against Monin-Obukhov similarity solved to the end, its limits and its derivative."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skyshine.mat.surface.convection import Wind
from skyshine.mat.surface.stability import Stability

AIR = 285.0
GRAVITY = 9.80665


def stable_pair(zeta, roughness, wind_height, air_height):
    """Richardson number g z dT / (T U^2) and factor by Dyer's 1 + 5 z/L, in closed form; z is the wind's height."""
    momentum = np.log1p(wind_height / roughness)
    heat = np.log1p(air_height * np.exp(2) / roughness)
    ratio = air_height / wind_height
    number = zeta * (heat + 5 * zeta * ratio) / (momentum + 5 * zeta) ** 2
    return number, momentum * heat / ((momentum + 5 * zeta) * (heat + 5 * ratio * zeta))


@pytest.mark.parametrize("roughness", [1e-4, 1e-3, 1e-2, 5e-2])
@pytest.mark.parametrize("zeta", [0.05, 0.1, 0.2, 0.5])
def test_weakly_stable_air(roughness, zeta):
    number, factor = stable_pair(zeta, roughness, 10.0, 2.0)
    colder = number * AIR * 3.0**2 / (GRAVITY * 10.0)
    found = Stability.of(Wind(3.0), AIR, 1.0, roughness).factor(np.array([-colder]))
    assert found == pytest.approx(factor, rel=0.08)


def unstable_factor(speed, warmer, roughness, wind_height=10.0, air_height=2.0):
    """Factor by the profiles of Paulson (1970) with 16 z/L, by iteration of the Obukhov length."""
    heat_roughness = roughness * np.exp(-2)

    def wind_part(zeta):
        x = (1 - 16 * zeta) ** 0.25
        return 2 * np.log((1 + x) / 2) + np.log((1 + x * x) / 2) - 2 * np.arctan(x) + np.pi / 2

    def heat_part(zeta):
        return 2 * np.log((1 + np.sqrt(1 - 16 * zeta)) / 2)

    momentum, heat = np.log(1 + wind_height / roughness), np.log(1 + air_height / heat_roughness)
    length = -10.0
    for _ in range(300):
        friction = 0.4 * speed / (momentum - wind_part(wind_height / length) + wind_part(roughness / length))
        scale = 0.4 * warmer / (heat - heat_part(air_height / length) + heat_part(heat_roughness / length))
        length = -np.sqrt(length * -(friction**2) * AIR / (0.4 * GRAVITY * scale))
    return friction * scale * momentum * heat / (0.16 * speed * warmer)


@pytest.mark.parametrize("roughness", [5e-4, 5e-3, 2e-2])
@pytest.mark.parametrize("speed", [1.0, 3.0, 6.0])
@pytest.mark.parametrize("warmer", [2.0, 8.0, 20.0])
def test_unstable_air(roughness, speed, warmer):
    """From a hundredth more exchange than in neutral air to three times as much."""
    found = Stability.of(Wind(speed), AIR, 1.0, roughness).factor(np.array([warmer]))
    assert found == pytest.approx(unstable_factor(np.hypot(speed, 0.1), warmer, roughness), rel=0.09)


def test_neutral_air_and_faces_that_look_down_have_the_neutral_coefficient():
    assert Stability.of(Wind(3.0), AIR, 1.0, 0.01).factor(np.zeros(1)) == 1
    assert np.all(Stability.of(Wind(3.0), AIR, [[-1.0]], 0.01).factor(np.array([[-9.0, 9.0]])) == 1)


def test_stability_fades_linearly_from_walls_to_hanging_faces():
    cosine = np.cos(np.radians([[0.0], [90.0], [120.0], [150.0]]))
    level, wall, *hanging = Stability.of(Wind(3.0), AIR, cosine, 0.01).factor(np.array([[-9.0, 9.0]] * 4)) - 1
    assert np.allclose(level, wall) and np.all(np.abs(level) > 0.2)
    assert np.allclose(hanging, np.array([[2 / 3], [1 / 3]]) * level)


@given(st.floats(-40, 60), st.floats(0, 40), st.floats(1e-5, 1), st.floats(-1, 1))
@settings(max_examples=100, deadline=None)
def test_slope_is_the_derivative(difference, speed, roughness, upward):
    stability = Stability.of(Wind(speed), AIR, upward, roughness)
    step = 1e-4 * max(abs(difference), 1e-3)  # the root bends at 0: not within a hundred steps of it
    around = difference + step * np.array([-1.0, 0.0, 1.0])
    low, middle, high = stability.factor(around)
    same, slopes = stability.factor_and_slope(around)
    slope = slopes[1]
    assert np.allclose(same, [low, middle, high], rtol=1e-14)
    if abs(difference) > 100 * step:
        assert slope == pytest.approx((high - low) / (2 * step), rel=1e-3, abs=1e-6)
    assert 0 <= middle < np.inf


def test_the_slope_is_continuous_where_the_sign_turns():
    stability = Stability.of(Wind(3.0), AIR, 1.0, 0.01)
    colder, warmer = stability.factor_and_slope(np.array([-1e-9, 1e-9]))[1]
    assert colder == pytest.approx(warmer, rel=1e-3) and colder > 0


def test_calm_and_storm_are_finite():
    difference = np.array([-80.0, -1e-12, 0.0, 1e-12, 500.0])
    for speed in (0.0, 1e4):
        stability = Stability.of(Wind(speed), AIR, 1.0, 0.01)
        assert np.all(np.isfinite(stability.factor_and_slope(difference)))


def test_strong_wind_is_neutral():
    """At 30 m/s ten kelvin change the exchange by less than a twenty-fifth."""
    found = Stability.of(Wind(30.0), AIR, 1.0, 0.01).factor(np.array([-10.0, 10.0]))
    assert found == pytest.approx(1.0, abs=0.04)
