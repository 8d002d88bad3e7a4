"""Frames of other renderers: each renderer's buffers of one scene give the pictures of that scene."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image
from renderer_buffers import (
    COLUMNS,
    FIELD,
    LOOK_AT,
    POSITION,
    ROWS,
    camera_columns,
    pose,
    save_carla,
    save_exr,
    stored_depth,
    to_world,
)

import skyshine
from skyshine.mat.cli import main
from skyshine.mat.render.camera import view_rays
from skyshine.mat.render.frame_file import load_frame
from skyshine.mat.render.frame_pictures import FrameRenderer
from skyshine.mat.render.frames import Renderer
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.runtime.shade import shaded_temperature
from skyshine.mat.tables.loader import open_table
from skyshine.schemas.errors import InputError

RENDERERS = ("blender", "mitsuba", "carla", "airsim", "isaac", "gazebo", "opencv")
HOUR = 10.0
GROUND_ID, ROOF_ID = 3, 200


def ramp(half, low, high):
    """Two triangles of a square from -half to half, y up, that rises towards the north."""
    corners = np.array([[-half, low, half], [half, low, half], [half, high, -half], [-half, high, -half]], float)
    return corners[[[0, 1, 2], [0, 2, 3]]]


@pytest.fixture(scope="module")
def scene(small_build, write_glb, tmp_path_factory):
    """A loaded scene of asphalt under a ramp of grass that casts a shadow, and its mesh."""
    mesh = tmp_path_factory.mktemp("ramp") / "ramp.glb"
    write_glb([("ground", ramp(40.0, 0.0, 0.0), None), ("roof", ramp(4.0, 3.0, 5.0), None)], mesh)
    return load_scene(
        {
            "skyshine_scene": 1,
            "name": "ramp",
            "databases": str(small_build),
            "surface": {
                "altitude_km": 0.1,
                "mesh": {"file": str(mesh), "materials": {"ground": "asphalt_road", "roof": "grass_green"}},
            },
            "camera": {
                "perspective": {
                    "field_of_view_deg": FIELD,
                    "size": [COLUMNS, ROWS],
                    "position_m": POSITION.tolist(),
                    "look_at_m": LOOK_AT.tolist(),
                }
            },
            "hours": [HOUR],
        }
    )


@pytest.fixture(scope="module")
def drawn(scene):
    """The scene's picture, with distances [m], normals and ids (rows, columns) of what its rays meet."""
    with Renderer(scene) as renderer:
        (picture,) = renderer.frames()
        seen = renderer._see(0, np.array([HOUR])).points
        rays = view_rays(scene, renderer.surface, 0)
    shape = (ROWS, COLUMNS)
    distance, normal, ids = (
        np.full(ROWS * COLUMNS, np.inf),
        np.zeros((ROWS * COLUMNS, 3)),
        np.zeros(ROWS * COLUMNS, int),
    )
    distance[seen.pixel], normal[seen.pixel] = seen.range * 1e3, seen.normal
    ids[seen.pixel] = np.where(seen.slope > 1, ROOF_ID, GROUND_ID)
    assert len(rays.direction) == distance.size and {GROUND_ID, ROOF_ID} <= set(ids)
    return picture, distance.reshape(shape), normal.reshape(*shape, 3), ids.reshape(shape)


def content(scene, renderer, **changes):
    """A frame file of the scene, as plain data."""
    model = {
        "skyshine_frame": 1,
        "name": "test",
        "databases": scene.model.databases,
        "renderer": renderer,
        "altitude_km": 0.1,
        "camera": {"field_of_view_deg": FIELD, "pose": pose(renderer).tolist()},
        "buffers": {"depth": {"file": "depth.npy"}, "normals": {"file": "normal.npy"}, "ids": {"file": "ids.npy"}},
        "materials": {GROUND_ID: "asphalt_road", ROOF_ID: "grass_green"},
        "mesh": {
            "file": str(scene.model.surface.mesh.file),
            "materials": {"ground": "asphalt_road", "roof": "grass_green"},
        },
        "hours": [HOUR],
    }
    if renderer == "mitsuba":
        model["camera"]["near_clip_m"] = 0.25
    return model | changes


