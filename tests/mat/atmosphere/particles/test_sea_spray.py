"""Drops of spray by wind and height."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.sea_spray import fall_speed, sea_spray


def test_amount_at_ten_metres_is_the_flux_over_the_fall():
    """Smith et al. 1993 with Stokes' law has a closed integral: growth by humidity cancels."""
    for wind, humidity in ((5.0, 60.0), (12.0, 80.0), (25.0, 97.0)):
        friction = 0.04 * wind
        at_14 = wind + friction / 0.4 * np.log(1.4)
        flux = 10 ** (0.959 * np.sqrt(at_14) - 1.476) * 9.2 * np.sqrt(np.pi / 3.3) * np.exp(1 / (4 * 3.3))
        expected = 2.1 * np.pi * flux / (2 * 1030 * 9.80665 / (9 * 1.8e-5))
        assert sea_spray(wind, friction, humidity).extinction_550([10.0])[0] == pytest.approx(expected, rel=0.01)


def test_drops_fall_as_stokes_says():
    """A drop of 10 um radius falls at 1.2 cm/s (Pruppacher and Klett 1997, table 10.1: 0.0121 m/s of water)."""
    assert fall_speed(np.array([10e-6]))[0] == pytest.approx(0.0121, rel=0.05)


def test_more_drops_low_down_and_in_wind():
    height = np.array([0.5, 1.0, 2.0, 10.0, 50.0, 300.0])
    for wind in (0.0, 3.0, 10.0, 34.0, 60.0):
        extinction = sea_spray(wind, max(0.035 * wind, 0.01), 80.0).extinction_550(height)
        assert np.all(np.diff(extinction) <= 0) and np.all(np.isfinite(extinction)) and extinction[0] > 0
    amounts = [sea_spray(wind, 0.04 * wind, 80.0).extinction_550([10.0])[0] for wind in (2.0, 5.0, 10.0, 20.0)]
    assert np.all(np.diff(amounts) > 0)
    # 10 m/s, drops of 12 um: (1 / 10)^(-0.0185 / 0.16) = 1.3 times as much at 1 m.
    layer = sea_spray(10.0, 0.4, 80.0).extinction_550([1.0, 10.0])
    assert 1.15 < layer[0] / layer[1] < 1.4


def test_none_above_the_mixed_layer():
    assert sea_spray(10.0, 0.4, 80.0).extinction_550([620.0])[0] == 0


def test_winds_beyond_the_measurements_make_no_more_drops_at_ten_metres():
    amounts = [sea_spray(wind, 1.2, 80.0).extinction_550([10.0])[0] for wind in (28.0, 30.0, 35.0, 60.0)]
    assert amounts[0] < amounts[1] == pytest.approx(amounts[2]) == pytest.approx(amounts[3])
