"""The C library against the package on lines of all kinds and sources of all elevations."""

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Header, read_file, write_file

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
from good_databases import with_shade, write_texture_of_two
from runtime_loaders import by_library

# Relative; the arithmetic of all is double, of arrays of single precision.
TOLERANCE = 1e-9
PIXELS = 60
SUN = {"day": (0.0, 60.0), "rise": (-2.0, 1.0), "twilight": (-19.9, -1.0), "night": (-60.0, -22.0)}
LINES = {"ground": (-90.0, -5.0), "limb": (-1.6, 0.0), "upward": (0.0, 90.0), "horizon": (-1.45, -1.25)}


@pytest.fixture(scope="module")
def lines(scene, channel_atmosphere, band_file):
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
        return scene | {"atmosphere": str(channel_atmosphere), "band": str(band_file), "pixels": pixels}

    return drawn


@pytest.fixture(scope="module")
def shaded_texture(tmp_path_factory):
    return with_shade(write_texture_of_two(tmp_path_factory.mktemp("texture")))


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
    scene = lines(sun, line)
    terms = agrees(runtime, scene)
    assert np.min(terms["temperature"]) < 293 and np.max(terms["temperature"]) > 305
    lit = np.mean((terms["diffuse"] > 0) & (terms["specular"] > 0))
    assert lit > 0.3 if sun == "day" else sun != "night" or lit == 0
    length = np.array([pixel["range"] for pixel in scene["pixels"]])
    assert np.all((terms["path"] > 0) == (length > 0)) and np.mean(length > 0) > 0.7
    assert np.all((terms["transmittance"] > 0) & ((terms["transmittance"] < 1) == (length > 0)))


@pytest.mark.parametrize("line", LINES)
def test_texels_in_the_shade_and_faces_beside_walls_agree_with_the_library(runtime, lines, shaded_texture, line):
    """Light of what hides the sky by wavelength, over ranges from none to the longest."""
    draw, scene = np.random.default_rng(41), lines("day", line)
    pixels = []
    for number, pixel in enumerate(scene["pixels"][:20]):
        place = {"texel": [float(draw.uniform(0, 40)), float(draw.uniform(0, 20))], "level": number % 3}
        pixels.append(pixel | place | {"sky_view": float(draw.uniform(0.2, 1))})
    shaded = scene | {"texture": str(shaded_texture), "shaded_sky": 0.3, "pixels": pixels}
    terms = agrees(runtime, shaded)
    without = by_library(scene | {"pixels": scene["pixels"][:20]})
    assert np.any(terms["skyshine"] != without["skyshine"]) and np.any(terms["diffuse"] < without["diffuse"])


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
    terms = agrees(runtime, scene | {"pixels": [_level(pixel) for pixel in scene["pixels"]]})
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
    write_file(day, replace(root, axes=axes), Header("atmq", "data", "job"))
    dusk = scene["pixels"][0] | {"source_elevation": -9.0}
    status, shown, complaint = runtime(scene | {"atmosphere": str(day), "pixels": [dusk]})
    assert (status, shown) == (1, "") and complaint.startswith("source_elevation: found -9; allowed: -1 and above, or ")
    agrees(runtime, scene | {"atmosphere": str(day), "pixels": [dusk | {"source_elevation": -30.0}]})


def test_light_below_0_at_a_wavelength_is_none_there(runtime, lines, tmp_path):
    """Of a file whose factors of light are below 0 in every third channel."""
    scene = lines("day", "limb")
    root, attributes = read_file(scene["atmosphere"])
    changed = {}
    for light in ("direct_light", "thermal_sky", "scattered_sky", "thermal_harmonics", "scattered_harmonics"):
        factor = np.array(root.variables[f"{light}_factor"].data)
        factor[::3] *= -1.0
        changed[f"{light}_factor"] = replace(root.variables[f"{light}_factor"], data=factor)
    path = tmp_path / "below.atmq.h5"
    header = Header(attributes["filetype"], "data", "job")
    write_file(path, replace(root, variables=root.variables | changed), header)
    below = scene | {"atmosphere": str(path)}
    table, first = skyshine.mat.open(path), scene["pixels"][2]
    place = {name: first[f"centre_{name}"] for name in ("range", "elevation")}
    place |= {name: first[name] for name in ("altitude", "source_elevation")}
    tilted = table.ambient_radiance(slope=40.0, by_wavelength=True, **place)
    for parts in (tilted, *(table.value_by_wavelength(f"{name}_radiance", **place) for name in ("direct", "ambient"))):
        assert 0 < np.count_nonzero(parts == 0) < parts.size
    terms = agrees(runtime, below)
    assert np.mean(terms["diffuse"] > 0) > 0.3
    agrees(runtime, below | {"pixels": [_level(pixel) for pixel in scene["pixels"]]})


