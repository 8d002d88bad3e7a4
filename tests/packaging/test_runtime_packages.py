"""The C library and its bindings as packages: their versions, the formats that they know, and what they hold."""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest

from skyshine.schemas.format_versions import FORMAT_VERSION

CHECKOUT = Path(__file__).parents[2]
RUNTIMES = CHECKOUT / "examples" / "runtimes"
KERNEL = CHECKOUT / "mat" / "kernel"
sys.path.insert(0, str(KERNEL))

import backend

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


def text(*parts: str) -> str:
    return RUNTIMES.joinpath(*parts).read_text(encoding="utf-8")


def run(*command: object, folder: Path) -> str:
    done = subprocess.run([str(part) for part in command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    return done.stdout


def need(*tools: str) -> None:
    if missing := [tool for tool in tools if not works(tool)]:
        pytest.skip(f"{', '.join(missing)} not installed")


def works(tool: str) -> bool:
    """Whether a tool runs: rustup leaves a cargo on the path that has no compiler."""
    return shutil.which(tool) is not None and subprocess.run([tool, "--version"], capture_output=True).returncode == 0


def camel(name: str) -> str:
    return re.sub(r"_(\w)", lambda match: match[1].upper(), name)


def test_every_package_has_the_version_of_the_project():
    versions = {
        "header": re.search(r'#define SKYSHINE_VERSION "(.*)"', text("c", "skyshine.h"))[1],
        "cmake": re.search(r"project\(skyshine VERSION (\S+)", text("c", "CMakeLists.txt"))[1],
        "rust": tomllib.loads(text("rust", "Cargo.toml"))["package"]["version"],
        "javascript": json.loads(text("javascript", "package.json"))["version"],
    }
    assert versions == dict.fromkeys(versions, PROJECT["version"])


def test_every_package_knows_the_format_that_is_written():
    header = re.search(r'#define SKYSHINE_FORMAT "(.*)"', text("c", "skyshine.h"))[1]
    rust = re.search(r'pub const FORMAT: &str = "(.*)";', text("rust", "src", "lib.rs"))[1]
    javascript = re.search(r'export const FORMAT = "(.*)";', text("javascript", "source.js"))[1]
    assert {header, rust, javascript} == {FORMAT_VERSION}


def test_every_package_has_the_ten_calls_and_its_page_names_them():
    sources = "".join(path.read_text() for path in (RUNTIMES / "rust" / "src").glob("*.rs"))
    types = text("javascript", "index.d.ts")
    for call in CALLS:
        assert re.search(rf"SKYSHINE_API \w+ skyshine_{call}\(", text("c", "skyshine.h")), call
        assert re.search(rf"pub fn {call}\(", sources), call
        assert re.search(rf"^ *(export function )?{camel(call)}\(", types, re.MULTILINE), call
        assert f"`skyshine_{call}`" in text("c", "README.md"), call
        assert re.search(rf"^\|.*\b{camel(call)}\(", text("javascript", "README.md"), re.MULTILINE), call
        assert re.search(rf"\|.*\b{call}\(", text("rust", "README.md")), call


def test_npm_packs_the_binding_with_the_library_its_types_and_page():
    need("npm")
    (packed,) = json.loads(
        run("npm", "pack", "--dry-run", "--ignore-scripts", "--json", folder=RUNTIMES / "javascript")
    )
    held = {file["path"] for file in packed["files"]} | {"kernel.wasm"}  # made by the script of `npm pack`
    own = set(run("git", "ls-files", folder=RUNTIMES / "javascript").split()) - {"build.py"}
    assert held == own | {"kernel.wasm"} and {"index.js", "index.d.ts", "README.md", "package.json"} <= held
    assert "kernel.wasm" in json.loads(text("javascript", "package.json"))["files"]


def test_cargo_packs_the_crate_with_the_sources_of_the_library():
    need("cargo")
    held = set(run("cargo", "package", "--list", "--allow-dirty", folder=RUNTIMES / "rust").split())
    sources = {f"kernel/{path.name}" for path in KERNEL.iterdir() if path.suffix in (".c", ".h")}
    assert sources | {"build.rs", "src/lib.rs", "README.md"} <= held
    assert not [name for name in held if name.startswith("kernel/") and name not in sources]


def test_the_crate_compiles_the_sources_as_the_package_does():
    build = text("rust", "build.rs")
    listed = re.search(r"const ONCE: .*? = &\[(.*?)\];", build)[1]
    assert set(re.findall(r'"(.*?)"', listed)) == set(backend.ONCE) - {"freestanding.c"}
    assert {flag for flag in backend.FLAGS.split() if f'"{flag}"' not in build} <= {"-std=c11", "-O3", "-fPIC"}


@pytest.mark.validation  # a minute: the packed crate is compiled
def test_cargo_would_publish_the_crate_and_clippy_has_no_complaint(tmp_path):
    need("cargo", "pkg-config")
    target = ("--target-dir", os.environ.get("CARGO_TARGET_DIR", str(tmp_path / "target")))
    run("cargo", "publish", "--dry-run", "--allow-dirty", *target, folder=RUNTIMES / "rust")
    if shutil.which("cargo-clippy") is None:
        pytest.skip("clippy not installed")
    run("cargo", "clippy", "--all-targets", *target, "--", "-D", "warnings", folder=RUNTIMES / "rust")


@pytest.fixture(scope="module")
def source_archive(tmp_path_factory):
    """Names in the source distribution, below its folder."""
    folder = tmp_path_factory.mktemp("sdist")
    run(sys.executable, "-m", "build", "--sdist", "--outdir", folder, CHECKOUT, folder=folder)
    (archive,) = folder.glob("skyshine-*.tar.gz")
    with tarfile.open(archive) as content:
        return {name.partition("/")[2] for name in content.getnames()}


def test_the_source_distribution_holds_the_runtimes(source_archive):
    listed = run("git", "ls-files", "examples/runtimes", folder=CHECKOUT).split()
    link = "examples/runtimes/rust/kernel"  # to mat/kernel, beside which the crate finds the sources too
    assert len(listed) > 25 and set(listed) - {link} <= source_archive
    assert not [
        name for name in source_archive if name.startswith(link) or "node_modules" in name or "/target/" in name
    ]


def test_the_source_distribution_holds_the_kernel_and_its_compiler_alone(source_archive):
    assert set(run("git", "ls-files", "mat/kernel", folder=CHECKOUT).split()) <= source_archive
    assert not [name for name in source_archive if "libskyshine." in name]
