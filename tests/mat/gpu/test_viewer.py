"""What the page shows is what the library computes, by the shader of the export, without asking for anything."""

import json
import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.cli import main
from skyshine.mat.gpu.stated_error import apparent_temperature
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance
from skyshine.mat.tables.band import BandTable
from skyshine.tmm import open_tmm

sys.path.insert(0, str(Path(__file__).parents[2] / "fuzz"))
from good_databases import with_shade

LARGEST_K = 0.065  # of apparent temperature: what textures of half precision leave


def settings_of(folder):
    return json.loads(re.search(r"settings: (\{.*\}), files", (folder / "index.html").read_text()).group(1))


@pytest.fixture(scope="module")
def page(plan_build, tmp_path_factory):
    folder = tmp_path_factory.mktemp("view")
    done = CliRunner().invoke(main, ["view", str(plan_build), "--out", str(folder), "--altitude", "0.5"])
    assert done.exit_code == 0, done.output
    assert done.output.split() == [str(folder / "index.html")]
    return folder


def expected(built, page, result, source, stride):
    """Radiance of the pixels that a probe read, by the library, from the geometry that the page states."""
    settings = settings_of(page)
    surface = skyshine.mat.open(built / "s01.htt.h5")
    band = skyshine.mat.open(built / "b01.band.h5")
    air = skyshine.mat.open(built / f"s01b01.{'' if source == 'sun' else 'lunar_'}atmq.h5")
    track = surface.source_track(source, time=result["hour"])
    up, along = np.radians(float(track.elevation)), np.radians(float(track.azimuth))
    to_source = np.array([np.cos(up) * np.sin(along), np.cos(up) * np.cos(along), np.sin(up)])
    row, column = (v.ravel() for v in np.mgrid[0 : settings["rows"] : stride, 0 : settings["columns"] : stride])
    size, height = settings["metres_per_texel"], settings["altitude_km"] - settings["surface_km"]
    aside = np.sqrt(max(result["range"] ** 2 - height**2, 0.0))
    observer = 1e3 * np.array([0.0, -aside, height])
    points = np.stack(
        [(column + 0.5 - settings["columns"] / 2) * size, (settings["rows"] / 2 - row - 0.5) * size, 0.0 * row], -1
    )
    way = observer - points
    reach = np.linalg.norm(way, axis=-1)
    to_observer = way / reach[:, None]
    elevation = -np.degrees(np.arcsin(to_observer[:, 2]))
    heading = np.degrees(np.arctan2(-to_observer[:, 0], -to_observer[:, 1]))
    count = row.size
    full, flat = np.full(count, 1.0), np.zeros(count)
    with open_tmm(built / "halves.tmm.h5") as texture:
        codes, shares = texture.mixture(column + 0.5, row + 0.5)
        shade = texture.shade(column + 0.5, row + 0.5)
    faces = Faces(codes, shares, settings["surface_km"] * full, flat, flat, result["hour"] * full, shade=shade)
    lines = LinesOfSight(
        reach / 1e3,
        settings["altitude_km"] * full,
        elevation,
        float(track.elevation) * full,
        float(track.azimuth) - heading,
    )
    view = View(
        lines,
        reach / 1e3,
        np.tile([0.0, 0.0, 1.0], (count, 1)),
        np.tile(to_source, (count, 1)),
        to_observer,
        float(track.azimuth) * full,
    )
    return band, pixel_radiance(surface, band, air, faces, view)


@pytest.mark.parametrize(
    ("hour", "source", "range_share"), [(13.0, "sun", 0.0), (16.4, "sun", 0.6), (4.0, "sun", 0.3), (23.0, "moon", 1.0)]
)
def test_a_frame_of_the_page_is_that_of_the_library(browser, plan_build, page, hour, source, range_share):
    wanted = {"band": "s01b01", "hour": hour, "source": source, "range": range_share, "stride": 3}
    result, pixels, messages, requests = browser.probe(page / "index.html", **wanted)
    assert messages == []
    assert requests == set()
    assert (result["message"], result["error"]) == ("", 0)
    band, library = expected(plan_build, page, result, source, wanted["stride"])
    assert np.ptp(library.temperature) > 0.05  # two materials are seen
    assert np.abs(pixels[:, 1] - apparent_temperature(band, library.radiance)).max() <= LARGEST_K
    assert np.abs(pixels[:, 2] - library.temperature).max() <= 1e-3


@pytest.fixture(scope="module")
def shaded_build(plan_build, tmp_path_factory):
    """The databases with a layer of shade in their texture."""
    folder = shutil.copytree(plan_build, tmp_path_factory.mktemp("shaded") / "built")
    with_shade(folder / "halves.tmm.h5")
    return folder


@pytest.fixture(scope="module")
def shaded_page(shaded_build, tmp_path_factory):
    folder = tmp_path_factory.mktemp("shaded_view")
    done = CliRunner().invoke(main, ["view", str(shaded_build), "--out", str(folder), "--altitude", "0.5"])
    assert done.exit_code == 0, done.output
    return folder


