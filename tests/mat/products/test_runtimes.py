"""The example runtimes in four languages against the library: the same pixels, every term of equation (1).

Those that must fetch packages first (Rust, JavaScript) belong to the validation suite.
"""

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.radiometry.lobe import specular_lobe
from skyshine.mat.tables.axes import table_axis
from skyshine.schemas.hdf5 import Header, read_file, write_file

RUNTIMES = Path(__file__).parents[3] / "examples" / "runtimes"
FILES = {"surface": "s01.htt.h5", "band": "b01.band.h5", "atmosphere": "s01b01.atmq.h5"}
CAMERA = {"bits": 12, "gain": 60.0, "buffer_gain": 1.02, "offset": 0.05}
PIXELS = 200
DOWNLOADS = pytest.mark.validation
LANGUAGES = ["python", "c", pytest.param("javascript", marks=DOWNLOADS), pytest.param("rust", marks=DOWNLOADS)]


def prepared(language, folder):
    """The command of a runtime, built in a folder of its own."""

    def run(*command):
        done = subprocess.run(command, cwd=folder / language, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]

    needed = {"c": ["cc", "make", "pkg-config"], "javascript": ["node", "npm"], "rust": ["cargo"]}.get(language, [])
    missing = [tool for tool in needed if shutil.which(tool) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed")
    if language in ("c", "rust") and subprocess.run(["pkg-config", "--exists", "hdf5"], check=False).returncode != 0:
        pytest.skip("the headers of the HDF5 library are not installed")
    shutil.copytree(RUNTIMES / language, folder / language)
    if language == "c":
        run("make")
        return [folder / "c" / "runtime"]
    if language == "javascript":
        run("npm", "install", "--no-package-lock", "--no-audit", "--no-fund")
        return ["node", folder / "javascript" / "runtime.js"]
    if language == "rust":
        run("cargo", "build", "--release", "--target-dir", str(folder / "target"))
        return [folder / "target" / "release" / "runtime"]
    return [sys.executable, folder / "python" / "runtime.py"]


@pytest.fixture(scope="module", params=LANGUAGES)
def runtime(request, tmp_path_factory):
    """Run the runtime of a language on a scene: exit status, standard output, standard error."""
    folder = tmp_path_factory.mktemp(request.param)
    command = prepared(request.param, folder)

    def run(scene):
        (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
        done = subprocess.run([*command, folder / "scene.json"], capture_output=True, text=True, timeout=120)
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.fixture(scope="module")
def scene(small_build):
    """Pixels all over the axes, round the periodic ones more than once, at nodes too, lit from behind too."""
    draw = np.random.default_rng(7)
    limits = {
        "surface_altitude": (0, 1),
        "surface_azimuth": (-400, 800),
        "surface_slope": (0, 45),
        "time": (-30, 60),
        "range": (0.001, 20),
        "centre_range": (0.001, 20),
        "altitude": (0.01, 1),
        "centre_elevation": (-90, 90),
        "source_elevation": (-20, 60),
        "source_azimuth": (-500, 500),
    }
    pixels = []
    for number in range(PIXELS):
        pixel = {name: float(draw.uniform(*limit)) for name, limit in limits.items()}
        if number % 10 == 0:
            pixel |= {
                "time": 24.0,
                "surface_azimuth": 360.0,
                "altitude": 1.0,
                "centre_elevation": 90.0,
                "source_azimuth": 180.0,
            }
        pixel |= {name: draw.normal(size=3).tolist() for name in ("normal", "to_source", "to_observer")}
        pixels.append(pixel | {"material": ["asphalt_road", "grass_green"][number % 2]})
    return {name: str(small_build / file) for name, file in FILES.items()} | CAMERA | {"pixels": pixels}


def by_library(scene):
    """The same terms with the library, all pixels at once."""
    surface, band, air = (skyshine.mat.open(scene[name]) for name in FILES)
    pixels = scene["pixels"]
    of = {name: np.array([pixel[name] for pixel in pixels]) for name in pixels[0]}
    face = {name: of[f"surface_{name}"] for name in ("altitude", "azimuth", "slope")}
    temperature = surface.temperature(material=of["material"], time=of["time"], **face)
    rho, fraction, shininess, normalisation = (
        band.value(name, material=of["material"])
        for name in ("reflectance", "specular_fraction", "shininess", "normalisation")
    )
    view = {"range": of["centre_range"], "altitude": of["altitude"], "elevation": of["centre_elevation"]}
    sun = {"source_elevation": of["source_elevation"]}
    tau = air.transmittance(range=of["range"], beta_star=air.value("beta_star", **view))
    normal, source, observer = (
        of[name] / np.linalg.norm(of[name], axis=1, keepdims=True) for name in ("normal", "to_source", "to_observer")
    )
    cosine = np.maximum(np.sum(normal * source, axis=1), 0.0)
    direct = np.where(cosine > 0, air.value("direct_radiance", **view, **sun) * rho * tau, 0.0)
    blackbody = band.blackbody_radiance(temperature)
    result = {
        "temperature": temperature,
        "blackbody_radiance": blackbody,
        "transmittance": tau,
        "thermal": blackbody * (1 - rho) * tau,
        "path": air.value("path_radiance_ratio", **view, **sun, source_azimuth=of["source_azimuth"]) * (1 - tau),
        "skyshine": air.value("ambient_radiance", **view, **sun) * rho * tau,
        "diffuse": direct * cosine * (1 - fraction),
        "specular": direct * specular_lobe(shininess, source, observer, normal) * fraction * normalisation,
    }
    result["radiance"] = sum(result[name] for name in ("thermal", "path", "skyshine", "diffuse", "specular"))
    share = np.clip(result["radiance"] / CAMERA["gain"], 0, 1)
    result["pixel_value"] = np.clip(
        np.trunc(2 ** CAMERA["bits"] * CAMERA["buffer_gain"] * (share - CAMERA["offset"]) - 0.5),
        0,
        2 ** CAMERA["bits"] - 1,
    )
    return result


def test_every_term_agrees_with_the_library(runtime, scene):
    status, shown, complaint = runtime(scene)
    assert status == 0, complaint
    pixels, expected = json.loads(shown)["pixels"], by_library(scene)
    assert len(pixels) == PIXELS and np.count_nonzero(expected["diffuse"]) > PIXELS / 4
    for name, values in expected.items():
        np.testing.assert_allclose([pixel[name] for pixel in pixels], values, rtol=1e-6, atol=1e-12, err_msg=name)


def test_optional_arrays_of_a_newer_minor_version_are_passed_over(runtime, scene, extra_build):
    status, shown, complaint = runtime(scene)
    newer = runtime(scene | {"band": str(extra_build / FILES["band"])})
    assert newer == (status, shown, complaint) and status == 0


def test_tables_on_axes_of_their_own_are_read_alike(runtime, scene, own_axes):
    """By scattering angle too, and with a name of its own for every axis."""
    scene = scene | {"atmosphere": str(own_axes[0])}
    status, shown, complaint = runtime(scene)
    assert status == 0, complaint
    expected = by_library(scene)
    for name in ("transmittance", "path", "skyshine", "diffuse", "radiance"):
        np.testing.assert_allclose(
            [pixel[name] for pixel in json.loads(shown)["pixels"]], expected[name], rtol=1e-6, atol=1e-12, err_msg=name
        )


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
    write_file(part, replace(root, axes=axes, variables=variables), Header("htt", "1.1.0", "data", "job"))
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
        (newer, "2.0.0; allowed: htt 1.x"),
        (scene["band"], "holds 'band'"),
        (damaged, "not a readable HDF5 file"),
    ):
        status, shown, complaint = runtime(scene | {"surface": str(wrong)})
        assert status == 1 and words in complaint and len(complaint.strip().splitlines()) == 1 and not shown.strip()
