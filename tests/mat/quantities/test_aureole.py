"""Light from around the Sun, against what radiative transfer says that obstacles before it take and walls receive."""

from functools import cache

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import packaged_points, sunlight_shares
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.quantities.aureole import DIRECTIONS, SunlitSky, sunlit_sky
from skyshine.mat.quantities.radiance_field import Directions
from skyshine.mat.surface.forcing import plane_irradiance
from skyshine.mat.surface.sun_path import SOLAR_CONSTANT

ELEVATIONS = np.array([5.0, 20.0, 40.0, 60.0])


@cache
def rural(visibility):
    aerosol = Aerosol("rural", visibility)
    return AtmosphericState.from_profile("midlatitude_summer", aerosol=aerosol, surface_albedo=0.2)


@cache
def sky(visibility):
    """Sky by direction, direct normal and level diffuse irradiance (S,) at all points."""
    points, state = packaged_points().shortwave, rural(visibility)
    ground = np.array([state.surface_altitude])
    air = SpectralAir.of(state, points)
    direct, diffuse = (part[0] @ points.weight for part in sunlight_shares(air, ground, ELEVATIONS, 0.2))
    return SunlitSky.of(air, points.weight, ELEVATIONS), direct, diffuse


def of_points(state, elevation):
    """The sky by the strongest of the packaged points."""
    points = packaged_points().shortwave
    return sunlit_sky(SpectralAir.of(state, points), points.weight, elevation)


def test_the_sky_by_direction_holds_its_flux():
    whole, _, diffuse = sky(23.0)
    np.testing.assert_allclose(whole.irradiance, diffuse, rtol=0.01)


# What hides directions before a Sun in the direction x: buildings, a long wall, a tree.
OBSTACLES = {
    "building": lambda v, sun: np.abs(np.arctan2(v[..., 1], v[..., 0])) < np.radians(52),
    "narrow building": lambda v, sun: np.abs(np.arctan2(v[..., 1], v[..., 0])) < np.radians(30),
    "wall": lambda v, sun: v[..., 2] < np.tan(np.arcsin(sun[2]) + np.radians(15)) * v[..., 0],
    "tree": lambda v, sun: v @ sun > np.cos(np.radians(20)),
}


def test_a_sector_before_the_sun_holds_more_than_its_share_of_the_sky():
    """.29 of an even sky, 0.5 to 0.7 of the diffuse light."""
    share, even = sky(23.0)[0].within(OBSTACLES["building"])
    assert even == pytest.approx(52 / 180, abs=0.01)
    assert np.all((share > 0.5) & (share < 0.7))


@pytest.mark.parametrize("hazes", [(23.0,), pytest.param((8.0, 23.0, 80.0), marks=pytest.mark.validation)])  # 7 s
def test_what_obstacles_before_the_sun_leave_of_the_sky(hazes):
    """Diffuse light on level ground, W/m2 rms over obstacles, Suns and hazes, by the share, by none, and by Hay and
    Davies (their split as shade would take it)."""
    errors = {"share": [], "none": [], "hay": []}
    for visibility in hazes:
        whole, direct, diffuse = sky(visibility)
        around = of_points(rural(visibility), ELEVATIONS).aureole
        for hides in OBSTACLES.values():
            share, even = whole.within(hides)
            of = {"share": around, "none": 0.0, "hay": direct / SOLAR_CONSTANT}
            for name, aureole in of.items():
                errors[name].append(((1 - aureole) * (1 - even) - (1 - share)) * diffuse)
    rms = {name: np.sqrt(np.mean(np.square(values))) for name, values in errors.items()}
    assert rms["share"] < 0.45 * min(rms["none"], rms["hay"]) and rms["share"] < 15
    assert abs(np.mean(errors["share"])) < 5 < np.mean(errors["none"])


@pytest.mark.parametrize("hazes", [(8.0,), pytest.param((8.0, 23.0, 80.0), marks=pytest.mark.validation)])  # 8 s
@pytest.mark.validation  # 5 s
def test_walls_receive_as_much_as_by_hay_and_davies(hazes):
    """Diffuse light of the sky on slopes and walls at four turns from the Sun: as near as by their published split."""
    errors = {"share": [], "hay": []}
    up = DIRECTIONS.cosine > 0
    for visibility in hazes:
        whole, direct, diffuse = sky(visibility)
        share = of_points(rural(visibility), ELEVATIONS).aureole
        for slope in (30.0, 60.0, 90.0):
            for turn in (0.0, 45.0, 90.0, 180.0):
                s, a = np.radians(slope), np.radians(turn)
                normal = np.array([np.sin(s) * np.cos(a), np.sin(s) * np.sin(a), np.cos(s)])
                exact = np.einsum("da,sda->s", DIRECTIONS.irradiance_weights(normal)[up], whole.radiance)
                for name, aureole in (("share", share), ("hay", direct / SOLAR_CONSTANT)):
                    _, ours, _ = plane_irradiance(slope, turn, ELEVATIONS, 0.0, 0.0, diffuse, 0.0, aureole)
                    errors[name].append(ours - exact)
    rms = {name: np.sqrt(np.mean(np.square(values))) for name, values in errors.items()}
    assert rms["share"] < 1.1 * rms["hay"] < 40


@pytest.mark.validation  # 4 s
def test_few_points_and_directions_are_enough():
    state, points = rural(23.0), packaged_points().shortwave
    few = of_points(state, ELEVATIONS).aureole
    fine = SunlitSky.of(SpectralAir.of(state, points), points.weight, ELEVATIONS, Directions.of(16, 24)).aureole
    np.testing.assert_allclose(few, fine, atol=0.012)
    assert np.all((few > 0.1) & (few < 0.4))


def test_fog_has_hardly_an_aureole_at_a_low_sun():
    assert of_points(rural(1.0), np.array([5.0])).aureole[0] < 0.03


@pytest.mark.parametrize("elevation", [90.0, 0.0])
def test_ends_of_the_elevations_are_finite(elevation):
    assert 0 <= of_points(rural(23.0), np.array([elevation])).aureole[0] < 1
