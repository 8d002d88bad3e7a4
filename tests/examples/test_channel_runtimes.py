"""The example runtimes against the library on an atmosphere in channels, of format 3."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import skyshine.mat
from skyshine.schemas.hdf5 import Header, read_file, write_file

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
from runtime_loaders import by_library

# Relative; the arithmetic of all is double, of arrays of single precision.
TOLERANCE = 1e-9
PIXELS = 60
SUN = {"day": (0.0, 60.0), "rise": (-2.0, 1.0), "twilight": (-19.9, -1.0), "night": (-60.0, -22.0)}
LINES = {"ground": (-90.0, -5.0), "limb": (-1.6, 0.0), "upward": (0.0, 90.0), "horizon": (-1.45, -1.25)}


@pytest.fixture(scope="module")
def lines(scene, channel_atmosphere):
    """Scene of pixels of a kind of line under a kind of source, at ranges from none to the longest."""

    def drawn(sun, line):
        draw = np.random.default_rng(23)
        pixels = []
        for number, pixel in enumerate(scene["pixels"][:PIXELS]):
            lowest, highest = SUN[sun]
            place = {
                "altitude": [0.01, 2.0, float(draw.uniform(0.01, 2.0)), 1.7][number % 4],
                "centre_elevation": float(draw.uniform(*LINES[line])),
                "centre_range": [0.0, 1e-3, float(draw.uniform(0.01, 1)), 20.0, float(draw.uniform(1, 20))][number % 5],
                "source_elevation": float(draw.uniform(lowest, highest)),
            }
            if number % 16 == 0:
                place["centre_elevation"] = LINES[line][number % 32 == 0]
            heading = {"source_heading": float(draw.uniform(-400, 400))}
            pixels.append(pixel | place | heading)
        return scene | {"atmosphere": str(channel_atmosphere), "pixels": pixels}

    return drawn


def agrees(runtime, scene):
    """Every term of the scene, after each was found as the library has it."""
    status, shown, complaint = runtime(scene)
    assert status == 0, complaint
    expected = by_library(scene)
    for name, values in expected.items():
        found = [pixel[name] for pixel in json.loads(shown)["pixels"]]
        np.testing.assert_allclose(found, values, rtol=TOLERANCE, atol=1e-12, err_msg=name)
    return expected


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("sun", SUN)
def test_every_term_agrees_with_the_library(runtime, lines, sun, line):
    terms = agrees(runtime, lines(sun, line))
    lit = np.mean(terms["diffuse"] > 0)
    assert lit > 0.3 if sun == "day" else sun != "night" or lit == 0
    assert np.all(terms["path"] > 0) and np.all((terms["transmittance"] > 0) & (terms["transmittance"] < 1))


def test_the_lines_are_of_all_kinds(lines, channel_atmosphere):
    """Those that meet the ground within their range and behind it, those that miss it, and a beam that is below its
    rise at some heights alone.
    """
    table = skyshine.mat.open(channel_atmosphere)
    beam, share = [], []
    for line in LINES:
        pixels = lines("rise", line)["pixels"]
        of = {name: np.array([pixel[name] for pixel in pixels]) for name in ("altitude", "source_elevation")}
        place = {name: np.array([pixel[f"centre_{name}"] for pixel in pixels]) for name in ("range", "elevation")}
        place["altitude"] = of["altitude"]
        share.append(float(np.mean(table.value("valid", **place))))
        beam.append(np.mean(table.value("direct_radiance", source_elevation=of["source_elevation"], **place) > 0))
    assert 0.1 < share[0] < 0.95 and share[2] == 1 and any(0.1 < each < 0.9 for each in beam)


def test_level_faces_agree_where_a_pixel_has_no_heading(runtime, lines):
    scene = lines("twilight", "ground")
    tilted = by_library(scene)["skyshine"]
    level = [{name: value for name, value in p.items() if name != "source_heading"} for p in scene["pixels"]]
    terms = agrees(runtime, scene | {"pixels": level})
    assert np.mean(np.abs(terms["skyshine"] - tilted) > 1e-3 * tilted) > 0.2


def test_the_ground_of_a_material_agrees(runtime, lines):
    scene = lines("day", "limb")
    agrees(runtime, scene | {"pixels": [pixel | {"ground_material": "grass_green"} for pixel in scene["pixels"]]})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"centre_range": 21.0}, "range: found 21; allowed: 0 to 20"),
        ({"altitude": 3.0}, "altitude: found 3; allowed: 0.01 to 2"),
        ({"centre_elevation": 91.0}, "elevation: found 91; allowed: -90 to 90"),
        ({"source_elevation": 65.0}, "source_elevation: found 65; allowed: -8 to 60"),
    ],
)
def test_outside_the_file_it_stops_or_clamps_as_the_scene_says(runtime, lines, change, words):
    scene = lines("day", "upward")
    outside = [scene["pixels"][3] | change]
    status, shown, complaint = runtime(scene | {"pixels": outside})
    assert (status, shown) == (1, "") and complaint.startswith(words)
    axis = words.split(":")[0]
    nearest = {name: value - 1.0 if axis != "source_elevation" else 60.0 for name, value in change.items()}
    clamped = runtime(scene | {"pixels": outside, "clamp": [axis]})
    expected = runtime(scene | {"pixels": [scene["pixels"][3] | nearest]})
    assert clamped[0] == expected[0] == 0
    if axis != "source_elevation":  # the direction of the source at the observer follows the pixel
        found, wanted = (json.loads(each[1])["pixels"][0] for each in (clamped, expected))
        assert found["transmittance"] == pytest.approx(wanted["transmittance"], rel=1e-12)


def test_a_twilight_that_no_node_holds_is_refused_in_one_line(runtime, lines, tmp_path):
    scene = lines("day", "limb")
    root, _ = read_file(scene["atmosphere"])
    axes = dict(root.axes)
    for name in ("source_elevation", "sky_source_elevation"):
        nodes = np.array(axes[name].values, float)
        axes[name] = replace(axes[name], values=np.linspace(-1.0, nodes[-1], nodes.size))
    day = tmp_path / "day.atmq.h5"
    write_file(day, replace(root, axes=axes), Header("atmq", "3.0.0", "data", "job"))
    dusk = scene["pixels"][0] | {"source_elevation": -9.0}
    status, shown, complaint = runtime(scene | {"atmosphere": str(day), "pixels": [dusk]})
    assert (status, shown) == (1, "") and complaint.startswith("source_elevation: found -9; allowed: -1 to 60")
    agrees(runtime, scene | {"atmosphere": str(day), "pixels": [dusk | {"source_elevation": -30.0}]})
