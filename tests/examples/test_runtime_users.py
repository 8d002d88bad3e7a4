"""Programs of users in C, Rust and TypeScript: the library or a binding installed, compiled, and all calls against the
package. Those that must fetch packages are nightly.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
from runtime_loaders import RUNTIME, RUNTIMES, built, missing_tools, prepared_package

USERS = Path(__file__).parent / "users"
USER = USERS / "c"
TYPES = ("typescript@5.9", "@types/node@20")
COMPILED = ("node_modules/.bin/tsc", "--strict", "--target", "es2022", "--module", "nodenext")
TOLERANCE = 1e-9
LINE = {"range": 1.3, "altitude": 0.6, "elevation": -12.0, "source_elevation": 30.0}


def run(*command: object, folder: Path, environment: dict[str, str] | None = None) -> str:
    done = subprocess.run(
        [str(part) for part in command],
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | (environment or {}),
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def need(language: str = "c") -> None:
    if missing := missing_tools(language):
        pytest.skip(f"{', '.join(missing)} not installed")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Where the C library is installed by CMake."""
    need()
    folder = tmp_path_factory.mktemp("c")
    run("cmake", "-S", RUNTIME, "-B", "build", f"-DCMAKE_INSTALL_PREFIX={folder / 'installed'}", folder=folder)
    run("cmake", "--build", "build", folder=folder)
    run("cmake", "--install", "build", folder=folder)
    return folder / "installed"


@pytest.fixture(scope="module")
def files(small_build, channel_atmosphere, band_file):
    """Surface, band and atmosphere."""
    return [small_build / "s01.htt.h5", band_file, channel_atmosphere]


def expected(files: list[Path]) -> dict[str, float]:
    surface, band, air = (skyshine.mat.open(path) for path in files)
    codes = band.root.axes["material"].values
    face = {"material": int(codes[0]), "altitude": 0.5, "azimuth": 200.0, "slope": 20.0, "time": 14.5}
    heat = surface.absorbed_change(
        **{name: value for name, value in face.items() if name != "time"}, shade=[(10, 14)], sky_view=0.6, facing=310
    )
    sight = {name: value for name, value in LINE.items() if name != "source_elevation"}
    transmittance = air.transmittance(range=1.3, beta_star=air.value("beta_star", **sight))
    kelvin = np.array([[surface.temperature(**face), 301.0]])
    one = np.ones(1)
    faces = Faces(codes[None, :2], np.array([[0.75, 0.25]]), 0.5 * one, 200 * one, 20 * one, 14.5 * one, kelvin)
    pixel = pixel_radiance(
        surface,
        band,
        air,
        faces,
        View(
            LinesOfSight(1.3 * one, 0.6 * one, -12 * one, 30 * one, 70 * one),
            1.2 * one,
            source_heading=150 * one,
            normal=np.array([[0.3, -0.2, 0.9]]),
            to_source=np.array([[0.5, 0.5, 0.6]]),
            to_observer=np.array([[-0.1, -0.9, 0.3]]),
        ),
    ).radiance[0]
    blackbody = band.root.variables["blackbody_radiance"].data
    return {
        "temperature": float(surface.temperature(**face)),
        "shaded_temperature": float(surface.temperature(**face, absorbed_change=heat)),
        "transmittance": float(transmittance),
        "path_radiance": float(air.value("path_radiance_ratio", **LINE, source_azimuth=70.0) * (1 - transmittance)),
        "ambient_radiance": float(air.ambient_radiance(slope=20.0, azimuth=50.0, **LINE)),
        "direct_radiance": float(air.value("direct_radiance", **LINE)),
        "pixel_radiance": float(pixel),
        "apparent_temperature": float(np.interp(pixel, blackbody, band.root.axes["temperature"].values)),
    }


def agrees(shown: str, files: list[Path]) -> None:
    found = json.loads(shown)
    for name, value in expected(files).items():
        np.testing.assert_allclose(found[name], value, rtol=TOLERANCE, err_msg=name)
    band = skyshine.mat.open(files[1])
    names = [str(name) for name in band.root.variables["material_name"].data]
    assert found["materials"] == [[int(c), n] for c, n in zip(band.root.axes["material"].values, names, strict=True)]
    assert found["listed"] > 0 and found["threads_alike"] is True and found["untouched"] is True
    assert found["refused"][0] == 2 and found["refused"][1].startswith("slope: found 400; allowed: 0 to ")
    for status, message in found["ranges"]:
        assert status == 2 and message.startswith("range: found ") and message.endswith("; allowed: 0.001 to 20")
    assert found["missing"][0] == 1 and "/nowhere/catalog.json" in found["missing"][1]


