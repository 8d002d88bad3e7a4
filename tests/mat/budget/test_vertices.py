"""Materials of vertices by the textures, and what temperatures at vertices alone make of a pixel."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.budget import vertices
from skyshine.mat.budget.vertices import CENTRE, NEAREST, drawn_materials, vertex_materials

NAMES = ("asphalt_road", "grass_green", "soil")
FILE = Path("stripes.tmm.h5")


@pytest.fixture
def textures(monkeypatch):
    """Make `vertex_materials` read a texture of codes (h, w): 1 asphalt, 2 grass, 3 a material that is not known."""

    class Texture(SimpleNamespace):
        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

    def show(codes):
        materials = dict(enumerate(("asphalt_road", "grass_green", "water"), 1))
        texture = Texture(
            width=codes.shape[1],
            height=codes.shape[0],
            materials=materials,
            code=lambda x, y: codes[np.floor(y).astype(int), np.floor(x).astype(int)],
        )
        monkeypatch.setattr(vertices, "open_tmm", lambda file: texture)
        return vertex_materials([FILE], NAMES, np.random.default_rng(3))

    return show


def test_a_texture_of_one_material_has_vertices_of_it(textures):
    for share in textures(np.ones((64, 64), int)).values():
        assert np.array_equal(share, np.eye(3))


def test_a_texture_of_no_known_material_says_nothing(textures):
    assert textures(np.full((64, 64), 3)) == {}
    assert vertex_materials([], NAMES, np.random.default_rng(3)) == {}


def test_stripes_finer_than_faces_leave_vertices_to_chance(textures):
    """Texels of asphalt and grass in turn: the centre is of either, in the shares of the texture."""
    codes = 1 + (np.arange(512)[None, :] + np.arange(512)[:, None]) % 2
    shares = textures(codes)
    for way in (CENTRE, NEAREST):
        assert shares[way][:2, :2] == pytest.approx(np.full((2, 2), 0.5), abs=0.05)
        assert shares[way][2] == pytest.approx([0, 0, 1])


def test_two_halves_change_materials_as_often_as_lines_cross_their_border(textures):
    """By integration over places, lengths and directions of faces: of the centre a quarter of the crossing lines'
    pixels are on its other side, of the vertices a half by their weights.
    """
    codes = np.ones((64, 64), int)
    codes[:, 32:] = 2
    shares = textures(codes)
    draw = np.random.default_rng(4)
    length, angle = 8 * 8 ** draw.random(400_000), draw.uniform(0, 2 * np.pi, 400_000)
    across, down = length * np.cos(angle), length * np.sin(angle)
    x, y, place = 64 * draw.random(400_000), 64 * draw.random(400_000), draw.random(400_000)
    inside = (np.abs(x + across - 32) < 32) & (np.abs(y + down - 32) < 32)
    pixel, ends, middle = x + place * across, (x, x + across), x + 0.5 * across
    left = inside & (pixel < 32)
    other = [np.mean(middle[left] >= 32)]
    other.append(np.mean((1 - place[left]) * (ends[0][left] >= 32) + place[left] * (ends[1][left] >= 32)))
    for way, expected in zip((CENTRE, NEAREST), other, strict=True):
        assert 0.02 < expected < 0.4
        assert shares[way][0, 1] == pytest.approx(expected, abs=0.01)
        assert shares[way][1, 0] == pytest.approx(expected, abs=0.01)


def test_unknown_materials_are_not_counted(textures):
    codes = np.ones((64, 64), int)
    codes[:, 32:] = 3
    for share in textures(codes).values():
        assert np.array_equal(share, np.eye(3))


def test_materials_are_assigned_in_their_shares():
    share = np.array([[0.7, 0.3, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, 0.6]])
    assigned = drawn_materials(share, np.random.default_rng(2), (20_000, 3))
    counts = np.array([np.bincount(column, minlength=3) for column in assigned.T]) / 20_000
    assert counts == pytest.approx(share, abs=0.02) and np.all(counts[share == 0] == 0)


def test_without_a_test_of_the_textures_every_material_is_right():
    assert np.array_equal(drawn_materials(None, np.random.default_rng(2), (4, 3)), [[0, 1, 2]] * 4)
