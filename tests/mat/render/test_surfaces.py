"""Plans and meshes as triangles: extents, slopes, materials, and the files that are refused."""

import dataclasses

import numpy as np
import pytest
import tifffile

from skyshine.mat.quantities.lines_of_sight import direction, slope_and_azimuth
from skyshine.mat.render.surface import SurfaceMaterials, surface_of_scene
from skyshine.schemas.errors import InputError

SQUARE = np.array([[[0, 0, 0], [4, 0, 0], [4, 0, -4]], [[0, 0, 0], [4, 0, -4], [0, 0, -4]]], float)  # level, y up
UV = np.array([[[0, 1], [1, 1], [1, 0]], [[0, 1], [1, 0], [0, 0]]], float)


def plan(texture, **changes):
    return {"altitude_km": 0.1, "plan": {"texture": str(texture), "metres_per_texel": 2.0} | changes}


def mesh(file, materials, **changes):
    return {"altitude_km": 0.1, "mesh": {"file": str(file), "materials": materials} | changes}


def test_a_plan_covers_its_image_around_the_origin(scene_of):
    surface = surface_of_scene(scene_of())
    assert surface.bounds.tolist() == [[-8, -4, 0], [8, 4, 0]]
    assert surface.area.sum() == pytest.approx(16 * 8)
    assert surface.slope.tolist() == [0, 0]
    assert surface.altitudes == (0.1, 0.1)


def test_the_top_of_a_plan_points_where_the_scene_says(scene_of, plain_texture):
    surface = surface_of_scene(scene_of(surface=plan(plain_texture, top_azimuth_deg=90)))
    top = surface.triangles[surface.uv[..., 1] == 0]
    assert top[:, 0] == pytest.approx(4.0)  # to the east
    left = surface.triangles[surface.uv[..., 0] == 0]
    assert left[:, 1] == pytest.approx(8.0)  # left of east is north


def test_a_ramp_of_heights_has_its_slope_and_azimuth(scene_of, plain_texture, tmp_path):
    """Rising 1 m per metre to the north over 8 m: it faces south at 45 degrees between the outermost values."""
    tifffile.imwrite(tmp_path / "ramp.tif", np.repeat(np.arange(7, -1, -1, dtype=np.int16)[:, None], 16, axis=1))
    surface = surface_of_scene(scene_of(surface=plan(plain_texture, height_map={"image": str(tmp_path / "ramp.tif")})))
    inside = np.abs(surface.triangles[:, :, 1]).max(axis=1) < 3.6
    assert surface.slope[inside] == pytest.approx(45.0)
    assert surface.azimuth[inside] == pytest.approx(180.0)
    assert surface.bounds[:, 2].tolist() == [0, 7]


@pytest.mark.parametrize("missing", [np.nan, -9999.0])
def test_heights_that_are_missing_are_refused_with_their_place(scene_of, plain_texture, tmp_path, missing):
    heights = np.zeros((4, 8), np.float32)
    heights[2, 5] = missing
    tags = [(42113, "s", 0, "-9999", True)]
    tifffile.imwrite(tmp_path / "holes.tif", heights, extratags=tags)
    scene = scene_of(surface=plan(plain_texture, height_map={"image": str(tmp_path / "holes.tif")}))
    with pytest.raises(InputError, match="1 places without height, the first in row 2, column 5"):
        surface_of_scene(scene)


def test_a_height_map_that_is_no_tiff_is_refused(scene_of, plain_texture, tmp_path):
    (tmp_path / "text.tif").write_text("no heights", encoding="utf-8")
    with pytest.raises(InputError, match="is no TIFF file of heights"):
        surface_of_scene(scene_of(surface=plan(plain_texture, height_map={"image": str(tmp_path / "text.tif")})))


def test_a_mesh_stands_up_and_north_as_gltf_says(scene_of, write_glb, tmp_path):
    wall = np.array([[[0, 0, 0], [4, 0, 0], [4, 3, 0]]], float)  # seen from +z, which is south
    write_glb([("ground", SQUARE, None), ("wall", wall, None)], tmp_path / "a.glb")
    surface = surface_of_scene(
        scene_of(surface=mesh(tmp_path / "a.glb", {"ground": "asphalt_road", "wall": "brick_red"}))
    )
    assert surface.bounds.tolist() == [[0, 0, 0], [4, 4, 3]]
    walls = surface.covering == [covering.material for covering in surface.coverings].index("brick_red")
    assert surface.slope[walls] == pytest.approx(90.0)
    assert surface.azimuth[walls] == pytest.approx(180.0)
    assert surface.slope[~walls] == pytest.approx(0.0, abs=1e-6)


def test_triangles_without_area_are_left_out(scene_of, write_glb, tmp_path):
    degenerate = np.concatenate([SQUARE, np.zeros((3, 3, 3))])
    write_glb([("ground", degenerate, None)], tmp_path / "a.glb")
    surface = surface_of_scene(scene_of(surface=mesh(tmp_path / "a.glb", {"ground": "asphalt_road"})))
    assert len(surface.triangles) == 2
    assert np.all(np.isfinite(surface.normal))


