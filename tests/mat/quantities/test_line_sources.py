"""Sources of a line of sight: scattering angles by the geometry of the sky, and angles that no azimuth gives."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.geometry import Shells, trace
from skyshine.mat.quantities.line_sources import LineSources

LEVELS = np.linspace(0.0, 100e3, 101)
VACUUM = Shells.of(LEVELS, np.full(LEVELS.size, 1.0), 1000.0)


def radians(*degrees):
    return np.radians(degrees)


def test_scattering_angle_at_the_observer():
    """Looking at the source, away from it, across, and up to a source on the horizon."""
    sources = LineSources.at(radians(30, -30, 0, 0), radians(0, 180, 90, 0))
    found = np.degrees(np.arccos(np.clip(sources.local_deflection(np.radians(30)), -1, 1)))
    assert found == pytest.approx([0, 180, 90, 30], abs=1e-5)


def test_pairs_run_over_the_last_axis_first():
    sources = LineSources.of_axes(radians(10, 20), radians(0, 90, 180))
    assert np.degrees(sources.elevation) == pytest.approx([10, 10, 10, 20, 20, 20])
    assert np.degrees(sources.azimuth) == pytest.approx([0, 90, 180] * 2) and not np.any(sources.excess)


@pytest.mark.parametrize("line", [-90.0, -35.0, 0.0, 12.0, 90.0])
def test_every_scattering_angle_is_kept_at_the_observer(line):
    """Also those that no azimuth of such a source gives: the rest is an excess."""
    angles = np.linspace(0.0, np.pi, 13)
    up, away = (part.ravel() for part in np.meshgrid(radians(-20, 0, 50), angles, indexing="ij"))
    sources = LineSources.at_angle(np.radians(line), up, away)
    found = np.arccos(np.clip(sources.local_deflection(np.radians(line)), -1.0, 1.0))
    # The cosine resolves angles near 0 and 180 degrees to 1e-8 of a radian.
    assert found == pytest.approx(np.tile(angles, 3), abs=1e-7)


def test_only_impossible_angles_have_an_excess():
    """A source at 50 degrees is 20 to 100 degrees from a line of sight at 30."""
    sources = LineSources.at_angle(np.radians(30), np.radians(np.full(6, 50.0)), radians(0, 10, 20, 60, 100, 130))
    assert np.degrees(sources.excess) == pytest.approx([-20, -10, 0, 0, 0, 30], abs=1e-6)


def test_angles_along_a_straight_line_stay_while_zenith_angles_turn_with_the_earth():
    rays = trace(VACUUM, np.array([0.0]), np.radians([0.0]), np.array([[0.0, 200e3]]))
    sources = LineSources.at(radians(0, 90, 40), radians(0, 0, 70))
    deflection, zenith = sources.deflection(rays), sources.to_source(rays)
    assert deflection[0] == pytest.approx([1, 0, np.cos(np.radians(40)) * np.cos(np.radians(70))], abs=1e-9)
    np.testing.assert_allclose(deflection, np.broadcast_to(deflection[0], deflection.shape), atol=1e-9)
    # 200 km along the tangent the Earth has turned by atan(200 / 6371) = 1.798 degrees: so high stands the source.
    end = np.argmin(np.abs(rays.distance[0] - 200e3))
    assert np.degrees(np.arcsin(zenith[end, 0])) == pytest.approx(1.798, abs=5e-3)
    assert zenith[0] == pytest.approx(np.sin(radians(0, 90, 40)), abs=1e-9)


def test_an_excess_turns_the_whole_line():
    rays = trace(VACUUM, np.array([0.0]), np.radians([30.0]), np.array([[0.0, 50e3]]))
    sources = LineSources.at_angle(np.radians(30), radians(50, 50), radians(5, 60))
    angle = np.degrees(np.arccos(sources.deflection(rays)))
    np.testing.assert_allclose(angle, np.broadcast_to([5.0, 60.0], angle.shape), atol=1e-5)
