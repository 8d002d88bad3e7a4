"""Periodic surface temperatures of whole batches of columns, with the next sturdier method where one does not hold.

The problem of a column is f(T) + C T = source for N temperatures of a period: f the nonlinear `Balance`, C the
exact `Conduction`, source what the back brings (`BackFlux`). A batch is iterated with one matrix (`Relaxation`), fine
steps from what fewer have found; what does not settle goes to damped Newton; what breaks the maximum principle is
solved again by backward Euler.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np

from skyshine.mat.surface.back_boundary import BackFlux
from skyshine.mat.surface.balance import Balance, Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.newton import DENSE_STEPS, solve_newton
from skyshine.mat.surface.relaxation import TOLERANCE, Relaxation, first_guess, imbalance_of, melting_cap, sampled
from skyshine.schemas.errors import CheckFailed

DAY = 86400.0  # s, the mean solar day
FINE_STEPS = 288
# Excess over the maximum principle [K] at which a column goes to backward Euler, which cannot exceed it.
BOUND_TOLERANCE = 0.1
# Temperatures iterated together: some 300 kB an array, so that a handful stays in a core's second-level cache.
_CHUNK = 384 * 96


class Method(IntEnum):
    """How a column was solved."""

    BDF2 = 0
    BDF2_NEWTON = 1
    BDF2_FINE = 2
    BDF2_FINE_NEWTON = 3
    EULER = 4
    EULER_NEWTON = 5
    GIVEN = 6  # not solved: the temperature was given


@dataclass(frozen=True, eq=False)
class Solution:
    """Surface temperatures and what is known of their quality.

    Attributes
    ----------
    temperature : ndarray, shape (columns, N)
        [K] at k / N of the period, k = 0 ... N - 1.
    melt : ndarray, shape (columns, N)
        Heat spent on melting snow [W m^-2].
    residual : ndarray, shape (columns,)
        Largest imbalance at any time [W m^-2].
    energy_closure : ndarray, shape (columns,)
        Mean over the period of all fluxes [W m^-2]; 0 where the energy closes.
    bound_excess : ndarray, shape (columns,)
        How far the temperature leaves the range of its instantaneous equilibria and the back [K].
    method : ndarray of uint8, shape (columns,)
        A `Method`.
    iterations : ndarray of int32, shape (columns,)
        Beyond those that found the material's common matrix and starting point.
    """

    temperature: np.ndarray
    melt: np.ndarray
    residual: np.ndarray
    energy_closure: np.ndarray
    bound_excess: np.ndarray
    method: np.ndarray
    iterations: np.ndarray


class ConvergenceError(CheckFailed):
    """A column that no method solves."""


def solve_columns(
    material: SurfaceMaterial,
    forcing_at: Callable[[int], Forcing],
    *,
    steps: int = 96,
    fine_steps: int | None = FINE_STEPS,
    period: float = DAY,
    scheme: str = "bdf2",
    start_hour: float = 0.0,
) -> list[tuple[np.ndarray, Solution]]:
    """Solve all columns of a material.

    Parameters
    ----------
    material : SurfaceMaterial
    forcing_at : callable
        Gives the `Forcing` of all columns at k / N of the period for a number of steps N.
    steps : int
        N to begin with.
    fine_steps : int or None
        N for surfaces that follow their forcing within a step, and for backward Euler; None: `steps`.
    period : float
        [s]
    scheme : str
        Time scheme to begin with; "spectral" is for verification and skips the sturdier ones.
    start_hour : float
        Clock hour at which the period begins, for a back that is given by hour.

    Returns
    -------
    list of (index, Solution)
        The columns of each Solution, together all columns once. They may differ in N.

    Raises
    ------
    InputError
        The forcing holds values that no balance can have.
    ConvergenceError
        No method solves a column.
    """
    fine = max(fine_steps or steps, steps)
    coarse = Conduction(material.thermal, steps, period, scheme)
    forcing = forcing_at(steps)
    forcing.check()
    if fine > steps and scheme == "bdf2" and not _settles_slowly(material, forcing, coarse):
        start = _approach(material, forcing, coarse, start_hour)
        first = _solve(
            material,
            forcing_at(fine),
            Conduction(material.thermal, fine, period, scheme),
            Method.BDF2_FINE,
            start_hour,
            start=start,
        )
    else:
        first = _solve(material, forcing, coarse, Method.BDF2, start_hour)
    broken = np.flatnonzero(first.bound_excess > BOUND_TOLERANCE)
    if scheme != "bdf2" or not broken.size:
        return [(np.arange(len(first.residual)), first)]
    euler = Conduction(material.thermal, fine, period, "euler")
    second = _solve(material, forcing_at(fine).columns(broken), euler, Method.EULER, start_hour, names=broken)
    kept = np.setdiff1d(np.arange(len(first.residual)), broken)
    return [(kept, _take(first, kept)), (broken, second)]


def _settles_slowly(material: SurfaceMaterial, forcing: Forcing, conduction: Conduction) -> bool:
    """Whether the surface takes longer than a step to follow the weather, at air temperature in a sample of columns."""
    balance = Balance(forcing.columns(sampled(forcing.shape[0])), material)
    _, slope = balance.loss_and_slope(first_guess(balance))
    return conduction.response_time_exceeds(float(np.median(slope)))


def _solve(
    material, forcing: Forcing, conduction: Conduction, method: Method, start_hour: float, names=None, start=None
) -> Solution:
    """Solve all columns by one scheme, chunk by chunk, from temperatures (columns, fewer steps) if there are any."""
    columns = forcing.shape[0]
    names = np.arange(columns) if names is None else names
    back = BackFlux.of(material, forcing, conduction, _clock(conduction, start_hour))
    relaxation = None
    if conduction.steps <= DENSE_STEPS:
        relaxation = Relaxation.of(material, forcing, conduction, back.source, start)
    parts = []
    for chosen in _chunks(columns, conduction.steps):
        parts.append(
            _solve_chunk(
                material,
                forcing.columns(chosen),
                back.columns(chosen),
                conduction,
                relaxation,
                method,
                names[chosen],
                None if start is None else start[chosen],
            )
        )
    return Solution(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Solution)))


def _chunks(columns: int, steps: int) -> list[slice]:
    size = max(1, _CHUNK // steps)
    return [slice(start, min(start + size, columns)) for start in range(0, columns, size)]


def _clock(conduction: Conduction, start_hour: float) -> np.ndarray:
    """Clock hours (N,) of the times of the period."""
    return start_hour + np.arange(conduction.steps) * (conduction.period / conduction.steps / 3600.0)


def _approach(material, forcing: Forcing, conduction: Conduction, start_hour: float) -> np.ndarray | None:
    """Temperatures (columns, N) in single precision, to start finer steps from; None where they are not found."""
    source = BackFlux.of(material, forcing, conduction, _clock(conduction, start_hour)).source
    relaxation = Relaxation.of(material, forcing, conduction, source)
    found = np.empty(forcing.shape, np.float32)
    for chosen in _chunks(*forcing.shape):
        found[chosen], _ = relaxation.approach(Balance(forcing.columns(chosen), material), source[chosen])
    return found if np.all((found > 1.0) & (found < 3000.0)) else None


def _take(solution: Solution, rows) -> Solution:
    return Solution(*(getattr(solution, field.name)[rows] for field in fields(Solution)))


def _solve_chunk(
    material, forcing: Forcing, back: BackFlux, conduction: Conduction, relaxation, method: Method, names, start
) -> Solution:
    balance, source = Balance(forcing, material), back.source
    cap = melting_cap(material)
    if relaxation is None:
        temperature, iterations = first_guess(balance), np.zeros(len(names), np.int32)
        if cap is not None:
            temperature = np.minimum(temperature, cap)
        melt = np.zeros(temperature.shape)
        loss, imbalance = imbalance_of(balance, conduction, source, temperature)
    else:
        temperature, melt, loss, imbalance, iterations = relaxation.solve(balance, conduction, source, start)
    residual = np.abs(imbalance).max(axis=1)
    methods = np.full(len(names), method, np.uint8)
    rest = np.flatnonzero(~(residual <= TOLERANCE))
    if rest.size:
        some = balance.columns(rest)
        begin = temperature[rest]
        lost = ~np.all((begin > 1.0) & (begin < 3000.0), axis=1)
        begin[lost] = first_guess(some)[lost]
        result = solve_newton(some, conduction, source[rest], begin, cap, TOLERANCE)
        _refuse_unsettled(result.residual, material, conduction, names[rest])
        temperature[rest], melt[rest], residual[rest] = result.temperature, result.melt, result.residual
        iterations[rest] += result.iterations
        methods[rest] = Method(method + 1)
        loss[rest] = some.loss(result.temperature)
    return Solution(
        temperature,
        melt,
        residual,
        (loss + melt).mean(axis=1) + conduction.steady_conductance * temperature.mean(axis=1) - source.mean(axis=1),
        bound_excess(balance, temperature, loss, back, cap),
        methods,
        iterations,
    )


def _refuse_unsettled(residual, material, conduction, names) -> None:
    wrong = ~(residual <= TOLERANCE)
    if np.any(wrong):
        worst = int(np.argmax(np.where(np.isfinite(residual), residual, np.inf)))
        raise ConvergenceError(
            f"material '{material.name}', column {names[worst]}: damped Newton with {conduction.steps} steps "
            f"({conduction.scheme}) stopped at a residual of {residual[worst]:.3g} W/m2 (allowed: {TOLERANCE:g}); "
            "check the material's numbers and the weather of this column"
        )


def bound_excess(balance: Balance, temperature, loss, back: BackFlux, cap: float | None) -> np.ndarray:
    """How far temperatures leave what the maximum principle of heat conduction allows.

    Parameters
    ----------
    balance : Balance
    temperature, loss : (columns, N) ndarray
        [K], and f of it [W m^-2].
    back : BackFlux
    cap : float or None
        Melting point of a surface that cannot exceed it [K].

    Returns
    -------
    (columns,) ndarray
        [K]; 0 within the bounds. The surface cannot be warmer than both its back and the warmest instantaneous
        equilibrium f(T, t) = 0, nor colder than both; with heat q from inside the equilibria are those of f = max q and
        f = min q, whose steady profiles bound the solution. A column whose f at its warmest time does not exceed that
        is below the equilibrium of that time; for the others the distance is one Newton step of f at the nearest time.
    """
    excess = np.zeros(len(temperature))
    for sign, behind, heat in ((1, back.highest, back.heat[1]), (-1, back.lowest, back.heat[0])):
        time = (np.argmax if sign > 0 else np.argmin)(temperature, axis=1)[:, None]
        extreme = np.take_along_axis(temperature, time, axis=1)
        doubtful = (sign * (np.take_along_axis(loss, time, axis=1) - heat) > 0) & (sign * (extreme - behind) > 0)
        if cap is not None and sign < 0:
            doubtful &= extreme < cap
        rows = np.flatnonzero(doubtful)
        if not rows.size:
            continue
        some = balance.columns(rows)
        force, slope = some.loss_and_slope(extreme[rows] + np.zeros(some.shape))
        beyond = np.min(sign * (force - heat) / np.maximum(slope, 1e-3), axis=1)
        beyond = np.minimum(beyond, sign * (extreme - behind)[rows, 0])
        if cap is not None and sign < 0:
            beyond = np.minimum(beyond, cap - extreme[rows, 0])
        excess[rows] = np.maximum(excess[rows], beyond)
    return excess
