"""Files of frames and of the day: 10 mK steps, radiance as computed, counts by equation (44)."""

import numpy as np
import OpenImageIO as oiio
import pytest
from PIL import Image

from skyshine.mat.render.day_picture import animate, draw_frames, photograph
from skyshine.mat.render.files import frame_files, kelvin_values
from skyshine.mat.render.frames import Picture
from skyshine.mat.render.scene_file import Sensor
from skyshine.schemas.errors import InputError


@pytest.fixture
def frame():
    draw = np.random.default_rng(3)
    radiance = draw.uniform(0.0, 60.0, (5, 7))
    kelvin = draw.uniform(250, 330, (5, 7))
    return Picture(13.5, 40.0, "b02", (8.0, 12.0), radiance, kelvin, np.full((5, 7), np.nan), np.ones((5, 7)))


def test_the_files_of_a_frame_hold_kelvin_radiance_and_counts(frame, tmp_path):
    sensor = Sensor(bits=14, gain=50.0, buffer_gain=1.2, offset=0.1)
    kelvin, radiance, counts = frame_files(tmp_path, "scene", frame, sensor)
    assert [file.name for file in (kelvin, radiance, counts)] == [
        "scene_b02_1330_kelvin.png",
        "scene_b02_1330_radiance.exr",
        "scene_b02_1330_counts.png",
    ]
    stored = np.asarray(Image.open(kelvin))
    assert stored.dtype == np.uint16
    assert np.abs(stored / 100.0 - frame.apparent_temperature).max() <= 0.005 + 1e-9
    exact = oiio.ImageInput.open(str(radiance))
    assert exact.spec().getattribute("skyshine:units") == "W m^-2 sr^-1"
    assert np.array_equal(exact.read_image()[..., 0], frame.radiance.astype(np.float32))
    # Equation (44), written out: n = int(2^N BG (L / G - DC) - 0.5), the nearest integer, L / G in 0 to 1.
    level = 2**14 * 1.2 * (np.minimum(frame.radiance / 50.0, 1.0) - 0.1)
    assert np.array_equal(np.asarray(Image.open(counts)), np.clip(np.floor(level), 0, 2**14 - 1))
    assert not list(tmp_path.glob(".*"))


def test_kelvin_beyond_16_bits_stay_at_their_ends():
    assert kelvin_values(np.array([0.0, 300.004, 300.006, 655.35, 9000.0])).tolist() == [0, 30000, 30001, 65535, 65535]


def test_a_folder_that_is_not_there_is_one_line(frame, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        frame_files(tmp_path / "missing", "scene", frame, None)


def test_the_day_has_a_frame_for_each_hour(scene_of, tmp_path):
    frames = [np.linspace(280, 280 + hour, 32).reshape(4, 8) for hour in range(1, 4)]
    animate(frames, [1.0, 2.0, 3.0], tmp_path / "day.png")
    assert Image.open(tmp_path / "day.png").n_frames == 3
    beside = photograph(scene_of(hours=[1.0, 2.0, 3.0]))
    bands = {"b01": frames, "b02": frames}
    drawn = Image.open(draw_frames(bands, "123", tmp_path / "both.png", sun_elevation=[-9, -8, 30], photograph=beside))
    assert drawn.width >= 3 * 600 and drawn.mode == "RGB"


def test_day_and_night_have_their_own_white_and_the_bar_every_grey(tmp_path):
    night, day = np.linspace(280, 284, 32).reshape(4, 8), np.linspace(300, 340, 32).reshape(4, 8)
    elevation = [-20.0, 45.0]
    drawn = Image.open(draw_frames({"b01": [night, day]}, "12", tmp_path / "day.png", sun_elevation=elevation))
    grey = np.asarray(drawn)
    middle = grey[40:330]
    for half in np.array_split(middle, 2, axis=1):
        assert half[:, 50:-50].min() < 40 and half[:, 50:-50].max() > 200
    assert len(np.unique(grey[340:])) >= 250  # a continuous bar


def test_a_picture_of_one_temperature_alone_is_drawn(tmp_path):
    animate([np.full((4, 8), 290.0)] * 2, [1.0, 2.0], tmp_path / "even.png")
    assert Image.open(tmp_path / "even.png").n_frames >= 1
    even = {"b01": [np.full((4, 8), 290.0)]}
    assert draw_frames(even, ["1"], tmp_path / "even_day.png", sun_elevation=[9.0]).is_file()
