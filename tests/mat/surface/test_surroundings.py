"""Shade and walls: hours of shade, what light and longwave are left, and what no surroundings may do."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.mat.surface.surroundings import Surroundings, shaded_share
from skyshine.schemas.errors import InputError

SLOPES, AZIMUTHS = np.array([0.0, 30.0, 90.0, 90.0, 150.0]), np.array([0.0, 180.0, 90.0, 270.0, 0.0])


@pytest.fixture
def scene(sun_path, weather, sky):
    return Scene(sun_path, weather, sky, np.array([0.0, 1000.0]), SLOPES, AZIMUTHS)


@pytest.mark.parametrize(
    ("shade", "hours"),
    [
        ([(10, 14)], 4.0),
        ([(22, 6)], 8.0),
        ([(0, 24)], 24.0),
        ([(10, 14), (13, 15.1)], 5.1),
        ([(23.9, 0.1), (12, 12.01)], 0.21),
        ([], 0.0),
    ],
)
def test_hours_of_shade_are_kept_whatever_the_step(shade, hours):
    for steps in (24, 96, 576):
        share = shaded_share(shade, np.arange(steps) * 24.0 / steps, 24.0 / steps)
        assert share.sum() * 24.0 / steps == pytest.approx(hours, abs=1e-9)
        assert share.min() >= 0 and share.max() <= 1


def test_shade_over_midnight_covers_both_sides_of_it():
    hours = np.array([21.0, 22.0, 23.0, 0.0, 5.0, 6.0, 7.0])
    assert shaded_share([(22, 6)], hours, 0.5) == pytest.approx([0, 0.5, 1, 1, 1, 0.5, 0])


def test_a_level_surface_in_the_shade_keeps_the_even_light_of_the_sky(scene):
    sunlit, shaded = scene.forcing(96), replace(scene, surroundings=Surroundings(((10, 14),))).forcing(96)
    inside = np.abs(np.arange(96) / 4 - 12) < 1.9
    assert np.all(shaded.shortwave_direct[:, inside] == 0) and sunlit.shortwave_direct[0, inside].min() > 500
    around = 1 - scene.sky.aureole[-1]
    np.testing.assert_allclose(shaded.shortwave_diffuse[0, inside], around * sunlit.shortwave_diffuse[0, inside])
    outside = np.abs(np.arange(96) / 4 - 12) > 2.2
    for name in ("shortwave_direct", "shortwave_diffuse", "longwave_sky", "longwave_ground"):
        np.testing.assert_allclose(getattr(shaded, name)[:, outside], getattr(sunlit, name)[:, outside], rtol=1e-12)


@pytest.mark.parametrize("sky_view", [1.0, 0.6, 0.0])
def test_surroundings_add_sunlight_to_no_surface(scene, sky_view):
    sunlit = scene.forcing(96)
    hidden = replace(scene, surroundings=Surroundings(((0, 24),), sky_view)).forcing(96)
    assert np.all(hidden.shortwave_direct == 0)
    assert np.all(hidden.shortwave_diffuse <= sunlit.shortwave_diffuse + 1e-12)
    assert np.array_equal(hidden.shortwave_reflected, sunlit.shortwave_reflected)


def test_without_sky_only_the_wall_radiates_on_a_level_surface(scene):
    hidden = replace(scene, surroundings=Surroundings(sky_view=0.0, facing=310.0, facing_emissivity=1.0)).forcing(96)
    assert np.all(hidden.longwave_sky == 0)
    np.testing.assert_allclose(hidden.longwave_ground[0], Stefan_Boltzmann * 310.0**4, rtol=1e-12)


def test_a_mirror_wall_reflects_half_the_sky_and_half_the_ground(scene):
    sunlit = scene.forcing(96)
    hidden = replace(scene, surroundings=Surroundings(sky_view=0.0, facing=500.0, facing_emissivity=0.0)).forcing(96)
    ground = Stefan_Boltzmann * sunlit.air_temperature[0] ** 4
    np.testing.assert_allclose(hidden.longwave_ground[0], 0.5 * (sunlit.longwave_sky[0] + ground), rtol=1e-12)


def test_the_sun_stays_where_only_the_sky_is_hidden(scene):
    sunlit, hidden = scene.forcing(96), replace(scene, surroundings=Surroundings(sky_view=0.2)).forcing(96)
    assert np.array_equal(hidden.shortwave_direct, sunlit.shortwave_direct)


def test_open_surroundings_change_nothing(scene):
    open_sky = replace(scene, surroundings=Surroundings()).forcing(96)
    for name, values in scene.forcing(96).given.items():
        np.testing.assert_allclose(getattr(open_sky, name), values, rtol=1e-12, err_msg=name)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sky_view": 1.2}, r"found sky_view 1\.2; allowed: 0 \(no sky\) to 1"),
        ({"sky_view": float("nan")}, "found sky_view nan"),
        ({"facing": 300.0}, "found facing with a sky_view of 1"),
        ({"sky_view": 0.5, "facing": 30.0}, "found facing 30 K; allowed: 50 to 2000 K; give it in kelvin"),
        ({"sky_view": 0.5, "facing_emissivity": 2.0}, "found facing_emissivity 2"),
        ({"shade": ((10.0, 10.0),)}, "found shade from 10 to 10 h; allowed: two different clock hours"),
        ({"shade": ((10.0, 25.0),)}, "found shade from 10 to 25 h"),
    ],
)
def test_impossible_surroundings_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        Surroundings(**settings)


def test_hours_of_the_sun_count_from_midnight():
    """Shade of 0 to 12 h covers the first half of `sun_hours()`, half of its two edge samples."""
    share = shaded_share([(0, 12)], sun_hours(), 24 / 576)
    assert share[0] == share[288] == 0.5 and np.all(share[1:288] == 1) and np.all(share[289:] == 0)


def test_a_wall_hides_its_share_of_an_even_sky_and_nothing_of_the_light_around_the_sun():
    """100 W m^-2 of diffuse light, 60 of it from an even sky, half of which a wall hides: 30, and 40 where sunlit."""
    direct, diffuse = Surroundings(sky_view=0.5, facing=300.0).sunlight(
        np.array([800.0, 800.0]), np.array([100.0, 100.0]), np.array([60.0, 60.0]), np.array([0.0, 1.0])
    )
    assert direct.tolist() == [800.0, 0.0] and diffuse == pytest.approx([70.0, 30.0])
