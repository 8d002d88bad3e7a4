"""Light of pixels in the shade and beside walls: the formulas of the pages, and their limits."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance, sky_radiance
from skyshine.mat.runtime.walls import beside_walls, wall_as_it_shines
from skyshine.mat.tables.loader import open_table

COUNT = 4


@pytest.fixture(scope="module")
def tables(small_build):
    return tuple(open_table(small_build / f"{name}.h5") for name in ("s01.htt", "b01.band", "s01b01.atmq"))


@pytest.fixture
def view():
    one = np.ones(COUNT)
    up = np.tile([0.0, 0.0, 1.0], (COUNT, 1))
    sun = np.tile([0.0, -0.5, 0.8], (COUNT, 1))
    to_observer = np.tile([0.5, 0.5, 0.7], (COUNT, 1))
    return View(LinesOfSight(one, 0.6 * one, -30 * one, 50 * one, 90 * one), one, up, sun, to_observer)


@pytest.fixture
def faces(tables):
    zero = np.zeros(COUNT)
    code = np.full((COUNT, 1), tables[0].materials["asphalt_road"])
    return Faces(code, np.ones((COUNT, 1)), 0.1 + zero, zero, zero, 12.0 + zero)


def test_light_beside_a_wall_is_the_formula_of_the_page():
    """L + (1 - w) (1 + cos b) / 2 (W - L_level), W = eps B(T_w) + (1 - eps) (L_level + B(T_g)) / 2."""
    values, place = (5.0, 4.0, 9.0, 7.0), (np.array([0.3]), np.array([0.5]), 0.9)
    light = beside_walls(*(np.array([value]) for value in values), *place)
    assert light == pytest.approx([5.0 + 0.7 * 0.75 * (0.9 * 9.0 + 0.1 * 5.5 - 4.0)])
    parted = beside_walls(
        *(np.array([[v, 2 * v]]) for v in (5.0, 4.0, 9.0, 7.0)), np.array([0.3]), np.array([0.5]), 0.9
    )
    assert parted == pytest.approx(np.array([[1.0, 2.0]]) * light)


def test_a_wall_as_it_shines_sends_what_the_sunlit_wall_emits_and_reflects(tables):
    """L = eps B(T) + (1 - eps) around + (1 - eps) cos E: read back from the plain wall at the temperature told."""
    band = tables[1]
    kelvin, emissivity, around, direct = np.array([300.0, 290.0]), np.array([0.8, 0.95]), np.array([3.0, 5.0]), 2.0
    emitted = emissivity * band.blackbody_radiance(kelvin)
    sunlit = (1 - emissivity) * np.array([0.7, 0.0]) * direct
    shines = wall_as_it_shines(band, emitted, 1 - emissivity, around, sunlit)
    plain = 0.95 * band.blackbody_radiance(shines) + 0.05 * around
    assert plain == pytest.approx(emitted + (1 - emissivity) * around + sunlit, rel=1e-5)
    assert shines[1] == pytest.approx(290.0, abs=1e-3)


def test_shade_takes_the_direct_light_and_nothing_else(tables, faces, view):
    sunlit = pixel_radiance(*tables, faces, view)
    half = pixel_radiance(*tables, replace(faces, lit_share=np.array([1.0, 0.5, 0.0, 0.0])), view)
    assert half.diffuse == pytest.approx(sunlit.diffuse * [1.0, 0.5, 0.0, 0.0])
    assert half.specular == pytest.approx(sunlit.specular * [1.0, 0.5, 0.0, 0.0])
    for term in ("thermal", "path", "skyshine"):
        assert np.array_equal(getattr(half, term), getattr(sunlit, term))
    assert np.all(sunlit.diffuse > 0)


def test_an_open_sky_is_a_sky_view_of_1_and_a_warm_wall_adds_light(tables, faces, view):
    open_sky = pixel_radiance(*tables, faces, view)
    walled = replace(faces, sky_view=np.array([1.0, 0.9, 0.5, 0.0]), wall_temperature=np.full(COUNT, 310.0))
    among = pixel_radiance(*tables, walled, view)
    assert among.skyshine[0] == pytest.approx(open_sky.skyshine[0], rel=1e-12)
    assert np.all(np.diff(among.skyshine) > 0)
    assert among.radiance - open_sky.radiance == pytest.approx(among.skyshine - open_sky.skyshine)


def test_a_wall_of_black_bodies_all_around_fills_the_sky(tables, faces, view):
    """No sky, and a wall as warm as the ground: emissivity times what it emits, and half of both again."""
    surface, band, air = tables
    ground = air.ground_temperature(surface, time=np.full(COUNT, 12.0))
    walled = replace(faces, sky_view=np.zeros(COUNT), wall_temperature=ground)
    among = pixel_radiance(*tables, walled, view)
    level = air.value("ambient_radiance", range=1.0, altitude=0.6, elevation=-30.0, source_elevation=50.0)
    black = band.blackbody_radiance(ground)
    reflectance = band.value("reflectance", material="asphalt_road")
    expected = (0.95 * black + 0.05 * (level + black) / 2) * reflectance * among.transmittance
    assert among.skyshine == pytest.approx(expected, rel=0.02)  # reflectance varies within the band


def test_a_line_into_the_air_is_the_path_of_a_pixel_there(tables, faces, view):
    path = pixel_radiance(*tables, faces, view).path
    assert sky_radiance(tables[2], view) == pytest.approx(path, rel=1e-12)
