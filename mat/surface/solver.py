"""Periodic surface temperatures of whole batches of columns, by a sturdier method where the first fails.

The problem of a column is f(T) + C T = source for N temperatures of a period: f the nonlinear `Balance`, C the
exact `Conduction`, source the flux from the back (`BackFlux`). A batch is iterated with one matrix (`Relaxation`); an
iteration in fine steps begins at the solution in coarse ones. Columns that do not settle go to damped Newton; columns
that break the maximum principle are solved again by backward Euler.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.back_boundary import BackFlux
from skyshine.mat.surface.balance import Balance, Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.film import solve_with_film
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.newton import DENSE_STEPS, HeatLoss, solve_newton
from skyshine.mat.surface.relaxation import (
    TOLERANCE,
    Relaxation,
    first_guess,
    imbalance_of,
    melting_cap,
    plausible,
    sampled,
)
from skyshine.mat.surface.solution import Method, Solution
from skyshine.schemas.arrays import Floats, Integers, Reals
from skyshine.schemas.errors import CheckFailed, InputError

DAY = 86400.0  # s, the mean solar day
# Steps of a day. On all library materials 192 err by .009 K rms against 576; 96 with 288 for thin surfaces err by .023
# K at .9 times the cost, and 192 with 288 for thin surfaces gain .002 K at 1.5 times the cost.
STEPS = 192
FINE_STEPS = 288  # of responses, which a shadow of minutes begins and ends
# Excess over the maximum principle [K] at which a column goes to backward Euler, which cannot exceed it.
BOUND_TOLERANCE = 0.1
# Temperatures iterated together: some 300 kB an array, so that a handful stays in a core's second-level cache.
_CHUNK = 384 * 96


class ConvergenceError(CheckFailed):
    """A column that no method solves."""


def solve_columns(
    material: SurfaceMaterial,
    forcing_at: Callable[[int], Forcing],
    *,
    steps: int = STEPS,
    fine_steps: int | None = STEPS,
    period: float = DAY,
    scheme: str = "bdf2",
    start_hour: float = 0.0,
) -> list[tuple[Integers, Solution]]:
    """Solve all columns of a material.

    Parameters
    ----------
    material : SurfaceMaterial
    forcing_at : callable
        Gives the `Forcing` of all columns at k / N of the period for a number of steps N.
    steps : int
        N to begin with.
    fine_steps : int or None
        N for surfaces that follow their forcing within a step, and for backward Euler, where it is more than `steps`;
        None: `steps`.
    period : float
        [s]
    scheme : str
        Time scheme to begin with; "spectral" is for verification and skips the sturdier ones.
    start_hour : float
        Clock hour at which the period begins, for a back that is given by hour.

    Returns
    -------
    list of (index, Solution)
        The columns of each Solution, together all columns once and none empty. They may differ in N.

    Raises
    ------
    InputError
        The forcing holds values that no balance can have.
    ConvergenceError
        No method solves a column.
    """
    if material.canopy is not None:
        raise InputError(f"found '{material.name}' with gaps between its leaves; allowed: a skin; see `solve_canopy`")
    fine = max(fine_steps or steps, steps)
    coarse = Conduction(material.thermal, steps, period, scheme)
    forcing = forcing_at(steps)
    forcing.check()
    columns = np.arange(forcing.shape[0])
    if fine > steps and scheme == "bdf2" and not settles_slowly(material, forcing, coarse):
        start = _approach(material, forcing, coarse, start_hour)
        finer = Conduction(material.thermal, fine, period, scheme)
        first = _solve_from(material, forcing_at(fine), finer, Method.BDF2_FINE, start_hour, columns, start)
    else:
        first = _solve_from(material, forcing, coarse, Method.BDF2, start_hour, columns)
    broken = np.flatnonzero(first.bound_excess > BOUND_TOLERANCE)
    if scheme != "bdf2" or not broken.size:
        return [(columns, first)]
    euler = Conduction(material.thermal, fine, period, "euler")
    second = _solve_from(material, forcing_at(fine).columns(broken), euler, Method.EULER, start_hour, broken)
    kept = np.setdiff1d(columns, broken)
    return [(kept, first.columns(kept)), (broken, second)] if kept.size else [(broken, second)]


def settles_slowly(material: SurfaceMaterial, forcing: Forcing, conduction: Conduction) -> bool:
    """Whether the surface takes longer than a step to follow the weather, at air temperature in a sample of columns."""
    balance = Balance(forcing.columns(sampled(forcing.shape[0])), material)
    _, slope = balance.loss_and_slope(first_guess(balance))
    return conduction.response_time_exceeds(float(np.median(slope)))


def _solve_from(
    material: SurfaceMaterial,
    forcing: Forcing,
    conduction: Conduction,
    method: Method,
    start_hour: float,
    names: Integers,
    start: Reals | None = None,
) -> Solution:
    """`solve_by` in a period that begins at an hour."""
    back_flux = BackFlux.of(material, forcing, conduction, clock(conduction, start_hour))
    return solve_by(material, forcing, conduction, back_flux, method, names, start)


def solve_by(
    material: SurfaceMaterial,
    forcing: Forcing,
    conduction: Conduction,
    back_flux: BackFlux,
    method: Method,
    names: Integers,
    start: Reals | None = None,
    film_before: Floats | None = None,
) -> Solution:
    """Solve all columns by one scheme, chunk by chunk; where there may be water on them, as often as it settles.

    Parameters
    ----------
    material : SurfaceMaterial
    forcing : Forcing
    conduction : Conduction
    back_flux : BackFlux
    method : Method
        That of the scheme, without Newton.
    names : (columns,) ndarray
        Numbers of the columns in messages.
    start : (columns, fewer steps) ndarray, optional
        Temperatures [K] to begin with.
    film_before : (columns,) ndarray, optional
        Water on the surface when a day begins [kg m^-2]; by default that with which the period ends.

    Raises
    ------
    ConvergenceError
        No method solves a column.
    """
    if material.film is None or forcing.rain is None or not np.any(forcing.pressure):
        return _solve_chunks(material, forcing, conduction, back_flux, method, names, start)

    def solve(part: Forcing, chosen: Integers) -> Solution:
        first = None if start is None else start[chosen]
        return _solve_chunks(material, part, conduction, back_flux.columns(chosen), method, names[chosen], first)

    return solve_with_film(material, forcing, conduction.period / conduction.steps, solve, film_before)


def _solve_chunks(
    material: SurfaceMaterial,
    forcing: Forcing,
    conduction: Conduction,
    back_flux: BackFlux,
    method: Method,
    names: Integers,
    start: Reals | None,
) -> Solution:
    """`solve_by` with the film of the forcing, if it has one."""
    relaxation = None
    if conduction.steps <= DENSE_STEPS:
        relaxation = Relaxation.of(material, forcing, conduction, back_flux.source, start)
    parts = [
        _solve_chunk(
            material,
            Balance(forcing.columns(chosen), material),
            back_flux.columns(chosen),
            conduction,
            relaxation,
            method,
            names[chosen],
            None if start is None else start[chosen],
        )
        for chosen in _chunks(*forcing.shape)
    ]
    return Solution(**{name: np.concatenate([part.given[name] for part in parts]) for name in parts[0].given})


def _chunks(columns: int, steps: int) -> list[slice]:
    size = max(1, _CHUNK // steps)
    return [slice(start, min(start + size, columns)) for start in range(0, columns, size)]


def clock(conduction: Conduction, start_hour: float = 0.0) -> Floats:
    """Clock hours (N,) of the times of the period."""
    return start_hour + np.arange(float(conduction.steps)) * (conduction.period / conduction.steps / 3600.0)


def _approach(
    material: SurfaceMaterial, forcing: Forcing, conduction: Conduction, start_hour: float
) -> npt.NDArray[np.float32] | None:
    """Temperatures (columns, N) [K] from which finer steps begin; None where the iteration diverges."""
    source = BackFlux.of(material, forcing, conduction, clock(conduction, start_hour)).source
    relaxation = Relaxation.of(material, forcing, conduction, source)
    temperature = np.empty(forcing.shape, np.float32)
    for chosen in _chunks(*forcing.shape):
        temperature[chosen], _ = relaxation.approach(Balance(forcing.columns(chosen), material), source[chosen])
    return temperature if np.all(plausible(temperature)) else None


def _solve_chunk(
    material: SurfaceMaterial,
    balance: Balance,
    back_flux: BackFlux,
    conduction: Conduction,
    relaxation: Relaxation | None,
    method: Method,
    names: Integers,
    start: Reals | None,
) -> Solution:
    source, cap = back_flux.source, melting_cap(material)
    temperature: Floats
    loss: Reals
    iterations: Integers
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
    unsettled = np.flatnonzero(~(residual <= TOLERANCE))
    if unsettled.size:
        unsettled_balance = balance.columns(unsettled)
        guess = temperature[unsettled]
        diverged = ~plausible(guess)
        guess[diverged] = first_guess(unsettled_balance)[diverged]
        result = solve_newton(unsettled_balance, conduction, source[unsettled], guess, cap, TOLERANCE)
        _refuse_unsettled(result.residual, material, conduction, names[unsettled])
        temperature[unsettled], melt[unsettled] = result.temperature, result.melt
        residual[unsettled] = result.residual
        iterations[unsettled] += result.iterations
        methods[unsettled] = Method(method + 1)
        loss[unsettled] = unsettled_balance.loss(result.temperature)
    return Solution(
        temperature,
        melt,
        residual,
        (loss + melt).mean(axis=1) + conduction.mean_flux(temperature) - source.mean(axis=1),
        bound_excess(balance, temperature, loss, back_flux, cap),
        methods,
        iterations,
    )


def _refuse_unsettled(residual: Floats, material: SurfaceMaterial, conduction: Conduction, names: Integers) -> None:
    wrong = ~(residual <= TOLERANCE)
    if np.any(wrong):
        worst = int(np.argmax(np.where(np.isfinite(residual), residual, np.inf)))
        raise ConvergenceError(
            f"material '{material.name}', column {names[worst]}: damped Newton with {conduction.steps} steps "
            f"({conduction.scheme}) stopped at a residual of {residual[worst]:.3g} W/m2 (allowed: {TOLERANCE:g}); "
            "check the material's numbers and the weather of this column"
        )


def bound_excess(balance: HeatLoss, temperature: Floats, loss: Reals, back_flux: BackFlux, cap: float | None) -> Floats:
    """How far temperatures leave the range that the maximum principle of heat conduction allows.

    Parameters
    ----------
    balance : HeatLoss
    temperature, loss : (columns, N) ndarray
        [K], and f of it [W m^-2].
    back_flux : BackFlux
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
    for sign, behind, heat in (
        (1, back_flux.highest, back_flux.heat[1]),
        (-1, back_flux.lowest, back_flux.heat[0]),
    ):
        time = (np.argmax if sign > 0 else np.argmin)(temperature, axis=1)[:, None]
        extreme = np.take_along_axis(temperature, time, axis=1)
        doubtful = (sign * (np.take_along_axis(loss, time, axis=1) - heat) > 0) & (sign * (extreme - behind) > 0)
        if cap is not None and sign < 0:
            doubtful &= extreme < cap
        rows = np.flatnonzero(doubtful)
        if not rows.size:
            continue
        doubtful_balance = balance.columns(rows)
        net, slope = doubtful_balance.loss_and_slope(extreme[rows] + np.zeros(doubtful_balance.shape))
        beyond = np.min(sign * (net - heat) / np.maximum(slope, 1e-3), axis=1)
        beyond = np.minimum(beyond, sign * (extreme - behind)[rows, 0])
        if cap is not None and sign < 0:
            beyond = np.minimum(beyond, cap - extreme[rows, 0])
        excess[rows] = np.maximum(excess[rows], beyond)
    return excess
