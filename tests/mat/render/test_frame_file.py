"""Frame files and buffers that are wrong are one line with its place; decoders give the numbers of the formats."""

import json

import numpy as np
import pytest
from numpy.lib import format as npy
from PIL import Image
from renderer_buffers import save_exr

from skyshine.mat.render.buffer_files import cryptomatte_id, read_cryptomatte, read_layer
from skyshine.mat.render.buffer_geometry import normals_from_depth, poses_of, view_of
from skyshine.mat.render.buffers import MaterialTable, Stored, carla_depth, depth_of, normals_of, sunlit_of
from skyshine.mat.render.frame_file import load_frame
from skyshine.schemas.errors import InputError

MODEL = {
    "skyshine_frame": 1,
    "name": "test",
    "renderer": "blender",
    "altitude_km": 0.1,
    "camera": {"field_of_view_deg": 50.0, "position": [0.0, 0.0, 2.0], "look_at": [9.0, 0.0, 2.0]},
    "buffers": {"depth": {"file": "depth.npy"}, "ids": {"file": "ids.npy"}},
    "materials": {1: "asphalt_road"},
    "hours": [10.0],
}
METRES = np.full((3, 4), 7.0)


@pytest.fixture
def frame(tmp_path):
    """Factory of a frame with changes of keys, given as paths with dots."""

    def make(**changes):
        model = json.loads(json.dumps(MODEL))
        for path, value in changes.items():
            *keys, last = path.split("__")
            place = model
            for key in keys:
                place = place[key]
            place.pop(last) if value is None else place.__setitem__(last, value)
        return load_frame(model, folder=tmp_path)

    return make


@pytest.fixture
def stored(tmp_path):
    """Factory of a buffer of an array."""

    def make(values, name="buffer.npy"):
        values = np.asarray(values)
        return Stored(values if values.ndim == 3 else values[..., None], tmp_path / name)

    return make


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"buffers__depth__file": "*/depth.npy"}, "with at most one \\*"),
        ({"buffers__depth__file": "a*b*.npy"}, "with at most one \\*"),
        ({"buffers__normals": {"file": "n.npy", "space": "sky"}}, "input should be 'world' or 'camera'"),
        ({"camera__look_at": None}, "found no pose of the camera, or two"),
        ({"camera__quaternion": [1, 0, 0, 0]}, "found no pose of the camera, or two"),
        ({"camera__look_at": [0.0, 0.0, 2.0]}, "at the same point"),
        ({"camera__field_of_view_deg": None}, "both or neither of field_of_view_deg and intrinsics"),
        ({"camera__intrinsics": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}, "both or neither"),
        ({"camera__near_clip_m": 0.1}, "for the renderer mitsuba alone"),
        ({"renderer": "airsim"}, "found no buffers.depth.kind; airsim writes both"),
        ({"renderer": "carla", "up": "y"}, "for carla has no other"),
        ({"renderer": "unity"}, "input should be 'blender'"),
        ({"materials": {}}, "at least 1"),
        ({"materials": {1: {"material": "skin", "temperature_k": 37.0}}}, "greater than or equal to 150"),
        ({"hours": [25.0]}, "less than 24"),
        ({"frame": 1}, "unknown key 'frame'"),
    ],
)
def test_a_wrong_key_is_refused(changes, message, frame):
    with pytest.raises(InputError, match=message):
        frame(**changes)


def test_a_wrong_key_of_a_file_has_its_line(tmp_path):
    (tmp_path / "frame.yaml").write_text("skyshine_frame: 1\nname: a\nrenderer: maya\n")
    with pytest.raises(InputError, match=r"frame.yaml:3:11: renderer: found 'maya'"):
        load_frame(tmp_path / "frame.yaml")