@pytest.fixture
def frame_of(scene, drawn, tmp_path):
    """Factory of a frame of the scene in a renderer's layout, with changes of its top keys, and of its files."""

    def make(renderer="blender", kind="planar", files=(), **changes):
        _, distance, normal, ids = drawn
        kind = "distance" if renderer == "mitsuba" else kind
        np.save(tmp_path / "depth.npy", stored_depth(renderer, distance, kind))
        np.save(tmp_path / "normal.npy", to_world(renderer, normal))
        np.save(tmp_path / "ids.npy", ids)
        for name, values in dict(files).items():
            np.save(tmp_path / name, values)
        model = content(scene, renderer)
        model["buffers"]["depth"]["kind"] = kind
        return load_frame(model | changes, folder=tmp_path)

    return make


def picture_of(frame):
    ((_, picture),) = FrameRenderer(frame).pictures()
    return picture


@pytest.mark.parametrize("renderer", RENDERERS)
def test_buffers_of_each_renderer_give_the_picture_of_the_scene(renderer, frame_of, drawn):
    picture = picture_of(frame_of(renderer))
    assert picture.radiance == pytest.approx(drawn[0].radiance, rel=1e-9)
    assert picture.surface_temperature == pytest.approx(drawn[0].surface_temperature, rel=1e-9, nan_ok=True)
    assert picture.range == pytest.approx(drawn[0].range, rel=1e-9)


@pytest.mark.parametrize("renderer", ["airsim", "blender", "isaac"])
def test_distances_are_no_planar_depths(renderer, frame_of, drawn):
    assert picture_of(frame_of(renderer, "distance")).range == pytest.approx(drawn[0].range, rel=1e-9)
    wrong = frame_of(renderer, "distance")
    depth = wrong.model.buffers.depth.model_copy(update={"kind": "planar"})
    buffers = wrong.model.buffers.model_copy(update={"depth": depth})
    wrong = replace(wrong, model=wrong.model.model_copy(update={"buffers": buffers, "mesh": None}))
    near = drawn[0].range
    assert np.nanmax(np.abs(picture_of(wrong).range / near - 1)[np.isfinite(near)]) > 0.05


@pytest.mark.parametrize("renderer", RENDERERS)
def test_normals_in_the_axes_of_the_camera(renderer, frame_of, drawn):
    columns = np.stack(camera_columns(renderer), axis=-1)
    files = {"normal.npy": drawn[2] @ columns}
    model = content_of(frame_of(renderer, files=files))
    model["buffers"]["normals"]["space"] = "camera"
    picture = picture_of(load_frame(model, folder=frame_of(renderer, files=files).folder))
    assert picture.radiance == pytest.approx(drawn[0].radiance, rel=1e-9)


def content_of(frame):
    return json.loads(json.dumps(frame.document.data))


def test_normals_from_depth_are_those_of_the_faces_away_from_edges(frame_of, drawn):
    model = content_of(frame_of())
    del model["buffers"]["normals"]
    picture = picture_of(load_frame(model, folder=frame_of().folder))
    same = np.abs(picture.radiance / drawn[0].radiance - 1) < 1e-6
    assert same.mean() > 0.9


def test_a_depth_of_carla_in_24_bits(frame_of, drawn):
    frame = frame_of("carla")
    save_carla(frame.folder / "depth.png", stored_depth("carla", drawn[1], "planar"))
    tags = np.stack([drawn[3], np.full_like(drawn[3], 7), np.zeros_like(drawn[3])], axis=-1).astype(np.uint8)
    Image.fromarray(tags).save(frame.folder / "tags.png")
    model = content_of(frame)
    model["buffers"] |= {"depth": {"file": "depth.png"}, "ids": {"file": "tags.png"}}
    picture = picture_of(load_frame(model, folder=frame.folder))
    assert picture.range == pytest.approx(drawn[0].range, abs=1e-7)
    assert picture.apparent_temperature == pytest.approx(drawn[0].apparent_temperature, abs=0.02)


def test_a_camera_that_looks_at_a_point_and_a_quaternion_are_the_pose(frame_of, drawn):
    lens = {"field_of_view_deg": FIELD, "position": POSITION.tolist()}
    looking = picture_of(frame_of("blender", camera=lens | {"look_at": LOOK_AT.tolist()}))
    assert looking.radiance == pytest.approx(drawn[0].radiance, rel=1e-9)
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(pose("airsim")[:3, :3]).as_quat()
    camera = {"field_of_view_deg": FIELD, "position": pose("airsim")[:3, 3].tolist(), "quaternion": [w, x, y, z]}
    assert picture_of(frame_of("airsim", camera=camera)).radiance == pytest.approx(drawn[0].radiance, rel=1e-9)


