"""Temperatures at vertices alone: black-body radiance between the corners of a face, by hand from the tables."""

import numpy as np
import pytest

from skyshine.mat.render.frames import Renderer
from skyshine.mat.render.reads import scene_reads
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.mat.tables.loader import open_table
from skyshine.schemas.errors import InputError

HALF, HOUR, GROUND_KM = 8.0, 10.0, 0.1
# A square, y up, its texture upright seen from above with north at the top.
SQUARE = np.array(
    [
        [[-HALF, 0, HALF], [HALF, 0, HALF], [HALF, 0, -HALF]],
        [[-HALF, 0, HALF], [HALF, 0, -HALF], [-HALF, 0, -HALF]],
    ]
)
UV = np.array([[[0, 1], [1, 1], [1, 0]], [[0, 1], [1, 0], [0, 0]]], float)


@pytest.fixture(scope="module")
def tables(small_build):
    return tuple(open_table(small_build / f"{name}.h5") for name in ("s01.htt", "b01.band"))


@pytest.fixture
def square(small_build, write_glb, tmp_path):
    """Factory of a frame of a plan view, 8 x 8, of a mesh; the right half of a texture is of grass."""

    def frame(materials, parts, vertices=None, **changes):
        mesh = {"file": str(write_glb(parts, tmp_path / "mesh.glb")), "materials": materials}
        content = {
            "skyshine_scene": 1,
            "name": "square",
            "databases": str(small_build),
            "surface": {"altitude_km": GROUND_KM, "mesh": mesh, "vertices": vertices},
            "camera": {"plan_view": {"height_m": 500.0, "size": [8, 8], "width_m": 2 * HALF}},
            "hours": [HOUR],
        }
        with Renderer(load_scene(content | changes)) as renderer:
            return next(renderer.frames())

    return frame


def middles():
    """East and north of the middles of the pixels, (8, 8) each [m]."""
    step = (np.arange(8) + 0.5) * HALF / 4 - HALF
    return np.meshgrid(step, -step)


def kelvin_between(tables, corners):
    """Temperatures (8, 8) [K] from the materials of the corners of both triangles of `SQUARE`."""
    surface, band = tables
    where = {"altitude": GROUND_KM, "azimuth": 0.0, "slope": 0.0, "time": HOUR}
    x, y = (value / (2 * HALF) + 0.5 for value in middles())  # from the south-western corner
    weights = np.where(x > y, [1 - x, x - y, y], [1 - y, x, y - x])
    total = np.zeros(x.shape)
    for part, rows in zip(corners, (x > y, x <= y), strict=True):
        black = [float(band.blackbody_radiance(surface.temperature(material=name, **where))) for name in part]
        total[rows] = np.einsum("c,cn->n", black, weights[:, rows])
    return equivalent_temperature(band, total)


def test_nearest_texels_give_the_corners_their_materials(square, tables, two_materials):
    """West of asphalt, east of grass: black-body radiance runs from one to the other over the whole square."""
    textured = {"ground": {"texture": str(two_materials)}}
    frame = square(textured, [("ground", SQUARE, UV)], "nearest")
    asphalt, grass = "asphalt_road", "grass_green"
    expected = kelvin_between(tables, [(asphalt, grass, grass), (asphalt, grass, asphalt)])
    off_diagonal = ~np.eye(8, dtype=bool)[:, ::-1]
    assert np.ptp(expected) > 2
    # The vertices are 1e-3 of the face inside it.
    assert frame.surface_temperature[off_diagonal] == pytest.approx(expected[off_diagonal], abs=1e-3 * np.ptp(expected))


def test_the_centre_gives_a_face_one_temperature_and_texels_their_reflectance(square, tables, two_materials):
    """The centres of the two triangles lie in grass and in asphalt; emission is 1 - reflectance of the texel."""
    textured = {"ground": {"texture": str(two_materials)}}
    frame = square(textured, [("ground", SQUARE, UV)], "centre")
    surface, _ = tables
    where = {"altitude": GROUND_KM, "azimuth": 0.0, "slope": 0.0, "time": HOUR}
    x, y = middles()
    for name, rows in (("grass_green", x > y + 0.1), ("asphalt_road", x < y - 0.1)):
        expected = float(surface.temperature(material=name, **where))
        assert frame.surface_temperature[rows] == pytest.approx(expected, abs=1e-3)
    south_east = frame.radiance[x > y + 0.1]
    assert np.ptp(south_east[x[x > y + 0.1] > 0]) == pytest.approx(0, abs=1e-9)
    assert np.ptp(south_east) > 1e-4 * south_east.mean()


@pytest.mark.parametrize("vertices", ["centre", "nearest"])
def test_a_level_face_of_one_material_in_the_open_is_as_without(square, vertices):
    plain, at_vertices = (
        square({"ground": "asphalt_road"}, [("ground", SQUARE, None)], option) for option in (None, vertices)
    )
    assert at_vertices.radiance == pytest.approx(plain.radiance, rel=1e-5)
    assert at_vertices.apparent_temperature == pytest.approx(plain.apparent_temperature, abs=1e-3)


def test_shade_between_vertices_is_not_seen(square, tables):
    """A roof over the middle of the square: its shade ends before the corners, which alone count."""
    roof = SQUARE * [0.3, 1, 0.3] + [0, 3, 0]
    parts = [("ground", SQUARE, None), ("roof", roof, None)]
    materials = {"ground": "asphalt_road", "roof": "grass_green"}
    ground = np.max(np.abs(middles()), axis=0) > 0.35 * HALF
    plain, at_vertices = (square(materials, parts, option) for option in (None, "nearest"))
    assert np.ptp(plain.surface_temperature[ground]) > 2
    assert np.ptp(at_vertices.surface_temperature[ground]) < 0.1


def test_vertices_beyond_the_picture_are_read(square, small_build, write_glb, tmp_path):
    """A slope whose upper end no pixel shows: the needs of the scene reach it."""
    slope = SQUARE + np.where(SQUARE[..., 2:] < 0, [0, 100, 0], [0, 0, 0])
    mesh = write_glb([("ground", slope, None)], tmp_path / "slope.glb")
    content = {
        "skyshine_scene": 1,
        "name": "slope",
        "databases": str(small_build),
        "surface": {"altitude_km": GROUND_KM, "mesh": {"file": str(mesh), "materials": {"ground": "asphalt_road"}}},
        "camera": {"plan_view": {"height_m": 500.0, "size": [4, 4], "width_m": 2.0, "centre_m": [0.0, -6.0]}},
        "hours": [HOUR],
    }
    highest = []
    for vertices in (None, "nearest"):
        content["surface"]["vertices"] = vertices
        highest.append(scene_reads(load_scene(content)).surface_altitude_km[1])
    assert highest[0] < GROUND_KM + 0.025 and highest[1] == pytest.approx(GROUND_KM + 0.1, abs=1e-3)


def test_another_choice_of_texel_is_refused_at_its_key(scene_of, plain_texture):
    surface = {"altitude_km": 0.1, "plan": {"texture": str(plain_texture), "metres_per_texel": 2.0}}
    with pytest.raises(InputError, match=r"surface\.vertices: found 'corner'; input should be 'centre' or 'nearest'"):
        scene_of(surface=surface | {"vertices": "corner"})
