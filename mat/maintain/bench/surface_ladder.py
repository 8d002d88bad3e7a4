"""Error against run time of surface temperatures: the periodic solver by steps a day, marching schemes, casadi's
oracle, EnergyPlus.

Library materials on planes of one clear summer day: level, a wall and a slope; dry, wet and leafy ones. The oracle is
the reference: the same balance in other numerics, whose own error every case measures. Errors are over the solver's
times of all oracle columns; times are processor seconds a column of a large batch whose forcing is known, medians of
repeats. EnergyPlus gives run time alone.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from skyshine.mat.bench.marching import DAY, Grid, march
from skyshine.mat.surface import solver
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.oracle import solve_oracle
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.schemas.arrays import Floats

Inputs: TypeAlias = tuple[SunPath, NearSurfaceAir, Sky]
ForcingBySteps: TypeAlias = Callable[[int], Forcing]  # by steps a day
Solve: TypeAlias = Callable[[SurfaceMaterial, ForcingBySteps], Floats]  # surface temperatures (columns, steps), K
MATERIALS = (
    "soil_sand",
    "soil_loam_wet",
    "concrete",
    "asphalt_road",
    "wood_pine_weathered",
    "aluminium_weathered",
    "grass_green",
    "deciduous",
    "water_fresh",
)
QUICK_MATERIALS = ("concrete", "grass_green")
# Dry, wet, vegetated: each has other fluxes to compute.
SPEED_MATERIALS = {"dry": "concrete", "wet": "soil_loam_wet", "vegetated": "grass_green"}
STEPS = (24, 48, 72, 96, 144, 192, 288, 576)  # per day, of the periodic scheme
BDF2_STEPS = (96, 192, 576)  # per day
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
MOST_EXPLICIT_STEPS = 5_000  # per day; materials that need more are skipped
_SLOPES, _AZIMUTHS = (0.0, 30.0, 90.0), np.arange(0.0, 360.0, 15.0)
_ORACLE_PLANES = ((0.0, 0.0), (90.0, 90.0), (30.0, 180.0))
# Of the oracle: the forcing is linear within each interval. Its error in cells falls with their square, so that it
# differs by its own error from a solution in 1 / sqrt(2) of them.
ORACLE_CELLS, _DEGREE = 56, 3
_COPIES = 16  # of them: a table has as many columns a material
_REPEATS = 3  # timings


@dataclass(frozen=True)
class SurfaceRung:
    """One method: error [K] against the oracle (its own, stated, of the oracle; None: not compared) and processor
    seconds a column.
    """

    name: str
    family: str
    rms: float | None
    largest: float | None
    seconds: float
    columns: int


@dataclass(frozen=True)
class Speed:
    """Processor seconds a column of a material, with the solver's own steps."""

    kind: str
    material: str
    seconds: float


@dataclass(frozen=True, eq=False)
class Case:
    """A material, forcing of a batch and of a few planes, and the oracle's temperatures (planes, n) of the few planes
    with the oracle's own error at each [K].

    The forcing is computed once: a table shares it among all materials.
    """

    material: SurfaceMaterial
    batch: ForcingBySteps
    oracle_forcing: ForcingBySteps
    reference: Floats
    reference_error: Floats
    oracle_seconds: float


def forcing_of(inputs: Inputs, planes: Sequence[tuple[float, float]]) -> ForcingBySteps:
    """Forcing of planes (slope, azimuth) at the site by steps a day, each computed once."""
    slope, azimuth = np.array(planes, float).T
    sun, weather, sky = inputs
    return lru_cache(maxsize=None)(Scene(sun, weather, sky, np.array([sun.altitude]), slope, azimuth).forcing)


def batch_planes() -> list[tuple[float, float]]:
    """Planes of the batch that is timed."""
    return [(slope, azimuth) for slope in _SLOPES for azimuth in _AZIMUTHS] * _COPIES


def forcing_between(forcing: Forcing, column: int) -> Callable[[Floats], Forcing]:
    """Forcing of one column at any times [s], linear between its own times of the day."""
    day = forcing.columns(np.array([column]))
    steps = forcing.shape[1]
    times = np.arange(steps) * (DAY / steps)

    def forcing_at(seconds: Floats) -> Forcing:
        values = {}
        for name, series in day.given.items():
            series = np.asarray(series, float)
            moving = series.shape[-1] > 1
            values[name] = np.interp(seconds, times, series[0], period=DAY)[None, :] if moving else series
        return Forcing(**values)

    return forcing_at


def case_of(material: SurfaceMaterial, inputs: Inputs, intervals: int = SUN_STEPS, cells: int = ORACLE_CELLS) -> Case:
    """Solve the oracle's columns of a material; intervals must divide SUN_STEPS."""
    oracle_forcing = forcing_of(inputs, _ORACLE_PLANES)
    columns = [forcing_between(oracle_forcing(SUN_STEPS), column) for column in range(len(_ORACLE_PLANES))]

    def solved(degree: int, cells: int) -> Floats:
        """From times at the ends of intervals to times from 0 on."""
        ends = [solve_oracle(material, at, intervals=intervals, degree=degree, cells=cells).surface for at in columns]
        return np.roll(np.array(ends), 1, axis=1)

    begin = time.process_time()
    reference = solved(_DEGREE, cells)
    seconds = (time.process_time() - begin) / len(_ORACLE_PLANES)
    error = solved(_DEGREE - 1, round(cells / math.sqrt(2))) - reference
    return Case(material, forcing_of(inputs, batch_planes()), oracle_forcing, reference, error, seconds)