def test_frames_of_a_folder_are_in_the_order_of_their_numbers(frame, tmp_path):
    for name in ("d_2.npy", "d_10.npy", "i_10.npy", "i_2.npy", "d_.npy", "other_3.npy"):
        (tmp_path / name).touch()
    several = {"buffers__depth__file": "d_*.npy", "buffers__ids__file": "i_*.npy"}
    assert frame(**several).marks == ("2", "10") and frame(**several).hours == [10.0, 10.0]
    assert frame(**several, hours=[1.0, 2.0]).hours == [1.0, 2.0]
    with pytest.raises(InputError, match="hours: found 3 hours and 2 frames"):
        _ = frame(**several, hours=[1.0, 2.0, 3.0]).hours
    (tmp_path / "d_3.npy").touch()
    with pytest.raises(InputError, match=r"buffers.ids.file: found no file for frame '3'"):
        _ = frame(**several).marks
    with pytest.raises(InputError, match=r"buffers.depth.file: found no file"):
        _ = frame(buffers__depth__file="x_*.npy").marks
    with pytest.raises(InputError, match="leads out of the job's folder"):
        _ = frame(buffers__depth__file="../x_*.npy").marks
    with pytest.raises(InputError, match="which is no file at"):
        frame().path(("buffers", "depth", "file"), "")


def test_layers_of_an_exr_are_read_by_name(tmp_path):
    layers = {
        "V.Depth.Z": METRES,
        "V.N.X": METRES * 0,
        "V.N.Y": METRES * 0,
        "V.N.Z": METRES * 0 + 1,
        "id": METRES * 0 + 3,
    }
    save_exr(tmp_path / "a.exr", layers)
    assert read_layer(tmp_path / "a.exr", "V.Depth").tolist() == METRES[..., None].tolist()
    assert read_layer(tmp_path / "a.exr", "V.Depth.Z").shape == (3, 4, 1)
    assert read_layer(tmp_path / "a.exr", "V.N")[0, 0].tolist() == [0.0, 0.0, 1.0]
    assert read_layer(tmp_path / "a.exr", "id")[0, 0].tolist() == [3.0]
    with pytest.raises(
        InputError, match=r"a.exr: has no layer 'V.Depht'; did you mean 'V.Depth'\? allowed: id, V.Depth, V.N"
    ):
        read_layer(tmp_path / "a.exr", "V.Depht")
    with pytest.raises(InputError, match="has 3 layers; name one of them with 'layer': id, V.Depth, V.N"):
        read_layer(tmp_path / "a.exr", None)
    with pytest.raises(InputError, match="has no layer of Cryptomatte 'V'"):
        read_cryptomatte(tmp_path / "a.exr", "V")


def test_stored_numbers_are_read_as_they_are(tmp_path):
    low_alpha = np.dstack([np.full((3, 4), value, np.uint8) for value in (200, 100, 50, 1)])
    Image.fromarray(low_alpha).save(tmp_path / "a.png")
    assert np.array_equal(read_layer(tmp_path / "a.png", None), low_alpha)
    deep = np.arange(12, dtype=np.uint16).reshape(3, 4) * 5000
    Image.fromarray(deep).save(tmp_path / "b.png")
    assert np.array_equal(read_layer(tmp_path / "b.png", None)[..., 0], deep)
    np.save(tmp_path / "c.npy", METRES.astype(np.float32))
    assert read_layer(tmp_path / "c.npy", None).dtype == np.float32


def header_of(path, shape):
    with path.open("wb") as file:
        npy.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})


