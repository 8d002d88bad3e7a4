"""Pipes, devices and full disks in place of every file that `mat` reads or writes: one clear line at once."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main

posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
pytestmark = posix
SECONDS = 60
DATABASE_COMMANDS = ("info", "query", "verify", "export")


@pytest.fixture
def at_once():
    """A hang becomes a failure."""

    def late(*_):
        raise TimeoutError("the command waits for a file that never ends")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(params=["pipe", "device"])
def special(request):
    """Makes a pipe, or a link to a device without end, of a path."""

    def make(path: Path) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        os.mkfifo(path) if request.param == "pipe" else path.symlink_to("/dev/zero")
        return path

    return make


def run(*arguments):
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == 2 and result.output.count("\n") == 1, result.output
    return result.output


@pytest.mark.parametrize("command", DATABASE_COMMANDS)
@pytest.mark.parametrize("name", ["s01.htt.h5", "s01.htt.raw.json"])
def test_a_database_that_is_a_pipe_or_a_device(command, name, special, at_once, tmp_path):
    if command in ("verify", "export") and name.endswith(".json"):
        pytest.skip("reads HDF5 alone")
    rest = {
        "query": ["temperature", "time=1"],
        "export": ["--to", "raw", "--out", tmp_path / "out"],
    }
    shown = run(command, special(tmp_path / name), *rest.get(command, []))
    assert "pipe, socket or device" in shown


def test_the_data_of_a_flat_export_that_are_a_pipe_or_a_device(special, at_once, small_build, tmp_path):
    CliRunner().invoke(main, ["export", str(small_build / "s01.htt.h5"), "--to", "raw", "--out", str(tmp_path)])
    (tmp_path / "s01.htt.raw.bin").unlink()
    special(tmp_path / "s01.htt.raw.bin")
    assert "pipe, socket or device" in run("query", tmp_path / "s01.htt.raw.json", "temperature", "time=1")


@pytest.mark.parametrize("command", ["check", "build", "report"])
def test_a_job_that_is_a_pipe_or_a_device(command, special, at_once, tmp_path):
    assert "pipe, socket or device" in run(command, special(tmp_path / "job.yaml"))


@pytest.mark.parametrize("key", ["sounding", "response", "weather.csv", "weather.epw", "series"])
def test_a_file_of_a_job_that_is_a_pipe_or_a_device(key, special, at_once, small_job, tmp_path, monkeypatch):
    monkeypatch.setenv("SKYSHINE_ALLOW_OUTSIDE", "1")  # a link to a device leads out of the folder
    text = small_job.read_text(encoding="utf-8")
    state = re.search(r"profile: \w+", text)[0]
    band = re.search(r"wavelength_um: \[[^]]*\]", text)[0]
    weather = re.search(r"weather: \{[^}]*\}", text)[0]
    name = "special.epw" if key == "weather.epw" else "special.csv"
    changed = {
        "sounding": text.replace(state, f"{state}\n    sounding: {name}"),
        "response": text.replace(band, f"response: {name}"),
        "weather.csv": text.replace(weather, f"weather: {{file: {name}}}"),
        "weather.epw": text.replace(weather, f"weather: {{file: {name}}}"),
        "series": text.replace(weather, f"{weather}\n    series: {{table: {name}}}"),
    }[key]
    assert changed != text
    (tmp_path / "job.yaml").write_text(changed, encoding="utf-8")
    special(tmp_path / name)
    shown = run("check", tmp_path / "job.yaml")
    assert "pipe, socket or device" in shown or "is no file" in shown


def test_a_record_or_job_of_a_surface_that_is_a_pipe_or_a_device(special, at_once, tmp_path):
    record = special(tmp_path / "special")
    assert "pipe, socket or device" in run("temperature", "--material", "asphalt_road", "--forcing", record)
    assert "pipe, socket or device" in run("temperature", "--material", "asphalt_road", "--job", record)


def test_a_material_of_a_file_that_is_a_pipe_or_a_device(special, at_once, small_job, tmp_path):
    material = special(tmp_path / "wall.yaml")
    run(
        "temperature",
        "--material",
        material,
        "--job",
        "x.yaml",
        "--absorptance",
        0.5,
        "--emissivity",
        0.9,
    )


@pytest.mark.parametrize(
    "command",
    [
        "--help",
        "info s01.htt.h5",
        "query s01.htt.h5 temperature material=asphalt_road time=1 altitude=0 azimuth=0 slope=0",
        "export s01.htt.h5 --to raw --out exported",
        *(
            pytest.param(command, marks=pytest.mark.validation)  # a process each, which ends in the same function
            for command in (
                "",
                "--version",
                "lines",
                "lines info",
                "bench --help",
                "materials",
                "info --preset",
                "info s01.htt.h5 --json",
                "verify s01.htt.h5",
                "materials specular --fwhm 5",
                "check job.yaml",
            )
        ),
    ],
)
def test_a_full_disk_behind_standard_output_is_one_line(command, small_build, small_job, tmp_path):
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    shutil.copyfile(small_build / "s01.htt.h5", tmp_path / "s01.htt.h5")
    shutil.copyfile(small_job, tmp_path / "job.yaml")
    code = "import sys; from skyshine.mat.cli import main; main(prog_name='mat')"
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [sys.executable, "-c", code, *command.split()],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            timeout=120,
        )
    assert result.returncode == 2 and result.stderr.count("\n") == 1, result.stderr
    assert "cannot be written" in result.stderr
