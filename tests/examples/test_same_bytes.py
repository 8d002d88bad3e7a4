"""The bindings in Rust and JavaScript compute with the sources of the C library: the same bytes, whatever the compiler,
the vectors of the processor or WebAssembly. Nightly, for both fetch packages first.
"""

import json
import subprocess

import numpy as np
import pytest

pytestmark = pytest.mark.validation


@pytest.fixture
def shown_by(program_of, tmp_path):
    """What the program of a language shows of a scene."""

    def run(language, scene):
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(scene), encoding="utf-8")
        done = subprocess.run([*program_of(language), path], capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    return run


@pytest.mark.parametrize("language", ["rust", "javascript"])
def test_pixels_have_the_bytes_of_the_c_library(shown_by, scene, language):
    """Of random places, sources and directions, on tilted faces, in shade and beside walls."""
    draw = np.random.default_rng(41)
    kinds = ({}, {"sky_view": 0.4}, {"surroundings": {"shade": [[8, 11.3]], "sky_view": 0.7, "facing": 290.0}})
    pixels = [
        pixel | {"source_heading": float(draw.uniform(-400, 400))} | kinds[number % 3]
        for number, pixel in enumerate(scene["pixels"])
    ]
    shown, expected = (shown_by(name, scene | {"pixels": pixels})["pixels"] for name in (language, "c"))
    for name in expected[0]:
        assert [pixel[name] for pixel in shown] == [pixel[name] for pixel in expected], name


@pytest.mark.parametrize("language", ["rust", "javascript"])
def test_frames_have_the_bytes_of_the_c_library(shown_by, scene, language):
    draw, count = np.random.default_rng(42), 4097  # not a multiple of any vector
    frame = {
        "altitude": 0.6, "centre_range": 1.5, "centre_elevation": -12.0, "centre_heading": 20.0,
        "source_elevation": 35.0, "source_heading": 140.0, "time": 14.3,
        "material": draw.choice(["asphalt_road", "grass_green"], count).tolist(),
        "range": draw.uniform(0.01, 9.0, count).tolist(), "elevation": draw.uniform(-40.0, -5.0, count).tolist(),
        "heading": draw.uniform(0.0, 40.0, count).tolist(), "surface_altitude": draw.uniform(0.0, 1.0, count).tolist(),
        "surface_azimuth": draw.uniform(0.0, 360.0, count).tolist(),
        "surface_slope": draw.uniform(0.0, 45.0, count).tolist(),
    }  # fmt: skip
    framed = {name: scene[name] for name in ("surface", "band", "atmosphere")} | {"frame": frame}
    assert shown_by(language, framed) == shown_by("c", framed)
