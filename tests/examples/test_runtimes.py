"""The C library against the package: the same pixels, every term of equation (1)."""

import json
import resource
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import skyshine.mat
import skyshine.tmm
from skyshine.mat.tables.axes import table_axis
from skyshine.schemas.hdf5 import Header, read_file, write_file

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
import good_databases
from runtime_loaders import by_library

PIXELS = 200


@pytest.fixture(scope="module")
def texture(tmp_path_factory):
    """A texture of 40 x 20 texels and six levels, grass on the left and asphalt on the right."""
    return good_databases.write_texture_of_two(tmp_path_factory.mktemp("texture"))


def test_every_term_agrees_with_the_library(runtime, scene):
    status, shown, complaint = runtime(scene)
    assert status == 0, complaint
    pixels, expected = json.loads(shown)["pixels"], by_library(scene)
    assert len(pixels) == PIXELS and np.count_nonzero(expected["diffuse"]) > PIXELS / 4
    for name, values in expected.items():
        np.testing.assert_allclose([pixel[name] for pixel in pixels], values, rtol=1e-6, atol=1e-12, err_msg=name)


@pytest.mark.parametrize("source", ["atmq", "lunar_atmq"])
def test_the_source_of_a_pixel_comes_from_the_tracks(runtime, scene, small_build, source):
    """Where the pixel names the azimuth of its line of sight in place of the source; day and night, to 36 h."""
    draw = np.random.default_rng(17)
    hours = [k * 0.61 % 36 for k in range(PIXELS)]
    pixels = [
        {
            name: value
            for name, value in pixel.items()
            if name not in ("source_elevation", "source_azimuth", "to_source")
        }
        | {"time": hour, "line_heading": float(draw.uniform(-180, 540))}
        for pixel, hour in zip(scene["pixels"], hours, strict=True)
    ]
    tracked = scene | {
        "atmosphere": str(small_build / f"s01b01.{source}.h5"),
        "pixels": pixels,
        "clamp": ["source_elevation"],
    }
    status, shown, complaint = runtime(tracked)
    assert status == 0, complaint
    low = skyshine.mat.open(tracked["surface"]).source_track(
        "sun" if source == "atmq" else "moon", time=np.array(hours)
    )
    high = low.elevation <= 60
    assert np.count_nonzero(high) > PIXELS / 2
    kept = [pixel for pixel, inside in zip(pixels, high, strict=True) if inside]
    expected = by_library(tracked | {"pixels": kept})
    found = [pixel for pixel, inside in zip(json.loads(shown)["pixels"], high, strict=True) if inside]
    for name, values in expected.items():
        np.testing.assert_allclose([pixel[name] for pixel in found], values, rtol=1e-6, atol=1e-12, err_msg=name)


def test_texels_of_a_texture_agree_with_the_library(runtime, scene, texture):
    """At several levels, at texels of one material and of two, at borders of the image, beside named materials."""
    draw = np.random.default_rng(19)
    pixels = []
    for number, pixel in enumerate(scene["pixels"]):
        texel = {"texel": [float(draw.uniform(0, 40)), float(draw.uniform(0, 20))], "level": number % 6}
        if number % 17 == 0:
            texel["texel"] = [40.0, 20.0]
        pixels.append(pixel if number % 9 == 0 else {k: v for k, v in pixel.items() if k != "material"} | texel)
    textured = scene | {"texture": str(texture), "pixels": pixels}
    status, shown, complaint = runtime(textured)
    assert status == 0, complaint
    found, expected = json.loads(shown)["pixels"], by_library(textured)
    for name, values in expected.items():
        np.testing.assert_allclose([each[name] for each in found], values, rtol=1e-6, atol=1e-12, err_msg=name)
    with skyshine.tmm.open_tmm(texture) as file:
        wanted = [file.code(*p["texel"], level=p["level"]) for p in pixels if "texel" in p]
        shares = np.array([file.mixture(*p["texel"], level=p["level"])[1] for p in pixels if "texel" in p])
    assert [each["material"] for each, p in zip(found, pixels, strict=True) if "texel" in p] == wanted
    assert np.any((shares[:, 1] > 0.05) & (shares[:, 1] < 0.5)) and len(set(wanted)) == 2


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"texel": [40.5, 3]}, "allowed: 0 to 40, 0 to 20"),
        ({"texel": [-1, 3]}, "allowed: 0 to 40, 0 to 20"),
        ({"texel": [1, 1], "level": 6}, "level"),
    ],
)
def test_a_texel_beyond_the_texture_is_refused_in_one_line(runtime, scene, texture, change, words):
    status, shown, complaint = runtime(scene | {"texture": str(texture), "pixels": [scene["pixels"][0] | change]})
    assert (status, shown) == (1, "") and words in complaint and len(complaint.strip().splitlines()) == 1


