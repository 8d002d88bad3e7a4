"""The C library as a package: its version, the formats that it knows, and what it holds."""

import re
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest

from skyshine.mat.tables.files import FORMATS
from skyshine.tmm.database.layout import FILETYPE, FORMAT_VERSION

CHECKOUT = Path(__file__).parents[2]
LIBRARY = CHECKOUT / "examples" / "runtimes" / "c"
PROJECT = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
CALLS = (
    "open",
    "materials",
    "temperature",
    "shaded_temperature",
    "transmittance",
    "path_radiance",
    "ambient_radiance",
    "direct_radiance",
    "pixel_radiance",
    "apparent_temperature",
)


def text(name: str) -> str:
    return (LIBRARY / name).read_text(encoding="utf-8")


def run(*command: object, folder: Path) -> str:
    done = subprocess.run([str(part) for part in command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    return done.stdout


def test_the_library_has_the_version_of_the_project():
    header = re.search(r'#define SKYSHINE_VERSION "(.*)"', text("skyshine.h"))[1]
    cmake = re.search(r"project\(skyshine VERSION (\S+)", text("CMakeLists.txt"))[1]
    assert header == cmake == PROJECT["version"]


def test_the_library_knows_the_formats_that_are_written():
    versions = {FILETYPE: FORMAT_VERSION} | {name: FORMATS[name].format_version for name in ("htt", "band", "atmq")}
    header = re.search(r'#define SKYSHINE_FORMATS "(.*)"', text("skyshine.h"))[1]
    known = dict(each.split() for each in header.split(", "))
    assert known == {name: version.rpartition(".")[0] for name, version in versions.items()}


def test_the_header_declares_the_ten_calls_and_the_page_names_them():
    for call in CALLS:
        assert re.search(rf"SKYSHINE_API \w+ skyshine_{call}\(", text("skyshine.h")), call
        assert f"`skyshine_{call}`" in text("README.md"), call


@pytest.fixture(scope="module")
def source_archive(tmp_path_factory):
    """Names in the source distribution, below its folder."""
    folder = tmp_path_factory.mktemp("sdist")
    run(sys.executable, "-m", "build", "--sdist", "--outdir", folder, CHECKOUT, folder=folder)
    (archive,) = folder.glob("skyshine-*.tar.gz")
    with tarfile.open(archive) as content:
        return {name.partition("/")[2] for name in content.getnames()}


def test_the_source_distribution_holds_the_library(source_archive):
    listed = run("git", "ls-files", "examples/runtimes", folder=CHECKOUT).split()
    assert len(listed) > 25 and set(listed) <= source_archive


def test_the_source_distribution_holds_the_kernel_and_its_compiler_alone(source_archive):
    assert set(run("git", "ls-files", "mat/kernel", folder=CHECKOUT).split()) <= source_archive
    assert not [name for name in source_archive if "libskyshine." in name]
