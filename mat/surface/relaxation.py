"""Batches of columns iterated with one matrix: to near the solution in single precision, to the tolerance in double.

With g(t) the batch's mean slope of f, T goes to (diag(g) + C)^-1 (g T - f(T) + source). That leaves an imbalance of the
change of T times the error of g, which Anderson acceleration reduces. Where stability bends f, slopes differ
severalfold between columns: each then has Newton's step with its own slopes, found with the common matrix.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Protocol, Self

import numpy as np

from skyshine.mat.surface.acceleration import Anderson, OwnSlopes, steeper
from skyshine.mat.surface.balance import MELTING_POINT, Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.newton import HeatFlux, HeatLoss
from skyshine.schemas.arrays import Booleans, Floats, Integers, Reals

# Largest residual of the balance at any time [W m^-2]: with at least 1 W m^-2 K^-1 of convection below 10 mK. On
# library materials a tenth of it changes temperatures by 4e-5 K and costs 15 % more.
TOLERANCE = 1e-2
_ITERATIONS = 16  # in either precision; more for snow, whose melting settles slowly
_MELTING_ITERATIONS = 60
# Change [K] at which single precision gives way to double: several times the rounding of temperatures near 300 K; more
# after Newton's step, whose own error is far smaller; still more in coarse steps.
_NEAR, _NEAR_NEWTON, _NEAR_COARSE = 5e-4, 3e-3, 0.02
# K: an iterate beyond these has diverged.
_COLDEST, _HOTTEST = 1.0, 3000.0
_RENEWED = 0.1  # K: after larger changes each column of a field gets its own slopes anew
_USUAL = 4  # iterations after which a column whose steps change sign is taken to cycle across a bend
_SAMPLE = 32  # columns that determine the relaxation of a material
# Steps of a day, at least, in which they are found, and in which more steps than twice as many begin: 96 steps that
# began in 48 took 1.2 times as long.
_COARSE_STEPS = 96


class Exchange(HeatLoss, Protocol):
    """A balance whose columns are iterated together."""

    material: SurfaceMaterial
    air_temperature: Floats

    @property
    def bends(self) -> bool: ...

    def single(self) -> Self: ...


def sampled(columns: int) -> Integers:
    """Indices of at most 32 columns, spread evenly over all."""
    return np.unique(np.linspace(0, columns - 1, min(columns, _SAMPLE)).astype(int))


def imbalance_of(balance: Exchange, conduction: HeatFlux, source: Floats, temperature: Floats) -> tuple[Reals, Floats]:
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


def first_guess(balance: Exchange) -> Floats:
    """Air temperature [K], (columns, N); without air the temperature that radiates the mean absorbed flux."""
    if isinstance(balance, Balance) and balance.airless:
        mean = np.mean(balance.absorbed + np.zeros(balance.shape), axis=1, keepdims=True)
        radiator: Floats = (np.maximum(mean, 1e-6) / max(float(np.max(balance.emission)), 1e-12)) ** 0.25
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
    stiffness : ndarray, shape (N,)
        Diagonal of C [W m^-2 K^-1].
    coarse : Relaxation or None
        Relaxation in coarse steps, in which the iteration begins.
    """

    slope: Reals
    inverse: Reals
    start: Floats | None
    origin: Floats
    origin_flux: Floats
    cap: float | None
    melting: float
    stiffness: Reals
    coarse: Relaxation | None = None

    @classmethod
    def of(
        cls,
        material: SurfaceMaterial,
        forcing: Forcing,
        conduction: Conduction,
        source: Floats,
    ) -> Relaxation:
        """The relaxation that suits a sample of the columns.

        Parameters
        ----------
        source : (columns, N or 1) ndarray
            [W m^-2]

        Notes
        -----
        Temperatures of the sample, about which the matrix is built, are found in coarse steps, whose matrices cost
        little.
        """
        sample = sampled(forcing.shape[0])
        forcing, source = forcing.columns(sample), source[sample]
        stride = max(conduction.steps // _COARSE_STEPS, 1)
        times = np.arange(0, conduction.steps, stride if conduction.steps % stride == 0 else 1)
        coarse = replace(conduction, steps=times.size)
        source = source if source.shape[1] == 1 else source[:, times]
        coarse_balance = Balance(forcing.times(times), material)
        about, start = cls._converging(coarse_balance, coarse, source)
        fine = cls._about(
            Balance(forcing, material),
            conduction,
            _between(about, conduction.steps).astype(float, copy=False),
            None if start is None else _between(start, conduction.steps).astype(float, copy=False),
        )
        if start is None or times.size == conduction.steps:
            return fine
        return replace(fine, coarse=cls._about(coarse_balance, coarse, about, start))

    @classmethod
    def of_all_steps(cls, balance: Exchange, conduction: HeatFlux, source: Floats) -> Relaxation:
        """The relaxation that suits a sample of the columns, found in all their steps: of leaves and soil, whose times
        lie one after the other.
        """
        sample = sampled(balance.shape[0])
        few, source = balance.columns(sample), source[sample]
        return cls._about(few, conduction, *cls._converging(few, conduction, source))

    @classmethod
    def _converging(cls, balance: Exchange, conduction: HeatFlux, source: Floats) -> tuple[Floats, Floats | None]:
        """Temperatures (columns, N) [K] near the solution, by a matrix about a first guess, and their mean (1, N); the
        guess and no mean where the iteration diverges. A second matrix, about these, saves no iteration.
        """
        guess = first_guess(balance)
        iterate, _, _ = cls._about(balance, conduction, guess, None).iterate(balance, source, guess, 2, 0.0)
        if not np.all(plausible(iterate)):
            return guess, None
        temperature = iterate.astype(float, copy=False)
        return temperature, temperature.mean(axis=0, keepdims=True)

    @classmethod
    def _about(cls, balance: Exchange, conduction: HeatFlux, temperature: Floats, start: Floats | None) -> Relaxation:
        """The relaxation about temperatures (columns, N) [K]."""
        cap = melting_cap(balance.material)
        _, slopes = balance.loss_and_slope(temperature if cap is None else np.minimum(temperature, cap))
        slope = np.maximum(slopes.mean(axis=0), 1e-3)
        inverse = np.linalg.inv(conduction.matrix + np.diag(slope)).T
        # Between the least and the largest stiffness of a wave: both of them converge then.
        ends = slope.mean() + conduction.admittance.real[[0, -1]]
        melting = 2 * ends.prod() / ends.sum()
        origin = temperature.mean(axis=0, keepdims=True)
        return cls(
            slope, inverse, start, origin, conduction.flux(origin), cap, float(melting), np.diagonal(conduction.matrix)
        )

    @cached_property
    def single(self) -> Relaxation:
        """The same in single precision."""
        return replace(
            self,
            slope=self.slope.astype(np.float32),
            inverse=self.inverse.astype(np.float32),
            stiffness=self.stiffness.astype(np.float32),
        )

    def solve(
        self, balance: Exchange, conduction: HeatFlux, source: Floats
    ) -> tuple[Floats, Floats, Reals, Floats, Integers]:
        """Iterate in single precision, then in double until the imbalance is within the tolerance.

        Parameters
        ----------
        source : (columns, N or 1) ndarray
            [W m^-2]

        Returns
        -------
        temperature, melt, loss, imbalance : (columns, N) ndarray
            [K], [W m^-2]; columns whose imbalance is not within the tolerance have not settled.
        iterations : (columns,) ndarray of int32
            Of all N steps.
        """
        unknown, single_count, column_slopes = self._approach(balance, source, _NEAR)
        if not np.all((unknown > _COLDEST) & (unknown < 1e5)):
            unknown = self._begin(balance, source)
        memory = Anderson()
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
            change: Reals = imbalance.astype(np.float32) @ self.single.inverse  # a small change needs few digits
            np.negative(change, out=change)
            if column_slopes is not None:
                if count > 1:
                    column_slopes = self.single._own_slopes(balance.loss_and_slope(temperature)[1].astype(np.float32))
                    memory = Anderson()
                change = column_slopes.step(change)
            unknown = memory.next(unknown + change, change).astype(float, copy=False)
        return temperature, melt, loss, imbalance, np.full(len(unknown), single_count + count, np.int32)

    def _approach(self, balance: Exchange, source: Floats, tolerance: float) -> tuple[Floats, int, OwnSlopes | None]:
        """Unknowns to some tolerance [K] (`_NEAR_NEWTON` at least, after Newton's step), iterated in single precision,
        the count of iterations, and the slopes of each column where it has its own.
        """
        start = self._coarse_start(balance, source)
        guess = self._begin(balance, source) if start is None else _between(start, balance.shape[1])
        newton = self.cap is None and balance.bends
        change, count, column_slopes = self.single.iterate(
            balance.single(),
            (source - self.origin_flux).astype(np.float32),
            (guess - self.origin).astype(np.float32),
            self._max_iterations,
            max(tolerance, _NEAR_NEWTON) if newton else tolerance,
            self.origin.astype(np.float32),
            None if not newton else 2 if start is None else 1,
        )
        return change + self.origin, count, column_slopes

    def _coarse_start(self, balance: Exchange, source: Floats) -> Floats | None:
        """Unknowns in coarse steps (columns, fewer steps); None where there are none or they diverge."""
        if self.coarse is None or not isinstance(balance, Balance):
            return None
        stride = balance.shape[1] // self.coarse.slope.size
        times = np.arange(0, balance.shape[1], stride)
        source = source if source.shape[1] == 1 else source[:, times]
        coarse = Balance(balance.forcing.times(times), balance.material)
        unknown, _, _ = self.coarse._approach(coarse, source, _NEAR_COARSE)
        if not np.all((unknown > _COLDEST) & (unknown < 1e5)):
            return None
        if self.cap is not None:
            excess = np.maximum(unknown - self.cap, 0.0)
            unknown += (self.coarse.melting / self.melting - 1.0) * excess
        return unknown

    def _begin(self, balance: Exchange, source: Floats) -> Floats:
        return first_guess(balance) if self.start is None else np.repeat(self.start, len(source), axis=0)

    @property
    def _max_iterations(self) -> int:
        return _ITERATIONS if self.cap is None else _MELTING_ITERATIONS

    def iterate(
        self,
        balance: Exchange,
        source: Reals,
        unknown: Reals,
        max_iterations: int,
        tolerance: float,
        origin: Reals | float = 0.0,
        newton: int | None = None,
    ) -> tuple[Reals, int, OwnSlopes | None]:
        """Accelerated fixed-point iteration, in the precision of its arguments.

        Parameters
        ----------
        source : (columns, N or 1) ndarray
            Less C of the origin [W m^-2].
        unknown : (columns, N) ndarray
            Initial values, less the origin [K].
        tolerance : float
            Largest change of an unknown [K] at which the iteration ends.
        origin : (1, N) ndarray or float
            [K]
        newton : int, optional
            Iteration from which on each column has its own slopes, renewed until changes are small.

        Returns
        -------
        unknown : (columns, N) ndarray
            Less the origin [K].
        count : int
            Of the iterations.
        own : OwnSlopes or None
            The last.
        """
        memory, column_slopes, largest = Anderson(), None, np.inf
        previous: tuple[Reals, Reals, Reals] | None = None
        for count in range(1, max_iterations + 1):
            loss = None
            if newton is not None and count >= newton and largest > _RENEWED:
                loss, slope = balance.loss_and_slope(unknown + origin)
            target = self._relaxed(balance, source, unknown, origin, loss)
            change: Reals = target - unknown
            if loss is not None:
                if previous is not None and count > _USUAL:
                    slope = steeper(slope, change, unknown, loss, *previous)
                column_slopes, previous, memory = self._own_slopes(slope), (change, unknown, loss), Anderson()
            if column_slopes is not None:
                change = column_slopes.step(change)
                target = unknown + change
            largest = max(change.max(), -change.min())
            if largest < tolerance:
                return target, count, column_slopes
            if not largest < 1e6:
                break
            unknown = memory.next(target, change)
        return unknown, count, column_slopes

    def _own_slopes(self, slope: Reals) -> OwnSlopes:
        return OwnSlopes.of(slope, self.slope, self.stiffness, self.inverse)

    def _relaxed(
        self, balance: Exchange, source: Reals, unknown: Reals, origin: Reals | float, loss: Reals | None = None
    ) -> Reals:
        """The unknown less the relaxed imbalance; `loss` is that of the balance where it is known."""
        temperature = unknown + origin
        if self.cap is not None:
            excess = np.maximum(temperature - self.cap, 0.0)
            np.minimum(temperature, self.cap, out=temperature)
            unknown = unknown - excess
        target: Reals = unknown * self.slope
        target -= balance.loss(temperature) if loss is None else loss
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
