"""The five loaders of databases, run so that a crash, a hang or a huge allocation of theirs is an answer to judge."""

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
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

import skyshine.mat
from skyshine.mat.radiometry.lobe import specular_lobe
from skyshine.schemas.errors import InputError
from skyshine.tmm import open_tmm

sys.path.insert(0, str(Path(__file__).parent))
from good_databases import scene

if TYPE_CHECKING:
    from collections import Counter

    from hostile_corpus import Case

RUNTIMES = Path(__file__).parents[2] / "examples" / "runtimes"
TABLES = ("surface", "band", "atmosphere")
SECONDS = 20  # a loader that takes longer hangs
MEMORY = 2 << 30  # bytes beyond those of the interpreter
LONGEST = 400  # characters of a message
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
        Read the textures too, with the library: no runtime reads them.
    """

    def answer(paths: dict[str, Path]) -> Answer:
        path = folder / "scene.json"
        path.write_text(json.dumps(scene(paths)), encoding="utf-8")
        return load(path)

    original, texels, wrong = answer(good), texture_library(), {}
    texture = texels(good["texture"])
    assert original.status == texture.status == 0, (original, texture)
    for case in cases:
        if case.kind == "texture" and not textures:
            continue
        path = case.write(good, folder)
        if case.kind == "texture":
            found = judge(texels(path), texture)
        else:
            found = judge(answer(good | {case.kind: path}), original)
        if not case.is_met_by(found):
            wrong[case.name] = f"must {case.verdict}: {found}"
        if counts is not None:
            counts[case.verdict, found if found in ("refused", "equal") else "wrong"] += 1
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    return wrong


def missing_tools(language: str) -> list[str]:
    """Programs and libraries that the runtime of a language needs and this machine lacks."""
    needed = {"c": ["cc", "make", "pkg-config"], "javascript": ["node", "npm"], "rust": ["cargo", "pkg-config"]}
    missing = [tool for tool in needed.get(language, []) if shutil.which(tool) is None]
    if not missing and language in ("c", "rust"):
        found = subprocess.run(["pkg-config", "--exists", "hdf5"], check=False).returncode == 0
        missing += [] if found else ["the headers of the HDF5 library"]
    return missing


def prepared(language: str, folder: Path, flags: str = "") -> list[str]:
    """The command of a runtime, built in a folder of its own."""

    def run(*command: str) -> None:
        done = subprocess.run(command, cwd=folder / language, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]

    shutil.copytree(RUNTIMES / language, folder / language)
    if language == "c":
        run("make", *([f"CFLAGS={flags}"] if flags else []))
        return [str(folder / "c" / "runtime")]
    if language == "javascript":
        run("npm", "install", "--no-package-lock", "--no-audit", "--no-fund")
        return ["node", str(folder / "javascript" / "runtime.js")]
    if language == "rust":
        target = os.environ.get("CARGO_TARGET_DIR", str(folder / "target"))
        run("cargo", "build", "--release", "--target-dir", target)
        return [str(Path(target) / "release" / "runtime")]
    return [sys.executable, str(folder / "python" / "runtime.py")]


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


def plain_python() -> Loader:
    """The runtime in plain Python, without a start of the interpreter for each file."""
    spec = importlib.util.spec_from_file_location("plain_runtime", RUNTIMES / "python" / "runtime.py")
    assert spec and spec.loader
    module: ModuleType = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)

    def shown(path: Path) -> str:
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            module.main(str(path))
        return output.getvalue()

    return in_child(shown)


def library() -> Loader:
    """`skyshine.mat.open`, and what a runtime computes from it."""
    return in_child(
        lambda path: json.dumps({k: v.tolist() for k, v in by_library(json.loads(path.read_text())).items()})
    )


def texture_library() -> Loader:
    """`skyshine.tmm.open_tmm`, and every texel of the file."""

    def read(path: Path) -> str:
        with open_tmm(path) as file:
            x, y = np.meshgrid(np.arange(file.width) + 0.5, np.arange(file.height) + 0.5)
            codes, shares = file.mixture(x, y)
            values = [file.code(x, y), codes, shares, file.confidence(x, y)]
            return json.dumps([file.materials, [value.tolist() for value in values]])

    return in_child(read)


def _ambient(surface, band, air, of: dict[str, np.ndarray], where: dict[str, np.ndarray]) -> np.ndarray:
    """Ambient radiance of the faces of pixels; of level ones where the pixels do not say where the source is."""
    if "source_heading" not in of or "ambient_radiance_harmonics" not in air.root.variables:
        return air.value("ambient_radiance", **where)
    ground = {}
    if "ground_material" in of:
        altitude, material = of["surface_altitude"], of["ground_material"].tolist()
        ground = {
            "ground_temperature": surface.temperature(material=material, altitude=altitude, time=of["time"]),
            "band": band,
        }
    turn = of["surface_azimuth"] - of["source_heading"]
    return air.ambient_radiance(slope=of["surface_slope"], azimuth=turn, **ground, **where)


def by_library(scene: dict) -> dict[str, np.ndarray]:
    """Every term of equation (1) of a scene with the library, all pixels at once."""
    surface, band, air = (skyshine.mat.open(scene[name]) for name in TABLES)
    for table, filetypes in ((surface, "htt"), (band, "band"), (air, "atmq lunar_atmq")):
        if table.filetype not in filetypes.split():
            raise InputError(f"holds '{table.filetype}'; allowed: {filetypes}; name another file", file=table.path)
    pixels = scene["pixels"]
    heat = ("absorbed_change", "surroundings")
    of = {name: np.array([pixel[name] for pixel in pixels]) for name in pixels[0] if name not in ("material", *heat)}
    codes = [pixel["material"] for pixel in pixels]
    material = np.array([code if isinstance(code, int) else int(band.material_codes(code)) for code in codes])
    face = {name: of[f"surface_{name}"] for name in ("altitude", "azimuth", "slope")}
    temperature = surface.temperature(material=material, time=of["time"], **face)
    for number, pixel in enumerate(pixels):
        if not any(name in pixel for name in heat):
            continue
        place = {"material": material[number], **{name: values[number] for name, values in face.items()}}
        around = pixel.get("surroundings")
        change = pixel.get("absorbed_change") if around is None else surface.absorbed_change(**place, **around)
        temperature[number] = surface.temperature(**place, time=pixel["time"], absorbed_change=change)
    rho, fraction, shininess, normalisation = (
        band.value(name, material=material)
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
        "skyshine": _ambient(surface, band, air, of, view | sun) * rho * tau,
        "diffuse": direct * cosine * (1 - fraction),
        "specular": direct * specular_lobe(shininess, source, observer, normal) * fraction * normalisation,
    }
    result["radiance"] = sum(result[name] for name in ("thermal", "path", "skyshine", "diffuse", "specular"))
    share = np.clip(result["radiance"] / scene["gain"], 0, 1)
    result["pixel_value"] = np.clip(
        np.floor(2 ** scene["bits"] * scene["buffer_gain"] * (share - scene["offset"])), 0, 2 ** scene["bits"] - 1
    )
    return result
