"""Spectral points of a band for its own response: narrow intervals where it changes, weights fitted where it is cut.

A point represents its interval, so an interval that a response cuts would count lines outside the band. There the
narrow intervals of the fine table take its place; where the response cuts these too, the weights of their points and of
their neighbours' are fitted to line-by-line spectra of paths through several atmospheres, weighted by the response.
These and other such spectra give the error of the band itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from skyshine.mat.atmosphere.band.points import BandPoints, LineByLineError, band_points, micron_response
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.gases.reference_spectra import ReferenceSpectra
from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.arrays import Booleans, Floats

# Standard deviation of monochromatic transmittance within an interval of some cm^-1 on paths of medium absorption: what
# a response that is not even within the interval errs by, over the part of it that is misplaced.
_SPREAD = 0.3
# Such errors of a band's transmittance that may remain: by intervals of the table, by narrow ones with mean responses.
_COARSE, _CUT = 3e-4, 1e-4
# rms that interpolation between the table's pressures and temperatures adds to a transmittance (`absorption.md`): the
# spectra share it.
_INTERPOLATION = 3.5e-4
_SAMPLES = 20  # samples of a response in a cell
_EVEN = 1e-3  # fraction of the largest response: a cell whose neighbours differ by less is taken for even
_LIKELIHOOD = 0.95  # that an air which is not among the atmospheres errs by less than is stated
_SUM_WEIGHT = 30.0  # weight of the row of a fit that is the sum of the weights


def points_of_band(table: AbsorptionTable, response: SpectralResponse) -> BandPoints:
    """All points of a band.

    Returns
    -------
    BandPoints
        With the error against line-by-line spectra where the table has such over the whole band.

    Raises
    ------
    InputError
        The table does not cover the band.

    Examples
    --------
    >>> from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
    >>> from skyshine.mat.radiometry.blackbody import SpectralResponse
    >>> band = points_of_band(AbsorptionTable.open(), SpectralResponse.rectangular(8.7, 8.8))
    >>> round(float(band.weight.sum()), 6)
    0.1
    """
    low, high = response.wavenumber_range
    line_table = table.with_continuum()  # that of the spectra
    points, fine = line_table.points(low, high), line_table.fine
    covered = np.zeros(len(points.interval_edges), bool) if fine is None else _covers(fine, points.interval_edges)
    if fine is None or not covered.any():
        return band_points(table.points(low, high), response)
    cells = _Cells.of(fine, response, low, high)
    uneven = np.where(covered, cells.unevenness(points.interval_edges), 0.0)
    band = band_points(points, response)
    refined = _largest(uneven, _COARSE * float(band.weight.sum()))
    if refined.any():
        band = _refined(fine, points, refined, cells, response)
    error = _error(band, cells, response) if any(a <= low and high <= b for a, b in fine.coverage) else None
    return replace(band, points=table.in_continuum(band.points), line_by_line=error)


@dataclass(frozen=True, eq=False)
class _Cells:
    """The response on the cells of reference spectra.

    Attributes
    ----------
    width : float
        Width of a cell, cm^-1.
    micron : (C,) array
        Mean response, um per cm^-1.
    """

    reference: ReferenceSpectra
    width: float
    micron: Floats

    @classmethod
    def of(cls, fine: AbsorptionTable, response: SpectralResponse, low: float, high: float) -> _Cells:
        edges = fine.interval_edges
        margin = 5.0  # cm^-1, of intervals of the table that a band's end cuts
        lower, upper = max(edges[0, 0], low - margin), min(edges[-1, 1], high + margin)
        reference = fine.reference_spectra(lower, upper)
        width = float(np.diff(reference.cell[:2])[0])
        return cls(reference, width, micron_response(response, reference.cell - width / 2, width, _SAMPLES))

    def inside(self, low: float, high: float) -> slice:
        """The cells between two wavenumbers."""
        return slice(*np.searchsorted(self.reference.cell, (low, high)))

    def unevenness(self, edges: Floats) -> Floats:
        """Response [um] on the wrong side of its mean in each of intervals (I, 2)."""
        starts, stops = np.searchsorted(self.reference.cell, edges.T)
        result = np.zeros(len(edges))
        for number, (a, b) in enumerate(zip(starts, stops, strict=True)):
            if b > a:
                part = self.micron[a:b]
                result[number] = 0.5 * np.sum(np.abs(part - part.mean())) * self.width
        return result


def _covers(fine: AbsorptionTable, edges: Floats) -> Booleans:
    """Whether the fine table covers each of intervals (I, 2)."""
    inside = [(edges[:, 0] >= lower) & (edges[:, 1] <= upper) for lower, upper in fine.coverage]
    return np.asarray(np.any(inside, axis=0), bool)


def _largest(uneven: Floats, allowed: float) -> Booleans:
    """The entries (I,) without which the root of the sum of squares is at most what is allowed, times `_SPREAD`."""
    order = np.argsort(-uneven)
    remainder = np.sqrt(np.cumsum(uneven[order][::-1] ** 2)[::-1])  # norm of an entry and all smaller ones
    chosen = np.zeros(uneven.size, bool)
    chosen[order[_SPREAD * remainder > allowed]] = True
    return chosen


def _refined(
    fine: AbsorptionTable, points: SpectralPoints, refined: Booleans, cells: _Cells, response: SpectralResponse
) -> BandPoints:
    """Points of a band with narrow intervals in the place of those of `points` at `refined` (I,)."""
    coarse = np.flatnonzero(~refined[points.interval])
    spans = points.interval_edges[refined]
    lowest, highest = spans[:, 0].min(), spans[:, 1].max()
    narrow = fine.points(max(lowest - 1.0, fine.interval_edges[0, 0]), min(highest + 1.0, fine.interval_edges[-1, 1]))
    low, high = narrow.interval_edges.T
    replaced = np.any([(low >= a) & (high <= b) for a, b in spans], axis=0)
    mean = np.where(replaced, micron_response(response, low, high - low), 0.0)
    weight = narrow.weight * mean[narrow.interval]
    uneven = np.where(replaced, cells.unevenness(narrow.interval_edges), 0.0)
    cut = np.flatnonzero(_largest(uneven, _CUT * float(np.sum(cells.micron) * cells.width)))
    if cut.size:
        near = np.flatnonzero(np.isin(narrow.interval, np.concatenate([cut - 1, cut, cut + 1])))
        values = cells.reference.at_points(narrow.subset(near), fitted=True)
        target = cells.reference.value[cells.reference.fitted]
        for number in cut:
            weight[narrow.interval == number] = 0.0
        for number in cut:
            part = np.flatnonzero(np.abs(narrow.interval[near] - number) <= 1)
            inside = cells.inside(low[number], high[number])
            weight[near[part]] += _fitted(values[:, part], target[:, inside], cells.micron[inside] * cells.width)
    counts = np.flatnonzero(weight > 0)
    chosen = narrow.subset(counts)
    if not coarse.size:
        return BandPoints(chosen, weight[counts], tuple(chosen.absorbing))
    unrefined = band_points(points.subset(coarse), response)
    joined, weights = unrefined.points.joined(chosen), np.concatenate([unrefined.weight, weight[counts]])
    order = np.argsort(joined.wavenumber, kind="stable")
    return BandPoints(joined.subset(order), weights[order], tuple(joined.absorbing))


def _fitted(values: Floats, cells: Floats, response: Floats) -> Floats:
    """Weights (K,) [um] with which values (m, K) at points sum to those of cells (m, C) under a response (C,) [um]."""
    total = response.sum()
    if total <= 0:
        return np.zeros(values.shape[1])
    rows = np.vstack([values, np.full((1, values.shape[1]), _SUM_WEIGHT)])
    share, _ = scipy.optimize.nnls(
        rows, np.append(cells @ response / total, _SUM_WEIGHT), maxiter=100 * values.shape[1]
    )
    return np.asarray(share * (total / share.sum()))


def _error(band: BandPoints, cells: _Cells, response: SpectralResponse) -> LineByLineError:
    """Of the band's transmittance and path radiance on the paths of the spectra: what another air is below, by the
    atmospheres that weights were fitted to and the others.
    """
    reference = cells.reference
    values = np.empty((reference.fitted.size, band.weight.size))
    for fitted in (True, False):
        values[reference.fitted == fitted] = reference.at_points(band.points, fitted=fitted)
    truth = reference.value @ cells.micron / cells.micron.sum()
    square = (values @ band.weight / band.weight.sum() - truth) ** 2
    # One draw for all paths of a band: two standard deviations.
    ends = 4.0 * _within_cells(cells, response)
    rms, largest = [], []
    for thermal in (False, True):
        kind = reference.emission == thermal
        airs = [kind & (reference.atmosphere == number) for number in np.unique(reference.atmosphere[kind])]
        likely = np.array([np.hypot(_likely_rms(square[air]), _INTERPOLATION) for air in airs])
        rms.append(float(np.hypot(_another(likely), np.sqrt(max(ends[air].mean() for air in airs)))))
        largest.append(max(rms[-1], float(np.hypot(np.sqrt((square + ends)[kind].max()), _INTERPOLATION))))
    return LineByLineError(*rms, *largest)


def _another(values: Floats) -> float:
    """What another value of a log-normal kind is below, with the likelihood `_LIKELIHOOD`, by n values above 0: the
    prediction limit of their logarithms (Hahn and Meeker 1991, section 4.8).
    """
    logarithm, count = np.log(values), values.size
    margin = scipy.special.stdtrit(count - 1, _LIKELIHOOD) * np.sqrt(1 + 1 / count)
    return float(np.exp(logarithm.mean() + margin * logarithm.std(ddof=1)))


def _within_cells(cells: _Cells, response: SpectralResponse) -> Floats:
    """Mean square (M,) of what the spectra err by where the response changes within a cell, as at a band's ends: the
    halves of a cell are taken to differ as neighbouring cells do.
    """
    micron, value = cells.micron, cells.reference.value
    beside = np.arange(micron.size) + np.array([[-1], [1]])
    before, after = np.clip(beside, 0, micron.size - 1)
    cut = np.flatnonzero(np.abs(micron[after] - micron[before]) > _EVEN * micron.max())
    lower = micron_response(response, cells.reference.cell[cut] - cells.width / 2, cells.width / 2, _SAMPLES)
    difference = ((value[:, before[cut]] - value[:, cut]) ** 2 + (value[:, after[cut]] - value[:, cut]) ** 2) / 2
    square: Floats = difference @ ((lower - micron[cut]) / 2) ** 2 / micron.sum() ** 2
    return square


def _likely_rms(square: Floats) -> float:
    """Root mean square of what squares (n,) of errors are drawn from, with two standard errors of their mean."""
    return float(np.sqrt(square.mean() + 2 * square.std(ddof=1) / np.sqrt(square.size)))
