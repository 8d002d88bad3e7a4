"""Damped Newton for the columns that the batch iteration does not settle, and for melting snow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from skyshine.mat.surface.conduction import Complexes
from skyshine.schemas.arrays import Booleans, Floats, Integers, Reals

_ITERATIONS = 80  # iterations of Newton's method, before a column is refused
_HALVINGS = 20  # halvings of a step: to 1e-6 of it
_LARGEST_STEP = 80.0  # K in one iteration
_LEAST_TEMPERATURE = 1.0  # K
_LEAST_SLOPE = 1e-3  # W m^-2 K^-1: keeps the matrix regular where radiation vanishes with T
_ARMIJO = 1e-4  # share of the decrease that a linear defect would show, which a damped step must reach
_MEMORY = 50_000_000  # elements of the batch of matrices solved at once: 400 MB
# Above this many steps a dense matrix costs more than Krylov iterations with fast Fourier transforms.
DENSE_STEPS = 1500


class HeatLoss(Protocol):
    """Net heat that leaves columns by their temperatures, each time by its own: a `Balance`, or what acts as one."""

    @property
    def shape(self) -> tuple[int, int]: ...

    def columns(self, chosen: slice | Integers) -> Self: ...

    def loss(self, temperature: Reals) -> Reals: ...

    def loss_and_slope(self, temperature: Reals) -> tuple[Reals, Reals]: ...


class HeatFlux(Protocol):
    """A linear operator on the temperatures of a column: `Conduction`, or what acts as it."""

    @property
    def steps(self) -> int: ...

    @property
    def scheme(self) -> str: ...

    @property
    def admittance(self) -> Complexes: ...

    @property
    def matrix(self) -> Floats: ...

    def flux(self, temperature: Reals) -> Floats: ...

    def relax(self, flux: Floats, conductance: float) -> Floats: ...


@dataclass(frozen=True, eq=False)
class NewtonResult:
    """Solution and its quality.

    Attributes
    ----------
    temperature : ndarray, shape (columns, N)
        [K]
    melt : ndarray, shape (columns, N)
        Heat spent on melting [W m^-2].
    residual : ndarray, shape (columns,)
        Largest imbalance at any time [W m^-2].
    iterations : ndarray of int32, shape (columns,)
    """

    temperature: Floats
    melt: Floats
    residual: Floats
    iterations: Integers


def solve_newton(
    balance: HeatLoss,
    conduction: HeatFlux,
    source: Floats,
    start: Floats,
    cap: float | None,
    tolerance: float,
) -> NewtonResult:
    """Solve f(T) + C T + m = source by damped Newton.

    Parameters
    ----------
    source : (columns, N or 1) ndarray
        [W m^-2]
    start : (columns, N) ndarray
        [K]
    cap : float or None
        Temperature T_m that the surface cannot exceed [K]: then m >= 0, T <= T_m and m (T_m - T) = 0, m being the heat
        spent on melting, whose water runs off and does not freeze again. Solved as max(F, k (T - T_m)) = 0 by the
        primal-dual active set method.
    tolerance : float
        [W m^-2]

    Returns
    -------
    NewtonResult
        The caller judges `residual`: columns beyond the tolerance have not converged.

    References
    ----------
    Hintermueller, Ito and Kunisch (2002), The primal-dual active set strategy as a semismooth Newton method,
    SIAM J. Optim. 13, 865-888.
    """
    temperature = start.copy() if cap is None else np.minimum(start, cap)
    iterations = np.zeros(len(temperature), np.int32)
    problem = _Problem(balance, conduction, source, cap)
    rows = np.arange(len(temperature))
    merit, defect, slope = problem.evaluate(temperature, rows)
    for _ in range(_ITERATIONS):
        active = np.flatnonzero(merit > 0.5 * tolerance)
        if not active.size:
            break
        step = problem.step(temperature[active], defect[active], slope[active])
        step *= np.minimum(1.0, _LARGEST_STEP / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
        moved = _damp(problem, temperature, step, active, merit)
        iterations[active] += 1
        if not moved.any():
            break
        merit, defect, slope = problem.evaluate(temperature, rows)
    temperature, melt, imbalance = problem.complementary(temperature)
    return NewtonResult(temperature, melt, np.abs(imbalance).max(axis=1), iterations)


def _damp(problem: _Problem, temperature: Floats, step: Floats, active: Integers, merit: Floats) -> Booleans:
    """Move the active columns along their steps, each by the longest halving that lowers its defect; which moved."""
    length = np.ones(len(active))
    pending = np.arange(len(active))
    moved = np.zeros(len(active), bool)
    for _ in range(_HALVINGS):
        rows = active[pending]
        trial = np.maximum(temperature[rows] + length[pending, None] * step[pending], _LEAST_TEMPERATURE)
        better = problem.evaluate(trial, rows)[0] < (1 - _ARMIJO * length[pending]) * merit[rows]
        temperature[rows[better]] = trial[better]
        moved[pending[better]] = True
        pending = pending[~better]
        if not pending.size:
            break
        length[pending] *= 0.5
    return moved


class _Problem:
    """The defect of a set of columns and the Newton matrix of each."""

    def __init__(self, balance: HeatLoss, conduction: HeatFlux, source: Floats, cap: float | None) -> None:
        self.balance, self.conduction, self.source, self.cap = balance, conduction, source, cap
        # Weight of the temperature condition against the heat condition: the stack's own stiffness.
        self.stiffness = 5.0 + float(conduction.admittance.real.mean())

    def imbalance(self, temperature: Floats) -> Floats:
        """f(T) + C T - source of all columns [W m^-2], (columns, N)."""
        imbalance: Floats = self.balance.loss(temperature) + self.conduction.flux(temperature) - self.source
        return imbalance

    def evaluate(self, temperature: Floats, rows: Integers) -> tuple[Floats, Floats, Reals]:
        """Largest |defect| (columns,), defect and slope (columns, N) of some columns at trial temperatures."""
        loss, slope = self.balance.columns(rows).loss_and_slope(temperature)
        defect = loss + self.conduction.flux(temperature) - self.source[rows]
        if self.cap is not None:
            defect = np.maximum(defect, self.stiffness * (temperature - self.cap))
        return np.abs(defect).max(axis=1), defect, np.maximum(slope, _LEAST_SLOPE)

    def complementary(self, temperature: Floats) -> tuple[Floats, Floats, Floats]:
        """Temperature with the melting times at the cap, melt, and the imbalance with it, each (columns, N).

        A melting time may still be a fraction of the tolerance away from the cap.
        """
        imbalance = self.imbalance(temperature)
        if self.cap is None:
            return temperature, np.zeros_like(temperature), imbalance
        melting = self._melting(temperature, imbalance)
        temperature = np.where(melting, self.cap, temperature)
        imbalance = self.imbalance(temperature)
        melt = np.where(melting, np.maximum(-imbalance, 0.0), 0.0)
        return temperature, melt, imbalance + melt

    def _melting(self, temperature: Floats, imbalance: Floats) -> Booleans:
        """The active set: where the temperature condition is the larger one, or the defect already equals it."""
        if self.cap is None:
            return np.zeros(temperature.shape, bool)
        melting: Booleans = imbalance <= self.stiffness * (temperature - self.cap)
        return melting

    def step(self, temperature: Floats, defect: Floats, slope: Reals) -> Floats:
        """The Newton step (columns, N) [K] of some columns from their temperature, defect and slope."""
        melting = self._melting(temperature, defect)
        if self.conduction.steps > DENSE_STEPS:
            return np.stack([self._krylov(*row) for row in zip(defect, slope, melting, strict=True)])
        size = max(1, _MEMORY // self.conduction.steps**2)
        parts = [slice(i, i + size) for i in range(0, len(defect), size)]
        return np.concatenate([self._dense(defect[part], slope[part], melting[part]) for part in parts])

    def _dense(self, defect: Floats, slope: Reals, melting: Booleans) -> Floats:
        matrix = np.repeat(self.conduction.matrix[None], len(defect), axis=0)
        matrix[melting] = 0.0
        diagonal = np.arange(self.conduction.steps)
        matrix[:, diagonal, diagonal] += np.where(melting, self.stiffness, slope)
        return np.linalg.solve(matrix, -defect[..., None])[..., 0].astype(float, copy=False)

    def _krylov(self, defect: Floats, slope: Reals, melting: Booleans) -> Floats:
        """The step (N,) of one column by GMRES on the times that do not melt.

        Melting times go to the cap whatever the others do. As unknowns of GMRES they would stop short of the cap by its
        tolerance, and their melt could not be distinguished from an imbalance.
        """
        from scipy.sparse.linalg import LinearOperator, gmres

        step: Floats = np.where(melting, -defect / self.stiffness, 0.0)
        active = np.flatnonzero(~melting)
        if not active.size:
            return step
        free_slope = slope[active]
        mean = float(np.mean(free_slope))

        def spread(vector: Floats) -> Floats:
            """A vector over the free times as one over all, 0 elsewhere."""
            padded = np.zeros(len(defect))
            padded[active] = vector
            return padded

        def product(vector: Floats) -> Floats:
            flux: Floats = free_slope * vector + self.conduction.flux(spread(vector))[active]
            return flux

        def approximate_inverse(vector: Floats) -> Floats:
            return self.conduction.relax(spread(vector), mean)[active]

        needed = -defect[active] - self.conduction.flux(step)[active]
        shape = (active.size, active.size)
        matrix, inverse = (LinearOperator(shape, apply, dtype=float) for apply in (product, approximate_inverse))
        step[active], _ = gmres(matrix, needed, M=inverse, rtol=1e-6, restart=60, maxiter=20)
        return step
