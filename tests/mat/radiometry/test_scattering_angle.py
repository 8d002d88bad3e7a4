"""Scattering angles against spherical trigonometry known otherwise."""

import numpy as np
import pytest

from skyshine.mat.radiometry.scattering_angle import azimuth_at, scattering_angle


@pytest.mark.parametrize(
    "line, source, azimuth, angle",
    [
        (10, 10, 0, 0),
        (0, 0, 35, 35),
        (90, 20, 77, 70),
        (30, -10, 0, 40),
        (30, -10, 180, 160),
        (0, 90, 12, 90),
        (-90, 90, 0, 180),
        (45, 45, 90, 60),
    ],
)
def test_angles_of_known_directions_are_exact(line, source, azimuth, angle):
    assert scattering_angle(line, source, azimuth) == pytest.approx(angle, abs=1e-6)


def test_small_angles_keep_their_digits():
    assert scattering_angle(20.0, 20.0 + 1e-7, 0.0) == pytest.approx(1e-7, rel=1e-6)


def test_azimuth_and_angle_lead_back_to_each_other():
    draw = np.random.default_rng(4)
    line, source, azimuth = draw.uniform(-89, 89, 500), draw.uniform(-89, 89, 500), draw.uniform(1, 179, 500)
    angle = scattering_angle(line, source, azimuth)
    found, rest = azimuth_at(*np.radians([line, source, angle]))
    np.testing.assert_allclose(np.degrees(found), azimuth, atol=1e-4)
    assert np.abs(rest).max() < 1e-6


def test_angles_out_of_reach_take_the_nearest_azimuth_and_state_the_excess():
    azimuth, rest = azimuth_at(*np.radians([[10.0, 10.0, 90.0], [40.0, 40.0, 20.0], [5.0, 170.0, 75.0]]))
    np.testing.assert_allclose(np.degrees(azimuth[:2]), [0, 180], atol=1e-6)
    np.testing.assert_allclose(np.degrees(rest), [5 - 30, 170 - 130, 75 - 70], atol=1e-6)