def test_a_camera_matrix_is_a_field_of_view(frame_of, drawn):
    focal = COLUMNS / 2 / np.tan(np.radians(FIELD / 2))
    matrix = [[focal, 0, COLUMNS / 2], [0, focal, ROWS / 2], [0, 0, 1]]
    picture = picture_of(frame_of("opencv", camera={"intrinsics": matrix, "pose": pose("opencv").tolist()}))
    assert picture.radiance == pytest.approx(drawn[0].radiance, rel=1e-9)


def test_a_world_with_y_up_and_its_azimuth(frame_of, drawn):
    turn = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # x north, y up, z east
    matrix = np.eye(4)
    matrix[:3] = turn @ pose("blender")[:3]
    camera = {"field_of_view_deg": FIELD, "pose": matrix.tolist()}
    frame = frame_of(files={"normal.npy": drawn[2] @ turn.T}, camera=camera, up="y", x_azimuth_deg=0.0)
    assert picture_of(frame).radiance == pytest.approx(drawn[0].radiance, rel=1e-9)


def test_a_temperature_of_ones_own(frame_of, drawn):
    own = {GROUND_ID: "asphalt_road", ROOF_ID: {"material": "grass_green", "temperature_k": 350.0}}
    picture, roof = picture_of(frame_of(materials=own)), drawn[3] == ROOF_ID
    assert picture.surface_temperature[roof] == pytest.approx(350.0)
    assert picture.radiance[~roof] == pytest.approx(drawn[0].radiance[~roof])
    assert np.all(picture.apparent_temperature[roof] > 335.0)


def test_an_id_may_be_the_sky(frame_of, drawn):
    picture, roof = picture_of(frame_of(materials={GROUND_ID: "asphalt_road", ROOF_ID: "sky"})), drawn[3] == ROOF_ID
    assert np.all(np.isinf(picture.range[roof])) and np.all(np.isnan(picture.surface_temperature[roof]))
    assert np.all(np.isfinite(picture.radiance))


def test_an_unknown_id_is_refused_or_drawn_by_the_default_and_said(frame_of, drawn):
    share = f"{np.mean(drawn[3] == ROOF_ID):.2%}"
    with pytest.raises(InputError, match=rf"materials: found the ids 200 \({share}\) of the pixels"):
        picture_of(frame_of(materials={GROUND_ID: "asphalt_road"}))
    renderer = FrameRenderer(frame_of(materials={GROUND_ID: "asphalt_road"}, default_material="grass_green"))
    ((_, picture),) = renderer.pictures()
    assert picture.radiance == pytest.approx(drawn[0].radiance, rel=1e-9)
    assert renderer.notes == [f"{share} of the pixels have ids without a material (200); drawn as grass_green"]


def test_shade_of_a_mask_lasts_all_day_or_for_hours(frame_of, drawn, small_build):
    surface, ground = open_table(small_build / "s01.htt.h5"), drawn[3] == GROUND_ID
    model = content_of(frame_of(files={"lit.npy": np.zeros((ROWS, COLUMNS), np.uint8)}))
    del model["mesh"]
    kelvin = []
    for lasts in (24.0, 2.0):
        model["buffers"]["sunlit"] = {"file": "lit.npy", "lasts_h": lasts, "open_sky": 0.5}
        kelvin.append(picture_of(load_frame(model, folder=frame_of().folder)).surface_temperature[ground])
    code, one = surface.materials["asphalt_road"], np.ones(1)
    where = {"altitude": 0.1 * one, "azimuth": 0 * one, "slope": 0 * one}
    expected = shaded_temperature(surface, np.array([code]), 0.5 * one, **where, time=np.array([[HOUR]]))[0, 0]
    # Between the altitudes of the table, 1 km apart, temperatures are interpolated, there the response to shade is.
    assert kelvin[0] == pytest.approx(expected, abs=0.03)
    sunlit = surface.temperature(material=code, altitude=0.1, azimuth=0, slope=0, time=HOUR)
    change = surface.absorbed_change(material=code, altitude=0.1, azimuth=0, slope=0, shade=[(8.0, 10.0)], sky_view=0.5)
    two_hours = surface.temperature(material=code, altitude=0.1, azimuth=0, slope=0, time=HOUR, absorbed_change=change)
    assert kelvin[1] == pytest.approx(float(two_hours), abs=0.03)
    assert expected < two_hours < sunlit