@pytest.mark.parametrize(
    ("name", "write", "message"),
    [
        ("a.npy", lambda path: path.write_bytes(b"\x93NUMPY"), "is no array of numpy"),
        ("a.npy", lambda path: header_of(path, (10**6, 10**6)), "is no array of numpy"),
        ("a.npy", lambda path: np.save(path, np.zeros((2, 2), object)), "is no array of numpy"),
        ("a.npy", lambda path: np.save(path, np.zeros(4)), "has an array of shape \\(4,\\)"),
        ("a.npy", lambda path: np.save(path, np.zeros((2, 0))), "has an array of shape \\(2, 0\\)"),
        ("a.npy", lambda path: np.save(path, np.zeros((2, 2), "U3")), "of <U3"),
        ("a.npy", lambda path: np.save(path, np.zeros((2, 2), complex)), "of complex128"),
        ("a.npy", lambda path: np.save(path, np.zeros((2, 2, 9))), "has 2 x 2 pixels; allowed"),
        ("a.npy", lambda path: np.save(path, np.zeros((4000, 4000), np.int8)), "has 4000 x 4000 pixels; allowed"),
        ("a.exr", lambda path: path.write_bytes(b"v/1\x01broken"), "cannot be read"),
        ("a.png", lambda path: path.write_bytes(b""), "cannot be read"),
        ("a.png", lambda path: Image.new("L", (4000, 4000)).save(path), "has 4000 x 4000 pixels; allowed"),
    ],
)
def test_a_file_that_is_no_picture_is_one_line(name, write, message, tmp_path):
    write(tmp_path / name)
    with pytest.raises(InputError, match=message):
        read_layer(tmp_path / name, None)


def test_a_damaged_picture_is_one_line(tmp_path):
    Image.fromarray(np.random.default_rng(1).integers(0, 255, (64, 64), np.uint8)).save(tmp_path / "a.png")
    (tmp_path / "a.png").write_bytes((tmp_path / "a.png").read_bytes()[:2000])
    with pytest.raises(InputError, match="is damaged"):
        read_layer(tmp_path / "a.png", None)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.nan, r"found a depth that is not a number in 1 pixels, the first in row 2, column 1"),
        (-3.0, r"found a depth of 0 or less in 1 pixels, the first in row 2, column 1"),
        (-np.inf, "found a depth of 0 or less"),
        (0.0, "found a depth of 0 or less"),
    ],
)
def test_a_depth_that_is_none_is_refused_with_its_pixel(value, message, frame, stored):
    depth = METRES.copy()
    depth[2, 1] = value
    with pytest.raises(InputError, match=message):
        depth_of(frame(), stored(depth))


def test_far_depths_are_the_sky_of_each_renderer(frame, stored):
    for renderer, sky in (
        ("blender", 1e10),
        ("mitsuba", 0.0),
        ("carla", 1000.0),
        ("isaac", np.inf),
        ("airsim", 65504.0),
    ):
        values = METRES.copy()
        values[0, 0] = sky
        depth = depth_of(frame(renderer=renderer, buffers__depth__kind="planar"), stored(values))
        assert np.isinf(depth[0, 0]) and depth[1:].tolist() == METRES[1:].tolist()


def test_millimetres_in_16_bits(frame, stored):
    depth = depth_of(frame(buffers__depth__metres_per_value=0.001), stored(np.full((3, 4), 7250, np.uint16)))
    assert depth == pytest.approx(7.25)


def test_depth_of_carla_is_little_by_red(stored):
    # The formula of CARLA's sensors reference: (R + 256 G + 65536 B) / (2^24 - 1) of 1000 m.
    raw = np.array([[[1, 0, 0], [0, 1, 0], [0, 0, 1], [255, 255, 255]]], np.uint8)
    assert carla_depth(stored(raw))[0] == pytest.approx(np.array([1, 256, 65536, 2**24 - 1]) * 1000.0 / (2**24 - 1))
    grey = np.full((3, 4, 3), 90, np.uint8)
    with pytest.raises(InputError, match="is grey, as CARLA's ColorConverter makes it"):
        carla_depth(stored(grey))


@pytest.mark.parametrize(
    ("renderer", "values", "name", "message"),
    [
        ("blender", np.zeros((3, 4, 3), np.uint8), "a.png", "has 3 channels of uint8; allowed: one of depth"),
        ("carla", np.zeros((3, 4, 3), np.uint16), "a.png", "has 3 channels of uint16"),
        ("airsim", METRES, "a.pfm", "whose rows AirSim's client writes from the top"),
    ],
)
def test_a_picture_that_is_no_depth_is_refused(renderer, values, name, message, frame, stored):
    with pytest.raises(InputError, match=message):
        depth_of(frame(renderer=renderer, buffers__depth__kind="planar"), stored(values, name))


