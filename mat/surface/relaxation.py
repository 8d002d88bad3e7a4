"""Batches of columns iterated with one matrix: to near the solution in single precision, to the tolerance in double.

With g(t) the batch's mean slope of f, T goes to (diag(g) + C)^-1 (g T - f(T) + source). That leaves an imbalance of the
change of T times the error of g, which Anderson acceleration reduces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from skyshine.mat.surface.balance import MELTING_POINT, Balance, Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.schemas.arrays import Booleans, Floats, Integers, Reals

# Largest residual of the balance at any time [W m^-2]: with at least 2 W m^-2 K^-1 of convection below 1 mK.
TOLERANCE = 1e-3
_ITERATIONS = 16  # in either precision; more for snow, whose melting settles slowly
_MELTING_ITERATIONS = 60
# Change [K] at which single precision gives way to double: several times the rounding of temperatures near 300 K.
_NEAR = 5e-4
# K: an iterate beyond these has diverged.
_COLDEST, _HOTTEST = 1.0, 3000.0
_SAMPLE, _RENEWALS = 32, 3  # columns and coarse matrices that determine the relaxation of a material
_COARSE_STEPS = 48  # of a day, at least, in which they are found


def sampled(columns: int) -> Integers:
    """Indices of at most 32 columns, spread evenly over all."""
    return np.unique(np.linspace(0, columns - 1, min(columns, _SAMPLE)).astype(int))


def imbalance_of(balance: Balance, conduction: Conduction, source: Floats, temperature: Floats) -> tuple[Reals, Floats]:
    """f(T), and f(T) + C T - source [W m^-2], each (columns, N)."""
    loss = balance.loss(temperature)
    flux = conduction.flux(temperature)
    flux += loss
    flux -= source
    return loss, flux


def plausible(temperature: Reals) -> Booleans:
    """Whether no temperature (columns, N) [K] of a column has diverged, (columns,)."""
    inside: Booleans = np.all((temperature > _COLDEST) & (temperature < _HOTTEST), axis=1)
    return inside


def first_guess(balance: Balance) -> Floats:
    """Air temperature [K], (columns, N); without air the temperature that radiates the mean absorbed flux."""
    if balance.airless:
        mean = np.mean(balance.absorbed + np.zeros(balance.shape), axis=1, keepdims=True)
        radiator: Floats = (np.maximum(mean, 1e-6) / max(balance.emission, 1e-12)) ** 0.25
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
    origin, origin_flux : ndarray, shape (1, N)
        Temperatures [K] near those of the sample, from which single precision measures, and C of them [W m^-2].
    cap : float or None
        Temperature T_m that the surface cannot exceed [K]. The unknown is then u, of which T = min(u, T_m) is the
        temperature and `melting` (u - T_m) the heat spent on melting where u exceeds T_m.
    melting : float
        [W m^-2 K^-1]
    """

    slope: Reals
    inverse: Reals
    start: Floats | None
    origin: Floats
    origin_flux: Floats
    cap: float | None
    melting: float

    @classmethod
    def of(
        cls,
        material: SurfaceMaterial,
        forcing: Forcing,
        conduction: Conduction,
        source: Floats,
        coarse: Reals | None = None,
    ) -> Relaxation:
        """The relaxation that suits a sample of the columns.

        Parameters
        ----------
        material : SurfaceMaterial
        forcing : Forcing
        conduction : Conduction
        source : (columns, N or 1) ndarray
            [W m^-2]
        coarse : (columns, fewer steps) ndarray, optional
            Temperatures [K] about which the matrix is built; without them those of the sample are found in coarse
            steps, whose matrices cost little.
        """
        sample = sampled(forcing.shape[0])
        forcing, source = forcing.columns(sample), source[sample]
        if coarse is not None:
            about = _between(coarse[sample], conduction.steps).astype(float)
            return cls._about(Balance(forcing, material), conduction, about, None)
        every = max(conduction.steps // _COARSE_STEPS, 1)
        times = np.arange(0, conduction.steps, every if conduction.steps % every == 0 else 1)
        few = replace(conduction, steps=times.size)
        source = source if source.shape[1] == 1 else source[:, times]
        about, start = cls._converging(Balance(forcing.times(times), material), few, source)
        return cls._about(
            Balance(forcing, material),
            conduction,
            _between(about, conduction.steps).astype(float, copy=False),
            None if start is None else _between(start, conduction.steps).astype(float, copy=False),
        )

    @classmethod
    def _converging(cls, balance: Balance, conduction: Conduction, source: Floats) -> tuple[Floats, Floats | None]:
        """Temperatures (columns, N) [K] near the solution, by matrices renewed about them, and their mean (1, N); no
        mean where the iteration diverges.
        """
        temperature: Floats = first_guess(balance)
        start: Floats | None = None
        for _ in range(_RENEWALS):
            relaxation = cls._about(balance, conduction, temperature, start)
            iterate, _ = relaxation.iterate(balance, source, temperature, 2, 0.0)
            if not np.all(plausible(iterate)):
                break
            temperature = iterate.astype(float, copy=False)
            start = temperature.mean(axis=0, keepdims=True)
        return temperature, start

    @classmethod
    def _about(cls, balance: Balance, conduction: Conduction, temperature: Floats, start: Floats | None) -> Relaxation:
        """The relaxation about temperatures (columns, N) [K]."""
        cap = melting_cap(balance.material)
        _, slopes = balance.loss_and_slope(temperature if cap is None else np.minimum(temperature, cap))
        slope = np.maximum(slopes.mean(axis=0), 1e-3)
        inverse = np.linalg.inv(conduction.matrix + np.diag(slope)).T
        # Between the least and the largest stiffness of a wave: both of them converge then.
        ends = slope.mean() + conduction.admittance.real[[0, -1]]
        melting = 2 * ends.prod() / ends.sum()
        origin = temperature.mean(axis=0, keepdims=True)
        return cls(slope, inverse, start, origin, conduction.flux(origin), cap, float(melting))

    @cached_property
    def single(self) -> Relaxation:
        """The same in single precision."""
        return replace(self, slope=self.slope.astype(np.float32), inverse=self.inverse.astype(np.float32))

    def solve(
        self, balance: Balance, conduction: Conduction, source: Floats, start: Reals | None = None
    ) -> tuple[Floats, Floats, Reals, Floats, Integers]:
        """Iterate in single precision, then in double until the imbalance is within the tolerance.

        Parameters
        ----------
        balance : Balance
        conduction : Conduction
        source : (columns, N or 1) ndarray
            [W m^-2]
        start : (columns, fewer steps) ndarray, optional
            Unknowns that `approach` gives.

        Returns
        -------
        temperature, melt, loss, imbalance : (columns, N) ndarray
            [K], [W m^-2]; columns whose imbalance is not within the tolerance have not settled.
        iterations : (columns,) ndarray of int32
        """
        unknown, single_count = self.approach(balance, source, start)
        if not np.all((unknown > _COLDEST) & (unknown < 1e5)):
            unknown = self._begin(balance, source)
        memory = _Anderson()
        for count in range(self._max_iterations + 1):
            temperature: Floats = unknown
            melt = np.zeros(unknown.shape)
            if self.cap is not None:
                temperature = np.minimum(unknown, self.cap)
                melt = self.melting * (unknown - temperature)
            loss, imbalance = imbalance_of(balance, conduction, source, temperature)
            if self.cap is not None:
                imbalance += melt
            largest = max(imbalance.max(), -imbalance.min())
            if largest <= TOLERANCE or not largest < 1e9 or count == self._max_iterations:
                break
            change: Floats = imbalance @ self.inverse
            np.negative(change, out=change)
            unknown = memory.next(unknown + change, change).astype(float, copy=False)
        return temperature, melt, loss, imbalance, np.full(len(unknown), single_count + count, np.int32)

    def approach(self, balance: Balance, source: Floats, start: Reals | None = None) -> tuple[Floats, int]:
        """Unknowns to about `_NEAR`, iterated in single precision, and the count of iterations."""
        guess = self._begin(balance, source) if start is None else _between(start, balance.shape[1])
        change, count = self.single.iterate(
            balance.single(),
            (source - self.origin_flux).astype(np.float32),
            (guess - self.origin).astype(np.float32),
            self._max_iterations,
            _NEAR,
            self.origin.astype(np.float32),
        )
        return change + self.origin, count

    def _begin(self, balance: Balance, source: Floats) -> Floats:
        return first_guess(balance) if self.start is None else np.repeat(self.start, len(source), axis=0)

    @property
    def _max_iterations(self) -> int:
        return _ITERATIONS if self.cap is None else _MELTING_ITERATIONS

    def iterate(
        self,
        balance: Balance,
        source: Reals,
        unknown: Reals,
        max_iterations: int,
        tolerance: float,
        origin: Reals | float = 0.0,
    ) -> tuple[Reals, int]:
        """Accelerated fixed-point iteration, in the precision of its arguments.

        Parameters
        ----------
        balance : Balance
        source : (columns, N or 1) ndarray
            Less C of the origin [W m^-2].
        unknown : (columns, N) ndarray
            To begin with, less the origin [K].
        max_iterations : int
        tolerance : float
            Largest change of an unknown [K] at which the iteration ends.
        origin : (1, N) ndarray or float
            [K]

        Returns
        -------
        unknown : (columns, N) ndarray
            Less the origin [K].
        count : int
            Of the iterations.
        """
        memory = _Anderson()
        for count in range(1, max_iterations + 1):
            target = self._relaxed(balance, source, unknown, origin)
            change = target - unknown
            largest = max(change.max(), -change.min())
            if largest < tolerance:
                return target, count
            if not largest < 1e6:
                break
            unknown = memory.next(target, change)
        return unknown, count

    def _relaxed(self, balance: Balance, source: Reals, unknown: Reals, origin: Reals | float) -> Reals:
        """The unknown less the relaxed imbalance."""
        temperature = unknown + origin
        if self.cap is not None:
            excess = np.maximum(temperature - self.cap, 0.0)
            np.minimum(temperature, self.cap, out=temperature)
            unknown = unknown - excess
        target: Reals = unknown * self.slope
        target -= balance.loss(temperature)
        target += source
        if self.cap is not None:
            target -= self.melting * excess
        target = target @ self.inverse
        if self.cap is not None:
            target += excess
        return target


def _between(temperature: Reals, steps: int) -> Reals:
    """Periodic temperatures (columns, fewer steps) at a number of times, linear between their own."""
    interpolated: Reals = temperature @ _weights_between(temperature.shape[1], steps).astype(temperature.dtype)
    return interpolated


@lru_cache(maxsize=8)
def _weights_between(fewer: int, steps: int) -> Floats:
    at = np.arange(steps) / steps
    return np.array([np.interp(at, np.arange(fewer) / fewer, row, period=1.0) for row in np.eye(fewer)])


def melting_cap(material: SurfaceMaterial) -> float | None:
    """Temperature that the surface cannot exceed [K]; None where it does not melt."""
    return MELTING_POINT if material.surface.snow else None


class _Anderson:
    """Anderson acceleration of depth two, each column its own.

    References
    ----------
    Walker and Ni (2011), Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, 1715-1735.
    """

    def __init__(self) -> None:
        self.last: tuple[Reals, Reals] | None = None
        self.steps: list[tuple[Reals, Reals]] = []

    def next(self, target: Reals, change: Reals) -> Reals:
        """The next iterate from G(x) and G(x) - x; `target` and `change` are kept, not copied."""
        if self.last is not None:
            self.steps = [(target - self.last[0], change - self.last[1]), *self.steps[:1]]
        self.last = target, change
        if not self.steps:
            return target
        bend = self.steps[0][1]
        first = _dot(bend, bend)
        with np.errstate(divide="ignore", invalid="ignore"):
            one = len(self.steps) == 1
            weights = [_dot(bend, change) / first] if one else self._two(first, bend, change)
        result = target.copy()
        for weight, (step, _) in zip(weights, self.steps, strict=True):
            result -= np.where(np.isfinite(weight), weight, 0.0).astype(step.dtype)[:, None] * step
        return result

    def _two(self, first: Floats, bend: Reals, change: Reals) -> list[Floats]:
        """Weights of both steps; `first` is the square of the newer bend."""
        older = self.steps[1][1]
        second, cross = _dot(older, older), _dot(bend, older)
        right, right_older = _dot(bend, change), _dot(older, change)
        determinant = first * second - cross**2
        # Nearly parallel differences carry one direction only.
        single = determinant < np.sqrt(np.finfo(change.dtype).eps) * first * second
        one = np.where(single, right / first, (second * right - cross * right_older) / determinant)
        two = np.where(single, 0.0, (first * right_older - cross * right) / determinant)
        return [one, two]


def _dot(one: Reals, other: Reals) -> Floats:
    product: Floats = np.einsum("ct,ct->c", one, other).astype(float)
    return product
