"""The coordinates of lines of sight: known geometry, and nodes that come back."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells, trace
from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.quantities.channels.nodes import SCATTERING_ANGLES, SOURCE_ELEVATIONS, ChannelNodes, NodeCounts
from skyshine.mat.quantities.channels.source_parts import SKY_ELEVATIONS
from skyshine.mat.quantities.channels.surface_light import ABOVE_RISE, TARGET_HEIGHTS

HEIGHTS = np.linspace(0.0, 40 ** (1 / 3), 12)


def shells(density: float, ground: float = 0.0) -> Shells:
    """Air whose density falls by e in 8 km."""
    altitude = ground + np.linspace(0.0, 100e3, 201)
    return Shells.of(altitude, density * np.exp(-altitude / 8e3), 1000.0)


EMPTY = RayCoordinates.of(shells(1.0), HEIGHTS)
AIR = RayCoordinates.of(shells(2.5e25), HEIGHTS)


def test_without_air_the_horizon_is_that_of_a_sphere():
    assert EMPTY.effective_radius == pytest.approx(EARTH_RADIUS / 1e3, rel=1e-6)
    height, radius = 2.0, EARTH_RADIUS / 1e3
    dip = np.degrees(np.arccos(radius / (radius + height)))
    inside, outside = EMPTY.locate(1.0, height, [-dip - 1e-4, -dip + 1e-4]).to_ground
    assert inside and not outside
    grazing = EMPTY.locate(1.0, height, -dip - 1e-9)
    assert grazing.ground_distance == pytest.approx(np.sqrt(2 * radius * height + height**2), rel=1e-3)
    assert grazing.direction == pytest.approx(1.0, abs=1e-3)


def test_refraction_widens_the_earth_by_its_gradient():
    # A horizontal ray bends with the gradient of n: the Earth looks as if its radius were R / (1 - R |dn/dz|).
    gradient = 2.73e-4 * 2.5e25 / 2.546899e25 / 8e3
    assert AIR.effective_radius[0] == pytest.approx(EARTH_RADIUS / 1e3 / (1 - EARTH_RADIUS * gradient), rel=0.01)


@pytest.mark.parametrize("elevation", [-90.0, -30.0, -2.0, -1.5])
def test_the_distance_to_the_ground_is_that_of_a_traced_ray(elevation):
    air = shells(2.5e25)
    end = trace(air, np.array([1.5e3]), np.radians([elevation])).end[0] / 1e3
    assert AIR.locate(1.0, 1.5, elevation).ground_distance == pytest.approx(end, rel=3e-3)


@pytest.mark.parametrize("direction", [0.0, 0.2, 0.9, 2.3, 2.99, 3.0, 3.4, 4.0])
@pytest.mark.parametrize("rays", [EMPTY, AIR], ids=["vacuum", "air"])
def test_nodes_come_back(rays, direction):
    share = np.array([0.1, 0.5, 0.99])
    for root in HEIGHTS[1:]:
        elevation, ranges, length = rays.line(float(root), direction, share)
        places = rays.locate(ranges, root**3 + rays.ground_km, elevation)
        assert places.direction == pytest.approx(direction, abs=2e-5)
        assert places.share == pytest.approx(share, abs=1e-6)
        assert places.length == pytest.approx(length, rel=1e-6)
        assert places.height_root == pytest.approx(root)


def test_straight_down_the_share_is_that_of_the_height():
    places = AIR.locate([0.0, 0.5, 2.0, 3.0], 2.0, -90.0)
    assert places.share == pytest.approx([0.0, 0.25, 1.0, 1.0])
    assert places.end_height == pytest.approx([2.0, 1.5, 0.0, 0.0], abs=1e-9)
    assert places.length == pytest.approx([0.0, 0.5, 2.0, 3.0])
    assert places.direction == pytest.approx(0.0, abs=1e-9)


def test_the_end_of_a_path_stands_where_a_circle_has_it():
    height, reach, up = 1.0, 50.0, np.radians(3.0)
    radius = EMPTY.radius_at(1.0)
    end = np.sqrt((radius + height) ** 2 + reach**2 + 2 * (radius + height) * reach * np.sin(up)) - radius
    assert EMPTY.locate(reach, height, 3.0).end_height == pytest.approx(end, rel=1e-9)


def test_ends_of_all_axes_are_finite_and_inside():
    ranges = np.array([0.0, 1e-9, 1e-3, 1.0, 1e3, 1e5])[:, None, None]
    altitude = np.array([-1.0, 0.0, 1e-6, 1.0, 40.0, 1e3])[:, None]
    elevation = np.array([-90.0, -1e-9, 0.0, 1e-9, 90.0])
    places = AIR.locate(ranges, altitude, elevation)
    for name in ("share", "height_root", "direction", "length", "end_height"):
        assert np.all(np.isfinite(getattr(places, name))), name
    assert np.all((places.share >= 0) & (places.share <= 1))
    assert np.all((places.direction >= 0) & (places.direction <= 4))
    assert not np.any((places.direction > 1 + 1e-9) & (places.direction < 2))
    assert np.all(places.end_height >= 0)


def test_length_grows_with_range_up_to_an_end():
    ranges = np.geomspace(1e-3, 1e4, 50)
    up = AIR.locate(ranges, 0.1, 5.0)
    assert np.all(np.diff(up.length) > 0) or np.all(np.diff(up.length) >= 0)
    assert up.length[-1] < 200
    assert np.all(np.diff(up.share) >= 0)


@pytest.mark.parametrize("counts", [NodeCounts(), NodeCounts(2, 2, 2, 3, 2)])
def test_nodes_reach_straight_down_the_level_and_straight_up(counts):
    nodes = ChannelNodes.of(counts, (0.0, 12.0))
    down, horizon, level, up = nodes.direction[[0, counts.ground - 1, counts.ground + counts.limb - 1, -1]]
    assert (down, horizon, level, up) == (0.0, 1.0, 3.0, 4.0)  # the pages of the format say so
    assert AIR.locate(1.0, 2.0, [-90.0, 0.0, 90.0]).direction.tolist() == [down, level, up]
    assert np.all(np.diff(nodes.direction) > 0) and np.all(np.diff(nodes.share) > 0)


@pytest.mark.parametrize("nodes", [TARGET_HEIGHTS, ABOVE_RISE, SOURCE_ELEVATIONS, SCATTERING_ANGLES, SKY_ELEVATIONS])
def test_nodes_of_light_increase(nodes):
    assert np.all(np.diff(nodes) > 0)


def test_heights_count_from_a_ground_above_the_sea():
    raised = RayCoordinates.of(shells(1.0, ground=1500.0), HEIGHTS)
    assert raised.ground_km == 1.5
    assert raised.locate(1.0, 3.5, -90.0).share == pytest.approx(0.5)  # of the two km to the ground
    assert raised.effective_radius == pytest.approx(EARTH_RADIUS / 1e3 + 1.5, rel=1e-6)
