"""Temperatures of mixtures under shade: each material of each point as the table alone gives it."""

import numpy as np
import pytest

from skyshine.mat.quantities.lines_of_sight import direction
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.render.alike import alike
from skyshine.mat.render.camera import ViewRays
from skyshine.mat.render.exposure import SeenExposure
from skyshine.mat.render.frames import _view
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface import Mixtures
from skyshine.mat.render.temperatures import SeenTemperatures
from skyshine.mat.tables.loader import open_table

SHADE = (9.0, 11.0)


@pytest.fixture(scope="module")
def table(small_build):
    return open_table(small_build / "s01.htt.h5")


@pytest.fixture
def points():
    """A mixture in the Sun, a mixture in the shade, one material in the shade on a slope, and the first again."""
    number = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0], [0, 1, 0]])
    share = np.array([[0.6, 0.4, 0.0], [0.7, 0.3, 0.0], [1.0, 0.0, 0.0], [0.6, 0.4, 0.0]])
    zero = np.zeros((4, 3))
    slope, azimuth = np.array([0.0, 0.0, 45.0, 0.0]), np.array([0.0, 0.0, 180.0, 0.0])
    altitude = np.array([0.1, 0.3, 0.1, 0.1])
    mixtures = Mixtures(("asphalt_road", "grass_green"), number, share)
    return SeenSurface(
        np.arange(4), np.arange(4), zero, zero, zero, zero, np.ones(4), slope, azimuth, altitude, mixtures
    )


def test_each_material_of_each_point_has_the_temperature_of_the_table(table, points):
    hours = np.array([10.0, 20.0])
    steps = np.arange(288) / 12
    shaded = np.zeros((4, 288), bool)
    shaded[1:3] = (steps >= SHADE[0]) & (steps < SHADE[1])
    exposure = SeenExposure(shaded, np.array([1.0, 0.8, 1.0, 1.0]), np.zeros((4, 0)))
    codes = np.array([table.materials[name] for name in points.materials.names])
    read = SeenTemperatures.of(table, points, exposure, codes, np.full(codes.size, np.nan), hours)
    assert len(read.kelvin) == 5  # the last point is the first again
    interval = (SHADE[0] - 1 / 24, SHADE[1] - 1 / 24)
    for place in range(4):
        where = {
            name: float(values[place])
            for name, values in (("altitude", points.altitude), ("azimuth", points.azimuth), ("slope", points.slope))
        }
        for part in np.flatnonzero(points.materials.share[place]):
            name = points.materials.names[points.materials.number[place, part]]
            change = None
            if place in (1, 2):
                view = float(exposure.sky_view[place])
                change = table.absorbed_change(material=name, **where, shade=[interval], sky_view=view)
            expected = table.temperature(material=name, **where, time=hours, absorbed_change=change)
            kelvin = [read.at(hour)[place, part] for hour in range(2)]
            assert kelvin == pytest.approx(expected.tolist(), abs=1e-6), (place, name)
    assert np.all(np.isfinite(read.at(0)))


def test_rows_that_are_alike_are_one_kind():
    first, kind = alike(np.array([1, 2, 1, 1]), np.array([[0.5, 1.0], [0.5, 1.0], [0.5, 1.0], [0.5, 1.5]]))
    assert len(first) == 3 and kind[0] == kind[2] and len({kind[0], kind[1], kind[3]}) == 3
    assert alike(np.zeros(0), np.zeros((0, 3)))[0].size == 0


def test_source_and_line_of_sight_of_a_view_span_the_angle_between_their_directions(small_build, table):
    """The tables take elevations and an azimuth between; vectors give the same angle without them."""
    ahead = direction(np.array([-40.0, -10.0, -60.0]), np.array([20.0, 200.0, 310.0]))
    rays = ViewRays((3, 1), np.zeros((3, 3)), ahead, np.full(3, 0.5), np.zeros(3), 0.0)
    air = open_table(small_build / "s01b01.atmq.h5")
    sun = table.source_track("sun", time=9.0)
    view = _view(air, rays, np.arange(3), np.ones(3), np.tile([0.0, 0.0, 1.0], (3, 1)), sun)
    between = np.degrees(np.arccos(np.sum(ahead * view.to_source, axis=1)))
    line = view.lines
    assert scattering_angle(line.elevation, line.source_elevation, line.source_azimuth) == pytest.approx(between)
    assert view.to_observer == pytest.approx(-ahead)


def test_a_mixture_gets_the_light_that_its_shaded_materials_leave():
    exposure = SeenExposure(np.zeros((3, 288), bool), np.array([1.0, 0.3, 0.9]), np.zeros((3, 0)))
    shares = np.array([[0.75, 0.25], [0.75, 0.25], [0.5, 0.5]])
    lit, view = exposure.of_mixtures(shares, np.array([[np.nan, 0.4], [np.nan, 0.4], [np.nan, np.nan]]))
    np.testing.assert_allclose(lit, [0.75, 0.75, 1.0], rtol=1e-12)
    # The second material sees 0.4 of the sky at most; where the surface leaves less, that is what it sees.
    np.testing.assert_allclose(view, [0.75 + 0.25 * 0.4, 0.3, 0.9], rtol=1e-12)
