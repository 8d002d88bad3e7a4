"""The wheel holds all that the commands need, and takes no bare top-level name."""

import os
import re
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import h5py
import pytest

from skyshine.mat.kernel.library import NAME

CHECKOUT = Path(__file__).parents[2]

OPEN_ONE_OF_EACH = """
import skyshine.mat, skyshine.tmm
from skyshine import atmospheres, materials, schemas
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.cloud import cloud_type
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.job.presets import presets
from skyshine.mat.kernel.library import library
from skyshine.mat.api.examples import example_names, starter_files
from skyshine.materials.library import load_library
for module in (skyshine.mat, skyshine.tmm, atmospheres, materials, schemas):
    assert module.__file__.startswith(PLACE), module.__file__
assert len(AbsorptionTable.open().gases) >= 3
assert load_profile("tropical").temperature[0] > 299
AerosolModel.load("rural")
assert cloud_type("stratus").model and "rain" in presets()
assert len(load_library()) >= 12
assert schemas.path("mat-job.schema.json").is_file()
assert all(file.is_file() for name in example_names() for file in starter_files(name))
assert materials.path("exchange/cdb.yaml").is_file()
assert library()._name.startswith(PLACE) and len(library().skyshine_sources()) == 64
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel that `SKYSHINE_WHEEL` names, just built of this checkout; or one of now."""
    if given := os.environ.get("SKYSHINE_WHEEL"):
        return Path(given)
    folder = tmp_path_factory.mktemp("wheel")
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "--disable-pip-version-check",
        "-w",
        folder,
        CHECKOUT,
    ]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return next(folder.glob("skyshine-*.whl"))


def test_only_the_skyshine_package_is_installed(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"skyshine"}
    assert not [name for name in names if "/tests/" in name or name.endswith(".pyc")]


def test_the_wheel_has_the_compiled_library_and_no_c(wheel):
    assert wheel.name.split("-")[2:4] == ["py3", "none"] and not wheel.name.endswith("-any.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert [name for name in names if "libskyshine" in name] == [f"skyshine/mat/kernel/{NAME}"]
    assert not [
        name for name in names if name.startswith("skyshine/mat/kernel/") and name.endswith((".c", ".h", "d.py"))
    ]


def test_the_wheel_has_neither_pages_nor_pictures(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    pages = [name for name in names if name.endswith((".md", ".png", ".ipynb")) and "/dist-info/" not in name]
    copied_by_init = re.compile(r"skyshine/(examples/[a-z_]+/README\.md|examples/textures/.*|atmospheres/[a-z_]+/.*)")
    assert not [name for name in pages if not copied_by_init.fullmatch(name)]


def test_the_metadata_says_where_the_runtimes_are(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
        description = " ".join(archive.read(name).decode().split("\n\n", 1)[1].split())
    assert "`examples/runtimes` of the checkout and of the source distribution" in description


def test_the_metadata_names_the_terms_of_mt_ckd_and_the_wheel_holds_its_notice(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
        metadata = archive.read(name).decode().split("\n\n")[0].splitlines()
        (name,) = [name for name in archive.namelist() if name.endswith("licenses/LICENSES/LicenseRef-MT-CKD.txt")]
        notice = " ".join(archive.read(name).decode().split())
    assert "License-Expression: Apache-2.0 AND LicenseRef-MT-CKD" in metadata
    with h5py.File(CHECKOUT / "atmospheres" / "absorption.h5") as table:
        assert notice == " ".join(table.attrs["notice"].split())
    assert "may not be incorporated" in notice


def test_a_fresh_environment_opens_one_of_each_data_file(wheel, tmp_path):
    venv.create(tmp_path / "fresh", with_pip=False)
    python = tmp_path / "fresh" / "bin" / "python"
    site = Path(sysconfig.get_path("purelib", vars={"base": tmp_path / "fresh", "platbase": tmp_path / "fresh"}))
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "MATERIALS_DATABASE")}
    install = [sys.executable, "-m", "pip", "--python", str(python), "install", "-q", "--no-deps", str(wheel)]
    subprocess.run(install, check=True, capture_output=True, env=environment)
    # Dependencies come from the running environment; the package itself, first on the path, from the wheel.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    code = OPEN_ONE_OF_EACH.replace("PLACE", repr(str(site)))
    done = subprocess.run([python, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for command in ("mat", "tmm"):
        shown = subprocess.run(
            [site.parents[2] / "bin" / command, "--help"], capture_output=True, text=True, env=environment
        )
        assert shown.returncode == 0 and "Example" in shown.stdout, shown.stderr
