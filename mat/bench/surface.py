"""Error against run time of surface temperatures: the periodic solver by steps a day, marching schemes, casadi's
oracle, EnergyPlus.

Library materials on planes of one clear summer day. The oracle is the reference: the same balance in other numerics,
exact to about 0.01 K. Errors are over the solver's times of all oracle columns; times are processor seconds a column of
a large batch whose forcing is known, medians of repeats. EnergyPlus gives run time alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from skyshine.mat.bench.marching import DAY, Grid, march
from skyshine.mat.surface.balance import Forcing
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.oracle import solve_oracle
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath
from skyshine.mat.surface.weather import NearSurfaceAir

MATERIALS = (
    "soil_sand",
    "soil_loam_wet",
    "concrete",
    "asphalt_road",
    "wood_pine_weathered",
    "aluminium_weathered",
    "grass_green",
    "water_fresh",
)
QUICK_MATERIALS = ("concrete", "grass_green")
# Dry, wet, vegetated: each has other fluxes to compute.
SPEED_MATERIALS = {"dry": "concrete", "wet": "soil_loam_wet", "vegetated": "grass_green"}
STEPS = (24, 48, 72, 96, 144, 192, 288, 576)
# Name, steps a day, days from the start, cells a layer, theta.
MARCHES = (
    ("implicit Euler, 1 h", 24, 5, 10, 1.0),
    ("implicit Euler, 15 min", 96, 5, 10, 1.0),
    ("implicit Euler, 5 min", 288, 10, 10, 1.0),
    ("Crank-Nicolson, 15 min", 96, 5, 10, 0.5),
    ("Crank-Nicolson, 5 min", 288, 10, 20, 0.5),
    ("one node a layer, implicit, 15 min", 96, 5, 1, 1.0),
)
EXPLICIT = ("explicit Euler, stable step", 5, 5)  # days, cells a layer
MOST_EXPLICIT_STEPS = 5_000
_SLOPES, _AZIMUTHS = (0.0, 30.0, 90.0), np.arange(0.0, 360.0, 15.0)
_ORACLE_PLANES = ((0.0, 0.0), (90.0, 90.0))
_COPIES = 16  # of them: a table has as many columns a material
_REPEATS = 3


@dataclass(frozen=True)
class Rung:
    """One method: error [K] against the oracle (None: not compared) and processor seconds a column."""

    name: str
    family: str
    rms: float | None
    largest: float | None
    seconds: float
    columns: int


@dataclass(frozen=True)
class Speed:
    """Processor seconds a column of a material, with 96 steps and with the steps that the solver chooses."""

    kind: str
    material: str
    seconds_96: float
    seconds_default: float
    default_steps: int


@dataclass(frozen=True, eq=False)
class Case:
    """A material, the forcing of a batch and of a few planes by steps a day, and the oracle's temperatures (planes, n)
    of the few.

    The forcing is computed once: a table shares it among all materials.
    """

    material: SurfaceMaterial
    batch: Callable[[int], Forcing]
    few: Callable[[int], Forcing]
    reference: np.ndarray
    oracle_seconds: float


def forcing_of(sun: SunPath, weather: NearSurfaceAir, sky: Sky, planes) -> Callable[[int], Forcing]:
    """Forcing of planes (slope, azimuth) at the site by steps a day, each computed once."""
    slope, azimuth = np.array(planes, float).T
    return lru_cache(maxsize=None)(Scene(sun, weather, sky, np.array([sun.altitude]), slope, azimuth).forcing)


def batch_planes() -> list[tuple[float, float]]:
    """Planes of the batch that is timed."""
    return [(slope, azimuth) for slope in _SLOPES for azimuth in _AZIMUTHS] * _COPIES


def forcing_between(forcing: Forcing, column: int):
    """Forcing of one column at any times [s], linear between its own times of the day."""
    one = forcing.columns(np.array([column]))
    steps = forcing.shape[1]
    at = np.arange(steps) * (DAY / steps)

    def forcing_at(seconds):
        values = {}
        for name, series in vars(one).items():
            series = np.asarray(series, float)
            moving = series.shape[-1] > 1
            values[name] = np.interp(seconds, at, series[0], period=DAY)[None, :] if moving else series
        return Forcing(**values)

    return forcing_at


def case_of(material: SurfaceMaterial, inputs, intervals: int = 192, cells: int = 40) -> Case:
    """Solve the oracle's columns of a material; intervals must divide SUN_STEPS."""
    few = forcing_of(*inputs, _ORACLE_PLANES)
    forcing = few(SUN_STEPS)
    begin = time.process_time()
    found = [
        solve_oracle(material, forcing_between(forcing, column), intervals=intervals, cells=cells).surface
        for column in range(len(_ORACLE_PLANES))
    ]
    seconds = (time.process_time() - begin) / len(_ORACLE_PLANES)
    reference = np.roll(np.array(found), 1, axis=1)  # from the ends of intervals to times from 0
    return Case(material, forcing_of(*inputs, batch_planes()), few, reference, seconds)