def test_shaded_and_heated_faces_agree_with_the_library(runtime, scene):
    """Shadows over midnight too, walls cbare and warmer than the air, and histories in few steps and in many."""
    draw = np.random.default_rng(11)
    pixels = []
    for number, pixel in enumerate(scene["pixels"][:24]):
        first = float(draw.uniform(0, 24))
        shade = {"shade": [[first, (first + float(draw.uniform(0.1, 9))) % 24]]}
        wall = {"sky_view": float(draw.uniform(0, 1)), "facing": float(draw.uniform(250, 350))}
        heat = draw.normal(scale=120, size=[1, 24, 96, 288, 7][number % 5]).tolist()
        pixels.append(
            pixel
            | [
                {"surroundings": shade},
                {"surroundings": shade | wall | {"facing_emissivity": 0.7}},
                {"surroundings": {"sky_view": 0.5}},
                {"absorbed_change": heat},
            ][number % 4]
        )
    scene = scene | {"pixels": pixels}
    status, shown, complaint = runtime(scene)
    assert status == 0, complaint
    expected = by_library(scene)
    sunlit = by_library(scene | {"pixels": [_bare(pixel) for pixel in pixels]})
    assert np.ptp(expected["temperature"] - sunlit["temperature"]) > 5
    for name in ("temperature", "thermal", "radiance"):
        found = [pixel[name] for pixel in json.loads(shown)["pixels"]]
        np.testing.assert_allclose(found, expected[name], rtol=1e-6, atol=1e-12, err_msg=name)


def test_melting_faces_agree_with_the_library(runtime, scene, tmp_path):
    """Of a file whose materials melt at 300 K and spend 90 W m^-2 on it: some pixels melt now, some at other times."""
    root, _ = read_file(scene["surface"])
    arrays = {name: root.variables[name] for name in ("highest_temperature", "melting_heat")}
    changed = {
        name: replace(array, data=np.full_like(array.data, value))
        for (name, array), value in zip(arrays.items(), (300.0, 90.0), strict=True)
    }
    melting = tmp_path / "melting.htt.h5"
    write_file(melting, replace(root, variables=root.variables | changed), Header("htt", "data", "job"))
    shade = {"surroundings": {"shade": [[8, 17]], "sky_view": 0.7, "facing": 290}}
    pixels = [
        pixel | (shade if number % 2 else {"absorbed_change": [40.0]})
        for number, pixel in enumerate(scene["pixels"][:16])
    ]
    wet = scene | {"surface": str(melting), "pixels": pixels}
    status, shown, complaint = runtime(wet)
    assert status == 0, complaint
    found, expected = [pixel["temperature"] for pixel in json.loads(shown)["pixels"]], by_library(wet)["temperature"]
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert np.abs(expected - by_library(scene | {"pixels": pixels})["temperature"]).max() > 1


def _bare(pixel):
    return {name: value for name, value in pixel.items() if name not in ("surroundings", "absorbed_change")}


def test_a_file_without_the_response_refuses_shade_in_one_line(runtime, scene, tmp_path):
    root, _ = read_file(scene["surface"])
    kept = {name: v for name, v in root.variables.items() if name in ("temperature", "material_name")}
    axes = {name: root.axes[name] for name in root.variables["temperature"].dims}
    bare = tmp_path / "bare.htt.h5"
    write_file(bare, replace(root, axes=axes, variables=kept), Header("htt", "data", "job"))
    shaded = scene["pixels"][0] | {"surroundings": {"shade": [[10, 14]]}}
    status, shown, complaint = runtime(scene | {"surface": str(bare), "pixels": [shaded]})
    assert (status, shown) == (1, "") and complaint.strip() == "the surface file has no response to shade"
    assert runtime(scene | {"surface": str(bare)})[0] == 0


@pytest.mark.parametrize("ground", [{}, {"ground_material": "asphalt_road"}])
def test_tilted_faces_are_lit_as_by_the_library(runtime, scene, ground):
    """Of any slope that the temperatures have, towards any side of the source, over either ground."""
    draw = np.random.default_rng(9)
    pixels = [pixel | ground | {"source_heading": float(draw.uniform(-400, 400))} for pixel in scene["pixels"]]
    status, shown, complaint = runtime(scene | {"pixels": pixels})
    assert status == 0, complaint
    expected = by_library(scene | {"pixels": pixels})
    for name in ("skyshine", "radiance"):
        found = [pixel[name] for pixel in json.loads(shown)["pixels"]]
        np.testing.assert_allclose(found, expected[name], rtol=1e-6, atol=1e-12, err_msg=name)
    level = by_library(scene)["skyshine"]
    assert np.mean(np.abs(expected["skyshine"] - level) > 0.01 * level) > 0.5


