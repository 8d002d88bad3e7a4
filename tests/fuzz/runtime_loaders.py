"""The loaders of databases, in four languages, run so that a crash, a hang or a huge allocation is an answer."""

from __future__ import annotations

import contextlib
import faulthandler
import importlib.util
import io
import json
import multiprocessing
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import skyshine.mat
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance, pixel_value
from skyshine.schemas.errors import InputError
from skyshine.tmm import open_tmm

sys.path.insert(0, str(Path(__file__).parent))
from good_databases import scene
from hostile_harmless import LATER

if TYPE_CHECKING:
    from collections import Counter

    from hostile_cases import Case

RUNTIMES = Path(__file__).parents[2] / "examples" / "runtimes"
RUNTIME = RUNTIMES / "c"
TOOLS = {"c": ("cc", "cmake", "pkg-config"), "rust": ("cargo", "cc", "pkg-config"), "javascript": ("node", "npm")}
TABLES = ("surface", "band", "atmosphere")
NOT_ARRAYS = (
    "material",
    "texel",
    "level",
    "absorbed_change",
    "surroundings",
    "line_heading",
    "sky_view",
)  # keys of a pixel
SECONDS = 20  # a loader that takes longer hangs
MEMORY = 2 << 30  # bytes beyond those of the interpreter
LONGEST = 800  # characters of a message, which may list the quantities of a file after a long path
SANITIZED = "-g -O1 -Wall -Wextra -std=c11 -fsanitize=address,undefined -fno-sanitize-recover=all"
SANITIZERS = {"ASAN_OPTIONS": "detect_leaks=0:exitcode=99:max_allocation_size_mb=2048:allocator_may_return_null=1"}


@dataclass(frozen=True)
class Answer:
    """Exit status, standard output and standard error of a loader."""

    status: int
    shown: str
    complaint: str


Loader = Callable[[Path], Answer]


def judge(answer: Answer, good: Answer) -> str:
    """'refused', 'equal' to the answer from good files, or how it is wrong."""
    if answer.status == 0:
        return "equal" if answer.shown == good.shown and not answer.complaint else "read otherwise"
    if answer.status != 1:
        return f"ended with status {answer.status}: {answer.complaint[-200:]!r}"
    if answer.shown.strip():
        return "refused after output"
    lines = answer.complaint.strip().splitlines()
    if len(lines) != 1 or not 5 < len(lines[0]) < LONGEST:
        return f"refused in {len(lines)} lines: {answer.complaint[:200]!r}"
    return "refused"


def wrong_answers(
    load: Loader,
    cases: list[Case],
    good: dict[str, Path],
    folder: Path,
    counts: Counter[tuple[str, str]] | None = None,
    *,
    textures: bool = True,
) -> dict[str, str]:
    """Read files of the corpus; returns by name what a loader did that it must not.

    Parameters
    ----------
    counts : Counter, optional
        Counts the files by what must be done with them, and by 'refused', 'equal' or 'wrong'.
    textures : bool
        Read textures whole, with the library; otherwise those texels that the pixels of the scene ask for.
    """

    def answer(paths: dict[str, Path]) -> Answer:
        path = folder / "scene.json"
        path.write_text(json.dumps(scene(paths)), encoding="utf-8")
        return load(path)

    texels, wrong = texture_library(), {}
    original, texture = answer(good), texels(good["texture"])
    assert original.status == texture.status == 0, (original, texture)
    for case in cases:
        path = case.write(good, folder)
        if case.kind == "texture" and textures:
            found = judge(texels(path), texture)
        else:
            found = judge(answer(good | {case.kind: path}), original)
        if not case.is_met_by(found, whole=textures or case.kind != "texture"):
            wrong[case.name] = f"must {case.verdict}: {found}"
        if counts is not None:
            counts[case.verdict, found if found in ("refused", "equal") else "wrong"] += 1
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    return wrong


def missing_tools(language: str = "c") -> list[str]:
    """Programs and libraries that a binding of the library needs and this machine lacks."""
    missing = [tool for tool in TOOLS[language] if shutil.which(tool) is None]
    if language == "javascript" and importlib.util.find_spec("ziglang") is None:
        missing.append("the package ziglang")
    if not missing and language != "javascript" and subprocess.run(["pkg-config", "--exists", "hdf5"]).returncode:
        missing = ["the headers of the HDF5 library"]
    return missing


