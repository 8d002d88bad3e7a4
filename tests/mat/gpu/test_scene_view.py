"""A page of a scene shows what the library computes for the faces that the camera's rays meet."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.cli import main
from skyshine.mat.gpu.stated_error import apparent_temperature
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.render.camera import view_rays
from skyshine.mat.render.rays import ray_caster
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.render.surface import SurfaceMaterials, surface_of_scene
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance

sys.path.insert(0, str(Path(__file__).parents[2] / "fuzz"))
from good_databases import with_shade

LARGEST_K = 0.05
LARGEST_SHADED_K = 0.08  # of tilted faces, whose temperatures in the shade are read between nodes
CAMERAS = {
    "perspective": {"position_m": [30.0, -60.0, 80.0], "look_at_m": [0.0, 5.0, 2.0], "field_of_view_deg": 30.0},
    "plan_view": {"height_m": 300.0, "width_m": 30.0, "top_azimuth_deg": 30.0},
}


@pytest.fixture(
    scope="module",
    params=["perspective", pytest.param("plan_view", marks=pytest.mark.validation)],  # 9 s a page
)
def scene(request, plan_build, write_height_map):
    """A scene of the texture over a sloping ground, seen by a kind of camera."""
    content = {
        "skyshine_scene": 1,
        "name": "hill",
        "databases": "built",
        "surface": {
            "altitude_km": 0.05,
            "plan": {
                "texture": "built/halves.tmm.h5",
                "metres_per_texel": 1.0,
                "height_map": {"image": write_height_map(plan_build.parent), "metres_per_value": 0.1},
            },
            "unknown_material": "asphalt_road",
        },
        "camera": {request.param: CAMERAS[request.param] | {"size": [36, 24]}},
        "hours": [15],
    }
    path = plan_build.parent / f"{request.param}.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def write_height_map():
    """Writes a slope to the south as a picture of heights and returns its name."""

    def write(folder):
        import tifffile

        heights = np.broadcast_to(np.arange(20, 0, -1)[:, None] * 6, (20, 40)).astype(np.uint16)
        tifffile.imwrite(folder / "heights.tif", heights)
        return "heights.tif"

    return write


def expected(path, hour):
    """Pixels inside the surface, their band, what the library computes for them, and their slopes."""
    scene = load_scene(path)
    surface = surface_of_scene(scene)
    rays = view_rays(scene, surface, 0)
    hits = ray_caster(surface).first(rays.origin, rays.direction)
    columns, rows = rays.size
    face = hits.face.reshape(rows, columns)
    inner = np.zeros_like(face, bool)
    near = [face[1 + down : rows - 1 + down, 1 + across : columns - 1 + across] for down, across in NEAR]
    inner[1:-1, 1:-1] = np.all(np.array(near) >= 0, axis=0)  # of one slope, and not on the edge of the surface
    pick = np.flatnonzero(inner.ravel())
    built = scene.databases
    table, band, air = (skyshine.mat.open(built / f"{n}.h5") for n in ("s01.htt", "b01.band", "s01b01.atmq"))
    with SurfaceMaterials(scene, surface) as materials:
        mixtures = materials.at(hits.face[pick], hits.weights[pick], np.zeros(pick.size))
        codes = np.array([table.materials[name] for name in mixtures.names] * 2)[mixtures.number[:, :3]]
        shade = mixtures.share[:, 3:].sum(axis=1)
        shares = mixtures.share[:, :3] + (mixtures.share[:, 3:] if shade.any() else 0.0)
    normal = surface.normal[hits.face[pick]]
    to_observer = -rays.direction[pick]
    normal = np.where(np.sum(normal * to_observer, axis=-1, keepdims=True) < 0, -normal, normal)
    slope = np.degrees(np.arccos(np.clip(normal[:, 2], -1, 1)))
    azimuth = np.mod(np.degrees(np.arctan2(normal[:, 0], normal[:, 1])), 360.0)
    height = rays.origin[pick, 2] + rays.direction[pick, 2] * hits.distance[pick]
    track = table.source_track("sun", time=hour)
    up, along = np.radians(float(track.elevation)), np.radians(float(track.azimuth))
    to_source = np.array([np.cos(up) * np.sin(along), np.cos(up) * np.cos(along), np.sin(up)])
    full, reach = np.ones(pick.size), hits.distance[pick] / 1e3
    dark = {"shade": shade, "shaded_sky": scene.model.surface.shaded_sky * full}
    faces = Faces(codes, shares, surface.altitude + height / 1e3, azimuth, slope, hour * full, **dark)
    lines = LinesOfSight(
        reach,
        rays.altitude[pick],
        rays.elevation[pick],
        float(track.elevation) * full,
        float(track.azimuth) - rays.azimuth[pick],
    )
    view = View(
        lines,
        reach,
        normal,
        np.tile(to_source, (pick.size, 1)),
        to_observer,
        float(track.azimuth) * full,
    )
    return pick, band, pixel_radiance(table, band, air, faces, view), slope


NEAR = [(down, across) for down in (-1, 0, 1) for across in (-1, 0, 1)]


@pytest.fixture(scope="module")
def shaded_scene(scene):
    """The scene over its texture with a layer of shade."""
    content = yaml.safe_load(scene.read_text())
    texture = scene.parent / f"shaded_{scene.stem}.tmm.h5"
    shutil.copyfile(scene.parent / "built" / "halves.tmm.h5", texture)
    with_shade(texture)
    content["surface"]["plan"]["texture"] = texture.name
    path = scene.parent / f"shaded_{scene.name}"
    path.write_text(yaml.safe_dump(content | {"surface": content["surface"] | {"shaded_sky": 0.3}}), encoding="utf-8")
    return path


@pytest.mark.parametrize("scene", ["perspective"], indirect=True)  # a page of a plan: test_viewer.py
@pytest.mark.validation  # 12 s
def test_the_shade_of_a_scene_is_that_of_the_library(browser, shaded_scene, tmp_path):
    done = CliRunner().invoke(main, ["view", str(shaded_scene), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    result, pixels, messages, _ = browser.probe(tmp_path / "index.html", band="s01b01", hour=15.0, source="sun")
    assert (messages, result["message"], result["error"]) == ([], "", 0)
    pick, band, library, _ = expected(shaded_scene, result["hour"])
    assert np.ptp(library.temperature) > 8
    # A pixel on the border of two texels may read either.
    same = np.abs(pixels[pick, 2] - library.temperature) < 0.05
    assert same.mean() > 0.95
    assert np.abs(pixels[pick, 1] - apparent_temperature(band, library.radiance))[same].max() <= LARGEST_SHADED_K


def test_the_faces_of_a_scene_are_those_of_the_library(browser, scene, tmp_path):
    done = CliRunner().invoke(main, ["view", str(scene), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    result, pixels, messages, requests = browser.probe(tmp_path / "index.html", band="s01b01", hour=15.0, source="sun")
    assert (messages, requests, result["message"], result["error"]) == ([], set(), "", 0)
    pick, band, library, slope = expected(scene, result["hour"])
    assert pick.size > 100
    assert np.all(slope > 10)
    kelvin = apparent_temperature(band, library.radiance)
    # A pixel on the border of two texels may read either.
    difference = np.abs(pixels[pick, 1] - kelvin)
    assert np.quantile(difference, 0.97) <= LARGEST_K
    same = np.abs(pixels[pick, 2] - library.temperature) < 0.02
    assert same.mean() > 0.97
    assert difference[same].max() <= LARGEST_K


def test_what_a_scene_states_is_refused_as_an_option(scene, tmp_path):
    done = CliRunner().invoke(main, ["view", str(scene), "--out", str(tmp_path), "--altitude", "1"])
    assert done.exit_code == 2
    assert "--altitude goes with a folder" in done.output


@pytest.mark.parametrize(("altitude", "height", "message"), [(0.9, 300.0, "is at"), (0.995, 4.0, "the surface spans")])
def test_a_scene_where_the_tables_are_not_is_refused_at_its_line(scene, tmp_path, altitude, height, message):
    content = yaml.safe_load(scene.read_text())
    content["surface"]["altitude_km"] = altitude
    content["camera"] = {"plan_view": {"height_m": height, "size": [4, 4]}}
    path = scene.parent / "moved.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    done = CliRunner().invoke(main, ["view", str(path), "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert "moved.yaml:" in done.output
    assert message in done.output
    assert len(done.output.strip().splitlines()) == 1