def run(
    cases: Sequence[Case], advance: Callable[[int], object] = lambda _: None
) -> tuple[list[SurfaceRung], list[str]]:
    """All rungs, and the materials that the explicit scheme leaves out."""
    rungs = [
        measured(f"periodic, N = {steps}", "periodic", partial(_solved, steps=steps), cases, advance) for steps in STEPS
    ]
    for steps in BDF2_STEPS:
        by_bdf2 = partial(_solved, steps=steps, scheme="bdf2")
        rungs.append(measured(f"periodic, BDF2, N = {steps}", "BDF2", by_bdf2, cases, advance))
    rungs.append(measured("periodic, default", "default", partial(_solved, steps=solver.STEPS), cases, advance))
    names = [case.material.name for case in cases]
    for name, steps, days, cells, theta in MARCHES:
        rungs.append(
            measured(name, "marching", _marching(days, cells, theta, dict.fromkeys(names, steps)), cases, advance)
        )
    explicit, days, cells = EXPLICIT
    stable_steps = {case.material.name: Grid.of(case.material, cells).explicit_steps for case in cases}
    stable = [case for case in cases if stable_steps[case.material.name] <= MOST_EXPLICIT_STEPS]
    if stable:
        solve = _marching(days, cells, 0.0, stable_steps, forcing_steps=96)
        rungs.append(measured(explicit, "marching", solve, stable, advance))
    oracle = float(np.mean([case.oracle_seconds for case in cases]))
    reference_error = np.concatenate([case.reference_error.ravel() for case in cases])
    columns = len(cases) * len(_ORACLE_PLANES)
    rungs.append(SurfaceRung("oracle (reference)", "oracle", *_rms_and_largest(reference_error), oracle, columns))
    left_out = [
        f"{case.material.name} ({stable_steps[case.material.name]} steps a day)" for case in cases if case not in stable
    ]
    return rungs, left_out


def measured(
    name: str, family: str, solve: Solve, cases: Sequence[Case], advance: Callable[[int], object]
) -> SurfaceRung:
    """Error of a method on the oracle's columns, and its time a column of the batch; `advance` is called by case."""
    differences, seconds = [], []
    for case in cases:
        differences.append(_difference(solve(case.material, case.oracle_forcing), case.reference).ravel())
        solve(case.material, case.batch)  # computes the forcing
        seconds.append(_median_seconds(partial(solve, case.material, case.batch)))
        advance(1)
    columns = len(batch_planes()) * len(cases)
    return SurfaceRung(name, family, *_rms_and_largest(np.concatenate(differences)), sum(seconds) / columns, columns)


def _rms_and_largest(error: Floats) -> tuple[float, float]:
    return float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())


def _marching(
    days: int,
    cells: int,
    theta: float,
    steps_of: Mapping[str, int],
    forcing_steps: int | None = None,
) -> Solve:
    """A marching scheme, with steps a day by material; its forcing has as many unless `forcing_steps` says fewer."""

    def solve(material: SurfaceMaterial, forcing: ForcingBySteps) -> Floats:
        steps = steps_of[material.name]
        return march(material, forcing(forcing_steps or steps), steps, days, cells, theta)

    return solve


def speeds(materials: dict[str, SurfaceMaterial], inputs: Inputs) -> list[Speed]:
    """Time a column of materials by kind, in the batch of `batch_planes`."""
    forcing = forcing_of(inputs, batch_planes())
    speeds_by_kind = []
    for kind, material in materials.items():
        seconds = _median_seconds(partial(_solved, material, forcing, steps=solver.STEPS)) / len(batch_planes())
        speeds_by_kind.append(Speed(kind, material.name, seconds))
    return speeds_by_kind


def _solved(material: SurfaceMaterial, forcing: ForcingBySteps, *, steps: int, scheme: str = "spectral") -> Floats:
    """Temperatures at the times of the first scheme."""
    temperature = np.empty(forcing(steps).shape)
    for columns, solution in solve_columns(material, forcing, steps=steps, fine_steps=None, scheme=scheme):
        temperature[columns] = solution.temperature
    return temperature


def _difference(temperature: Floats, reference: Floats) -> Floats:
    """Temperature less reference [K] at the times that both have."""
    steps = math.gcd(temperature.shape[1], reference.shape[1])
    difference: Floats = temperature[:, :: temperature.shape[1] // steps] - reference[:, :: reference.shape[1] // steps]
    return difference


def _median_seconds(action: Callable[[], object]) -> float:
    spent = []
    for _ in range(_REPEATS):
        begin = time.process_time()
        action()
        spent.append(time.process_time() - begin)
    return float(np.median(spent))


def plot(rungs: Sequence[SurfaceRung], path: Path) -> None:
    """Draw error against time a column, both axes logarithmic."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.add_subplot(xscale="log", yscale="log", xlabel="processor time per column and day [us]")
    axes.set(ylabel="rms error of surface temperature [K]", title="Surface temperature against casadi's oracle")
    for family, marker in (("periodic", "o-"), ("BDF2", "^"), ("default", "*"), ("marching", "s")):
        chosen = [rung for rung in rungs if rung.family == family]
        points = [(1e6 * rung.seconds, rung.rms) for rung in chosen if rung.rms is not None]
        axes.plot([x for x, _ in points], [y for _, y in points], marker, label=family)
        for rung, point in zip(chosen, points, strict=True):
            text = rung.name.replace("periodic, ", "")
            axes.annotate(text, point, textcoords="offset points", xytext=(4, 4), fontsize=7)
    for rung in rungs:
        if rung.family in ("oracle", "EnergyPlus"):
            axes.axvline(1e6 * rung.seconds, color="grey", linestyle=":")
            axes.annotate(
                rung.name, (1e6 * rung.seconds, 0.5), xycoords=("data", "axes fraction"), rotation=90, fontsize=7
            )
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=110, metadata={"Software": None})
