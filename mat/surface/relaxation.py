"""Batches of columns iterated with one matrix: to near the solution in single precision, to the tolerance in double.

With g(t) the batch's mean slope of f, T goes to (diag(g) + C)^-1 (g T - f(T) + source), which leaves an imbalance of
the change times what g is wrong by, and Anderson acceleration makes up for that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from skyshine.mat.surface.balance import MELTING_POINT, Balance, Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.material import SurfaceMaterial

# Largest residual of the balance at any time [W m^-2]: with at least 2 W m^-2 K^-1 of convection below 1 mK.
TOLERANCE = 1e-3
_ITERATIONS = 16  # in either precision; more for snow, whose melting is slow to settle
_MELTING_ITERATIONS = 60
# Change [K] at which single precision gives way to double: several times the rounding of temperatures near 300 K.
_NEAR = 5e-4
_SAMPLE, _RENEWALS = 32, 3  # columns and matrices from which a material's relaxation is found


def sampled(columns: int) -> np.ndarray:
    """Indices of columns that stand for all."""
    return np.unique(np.linspace(0, columns - 1, min(columns, _SAMPLE)).astype(int))


def imbalance_of(balance: Balance, conduction: Conduction, source, temperature) -> tuple[np.ndarray, np.ndarray]:
    """f(T), and f(T) + C T - source [W m^-2], each (columns, N)."""
    loss = balance.loss(temperature)
    flux = conduction.flux(temperature)
    flux += loss
    flux -= source
    return loss, flux


def first_guess(balance: Balance) -> np.ndarray:
    """Air temperature; without air the temperature that radiates the mean of what is absorbed."""
    if balance.airless:
        mean = np.mean(balance.absorbed + np.zeros(balance.shape), axis=1, keepdims=True)
        radiator = (np.maximum(mean, 1e-6) / max(balance.emission, 1e-12)) ** 0.25
        return np.clip(radiator, 3.0, 2000.0) + np.zeros(balance.shape)
    return balance.air_temperature + np.zeros(balance.shape)


@dataclass(frozen=True, eq=False)
class Relaxation:
    """One matrix (diag(g) + C)^-1 for all columns of a material, and where to start from.

    Attributes
    ----------
    slope : ndarray, shape (N,)
        g, the mean slope of f over columns at about their solution [W m^-2 K^-1].
    inverse : ndarray, shape (N, N)
        Transposed, for temperatures in rows.
    start : ndarray, shape (1, N), or None
        Mean temperature of the sample [K].
    origin, pull : ndarray, shape (1, N)
        Temperatures [K] from which single precision measures, near those of the sample, and C of them [W m^-2].
    cap : float or None
        Temperature T_m that the surface cannot exceed [K]. The unknown is then u, of which T = min(u, T_m) is the
        temperature and `melting` (u - T_m) the heat spent on melting where u exceeds T_m.
    melting : float
        [W m^-2 K^-1]
    """

    slope: np.ndarray
    inverse: np.ndarray
    start: np.ndarray | None
    origin: np.ndarray
    pull: np.ndarray
    cap: float | None
    melting: float

    @classmethod
    def of(cls, material, forcing: Forcing, conduction: Conduction, source: np.ndarray, found=None) -> Relaxation:
        """The relaxation that suits a sample of the columns: by temperatures found with fewer steps or by renewed
        matrices.
        """
        sample = sampled(forcing.shape[0])
        balance = Balance(forcing.columns(sample), material)
        source = source[sample]
        temperature, start = first_guess(balance), None
        if found is not None:
            temperature = _between(found[sample], conduction.steps).astype(float)
        cap = melting_cap(material)
        for _ in range(_RENEWALS if found is None else 1):
            _, slopes = balance.loss_and_slope(temperature if cap is None else np.minimum(temperature, cap))
            slope = np.maximum(slopes.mean(axis=0), 1e-3)
            inverse = np.linalg.inv(conduction.matrix + np.diag(slope)).T
            # Between the least and the largest stiffness of a wave: both of them converge then.
            ends = slope.mean() + conduction.admittance.real[[0, -1]]
            melting = 2 * ends.prod() / ends.sum()
            origin = temperature.mean(axis=0, keepdims=True)
            relaxation = cls(slope, inverse, start, origin, conduction.flux(origin), cap, float(melting))
            if found is not None:
                break
            better, _ = relaxation.iterate(balance, source, temperature, 2, 0.0)
            if not np.all((better > 1.0) & (better < 3000.0)):
                break
            temperature, start = better, better.mean(axis=0, keepdims=True)
        return relaxation

    @cached_property
    def single(self) -> Relaxation:
        """The same in single precision."""
        return replace(self, slope=self.slope.astype(np.float32), inverse=self.inverse.astype(np.float32))

    def solve(self, balance: Balance, conduction: Conduction, source, start=None):
        """Iterate in single precision, then in double until the imbalance is within the tolerance.

        Parameters
        ----------
        balance : Balance
        conduction : Conduction
        source : (columns, N or 1) ndarray
            [W m^-2]
        start : (columns, fewer steps) ndarray, optional
            Unknowns that `approach` has found.

        Returns
        -------
        temperature, melt, loss, imbalance : (columns, N) ndarray
            [K], [W m^-2]; columns whose imbalance is not within the tolerance have not settled.
        iterations : (columns,) ndarray of int32
        """
        unknown, light = self.approach(balance, source, start)
        if not np.all((unknown > 1.0) & (unknown < 1e5)):
            unknown = self._begin(balance, source)
        memory = _Anderson()
        for count in range(self._most + 1):
            temperature, melt = unknown, np.zeros(unknown.shape)
            if self.cap is not None:
                temperature = np.minimum(unknown, self.cap)
                melt = self.melting * (unknown - temperature)
            loss, imbalance = imbalance_of(balance, conduction, source, temperature)
            if self.cap is not None:
                imbalance += melt
            largest = max(imbalance.max(), -imbalance.min())
            if largest <= TOLERANCE or not largest < 1e9 or count == self._most:
                break
            change = imbalance @ self.inverse
            np.negative(change, out=change)
            unknown = memory.next(unknown + change, change)
        return temperature, melt, loss, imbalance, np.full(len(unknown), light + count, np.int32)

    def approach(self, balance: Balance, source, start=None) -> tuple[np.ndarray, int]:
        """Unknowns to about `_NEAR`, iterated in single precision, and the count of iterations."""
        begin = self._begin(balance, source) if start is None else _between(start, balance.shape[1])
        light, origin = self.single, self.origin.astype(np.float32)
        given = [part.astype(np.float32) for part in (source - self.pull, begin - self.origin)]
        found, count = light.iterate(balance.single(), *given, self._most, _NEAR, origin)
        return found + self.origin, count

    def _begin(self, balance: Balance, source) -> np.ndarray:
        return first_guess(balance) if self.start is None else np.repeat(self.start, len(source), axis=0)

    @property
    def _most(self) -> int:
        return _ITERATIONS if self.cap is None else _MELTING_ITERATIONS

    def iterate(
        self, balance: Balance, source, unknown, most: int, tolerance: float, origin=0.0
    ) -> tuple[np.ndarray, int]:
        """Accelerated fixed-point iteration until no unknown changes by more than a tolerance [K]; and its count.

        Unknowns are measured from `origin`, of which `source` has lost C of it.
        """
        memory = _Anderson()
        for count in range(1, most + 1):
            target = self._relaxed(balance, source, unknown, origin)
            change = target - unknown
            largest = max(change.max(), -change.min())
            if largest < tolerance:
                return target, count
            if not largest < 1e6:
                break
            unknown = memory.next(target, change)
        return unknown, count

    def _relaxed(self, balance: Balance, source, unknown: np.ndarray, origin) -> np.ndarray:
        """The unknown less the relaxed imbalance."""
        temperature = unknown + origin
        if self.cap is not None:
            excess = np.maximum(temperature - self.cap, 0.0)
            np.minimum(temperature, self.cap, out=temperature)
            unknown = unknown - excess
        target = unknown * self.slope
        target -= balance.loss(temperature)
        target += source
        if self.cap is not None:
            target -= self.melting * excess
        target = target @ self.inverse
        if self.cap is not None:
            target += excess
        return target


def _between(temperature: np.ndarray, steps: int) -> np.ndarray:
    """Periodic temperatures (columns, fewer steps) at a number of times, linear between their own."""
    return temperature @ _weights_between(temperature.shape[1], steps).astype(temperature.dtype)


@lru_cache(maxsize=8)
def _weights_between(fewer: int, steps: int) -> np.ndarray:
    at = np.arange(steps) / steps
    return np.array([np.interp(at, np.arange(fewer) / fewer, row, period=1.0) for row in np.eye(fewer)])


def melting_cap(material: SurfaceMaterial) -> float | None:
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
        _new, bend = self.steps[0]
        first = _dot(bend, bend)
        with np.errstate(divide="ignore", invalid="ignore"):
            weights = [_dot(bend, change) / first] if len(self.steps) == 1 else self._two(first, bend, change)
        result = target.copy()
        for weight, (step, _) in zip(weights, self.steps, strict=True):
            result -= np.where(np.isfinite(weight), weight, 0.0).astype(step.dtype)[:, None] * step
        return result

    def _two(self, first, bend, change) -> list[np.ndarray]:
        older = self.steps[1][1]
        second, cross = _dot(older, older), _dot(bend, older)
        right, right_older = _dot(bend, change), _dot(older, change)
        determinant = first * second - cross**2
        # Nearly parallel differences carry one direction only.
        single = determinant < np.sqrt(np.finfo(change.dtype).eps) * first * second
        one = np.where(single, right / first, (second * right - cross * right_older) / determinant)
        two = np.where(single, 0.0, (first * right_older - cross * right) / determinant)
        return [one, two]


def _dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.einsum("ct,ct->c", one, other).astype(float)
