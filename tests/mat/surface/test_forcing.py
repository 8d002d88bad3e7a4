"""Sun, sky and weather on planes: geometry, limits, conservation."""

import numpy as np
import pytest

from skyshine.mat.surface.forcing import (
    Scene,
    plane_irradiance,
    step_means,
)
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath
from skyshine.schemas.errors import InputError

STEFAN_BOLTZMANN = 5.670374419e-8


def test_overcast_leaves_a_quarter_and_no_shadow(sun_path, sky):
    """Kasten and Czeplak: global irradiance under 8 octas is 0.25 of the clear one."""
    height = np.array([0.0])
    direct, diffuse = sky.irradiance(sun_path, 0.0, height)
    cloud_direct, cloud_diffuse = sky.irradiance(sun_path, 1.0, height)
    level = direct * np.maximum(np.sin(np.radians(sun_path.solar_elevation)), 0) + diffuse
    assert np.all(cloud_direct == 0)
    assert np.allclose(cloud_diffuse, 0.25 * level, rtol=1e-9)


def test_sky_longwave_by_cloud(sky):
    """Emissivity 0.8 when clear, 0.16 x 0.8 + 0.84 when overcast (Unsworth and Monteith)."""
    black = STEFAN_BOLTZMANN * 288.0**4
    air, height = np.full((1, SUN_STEPS), 288.0), np.array([0.0])
    assert sky.longwave(air, 0.0, height) / black == pytest.approx(0.8)
    assert sky.longwave(air, 1.0, height) / black == pytest.approx(0.968)


def test_no_light_comes_up_from_below_the_horizon(sky):
    elevation = np.linspace(-90, 90, SUN_STEPS)
    direct, diffuse = sky.irradiance(SunPath(0.0, elevation, np.zeros(SUN_STEPS)), 0.0, np.array([0.0, 4000.0]))
    assert np.all(np.isfinite(direct)) and np.all(np.isfinite(diffuse))
    assert np.all(direct[:, elevation < -1] == 0) and np.all(diffuse[:, elevation < -1] == 0)
    assert np.all(np.diff(direct, axis=1) >= 0)


def test_twilight_is_diffuse():
    direct, diffuse, reflected = plane_irradiance(0.0, 0.0, -2.0, 0.0, 0.0, 3.0, 0.2, 1361.0)
    assert (direct, reflected) == (0, 0) and diffuse == pytest.approx(3.0)


def test_level_plane_takes_the_sine_of_the_elevation():
    direct, diffuse, reflected = plane_irradiance(0.0, 123.0, 30.0, 250.0, 800.0, 100.0, 0.2, 1361.0)
    assert direct == pytest.approx(400.0)
    assert diffuse == pytest.approx(100.0)
    assert reflected == 0


@pytest.mark.parametrize("azimuth, share", [(180.0, 1.0), (90.0, 0.0), (270.0, 0.0), (0.0, 0.0), (225.0, 0.5**0.5)])
def test_wall_faces_its_azimuth(azimuth, share):
    """The Sun in the south at 30 degrees: a south wall gets cos 30 of the beam, a south-west one cos 45 of it."""
    direct, _, reflected = plane_irradiance(90.0, azimuth, 30.0, 180.0, 1000.0, 0.0, 0.2, 1361.0)
    assert direct == pytest.approx(866.025 * share, abs=1e-3)
    assert reflected == pytest.approx(0.5 * 0.2 * 500.0)


def test_face_down_sees_ground_only():
    direct, diffuse, reflected = plane_irradiance(180.0, 0.0, 45.0, 90.0, 900.0, 120.0, 0.3, 1361.0)
    assert direct == 0
    assert diffuse == pytest.approx(0.0, abs=1e-9)
    assert reflected == pytest.approx(0.3 * (900 * np.sin(np.pi / 4) + 120))


def test_east_wall_is_lit_in_the_morning(sun_path, weather, sky):
    forcing = Scene(sun_path, weather, sky, np.array([0.0]), np.array([90.0, 90.0]), np.array([90.0, 270.0])).forcing(
        96
    )
    east, west = forcing.shortwave_direct
    assert east[8 * 4] > 500 and west[8 * 4] == 0
    assert west[16 * 4] > 500 and east[16 * 4] == 0
    assert np.allclose(east[1:], west[1:][::-1], atol=1e-6)


@pytest.mark.parametrize("steps", [48, 96, 192, 288, 576])
def test_step_means_keep_the_daily_sum(steps):
    series = np.random.default_rng(1).uniform(0, 900, (3, SUN_STEPS))
    assert np.allclose(step_means(series, steps).mean(axis=1), series.mean(axis=1))
    assert np.allclose(step_means(np.full((1, SUN_STEPS), 7.0), steps), 7.0)


def test_step_means_refuse_other_steps():
    with pytest.raises(InputError, match="allowed: divisors of 576"):
        step_means(np.zeros((1, SUN_STEPS)), 100)


def test_higher_ground_is_colder_with_thinner_air(sun_path, weather, sky):
    forcing = Scene(sun_path, weather, sky, np.array([0.0, 1000.0]), np.array([0.0]), np.array([0.0])).forcing(96)
    assert np.allclose(forcing.air_temperature[0] - forcing.air_temperature[1], 6.5)
    assert forcing.pressure[1, 0] == pytest.approx(101325 * np.exp(-1 / 8), rel=1e-9)
    assert np.all(forcing.longwave_sky[1] < forcing.longwave_sky[0])
    assert np.all(forcing.vapour_pressure[1] < forcing.vapour_pressure[0])


def test_altitude_outside_the_sky_is_refused(sun_path, weather, sky):
    scene = Scene(sun_path, weather, sky, np.array([5000.0]), np.array([0.0]), np.array([0.0]))
    with pytest.raises(InputError, match="allowed: 0 to 4000 m"):
        scene.forcing(96)


def test_sun_of_another_length_is_refused():
    with pytest.raises(InputError, match="allowed: 576 finite angles"):
        SunPath(0.0, np.zeros(96), np.zeros(96))
