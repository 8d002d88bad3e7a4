"""Rays: first hits and shadows, by Embree as by a plain test of all triangles; cameras."""

from pathlib import Path

import numpy as np
import pytest
import tifffile

from skyshine.mat.render.camera import check_above_ground, view_rays
from skyshine.mat.render.rays import EmbreeCaster, FewTriangles, ray_caster
from skyshine.mat.render.surface import surface_of_scene
from skyshine.mat.render.surface_mesh import Covering, surface_of
from skyshine.schemas.errors import InputError


def surface_with(triangles):
    covering = (Covering("asphalt_road", None, ()),)
    return surface_of(triangles, np.zeros(len(triangles)), covering, np.zeros((len(triangles), 3, 2)), 0.1, Path("x"))


def still(position, look_at, **changes):
    perspective = {"field_of_view_deg": 90.0, "size": [4, 2], "position_m": position, "look_at_m": look_at} | changes
    return {"perspective": perspective}


def test_embree_meets_what_a_plain_test_meets():
    draw = np.random.default_rng(5)
    surface = surface_with(draw.uniform(-50, 50, (40, 3, 3)))
    origin, ahead = draw.uniform(-80, 80, (5000, 3)), draw.normal(size=(5000, 3))
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    fast, plain = EmbreeCaster(surface).first(origin, ahead), FewTriangles(surface).first(origin, ahead)
    same = fast.face == plain.face
    assert same.mean() > 0.999  # single precision decides otherwise at edges alone
    assert 0.1 < plain.met.mean() < 0.9
    met = same & plain.met
    assert fast.distance[met] == pytest.approx(plain.distance[met], rel=1e-4, abs=1e-3)
    assert surface.points(fast.face[met], fast.weights[met]) == pytest.approx(
        origin[met] + fast.distance[met, None] * ahead[met], abs=0.02
    )
    blocked = EmbreeCaster(surface).blocked(origin, ahead)
    assert (blocked == fast.met).mean() > 0.999


@pytest.mark.parametrize("caster", [EmbreeCaster, FewTriangles])
def test_no_ray_passes_between_two_triangles(caster):
    square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]], float)
    along = np.linspace(0, 1, 1001)[:, None] * [[1.0, 1.0, 0.0]] + [[0.0, 0.0, 2.0]]
    assert caster(surface_with(square)).first(along, np.tile([0.0, 0.0, -1.0], (1001, 1))).met.all()


def test_a_plan_view_sees_every_texel_once(scene_of):
    scene = scene_of()
    surface = surface_of_scene(scene)
    rays = view_rays(scene, surface, 0)
    hits = ray_caster(surface).first(rays.origin, rays.direction)
    assert hits.met.all()
    assert hits.distance == pytest.approx(500.0)
    uv = surface.texture_coordinates(hits.face, hits.weights).reshape(4, 8, 2)
    assert uv[..., 0] * 8 == pytest.approx(np.tile(np.arange(8) + 0.5, (4, 1)))
    assert uv[..., 1] * 4 == pytest.approx(np.tile(np.arange(4)[:, None] + 0.5, (1, 8)))
    assert rays.elevation == pytest.approx(-90.0)
    assert rays.altitude == pytest.approx(0.6)


def test_a_turned_plan_is_upright_in_its_plan_view(scene_of, plain_texture):
    surface_keys = {
        "altitude_km": 0.1,
        "plan": {"texture": str(plain_texture), "metres_per_texel": 2.0, "top_azimuth_deg": 30.0},
    }
    scene = scene_of(surface=surface_keys)
    surface = surface_of_scene(scene)
    rays = view_rays(scene, surface, 0)
    hits = ray_caster(surface).first(rays.origin, rays.direction)
    assert surface.texture_coordinates(hits.face, hits.weights)[0] == pytest.approx([0.5 / 8, 0.5 / 4])


def test_the_middle_of_a_picture_looks_where_the_camera_points(scene_of):
    scene = scene_of(camera=still([0, 0, 10], [10, 10, 0], size=[3, 3]))
    rays = view_rays(scene, surface_of_scene(scene), 0)
    assert rays.azimuth[4] == pytest.approx(45.0)
    assert rays.elevation[4] == pytest.approx(-np.degrees(np.arctan(10 / np.hypot(10, 10))))
    assert rays.azimuth[5] > 45.0  # to the right
    assert rays.elevation[1] > rays.elevation[4]  # upwards


def test_the_field_of_view_spans_the_outer_edges(scene_of):
    scene = scene_of(camera=still([0, 0, 10], [0, 50, 10], size=[1000, 2], field_of_view_deg=60.0))
    rays = view_rays(scene, surface_of_scene(scene), 0)
    half_pixel = np.degrees(rays.spread[0]) / 2
    assert rays.azimuth[0] - half_pixel == pytest.approx(330.0, abs=0.01)


def test_a_camera_that_looks_straight_down_has_north_at_the_top(scene_of):
    scene = scene_of(camera=still([0, 0, 10], [0, 0, 0], size=[2, 2]))
    rays = view_rays(scene, surface_of_scene(scene), 0)
    assert rays.direction[0, 0] < 0 < rays.direction[0, 1]


def test_a_camera_below_the_ground_is_refused(scene_of):
    scene = scene_of(camera=still([0, 0, -3], [0, 1, -3]))
    surface = surface_of_scene(scene)
    with pytest.raises(InputError, match="found a camera 3 m below the surface"):
        check_above_ground(scene, surface, ray_caster(surface))


def test_an_observer_below_the_highest_point_is_refused(scene_of, plain_texture, tmp_path):
    tifffile.imwrite(tmp_path / "hill.tif", np.array([[0, 9], [0, 0]], np.uint8))
    hill = {"texture": str(plain_texture), "metres_per_texel": 2.0, "height_map": {"image": str(tmp_path / "hill.tif")}}
    camera = {"plan_view": {"height_m": 5, "size": [8, 4]}}
    scene = scene_of(surface={"altitude_km": 0.1, "plan": hill}, camera=camera)
    surface = surface_of_scene(scene)
    with pytest.raises(InputError, match="whose highest point is at 9 m"):
        check_above_ground(scene, surface, ray_caster(surface))