@pytest.mark.parametrize("name", ["range", "centre_range"])
def test_a_negative_range_is_refused_clamped_or_not(runtime, scene, name):
    """At -1 km a transmittance would be above 1."""
    behind = scene["pixels"][0] | {name: -1.0}
    for clamp in ([], ["range"]):
        status, shown, complaint = runtime(scene | {"pixels": [behind], "clamp": clamp})
        assert (status, shown) == (1, "") and complaint.startswith("range: found -1; allowed: ")
        assert len(complaint.strip().splitlines()) == 1


def test_outside_an_axis_it_stops_or_clamps_as_the_scene_says(runtime, scene):
    high = scene["pixels"][0] | {"surface_altitude": 7.0}
    status, _, complaint = runtime(scene | {"pixels": [high]})
    assert status == 1 and complaint.strip() == "altitude: found 7; allowed: 0 to 1"
    status, shown, _ = runtime(scene | {"pixels": [high], "clamp": ["altitude"]})
    _, expected, _ = runtime(scene | {"pixels": [high | {"surface_altitude": 1.0}]})
    assert status == 0 and json.loads(shown) == json.loads(expected)


def test_a_table_of_part_of_the_day_reads_over_midnight_and_refuses_noon(runtime, scene, tmp_path):
    """Times 18, 24 and 30 h, as needs.hours leaves them."""
    root, _ = read_file(scene["surface"])
    night, hours = [3, 0, 1], np.array([18.0, 24.0, 30.0])  # of the times 0, 6, 12, 18
    axes = root.axes | {"time": table_axis(hours, "h", "local clock time of day", period=24.0)}
    temperature = root.variables["temperature"]
    variables = root.variables | {"temperature": replace(temperature, data=temperature.data[..., night])}
    part = tmp_path / "night.htt.h5"
    write_file(part, replace(root, axes=axes, variables=variables), Header("htt", "data", "job"))
    at_night = [pixel | {"time": (19.0 + number / 20) % 24} for number, pixel in enumerate(scene["pixels"])]
    status, shown, complaint = runtime(scene | {"surface": str(part), "pixels": at_night})
    assert status == 0, complaint
    whole = by_library(scene | {"pixels": at_night})["temperature"]
    np.testing.assert_allclose([pixel["temperature"] for pixel in json.loads(shown)["pixels"]], whole, rtol=1e-6)
    status, shown, complaint = runtime(scene | {"surface": str(part), "pixels": [at_night[0] | {"time": 12.0}]})
    assert status == 1 and complaint.startswith("time: found ") and "allowed: 18 to 30" in complaint


def test_another_version_another_kind_and_damage_are_refused_in_one_line(runtime, scene, tmp_path):
    newer = tmp_path / "newer.htt.h5"
    shutil.copyfile(scene["surface"], newer)
    with h5py.File(newer, "r+") as file:
        file.attrs["format_version"] = "2.0.0"
    damaged = tmp_path / "damaged.htt.h5"
    damaged.write_bytes(Path(scene["surface"]).read_bytes()[:3000])
    for wrong, words in (
        (newer, "formats 1.x"),
        (scene["band"], "'band'"),
        (damaged, "not a readable HDF5 file"),
    ):
        status, shown, complaint = runtime(scene | {"surface": str(wrong)})
        assert status == 1 and words in complaint and len(complaint.strip().splitlines()) == 1 and not shown.strip()


def test_nothing_is_shown_where_the_last_pixel_is_wrong(runtime, scene):
    wrong = scene["pixels"][1] | {"surface_altitude": 7.0}
    status, shown, complaint = runtime(scene | {"pixels": [scene["pixels"][0], wrong]})
    assert status == 1 and not shown and "allowed: 0 to 1" in complaint


def test_the_program_takes_memory_in_proportion_to_the_pixels(c_program, scene, tmp_path):
    """Each text once took as much as all that came after it in the scene: of 4,000 pixels 4 GB and more."""
    path, limit = tmp_path / "scene.json", 1 << 29
    path.write_text(json.dumps(scene | {"pixels": scene["pixels"] * 20}), encoding="utf-8")
    done = subprocess.run(
        [*c_program, path],
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    assert done.returncode == 0, done.stderr
    assert len(json.loads(done.stdout)["pixels"]) == 20 * PIXELS
