"""Positions of Sun and Moon against almanacs."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.sources.ephemeris import position
from skyshine.mat.atmosphere.sources.lunar import MOON_RADIUS
from skyshine.schemas.errors import InputError


def times(*texts):
    return np.array(texts, dtype="datetime64[s]")


def test_sun_of_the_spa_report():
    """Reda and Andreas 2008 (NREL/TP-560-34302), appendix A.5: 2003-10-17 12:30:30 at UTC-7.

    Zenith 50.11162 degrees after a refraction of 0.016332 degrees (820 hPa, 11 C): elevation without it 39.872048.
    """
    sun = position("sun", times("2003-10-17T19:30:30"), 39.742476, -105.1786, 1830.14)
    assert sun.elevation[0] == pytest.approx(39.872048, abs=5e-4)
    assert sun.azimuth[0] == pytest.approx(194.34024, abs=5e-4)
    assert sun.sun_distance[0] == pytest.approx(0.9965422974, abs=5e-5)  # the report's R is from the Earth's centre


def test_moon_of_meeus():
    """Meeus, Astronomical Algorithms, examples 47.a and 48.a: 1992-04-12 0h TD, 368,409.7 km, phase angle 69.0756.

    From the centre of the Earth; the observer whose zenith the Moon is in (right ascension 134.69, declination
    13.77, Greenwich sidereal time 200.2 degrees) is nearer by the radius of the Earth and sees the same phase.
    """
    moon = position("moon", times("1992-04-11T23:59:01"), 13.768, 134.688 - 199.92)
    assert moon.elevation[0] > 89
    assert moon.distance[0] + 6377e3 == pytest.approx(368409.7e3, rel=1e-4)
    assert moon.phase_angle[0] == pytest.approx(69.0756, abs=0.02)
    assert moon.waxing[0]


def test_total_eclipse_of_the_sun():
    """NASA: greatest eclipse 2017-08-21 18:25:32 UT at 36.967 N, 87.672 W, the Sun 64 degrees high: both in one
    place.
    """
    moment = times("2017-08-21T18:25:32")
    sun = position("sun", moment, 36.967, -87.672)
    moon = position("moon", moment, 36.967, -87.672)
    assert sun.elevation[0] == pytest.approx(63.9, abs=0.1)
    assert moon.elevation[0] == pytest.approx(sun.elevation[0], abs=0.01)
    assert moon.azimuth[0] == pytest.approx(sun.azimuth[0], abs=0.02)
    assert moon.phase_angle[0] > 179.9
    # The Moon then covers the Sun, by a magnitude of 1.0306.
    assert (MOON_RADIUS / moon.distance[0]) / (695.7e6 / sun.distance[0]) == pytest.approx(1.0306, abs=2e-3)


def test_total_eclipse_of_the_moon():
    """Greatest eclipse 2018-07-27 20:22 UT: full Moon, up over Cairo, its distance near apogee (406,223 km
    geocentric).
    """
    moon = position("moon", times("2018-07-27T20:21:44"), 30.0, 31.2)
    assert moon.phase_angle[0] < 1.6
    assert moon.elevation[0] > 0
    assert 400e6 < moon.distance[0] < 407e6


def test_polar_night_and_midnight_sun():
    day = np.arange(np.datetime64("2024-12-21T00:00"), np.datetime64("2024-12-22T00:00"), np.timedelta64(30, "m"))
    assert np.all(position("sun", day, 80.0, 15.0).elevation < 0)
    assert np.all(position("sun", day, -80.0, 15.0).elevation > 0)
    assert position("moon", day, 50.0, 10.0).elevation.min() < 0


def test_equinox_at_the_equator():
    """Noon at the equator on the day of equinox: the Sun within half a degree of the zenith; sunrise due east."""
    assert position("sun", times("2024-03-20T12:07:30"), 0.0, 0.0).elevation[0] > 89.5
    assert position("sun", times("2024-03-20T06:07:30"), 0.0, 0.0).azimuth[0] == pytest.approx(90, abs=0.5)


def test_no_times_give_no_positions():
    assert position("sun", times(), 0.0, 0.0).elevation.shape == (0,)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("mars", times("2024-01-01T00:00:00"), 0.0, 0.0), "sun, moon"),
        (("sun", times("NaT"), 0.0, 0.0), "NaT"),
        (("sun", [1.0], 0.0, 0.0), "datetime64"),
        (("sun", times("2024-01-01T00:00:00"), 91.0, 0.0), "latitude 91"),
        (("sun", times("2024-01-01T00:00:00"), 0.0, np.nan), "longitude nan"),
    ],
)
def test_impossible_arguments_are_named(arguments, message):
    with pytest.raises(InputError, match=message):
        position(*arguments)


def test_a_height_shortens_the_way_to_the_moon_overhead():
    moment, place = times("1992-04-11T23:59:01"), (13.768, 134.688 - 199.92)
    low, high = (position("moon", moment, *place, height=height).distance[0] for height in (0.0, 10e3))
    assert low - high == pytest.approx(10e3, rel=1e-3)


def test_longitude_repeats_after_a_turn():
    west, east = (position("sun", times("2024-05-01T09:00:00"), 48.0, longitude) for longitude in (-120.0, 240.0))
    assert (west.elevation[0], west.azimuth[0]) == pytest.approx((east.elevation[0], east.azimuth[0]), abs=1e-9)


def test_phase_of_the_moon_waxes_and_wanes():
    """Moon phases of January 2024 (USNO): last quarter on the 4th, new 11th, first quarter 18th, full 25th."""
    quarters = times("2024-01-04T03:30:00", "2024-01-18T03:53:00", "2024-01-25T17:54:00", "2024-01-11T11:57:00")
    moon = position("moon", quarters, 0.0, 0.0)
    # A quarter is an elongation of 90 degrees; the phase angle is less by the parallax of the Sun, 0.15, and the
    # observer's place shifts it by up to a degree.
    assert moon.phase_angle == pytest.approx([90, 90, 0, 180], abs=6)
    assert moon.phase_angle[:2] == pytest.approx([90, 90], abs=1.2)
    assert moon.waxing[:2].tolist() == [False, True]
