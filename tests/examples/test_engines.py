"""The examples for three.js and Godot draw what the library computes."""

import functools
import http.server
import json
import shutil
import subprocess
import threading
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import skyshine.mat
from skyshine.mat.api.examples import starter_files
from skyshine.mat.gpu.export import Frame
from skyshine.mat.gpu.stated_error import apparent_temperature
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance

RUNTIMES = Path(__file__).parents[2] / "examples" / "runtimes"
LARGEST_K = 0.05  # half-float textures, and a pixel's middle beside the place that is asked for
PLACES = {"asphalt_road": (0.0, 0.0, 0.3), "grass_green": (60.0, 60.0, 0.0), "wood_pine_weathered": (-40.0, 10.0, 12.0)}
BLACK_K, WHITE_K = 293.0, 317.0  # LEVELS of main.gd
STEP_K = 1.5 * (WHITE_K - BLACK_K) / 255  # of a shade on the screen, and half a step for rounding
READ = """
import puppeteer from "puppeteer-core";
const [, , address, program, script, picture] = process.argv;
const options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const browser = await puppeteer.launch({ executablePath: program, args: options });
const page = await browser.newPage();
await page.setViewport({ width: 960, height: 540 });
await page.goto(address);
console.log(JSON.stringify(await page.evaluate(script)));
if (picture) await page.screenshot({ path: picture });
await browser.close();
"""
PROBE = """(async () => {
  while (!window.probe) await new Promise((done) => setTimeout(done, 100));
  return PLACES.map((place) => probe(...place));
})()"""
STARTED = "window.started.then(() => new Promise((done) => setTimeout(() => done(true), 20000)))"


def in_browser(engine, demo, folder, script, *picture):
    """What a script finds on the page of an engine's example, with the databases of a build."""
    program = next((path for name in ("chromium", "google-chrome") if (path := shutil.which(name))), None)
    if program is None or shutil.which("npm") is None:
        pytest.skip("needs npm and Chromium")
    shutil.copytree(RUNTIMES / engine, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("node_modules"))
    skyshine.mat.export(demo, "gpu", folder / "gpu", frame=Frame(14.0, 2.6))
    done = subprocess.run(["npm", "install", "puppeteer-core"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"npm cannot install {engine}: {done.stderr.strip().splitlines()[-1]}")
    if engine == "godot":
        subprocess.run(["npm", "run", "pack"], cwd=folder, check=True, capture_output=True)
    (folder / "read.mjs").write_text(READ)
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=folder)
    with http.server.ThreadingHTTPServer(("localhost", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        command = ["node", "read.mjs", f"http://localhost:{server.server_port}/index.html", program, script, *picture]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
        server.shutdown()
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """Databases of the starter job."""
    folder = tmp_path_factory.mktemp("demo")
    for file in starter_files("starter"):
        shutil.copyfile(file, folder / file.name)
    skyshine.mat.build(folder / "job.yaml", pictures=False)
    return folder / "built"


@pytest.fixture(scope="module")
def drawn(demo, tmp_path_factory):
    """Values of the places, from the page of three.js."""
    script = PROBE.replace("PLACES", json.dumps(list(PLACES.values())))
    values = in_browser("three", demo, tmp_path_factory.mktemp("three"), script)
    return dict(zip(PLACES, values, strict=True))


@pytest.mark.validation  # 90 s, and it asks npm
@pytest.mark.parametrize("material", PLACES)
def test_pixels_of_three_are_those_of_the_library(drawn, demo, material):
    surface, band, air = (skyshine.mat.open(demo / f"{name}.h5") for name in ("s01.htt", "b02.band", "s01b02.atmq"))
    place = np.array(PLACES[material])
    way = np.array(drawn[material]["camera"]) - place
    reach = np.linalg.norm(way)
    to_observer = way[None] / reach
    track = surface.source_track("sun", time=14.0)
    up, along = np.radians(float(track.elevation)), np.radians(float(track.azimuth))
    to_source = np.array([[np.cos(up) * np.sin(along), np.cos(up) * np.cos(along), np.sin(up)]])
    ground = float(np.asarray(surface.root.axes["altitude"].values)[0])
    code = np.array([[surface.materials[material], 0, 0]])
    none = np.zeros(1)
    faces = Faces(code, np.array([[1.0, 0.0, 0.0]]), none + ground + place[2] / 1e3, none, none, none + 14.0)
    heading = np.degrees(np.arctan2(-to_observer[:, 0], -to_observer[:, 1]))
    elevation = -np.degrees(np.arcsin(to_observer[:, 2]))
    sun, azimuth = none + float(track.elevation), none + float(track.azimuth)
    lines = LinesOfSight(none + reach / 1e3, none + 2.6, elevation, sun, azimuth - heading)
    view = View(lines, none + reach / 1e3, np.array([[0.0, 0.0, 1.0]]), to_source, to_observer, azimuth)
    library = pixel_radiance(surface, band, air, faces, view)
    radiance, apparent, kelvin, inside = drawn[material]["values"]
    assert inside == 1 and kelvin == pytest.approx(library.temperature[0], abs=0.02)
    assert apparent == pytest.approx(float(apparent_temperature(band, library.radiance)[0]), abs=LARGEST_K)
    assert radiance == pytest.approx(float(library.radiance[0]), rel=2e-3)


@pytest.mark.validation  # 60 s, and it asks npm
def test_the_screen_of_godot_shows_the_apparent_temperatures_of_three(drawn, demo, tmp_path):
    in_browser("godot", demo, tmp_path / "godot", STARTED, "godot.png")
    shades = oiio.ImageBuf(str(tmp_path / "godot" / "godot.png")).get_pixels(oiio.FLOAT)[..., 0]
    for pixel in drawn.values():
        kelvin = BLACK_K + (WHITE_K - BLACK_K) * shades[pixel["row"], pixel["column"]]
        assert kelvin == pytest.approx(pixel["values"][1], abs=STEP_K)
