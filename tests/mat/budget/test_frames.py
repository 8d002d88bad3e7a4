"""Errors of stored tables off the centre of a frame."""

import numpy as np
import pytest

from skyshine.mat.budget.built_tables import frame_centres
from skyshine.mat.budget.frames import FIELDS_OF_VIEW, READINGS, frame_errors
from skyshine.mat.quantities.grid import PathGrid

GRID = PathGrid([0.1, 20.0], [0.01, 1.0], [-89.0, 89.0], [-20.0, 60.0], [0.0, 180.0])


@pytest.fixture(scope="module")
def views(make_views):
    draw = np.random.default_rng(6)
    places = {
        "range": draw.uniform(1, 9, 40),
        "altitude": draw.uniform(0.1, 0.9, 40),
        "elevation": draw.uniform(-60, -20, 40),
        "source_azimuth": draw.uniform(0, 360, 40),
    }
    return make_views(40, **places)


@pytest.fixture(scope="module")
def errors(tables, views):
    """Of ambient light read from tables, against that at the pixel; along the diagonal of the frame."""
    here = tables.readings(views).ambient
    return frame_errors(tables, views, GRID, np.full((2, 40), 0.5), here, lambda readings: readings.ambient)


def test_what_is_read_at_the_pixel_has_no_error_of_the_frame(errors):
    assert set(errors) == set(READINGS) and errors["frame"].shape == (len(FIELDS_OF_VIEW), 40, 1)
    assert np.array_equal(errors["frame"], np.zeros(errors["frame"].shape))
    assert np.all(np.abs(errors["centre"]).max(axis=(1, 2)) > 0)


def test_errors_of_a_profile_grow_with_the_field_of_view(errors):
    """The same range, half a field of view off: what is left is the slope of the table over elevation."""
    size = np.abs(errors["profile"]).mean(axis=(1, 2))
    assert np.all(np.diff(size) > 0) and size[1] == pytest.approx(2 * size[0], rel=0.3)


def test_a_profile_through_the_centre_itself_is_right(tables, views):
    here = tables.readings(views).ambient
    found = frame_errors(tables, views, GRID, np.zeros((2, 40)), here, lambda readings: readings.ambient)
    assert np.array_equal(found["profile"], np.zeros(found["profile"].shape))


def test_transmittance_of_the_centre_is_taken_to_the_range_of_the_pixel(tables, views):
    """Equation (9) with beta* of the centre and the range of the pixel."""
    still = np.zeros((2, 40))
    found = frame_errors(tables, views, GRID, still, np.zeros((40, 1)), lambda readings: readings.transmittance)
    centre = frame_centres(views, GRID, still)
    beta = tables.air.value("beta_star", range=centre.range, altitude=views.altitude, elevation=centre.elevation)
    assert found["centre"][0, :, 0] == pytest.approx(np.exp(-5.5 * views.range / beta), rel=1e-6)
