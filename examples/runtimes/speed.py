"""Speed of the C library, of the Rust crate and of the npm package: pixels a second of processor time on one frame,
beside the Python package, which is measured once with the air of the frame's centre and once with that of each pixel's
own line.

Run: python speed.py FOLDER [--band N], with the folder of a build and skyshine installed. The programs are built in a
temporary folder; a language whose tools are not there is left out. The npm package needs the package `ziglang`.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
SIDE = 256  # pixels of a row and of a column
TURNS = 100
REPEATS = 3  # the fastest is kept: other programs on the machine only ever slow one down
ALTITUDE = 0.9  # km, of the observer above the ground


def frame_of(files: dict[str, str]) -> dict[str, Any]:
    """A picture of a plane below the horizon, of patches of all materials, on faces of every direction."""
    import skyshine.mat

    surface, band = skyshine.mat.open(files["surface"]), skyshine.mat.open(files["band"])
    nodes = {name: surface.root.axes[name].values for name in ("altitude", "slope")}
    draw, count = np.random.default_rng(1), SIDE * SIDE
    elevation = np.repeat(np.linspace(-25.0, -5.0, SIDE), SIDE)
    patches = draw.choice(band.root.axes["material"].values, (SIDE // 16, SIDE // 16))
    ground = float(nodes["altitude"][0])
    lists = {
        "material": np.kron(patches, np.ones((16, 16), int)).ravel(),
        "range": ALTITUDE / np.sin(np.radians(-elevation)),
        "elevation": elevation,
        "heading": np.tile(np.linspace(20.0, 40.0, SIDE), SIDE),
        "surface_altitude": draw.uniform(ground, min(ground + 0.2, nodes["altitude"][-1]), count),
        "surface_azimuth": draw.uniform(0.0, 360.0, count),
        "surface_slope": draw.uniform(nodes["slope"][0], min(40.0, nodes["slope"][-1]), count),
    }
    view = {
        "altitude": ground + ALTITUDE,
        "centre_range": 3.0,
        "centre_elevation": -15.0,
        "centre_heading": 30.0,
        "source_elevation": 50.0,
        "source_heading": 150.0,
        "time": 14.3,
    }
    return view | {name: values.tolist() for name, values in lists.items()}


def by_library(tables: list[Any], frame: dict[str, Any], count: int, *, own: bool = False) -> np.ndarray:
    """Radiances of the first pixels of a frame, with the air of its centre or of each pixel's own line."""
    from skyshine.mat.quantities.lines_of_sight import LinesOfSight
    from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance

    def directions(elevation: np.ndarray, heading: np.ndarray) -> np.ndarray:
        up, turn = np.radians(elevation), np.radians(heading)
        return np.stack([np.cos(up) * np.sin(turn), np.cos(up) * np.cos(turn), np.sin(up)], axis=-1)

    of = {name: np.array(frame[name][:count]) for name in frame if isinstance(frame[name], list)}
    whole = {name: np.full(count, frame[name]) for name in frame if isinstance(frame[name], float)}
    lines = LinesOfSight(
        whole["centre_range"],
        whole["altitude"],
        whole["centre_elevation"],
        whole["source_elevation"],
        whole["source_heading"] - whole["centre_heading"],
    )
    view = View(
        lines,
        of["range"],
        source_heading=whole["source_heading"],
        normal=directions(90.0 - of["surface_slope"], of["surface_azimuth"]),
        to_source=directions(whole["source_elevation"], whole["source_heading"]),
        to_observer=-directions(of["elevation"], of["heading"]),
    )
    if own:
        turn = whole["source_heading"] - of["heading"]
        lines = LinesOfSight(of["range"], lines.altitude, of["elevation"], lines.source_elevation, turn)
        view = replace(view, lines=lines)
    codes = of["material"][:, None]
    place = (of["surface_altitude"], of["surface_azimuth"], of["surface_slope"])
    faces = Faces(codes, np.ones(codes.shape), *place, whole["time"])
    surface, band, air = tables
    return pixel_radiance(surface, band, air, faces, view).radiance


