"""Lines of sight against closed forms, published refraction and air mass, and their own reverse."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.schemas.errors import InputError

RADIUS = geometry.EARTH_RADIUS


@pytest.fixture(scope="module")
def state():
    return AtmosphericState.from_profile("us_standard")


@pytest.fixture(scope="module")
def shells(state):
    return geometry.Shells.of(state.altitude, state.number_density, 1e4 / 0.55)


@pytest.fixture(scope="module")
def straight(state):
    """Air so thin that it does not refract."""
    return geometry.Shells.of(state.altitude, state.number_density * 1e-12, 1e4 / 0.55)


def air(rays):
    return np.sum(rays.lower + rays.upper, axis=1)


def until(rays, row, distance):
    """Air up to a distance, and the altitude, central angle and direction there."""
    node = np.searchsorted(rays.distance[row], distance)
    column = np.sum((rays.lower + rays.upper)[row, :node])
    return column, rays.altitude[row, node], rays.central_angle[row, node], rays.direction[row, node]


def test_refraction_at_the_horizon_agrees_with_the_almanac(shells):
    bending = geometry.departure_angle(geometry.trace(shells, np.zeros(1), np.zeros(1)))[0] - np.pi / 2
    assert np.degrees(bending) * 60 == pytest.approx(34, abs=1.5)  # arc minutes; almanacs take 34


@pytest.mark.parametrize("altitude", [5.0, 10.0, 20.0, 45.0, 80.0])
def test_refraction_above_the_horizon(shells, altitude):
    # Bennett 1982, J. Navigation 35, 255: for 10 C and 1010 hPa, apparent altitudes.
    bennett = 1 / np.tan(np.radians(altitude + 7.31 / (altitude + 4.4))) * (1013.25 / 1010) * (283 / 288.15)
    elevation = np.radians([altitude])
    bending = geometry.departure_angle(geometry.trace(shells, np.zeros(1), elevation))[0] - (np.pi / 2 - elevation[0])
    assert np.degrees(bending) * 60 == pytest.approx(bennett, abs=0.1)


@pytest.mark.parametrize(
    ("elevation", "tolerance"), [(90, 1e-3), (60, 1e-3), (30, 1e-3), (10, 1e-3), (5, 2e-3), (1, 2e-3), (0, 0.01)]
)
def test_air_mass_agrees_with_kasten_and_young(shells, elevation, tolerance):
    # Kasten and Young 1989, Appl. Opt. 28, 4735, equation (3).
    expected = 1 / (np.sin(np.radians(elevation)) + 0.50572 * (elevation + 6.07995) ** -1.6364)
    slant, zenith = air(geometry.trace(shells, np.zeros(2), np.radians([elevation, 90.0])))
    assert slant / zenith == pytest.approx(expected, rel=tolerance)


def test_paths_without_refraction_are_straight_chords(straight):
    top = RADIUS + straight.top
    altitude, elevation = np.array([0.0, 0.0, 20e3, 700e3]), np.radians([0.0, 35.0, -2.0, -25.0])
    rays = geometry.trace(straight, altitude, elevation)
    radius, sine = RADIUS + altitude, np.sin(elevation)
    expected = -radius * sine + np.sqrt(top**2 - (radius * np.cos(elevation)) ** 2)
    assert rays.end == pytest.approx(expected, rel=1e-9)
    assert not rays.ground.any()
    assert rays.direction == pytest.approx(
        np.broadcast_to((np.pi / 2 - elevation)[:, None], rays.direction.shape), abs=1e-12
    )
    assert rays.distance[3, 0] == pytest.approx(
        -radius[3] * sine[3] - np.sqrt(top**2 - (radius[3] * np.cos(elevation[3])) ** 2)
    )
    # The lowest point of a straight line of sight.
    assert rays.altitude[2].min() == pytest.approx(radius[2] * np.cos(elevation[2]) - RADIUS, abs=1e-3)


def test_altitudes_and_central_angles_of_a_straight_line(straight):
    ranges = np.geomspace(1.0, 900e3, 12)
    altitude, elevation = 3e3, np.radians(-1.2)
    rays = geometry.trace(straight, np.array([altitude]), np.array([elevation]), ranges[None])
    for distance in ranges:
        if distance > rays.end[0]:
            continue
        _, height, angle, _ = until(rays, 0, distance)
        across, up = distance * np.cos(elevation), RADIUS + altitude + distance * np.sin(elevation)
        assert height == pytest.approx(np.hypot(across, up) - RADIUS, abs=0.02)
        assert angle == pytest.approx(np.arctan2(across, up), abs=1e-8)


@pytest.mark.parametrize(
    ("altitude", "elevation", "distance"),
    [
        (2e3, -1.0, 37e3),
        (10e3, -3.0, 120e3),
        (50e3, -7.0, 1500e3),
        (1500.0, -0.3, 50e3),
        (0.0, 0.0, 100e3),
        (0.0, 90.0, 30e3),
        (30e3, -90.0, 29e3),
    ],
)
def test_the_same_path_from_either_end(shells, altitude, elevation, distance):
    there = geometry.trace(shells, np.array([altitude]), np.radians([elevation]), np.array([[distance]]))
    column, height, angle, direction = until(there, 0, distance)
    back = geometry.trace(shells, np.array([height]), np.array([direction - angle - np.pi / 2]), np.array([[distance]]))
    returned, start, *_ = until(back, 0, distance)
    assert returned == pytest.approx(column, rel=1e-6)
    assert start == pytest.approx(altitude, abs=1e-3)


def test_ranges_do_not_change_the_air(shells):
    altitude, elevation = np.array([0.0, 12e3, 700e3]), np.radians([0.5, -3.0, -24.0])
    plain = geometry.trace(shells, altitude, elevation)
    cut = geometry.trace(shells, altitude, elevation, np.tile(np.geomspace(1e-3, 5e6, 30), (3, 1)))
    assert air(cut) == pytest.approx(air(plain), rel=1e-7)
    assert cut.end == pytest.approx(plain.end, rel=1e-12)


def test_air_of_short_horizontal_paths_is_density_times_length(state, shells):
    for altitude in (0.0, 250.0, 1234.0, 30e3):
        density = np.exp(np.interp(altitude, state.altitude, np.log(state.number_density)))
        rays = geometry.trace(shells, np.array([altitude]), np.zeros(1), np.array([[1e-3, 1.0, 100.0]]))
        for distance in (1e-3, 1.0, 100.0):
            assert until(rays, 0, distance)[0] == pytest.approx(density * distance, rel=1e-6)


def test_rays_end_at_the_ground_or_leave(shells):
    altitude = np.array([0.0, 0.0, 1e3, 1e3, 100e3, 100e3, 700e3, 700e3])
    elevation = np.radians([-0.001, 0.0, -90.0, -0.5, -11.0, -9.0, -80.0, 10.0])
    rays = geometry.trace(shells, altitude, elevation)
    assert rays.ground.tolist() == [True, False, True, False, True, False, True, False]
    assert rays.end[0] == 0.0
    assert rays.end[2] == pytest.approx(1e3, rel=1e-9)
    assert air(rays)[-1] == 0.0
    assert np.all(np.diff(rays.distance, axis=1) >= 0)
    for name in ("altitude", "central_angle", "direction", "lower", "upper"):
        assert np.all(np.isfinite(getattr(rays, name))), name


def test_a_source_straight_ahead_is_not_deflected(shells):
    rays = geometry.trace(shells, np.array([5e3]), np.radians([30.0]))
    cosine = geometry.scattering_cosine(rays, np.radians([30.0, -30.0]), np.radians([0.0, 180.0]))
    assert np.degrees(np.arccos(np.minimum(cosine[0, 0], 1.0))) == pytest.approx([0.0, 180.0], abs=1e-4)


def test_strong_gradients_do_not_trap_a_ray():
    altitude = np.array([0.0, 10.0, 100.0, 1e3, 100e3])
    density = np.array([2.55e25, 1.0e25, 0.9e25, 0.8e25, 1e19])
    rays = geometry.trace(geometry.Shells.of(altitude, density, 1e3), np.zeros(3), np.radians([0.0, 0.01, 1.0]))
    assert np.all(np.isfinite(rays.end)) and not rays.ground.any()


@pytest.mark.parametrize(
    ("altitude", "elevation", "ranges", "message"),
    [
        (-10.0, 0.0, None, "below the ground"),
        (0.0, 2.0, None, "elevations"),
        (0.0, 0.0, [[-1.0]], "ranges"),
        (0.0, 0.0, [[np.nan]], "ranges"),
        (np.nan, 0.0, None, "altitude"),
    ],
)
def test_impossible_lines_of_sight_are_refused(shells, altitude, elevation, ranges, message):
    with pytest.raises(InputError, match=message):
        geometry.trace(shells, np.array([altitude]), np.array([elevation]), ranges)


def test_refractivity_of_standard_air():
    assert geometry.refractivity(1e4 / 0.633) == pytest.approx(2.7652e-4, rel=2e-4)  # Ciddor 1996, 15 C, 1013.25 hPa
    assert geometry.refractivity(1000.0) == pytest.approx(2.726e-4, rel=1e-3)
