"""Periodic surface temperatures of whole batches of columns, by a sturdier method where the first fails.

The problem of a column is f(T) + C T = source for N temperatures of a period: f the nonlinear `Balance`, C the
exact `Conduction`, source the flux from the back (`BackFlux`). A batch is iterated with one matrix (`Relaxation`); an
iteration begins at the solution in coarse steps. Columns that do not settle go to damped Newton. The scheme that is
exact for each wave of the day needs fewest steps; columns that break the maximum principle by it are solved again by
BDF2 in finer steps, and those that still do by backward Euler.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skyshine.mat.surface.back_boundary import BackFlux
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.film import WetSkin, solve_with_film
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.newton import DENSE_STEPS, HeatFlux, HeatLoss, solve_newton
from skyshine.mat.surface.relaxation import (
    TOLERANCE,
    Relaxation,
    first_guess,
    imbalance_of,
    melting_cap,
    plausible,
)
from skyshine.mat.surface.solution import Method, Solution
from skyshine.schemas.arrays import Floats, Integers, Reals
from skyshine.schemas.errors import CheckFailed, InputError

DAY = 86400.0  # s, the mean solar day
# Steps of a day. Of a fourth of the library on 40 planes, read between these times, 96 err by 0.010 / 0.040 / 0.30 K
# (rms / 99 % / largest) against 576, 144 by 0.004 / 0.015 / 0.15 K, 192 by 0.002 / 0.006 / 0.09 K; BDF2 with 192 as 96.
STEPS = 96
STURDY_STEPS = 192  # steps of BDF2 and backward Euler, which need twice as many for the same error
FINE_STEPS = 288  # steps of responses, which a shadow of minutes begins and ends
# Schemes by the first of them, from exact to sturdy.
SCHEMES = {"spectral": ("spectral", "bdf2", "euler"), "bdf2": ("bdf2", "euler"), "euler": ("euler",)}
METHODS = {"spectral": Method.SPECTRAL, "bdf2": Method.BDF2, "euler": Method.EULER}
# Excess over the maximum principle [K] at which a column goes to the next scheme; backward Euler cannot exceed it.
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
    fine_steps: int | None = STURDY_STEPS,
    period: float = DAY,
    scheme: str = "spectral",
    start_hour: float = 0.0,
) -> list[tuple[Integers, Solution]]:
    """Solve all columns of a material.

    Parameters
    ----------
    forcing_at : callable
        Gives the `Forcing` of all columns at k / N of the period for a number of steps N.
    steps : int
        N of the first scheme.
    fine_steps : int or None
        N of those that follow, where it is more than `steps`; None: `steps`.
    period : float
        [s]
    scheme : str
        Time scheme to begin with, of "spectral", "bdf2", "euler"; see `conduction.frequencies`.
    start_hour : float
        Clock hour at which the period begins, for a back that is given by hour.

    Returns
    -------
    list of (index, Solution)
        The columns of each Solution, together all columns once and none empty. They may differ in N.

    Raises
    ------
    InputError
        The forcing contains values that no balance can have.
    ConvergenceError
        No method solves a column.
    """
    if material.canopy is not None:
        raise InputError(f"found '{material.name}' with gaps between its leaves; allowed: a skin; see `solve_canopy`")
    fine = max(fine_steps or steps, steps)
    forcing_at(steps).check()

    def solve(name: str, chosen: Integers) -> Solution:
        count = steps if name == scheme else fine
        forcing = forcing_at(count)
        part = forcing if chosen.size == forcing.shape[0] else forcing.columns(chosen)
        return _solve_from(
            material, part, Conduction(material.thermal, count, period, name), METHODS[name], start_hour, chosen
        )

    return by_sturdier_schemes(scheme, forcing_at(steps).shape[0], solve)


def by_sturdier_schemes(
    scheme: str, columns: int, solve: Callable[[str, Integers], Solution]
) -> list[tuple[Integers, Solution]]:
    """Solutions by a scheme, of columns that break the maximum principle by the next; parts as of `solve_columns`.

    Parameters
    ----------
    scheme : str
        Scheme of the first attempt.
    solve : callable
        Solves an index array of columns by a scheme.
    """
    remaining, parts = np.arange(columns), list[tuple[Integers, Solution]]()
    for name in SCHEMES[scheme]:
        solution = solve(name, remaining)
        broken = (solution.bound_excess > BOUND_TOLERANCE) & (name != SCHEMES[scheme][-1])
        if not np.any(broken):
            return [*parts, (remaining, solution)]
        if not np.all(broken):
            parts.append((remaining[~broken], solution.columns(np.flatnonzero(~broken))))
        remaining = remaining[broken]
    return parts


def _solve_from(
    material: SurfaceMaterial,
    forcing: Forcing,
    conduction: Conduction,
    method: Method,
    start_hour: float,
    names: Integers,
) -> Solution:
    """`solve_by` in a period that begins at an hour."""
    back_flux = BackFlux.of(material, forcing, conduction, clock(conduction, start_hour))
    return solve_by(material, forcing, conduction, back_flux, method, names)


def solve_by(
    material: SurfaceMaterial,
    forcing: Forcing,
    conduction: Conduction,
    back_flux: BackFlux,
    method: Method,
    names: Integers,
    film_before: Floats | None = None,
) -> Solution:
    """Solve all columns by one scheme, chunk by chunk; where there may be water on them, as often as it settles.

    Parameters
    ----------
    method : Method
        Method of the scheme, without Newton iterations.
    names : (columns,) ndarray
        Numbers of the columns in messages.
    film_before : (columns,) ndarray, optional
        Water on the surface when a day begins [kg m^-2]; by default that with which the period ends.

    Raises
    ------
    ConvergenceError
        No method solves a column.
    """
    if material.film is None or forcing.rain is None or not np.any(forcing.pressure):
        return _solve_chunks(material, forcing, conduction, back_flux, method, names)

    def solve(part: Forcing, chosen: Integers) -> Solution:
        return _solve_chunks(material, part, conduction, back_flux.columns(chosen), method, names[chosen])

    return solve_with_film(WetSkin(material), forcing, conduction.period / conduction.steps, solve, film_before)


def _solve_chunks(
    material: SurfaceMaterial,
    forcing: Forcing,
    conduction: Conduction,
    back_flux: BackFlux,
    method: Method,
    names: Integers,
) -> Solution:
    """`solve_by` with the film of the forcing, if it has one."""
    relaxation = None
    if conduction.steps <= DENSE_STEPS:
        relaxation = Relaxation.of(material, forcing, conduction, back_flux.source)
    parts = [
        _solve_chunk(
            material,
            Balance(forcing.columns(chosen), material),
            back_flux.columns(chosen),
            conduction,
            relaxation,
            method,
            names[chosen],
        )
        for chosen in chunks(*forcing.shape)
    ]
    return Solution.stacked(parts)


def chunks(columns: int, steps: int) -> list[slice]:
    size = max(1, _CHUNK // steps)
    return [slice(start, min(start + size, columns)) for start in range(0, columns, size)]


def clock(conduction: Conduction, start_hour: float = 0.0) -> Floats:
    """Clock hours (N,) of the times of the period."""
    return start_hour + np.arange(float(conduction.steps)) * (conduction.period / conduction.steps / 3600.0)


def _solve_chunk(
    material: SurfaceMaterial,
    balance: Balance,
    back_flux: BackFlux,
    conduction: Conduction,
    relaxation: Relaxation | None,
    method: Method,
    names: Integers,
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
        temperature, melt, loss, imbalance, iterations = relaxation.solve(balance, conduction, source)
    residual = np.abs(imbalance).max(axis=1)
    methods = np.full(len(names), method, np.uint8)
    unsettled = np.flatnonzero(~(residual <= TOLERANCE))
    if unsettled.size:
        unsettled_balance = balance.columns(unsettled)
        guess = temperature[unsettled]
        diverged = ~plausible(guess)
        guess[diverged] = first_guess(unsettled_balance)[diverged]
        result = solve_newton(unsettled_balance, conduction, source[unsettled], guess, cap, TOLERANCE)
        refuse_unsettled(result.residual, material, conduction, names[unsettled])
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


def refuse_unsettled(residual: Floats, material: SurfaceMaterial, conduction: HeatFlux, names: Integers) -> None:
    """ConvergenceError where a residual (columns,) [W m^-2] of Newton's method exceeds the tolerance."""
    wrong = ~(residual <= TOLERANCE)
    if np.any(wrong):
        column = int(np.argmax(np.where(np.isfinite(residual), residual, np.inf)))
        raise ConvergenceError(
            f"material '{material.name}', column {names[column]}: damped Newton with {conduction.steps} steps "
            f"({conduction.scheme}) stopped at a residual of {residual[column]:.3g} W/m2 (allowed: {TOLERANCE:g}); "
            "check the material's numbers and the weather of this column"
        )


def bound_excess(balance: HeatLoss, temperature: Floats, loss: Reals, back_flux: BackFlux, cap: float | None) -> Floats:
    """How far temperatures leave the range that the maximum principle of heat conduction allows.

    Parameters
    ----------
    temperature, loss : (columns, N) ndarray
        [K], and f of it [W m^-2].
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