@pytest.mark.parametrize(("hour", "source"), [(9.0, "sun"), (13.0, "sun"), (23.0, "moon")])
def test_texels_in_the_shade_are_those_of_the_library(browser, shaded_build, shaded_page, hour, source):
    wanted = {"band": "s01b01", "hour": hour, "source": source, "range": 0.3, "stride": 3}
    result, pixels, messages, _ = browser.probe(shaded_page / "index.html", **wanted)
    assert (messages, result["message"], result["error"]) == ([], "", 0)
    band, library = expected(shaded_build, shaded_page, result, source, wanted["stride"])
    if hour == 13.0:
        assert np.ptp(library.temperature) > 8
    assert np.abs(pixels[:, 1] - apparent_temperature(band, library.radiance)).max() <= LARGEST_K
    assert np.abs(pixels[:, 2] - library.temperature).max() <= 0.02


def test_shade_without_the_response_to_it_is_refused_in_one_line(shaded_build, tmp_path):
    folder = shutil.copytree(shaded_build, tmp_path / "built")
    with h5py.File(folder / "s01.htt.h5", "r+") as file:
        del file["response_kernel"]
    done = CliRunner().invoke(main, ["view", str(folder), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "has no response to shade" in done.output and len(done.output.strip().splitlines()) == 1


def test_the_first_picture_of_a_frame_has_the_values_of_every_third_texel(browser, page):
    wanted = {"band": "s01b01", "hour": 16.4, "source": "sun", "range": 0.6}
    settings = settings_of(page)
    frames = []
    for more in ({}, {"coarse": 3}):
        _, pixels, messages, _ = browser.probe(page / "index.html", **wanted, **more)
        assert messages == []
        frames.append(pixels.reshape(settings["rows"], settings["columns"], 4)[::-1])  # from the bottom, as it is drawn
    complete, first = frames
    assert np.ptp(complete[..., 1]) > 0.05
    middles = [np.minimum(3 * (np.arange(count) // 3) + 1, count - 1) for count in complete.shape[:2]]
    assert np.array_equal(first, complete[np.ix_(*middles)])


def test_palettes_run_from_cold_to_hot(page):
    palettes = {entry["name"]: np.array(entry["colours"]) for entry in settings_of(page)["palettes"]}
    assert list(palettes) == ["White hot", "Black hot", "Inferno"]
    for name, colours in palettes.items():
        assert (colours.min(), colours.max()) >= (0, 250) and colours.max() <= 255
        brightness = colours @ [0.2126, 0.7152, 0.0722]  # of Rec. 709
        assert (np.diff(brightness if name != "Black hot" else brightness[::-1]) > 0).all()


def test_nothing_in_the_folder_names_an_address(page):
    for file in (page / "index.html", page / "viewer.js", *page.glob("data/*.js")):
        assert not re.search(r"\b(?:https?|wss?)://", file.read_text(encoding="utf-8")), file


@pytest.mark.parametrize(
    ("prepared", "message"),
    [
        (lambda folder: None, "is not a folder of databases"),
        (lambda folder: folder.mkdir(), "has no database"),
        (lambda folder: (folder.mkdir(), (folder / "s01.htt.h5").touch()), "has databases but no catalog.json"),
    ],
)
def test_a_folder_that_is_no_build_is_refused_in_one_line(tmp_path, prepared, message):
    prepared(tmp_path / "built")
    done = CliRunner().invoke(main, ["view", str(tmp_path / "built"), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert message in done.output
    assert len(done.output.strip().splitlines()) == 1


def test_a_half_built_folder_is_refused(plan_build, tmp_path):
    for file in plan_build.iterdir():
        if file.is_file() and file.name != "s01.htt.h5":
            (tmp_path / file.name).write_bytes(file.read_bytes())
    done = CliRunner().invoke(main, ["view", str(tmp_path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "lists s01.htt.h5, which is not there" in done.output


def test_a_material_that_a_band_lacks_is_refused(plan_build, tmp_path, monkeypatch):
    monkeypatch.setattr(BandTable, "materials", {"asphalt_road": 1})
    with open_tmm(plan_build / "halves.tmm.h5") as file:
        lacking = next(name for code, name in file.materials.items() if code != 1)
    done = CliRunner().invoke(main, ["view", str(plan_build), "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert f"b01.band.h5: lacks '{lacking}' of the texture halves.tmm.h5" in done.output


def test_an_altitude_outside_the_table_and_an_unknown_texture_are_refused(plan_build, tmp_path):
    def message(*options):
        done = CliRunner().invoke(main, ["view", str(plan_build), "--out", str(tmp_path), *options])
        assert done.exit_code == 2
        return done.output

    assert "allowed: 0.01 to 1 km" in message("--altitude", "7")
    assert "found the texture 'roof'; allowed: halves" in message("--texture", "roof")
