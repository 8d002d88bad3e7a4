"""Frames of the C library against the package, pixel by pixel."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
from runtime_loaders import TABLES

# Relative to the radiance, as the library states it.
TOLERANCE = 1e-11
PIXELS = 700  # more than two blocks, and a part of one
LISTS = ("range", "elevation", "heading", "surface_altitude", "surface_azimuth", "surface_slope")
VIEWS = {
    "day": {"source_elevation": 40.0, "centre_elevation": -15.0, "centre_range": 2.0},
    "sunrise": {"source_elevation": 0.5, "centre_elevation": -4.0, "centre_range": 0.3},
    "night": {"source_elevation": -21.0, "centre_elevation": 3.0, "centre_range": 6.0},
}


@pytest.fixture(scope="module")
def frame_files(small_build, channel_atmosphere, band_file):
    """A scene's files, with materials that have lobes."""
    files = {"surface": small_build / "s01.htt.h5", "band": band_file, "atmosphere": channel_atmosphere}
    return {name: str(path) for name, path in files.items()}


def drawn(files, view):
    """A frame of pixels from at once to far away, on faces of every direction, at borders of the axes too."""
    draw = np.random.default_rng(31)
    codes = skyshine.mat.open(files["band"]).root.axes["material"].values
    of = {
        "range": np.concatenate([[0.0, 1e-5, 4095.0], 10 ** draw.uniform(-4, 2, PIXELS - 3)]),
        "elevation": draw.uniform(-90, 20, PIXELS),
        "heading": draw.uniform(-400, 400, PIXELS),
        "surface_altitude": draw.choice([0.0, 0.25, 0.6, 1.0], PIXELS),
        "surface_azimuth": draw.uniform(-400, 800, PIXELS),
        "surface_slope": np.concatenate([[0.0, 45.0], draw.uniform(0, 45, PIXELS - 2)]),
    }
    frame = VIEWS[view] | {"altitude": 0.5, "centre_heading": 20.0, "source_heading": 130.0, "time": 15.3}
    lists = {name: values.tolist() for name, values in of.items()}
    return frame | lists | {"material": draw.choice(codes, PIXELS).tolist()}


def directions(elevation, heading):
    up, turn = np.radians(elevation), np.radians(heading)
    return np.stack([np.cos(up) * np.sin(turn), np.cos(up) * np.cos(turn), np.sin(up)], axis=-1)


def by_library(files, frame, **faces):
    """Every term of the frame's pixels."""
    tables = [skyshine.mat.open(files[name]) for name in TABLES]
    of, one = {name: np.array(frame[name]) for name in LISTS}, np.ones(len(frame["range"]))
    ground = frame.get("ground_material")
    names = ("centre_range", "altitude", "centre_elevation", "source_elevation")
    lines = LinesOfSight(
        *(frame[name] * one for name in names), (frame["source_heading"] - frame["centre_heading"]) * one
    )
    view = View(
        lines,
        of["range"],
        source_heading=frame["source_heading"] * one,
        normal=directions(90 - of["surface_slope"], of["surface_azimuth"]),
        to_source=directions(frame["source_elevation"] * one, frame["source_heading"] * one),
        to_observer=-directions(of["elevation"], of["heading"]),
    )
    face = {name: of[f"surface_{name}"] for name in ("azimuth", "slope")} | {"time": frame["time"] * one}
    altitude = of["surface_altitude"]
    if ground is not None:
        altitude = frame["ground_altitude"] * one
        faces["ground_material"] = np.full(len(one), ground)
    codes = np.array(frame["material"])[:, None]
    return pixel_radiance(*tables, Faces(codes, np.ones(codes.shape), altitude, **face, **faces), view)


@pytest.mark.parametrize("view", VIEWS)
def test_the_pixels_of_a_frame_agree_with_the_library(runtime, frame_files, view):
    frame = drawn(frame_files, view)
    status, shown, complaint = runtime(frame_files | {"frame": frame})
    assert status == 0, complaint
    terms = by_library(frame_files, frame)
    if view == "day":
        assert np.count_nonzero(terms.diffuse) > PIXELS / 4
        assert np.count_nonzero(terms.specular > 1e-6) > 20
    np.testing.assert_allclose(json.loads(shown)["radiance"], terms.radiance, rtol=TOLERANCE)


def test_given_temperatures_and_a_ground_of_a_material_agree(runtime, frame_files):
    frame = drawn(frame_files, "day")
    kelvin = np.linspace(260.0, 330.0, PIXELS)
    frame |= {"temperature": kelvin.tolist(), "ground_material": frame["material"][0], "ground_altitude": 0.4}
    status, shown, complaint = runtime(frame_files | {"frame": frame})
    assert status == 0, complaint
    terms = by_library(frame_files, frame, temperature=kelvin[:, None])
    np.testing.assert_allclose(json.loads(shown)["radiance"], terms.radiance, rtol=TOLERANCE)


@pytest.mark.parametrize(
    ("list_of", "value", "words"),
    [
        ("range", -0.1, "range: found -0.1; allowed: finite numbers from 0"),
        ("surface_slope", 45.5, "slope: found 45.5; allowed: 0 to 45"),
        ("surface_altitude", 1.5, "altitude: found 1.5; allowed: 0 to 1"),
        ("material", 65534, "material: found 65534; allowed"),
    ],
)
def test_a_pixel_outside_the_tables_is_refused_with_its_number(runtime, frame_files, list_of, value, words):
    frame = drawn(frame_files, "night")
    frame[list_of][PIXELS - 1] = value
    status, shown, complaint = runtime(frame_files | {"frame": frame})
    assert (status, shown) == (1, "") and complaint.startswith(f"pixel {PIXELS - 1}: {words}")
