"""Measured light in place of the computed: means that are kept, nights, other altitudes, cloud."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.measured import MeasuredRadiation
from skyshine.mat.surface.sun_path import SUN_STEPS
from skyshine.schemas.errors import InputError

HOURS = np.arange(1.0, 25.0)
EACH = SUN_STEPS // 24


def hourly_means(values):
    """Means over the hours that end at 1 to 24; the time at which one ends is in it."""
    return np.roll(values, -1).reshape(24, EACH).mean(axis=1)


@pytest.fixture
def clear(sun_path, sky):
    direct, diffuse = sky.irradiance(sun_path, 0.0, np.array([0.0]))
    return direct[0], diffuse[0]


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0, 1.3])
def test_every_interval_keeps_its_mean(sun_path, clear, share):
    means = [share * hourly_means(part) for part in clear]
    sunlight = MeasuredRadiation(HOURS, *means).sunlight(sun_path, *clear)
    for light, mean, part in zip(sunlight, means, clear, strict=True):
        assert hourly_means(light) == pytest.approx(mean, rel=1e-12)
        assert light == pytest.approx(share * part, rel=1e-9)  # the clear sky's share of each hour is one number


def test_diffuse_light_of_a_dull_dawn_is_spread_while_the_sun_is_up(sun_path, clear):
    """Far more than the clear sky has in the hour of sunrise: kept as it is, without a peak."""
    rise = int(np.argmax(hourly_means(clear[1]) > 0))
    means = np.zeros(24)
    means[rise] = 40 * hourly_means(clear[1])[rise]
    light = MeasuredRadiation(HOURS, np.zeros(24), means).sunlight(sun_path, *clear)[1]
    assert hourly_means(light)[rise] == pytest.approx(means[rise]) and np.unique(light).size == 2


def test_direct_light_at_night_is_refused_and_a_little_is_stray(sun_path, clear):
    direct = np.zeros(24)
    direct[1] = 5.0
    assert np.all(MeasuredRadiation(HOURS, direct, np.zeros(24)).sunlight(sun_path, *clear)[0] == 0)
    direct[1] = 300.0
    with pytest.raises(
        InputError, match=r"found 300 W m\^-2 of direct light in the time to 2 h, when the Sun is down; check date"
    ):
        MeasuredRadiation(HOURS, direct, np.zeros(24)).sunlight(sun_path, *clear)


def test_diffuse_light_at_night_is_refused(sun_path, clear):
    diffuse = np.zeros(24)
    diffuse[1] = 80.0
    with pytest.raises(InputError, match="of diffuse light in the time to 2 h, when the Sun is down"):
        MeasuredRadiation(HOURS, np.zeros(24), diffuse).sunlight(sun_path, *clear)


def test_polar_night_is_dark(make_sun_path, sky):
    sun_path = make_sun_path(85.0, -23.0)
    dark = [part[0] for part in sky.irradiance(sun_path, 0.0, np.array([0.0]))]
    sunlight = MeasuredRadiation(HOURS, np.zeros(24), np.full(24, 2.0)).sunlight(sun_path, *dark)
    assert all(np.all(part == 0) for part in sunlight)


def test_longwave_goes_through_the_middles_of_the_intervals():
    falling = 400.0 - HOURS
    sunlight = MeasuredRadiation(HOURS, np.zeros(24), np.zeros(24), falling).sky_longwave()
    assert sunlight[EACH // 2 :: EACH] == pytest.approx(falling)
    assert sunlight.min() >= falling.min() and sunlight.max() <= falling.max()


def test_measured_clear_light_gives_the_forcing_of_the_clear_sky(sun_path, weather, sky, clear):
    """At the altitude of the weather and above it, sky longwave included."""
    heights, planes = np.array([0.0, 2000.0]), np.array([0.0, 90.0])
    longwave = hourly_means(
        Scene(sun_path, weather, sky, heights[:1], planes, planes).forcing(SUN_STEPS).longwave_sky[0]
    )
    measured = replace(weather, radiation=MeasuredRadiation(HOURS, *(hourly_means(part) for part in clear), longwave))
    computed, other = (
        Scene(sun_path, w, sky, heights, planes, 180 + 0 * planes).forcing(96) for w in (weather, measured)
    )
    for name in ("shortwave_direct", "shortwave_diffuse", "shortwave_reflected"):
        assert getattr(other, name) == pytest.approx(getattr(computed, name), abs=2.0), name
    assert other.longwave_sky == pytest.approx(computed.longwave_sky, rel=0.01)


def test_measured_light_is_no_longer_dimmed_by_cloud(sun_path, make_weather, sky, clear):
    dull = replace(make_weather(1.0), radiation=MeasuredRadiation(HOURS, *(hourly_means(part) for part in clear)))
    forcing = Scene(sun_path, dull, sky, np.array([0.0]), np.array([0.0]), np.array([0.0])).forcing(96)
    assert forcing.shortwave_direct[0, 48] > 500
    assert np.all(forcing.longwave_sky > 300)  # not measured: the state's, with the cloud


@pytest.mark.parametrize("every", [1, 4])
def test_a_total_is_parted_as_erbs_does_and_keeps_its_energy(sun_path, every):
    """Above a clearness of 0.8 the diffuse share is 0.165, below 0.22 it is 1 - 0.09 of it (Erbs et al. 1982); in
    intervals of four hours the Sun is up for a part of one."""
    hours = np.arange(every, 25.0, every)
    sine = np.sin(np.radians(sun_path.solar_elevation))
    above = 1361.1 / sun_path.sun_distance**2
    interval = MeasuredRadiation(hours, 0 * hours, 0 * hours)._intervals()
    for clearness, share in ((0.85, 0.165), (0.1, 1 - 0.09 * 0.1)):
        total = np.array([clearness * above * np.maximum(sine, 0.0)[interval == n].mean() for n in range(hours.size)])
        parts = MeasuredRadiation.of_total(hours, total, sun_path)
        for number in np.flatnonzero(total > 20):
            lit = sine[(interval == number) & (sine > 0)].mean()
            assert parts.diffuse[number] == pytest.approx(share * total[number], rel=1e-3)
            assert parts.direct[number] * lit + parts.diffuse[number] == pytest.approx(total[number], rel=1e-6)
        assert np.all(parts.direct[total == 0] == 0) and np.all(parts.diffuse[total == 0] == 0)
    stray = MeasuredRadiation.of_total(hours, np.full(hours.size, 5.0), sun_path)
    assert stray.direct[0] == 0 and stray.diffuse[0] == 5.0
