"""An export holds what the databases hold, within what its headers state."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from gpu_files import read_gpu

import skyshine.mat
from skyshine.mat.cli import main
from skyshine.mat.gpu.air import FRAME_BYTES, GroundDay, export_air
from skyshine.mat.gpu.codes import export_codes
from skyshine.mat.gpu.evaluation import GpuAir
from skyshine.mat.gpu.export import Frame, export_gpu
from skyshine.mat.gpu.stated_error import apparent_temperature, random_pixels, with_stated_error
from skyshine.mat.gpu.surface import export_surface
from skyshine.mat.runtime.pixel import pixel_radiance
from skyshine.schemas.errors import InputError
from skyshine.tmm import open_tmm

sys.path.insert(0, str(Path(__file__).parents[2] / "fuzz"))
from good_databases import with_shade

FRAME = Frame(13.0, 0.5)


@pytest.fixture(scope="module")
def exported(plan_build, tmp_path_factory):
    folder = tmp_path_factory.mktemp("frame")
    export_gpu([plan_build], folder, FRAME)
    return folder


@pytest.fixture(scope="module")
def tables(plan_build):
    """Surface, band and sunlit air."""
    return [skyshine.mat.open(plan_build / f"{name}.h5") for name in ("s01.htt", "b01.band", "s01b01.atmq")]


def test_every_database_and_both_shaders_are_written(exported):
    names = {path.name for path in exported.iterdir()}
    files = ("s01.htt", "b01.band", "s01b01.atmq", "s01b01.lunar_atmq", "halves.tmm")
    assert names == {f"{name}.gpu.{end}" for name in files for end in ("json", "bin")} | {
        "skyshine.glsl",
        "skyshine.hlsl",
    }


def test_the_air_of_a_frame_is_small_with_its_header(exported):
    for name in ("s01b01.atmq", "s01b01.lunar_atmq"):
        assert sum((exported / f"{name}.gpu.{end}").stat().st_size for end in ("json", "bin")) <= FRAME_BYTES


def difference(content, tables, seed):
    """Apparent temperatures of random pixels from textures, less those of the library."""
    surface, band, air = tables
    elevation = content.numbers["source_elevation"]["path"][0]
    pixels = random_pixels(content, 500, np.random.default_rng(seed), elevation)
    exact = pixel_radiance(surface, band, air, pixels.faces, pixels.view).radiance
    read = GpuAir.of(content).frame(elevation).radiance(band, pixels.faces, pixels.view)
    return np.abs(apparent_temperature(band, read) - apparent_temperature(band, exact))


def test_other_pixels_than_those_measured_are_within_the_stated_error(exported, tables):
    content = read_gpu(exported / "s01b01.atmq.gpu.json")
    stated = content.stated_error
    assert stated["units"] == "K"
    error = difference(content, tables, seed=99)
    assert np.quantile(error, 0.99) <= 1.5 * stated["p99"]
    assert error.max() <= 2 * stated["largest"]
    assert stated["p99"] <= 0.15


def test_a_wrong_texel_is_seen_in_the_stated_error(exported, tables):
    content = read_gpu(exported / "s01b01.atmq.gpu.json")
    air = content.textures["air0"]
    wrong = air.texels.copy()
    wrong[..., 0] *= np.float16(0.98)
    textures = content.textures | {"air0": replace(air, texels=wrong)}
    surface, band, table = tables
    measured = with_stated_error(replace(content, textures=textures), table, band, surface)
    assert measured.stated_error["p99"] > 5 * content.stated_error["p99"]


def test_the_air_of_a_whole_day_and_of_all_altitudes(tables):
    surface, band, air = tables
    content = with_stated_error(export_air(air, band, texels=1500), air, band, surface)
    assert content.textures["air0"].size[2] > 1
    assert content.stated_error["p99"] <= 0.3
    at_night = GpuAir.of(content).frame(-60.0)
    assert not np.any(np.abs(at_night.terms["direct"]) > 1e-3)


def test_the_ground_of_a_day_is_that_of_its_hour(tables):
    """Tilted faces see the ground that the atmosphere names, warmer at 14 h than at 4 h."""
    surface, band, air = tables
    day = GroundDay.of(air, band, surface)
    gpu = GpuAir.of(export_air(air, band, ground_day=day, texels=1500))
    pixels = random_pixels(gpu.content, 500, np.random.default_rng(4), 30.0)
    one = np.ones(500)
    faces = replace(pixels.faces, time=14.0 * one, ground_temperature=None, slope=80 * one)
    exact = pixel_radiance(surface, band, air, faces, pixels.view).radiance
    apart = [np.abs(gpu.frame(30.0, hour).radiance(band, faces, pixels.view) - exact).mean() for hour in (14.0, 4.0)]
    assert apart[0] < 0.2 * apart[1]
    assert gpu.ground_at(14.0)[0] == pytest.approx(float(air.ground_temperature(surface, time=14.0)), abs=1e-3)


def test_a_table_of_one_altitude(tables):
    surface, band, air = tables
    cut = replace(air, attributes=air.attributes | {"altitude_km": np.array([0.5, 0.5])})
    content = with_stated_error(export_air(cut, band, source_elevation=30.0), cut, band, surface)
    assert content.textures["air0"].size[2] == 1
    assert content.numbers["altitude_km"] == [0.5, 0.5]
    assert content.stated_error["p99"] <= 0.2


def test_a_source_that_the_table_cannot_tell_of_is_refused(tables):
    _, band, air = tables
    content = export_air(air, band, altitude=0.5, source_elevation=20.0)
    with pytest.raises(InputError, match="allowed: 20, the frame's own"):
        GpuAir.of(content).frame(25.0)
    with pytest.raises(InputError, match="altitude: found 9; allowed: 0.01 to 1 km"):
        export_air(air, band, altitude=9.0)


def test_components_are_half_floats_that_use_their_range(exported):
    content = read_gpu(exported / "s01b01.atmq.gpu.json")
    groups = [part.texels for name, part in content.textures.items() if name.startswith("air")]
    layers = np.concatenate(groups, axis=-1).reshape(-1, content.numbers["components"])
    assert layers.dtype == np.float16
    assert np.abs(layers).max(axis=0) == pytest.approx(1.0, abs=1e-3)


def test_temperatures_at_the_nodes_are_those_of_the_table(tables, exported):
    surface = tables[0]
    for content in (export_surface(surface), read_gpu(exported / "s01.htt.gpu.json")):
        numbers = content.numbers
        times, slopes, azimuths = (np.array(numbers[name]) for name in ("time", "slope", "azimuth"))
        shape = (times.size, len(numbers["material"]), len(numbers["altitude"]))
        above = content.textures["temperature"].texels.astype(float).reshape(*shape, slopes.size, azimuths.size)
        reference = content.textures["reference"].texels.astype(float).reshape(shape)
        exact = surface.temperature(
            material=np.array(numbers["material"])[:, None, None, None],
            altitude=np.array(numbers["altitude"])[:, None, None],
            slope=slopes[:, None],
            azimuth=azimuths,
            time=times[:, None, None, None, None],
        )
        error = np.abs(above + reference[..., None, None] - exact).max()
        assert error <= content.stated_error["largest"] + 1e-4
        assert error <= 0.02


def test_the_response_to_shade_is_that_of_the_table(tables):
    surface = tables[0]
    content = export_surface(surface)
    kernel = np.asarray(surface.root.variables["response_kernel"].data, float)
    stored = content.textures["response_kernel"].texels.astype(float) * content.numbers["scale"]["response_kernel"]
    assert stored.reshape(kernel.shape) == pytest.approx(kernel, rel=6e-4, abs=1e-6 * np.abs(kernel).max())


@pytest.mark.parametrize("hour", [None, 13.4])
def test_temperatures_in_the_shade_are_those_of_the_table(tables, hour):
    """At nodes of the table and between them, at all hours or at that of a frame."""
    surface = tables[0]
    content = export_surface(surface, hour=hour, shaded_sky=0.4)
    numbers = content.numbers
    axes = [numbers[name] for name in ("shaded_time", "material", "altitude", "shaded_slope", "shaded_azimuth")]
    change = content.textures["shaded_change"].texels.astype(float).reshape([len(axis) for axis in axes])
    assert set(numbers["slope"]) < set(numbers["shaded_slope"]) and numbers["shaded_sky"] == 0.4
    assert np.diff(numbers["shaded_azimuth"]).max() <= 15 and (len(axes[0]) == 1) == (hour is not None)
    for place in (
        (0, 0, 0, 0, 0),
        (-1, 1, 1, 3, 5),
        (len(axes[0]) // 2, 0, 1, -1, -1),
        (len(axes[0]) // 3, 1, 0, 2, 7),
    ):
        time, material, altitude, slope, azimuth = (axis[k] for axis, k in zip(axes, place, strict=True))
        where = {"material": material, "altitude": altitude, "slope": slope, "azimuth": azimuth % 360, "time": time}
        dark = surface.shaded_temperature(sky_view=0.4, **where)
        assert surface.temperature(**where) + change[place] == pytest.approx(float(dark), abs=0.02)
    air = surface.value("air_temperature", altitude=np.array(axes[2]), forcing_time=np.array(axes[0])[:, None])
    assert numbers["air_temperature"] == pytest.approx(air)


def test_an_export_of_a_folder_with_shade_holds_it_on_all_levels(plan_build, tmp_path):
    # The texture and the temperatures alone, which the shade changes.
    files = [Path(shutil.copy(plan_build / name, tmp_path)) for name in ("halves.tmm.h5", "s01.htt.h5")]
    export_gpu(files, tmp_path / "plain")
    with_shade(files[0])
    export_gpu(files, tmp_path / "out")
    content = read_gpu(tmp_path / "out" / "halves.tmm.gpu.json")
    with open_tmm(files[0]) as file:
        for level in range(file.levels):
            stored = content.textures[f"shade{level}"]
            assert stored.format == "R8" and np.array_equal(
                stored.texels[0, ..., 0], file.array(f"levels/{level}/shade")
            )
    assert read_gpu(tmp_path / "out" / "s01.htt.gpu.json").numbers["shaded_sky"] == 0.5
    assert "shaded_change" not in read_gpu(tmp_path / "plain" / "s01.htt.gpu.json").textures
    assert "shade0" not in read_gpu(tmp_path / "plain" / "halves.tmm.gpu.json").textures


def test_mixtures_of_all_levels_are_those_of_the_texture(plan_build):
    with open_tmm(plan_build / "halves.tmm.h5") as file:
        content = export_codes(file, "halves.tmm.h5")
        mixtures = content.textures["mixtures"].texels.reshape(-1, 2, 4)
        total = content.numbers["share_total"]
        for level in range(file.levels):
            number = content.textures[f"level{level}"].texels[0, ..., 0]
            shares = file.array(f"levels/{level}/mix_weight")
            codes = np.where(shares > 0, file.array(f"levels/{level}/mix_code"), 0)
            assert np.array_equal(mixtures[number, 0, :3], codes)
            assert np.array_equal(mixtures[number, 1, :3], shares)
            assert np.all(mixtures[number, 1, :3].sum(axis=-1) == total)
        assert content.stated_error["largest"] == 0


def test_more_mixtures_than_numbers_are_rounded_and_the_header_says_by_how_much(plan_build, monkeypatch):
    with open_tmm(plan_build / "halves.tmm.h5") as file:
        whole = export_codes(file, "halves.tmm.h5")
        monkeypatch.setattr("skyshine.mat.gpu.codes.MOST", whole.numbers["mixtures"] - 1)
        rounded = export_codes(file, "halves.tmm.h5")
    assert rounded.numbers["mixtures"] < whole.numbers["mixtures"]
    first, second = (c.textures["mixtures"].texels.reshape(-1, 2, 4) for c in (whole, rounded))
    place, other = (c.textures["level1"].texels[0, ..., 0] for c in (whole, rounded))
    moved = np.abs(second[other, 1, 0].astype(float) - first[place, 1, 0]) / whole.numbers["share_total"]
    assert 0 < rounded.stated_error["largest"] <= 0.5
    assert moved.max() <= 2 * rounded.stated_error["largest"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--to", "gpus"], "found --to 'gpus'; did you mean 'gpu'?"),
        ([], "no format is named; allowed: --to raw"),
        (["--to", "raw", "--hour", "3", "--altitude", "1"], "No such option"),
        (["--to=gpu", "--hour", "3"], "give both --hour and --altitude"),
        (["--to=gpu", "--hour", "3", "--altitude", "90"], "altitude: found 90"),
        (["--to=gpu", "--hour", "99", "--altitude", "0.5"], "99"),
    ],
)
def test_wrong_options_are_refused_in_one_line(plan_build, tmp_path, options, message):
    done = CliRunner().invoke(main, ["export", str(plan_build), "--out", str(tmp_path), *options])
    assert done.exit_code == 2
    assert message in done.output
    assert len(done.output.strip().splitlines()) == 1


def test_an_atmosphere_without_its_band_is_refused(plan_build, tmp_path):
    (tmp_path / "s01b01.atmq.h5").write_bytes((plan_build / "s01b01.atmq.h5").read_bytes())
    done = CliRunner().invoke(main, ["export", str(tmp_path / "s01b01.atmq.h5"), "--to", "gpu", "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert "needs b01.band.h5, which is not beside it" in done.output