def run(cases: list[Case], advance=None) -> tuple[list[Rung], list[str]]:
    """All rungs, and what is left out of the explicit scheme."""
    rungs = []

    def add(name, family, solve, cases=cases):
        differences, seconds = [], []
        columns = 0
        for case in cases:
            differences.append(_difference(solve(case.material, case.few), case.reference))
            solve(case.material, case.batch)  # computes the forcing
            seconds.append(_median_seconds(lambda: solve(case.material, case.batch)))  # noqa: B023
            columns += len(batch_planes())
            if advance:
                advance(1)
        each = np.concatenate([difference.ravel() for difference in differences])
        rms, largest = float(np.sqrt(np.mean(each**2))), float(np.abs(each).max())
        rungs.append(Rung(name, family, rms, largest, sum(seconds) / columns, columns))

    for steps in STEPS:
        add(
            f"periodic, N = {steps}", "periodic", lambda material, forcing, n=steps: _solved(material, forcing, n, None)
        )
    add("periodic, default", "default", lambda material, forcing: _solved(material, forcing, 96, 288))
    for name, steps, days, cells, theta in MARCHES:
        add(
            name,
            "marching",
            lambda material, forcing, n=steps, d=days, c=cells, t=theta: march(material, forcing(n), n, d, c, t),
        )
    name, days, cells = EXPLICIT
    steps = {case.material.name: Grid.of(case.material, cells).explicit_steps for case in cases}
    stable = [case for case in cases if steps[case.material.name] <= MOST_EXPLICIT_STEPS]
    if stable:
        add(
            name,
            "marching",
            lambda material, forcing: march(material, forcing(96), steps[material.name], days, cells, 0.0),
            stable,
        )
    oracle = float(np.mean([case.oracle_seconds for case in cases]))
    rungs.append(Rung("oracle (reference)", "oracle", None, None, oracle, len(cases) * len(_ORACLE_PLANES)))
    left_out = [
        f"{case.material.name} ({steps[case.material.name]} steps a day)" for case in cases if case not in stable
    ]
    return rungs, left_out


def speeds(materials: dict[str, SurfaceMaterial], inputs) -> list[Speed]:
    """Time a column of materials by kind, in the batch of `batch_planes`."""
    forcing = forcing_of(*inputs, batch_planes())
    found = []
    for kind, material in materials.items():
        steps = _solved(material, forcing, 96, 288).shape[1]  # computes the forcing
        spent = [
            _median_seconds(lambda: _solved(material, forcing, 96, fine)) / len(batch_planes())  # noqa: B023
            for fine in (None, 288)
        ]
        found.append(Speed(kind, material.name, *spent, steps))
    return found


def _solved(
    material: SurfaceMaterial, forcing: Callable[[int], Forcing], steps: int, fine_steps: int | None
) -> np.ndarray:
    ((_, found),) = (
        part for part in solve_columns(material, forcing, steps=steps, fine_steps=fine_steps) if len(part[0])
    )
    return found.temperature


def _difference(found: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Found less reference [K] at the times that both have."""
    steps = np.gcd(found.shape[1], reference.shape[1])
    return found[:, :: found.shape[1] // steps] - reference[:, :: reference.shape[1] // steps]


def _median_seconds(action) -> float:
    spent = []
    for _ in range(_REPEATS):
        begin = time.process_time()
        action()
        spent.append(time.process_time() - begin)
    return float(np.median(spent))


def plot(rungs: list[Rung], path) -> Path:
    """Draw error against time a column, both axes logarithmic."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.add_subplot(xscale="log", yscale="log", xlabel="processor time per column and day [us]")
    axes.set(ylabel="rms error of surface temperature [K]", title="Surface temperature against casadi's oracle")
    for family, marker in (("periodic", "o-"), ("default", "*"), ("marching", "s")):
        chosen = [rung for rung in rungs if rung.family == family]
        axes.plot([1e6 * rung.seconds for rung in chosen], [rung.rms for rung in chosen], marker, label=family)
        for rung in chosen:
            text = rung.name.replace("periodic, ", "")
            axes.annotate(text, (1e6 * rung.seconds, rung.rms), textcoords="offset points", xytext=(4, 4), fontsize=7)
    for rung in rungs:
        if rung.rms is None:
            axes.axvline(1e6 * rung.seconds, color="grey", linestyle=":")
            axes.annotate(
                rung.name, (1e6 * rung.seconds, 0.5), xycoords=("data", "axes fraction"), rotation=90, fontsize=7
            )
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    return Path(path)