def test_a_lit_mask_is_no_mask_and_half_shade_lies_between(frame_of, drawn):
    model, pictures = content_of(frame_of()), []
    del model["mesh"]
    folder = frame_of().folder
    plain = picture_of(load_frame(model, folder=folder))
    model["buffers"]["sunlit"] = {"file": "lit.npy"}
    for value in (255, 128, 0):
        np.save(folder / "lit.npy", np.full((ROWS, COLUMNS), value, np.uint8))
        pictures.append(picture_of(load_frame(model, folder=folder)))
    assert pictures[0].radiance == pytest.approx(plain.radiance, rel=1e-9)
    ground = drawn[3] == GROUND_ID
    lit, half, dark = (picture.radiance[ground] for picture in pictures)
    assert np.all((dark < half) & (half < lit))


def test_cryptomatte_mixes_materials_by_their_coverage(frame_of, drawn):
    from skyshine.mat.render.buffer_files import cryptomatte_id

    frame = frame_of()
    code = {name: np.array(cryptomatte_id(name), np.uint32).view(np.float32) for name in ("road", "lawn")}
    full = np.ones((ROWS, COLUMNS), np.float32)
    layers = {
        "View.Crypto00.r": full * code["road"],
        "View.Crypto00.g": full * np.float32(0.75),
        "View.Crypto00.b": full * code["lawn"],
        "View.Crypto00.a": full * np.float32(0.25),
    }
    manifest = json.dumps({name: f"{cryptomatte_id(name):08x}" for name in code})
    names = {"cryptomatte/abc/name": "View.Crypto", "cryptomatte/abc/manifest": manifest}
    save_exr(frame.folder / "ids.exr", layers, names)
    model = content_of(frame)
    model["buffers"]["ids"] = {"file": "ids.exr", "layer": "View.Crypto", "encoding": "cryptomatte"}
    pure = []
    for name in ("asphalt_road", "grass_green"):
        model["materials"] = {"road": name, "lawn": name}
        pure.append(picture_of(load_frame(model, folder=frame.folder)).radiance)
    model["materials"] = {"road": "asphalt_road", "lawn": "grass_green"}
    mixed = picture_of(load_frame(model, folder=frame.folder)).radiance
    assert mixed == pytest.approx(0.75 * pure[0] + 0.25 * pure[1], rel=1e-9)
    model["materials"] = {"road": "asphalt_road"}
    with pytest.raises(InputError, match="'lawn' "):
        picture_of(load_frame(model, folder=frame.folder))


def test_labels_of_isaac_name_ids_and_colours(frame_of, drawn):
    frame, ids = frame_of("isaac"), drawn[3]
    model = content_of(frame)
    model["materials"] = {"road": "asphalt_road", "lawn": "grass_green", "BACKGROUND": "sky"}
    labels = {"3": {"class": "road"}, "200": {"kind": "plant", "class": "lawn"}, "0": {"class": "BACKGROUND"}}
    (frame.folder / "labels.json").write_text(json.dumps(labels))
    model["buffers"]["ids"] = {"file": "ids.npy", "labels": "labels.json"}
    assert picture_of(load_frame(model, folder=frame.folder)).radiance == pytest.approx(drawn[0].radiance, rel=1e-9)
    colours = np.zeros((256, 4), np.uint8)
    colours[[GROUND_ID, ROOF_ID, 0]] = [[140, 25, 255, 255], [9, 8, 7, 0], [0, 0, 0, 0]]
    Image.fromarray(colours[ids]).save(frame.folder / "ids.png")
    labels = {
        "(140, 25, 255, 255)": {"class": "road"},
        "(9, 8, 7, 0)": {"class": "lawn"},
        "(0, 0, 0, 0)": {"class": "BACKGROUND"},
    }
    (frame.folder / "labels.json").write_text(json.dumps(labels))
    model["buffers"]["ids"] |= {"file": "ids.png", "encoding": "colour"}
    assert picture_of(load_frame(model, folder=frame.folder)).radiance == pytest.approx(drawn[0].radiance, rel=1e-9)
    model["materials"] = {"#8c19FF": "asphalt_road", "#090807": "grass_green"}
    del model["buffers"]["ids"]["labels"]
    assert picture_of(load_frame(model, folder=frame.folder)).radiance == pytest.approx(drawn[0].radiance, rel=1e-9)


