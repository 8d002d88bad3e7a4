"""Light from around the Sun, against what radiative transfer says that obstacles before it take and walls receive."""

from functools import cache

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import packaged_points, sunlight_shares
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.quantities.aureole import DIRECTIONS, aureole_shares, sunlit_sky
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
    """Radiance (S, D, A), level diffuse irradiance and direct normal irradiance (S,) at all points."""
    points, state = packaged_points().shortwave, rural(visibility)
    ground = np.array([state.surface_altitude])
    direct, diffuse = (part[0] @ points.weight for part in sunlight_shares(state, points, ground, ELEVATIONS, 0.2))
    return sunlit_sky(state, points, ELEVATIONS), diffuse, direct


def upper():
    up = DIRECTIONS.cosine > 0
    level = (DIRECTIONS.solid_angle * DIRECTIONS.cosine[:, None])[up]
    return DIRECTIONS.samples[up], np.broadcast_to(level, (level.size, DIRECTIONS.azimuths))


def test_the_sky_by_direction_holds_its_flux():
    radiance, diffuse, _ = sky(23.0)
    _, level = upper()
    np.testing.assert_allclose(np.sum(level * radiance, axis=(1, 2)), diffuse, rtol=0.01)


def obstacles(elevation):
    """What hides directions (..., 3) before a Sun in the direction x: a building, a long wall, a tree."""
    sun = np.array([np.cos(np.radians(elevation)), 0.0, np.sin(np.radians(elevation))])
    return {
        "building": lambda v: np.abs(np.arctan2(v[..., 1], v[..., 0])) < np.radians(52),
        "narrow building": lambda v: np.abs(np.arctan2(v[..., 1], v[..., 0])) < np.radians(30),
        "wall": lambda v: v[..., 2] < np.tan(np.radians(elevation + 15)) * v[..., 0],
        "tree": lambda v: v @ sun > np.cos(np.radians(20)),
    }


def test_what_obstacles_before_the_sun_leave_of_the_sky():
    """Diffuse light on level ground, W/m2 rms over obstacles, Suns and hazes, by the share, by none, and by Hay and
    Davies (their split as shade would take it)."""
    samples, level = upper()
    errors = {"share": [], "none": [], "hay": []}
    for visibility in (8.0, 23.0, 80.0):
        radiance, diffuse, direct = sky(visibility)
        share = aureole_shares(rural(visibility), packaged_points().shortwave, ELEVATIONS)
        for number, elevation in enumerate(ELEVATIONS):
            for hides in obstacles(elevation).values():
                covered = level * hides(samples).mean(axis=-1)
                left = diffuse[number] - np.sum(covered * radiance[number])
                even = 1 - covered.sum() / level.sum()
                of = {"share": share[number], "none": 0.0, "hay": direct[number] / SOLAR_CONSTANT}
                for name, aureole in of.items():
                    errors[name].append((1 - aureole) * even * diffuse[number] - left)
    rms = {name: np.sqrt(np.mean(np.square(values))) for name, values in errors.items()}
    assert rms["share"] < 0.45 * min(rms["none"], rms["hay"]) and rms["share"] < 15
    assert abs(np.mean(errors["share"])) < 5 < np.mean(errors["none"])


def test_walls_receive_as_much_as_by_hay_and_davies():
    """Diffuse light of the sky on slopes and walls at four turns from the Sun: as near as by their published split."""
    errors = {"share": [], "hay": []}
    up = DIRECTIONS.cosine > 0
    for visibility in (8.0, 23.0, 80.0):
        radiance, diffuse, direct = sky(visibility)
        share = aureole_shares(rural(visibility), packaged_points().shortwave, ELEVATIONS)
        for slope in (30.0, 60.0, 90.0):
            for turn in (0.0, 45.0, 90.0, 180.0):
                s, a = np.radians(slope), np.radians(turn)
                normal = np.array([np.sin(s) * np.cos(a), np.sin(s) * np.sin(a), np.cos(s)])
                exact = np.einsum("da,sda->s", DIRECTIONS.irradiance_weights(normal)[up], radiance)
                for name, aureole in (("share", share), ("hay", direct / SOLAR_CONSTANT)):
                    _, ours, _ = plane_irradiance(slope, turn, ELEVATIONS, 0.0, 0.0, diffuse, 0.0, aureole)
                    errors[name].append(ours - exact)
    rms = {name: np.sqrt(np.mean(np.square(values))) for name, values in errors.items()}
    assert rms["share"] < 1.1 * rms["hay"] < 40


def test_few_points_and_directions_are_enough():
    state, points = rural(23.0), packaged_points().shortwave
    few = aureole_shares(state, points, ELEVATIONS)
    fine = aureole_shares(state, points, ELEVATIONS, Directions.of(16, 24))
    np.testing.assert_allclose(few, fine, atol=0.012)
    assert np.all((few > 0.1) & (few < 0.4))


def test_fog_has_hardly_an_aureole_at_a_low_sun():
    assert aureole_shares(rural(1.0), packaged_points().shortwave, np.array([5.0]))[0] < 0.03


@pytest.mark.parametrize("elevation", [90.0, 0.0])
def test_ends_of_the_elevations_are_finite(elevation):
    assert 0 <= aureole_shares(rural(23.0), packaged_points().shortwave, np.array([elevation]))[0] < 1
