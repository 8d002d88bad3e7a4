"""Tracks of Sun and Moon in the temperature tables, against another ephemeris."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.schemas.errors import InputError

# PyEphem 4.2.1 (libastro: VSOP87, and the Moon of Moshier), without refraction, at 29.7 N, 82 W on 2026-06-28 at UTC-5:
# hour; Sun: elevation, azimuth [degree], distance [au]; Moon: elevation, azimuth [degree], distance [km], share of its
# disc in light as seen from the centre of the Earth [percent].
PYEPHEM = np.array(
    [
        (0.0, -36.496, 351.067, 1.01653, 30.319, 194.481, 402992, 96.96),
        (3.3, -23.594, 41.807, 1.01652, 6.711, 231.870, 405459, 97.38),
        (9.17, 44.878, 85.783, 1.01648, -61.398, 265.233, 411817, 98.05),
        (12.5, 83.543, 177.246, 1.01648, -76.922, 86.190, 412403, 98.38),
        (19.0, 5.514, 293.655, 1.01652, 0.217, 123.464, 406003, 98.94),
        (23.9, -36.316, 349.310, 1.01656, 31.598, 180.147, 402579, 99.28),
        (28.4, -13.075, 53.249, 1.01655, 4.232, 233.771, 405308, 99.52),
        (36.0, 80.407, 130.820, 1.01650, -85.500, 296.531, 411916, 99.79),
    ]
)


@pytest.fixture(scope="module")
def table(small_build):
    return skyshine.mat.open(small_build / "s01.htt.h5")


@pytest.mark.parametrize(("source", "first"), [("sun", 1), ("moon", 4)])
def test_directions_and_distances_are_those_of_another_ephemeris(table, source, first):
    elevation, azimuth, distance = PYEPHEM[:, first : first + 3].T
    track = table.source_track(source, time=PYEPHEM[:, 0])
    np.testing.assert_allclose(track.elevation, elevation, atol=0.02)
    turn = (track.azimuth - azimuth + 180) % 360 - 180
    # On the sky; near the zenith azimuths of the table turn fast between its nodes.
    np.testing.assert_allclose(turn * np.cos(np.radians(elevation)), 0, atol=0.02)
    assert np.all((track.azimuth >= 0) & (track.azimuth < 360))
    np.testing.assert_allclose(track.distance, distance, rtol=1e-4)


def test_the_disc_of_the_moon_is_lit_as_by_another_ephemeris(table):
    moon = table.source_track("moon", time=PYEPHEM[:, 0])
    np.testing.assert_allclose(100 * moon.illuminated_fraction, PYEPHEM[:, 7], atol=0.3)
    np.testing.assert_allclose(np.cos(np.radians(moon.phase_angle / 2)) ** 2, moon.illuminated_fraction, atol=1e-5)
    sun = table.source_track("sun", time=PYEPHEM[:, 0])
    assert np.all(sun.illuminated_fraction == 1) and np.all(sun.phase_angle == 0)


def test_tracks_have_no_jumps_and_last_over_the_night(table):
    for name in ("sun_azimuth", "moon_azimuth"):
        assert np.abs(np.diff(table.root.variables[name].data)).max() < 90
    nodes = table.root.axes["track_time"].values
    assert nodes[0] == 0 and nodes[-1] == 36 and np.allclose(np.diff(nodes), 1 / 12)


def test_the_sun_of_the_heat_balance_is_that_of_the_track(table):
    hours = table.root.axes["forcing_time"].values
    track = table.source_track("sun", time=hours)
    np.testing.assert_allclose(track.elevation, table.root.variables["solar_elevation"].data, atol=0.01)


def test_what_the_tracks_do_not_hold_is_refused(table):
    with pytest.raises(InputError, match="found the source 'mars'; allowed: sun, moon"):
        table.source_track("mars", time=0)
    with pytest.raises(InputError, match="track_time: found 36.5; allowed: 0 to 36"):
        table.source_track("sun", time=36.5)
    kept = {name: each for name, each in table.root.variables.items() if not name.startswith(("sun_", "moon_"))}
    with pytest.raises(InputError, match="contains no tracks of Sun and Moon; build it again"):
        replace(table, root=replace(table.root, variables=kept)).source_track("sun", time=0)
