"""How certain fitted parameters are, with residuals that follow each other in time, and which a record cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.free_parameters import FreeParameter
from skyshine.schemas.arrays import Floats

CONFIDENCE = 0.99  # probability that all intervals of a fit contain the truth at once
_APART = 3 * 3600.0  # s: chosen, longer than what instruments add and shorter than the day
_SIGNIFICANT = 2.0  # standard errors of a correlation, 1 / sqrt n of white noise, below which it counts as none
_SLOWEST = 0.9995  # correlation of neighbours at most: chosen, of half-hours 40 days
_HALVINGS = 40  # halvings of the interval 0 to 1: to double precision
_FLOOR = 1e-8  # floor of singular values over the largest: below, a direction has no effect on the temperatures
ALIKE = 0.95  # size of a correlation from which two parameters cannot be distinguished: chosen
SPAN = 0.5  # share of its bounds from which an interval says nothing: chosen
_AT_BOUND = 1e-3  # fraction of the way between the bounds


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Uncertainty of p parameters, in shares of the way between their bounds.

    Attributes
    ----------
    standard : (p,) ndarray
        Standard errors.
    correlation : (p, p) ndarray
    effective : float
        Number of independent residuals with as much information as those of the fit.
    factor : float
        Half width of an interval over its standard error.
    """

    standard: Floats
    correlation: Floats
    effective: float
    factor: float

    def interval(self, index: int, share: float) -> tuple[float, float]:
        """Interval of a parameter at a share, within its bounds."""
        half = self.factor * float(self.standard[index])
        return max(share - half, 0.0), min(share + half, 1.0)


def uncertainty(residual: Floats, derivatives: Floats, step: float) -> Uncertainty:
    """Uncertainty of a least-squares solution.

    Parameters
    ----------
    residual : (N,) ndarray
        Residuals at equal steps [K]; NaN where none counts.
    derivatives : (N, p) ndarray
        Derivatives of the residuals with respect to the parameters.
    step : float
        [s]

    Notes
    -----
    Errors are taken as a first-order autoregression: their correlation falls by one factor from step to step. What is
    left of them after the fit hangs together less; the factor is that which explains, after a fit, the correlation that
    is found: the slower of those a step and three hours apart, because instruments add noise of their own to what the
    weather leaves. A correlation that white noise might show counts as none; to any other its standard error is added,
    sqrt((1 - a^2) / n) by Bartlett (1946). The covariance is (J'J)^-1 J'RJ (J'J)^-1 times the variance, both with that
    factor. `effective` is the number n of independent residuals whose covariance has the same trace; intervals are by
    Student's quantile for n - p degrees of freedom and Bonferroni's inequality for all p of them at once. An error of
    the model that repeats day by day is no random one: it shifts parameters and does not widen their intervals.

    References
    ----------
    Bayley and Hammersley (1946), J. R. Stat. Soc. Suppl. 8, 184-197: the effective number of independent observations.
    Bartlett (1946), J. R. Stat. Soc. Suppl. 8, 27-41: standard errors of autocorrelations.
    Durbin and Watson (1950), Biometrika 37, 409-428: the autocorrelation that a fit leaves.
    """
    from scipy.stats import t as student

    finite = np.isfinite(residual)
    count, parameter_count = int(finite.sum()), derivatives.shape[1]
    error, slopes = np.where(finite, residual, 0.0), np.where(finite[:, None], derivatives, 0.0)
    basis, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    singular = np.maximum(singular, _FLOOR * max(float(singular[0]), np.finfo(float).tiny))
    lags = {1, max(round(_APART / step), 1)}
    decay = max(_decay(error, finite, basis, lag) for lag in lags)
    decay = min(decay + float(np.sqrt((1.0 - decay**2) / count)), _SLOWEST) if decay > 0 else 0.0
    between = basis.T @ _smeared(basis, decay)
    towards = directions.T / singular
    ratio = float(np.trace(between)) / parameter_count  # ratio of variances, to those of independent residuals
    effective = count / ratio
    freedom = max(effective - parameter_count, 1.0)
    covariance = towards @ between @ towards.T * (float(error @ error) / max(count - float(np.trace(between)), 1.0))
    standard = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    quantile = float(student.ppf(1.0 - (1.0 - CONFIDENCE) / (2 * parameter_count), freedom))
    return Uncertainty(standard, covariance / np.outer(standard, standard), effective, quantile)


def _smeared(values: Floats, decay: float) -> Floats:
    """Values (N, p) times the matrix of decay to the power of the distance."""
    from scipy.signal import lfilter

    onwards = lfilter([1.0], [1.0, -decay], values, axis=0)
    back = lfilter([1.0], [1.0, -decay], values[::-1], axis=0)[::-1]
    smeared: Floats = onwards + back - values
    return smeared


def _decay(error: Floats, finite: npt.NDArray[np.bool_], basis: Floats, lag: int) -> float:
    """Correlation of neighbours whose fit leaves the correlation that is found `lag` steps apart, by bisection."""
    correlation = float(error[lag:] @ error[:-lag]) / max(float(error @ error), np.finfo(float).tiny)
    if correlation * np.sqrt(np.sum(finite)) < _SIGNIFICANT:
        return 0.0
    low, high = 0.0, _SLOWEST
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _left(finite, basis, middle, lag) < correlation else (low, middle)
    return low


def _left(finite: npt.NDArray[np.bool_], basis: Floats, decay: float, lag: int) -> float:
    """Expected correlation `lag` steps apart of what a fit on an orthonormal basis (N, p) leaves of errors."""
    smeared = _smeared(basis, decay) * finite[:, None]
    between = basis.T @ smeared
    apart = np.sum(finite[lag:] & finite[:-lag]) * decay**lag
    apart -= np.sum(basis[:-lag] * smeared[lag:]) + np.sum(smeared[:-lag] * basis[lag:])
    apart += np.sum((basis[:-lag] @ between) * basis[lag:])
    return float(apart / (np.sum(finite) - np.trace(between)))


def not_identified(parameters: Sequence[FreeParameter], shares: Floats, certainty: Uncertainty) -> tuple[str, ...]:
    """What a record cannot tell, one sentence each: ends at bounds, intervals of most of the bounds, pairs alike."""
    notes = []
    for index, (parameter, share) in enumerate(zip(parameters, shares, strict=True)):
        low, high = certainty.interval(index, float(share))
        if min(share, 1.0 - share) < _AT_BOUND:
            bound = f"{parameter.value(round(float(share))):.4g} {parameter.units}".removesuffix(" 1")
            notes.append(f"{parameter.name} ended at its bound {bound}; fix it, or ask what else is wrong")
        if high - low > SPAN:
            notes.append(
                f"{parameter.name} is not identified by this record: its interval spans {100 * (high - low):.0f} % of"
                " its bounds; fix it"
            )
        for earlier in range(index):
            correlation = float(certainty.correlation[index, earlier])
            if abs(correlation) > ALIKE:
                notes.append(
                    f"{parameters[earlier].name} and {parameter.name} cannot be distinguished by this record:"
                    f" correlation {correlation:+.3f}; fix one of them"
                )
    return tuple(notes)
