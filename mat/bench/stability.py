"""Extreme and stiff cases of every part, from surfaces to textures, drawn at random for a given time.

The cases are extreme: foil in a vacuum, fog of 100 m beside a range to space, air without water and saturated air, one
seed a material. Each must give finite numbers, keep the bounds of physics and probability, and close its balances.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from skyshine.mat.bench.extreme_air import atmosphere_case, sky_case
from skyshine.mat.bench.extreme_reading import band_case, lobe_case, table_case
from skyshine.mat.bench.extreme_textures import classifier_case, texture_case
from skyshine.mat.surface.relaxation import TOLERANCE
from skyshine.mat.surface.solver import Solution, solve_columns
from skyshine.mat.surface.stress import random_forcing, random_material, random_snow

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
    worst : dict of str to float
        Largest of each measure: residuals and violations of bounds.
    slowest : float
        Processor seconds of the slowest case.
    slowest_case : str
    """

    cases: int = 0
    failures: list[str] = field(default_factory=list)
    worst: dict[str, float] = field(default_factory=dict)
    slowest: float = 0.0
    slowest_case: str = ""


def run(seconds: float, seed: int, parts: dict[str, Case] | None = None) -> dict[str, Trial]:
    """Try random cases of each part in turn until the time is up, at least one of each.

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
    number = 0
    while number == 0 or time.monotonic() < end:
        for name, case in parts.items():
            _one(trials[name], case, name, seed, number)
            if number and time.monotonic() >= end:
                break
        number += 1
    return trials


def _one(trial: Trial, case: Case, name: str, seed: int, number: int) -> None:
    label = f"{name}, seed {seed}, case {number}"
    begin = time.process_time()
    try:
        with np.errstate(all="ignore"):
            measures = case(np.random.default_rng([seed, number]))
    except Exception as error:
        trial.failures.append(f"{label}: {type(error).__name__}: {error}")
        measures = {}
    spent = time.process_time() - begin
    trial.cases += 1
    if spent > trial.slowest:
        trial.slowest, trial.slowest_case = spent, label
    for measure, (value, allowed) in measures.items():
        trial.worst[measure] = max(trial.worst.get(measure, 0.0), value if np.isfinite(value) else np.inf)
        if not value <= allowed:
            trial.failures.append(f"{label}: {measure} {value:.3g}, allowed {allowed:.3g}")


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
    "atmosphere": atmosphere_case,
    "sky": sky_case,
    "bands": band_case,
    "lobes": lobe_case,
    "tables": table_case,
    "classifier": classifier_case,
    "texture": texture_case,
}
