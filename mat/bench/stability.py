"""Extreme and stiff cases of every part, from surfaces to textures, drawn at random for a given time.

The cases are extreme: foil in a vacuum, fog of 100 m beside a range to space, air without water and saturated air, one
seed a material, whole jobs from the check to verified files. Each must give finite numbers, keep the bounds of physics
and probability, and close its balances.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from skyshine.mat.bench.extreme_air import atmosphere_case, sky_case
from skyshine.mat.bench.extreme_jobs import compiled_case, job_case
from skyshine.mat.bench.extreme_reading import band_case, lobe_case, table_case
from skyshine.mat.bench.extreme_textures import classifier_case, texture_case
from skyshine.mat.surface.relaxation import TOLERANCE
from skyshine.mat.surface.solution import Solution
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.stress import random_forcing, random_material, random_snow
from skyshine.schemas.errors import InputError, nearest

Measures: TypeAlias = dict[str, tuple[float, float]]  # value and upper bound of each measure
Case: TypeAlias = Callable[[np.random.Generator], Measures]
SURFACE_BOUND = 0.5  # K beyond the instantaneous equilibria, for a solver with a time step


@dataclass(eq=False)
class Trial:
    """Results of one part.

    Attributes
    ----------
    cases : int
    failures : list of str
        Each with the numbers that draw the case again.
    largest : dict of str to float
        Largest of each measure: residuals and violations of bounds.
    seconds : float
        Wall time of all cases together.
    slowest : float
        Processor seconds of the slowest case, those of its processes with them.
    slowest_case : str
    """

    cases: int = 0
    failures: list[str] = field(default_factory=list)
    largest: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0
    slowest: float = 0.0
    slowest_case: str = ""


def run(seconds: float, seed: int, parts: dict[str, Case] | None = None) -> dict[str, Trial]:
    """Try random cases until the time is up: at least one of each part, and then of the part that had the least time.

    Parameters
    ----------
    seconds : float
        Wall clock.
    seed : int
        Case k of a part is drawn from [seed, k], whatever the time.
    parts : dict of str to callable, optional
        A callable takes a generator and returns measures with the most that each may be; by default `PARTS`.
    """
    parts = PARTS if parts is None else parts
    trials = {name: Trial() for name in parts}
    end = time.monotonic() + seconds
    for name, case in parts.items():
        _one(trials[name], case, name, seed, 0)
    while time.monotonic() < end:
        name = min(trials, key=lambda part: trials[part].seconds)
        _one(trials[name], parts[name], name, seed, trials[name].cases)
    return trials


def replay(name: str, number: int, seed: int) -> Trial:
    """Try one case of a part of `PARTS` again.

    Raises
    ------
    InputError
        There is no such part.
    """
    if name not in PARTS:
        raise InputError(f"found the part '{name}'; {nearest(name, PARTS)}")
    trial = Trial()
    _one(trial, PARTS[name], name, seed, number)
    return trial


def _one(trial: Trial, case: Case, name: str, seed: int, number: int) -> None:
    label = f"--seed {seed} --case {name}:{number}"
    begin, clock = _processor_seconds(), time.monotonic()
    try:
        with np.errstate(all="ignore"):
            measures = case(np.random.default_rng([seed, number]))
    except Exception as error:
        trial.failures.append(f"{label}: {type(error).__name__}: {error}")
        measures = {}
    spent = _processor_seconds() - begin
    trial.seconds += time.monotonic() - clock
    trial.cases += 1
    if spent > trial.slowest:
        trial.slowest, trial.slowest_case = spent, label
    for measure, (value, allowed) in measures.items():
        trial.largest[measure] = max(trial.largest.get(measure, 0.0), value if np.isfinite(value) else np.inf)
        if not value <= allowed:
            trial.failures.append(f"{label}: {measure} {value:.3g}, allowed {allowed:.3g}")


def _processor_seconds() -> float:
    """Of this process and of those of its children that have ended, where the system counts them."""
    times = os.times()
    return time.process_time() + times.children_user + times.children_system


def surface_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """One column of extreme material and weather."""
    ((_, solution),) = solve_columns(random_material(generator), random_forcing(generator))
    return _surface_measures(solution)


def snow_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """One melting snow surface under a long record."""
    material, forcing, period = random_snow(generator)
    steps = forcing.shape[1]
    ((_, solution),) = solve_columns(material, lambda _: forcing, steps=steps, fine_steps=None, period=period)
    return _surface_measures(solution)


def _surface_measures(solution: Solution) -> dict[str, tuple[float, float]]:
    return {
        "not finite": (float(np.count_nonzero(~np.isfinite(solution.temperature))), 0.0),
        "residual, W m^-2": (float(np.max(solution.residual)), TOLERANCE),
        "energy closure, W m^-2": (float(np.max(np.abs(solution.energy_closure))), TOLERANCE),
        "bound excess, K": (float(np.max(solution.bound_excess)), SURFACE_BOUND),
    }


PARTS: dict[str, Case] = {
    "surface": surface_case,
    "snow": snow_case,
    "job": job_case,
    "compiled": compiled_case,
    "atmosphere": atmosphere_case,
    "sky": sky_case,
    "bands": band_case,
    "lobes": lobe_case,
    "tables": table_case,
    "classifier": classifier_case,
    "texture": texture_case,
}