def test_normals_of_integers_span_minus_one_to_one(stored):
    met = np.array([[True, True, False]])
    values = np.array([[[255, 128, 128], [0, 127, 127], [7, 7, 7]]], np.uint8)
    normal = normals_of(stored(values), met)
    assert normal[0, :2] == pytest.approx(np.array([[1.0, 0, 0], [-1.0, 0, 0]]), abs=5e-3)
    assert np.all(np.isnan(normal[0, 2]))
    with pytest.raises(
        InputError, match="found a normal without a direction in 1 pixels, the first in row 0, column 1"
    ):
        normals_of(stored(np.array([[[0.0, 0, 1], [0, 0, 0], [0, 0, 0]]])), met)
    with pytest.raises(InputError, match="has 2 channels; allowed: 3 at least"):
        normals_of(stored(np.zeros((1, 3, 2))), met)


def test_a_share_of_light_is_0_to_1(stored):
    assert sunlit_of(stored(np.array([[0, 51, 255]], np.uint8)))[0] == pytest.approx([0.0, 0.2, 1.0])
    assert sunlit_of(stored(np.array([[False, True]])))[0].tolist() == [0.0, 1.0]
    for wrong in (1.5, -0.1, np.nan):
        with pytest.raises(InputError, match="a share of light beyond 0 to 1"):
            sunlit_of(stored(np.array([[0.5, wrong]])))


def test_ids_of_cryptomatte_are_murmur_hashes():
    # Of a file of Blender 5.0.1; published test vectors of MurmurHash3_32 with seed 0 for the last three.
    names = {"asphalt": "62980026", "brick": "d0223176", "default_surface": "78d05529", "default_empty": "9a46ca03"}
    assert {name: f"{cryptomatte_id(name):08x}" for name in names} == names
    assert cryptomatte_id("test") == 0xBA6BD213 and cryptomatte_id("Hello, world!") == 0xC0363E43
    assert cryptomatte_id("The quick brown fox jumps over the lazy dog") == 0x2E4FF723
    assert cryptomatte_id("") >> 23 & 255 not in (0, 255)


@pytest.mark.parametrize(
    ("values", "changes", "message"),
    [
        (np.full((3, 4), 1.5), {}, "an id that is no whole number in 12 pixels"),
        (np.full((3, 4), np.nan), {}, "an id that is no whole number"),
        (np.full((3, 4), 2.0**40), {}, "an id that is no whole number"),
        (np.full((3, 4), -1), {}, "an id below 0"),
        (np.full((2, 4), 1), {}, "buffers.ids.file: found 4 x 2 pixels; allowed: those of the depth, 4 x 3"),
        (np.full((3, 4), 9), {}, r"found the ids 9 \(100.00%\)"),
        (np.full((3, 4), 4_000_000_000, np.uint32), {}, "found the ids 4000000000"),
        (np.full((3, 4, 3), 5, np.int16), {"buffers__ids__encoding": "colour"}, "materials.1: found the key '1'"),
    ],
)
def test_ids_that_are_none_are_refused(values, changes, message, frame, tmp_path):
    np.save(tmp_path / "ids.npy", values)
    with pytest.raises(InputError, match=message):
        MaterialTable(frame(**changes)).pixels("", np.ones((3, 4), bool))


def test_every_id_of_the_sky_may_be_unknown(frame, tmp_path):
    np.save(tmp_path / "ids.npy", np.full((3, 4), 9))
    assert MaterialTable(frame()).pixels("", np.zeros((3, 4), bool)).share.sum() == 0


@pytest.mark.parametrize("text", ["[", "[1]", '{"a": {"class": "x"}}', '{"(1, 2)": "x"}', '{"1": 3}'])
def test_labels_that_are_none_are_refused(text, frame, tmp_path):
    np.save(tmp_path / "ids.npy", np.full((3, 4), 9))
    (tmp_path / "labels.json").write_text(text)
    table = MaterialTable(frame(buffers__ids__labels="labels.json", materials={"x": "asphalt_road"}))
    with pytest.raises(InputError, match=r"labels.json: "):
        table.pixels("", np.ones((3, 4), bool))


