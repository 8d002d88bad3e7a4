"""The scene file: what it takes, and the line of what it refuses."""

import pytest

from skyshine.mat.render.scene_file import load_scene
from skyshine.schemas.errors import InputError

TEXT = """\
skyshine_scene: 1
name: test
surface:
  altitude_km: 0.1
  plan: {texture: TEXTURE, metres_per_texel: 2}
camera:
  plan_view: {height_m: 500, size: [8, 4]}
"""


@pytest.fixture
def written(tmp_path, plain_texture):
    def make(old="", new=""):
        assert old in TEXT
        path = tmp_path / "scene.yaml"
        path.write_text(TEXT.replace(old, new).replace("TEXTURE", str(plain_texture)), encoding="utf-8")
        return path

    return make


def test_hours_of_a_scene_without_them_are_every_third(written):
    scene = load_scene(written())
    assert scene.hours == [0, 3, 6, 9, 12, 15, 18, 21]
    assert scene.databases == scene.folder / "built"


def test_a_range_of_hours_includes_its_last(written):
    path = written("name: test", "name: test\nhours: {first: 6, last: 7.2, step: 0.4}")
    assert load_scene(path).hours == pytest.approx([6, 6.4, 6.8, 7.2])


def test_hours_of_a_track_are_those_of_its_stations(written):
    stations = "[{hour: 5, position_m: [0, 0, 9], look_at_m: [1, 0, 0]}]"
    camera = f"perspective: {{field_of_view_deg: 40, size: [8, 4], track: {stations}}}"
    assert load_scene(written("plan_view: {height_m: 500, size: [8, 4]}", camera)).hours == [5]


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("  altitude_km: 0.1", "  altitude_km: 0.1\n  mesh: 3", "5:9", "valid dictionary"),
        (
            "  plan: {texture: TEXTURE, metres_per_texel: 2}",
            "  unknown_material: sea",
            "3:1",
            "neither of plan and mesh",
        ),
        ("TEXTURE", "missing.tmm.h5", "5:19", "which is no file"),
        ("TEXTURE", "../../secret.tmm.h5", "5:19", "leads out of the"),
        ("metres_per_texel: 2", "metres_per_texel: .nan", "5:", "finite number"),
        ("metres_per_texel: 2", "metres_per_texel: 0", "5:", "greater than 0"),
        ("size: [8, 4]", "size: [16384, 16384]", "6:1", "make size or samples smaller"),
        ("name: test", "name: ../test", "2:7", "match pattern"),
        ("name: test", "name: test\nhours: [24]", "3:9", "less than 24"),
        ("name: test", "name: test\nhours: {first: 9, last: 3, step: 1}", "3:1", "last after first"),
        ("name: test", "name: test\nhuors: [3]", "3:1", "did you mean 'hours'"),
        ("height_m: 500, size", "hight_m: 500, size", "7:15", "unknown key 'hight_m'"),
        (
            "plan_view: {height_m: 500, size: [8, 4]}",
            "perspective: {field_of_view_deg: 40, size: [8, 4], position_m: [0, 0, 1], look_at_m: [0, 0, 1]}",
            "7:3",
            "at the same point",
        ),
        (
            "plan_view: {height_m: 500, size: [8, 4]}",
            "perspective: {field_of_view_deg: 40, size: [8, 4], position_m: [0, 0, 1]}",
            "7:3",
            "position_m and look_at_m, or track",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_its_place(written, old, new, place, words):
    path = written(old, new)
    with pytest.raises(InputError) as caught:
        load_scene(path)
    assert str(caught.value).startswith(f"{path}:{place}")
    assert words in caught.value.message
