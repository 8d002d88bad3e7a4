"""Periodic surface temperatures of whole batches of columns, with the next sturdier method where one does not hold.

The problem of a column is f(T) + C T = source for N temperatures of a period: f the nonlinear `Balance`, C the
exact `Conduction`, source what the back brings (`BackFlux`). A batch is iterated with one matrix (diag(g) + C)^-1,
g(t) the batch's mean slope of f, and Anderson acceleration; what does not settle goes to damped Newton; what breaks
the maximum principle is solved again by backward Euler.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np

from skyshine.mat.surface.back import BackFlux
from skyshine.mat.surface.balance import MELTING_POINT, Balance, Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.newton import DENSE_STEPS, solve_newton
from skyshine.schemas.errors import CheckFailed

DAY = 86400.0  # s, the mean solar day
FINE_STEPS = 288
# Largest residual of the balance at any time [W m^-2]: with at least 2 W m^-2 K^-1 of convection below 1 mK.
TOLERANCE = 1e-3
# Excess over the maximum principle [K] at which a column goes to backward Euler, which cannot exceed it.
BOUND_TOLERANCE = 0.1
# Temperatures iterated together: some 300 kB an array, so that a handful stays in a core's second-level cache.
_CHUNK = 384 * 96
_ITERATIONS = 16
_MELTING_ITERATIONS = 60
_SAMPLE, _RENEWALS = 32, 3  # columns and matrices from which a material's relaxation is found
# Least spread of the slope of f over columns that is reckoned with [W m^-2 K^-1].
_LEAST_SPREAD = 0.5


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
        coarse = Conduction(material.thermal, fine, period, scheme)
        forcing = forcing_at(fine)
    first = _solve(material, forcing, coarse, Method.BDF2 if coarse.steps == steps else Method.BDF2_FINE, start_hour)
    broken = np.flatnonzero(first.bound_excess > BOUND_TOLERANCE)
    if scheme != "bdf2" or not broken.size:
        return [(np.arange(len(first.residual)), first)]
    euler = Conduction(material.thermal, fine, period, "euler")
    second = _solve(material, forcing_at(fine).columns(broken), euler, Method.EULER, start_hour, names=broken)
    kept = np.setdiff1d(np.arange(len(first.residual)), broken)
    return [(kept, _take(first, kept)), (broken, second)]


def _settles_slowly(material: SurfaceMaterial, forcing: Forcing, conduction: Conduction) -> bool:
    """Whether the surface takes longer than a step to follow the weather, at air temperature in a sample of columns."""
    balance = Balance(forcing.columns(_sampled(forcing.shape[0])), material)
    _, slope = balance.loss_and_slope(_first_guess(balance))
    return conduction.response_time_exceeds(float(np.median(slope)))


def _sampled(columns: int) -> np.ndarray:
    """Indices of columns that stand for all."""
    return np.unique(np.linspace(0, columns - 1, min(columns, _SAMPLE)).astype(int))


def _solve(material, forcing: Forcing, conduction: Conduction, method: Method, start_hour: float, names=None) -> Solution:
    """Solve all columns by one scheme, chunk by chunk."""
    columns = forcing.shape[0]
    names = np.arange(columns) if names is None else names
    hours = start_hour + np.arange(conduction.steps) * (conduction.period / conduction.steps / 3600.0)
    back = BackFlux.of(material, forcing, conduction, hours)
    relaxation = None if conduction.steps > DENSE_STEPS else _Relaxation.of(material, forcing, conduction, back.source)
    parts = []
    size = max(1, _CHUNK // conduction.steps)
    for start in range(0, columns, size):
        chosen = slice(start, min(start + size, columns))
        parts.append(
            _solve_chunk(
                material, forcing.columns(chosen), back.columns(chosen), conduction, relaxation, method, names[chosen]
            )
        )
    return Solution(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Solution)))


def _take(solution: Solution, rows) -> Solution:
    return Solution(*(getattr(solution, field.name)[rows] for field in fields(Solution)))


def _solve_chunk(
    material, forcing: Forcing, back: BackFlux, conduction: Conduction, relaxation, method: Method, names
) -> Solution:
    balance, source = Balance(forcing, material), back.source
    cap = _cap(material)
    if relaxation is None:
        temperature, iterations = _first_guess(balance), np.zeros(len(names), np.int32)
    else:
        temperature, iterations = relaxation.iterate(balance, source)
    if cap is not None:
        temperature = np.minimum(temperature, cap)
    loss, imbalance = _imbalance(balance, conduction, source, temperature)
    melt = np.zeros_like(temperature) if cap is None else np.where(temperature >= cap, np.maximum(-imbalance, 0.0), 0.0)
    unsettled = ~(np.abs(imbalance + melt).max(axis=1) <= TOLERANCE)
    methods = np.full(len(names), method, np.uint8)
    rest = np.flatnonzero(unsettled)
    if rest.size:
        some = balance.columns(rest)
        start = temperature[rest]
        lost = ~np.all((start > 1.0) & (start < 3000.0), axis=1)
        start[lost] = _first_guess(some)[lost]
        result = solve_newton(some, conduction, source[rest], start, cap, TOLERANCE)
        _refuse_unsettled(result.residual, material, conduction, names[rest])
        temperature[rest], melt[rest] = result.temperature, result.melt
        iterations[rest] += result.iterations
        methods[rest] = Method(method + 1)
        loss, imbalance = _imbalance(balance, conduction, source, temperature)
    return Solution(
        temperature,
        melt,
        np.abs(imbalance + melt).max(axis=1),
        (loss + melt).mean(axis=1) + conduction.steady_conductance * temperature.mean(axis=1) - source.mean(axis=1),
        bound_excess(balance, temperature, loss, back, cap),
        methods,
        iterations,
    )


def _imbalance(balance: Balance, conduction: Conduction, source, temperature) -> tuple[np.ndarray, np.ndarray]:
    """f(T), and f(T) + C T - source [W m^-2], each (columns, N)."""
    loss = balance.loss(temperature)
    flux = conduction.flux(temperature)
    flux += loss
    flux -= source
    return loss, flux


def _refuse_unsettled(residual, material, conduction, names) -> None:
    wrong = ~(residual <= TOLERANCE)
    if np.any(wrong):
        worst = int(np.argmax(np.where(np.isfinite(residual), residual, np.inf)))
        raise ConvergenceError(
            f"material '{material.name}', column {names[worst]}: damped Newton with {conduction.steps} steps "
            f"({conduction.scheme}) stopped at a residual of {residual[worst]:.3g} W/m2 (allowed: {TOLERANCE:g}); "
            f"check the material's numbers and the weather of this column"
        )


def _first_guess(balance: Balance) -> np.ndarray:
    """Air temperature; without air the temperature that radiates the mean of what is absorbed."""
    if balance.airless:
        mean = np.mean(balance.absorbed + np.zeros(balance.shape), axis=1, keepdims=True)
        radiator = (np.maximum(mean, 1e-6) / max(balance.emission, 1e-12)) ** 0.25
        return np.clip(radiator, 3.0, 2000.0) + np.zeros(balance.shape)
    return balance.air_temperature + np.zeros(balance.shape)


@dataclass(frozen=True, eq=False)
class _Relaxation:
    """One matrix (diag(g) + C)^-1 for all columns of a material, and where to start from.

    Attributes
    ----------
    slope : ndarray, shape (N,)
        g, the mean slope of f over columns at about their solution [W m^-2 K^-1].
    inverse : ndarray, shape (N, N)
        Transposed, for temperatures in rows.
    change_tolerance : float
        A change [K] after which the residual is within the tolerance.
    start : ndarray, shape (1, N), or None
        Mean temperature of the sample [K].
    cap : float or None
        Temperature T_m that the surface cannot exceed [K]. The unknown is then u, of which T = min(u, T_m) is the
        temperature and `melting` (u - T_m) the heat spent on melting where u exceeds T_m.
    melting : float
        [W m^-2 K^-1]
    """

    slope: np.ndarray
    inverse: np.ndarray
    change_tolerance: float
    start: np.ndarray | None
    cap: float | None
    melting: float

    @classmethod
    def of(cls, material, forcing: Forcing, conduction: Conduction, source: np.ndarray) -> _Relaxation:
        """The relaxation that suits a sample of the columns, found by solving it with a few renewed matrices."""
        sample = _sampled(forcing.shape[0])
        balance = Balance(forcing.columns(sample), material)
        source = source[sample]
        temperature, start = _first_guess(balance), None
        cap = _cap(material)
        for _ in range(_RENEWALS):
            _, slopes = balance.loss_and_slope(temperature if cap is None else np.minimum(temperature, cap))
            slope = np.maximum(slopes.mean(axis=0), 1e-3)
            inverse = np.linalg.inv(conduction.matrix + np.diag(slope)).T
            # Between the least and the largest stiffness of a wave: both of them converge then.
            ends = slope.mean() + conduction.admittance.real[[0, -1]]
            melting = 2 * ends.prod() / ends.sum()
            # After a step the imbalance is the change times what the slope is wrong by; melting, the whole stiffness.
            wrong = np.abs(slopes - slope).max() if cap is None else 0.25 * (slope.max() + conduction.matrix[0, 0])
            settled = 0.5 * TOLERANCE / max(wrong, _LEAST_SPREAD)
            relaxation = cls(slope, inverse, settled, start, cap, float(melting))
            found, _ = relaxation.iterate(balance, source, temperature, iterations=2)
            if not np.all((found > 1.0) & (found < 3000.0)):
                break
            temperature, start = found, found.mean(axis=0, keepdims=True)
        return relaxation

    def iterate(self, balance: Balance, source, temperature=None, iterations: int | None = None):
        """Accelerated fixed-point iteration; temperatures (columns, N), which may not have settled, and counts."""
        if temperature is None:
            temperature = _first_guess(balance) if self.start is None else np.repeat(self.start, len(source), axis=0)
        memory = _Anderson()
        for count in range(1, (iterations or (_ITERATIONS if self.cap is None else _MELTING_ITERATIONS)) + 1):
            target = self._relaxed(balance, source, temperature)
            change = target - temperature
            largest = max(change.max(), -change.min())
            if largest < self.change_tolerance:
                temperature = target
                break
            if not largest < 1e6:
                break
            temperature = memory.next(target, change)
        return temperature, np.full(len(temperature), count, np.int32)

    def _relaxed(self, balance: Balance, source, temperature: np.ndarray) -> np.ndarray:
        """The unknown less the relaxed imbalance."""
        excess = 0.0
        if self.cap is not None:
            excess = np.maximum(temperature - self.cap, 0.0)
            temperature = np.minimum(temperature, self.cap)
        target = temperature * self.slope
        target -= balance.loss(temperature)
        target += source
        if self.cap is not None:
            target -= self.melting * excess
        target = target @ self.inverse
        if self.cap is not None:
            target += excess
        return target


def _cap(material: SurfaceMaterial) -> float | None:
    """Temperature that the surface cannot exceed [K]."""
    return MELTING_POINT if material.surface.snow else None


class _Anderson:
    """Anderson acceleration of depth two, each column its own.

    References
    ----------
    Walker and Ni (2011), Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, 1715-1735.
    """

    def __init__(self):
        self.target = self.change = None
        self.steps: list[tuple[np.ndarray, np.ndarray]] = []

    def next(self, target: np.ndarray, change: np.ndarray) -> np.ndarray:
        """The next iterate from G(x) and G(x) - x; `target` and `change` are kept, not copied."""
        if self.target is not None:
            self.steps = [(target - self.target, change - self.change), *self.steps[:1]]
        self.target, self.change = target, change
        if not self.steps:
            return target
        new, bend = self.steps[0]
        first = _dot(bend, bend)
        with np.errstate(divide="ignore", invalid="ignore"):
            if len(self.steps) == 1:
                weights = [_dot(bend, change) / first]
            else:
                weights = self._two(first, bend, change)
        result = target.copy()
        for weight, (step, _) in zip(weights, self.steps, strict=True):
            result -= np.where(np.isfinite(weight), weight, 0.0)[:, None] * step
        return result

    def _two(self, first, bend, change) -> list[np.ndarray]:
        older = self.steps[1][1]
        second, cross = _dot(older, older), _dot(bend, older)
        right, right_older = _dot(bend, change), _dot(older, change)
        determinant = first * second - cross**2
        # Nearly parallel differences carry one direction only.
        single = determinant < 1e-8 * first * second
        one = np.where(single, right / first, (second * right - cross * right_older) / determinant)
        two = np.where(single, 0.0, (first * right_older - cross * right) / determinant)
        return [one, two]


def _dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.einsum("ct,ct->c", one, other)


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
        time = np.argmax(sign * temperature, axis=1)[:, None]
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