@pytest.mark.parametrize(
    ("corners", "words"),
    [(np.zeros((2, 3, 3)), "no triangle with an area"), (np.full((1, 3, 3), np.nan), "not finite")],
)
def test_a_mesh_without_a_surface_is_refused(scene_of, write_glb, tmp_path, corners, words):
    write_glb([("ground", corners, None)], tmp_path / "a.glb")
    with pytest.raises(InputError, match=words):
        surface_of_scene(scene_of(surface=mesh(tmp_path / "a.glb", {"ground": "asphalt_road"})))


def test_a_mesh_without_triangles_is_refused(scene_of, write_glb, tmp_path):
    write_glb([], tmp_path / "empty.glb")
    with pytest.raises(InputError, match="has no triangle"):
        surface_of_scene(scene_of(surface=mesh(tmp_path / "empty.glb", {"ground": "asphalt_road"})))


def test_texels_are_those_of_the_photograph_and_repeat_beyond_it(scene_of, write_glb, two_materials, tmp_path):
    """The left half is asphalt, the right one grass; far away the mip level mixes both."""
    write_glb([("ground", SQUARE, UV)], tmp_path / "a.glb")
    scene = scene_of(surface=mesh(tmp_path / "a.glb", {"ground": {"texture": str(two_materials)}}))
    surface = surface_of_scene(scene)
    middle, corner = [1 / 3, 1 / 3, 1 / 3], [0.02, 0.02, 0.96]
    with SurfaceMaterials(scene, surface) as materials:
        near = materials.at(np.array([0, 1, 1]), np.array([middle, middle, corner]), np.full(3, 0.1))
        far = materials.at(np.array([0]), np.array([middle]), np.array([1e4]))
        shifted = dataclasses.replace(surface, uv=surface.uv + np.array([3.0, -2.0]))
        with SurfaceMaterials(scene, shifted) as repeated:
            beyond = repeated.at(np.array([0, 1, 1]), np.array([middle, middle, corner]), np.full(3, 0.1))
    names = [near.names[number] for number in near.number[:, 0]]
    assert names == ["grass_green", "asphalt_road", "asphalt_road"]
    assert [beyond.names[number] for number in beyond.number[:, 0]] == names
    assert sorted(far.share[0]) == pytest.approx([0.0, 0.5, 0.5], abs=1e-4)


def test_texels_without_material_are_refused_or_named(scene_of, half_known):
    surface_keys = {"altitude_km": 0.1, "plan": {"texture": str(half_known), "metres_per_texel": 2.0}}
    weights = (np.array([0, 1]), np.full((2, 3), 1 / 3), np.full(2, 0.1))
    scene = scene_of(surface=surface_keys)
    with (
        SurfaceMaterials(scene, surface_of_scene(scene)) as materials,
        pytest.raises(InputError, match=r"surface\.plan\.texture: 1 texels that are seen have no material"),
    ):
        materials.at(*weights)
    scene = scene_of(surface=surface_keys | {"unknown_material": "leaf_litter"})
    with SurfaceMaterials(scene, surface_of_scene(scene)) as materials:
        mixtures = materials.at(*weights)
    assert [mixtures.names[number] for number in mixtures.number[:, 0]] == ["asphalt_road", "leaf_litter"]


def test_a_file_that_is_no_gltf_is_refused(scene_of, tmp_path):
    (tmp_path / "a.glb").write_bytes(b"glTF" + bytes(40))
    with pytest.raises(InputError, match="is no glTF 2.0"):
        surface_of_scene(scene_of(surface=mesh(tmp_path / "a.glb", {"ground": "asphalt_road"})))


@pytest.mark.parametrize("materials", [{"grund": "asphalt_road"}, {"ground": "asphalt_road", "wall": "brick_red"}])
def test_materials_that_the_mesh_and_the_scene_do_not_share_are_refused(scene_of, write_glb, tmp_path, materials):
    write_glb([("ground", SQUARE, None)], tmp_path / "a.glb")
    with pytest.raises(InputError, match=r"surface\.mesh\.materials.*ground"):
        surface_of_scene(scene_of(surface=mesh(tmp_path / "a.glb", materials)))


def test_a_texture_of_a_mesh_is_read_from_its_top_left_corner(scene_of, write_glb, plain_texture, tmp_path):
    write_glb([("ground", SQUARE, UV)], tmp_path / "a.glb")
    scene = scene_of(surface=mesh(tmp_path / "a.glb", {"ground": {"texture": str(plain_texture)}}))
    surface = surface_of_scene(scene)
    assert surface.uv == pytest.approx(UV)
    with SurfaceMaterials(scene, surface) as materials:
        mixtures = materials.at(np.array([0, 1]), np.full((2, 3), 1 / 3), np.array([0.1, 100.0]))
    assert [mixtures.names[number] for number in mixtures.number[:, 0]] == ["asphalt_road"] * 2
    assert mixtures.share.sum(axis=1) == pytest.approx(1.0)


def test_slope_and_azimuth_are_those_of_the_direction():
    slope, azimuth = slope_and_azimuth(direction(np.array([30.0, 90.0, -20.0]), np.array([120.0, 0.0, 359.0])))
    assert slope == pytest.approx([60.0, 0.0, 110.0], abs=1e-9)
    assert azimuth == pytest.approx([120.0, 0.0, 359.0])
