"""View factors under a horizon, beside those that are known in closed form."""

import numpy as np
import pytest

from skyshine.mat.surface.horizon import ASPECTS, Horizon, Views
from skyshine.schemas.errors import InputError

SLOPES, AZIMUTHS = np.array([0.0, 30.0, 90.0, 90.0, 130.0, 180.0]), np.array([0.0, 20.0, 90.0, 200.0, 310.0, 0.0])


def canyon(left: float, right: float) -> Horizon:
    """Infinite walls to the east and to the west, height over distance `left` and `right`, along a street to the
    north."""
    azimuth = np.arange(0.0, 360.0, 0.5)
    across = np.sin(np.radians(azimuth))
    elevation = np.degrees(np.arctan(np.where(across > 0, right, left) * np.abs(across)))
    return Horizon(tuple(azimuth), tuple(elevation))


def level(horizon: Horizon, sky_view: float = 1.0) -> Views:
    return Views.of(horizon, sky_view, np.zeros(1), np.zeros(1))


@pytest.mark.parametrize("elevation", [0.0, 10.0, 45.0, 80.0, 90.0])
def test_a_basin_leaves_the_level_the_squared_cosine_of_its_rim(elevation):
    """Oke (1987), Boundary Layer Climates, appendix A1: the sky view of the middle of a basin is cos^2."""
    views = level(Horizon((0.0,), (elevation,)))
    assert views.sky[0] == pytest.approx(np.cos(np.radians(elevation)) ** 2, abs=1e-9)
    assert views.walls.sum() == pytest.approx(np.sin(np.radians(elevation)) ** 2, abs=1e-9)


@pytest.mark.parametrize("ratio", [0.2, 1.0, 3.0])
def test_the_middle_of_a_street_has_the_sky_view_of_oke(ratio):
    """Oke (1981), J. Climatol. 1, 237-254: cos(arctan(2 H/W)) on the middle of the floor."""
    views = level(canyon(2 * ratio, 2 * ratio))
    assert views.sky[0] == pytest.approx(np.cos(np.arctan(2 * ratio)), abs=2e-4)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_floor_and_walls_of_a_street_have_the_mean_views_of_crossed_strings(ratio):
    """Of the whole floor sqrt(1 + (H/W)^2) - H/W; of a wall (1 + H/W - sqrt(1 + (H/W)^2)) / (2 H/W): Johnson and Watson
    (1984), J. Clim. Appl. Meteorol. 23, 329-335."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    place, weights = 0.5 * (nodes + 1), 0.5 * weights
    root = np.sqrt(1 + ratio**2)
    floor = sum(w * level(canyon(ratio / x, ratio / (1 - x))).sky[0] for x, w in zip(place, weights, strict=True))
    assert floor == pytest.approx(root - ratio, abs=3e-4)
    wall = sum(
        w * Views.of(canyon(0.0, ratio * z), 1.0, np.array([90.0]), np.array([90.0])).sky[0]
        for z, w in zip(place, weights, strict=True)
    )
    assert wall == pytest.approx((1 + ratio - root) / (2 * ratio), abs=3e-4)


@pytest.mark.parametrize("horizon", [Horizon(), Horizon((0.0,), (35.0,)), canyon(1.0, 4.0), Horizon((0.0,), (90.0,))])
@pytest.mark.parametrize("sky_view", [0.0, 0.3, 1.0])
def test_sky_walls_and_ground_fill_the_half_space_of_every_plane(horizon, sky_view):
    views = Views.of(horizon, sky_view, SLOPES, AZIMUTHS)
    assert views.sky + views.walls.sum(axis=1) + views.ground == pytest.approx(1.0, abs=1e-12)
    assert views.sky.min() >= 0 and views.walls.min() >= 0 and views.ground.min() >= 0
    assert views.ground == pytest.approx(0.5 * (1 - np.cos(np.radians(SLOPES))))


def test_views_agree_with_a_count_of_random_directions():
    """Of two million directions, weighted by the cosine of incidence: within 0.003."""
    generator = np.random.default_rng(1)
    directions = generator.normal(size=(2_000_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    elevation = np.degrees(np.arcsin(directions[:, 2]))
    azimuth = np.degrees(np.arctan2(directions[:, 0], directions[:, 1])) % 360
    horizon = Horizon((0.0, 90.0, 200.0), (10.0, 70.0, 30.0))
    hidden = (elevation > 0) & (elevation <= horizon.at(azimuth))
    views = Views.of(horizon, 1.0, SLOPES, AZIMUTHS)
    for number, (slope, facing) in enumerate(np.radians(np.stack([SLOPES, AZIMUTHS], axis=1))):
        normal = np.array([np.sin(slope) * np.sin(facing), np.sin(slope) * np.cos(facing), np.cos(slope)])
        weight = 4 * np.maximum(directions @ normal, 0) / len(directions)
        assert views.walls[number].sum() == pytest.approx(weight[hidden].sum(), abs=3e-3)
        assert views.sky[number] == pytest.approx(weight[(elevation > 0) & ~hidden].sum(), abs=3e-3)


def test_a_face_to_the_east_sees_walls_that_face_west():
    views = Views.of(Horizon((0.0,), (40.0,)), 1.0, np.array([90.0]), np.array([90.0])).walls[0]
    assert ASPECTS[np.argmax(views)] == 270.0
    assert views[ASPECTS == 90.0] == 0.0
    assert views[ASPECTS == 225.0] == pytest.approx(views[ASPECTS == 315.0], rel=1e-9)


def test_what_hides_part_of_the_sky_stands_on_all_sides_alike():
    views = level(Horizon(), 0.25)
    assert views.sky[0] == pytest.approx(0.25, abs=1e-12)
    assert views.walls[0] == pytest.approx(0.75 / 8, abs=1e-9)


def test_the_sun_is_hidden_up_to_the_horizon_and_nowhere_on_a_level_one():
    horizon = Horizon((0.0, 90.0, 180.0, 270.0), (0.0, 30.0, 0.0, 90.0))
    assert horizon.hides(np.array([29.9, 30.0, 30.1, 89.0, 90.0]), np.array([90.0, 90, 90, 270, 270])).tolist() == [
        True,
        True,
        False,
        True,
        True,
    ]
    assert not horizon.hides(np.array([-20.0, 0.0]), np.array([0.0, 180.0])).any()
    assert horizon.at(np.array([315.0])) == pytest.approx(45.0)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "message"),
    [
        ((), (), "found 0 azimuths"),
        ((0.0, 90.0), (1.0,), "found 2 azimuths and 1 elevations"),
        ((90.0, 0.0), (1.0, 1.0), "allowed: 0 to below 360 degree, ascending"),
        ((0.0, 360.0), (1.0, 1.0), "allowed: 0 to below 360 degree"),
        ((0.0,), (91.0,), "allowed: 0 to 90 degree"),
        ((0.0,), (float("nan"),), "allowed: 0 to 90 degree"),
    ],
)
def test_impossible_horizons_are_refused(azimuth, elevation, message):
    with pytest.raises(InputError, match=message):
        Horizon(azimuth, elevation)