def _level(pixel):
    return {name: value for name, value in pixel.items() if name != "source_heading"}


def test_ends_of_bent_paths_agree(runtime, lines, tmp_path):
    """Of a file that says how refraction lowers them, by far more than any air does."""
    scene = lines("rise", "limb")
    root, attributes = read_file(scene["atmosphere"])
    ratio = root.variables["thermal_ratio"]
    rise = (-0.02 - 0.015 * np.sin(np.arange(ratio.data.size))).reshape(ratio.data.shape)
    path = tmp_path / "bent.atmq.h5"
    variables = {name: variable for name, variable in root.variables.items() if name != "end_rise"}
    header = Header(attributes["filetype"], "data", "job")
    write_file(path, replace(root, variables=variables | {"end_rise": replace(ratio, data=rise.astype("f4"))}), header)
    terms, straight = agrees(runtime, scene | {"atmosphere": str(path)}), by_library(scene)
    assert np.mean(np.abs(terms["skyshine"] - straight["skyshine"]) > 1e-5 * straight["skyshine"]) > 0.3
    np.testing.assert_array_equal(terms["path"], straight["path"])


def test_observers_in_space_agree(runtime, lines, tmp_path):
    """Lines that enter the air, that end before it and that pass it by, under a source of any azimuth."""
    scene, draw = lines("day", "ground"), np.random.default_rng(43)
    path = Path(shutil.copy(scene["atmosphere"], tmp_path / "space.atmq.h5"))
    with h5py.File(path, "r+") as file:
        file.attrs["range_km"], file.attrs["altitude_km"] = [0.0, 60_000.0], [0.01, 100.0]
    pixels = []
    for number, pixel in enumerate(scene["pixels"]):
        altitude = [99.0, 100.0, 150.0, 400.0, 36_000.0][number % 5]
        place = {"altitude": altitude, "centre_elevation": float(draw.uniform(-90, -60 if number % 3 else 20))}
        place["centre_range"] = float(draw.uniform(0.5, 1.6)) * altitude
        pixels.append(pixel | place | {"range": place["centre_range"], "source_elevation": float(draw.uniform(5, 50))})
    terms = agrees(runtime, scene | {"atmosphere": str(path), "pixels": pixels})
    assert 0.1 < np.mean(terms["path"] > 1e-6) < 0.9
    status, shown, complaint = runtime(scene | {"pixels": [pixels[3] | {"centre_range": 1.0}]})
    assert (status, shown) == (1, "") and complaint.startswith("altitude: found 400; allowed: 0.01 to 2")


def test_a_band_of_other_wavelengths_is_refused_in_one_line(runtime, lines, scene):
    """With the library too; and with no pixel."""
    other = lines("day", "ground") | {"band": scene["band"]}
    status, shown, complaint = runtime(other | {"pixels": []})
    assert (status, shown) == (1, "") and len(complaint.strip().splitlines()) == 1
    assert "b01.band.h5: " in complaint and "8 to 8.4 um; allowed: " in complaint
    assert complaint.endswith("those of the air\n")
    with pytest.raises(InputError, match="spans 8 to 8.4 um"):
        by_library(other)


def test_a_centre_without_a_range_gives_the_limit_of_short_ones(runtime, lines):
    """What the air lets through grows less by the same factor with each length, as close as the centre may be."""
    scene = lines("day", "ground")

    def thermal(centre_range):
        pixels = [pixel | {"centre_range": centre_range, "range": 2.0} for pixel in scene["pixels"]]
        status, shown, complaint = runtime(scene | {"pixels": pixels})
        assert status == 0, complaint
        return np.array([pixel["thermal"] for pixel in json.loads(shown)["pixels"]])

    at_once, near, far = (thermal(length) for length in (0.0, 1e-6, 2e-6))
    assert np.all(at_once > 0)
    np.testing.assert_allclose(at_once, 2 * near - far, rtol=1e-6)
    assert np.any(np.abs(at_once - thermal(1.0)) > 1e-4 * at_once)
