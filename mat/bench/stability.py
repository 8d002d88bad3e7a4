"""Extreme and stiff cases of every part, from surfaces to textures, drawn at random for a given time.

The cases are extreme: foil in a vacuum, fog of 100 m beside a range to space, air without water and saturated air, one
seed a material, whole jobs from the check to verified files. Each must give finite numbers, keep the bounds of physics
and probability, and close its balances.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

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
from skyshine.schemas.quantity import quantity

Measures: TypeAlias = dict[str, tuple[float, float]]  # value and upper limit of each measure
Outcome: TypeAlias = Measures | str  # or, in a word, what ended a case that was rightly refused
CaseFunction: TypeAlias = Callable[[np.random.Generator], Outcome]
SURFACE_BOUND = 0.5  # K beyond the instantaneous equilibria, for a solver with a time step
FEWEST_CASES = 5  # fewest cases of each kind, before the kinds share the time


@dataclass(frozen=True)
class Case:
    """One case that was tried.

    Attributes
    ----------
    number, seed : int
        Generator's key [seed, number].
    measures : dict
        Value and upper limit of each measure; empty where the case was refused or raised an error.
    refusal, error : str
        Reason of a rightful refusal, and error that it raised; empty where there was none.
    seconds : float
        Processor seconds, those of its processes included.
    """

    kind: str
    number: int
    seed: int
    measures: Measures
    refusal: str
    error: str
    seconds: float

    @property
    def again(self) -> str:
        """Command that runs the case again."""
        return f"mat bench stability --seed {self.seed} --case {self.kind}:{self.number}"

    @property
    def worst(self) -> str:
        """Measure that uses most of its limit; empty where there is none."""
        return max(self.measures, key=lambda name: share_of_limit(*self.measures[name]), default="")

    @property
    def failures(self) -> list[str]:
        """What is wrong with the case, in a line each."""
        beyond = [
            f"{name} {value:.3g}, limit {limit:.3g}"
            for name, (value, limit) in self.measures.items()
            if share_of_limit(value, limit) > 1
        ]
        return [f"{self.again}: {text}" for text in ([self.error] if self.error else []) + beyond]


def share_of_limit(value: float, limit: float) -> float:
    """Part of a limit that a value uses: above 1 it fails; infinite where the value is not a number."""
    if not value <= limit:
        return max(value / limit, np.nextafter(1.0, 2.0)) if np.isfinite(value) and limit > 0 else np.inf
    return value / limit if limit > 0 else 0.0


def run(seconds: float, seed: int, kinds: dict[str, CaseFunction] | None = None) -> list[Case]:
    """Try random cases until the time is up: one of each kind, then `FEWEST_CASES` of each, the cheapest kinds first,
    then of the kind that had the least time.

    Parameters
    ----------
    seconds : float
        Processor time, which does not depend on the load of the machine.
    seed : int
        Case k of a kind is drawn from [seed, k], whatever the time.
    kinds : dict of str to callable, optional
        A callable takes a generator and returns measures with their limits; by default `KINDS`.

    Returns
    -------
    list of Case
        Cases in the order in which they ran.
    """
    kinds = KINDS if kinds is None else kinds
    counts, spent = dict.fromkeys(kinds, 0), dict.fromkeys(kinds, 0.0)
    cases: list[Case] = []
    start = _processor_seconds()

    def try_next(kind: str) -> None:
        begin = _processor_seconds()
        cases.append(_tried(kind, kinds[kind], seed, counts[kind]))
        counts[kind] += 1
        spent[kind] += _processor_seconds() - begin

    for kind in kinds:
        try_next(kind)
    while _processor_seconds() < start + seconds:
        try_next(min(kinds, key=lambda kind: (counts[kind] >= FEWEST_CASES, spent[kind])))
    return cases


def replay(kind: str, number: int, seed: int) -> Case:
    """Try one case of a kind of `KINDS` again.

    Raises
    ------
    InputError
        There is no such kind.
    """
    if kind not in KINDS:
        raise InputError(f"found the kind '{kind}'; {nearest(kind, KINDS)}")
    return _tried(kind, KINDS[kind], seed, number)


def _tried(kind: str, function: CaseFunction, seed: int, number: int) -> Case:
    begin, refusal, error = _processor_seconds(), "", ""
    measures: Measures = {}
    try:
        with np.errstate(all="ignore"):
            outcome = function(np.random.default_rng([seed, number]))
    except Exception as raised:
        error = f"{type(raised).__name__}: {raised}"
    else:
        if isinstance(outcome, str):
            refusal = outcome
        else:
            measures = outcome
    return Case(kind, number, seed, measures, refusal, error, _processor_seconds() - begin)


def worst_first(cases: Sequence[Case]) -> list[tuple[Case, str]]:
    """Case of each kind and measure that uses most of the limit, with the measure; the worst of all first."""
    worst: dict[tuple[str, str], Case] = {}
    for case in cases:
        for name, values in case.measures.items():
            known = worst.get((case.kind, name))
            if known is None or share_of_limit(*values) > share_of_limit(*known.measures[name]):
                worst[case.kind, name] = case
    rows = [(case, name) for (_, name), case in worst.items()]
    return sorted(rows, key=lambda row: share_of_limit(*row[0].measures[row[1]]), reverse=True)


def described(cases: Sequence[Case], seed: int) -> dict[str, Any]:
    """Cases as plain values: what ``mat bench stability --json`` prints."""
    kinds = dict.fromkeys(case.kind for case in cases)
    return {
        "seed": seed,
        "kinds": {
            kind: {
                "cases": len(of_kind),
                "refused": sum(bool(case.refusal) for case in of_kind),
                "failures": [line for case in of_kind for line in case.failures],
                "time": quantity(sum(case.seconds for case in of_kind), "s"),
                "slowest": quantity(max(case.seconds for case in of_kind), "s"),
            }
            for kind in kinds
            for of_kind in [[case for case in cases if case.kind == kind]]
        },
        "worst": [_described(case, name) for case, name in worst_first(cases)],
        "cases": [
            _described(case, case.worst) if case.measures else _named(case) | {"refused": case.refusal or case.error}
            for case in sorted(cases, key=lambda case: _used(case), reverse=True)
        ],
    }


def _used(case: Case) -> float:
    return share_of_limit(*case.measures[case.worst]) if case.measures else (np.inf if case.error else 0.0)


def _named(case: Case) -> dict[str, Any]:
    return {"kind": case.kind, "again": case.again, "time": quantity(case.seconds, "s")}


def _described(case: Case, name: str) -> dict[str, Any]:
    value, limit = (float(number) for number in case.measures[name])
    finite = bool(np.isfinite(value))
    return {
        "measure": name,
        "value": value if finite else None,
        "limit": limit,
        "margin": limit - value if finite else None,
        **_named(case),
    }


def _processor_seconds() -> float:
    """Processor seconds of this process and of those of its children that have ended, where the system counts them."""
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


KINDS: dict[str, CaseFunction] = {
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
