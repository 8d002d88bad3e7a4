"""Tables read as a runtime reads them: vertices of a face, the centre of a frame, assigned materials, missing files."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.budget.built_tables import Tables, frame_centres, vertices
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.grid import PathGrid
from skyshine.schemas.errors import InputError

GRID = PathGrid([0.1, 20.0], [0.01, 1.0], [-80.0, 60.0], [-20.0, 60.0], [0.0, 180.0])


def test_vertices_lie_a_face_apart_with_the_pixel_between(make_views, tables):
    """Across the line of sight, 20 m at 2 km: a quarter of 0.573 degrees to one side, the rest to the other."""
    views = make_views(1, elevation=0.0, altitude=0.0)
    first, second = vertices(views, GRID, tables)
    turn = np.degrees(np.arctan([-5.0 / 2000.0, 15.0 / 2000.0]))
    assert [first.heading[0], second.heading[0]] == pytest.approx(turn)
    assert [first.range[0], second.range[0]] == pytest.approx(np.hypot(2.0, [0.005, 0.015]))
    assert [first.elevation[0], second.elevation[0]] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert [first.surface_altitude[0], second.surface_altitude[0]] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_vertices_up_a_wall_differ_in_altitude_and_elevation(make_views, tables):
    views = make_views(1, elevation=0.0, surface_altitude=0.5, along=[0.0, 0.0, 1.0], normal=[0.0, -1.0, 0.0])
    first, second = vertices(views, GRID, tables)
    assert second.surface_altitude[0] - first.surface_altitude[0] == pytest.approx(0.02)
    angles = np.degrees(np.arctan([-0.005 / 2, 0.015 / 2]))
    assert [first.elevation[0], second.elevation[0]] == pytest.approx(angles, rel=1e-4)


def test_normals_of_the_vertices_differ_by_the_bend(make_views, tables):
    views = make_views(1, bend=np.radians(10.0), normal=[0.0, -1.0, 0.0], along=[1.0, 0.0, 0.0], share=0.5)
    first, second = vertices(views, GRID, tables)
    between = np.degrees(np.arccos(np.sum(first.normal * second.normal)))
    # Half of tan(10 degrees) to each side.
    assert between == pytest.approx(2 * np.degrees(np.arctan(0.5 * np.tan(np.radians(10.0)))))
    level = make_views(1, bend=0.0, normal=[0.0, -1.0, 0.0])
    assert np.array_equal(*(sight.normal for sight in vertices(level, GRID, tables)))


def test_the_centre_of_a_frame_meets_the_ground_of_the_same_altitude(make_views):
    """500 m up, looking 15 degrees down: 1.93 km away; a degree lower, 1.81 km (500 m / sine, nearly flat)."""
    views = make_views(2)
    centre = frame_centres(views, GRID, np.array([[0.0, 0.0], [0.0, -1.0]]))
    assert centre.range == pytest.approx(0.5 / np.sin(np.radians([15.0, 16.0])), rel=2e-3)
    assert centre.elevation == pytest.approx([-15.0, -16.0]) and centre.heading == pytest.approx([0.0, 0.0])


def test_a_centre_above_the_horizon_looks_three_times_as_far(make_views):
    centre = frame_centres(make_views(1), GRID, np.array([[0.0], [20.0]]))
    assert centre.elevation == pytest.approx([5.0]) and centre.range == pytest.approx([6.0])


def test_degrees_across_a_frame_are_more_of_heading_far_below_the_horizon(make_views):
    centre = frame_centres(make_views(1, elevation=-60.0), GRID, np.array([[3.0], [0.0]]))
    assert centre.heading == pytest.approx([6.0])  # 3 / cos 60


def test_a_centre_stays_on_the_axes(make_views):
    centre = frame_centres(make_views(2, range=[0.2, 19.0]), GRID, np.array([[0.0, 0.0], [-90.0, 90.0]]))
    assert centre.elevation == pytest.approx([-80.0, 60.0]) and centre.range[1] == 20.0


def test_readings_are_those_of_the_table_at_the_place_of_the_sight(make_views, tables):
    views = make_views(3, range=[1.0, 2.0, 7.0], heading=[0.0, 90.0, 200.0])
    read = tables.readings(views)
    other = replace(views, elevation=views.elevation - 30)
    path = {"range": views.range, "altitude": views.altitude, "elevation": views.elevation}
    tau = np.exp(-5.5 * views.range / tables.air.value("beta_star", **path))
    assert read.transmittance[:, 0] == pytest.approx(tau)
    light = tables.air.value("ambient_radiance", **path, source_elevation=views.source_elevation)
    assert read.ambient[:, 0] == pytest.approx(light)
    # Tables of 5 K have so few digits that two of three may stay.
    assert np.any(tables.readings(other).ambient != read.ambient)
    # The source at 120 degrees lies 120, 30 and 80 degrees from the headings.
    place = path | {"source_elevation": views.source_elevation, "source_azimuth": [120.0, 30.0, 80.0]}
    assert read.path_radiance_ratio[:, 0] == pytest.approx(tables.air.value("path_radiance_ratio", **place))


def test_a_missing_database_says_what_to_do(small_job, tmp_path):
    job = load_job(small_job).trimmed
    with pytest.raises(InputError, match=r"has no s01.htt.h5; build the job first: mat build"):
        Tables.open(tmp_path, 1, 1, "sun", job)
