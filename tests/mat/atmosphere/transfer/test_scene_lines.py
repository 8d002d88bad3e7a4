"""Lines of sight that look as scenes do."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells, trace
from skyshine.mat.atmosphere.transfer.scene_lines import LOWEST_KM, SceneLines
from skyshine.mat.quantities.grid import PathGrid

LEVELS = np.linspace(0.0, 100e3, 101)
SHELLS = Shells.of(LEVELS, 2.5e25 * np.exp(-LEVELS / 8e3), 1000.0)
RANGES = np.concatenate([[0.0], np.geomspace(1e-3, 1000.0, 19)])
BASE = PathGrid(RANGES, [0.0, 1.0, 10.0, 40.0], np.linspace(-90, 90, 13), [-5.0, 60.0], [0.0, 180.0])


def drawn(base=BASE, count=3000, shells=SHELLS):
    return SceneLines.drawn(shells, base, count, np.random.default_rng(5))


def test_a_third_and_more_ends_on_the_ground_exactly():
    lines = drawn()
    rays = trace(SHELLS, lines.altitude_km * 1e3, np.radians(lines.elevation_deg))
    assert 1 / 3 < lines.on_ground.mean() < 0.7
    np.testing.assert_allclose(lines.range_km[lines.on_ground, -1], rays.end[lines.on_ground] / 1e3, rtol=1e-12)
    # No range lies behind the ground, and all increase.
    behind = lines.range_km * 1e3 > rays.end[:, None] * (1 + 1e-9)
    assert not behind[rays.ground & lines.on_ground].any() and np.all(np.diff(lines.range_km, axis=1) >= 0)


def test_lines_to_the_ground_are_even_in_solid_angle_and_in_the_logarithm_of_range():
    """On a flat Earth, with the cells of the axes apart: of two equal parts of the sphere, and of two equal parts of
    the logarithm, each has as many lines.
    """
    base = PathGrid(RANGES, [0.0, 5.0], [-90.0, -10.0], [10.0], [0.0])
    lines = drawn(base, 9000)
    # The cells of this grid are one, even in degrees and in altitude: the heights below 100 m are of the others.
    low = lines.on_ground & (lines.altitude_km < 0.1)
    sine, height = np.sin(np.radians(-lines.elevation_deg[low])), lines.altitude_km[low]
    middle = (1 + np.sin(np.radians(10))) / 2
    assert np.mean(sine < middle) == pytest.approx(0.5, abs=0.04)
    assert np.mean(height < np.sqrt(LOWEST_KM * 0.1)) == pytest.approx(0.5, abs=0.05)


def test_lines_pass_the_limb_and_go_up():
    lines = drawn()
    dip = np.degrees(np.arccos(EARTH_RADIUS / (EARTH_RADIUS + lines.altitude_km * 1e3)))
    past = ~lines.on_ground & (lines.elevation_deg < 0) & (lines.elevation_deg > -dip)
    assert past.mean() > 0.12 and np.mean(lines.elevation_deg >= 0) > 0.12


@pytest.mark.parametrize(
    "changed",
    [
        {"altitude_km": [0.0]},
        {"altitude_km": [3.0]},
        {"elevation_deg": [10.0, 90.0]},
        {"elevation_deg": [-30.0]},
        {"range_km": [2.0]},
        {"range_km": [0.5, 4.0], "elevation_deg": [-20.0, -10.0], "altitude_km": [1.0, 2.0]},
    ],
)
def test_lines_stay_on_the_axes_of_a_job(changed):
    base = PathGrid(**{**vars(BASE), **changed})
    lines = drawn(base, 200)
    for name in ("altitude_km", "elevation_deg", "range_km"):
        values, nodes = getattr(lines, name), getattr(base, name)
        assert values.min() >= nodes[0] - 1e-9 and values.max() <= nodes[-1] + 1e-9, name
    assert lines.range_km.shape == (200, max(1, base.range_km.size - 1))


def test_ground_above_the_sea_is_met():
    high = Shells.of(LEVELS[2:], 2.5e25 * np.exp(-LEVELS[2:] / 8e3), 1000.0)
    base = PathGrid(RANGES, [2.0, 12.0], BASE.elevation_deg, [10.0], [0.0])
    lines = drawn(base, 500, high)
    assert lines.on_ground.mean() > 1 / 3 and np.all(lines.altitude_km >= 2.0)