def test_a_user_in_c_finds_the_library_with_cmake(installed, small_build, files, tmp_path):
    run("cmake", "-S", USER, "-B", tmp_path, f"-DCMAKE_PREFIX_PATH={installed}", folder=tmp_path)
    run("cmake", "--build", tmp_path, folder=tmp_path)
    agrees(run(tmp_path / "user", small_build, *files, folder=tmp_path), files)


def test_a_user_in_c_finds_the_library_with_pkg_config(installed, small_build, files, tmp_path):
    (places,) = {path.parent for path in installed.rglob("skyshine.pc")}
    found = {"PKG_CONFIG_PATH": str(places)}
    flags = run("pkg-config", "--cflags", "--libs", "skyshine", folder=tmp_path, environment=found).split()
    assert run("pkg-config", "--modversion", "skyshine", folder=tmp_path, environment=found).strip() == "0.1.0"
    run("cc", "-std=c11", "-o", "user", USER / "user.c", *flags, "-lpthread", "-lm", folder=tmp_path)
    library = {"LD_LIBRARY_PATH": str(places.parent)}
    agrees(run(tmp_path / "user", small_build, *files, folder=tmp_path, environment=library), files)


def test_the_shared_c_library_exports_its_calls_alone(installed):
    """And calls nothing that ends the process or writes to a stream."""
    if shutil.which("nm") is None:
        pytest.skip("nm not installed")
    (library,) = {path.resolve() for path in installed.rglob("libskyshine.so*")}
    symbols = [line.split() for line in run("nm", "-D", library, folder=installed).splitlines()]
    defined = {symbol[-1] for symbol in symbols if symbol[-2] in "TDBRi"}
    assert defined and all(name.startswith("skyshine_") for name in defined), defined
    wanted = {symbol[-1].split("@")[0] for symbol in symbols if symbol[-2] == "U"}
    assert not wanted & {"exit", "abort", "_exit", "printf", "puts", "stderr", "stdout", "perror", "__assert_fail"}


@pytest.mark.validation  # 7 s: compiled anew with sanitizers
def test_the_c_library_gives_back_all_it_takes_and_does_nothing_undefined(small_build, files, tmp_path):
    """With its failures; leaks count, unlike in the program, which ends with what it reads."""
    need()
    sanitized = "-g -O1 -std=c11 -fsanitize=address,undefined -fno-sanitize-recover=all"
    options = (f"-DCMAKE_C_FLAGS={sanitized}", "-DCMAKE_BUILD_TYPE=None", "-DBUILD_SHARED_LIBS=OFF")
    run("cmake", "-S", RUNTIME, "-B", "build", *options, folder=tmp_path)
    run("cmake", "--build", "build", "--target", "skyshine", folder=tmp_path)
    flags = run("pkg-config", "--cflags", "--libs", "hdf5", folder=tmp_path).split()
    library = (f"-I{RUNTIME}", tmp_path / "build" / "libskyshine.a")
    command = ("cc", *sanitized.split(), "-o", "user", USER / "user.c", *library, *flags, "-lpthread", "-lm")
    run(*command, folder=tmp_path)
    leaks = {"ASAN_OPTIONS": "detect_leaks=1"}
    agrees(run(tmp_path / "user", small_build, *files, folder=tmp_path, environment=leaks), files)


@pytest.mark.validation
def test_a_user_in_rust_builds_against_the_crate(small_build, files, tmp_path):
    need("rust")
    shutil.copytree(USERS / "rust", tmp_path / "user")
    manifest = tmp_path / "user" / "Cargo.toml"
    manifest.write_text(manifest.read_text().replace("@SKYSHINE@", str(RUNTIMES / "rust")))
    target = os.environ.get("CARGO_TARGET_DIR", str(tmp_path / "target"))
    run("cargo", "build", "--release", "--target-dir", target, folder=tmp_path / "user")
    agrees(run(Path(target) / "release" / "user", small_build, *files, folder=tmp_path), files)


@pytest.fixture(scope="module")
def javascript_user(tmp_path_factory):
    """Folder of a user's project in TypeScript, with the package as `npm pack` makes it."""
    need("javascript")
    folder = tmp_path_factory.mktemp("javascript")
    prepared_package(folder)
    built(folder, ["npm", "install", "--no-package-lock", "--no-audit", "--no-fund", *TYPES])
    for file in (USERS / "javascript").iterdir():
        shutil.copy(file, folder)
    return folder


@pytest.mark.validation
def test_a_user_in_typescript_compiles_and_runs(javascript_user, small_build, files):
    run(*COMPILED, "user.ts", folder=javascript_user)
    agrees(run("node", "user.js", small_build, *files, folder=javascript_user), files)


@pytest.mark.validation
def test_the_types_refuse_a_face_without_its_slope(javascript_user):
    done = subprocess.run([*COMPILED, "--noEmit", "wrong.ts"], cwd=javascript_user, capture_output=True, text=True)
    assert done.returncode != 0 and "'slope'" in done.stdout and "wrong.ts(5," in done.stdout, done.stdout