def seconds_in_python(tables: list[Any], frame: dict[str, Any], *, own: bool) -> float:
    """Seconds a pixel of processor time in the package, the fastest of several runs."""
    runs = []
    for _ in range(REPEATS):
        begin = time.process_time()
        by_library(tables, frame, SIDE * SIDE, own=own)
        runs.append(time.process_time() - begin)
    return min(runs) / SIDE**2


# Parts of each language: its tool, the commands that build its program in a folder, and the command of the program.
PROGRAMS = {
    "C": (
        "cmake",
        [["cmake", "-S", "{here}/c", "-B", "{to}/c"], ["cmake", "--build", "{to}/c"]],
        ["{to}/c/runtime"],
    ),
    "Rust": (
        "cargo",
        [["cargo", "build", "-q", "--release", "--manifest-path", "{here}/rust/Cargo.toml", "--target-dir", "{to}"]],
        ["{to}/release/runtime"],
    ),
    "WebAssembly in Node": (
        "node",
        [
            ["python3", "{here}/javascript/build.py"],
            ["cp", "-r", "{here}/javascript", "{to}/javascript"],
            ["npm", "install", "--silent", "--ignore-scripts", "--prefix", "{to}/javascript"],
        ],
        ["node", "{to}/javascript/runtime.js"],
    ),
}


def built(language: str, folder: Path) -> list[str]:
    """The command of the program of a language, built in a folder; empty where its tool is not there."""
    tool, steps, command = PROGRAMS[language]
    if shutil.which(tool) is None:
        return []
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])  # python3 is this one
    for step in steps:
        words = [word.format(here=HERE, to=folder) for word in step]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL, env=os.environ | {"PATH": path})
    return [word.format(to=folder) for word in command]


def seconds_of(command: list[str], scene: Path, content: dict[str, Any]) -> tuple[float, np.ndarray]:
    """Processor time of a program, with all that it starts, and the radiances that it prints."""
    scene.write_text(json.dumps(content), encoding="utf-8")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([*command, str(scene)], check=True, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, np.array(json.loads(done.stdout)["radiance"])


def measured(command: list[str], files: dict[str, str], frame: dict[str, Any], scene: Path) -> tuple[float, np.ndarray]:
    """Seconds a pixel, and radiances.

    The former are differences of runs of unlike lengths, so that reading the files does not count.
    """

    def best(repeat: int) -> tuple[float, np.ndarray]:
        runs = [seconds_of(command, scene, files | {"frame": frame | {"repeat": repeat}}) for _ in range(REPEATS)]
        return min(runs, key=lambda run: run[0])

    once, radiance = best(1)
    often, _ = best(1 + TURNS)
    return (often - once) / (TURNS * len(radiance)), radiance


def main() -> None:
    """Print the table."""
    import skyshine.mat

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--band", type=int, default=1)
    given = parser.parse_args()
    band = f"b{given.band:02d}"
    names = {"surface": "s01.htt.h5", "band": f"{band}.band.h5", "atmosphere": f"s01{band}.atmq.h5"}
    files = {name: str((given.folder / file).resolve()) for name, file in names.items()}
    frame = frame_of(files)
    tables = [skyshine.mat.open(files[name]) for name in ("surface", "band", "atmosphere")]
    by_library(tables, frame, 1)  # reads their arrays
    expected = by_library(tables, frame, SIDE * SIDE)
    print("| | million pixels/s | largest difference |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for language in PROGRAMS:
            command = built(language, Path(folder))
            if not command:
                print(f"{PROGRAMS[language][0]} is not installed: {language} is left out", file=sys.stderr)
                continue
            pixel, radiance = measured(command, files, frame, Path(folder) / "scene.json")
            apart = float(np.max(np.abs(radiance / expected - 1)))
            print(f"| {language} | {1e-6 / pixel:.3g} | {apart:.1g} |")
    for name, own in (("Python package", False), ("Python package, lines of their own", True)):
        print(f"| {name} | {1e-6 / seconds_in_python(tables, frame, own=own):.3g} | |")


if __name__ == "__main__":
    main()
