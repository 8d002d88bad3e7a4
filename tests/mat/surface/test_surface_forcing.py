"""Sun, sky and weather on planes: geometry, limits, conservation."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.surface.forcing import (
    Scene,
    plane_irradiance,
    sky_irradiance,
    sky_longwave,
    step_means,
)
from skyshine.mat.surface.site import SUN_STEPS, Site
from skyshine.schemas.errors import InputError

STEFAN_BOLTZMANN = 5.670374419e-8


def at_hour(hour):
    return int(hour * SUN_STEPS / 24)


def test_clear_sky_of_a_summer_noon(site, sky):
    """Pyrheliometers read 800 to 1000 W/m2 under a clear sky with the Sun near the zenith; more higher up."""
    direct, diffuse = sky_irradiance(site, sky, 0.0, np.array([0.0, 3000.0]))
    noon = at_hour(12)
    assert 800 < direct[0, noon] < 950
    assert 70 < diffuse[0, noon] < 180
    assert 950 < direct[1, noon] < 1120


def test_clear_sky_is_finite_and_dark_at_night_and_fades_towards_the_horizon(make_site, sky):
    elevation = np.linspace(-90, 90, SUN_STEPS)
    direct, diffuse = sky_irradiance(Site(0.0, elevation, np.zeros(SUN_STEPS)), sky, 0.0, np.array([0.0, 4000.0]))
    assert np.all(np.isfinite(direct)) and np.all(np.isfinite(diffuse))
    assert np.all(direct[:, elevation <= 0] == 0) and np.all(diffuse[:, elevation <= 0] == 0)
    assert np.all(np.diff(direct[:, elevation > 0], axis=1) > 0)
    assert np.all(direct[0, (elevation > 0) & (elevation < 1)] < 10)
    assert np.all((diffuse >= 0) & (direct >= 0))


@pytest.mark.parametrize("water", [0.0, 70.0])
@pytest.mark.parametrize("aerosol", [0.0, 60.0])
def test_extreme_skies_stay_finite(site, sky, water, aerosol):
    """Bone dry and aerosol-free to tropical in a dust storm."""
    extreme = replace(
        sky,
        precipitable_water=np.full(9, water),
        aerosol_optical_depth_380=np.full(9, 1.3 * aerosol),
        aerosol_optical_depth_500=np.full(9, aerosol),
    )
    direct, diffuse = sky_irradiance(site, extreme, 0.0, np.array([0.0, 4000.0]))
    assert np.all((direct >= 0) & (direct < 1361)) and np.all((diffuse >= 0) & (diffuse < 1361))
    assert direct.max() > 900 if aerosol == 0 else direct.max() < 1


def test_overcast_leaves_a_quarter_and_no_shadow(site, sky):
    """Kasten and Czeplak: global irradiance under 8 octas is 0.25 of the clear one."""
    height = np.array([0.0])
    direct, diffuse = sky_irradiance(site, sky, 0.0, height)
    cloud_direct, cloud_diffuse = sky_irradiance(site, sky, 1.0, height)
    level = direct * np.sin(np.radians(site.solar_elevation)) + diffuse
    assert np.all(cloud_direct == 0)
    assert np.allclose(cloud_diffuse, 0.25 * level, rtol=1e-9)


def test_sky_longwave_of_a_temperate_night():
    """Prata's emissivity with 1 and 2 cm of water: 0.7424 and 0.7950 by hand; overcast is nearly black."""
    black = STEFAN_BOLTZMANN * 288.0**4
    assert sky_longwave(288.0, [10.0, 20.0], 0.0) / black == pytest.approx([0.7424, 0.7950], abs=2e-4)
    assert 0.95 < sky_longwave(288.0, 20.0, 1.0) / black < 1.0
    assert sky_longwave(288.0, 0.0, 0.0) > 0


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


def test_east_wall_is_lit_in_the_morning(site, weather, sky):
    forcing = Scene(site, weather, sky, np.array([0.0]), np.array([90.0, 90.0]), np.array([90.0, 270.0])).forcing(96)
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


def test_higher_ground_is_colder_with_thinner_air(site, weather, sky):
    forcing = Scene(site, weather, sky, np.array([0.0, 1000.0]), np.array([0.0]), np.array([0.0])).forcing(96)
    assert np.allclose(forcing.air_temperature[0] - forcing.air_temperature[1], 6.5)
    assert forcing.pressure[1, 0] == pytest.approx(101325 * np.exp(-1 / 8), rel=1e-9)
    assert np.all(forcing.longwave_sky[1] < forcing.longwave_sky[0])
    assert np.all(forcing.vapour_pressure[1] < forcing.vapour_pressure[0])


def test_altitude_outside_the_sky_is_refused(site, weather, sky):
    scene = Scene(site, weather, sky, np.array([5000.0]), np.array([0.0]), np.array([0.0]))
    with pytest.raises(InputError, match="allowed: 0 to 4000 m"):
        scene.forcing(96)


def test_sun_of_another_length_is_refused():
    with pytest.raises(InputError, match="allowed: 576 finite angles"):
        Site(0.0, np.zeros(96), np.zeros(96))
