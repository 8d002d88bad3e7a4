"""Pixels of which a part lies in the shade all day: the sum of two pixels."""

from dataclasses import fields, replace

import numpy as np
import pytest

from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.runtime.pixel import Faces, PixelRadiance, View, pixel_radiance
from skyshine.mat.tables.loader import open_table
from skyshine.schemas.errors import InputError

COUNT = 5
SHADE = np.array([0.0, 0.25, 0.5, 0.9, 1.0])
DARK_SKY = 0.35


@pytest.fixture(scope="module")
def tables(small_build):
    return tuple(open_table(small_build / f"{name}.h5") for name in ("s01.htt", "b01.band", "s01b01.atmq"))


@pytest.fixture
def view():
    one = np.ones(COUNT)
    normal = np.tile([0.1, -0.2, 0.9], (COUNT, 1))
    sun = np.tile([0.0, -0.5, 0.8], (COUNT, 1))
    to_observer = np.tile([0.5, 0.5, 0.7], (COUNT, 1))
    lines = LinesOfSight(one, 0.6 * one, -30 * one, 50 * one, 90 * one)
    return View(lines, one, normal, sun, to_observer, 170 * one)


@pytest.fixture
def faces(tables):
    """Of two materials, at several hours of the day."""
    one = np.ones(COUNT)
    codes = np.tile([tables[0].materials[name] for name in ("asphalt_road", "grass_green")] + [0], (COUNT, 1))
    shares = np.tile([0.6, 0.4, 0.0], (COUNT, 1))
    return Faces(codes, shares, 0.1 * one, 200 * one, 15 * one, np.array([9.0, 12.0, 12.0, 15.0, 21.0]))


def shaded(faces):
    return replace(faces, shade=SHADE, shaded_sky=np.full(COUNT, DARK_SKY))


def in_the_shade(tables, faces, sky_view):
    """The same faces in the shade as a whole, from the calls of the table alone."""
    surface, _, _ = tables
    wall = surface.value("air_temperature", altitude=faces.altitude, forcing_time=faces.time)
    kelvin = np.zeros(faces.shares.shape)
    for row, part in zip(*np.nonzero(faces.shares), strict=True):
        kelvin[row, part] = surface.shaded_temperature(
            material=int(faces.codes[row, part]),
            sky_view=float(sky_view[row]),
            altitude=faces.altitude[row],
            azimuth=faces.azimuth[row],
            slope=faces.slope[row],
            time=faces.time[row],
        )
    kelvin[:, 2] = kelvin[:, 0]
    return replace(faces, temperature=kelvin, lit_share=np.zeros(COUNT), sky_view=sky_view, wall_temperature=wall)


@pytest.mark.parametrize("own", [None, 0.8, 0.2])
def test_a_pixel_partly_in_the_shade_is_the_sum_of_its_parts(tables, faces, view, own):
    """Each term by the shares: of the lit part, and of one without direct light under the smaller sky."""
    sky = np.full(COUNT, 1.0 if own is None else own)
    wall = tables[0].value("air_temperature", altitude=faces.altitude, forcing_time=faces.time)
    if own is not None:
        faces = replace(faces, sky_view=sky, wall_temperature=wall)
    found = pixel_radiance(*tables, shaded(faces), view)
    bright = pixel_radiance(*tables, faces, view)
    dark = pixel_radiance(*tables, in_the_shade(tables, faces, np.minimum(sky, DARK_SKY)), view)
    for field in fields(PixelRadiance):
        parts = (1 - SHADE) * getattr(bright, field.name) + SHADE * getattr(dark, field.name)
        np.testing.assert_allclose(getattr(found, field.name), parts, rtol=1e-11, atol=1e-13, err_msg=field.name)
    assert np.all(dark.diffuse == 0) and bright.diffuse[1] > 0 and bright.temperature[1] - dark.temperature[1] > 5


def test_the_light_of_the_sky_in_the_shade_is_the_formula_of_the_page(tables, faces, view):
    """Light of the open sky's share and of a wall as warm as the air, reflected evenly over the narrow band."""
    surface, band, air = tables
    place = {"range": 1.0, "altitude": 0.6, "elevation": -30.0, "source_elevation": 50.0}
    level = air.value("ambient_radiance", **place)
    kelvin = air.ground_temperature(surface, time=12.0)
    face = air.ambient_radiance(slope=15.0, azimuth=30.0, ground_temperature=kelvin, band=band, **place)
    wall = band.blackbody_radiance(surface.value("air_temperature", altitude=0.1, forcing_time=12.0))
    ground = band.blackbody_radiance(kelvin)
    hidden = (1 - DARK_SKY) * (1 + np.cos(np.radians(15.0))) / 2
    expected = face + 0.5 * hidden * (0.95 * wall + 0.05 * (level + ground) / 2 - level)
    reflectance = 0.6 * band.value("reflectance", material="asphalt_road") + 0.4 * band.value(
        "reflectance", material="grass_green"
    )
    found = pixel_radiance(*tables, shaded(faces), view)
    assert found.skyshine[2] == pytest.approx(expected * reflectance * found.transmittance[2], rel=0.01)


def test_without_shade_nothing_changes(tables, faces, view):
    plain = pixel_radiance(*tables, faces, view)
    none = pixel_radiance(*tables, replace(faces, shade=np.zeros(COUNT), shaded_sky=np.zeros(COUNT)), view)
    among = pixel_radiance(*tables, shaded(faces), view)
    for field in fields(PixelRadiance):
        assert np.array_equal(getattr(plain, field.name), getattr(none, field.name))
        assert getattr(plain, field.name)[0] == pytest.approx(getattr(among, field.name)[0], rel=1e-14)


def test_the_sky_of_the_shade_is_half_open_where_nothing_is_said(tables, faces, view):
    default = pixel_radiance(*tables, replace(faces, shade=SHADE), view)
    half = pixel_radiance(*tables, replace(faces, shade=SHADE, shaded_sky=np.full(COUNT, 0.5)), view)
    assert np.array_equal(default.radiance, half.radiance)


def test_temperatures_that_are_given_stand(tables, faces, view):
    given = np.full(faces.shares.shape, 300.0)
    found = pixel_radiance(*tables, shaded(replace(faces, temperature=given, shaded_temperature=given - 10)), view)
    assert found.temperature == pytest.approx(300.0 - 10 * SHADE)


def test_a_file_without_the_response_refuses_shade_in_one_line(tables, faces, view):
    surface, band, air = tables
    kept = {name: held for name, held in surface.root.variables.items() if name in ("temperature", "material_name")}
    bare = replace(surface, root=replace(surface.root, variables=kept))
    assert pixel_radiance(bare, band, air, faces, view).radiance.shape == (COUNT,)
    with pytest.raises(InputError, match=r"has no response to shade; build it again, without needs.shade: false$"):
        pixel_radiance(bare, band, air, shaded(faces), view)


@pytest.mark.parametrize("share", [-0.1, 1.1, np.nan])
def test_a_share_beyond_the_whole_is_refused(tables, faces, view, share):
    wrong = np.array([0.5, 0.5, 0.5, 0.5, share])
    with pytest.raises(InputError, match="share in the shade beyond 0 to 1"):
        pixel_radiance(*tables, replace(faces, shade=wrong), view)
