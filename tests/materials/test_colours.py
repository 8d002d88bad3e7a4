"""Colours of materials: against colours that are known, fixed, and told apart."""

import numpy as np
import pytest
from skimage.color import rgb2lab

from mat.maintain.materials.colours import APART, derive
from skyshine.materials import path
from skyshine.materials.colours import FILE, WAVELENGTHS, _matching, material_colours, natural_colour
from skyshine.materials.library import load_library


@pytest.fixture
def library():
    return load_library(None)


def test_matching_functions_are_those_of_the_observer():
    """Maxima of the CIE 1931 tables: x at 600 nm 1.0622, y at 555 nm 1.0000, z at 445 nm 1.7826."""
    x, y, z = _matching(np.arange(380.0, 781.0))
    assert x.max() == pytest.approx(1.0622, abs=0.03) and np.arange(380, 781)[x.argmax()] == pytest.approx(600, abs=3)
    assert y.max() == pytest.approx(1.0, abs=0.01) and np.arange(380, 781)[y.argmax()] == pytest.approx(555, abs=3)
    assert z.max() == pytest.approx(1.7826, abs=0.03) and np.arange(380, 781)[z.argmax()] == pytest.approx(445, abs=4)
    areas = np.array([x.sum(), y.sum(), z.sum()])
    np.testing.assert_allclose(areas, 106.9, rtol=0.01)  # of equal-energy white, in the tables


def test_grey_is_grey_by_its_lightness():
    """A reflectance of 0.184 has L* 50."""
    colour = natural_colour(WAVELENGTHS, np.full(WAVELENGTHS.shape, 0.18419))
    np.testing.assert_allclose(rgb2lab(colour[np.newaxis])[0], [50, 0, 0], atol=0.5)


def test_green_leaves_are_green_and_bricks_red(library):
    grass, brick, sky = (
        material_colours([name], library)[0].astype(int) for name in ("grass_green", "brick_red", "pvc_tarpaulin_blue")
    )
    assert grass.argmax() == 1 and brick.argmax() == 0 and sky.argmax() == 2
    road, snow = (material_colours([name], library)[0].astype(float) for name in ("asphalt_road", "snow_fine"))
    assert road.max() < 150 and snow.min() > 200


def test_packaged_colours_are_of_the_packaged_materials(library):
    rows = (path() / FILE).read_text().splitlines()
    assert {row.split(",")[0] for row in rows} > set(library.names)


@pytest.mark.validation  # 7 s
def test_packaged_colours_are_those_of_the_program(library):
    assert (path() / FILE).read_text() == derive()


def test_any_two_packaged_materials_are_told_apart(library):
    lab = rgb2lab(material_colours(library.names, library) / 255)
    distance = np.linalg.norm(lab[:, np.newaxis] - lab, axis=2) + 100 * np.eye(len(lab))
    assert distance.min() > APART - 0.5  # rounded to 8 bit
    assert len(lab) == len(library)


def test_a_material_has_one_colour_in_every_picture(library):
    among = material_colours(["tar", "conifer", "concrete"], library)
    assert among[1].tolist() == material_colours(["conifer"], library)[0].tolist()


def test_names_that_are_not_there_have_colours_that_differ(library):
    colours = material_colours(["x", "y", "z"], library)
    assert len(np.unique(colours, axis=0)) == 3 and (colours[:, [0, 2]] > 250).any(axis=1).all()


def test_a_material_of_ones_own_has_the_colour_of_its_spectrum(library):
    class One:
        wavelength, reflectance = np.array([0.3, 0.5, 0.51, 0.59, 0.6, 20.0]), np.array([0, 0, 0.6, 0.6, 0, 0])

    class Own(dict):
        pass

    red, green, blue = material_colours(["mine"], Own(mine=One()))[0]
    assert green > 2 * max(int(blue), 1) and green > red