def built(folder: Path, *steps: Sequence[object]) -> str:
    """Standard output of the last of some commands, run in a folder; python3 is the one that runs the tests."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for step in steps:
        command = [str(part) for part in step]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=os.environ | {"PATH": path})
        assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    return done.stdout


def prepared(folder: Path, flags: str = "") -> list[str]:
    """The command of the program of the C library, built in a folder of its own."""
    options = [f"-DCMAKE_C_FLAGS={flags}", "-DCMAKE_BUILD_TYPE=None"] if flags else []
    configure = ["cmake", "-S", RUNTIME, "-B", "build", "-DBUILD_SHARED_LIBS=OFF", *options]
    built(folder, configure, ["cmake", "--build", "build"])
    return [str(folder / "build" / "runtime")]


def prepared_crate(folder: Path) -> list[str]:
    """The command of the program of the Rust crate; CARGO_TARGET_DIR keeps what is compiled."""
    target = os.environ.get("CARGO_TARGET_DIR", str(folder / "target"))
    built(RUNTIMES / "rust", ["cargo", "build", "--release", "--target-dir", target])
    return [str(Path(target) / "release" / "runtime")]


def prepared_package(folder: Path) -> list[str]:
    """The command of the program of the npm package, packed and installed as a user has it."""
    shown = built(folder, ["npm", "pack", RUNTIMES / "javascript", "--json"])
    archive = json.loads(shown[shown.index("[") :])[0]["filename"]
    (folder / "package.json").write_text('{"private": true, "type": "module"}', encoding="utf-8")
    built(folder, ["npm", "install", "--no-package-lock", "--no-audit", "--no-fund", f"./{archive}"])
    return ["node", str(folder / "node_modules" / "skyshine" / "runtime.js")]


PREPARED = {"c": prepared, "rust": prepared_crate, "javascript": prepared_package}


def program(command: list[str], environment: dict[str, str] | None = None) -> Loader:
    """A loader that is a program of its own."""

    def run(scene: Path) -> Answer:
        try:
            done = subprocess.run(
                [*command, str(scene)],
                capture_output=True,
                timeout=SECONDS,
                env=os.environ | (environment or {}),
                check=False,
            )
        except subprocess.TimeoutExpired:
            return Answer(-signal.SIGALRM, "", f"took more than {SECONDS} s")
        return Answer(done.returncode, *(text.decode(errors="replace") for text in (done.stdout, done.stderr)))

    return run


def in_child(function: Callable[[Path], str]) -> Loader:
    """A loader in Python: a function that returns what it shows, run in a forked child of bounded time and memory."""

    def child(path: Path, sender) -> None:
        taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, taken + MEMORY))
        faulthandler.disable()  # of a test runner: a crash is an answer here
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors):
            try:
                status, shown, complaint = 0, function(path), ""
            except SystemExit as error:
                status, shown, complaint = 1, "", str(error.code)
            except InputError as error:
                status, shown, complaint = 1, "", str(error)
            except BaseException as error:
                status, shown, complaint = 2, "", f"{type(error).__name__}: {error}"
        sender.send(Answer(status, shown, complaint + errors.getvalue()))
        sender.close()

    def run(path: Path) -> Answer:
        receiver, sender = multiprocessing.Pipe(duplex=False)
        process = multiprocessing.get_context("fork").Process(target=child, args=(path, sender))
        process.start()
        sender.close()
        try:
            answer = receiver.recv() if receiver.poll(SECONDS) else Answer(-signal.SIGALRM, "", "hangs")
        except EOFError:
            process.join()
            answer = Answer(process.exitcode or 2, "", "the process died")
        process.kill()
        process.join()
        return answer

    return run


def library() -> Loader:
    """`skyshine.mat.open`, every array of each table, and what a runtime computes from them."""

    def shown(path: Path) -> str:
        scene = json.loads(path.read_text())
        for name in TABLES:
            for array, variable in skyshine.mat.open(scene[name]).root.variables.items():
                if not array.startswith(LATER):  # of a later format, which no reader of this one asks for
                    np.size(variable.data)  # arrays are read, and refused, when they are first asked for
        return json.dumps({name: values.tolist() for name, values in by_library(scene).items()})

    return in_child(shown)


def texture_library() -> Loader:
    """`skyshine.tmm.open_tmm`, and every texel of the file."""

    def read(path: Path) -> str:
        with open_tmm(path) as file:
            x, y = np.meshgrid(np.arange(file.width) + 0.5, np.arange(file.height) + 0.5)
            codes, shares = file.mixture(x, y)
            values = [file.code(x, y), codes, shares, file.confidence(x, y), file.shade(x, y)]
            values += [file.shade(x, y, level) for level in range(1, file.levels)]
            return json.dumps([file.materials, [value.tolist() for value in values]])

    return in_child(read)


def by_library(scene: dict) -> dict[str, np.ndarray]:
    """Every term of equation (1) of a scene with the library, all pixels at once."""
    surface, band, air = (skyshine.mat.open(scene[name]) for name in TABLES)
    for table, filetypes in ((surface, "htt"), (band, "band"), (air, "atmq lunar_atmq")):
        if table.filetype not in filetypes.split():
            raise InputError(f"has '{table.filetype}'; allowed: {filetypes}; name another file", file=table.path)
    pixels = [_with_source(surface, air, pixel) for pixel in scene["pixels"]]
    of = {name: np.array([pixel[name] for pixel in pixels]) for name in pixels[0] if name not in NOT_ARRAYS}
    codes, shares, shade = _materials(band, scene, pixels)
    face = {name: of[f"surface_{name}"] for name in ("altitude", "azimuth", "slope")} | {"time": of["time"]}
    faces = Faces(codes, shares, **face, ground_material=of.get("ground_material"))
    temperature = np.array([_temperatures(surface, faces, number, pixel) for number, pixel in enumerate(pixels)])
    faces = replace(faces, temperature=temperature, **_exposure(surface, faces, scene, pixels, shade))
    place = ("centre_range", "altitude", "centre_elevation", "source_elevation", "source_azimuth")
    lines = LinesOfSight(*(of[name] for name in place))
    directions = (of[name] for name in ("normal", "to_source", "to_observer"))
    terms = pixel_radiance(surface, band, air, faces, View(lines, of["range"], *directions, of.get("source_heading")))
    camera = {name: scene[name] for name in ("bits", "gain", "buffer_gain", "offset")}
    result = {field.name: getattr(terms, field.name) for field in fields(terms)} | {"radiance": terms.radiance}
    return result | {"pixel_value": pixel_value(terms.radiance, **camera)}


def _with_source(surface, air, pixel: dict) -> dict:
    """The pixel with its source, from the tracks where it does not say where that is."""
    if "source_elevation" in pixel:
        return pixel
    track = surface.source_track("moon" if air.filetype == "lunar_atmq" else "sun", time=pixel["time"])
    up, turn = np.radians([track.elevation, track.azimuth])
    place = {
        "source_elevation": float(track.elevation),
        "source_azimuth": float(track.azimuth - pixel["line_heading"]),
        "source_heading": float(track.azimuth),
        "to_source": [float(np.cos(up) * np.sin(turn)), float(np.cos(up) * np.cos(turn)), float(np.sin(up))],
    }
    return place | pixel


def _exposure(surface, faces: Faces, scene: dict, pixels: list[dict], shade: np.ndarray) -> dict[str, np.ndarray]:
    """What keeps light from the pixels, as fields of `Faces`."""
    sky_view = np.array([pixel.get("sky_view", 1.0) for pixel in pixels])
    shaded_sky = np.full(len(pixels), scene.get("shaded_sky", 0.5))
    given = {}
    if np.any(sky_view < 1):
        air = surface.value("air_temperature", altitude=faces.altitude, forcing_time=faces.time)
        given = {"sky_view": sky_view, "wall_temperature": air}
    if shade.any():
        given |= {"shade": shade, "shaded_sky": shaded_sky}
    if any("surroundings" in pixel for pixel in pixels):
        dark = []
        for number, pixel in enumerate(pixels):
            around = dict(pixel.get("surroundings", {}))
            open_sky = min(around.get("sky_view", 1.0), sky_view[number], shaded_sky[number])
            around |= {"shade": [[0, 24]], "sky_view": open_sky}
            dark.append(_temperatures(surface, faces, number, pixel | {"surroundings": around}))
        given["shaded_temperature"] = np.array(dark)
    return given


def _materials(band, scene: dict, pixels: list[dict]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Codes and shares (n, 3) of the materials of pixels, and their shares (n,) in the shade: those of their texels, or
    one material each.
    """
    codes, shares, shade = np.zeros((len(pixels), 3), int), np.zeros((len(pixels), 3)), np.zeros(len(pixels))
    shares[:, 0] = 1
    with contextlib.ExitStack() as opened:
        texture = None
        for number, pixel in enumerate(pixels):
            if "texel" in pixel:
                texture = texture or opened.enter_context(open_tmm(scene["texture"]))
                place, level = pixel["texel"], pixel.get("level", 0)
                codes[number], shares[number] = texture.mixture(*place, level=level)
                shade[number] = texture.shade(*place, level=level)
            else:
                given = pixel["material"]
                codes[number, 0] = given if isinstance(given, int) else int(band.material_codes(given))
    return codes, shares, shade


def _temperatures(surface, faces: Faces, number: int, pixel: dict) -> np.ndarray:
    """Temperatures (3,) of the materials of a pixel, with its heat or its surroundings."""
    used = np.where(faces.shares[number] > 0, faces.codes[number], faces.codes[number, 0])
    place = {"material": used} | {name: getattr(faces, name)[number] for name in ("altitude", "azimuth", "slope")}
    change = pixel.get("absorbed_change")
    if "surroundings" in pixel:
        change = surface.absorbed_change(**place, **pixel["surroundings"])
    return surface.temperature(**place, time=pixel["time"], absorbed_change=change)