def test_a_folder_of_frames_with_poses_and_hours_is_written(frame_of, scene, drawn, tmp_path):
    frame = frame_of()
    for mark in ("2", "10"):
        for name in ("depth", "normal", "ids"):
            (frame.folder / f"{name}_{mark}.npy").write_bytes((frame.folder / f"{name}.npy").read_bytes())
    np.savetxt(frame.folder / "poses.txt", np.stack([pose("blender")] * 2).reshape(-1, 4))
    model = content_of(frame)
    model["buffers"] = {
        name: {"file": f"{file}_*.npy"} for name, file in (("depth", "depth"), ("normals", "normal"), ("ids", "ids"))
    }
    model["camera"] = {"field_of_view_deg": FIELD, "poses": "poses.txt"}
    model |= {"hours": [HOUR, 9.0], "sensors": {"b01": {"gain": 50.0}}}
    frames = skyshine.Frame(model, folder=frame.folder)
    assert frames.marks == ("2", "10") and frames.hours == [HOUR, 9.0]
    frames.check()
    names = {path.name for path in frames.render(tmp_path / "out")}
    assert names == {
        "test_frames.png",
        *(
            f"test_{stem}_{kind}"
            for stem in ("2_b01_1000", "10_b01_0900")
            for kind in ("kelvin.png", "radiance.exr", "counts.png")
        ),
    }
    pictures = dict(frames.pictures())
    assert pictures["2"].radiance == pytest.approx(drawn[0].radiance, rel=1e-9)
    assert not np.array_equal(pictures["2"].radiance, pictures["10"].radiance)


def test_one_frame_at_several_hours(frame_of, drawn):
    pictures = [picture for _, picture in FrameRenderer(frame_of(hours=[4.0, HOUR])).pictures()]
    assert [picture.hour for picture in pictures] == [4.0, HOUR]
    assert pictures[1].radiance == pytest.approx(drawn[0].radiance, rel=1e-9)


def test_faces_that_look_down_are_said_and_altitudes_beyond_the_table_refused(frame_of, drawn):
    down = drawn[2].copy()
    down[drawn[3] == ROOF_ID] = [0.0, -0.94, -0.34]
    renderer = FrameRenderer(frame_of(files={"normal.npy": down}, mesh=None))
    renderer.check()
    assert "look further down than a slope of 45 degree" in renderer.notes[0]
    with pytest.raises(InputError, match=r"altitude_km: the surface is at 5 to 5\.0\d* km, s01.htt.h5 covers 0 to 1"):
        FrameRenderer(frame_of(altitude_km=5.0)).check()


def test_the_commands_check_and_draw_a_frame(frame_of, drawn, tmp_path, monkeypatch):
    monkeypatch.setenv("SKYSHINE_ALLOW_OUTSIDE", "0")  # set back after --allow-outside
    frame = frame_of(files={"lit.npy": np.ones((ROWS, COLUMNS))}, mesh=None)
    model = content_of(frame)
    model["materials"], model["default_material"] = {"3": "asphalt_road"}, "grass_green"
    file = frame.folder / "frame.yaml"
    file.write_text(json.dumps(model))
    run = CliRunner().invoke
    checked = run(main, ["check", "--allow-outside", "--buffers", str(file)])
    assert checked.exit_code == 0 and "frame.yaml: OK; frames: 1" in checked.output
    assert "note: " in checked.output and "(200); drawn as grass_green" in checked.output
    answer = run(main, ["render", "--allow-outside", "--buffers", str(file), "--out", str(tmp_path / "out"), "--json"])
    assert answer.exit_code == 0, answer.output
    answer = json.loads(answer.output)
    assert len(answer["files"]) == 3 and "drawn as grass_green" in answer["notes"][0]
    file.write_text(json.dumps(model | {"hours": [30.0]}))
    for command in ("check", "render"):
        refused = run(main, [command, "--allow-outside", "--buffers", str(file)])
        assert refused.exit_code == 2 and "frame.yaml:1:" in refused.output
