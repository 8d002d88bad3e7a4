"""Texels in the shade of their photograph: the C library against the package, to 1e-9."""

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import skyshine.tmm
from skyshine.schemas.hdf5 import Header, Variable, read_file, write_file

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
import good_databases
from runtime_loaders import by_library

LEVELS, PIXELS = 6, 30


@pytest.fixture(scope="module")
def plain_texture(tmp_path_factory):
    return good_databases.write_texture_of_two(tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="module")
def texture(plain_texture, tmp_path_factory):
    """The texture of 40 x 20 texels with shade of shares 0 to 1 on six levels."""
    fbare = tmp_path_factory.mktemp("shaded")
    return good_databases.with_shade(Path(shutil.copy(plain_texture, fbare / plain_texture.name)))


@pytest.fixture(scope="module")
def textured(scene, texture):
    """Two scenes of texels of all levels: of level faces, and of tilted ones."""
    draw, scenes = np.random.default_rng(31), []
    for turned in (False, True):  # `source_heading` is of all pixels of a list of the library, or of none
        pixels = []
        for number, pixel in enumerate(scene["pixels"][:PIXELS]):
            texel = {"texel": [float(draw.uniform(0, 40)), float(draw.uniform(0, 20))], "level": number % LEVELS}
            heading = {"source_heading": float(draw.uniform(0, 360))} if turned else {}
            pixels.append({name: value for name, value in pixel.items() if name != "material"} | texel | heading)
        scenes.append(scene | {"texture": str(texture), "pixels": pixels})
    return scenes


def agrees(runtime, scene):
    """The terms of the library, after a comparison with those of a runtime."""
    status, shown, complaint = runtime(scene)
    assert status == 0, complaint
    found, expected = json.loads(shown)["pixels"], by_library(scene)
    for name, values in expected.items():
        np.testing.assert_allclose([each[name] for each in found], values, rtol=1e-9, atol=1e-13, err_msg=name)
    return expected


def shade_of(scene):
    with skyshine.tmm.open_tmm(scene["texture"]) as file:
        return np.array([file.shade(*pixel["texel"], level=pixel["level"]) for pixel in scene["pixels"]])


@pytest.mark.parametrize("shaded_sky", [None, 0.2])
def test_texels_in_the_shade_agree_with_the_library(runtime, textured, plain_texture, shaded_sky):
    """Partly and wholly, at all levels and hours, on level and tilted faces, under several shares of the sky."""
    for scene in textured:
        shaded = scene if shaded_sky is None else scene | {"shaded_sky": shaded_sky}
        terms, share = agrees(runtime, shaded), shade_of(scene)
        assert np.any(share == 1) and np.any((share > 0.2) & (share < 0.8)) and np.any(share == 0)
        sunlit = by_library(scene | {"texture": str(plain_texture)})
        assert np.all(terms["diffuse"][share == 1] == 0) and np.any(sunlit["diffuse"][share > 0] > 0)
        assert np.ptp(sunlit["temperature"] - terms["temperature"]) > 5


def test_faces_under_a_part_of_the_sky_agree_with_the_library(runtime, textured):
    """In the shade and in sunlight, with and without surroundings, over the file's ground and over another."""
    draw = np.random.default_rng(37)
    for scene in textured:
        pixels = []
        for number, pixel in enumerate(scene["pixels"][::2]):
            pixel = pixel | {"sky_view": float(draw.uniform(0, 1)), "ground_material": "asphalt_road"}
            if number % 3 == 0:
                wall = {"facing": float(draw.uniform(260, 330)), "sky_view": float(draw.uniform(0, 1))}
                pixel["surroundings"] = {"shade": [[8, 12]]} | (wall if number % 2 else {})
            pixels.append(pixel)
        agrees(runtime, scene | {"pixels": pixels})
        agrees(runtime, scene | {"pixels": [{k: v for k, v in p.items() if k != "ground_material"} for p in pixels]})


def test_the_ground_that_a_file_names_is_before_the_walls(runtime, textured, tmp_path):
    """Its temperature is that of level ground at the lowest altitude of the surface file, at the hour of the pixel."""
    named = tmp_path / Path(textured[1]["atmosphere"]).name
    shutil.copyfile(textured[1]["atmosphere"], named)
    with h5py.File(named, "r+") as file:
        file.attrs["ground_material"] = "grass_green"
    scene = textured[1] | {"atmosphere": str(named), "shaded_sky": 0.1}
    terms, stated = agrees(runtime, scene), by_library(textured[1] | {"shaded_sky": 0.1})
    assert np.any(terms["skyshine"] != stated["skyshine"])
    with h5py.File(named, "r+") as file:
        file.attrs["ground_material"] = "no_such_material"
    status, shown, complaint = runtime(scene)
    assert (status, shown) == (1, "") and "no_such_material" in complaint and len(complaint.strip().splitlines()) == 1


def film_of(root):
    """A shower at noon on all materials of a file but the first."""
    excess, slope = root.variables["heat_loss_excess"], root.variables["heat_loss_slope"]
    offsets, table = np.asarray(root.axes["temperature_offset"].values), np.ones(excess.data.shape)
    codes = root.axes["material"].values.size
    rain = np.where(np.abs(np.arange(288) / 12 - 12) < 0.5, 4e-4, 0.0)
    arrays = {
        "film_heat_loss": ("W m^-2", excess.dims, table * (40 + 8 * offsets + 0.02 * offsets * np.abs(offsets))),
        "film_evaporation": ("kg m^-2 s^-1", excess.dims, 1e-5 * table * (1 + offsets / 4)),
        "film_sunlight": ("W m^-2", slope.dims, np.full(slope.data.shape, 30.0)),
        "absorbed_sunlight": ("W m^-2", slope.dims, np.full(slope.data.shape, 200.0)),
        "film_capacity": ("kg m^-2", ("material",), np.where(np.arange(codes) == 0, 0.0, 0.5)),
        "rain": ("kg m^-2 s^-1", ("forcing_time",), rain),
    }
    return {name: Variable(dims, data.astype(np.float32), units, name) for name, (units, dims, data) in arrays.items()}