def test_a_name_needs_labels(frame):
    with pytest.raises(InputError, match=r"materials.road: found the key 'road'; .* give buffers.ids.labels"):
        MaterialTable(frame(materials={"road": "asphalt_road"}))


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([2.0, 2, 2, 1]), r"lengths \[2.0, 2.0, 2.0\]"),
        (np.diag([-1.0, 1, 1, 1]), "remove scale and mirrors"),
        (np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [3, 2, 1, 1.0]]), "as USD has them: transpose it"),
    ],
)
def test_a_matrix_that_is_no_pose_is_refused(matrix, message, frame, tmp_path):
    lens = {"field_of_view_deg": 50.0}
    with pytest.raises(InputError, match=f"camera.pose: .*{message}"):
        poses_of(frame(camera=lens | {"pose": matrix.tolist()}))
    np.save(tmp_path / "poses.npy", matrix)
    with pytest.raises(InputError, match=f"camera.poses: .*{message}"):
        poses_of(frame(camera=lens | {"poses": "poses.npy"}))


def test_files_of_poses_that_are_none_are_refused(frame, tmp_path):
    camera = {"field_of_view_deg": 50.0, "poses": "poses.txt"}
    for text, message in (
        ("1 2 3", "has no matrices of 4 x 4"),
        ("a", "has no matrices"),
        ("", "has no matrices|found 0"),
    ):
        (tmp_path / "poses.txt").write_text(text)
        with pytest.raises(InputError, match=message):
            poses_of(frame(camera=camera))
    np.savetxt(tmp_path / "poses.txt", np.stack([np.eye(4)] * 3).reshape(-1, 4))
    with pytest.raises(InputError, match="found 3 matrices and 1 frames"):
        poses_of(frame(camera=camera))
    zero = {"field_of_view_deg": 50.0, "position": [0.0, 0.0, 0.0], "quaternion": [0.0, 0.0, 0.0, 0.0]}
    with pytest.raises(InputError, match="found a quaternion of length 0"):
        poses_of(frame(camera=zero))


def test_normals_of_planes_follow_from_their_depth_up_to_their_edges(frame):
    turned = {"position": [1.0, 2.0, 3.0], "look_at": [4.0, 9.0, 1.0], "field_of_view_deg": 70.0}
    model = frame(camera=turned).model
    (pose,) = poses_of(frame(camera=turned))
    view = view_of(model, pose, (9, 7))
    rays = view.rays.direction.reshape(7, 9, 3)
    normals = np.array([[0.3, -0.8, 0.5], [-0.9, -0.3, 0.1]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    # Planes 8 m and 80 m ahead of the middle of the picture, each in one half of it.
    distance = np.stack([away * (pose.ahead @ n) / (rays @ n) for away, n in zip((8.0, 80.0), normals, strict=True)])
    assert np.all(distance > 0)
    half = (np.arange(9) >= 4).astype(int)
    depth = np.where(half, distance[1], distance[0]) / view.length
    found = normals_from_depth(view, pose, depth)
    assert np.abs(np.einsum("rcx,cx->rc", found, normals[half])) == pytest.approx(1.0)
    sky = np.full(depth.shape, np.inf)
    sky[3, 4] = 5.0
    assert normals_from_depth(view, pose, sky)[3, 4].tolist() == [0.0, 0.0, 1.0]


def test_channels_of_a_layer_have_its_order_whatever_that_of_the_file(tmp_path):
    layers = {f"C00.{channel}": METRES * 0 + value for channel, value in zip("abgr", (4, 3, 2, 1), strict=True)}
    save_exr(tmp_path / "a.exr", layers)
    assert read_layer(tmp_path / "a.exr", "C00")[0, 0].tolist() == [1.0, 2.0, 3.0, 4.0]
