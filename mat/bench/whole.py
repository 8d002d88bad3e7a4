"""Error against run time of the whole tool: the ladders of its parts, with the default of each and its reason."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skyshine.mat.bench.pareto import unbeaten
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.quantity import quantity


@dataclass(frozen=True)
class Rung:
    """One setting: processor seconds a unit of work, and an error."""

    name: str
    seconds: float
    error: float
    default: bool = False
    peer: bool = False


@dataclass(frozen=True)
class Ladder:
    """The settings of one part.

    Attributes
    ----------
    name : str
    work, units : str
        What the seconds are for; of the error.
    rungs : tuple of Rung
    why : str
        Why the default is what it is.
    """

    name: str
    work: str
    units: str
    rungs: tuple[Rung, ...]
    why: str

    def pareto(self) -> list[Rung]:
        """Rungs that no other beats in both error and time."""
        stands = unbeaten([(rung.seconds, rung.error) for rung in self.rungs])
        return list(itertools.compress(self.rungs, stands))


def from_absorption(result: dict[str, Any]) -> list[Ladder]:
    """Ladders of spectral points from ``mat bench absorption --json``."""
    ladders = []
    for band, content in result["bands"].items():
        compiled = [rung["name"] for rung in content["rungs"] if rung["name"].startswith("compiled")]
        # The compiler stops where its tolerance holds, at 64 points at most.
        default = max(
            (name for name in compiled if int(name.split()[1]) <= 64), key=lambda name: int(name.split()[1]), default=""
        )
        rungs = [
            Rung(
                rung["name"],
                rung["time_line_of_sight"]["value"],
                rung["errors"]["all"]["in_band_rms"]["value"],
                rung["name"] == default,
                rung["name"] == "LOWTRAN7",
            )
            for rung in content["rungs"]
            if rung["name"] != content["reference"]
        ]
        ladders.append(
            Ladder(
                f"spectral points, {band}",
                "a line of sight",
                "in-band transmittance, rms",
                tuple(rungs),
                "points are added until accuracy.spectral_tolerance holds, 64 at most",
            )
        )
    return ladders


def from_atmosphere(result: dict[str, Any]) -> list[Ladder]:
    """Ladders of directions of the sky and of layers from ``mat bench atmosphere --json``; the error of the worst
    quantity.
    """
    from skyshine.mat.atmosphere.transfer.sky import ZENITHS

    why = {
        "directions": "each further rung takes twice the directions",
        "layers": "the levels of the state, as they are given",
    }
    ladders = []
    for band, content in result["bands"].items():
        for name, reason in why.items():
            rungs = [
                Rung(
                    rung["name"],
                    rung["time"]["value"],
                    max(error["value"] for error in rung["errors_rms"].values()),
                    rung["name"] == str(ZENITHS) if name == "directions" else rung is content["ladders"][name][-1],
                )
                for rung in content["ladders"][name]
            ]
            ladders.append(
                Ladder(f"{name}, {band}", "a small table", "relative, rms of the worst quantity", tuple(rungs), reason)
            )
    return ladders


def from_surface(result: dict[str, Any]) -> list[Ladder]:
    """The ladder of solver steps from ``mat bench surface --json``."""
    rungs = [
        Rung(
            rung["name"],
            rung["time_per_column_day"]["value"],
            rung["rms_error"]["value"],
            rung["family"] == "default",
            rung["family"] in ("oracle", "energyplus", "peer"),
        )
        for rung in result["rungs"]
        if rung["rms_error"] is not None
    ]
    why = "96 steps of the day, exact for each wave, err as 192 by BDF2 that take twice the time"
    return [Ladder("surface solver, steps a day", "a column and day", "K, rms", tuple(rungs), why)]


def compile_ladders(bands: Sequence[tuple[float, float]], tolerances: Sequence[float]) -> list[Ladder]:
    """Choice of the points of thermal bands, by the root mean square and by 99 % of what a pixel errs."""
    from skyshine.mat.bench.compile_ladder import compile_rungs

    why = "below it tables err more than points do; a day that shares its points takes the time of their test alone"
    ladders = []
    for low, high in bands:
        rungs = compile_rungs((low, high), tolerances)
        for measure, errors in (
            ("rms", [rung.rms for rung in rungs]),
            ("99 %", [rung.percentile for rung in rungs]),
        ):
            settings = tuple(
                Rung(f"{rung.name}, {rung.points} points", rung.seconds, error, rung.default)
                for rung, error in zip(rungs, errors, strict=True)
            )
            name = f"choice of points, {low:g}-{high:g} um, {measure}"
            ladders.append(Ladder(name, "a state and band", f"K of a pixel, {measure}", settings, why))
    return ladders


def run_command(program: str, *arguments: str) -> dict[str, Any]:
    """The JSON of a command of this package, run in a process of its own so that its clock counts it alone.

    Raises
    ------
    CheckFailed
        The command failed.
    """
    code = f"from skyshine.{program}.cli import main; main()"
    process = subprocess.run([sys.executable, "-c", code, *arguments, "--json"], capture_output=True, text=True)
    if process.returncode:
        raise CheckFailed(f"{program} {' '.join(arguments)}: {process.stderr.strip() or process.returncode}")
    result: dict[str, Any] = json.loads(process.stdout)
    return result


def parts(quick: bool) -> dict[str, Callable[[], list[Ladder]]]:
    """Parts of the tool to measure, by name.

    Parameters
    ----------
    quick : bool
        Narrow bands and few materials.
    """
    short = ("--quick",) if quick else ()
    return {
        "spectral points": lambda: from_absorption(run_command("mat", "bench", "absorption", *short)),
        "choice of points": lambda: compile_ladders(
            [(10.5, 11.0)] if quick else [(3.0, 5.0), (8.0, 12.0)],
            (1e-2, 1e-3) if quick else (3e-2, 1e-2, 3e-3, 1e-3, 3e-4),
        ),
        "directions and layers": lambda: from_atmosphere(run_command("mat", "bench", "atmosphere", *short)),
        "surface solver": lambda: from_surface(run_command("mat", "bench", "surface", *short)),
    }


def describe(ladders: Sequence[Ladder], seconds: dict[str, float]) -> dict[str, Any]:
    """All ladders as plain values; `seconds` of wall clock that each part took."""
    return {
        "ladders": [
            {
                "name": ladder.name,
                "work": ladder.work,
                "error": ladder.units,
                "why_the_default": ladder.why,
                "rungs": [
                    {
                        "name": rung.name,
                        "time": quantity(rung.seconds, "s"),
                        "error": rung.error,
                        "default": rung.default,
                        "peer": rung.peer,
                        "pareto": rung in ladder.pareto(),
                    }
                    for rung in ladder.rungs
                ],
            }
            for ladder in ladders
        ],
        "seconds": {name: quantity(spent, "s") for name, spent in seconds.items()},
    }


def plot(ladders: Sequence[Ladder], picture: Path) -> None:
    """Error against time of every ladder, the rungs that none beats joined, the default marked."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.6 * len(ladders), 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, ladder in zip(figure.subplots(1, len(ladders), squeeze=False)[0], ladders, strict=True):
        front = sorted(ladder.pareto(), key=lambda rung: rung.seconds)
        axes.loglog(
            [rung.seconds for rung in front], [max(rung.error, 1e-9) for rung in front], "-", color="tab:grey", lw=1
        )
        for rung in ladder.rungs:
            colour = "tab:red" if rung.default else "tab:orange" if rung.peer else "tab:blue"
            axes.loglog(rung.seconds, max(rung.error, 1e-9), "o", color=colour)
            axes.annotate(
                rung.name, (rung.seconds, max(rung.error, 1e-9)), fontsize=6, xytext=(3, 3), textcoords="offset points"
            )
        axes.set(title=ladder.name, xlabel=f"processor seconds for {ladder.work}", ylabel=ladder.units)
        axes.tick_params(axis="x", which="both", labelrotation=40)
    figure.savefig(picture, dpi=110, metadata={"Software": None})