def test_a_film_of_water_lasts_in_the_shade_as_in_the_library(runtime, textured, tmp_path):
    """A film that returns after the day, one that lies there before it, and none, as in bare files."""
    scene, found = textured[1] | {"shaded_sky": 0.2}, {}
    root, _ = read_file(scene["surface"])
    column = root.variables["heat_loss_slope"].dims[:3]
    water = np.full([root.axes[name].values.size for name in column], 0.3, np.float32)
    before = {"film_before": Variable(column, water, "kg m^-2", "water on the surface")}
    wet = root.variables | film_of(root)
    for name, variables in (("returns", wet), ("lies", wet | before), ("none", root.variables)):
        path = tmp_path / f"{name}.htt.h5"
        write_file(path, replace(root, variables=variables), Header("htt", "data", "job"))
        found[name] = agrees(runtime, scene | {"surface": str(path)})["temperature"]
    assert np.abs(found["returns"] - found["none"]).max() > 0.5
    assert np.abs(found["returns"] - found["lies"]).max() > 0.05


def test_a_texture_without_shade_reads_as_one_in_the_sun(runtime, textured, texture, tmp_path):
    """A layer of zeros, and none: the same characters."""
    scene = textured[0]
    none, zeros = tmp_path / "none.tmm.h5", tmp_path / "zeros.tmm.h5"
    for path in (none, zeros):
        shutil.copyfile(texture, path)
    with h5py.File(none, "r+") as without, h5py.File(zeros, "r+") as empty:
        for level in range(LEVELS):
            del without[f"levels/{level}/shade"]
            empty[f"levels/{level}/shade"][...] = 0
    shown = runtime(scene | {"texture": str(none)})
    assert shown[0] == 0 and runtime(scene | {"texture": str(zeros)}) == shown


def test_a_surface_file_without_the_response_refuses_shade_in_one_line(runtime, textured, tmp_path):
    root, _ = read_file(textured[0]["surface"])
    kept = {name: v for name, v in root.variables.items() if name in ("temperature", "material_name")}
    axes = {name: root.axes[name] for name in root.variables["temperature"].dims}
    bare = tmp_path / "bare.htt.h5"
    write_file(bare, replace(root, axes=axes, variables=kept), Header("htt", "data", "job"))
    status, shown, complaint = runtime(textured[0] | {"surface": str(bare)})
    assert (status, shown) == (1, "") and complaint.strip() == "the surface file has no response to shade"
    lit = [pixel for pixel, share in zip(textured[0]["pixels"], shade_of(textured[0]), strict=True) if share == 0]
    assert runtime(textured[0] | {"surface": str(bare), "pixels": lit})[0] == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"shaded_sky": 1.5}, "found 1.5; allowed: 0 to 1"),
        ({"shaded_sky": -0.5}, "found -0.5; allowed: 0 to 1"),
        ({"absorbed_change": [10.0]}, "a texel in the shade takes 'surroundings' in place of 'absorbed_change'"),
    ],
)
def test_a_wrong_scene_of_shade_is_refused_in_one_line(runtime, textured, change, words):
    scene = textured[0]
    dark = int(np.flatnonzero(shade_of(scene) == 1)[0])
    status, shown, complaint = runtime(scene | change | {"pixels": [scene["pixels"][dark] | change]})
    assert (status, shown) == (1, "") and words in complaint and len(complaint.strip().splitlines()) == 1


def damaged(name, level, edit):
    def change(path):
        with h5py.File(path, "r+") as file:
            edit(file, f"levels/{level}/shade")

    return pytest.param(level, change, id=f"{name}-{level}")


def _retyped(file, name, values):
    del file[name]
    file.create_dataset(name, data=values).attrs["total"] = 255


@pytest.mark.parametrize(
    ("level", "change"),
    [
        case
        for level in (0, 1)
        for case in (
            damaged("floats", level, lambda f, n: _retyped(f, n, f[n][()].astype(np.float32))),
            damaged("sixteen-bits", level, lambda f, n: _retyped(f, n, f[n][()].astype(np.uint16))),
            damaged("signed", level, lambda f, n: _retyped(f, n, (f[n][()] // 2).astype(np.int8))),
            damaged("fewer-rows", level, lambda f, n: _retyped(f, n, f[n][1:])),
            damaged("three-axes", level, lambda f, n: _retyped(f, n, f[n][()][..., None])),
            damaged("another-total", level, lambda f, n: f[n].attrs.__setitem__("total", 200)),
            damaged("no-total", level, lambda f, n: f[n].attrs.__delitem__("total")),
        )
    ]
    + [damaged("missing", 1, lambda f, n: f.__delitem__(n))],
)
def test_a_damaged_layer_of_shade_is_refused_when_its_level_is_read(
    runtime, textured, texture, tmp_path, level, change
):
    path = tmp_path / "damaged.tmm.h5"
    shutil.copyfile(texture, path)
    change(path)
    scene = textured[0] | {"texture": str(path)}
    of_level = [pixel for pixel in scene["pixels"] if pixel["level"] == level]
    status, shown, complaint = runtime(scene | {"pixels": of_level})
    assert (status, shown) == (1, "") and str(path) in complaint and len(complaint.strip().splitlines()) == 1
    if level == 1:
        assert runtime(scene | {"pixels": [pixel for pixel in scene["pixels"] if pixel["level"] == 0]})[0] == 0
