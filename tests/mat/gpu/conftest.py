"""A small build with a texture, and a browser without a screen."""

import base64
import json
import re
import shutil
import subprocess
import urllib.parse

import numpy as np
import OpenImageIO as oiio
import pytest

PLAN = """\
skyshine: 1
name: plan
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    visibility_km: 23
    weather: {air_temperature_c: [22, 33], relative_humidity_percent: 60, wind_speed_m_s: 2}
bands:
  - wavelength_um: [3.9, 4.0]
sources: [sun, moon]
materials: [asphalt_road, grass_green]
atmosphere_grid:
  tolerance: 2 K
  range_km: [0, 20]
  altitude_km: [0.01, 1]
  source_elevation_deg: [-8, 90]
surface_grid:
  altitude_km: [0, 1]
  azimuth_deg: [0, 90, 180, 270]
  slope_deg: [0, 45]
  time: [00:00, 03:00, 06:00, 09:00, 12:00, 15:00, 18:00, 21:00]
output: {folder: built, pictures: false}
textures:
  - name: halves
    image: halves.png
    seeds:
      polygons:
        grass_green: [[[2, 2], [12, 2], [12, 15], [2, 15]]]
        asphalt_road: [[[25, 3], [38, 3], [38, 12], [25, 12]]]
"""
# Hosts that a Chromium asks for updates and dictionaries of its own, whatever page it shows.
OWN_HOSTS = {
    "accounts.google.com",
    "clients2.google.com",
    "optimizationguide-pa.googleapis.com",
    "redirector.gvt1.com",
    "update.googleapis.com",
}
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "chrome")


@pytest.fixture(scope="session")
def plan_build(build_once):
    """Folder of databases of one band with Sun, Moon and a texture."""
    return build_once("plan", PLAN, write_halves)


def write_halves(folder):
    """The image of the texture: grass on the left, asphalt on the right."""
    random = np.random.default_rng(1)
    colours = np.empty((20, 40, 3))
    colours[:, :20], colours[:, 20:] = (60, 140, 50), (120, 120, 125)
    values = np.clip(colours + random.normal(0, 6, colours.shape), 0, 255).astype(np.uint8)
    output = oiio.ImageOutput.create(str(folder / "halves.png"))
    assert output.open(str(folder / "halves.png"), oiio.ImageSpec(40, 20, 3, "uint8"))
    assert output.write_image(np.ascontiguousarray(values))
    output.close()


class Browser:
    """Chromium without a screen, drawing in software."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def probe(self, page, **wanted):
        """What the page wrote on `#probe`: its numbers, and pixels (n, 4); then messages, then addresses asked for."""
        log = self.folder / "net.json"
        address = f"{page.resolve().as_uri()}#probe={urllib.parse.quote(json.dumps(wanted))}"
        options = (
            "--headless",
            "--disable-background-networking",
            "--disable-component-update",
            "--no-first-run",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--enable-logging=stderr",
            f"--log-net-log={log}",
            f"--user-data-dir={self.folder / 'profile'}",
            "--dump-dom",
        )
        done = subprocess.run([self.program, *options, address], capture_output=True, text=True, timeout=300)
        found = re.search(r'<pre id="probe"[^>]*>(.*?)</pre>', done.stdout, re.S)
        assert found, done.stderr[-2000:]
        result = json.loads(found.group(1))
        words = base64.b64decode(result.pop("pixels"))
        messages = [line for line in done.stderr.splitlines() if ":CONSOLE" in line and "GL Driver Message" not in line]
        addresses = re.findall(r'"url":"(https?://[^"]*|wss?://[^"]*)"', log.read_text(errors="replace"))
        requests = {each for each in addresses if urllib.parse.urlsplit(each).hostname not in OWN_HOSTS}
        return result, np.frombuffer(words, np.float32).reshape(-1, 4).astype(float), messages, requests


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A browser; the test is skipped where none is installed."""
    program = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if program is None:
        pytest.skip(f"no Chromium is installed: looked for {', '.join(BROWSERS)}")
    return Browser(program, tmp_path_factory.mktemp("browser"))
