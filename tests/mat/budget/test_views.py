"""Random views: directions by their geometry, every coordinate on the axes of the tables, the same from a seed."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells
from skyshine.mat.budget import views as views_module
from skyshine.mat.budget.views import (
    BEND_DEG,
    FACES_M,
    FACES_OF_A_PLACE,
    OBSERVERS_KM,
    direction,
    fold,
    on_axes,
    random_views,
    slope_and_azimuth,
)
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.grid import PathGrid

LEVELS = np.linspace(0.0, 100e3, 101)
SHELLS = Shells.of(LEVELS, 2.55e25 * np.exp(-LEVELS / 8e3), 1000.0)
GRID = PathGrid([0.1, 20.0], [0.05, 1.0], [-90.0, -5.0, 5.0], [-20.0, 70.0], [0.0, 120.0])
NEAR_GRID = PathGrid([1e-3, 20.0], [0.0, 1.0], [-90.0, 90.0], [-20.0, 70.0], [0.0, 180.0])
AXES = {
    "altitude": np.array([0.0, 0.4]),
    "azimuth": np.array([0.0, 120.0, 240.0]),
    "slope": np.array([0.0, 90.0]),
    "time": np.array([6.0, 12.0]),
}


@pytest.fixture(scope="module")
def job(small_job):
    return load_job(small_job).trimmed


@pytest.fixture(scope="module")
def views(job):
    return random_views(job, "sun", GRID, AXES, SHELLS, 300, 4)


def test_azimuth_differences_fold_onto_half_a_turn():
    assert fold([0, 90, 180, 190, 350, -10, 540, 725]) == pytest.approx([0, 90, 180, 170, 10, 10, 180, 5], abs=1e-12)


def test_directions_are_east_north_and_up():
    expected = [[0, 1, 0], [1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0.5**0.5, -(0.5**0.5)]]
    np.testing.assert_allclose(direction([0, 0, 0, 90, -45], [0, 90, 180, 33, 0]), expected, atol=1e-15)


def test_slope_and_azimuth_of_a_normal():
    slope, azimuth = slope_and_azimuth(
        np.array([[0, 0, 1.0], [0, -1, 0], [-1, 0, 0], [1, 1, 2**0.5], [0, 0, -1]]) / 1.0
    )
    assert slope[[0, 1, 2, 4]] == pytest.approx([0, 90, 90, 180])
    assert azimuth[1:4] == pytest.approx([180, 270, 45])


def test_normals_off_the_axes_are_tilted_onto_them():
    axes = {"slope": np.array([10.0, 60.0]), "azimuth": np.array([0.0, 180.0])}
    given = direction([0.0, 45.0, 90.0], [100.0, 200.0, 0.0])
    slope, azimuth = slope_and_azimuth(on_axes(given, axes))
    assert slope == pytest.approx([60.0, 45.0, 10.0]) and azimuth[:2] == pytest.approx([100.0, 200.0])
    one = axes | {"azimuth": np.array([270.0])}
    assert slope_and_azimuth(on_axes(given, one))[1] == pytest.approx([270.0] * 3)


def test_every_coordinate_lies_on_the_axes(views):
    assert len(views) == 300
    for values, nodes in (
        (views.range, GRID.range_km),
        (views.altitude, GRID.altitude_km),
        (views.elevation, GRID.elevation_deg),
        (np.maximum(views.source_elevation, -20.0), GRID.source_elevation_deg),
        (views.lines.source_azimuth, GRID.source_azimuth_deg),
        (views.surface_altitude, AXES["altitude"]),
        (slope_and_azimuth(views.normal)[0], AXES["slope"] + [-1e-6, 1e-6]),
        (views.face, FACES_M),
        (views.share, (0.0, 1.0)),
        (np.degrees(views.bend), (0.0, BEND_DEG)),
    ):
        assert nodes[0] <= values.min() and values.max() <= nodes[-1]
        assert np.ptp(values) > 0
    assert np.all((views.altitude >= views.surface_altitude) | views.near)


def test_drones_aircraft_and_satellites_look_where_the_table_reaches(job):
    """Three views in eight, in equal parts; those of aircraft and satellites end on the ground too."""
    high = PathGrid([1e-3, 5000.0], [0.01, 1500.0], [-90.0, 90.0], [-20.0, 70.0], [0.0, 180.0])
    views = random_views(job, "sun", high, AXES, SHELLS, 800, 4)
    height = views.altitude - views.surface_altitude
    share = {
        name: np.mean(~views.near & (height >= low) & (height <= top)) for name, (low, top) in OBSERVERS_KM.items()
    }
    assert min(share.values()) > 0.08, share
    low = PathGrid([1e-3, 20.0], [0.01, 0.4], [-90.0, 90.0], [-20.0, 70.0], [0.0, 180.0])
    views = random_views(job, "sun", low, AXES, SHELLS, 400, 4)
    assert views.height[~views.near].max() <= 0.4


def test_the_sun_is_seen_at_all_hours_and_the_moon_above_the_horizon(job, views):
    """A day of the subtropics in June is a little longer than its night."""
    assert 0.42 < np.mean(views.source_elevation > 0) < 0.7  # of 75 places
    moon = random_views(job, "moon", GRID, AXES, SHELLS, 40, 4)
    assert len(moon) == 40 and np.all(moon.source_elevation > 0)


def test_faces_of_a_place_share_its_time_and_altitude(views):
    """Under one sky: at most so many that the light around them is computed once."""
    hours, counts = np.unique(views.time, return_counts=True)
    assert counts.max() == FACES_OF_A_PLACE and counts.mean() > 2
    assert all(np.ptp(views.surface_altitude[views.time == hour]) == 0 for hour in hours)


def test_some_views_are_from_nearby(job, views):
    """A quarter of the candidates; in this grid observers are 50 m up, which leaves few of them."""
    near = random_views(job, "sun", NEAR_GRID, AXES, SHELLS, 200, 4).near
    assert 0.1 < near.mean() < 0.4 and views.near.mean() < near.mean()


def test_a_face_is_seen_from_its_front_and_lies_in_its_plane(views):
    assert np.all(np.sum(views.normal * views.to_observer, axis=1) > 0)
    assert np.sum(views.normal * views.along, axis=1) == pytest.approx(np.zeros(300), abs=1e-12)
    assert np.linalg.norm(views.along, axis=1) == pytest.approx(np.ones(300))


def test_lines_end_at_the_altitude_of_the_surface_or_on_the_ground(views):
    """The straight line, by the cosine rule; refraction shortens it at most, by the ground."""
    start, rise = EARTH_RADIUS * 1e-3 + views.altitude, np.sin(np.radians(views.elevation))
    end = np.sqrt(start**2 + views.range**2 + 2 * start * views.range * rise) - EARTH_RADIUS * 1e-3
    ended = np.abs(end - views.surface_altitude) < 1e-6
    assert ended.mean() > 0.9 and np.all(end[~ended] > views.surface_altitude[~ended])
    assert np.all(end[~ended] < 0.02)


def test_a_seed_gives_the_same_views_again_and_another_gives_others(job, views):
    again, other = (random_views(job, "sun", GRID, AXES, SHELLS, 300, seed) for seed in (4, 5))
    assert np.array_equal(again.heading, views.heading) and not np.any(np.isin(other.heading, views.heading))


def test_some_of_the_views_are_those_that_were_chosen(views):
    some = views.take(np.array([7, 3]))
    assert len(some) == 2 and some.range.tolist() == [views.range[7], views.range[3]]
    assert np.array_equal(some.normal, views.normal[[7, 3]])


def test_no_views_where_the_source_is_never_up(job, monkeypatch):
    monkeypatch.setattr(views_module, "_TRIES", 3)  # batches of 256 candidates
    day = AXES | {"time": np.array([12.0])}
    assert np.all(random_views(job, "sun", GRID, day, SHELLS, 10, 1).source_elevation > 0)
    assert len(random_views(job, "moon", GRID, day, SHELLS, 10, 1)) == 0
