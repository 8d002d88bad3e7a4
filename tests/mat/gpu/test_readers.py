"""The reader in C of an export for graphics processors agrees with the package's own."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from gpu_files import read_gpu

import skyshine.mat
from skyshine.mat.gpu.evaluation import GpuAir
from skyshine.mat.gpu.export import Frame, export_gpu
from skyshine.mat.gpu.stated_error import apparent_temperature, random_pixels

SOURCE = Path(__file__).parents[3] / "examples" / "runtimes" / "c" / "gpu.c"
COUNT = 200


@pytest.fixture(scope="module")
def reader(tmp_path_factory):
    """The program of the reader."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler is installed")
    program = tmp_path_factory.mktemp("gpu") / "gpu"
    options = [
        "-std=c11",
        "-O1",
        "-g",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-fsanitize=undefined",
        "-fno-sanitize-recover=all",
    ]
    subprocess.run([compiler, *options, "-o", program, SOURCE, "-lm"], check=True)
    return program


@pytest.fixture(scope="module")
def frame(plan_build, tmp_path_factory):
    """An exported frame, its band, and random pixels of it."""
    folder = tmp_path_factory.mktemp("frame")
    export_gpu([plan_build], folder, Frame(9.0, 0.5))
    content = read_gpu(folder / "s01b01.atmq.gpu.json")
    elevation = content.numbers["source_elevation"]["path"][0]
    pixels = random_pixels(content, COUNT, np.random.default_rng(4), elevation)
    return folder, content, skyshine.mat.open(plan_build / "b01.band.h5"), pixels


def read(reader, folder, lines):
    files = [folder / "s01b01.atmq.gpu.json", folder / "b01.band.gpu.json"]
    return subprocess.run([reader, *files], input=lines, capture_output=True, text=True, timeout=60)


def test_pixels_are_those_of_the_package(reader, frame):
    folder, content, band, pixels = frame
    view, faces = pixels.view, pixels.faces
    units = [v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (view.normal, view.to_source, view.to_observer)]
    rows = np.concatenate([faces.codes, faces.temperature, view.range[:, None], *units], axis=1)
    done = read(reader, folder, "\n".join(" ".join(f"{value:.17g}" for value in row) for row in rows))
    assert done.returncode == 0, done.stderr
    found = np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
    elevation = content.numbers["source_elevation"]["path"][0]
    expected = GpuAir.of(content).frame(elevation).radiance(band, faces, view)
    assert found[:, 0] == pytest.approx(expected, rel=1e-6)
    assert found[:, 2] == pytest.approx(apparent_temperature(band, expected), abs=1e-4)


@pytest.mark.parametrize(
    ("pixel", "message"),
    [
        ("9999 300 1 0 0 1 0 0 1 0 0 1", "is not in the export"),
        ("1 2 3", "a pixel must be twelve numbers"),
        ("1 300 -1 0 0 1 0 0 1 0 0 1", "a range must be a finite number from 0"),
        ("1 300 nan 0 0 1 0 0 1 0 0 1", "a range must be a finite number from 0"),
    ],
)
def test_wrong_pixels_are_refused(reader, frame, pixel, message):
    done = read(reader, frame[0], pixel)
    assert done.returncode == 1
    assert message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_a_file_of_another_kind_is_refused(reader, frame):
    band = frame[0] / "b01.band.gpu.json"
    done = subprocess.run([reader, band, band], input="", capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "skyshine-gpu 1.x" in done.stderr
