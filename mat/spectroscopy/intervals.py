"""From lines to the spectral points of one interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.gases.path_states import PathState, planck_ratio, slab_emission
from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, CrossSectionNodes, water_continuum
from skyshine.mat.spectroscopy import linebyline, nodes
from skyshine.mat.spectroscopy.continua import ContinuumModel
from skyshine.mat.spectroscopy.gases import GASES, LONGEST_COLUMN
from skyshine.mat.spectroscopy.sources import GasSources, SpectralSource
from skyshine.schemas.arrays import Floats, Integers, Singles

CANDIDATES = 1000  # fine wavenumbers among which an interval's points are chosen
SINGLE_GAS_SCALE = 0.7  # importance of transmittances by single gases
EXCHANGES = 4  # passes that improve the greedy choice
PRESENT = 1e-3  # a gas is in an interval when its optical depth exceeds this on the longest path
FLOOR = 1e-37  # m2/molecule; 300 km of air at sea level: 1e-6 optical depth
REFERENCE_CELL = 0.125  # cm^-1, of reference spectra; the fine grid's points divide into such cells evenly


@dataclass(frozen=True)
class IntervalPoints:
    """The points of one interval.

    Attributes
    ----------
    low, high : float, cm^-1
    wavenumber, weight : (K,) arrays, cm^-1
    cross_section : dict of (K, P, T) arrays, m2/molecule in dry air
    humid : dict of (K, Q - 1, H, T) arrays
        Logarithm of the ratio of cross sections in moist and dry air, at `nodes.H2O_FRACTION[1:]` and the H highest
        pressures.
    continuum : (3, K) array
        Water vapour continuum at the points: self, foreign (m2/molecule per cm^-1), self exponent.
    error : (4,) array
        Errors on held-out paths: rms and largest error of the mixture's transmittance, rms and largest of single gases.
    gas_error : dict of float
        Errors by gas on held-out paths: rms error of the transmittance.
    reference : (M, C) array or None
        Values line by line over the cells of the interval, for each state that `build_interval` is given for it, as
        those of `PathState.values`.
    """

    low: float
    high: float
    wavenumber: Floats
    weight: Floats
    cross_section: dict[str, Floats]
    humid: dict[str, Floats]
    continuum: Floats
    error: Floats
    gas_error: dict[str, float]
    reference: Singles | None = None


class Spectra:
    """Monochromatic cross sections of all gases on the fine grid of an interval."""

    def __init__(
        self, sources: Sequence[GasSources[SpectralSource]], continua: ContinuumModel, low: float, high: float
    ) -> None:
        self.low, self.high = low, high
        self.wavenumber = linebyline.interval_grid(low, high)
        self.water = continua.water_coefficients(self.wavenumber)
        self.tables: dict[str, Singles] = {}
        self.moist: dict[str, Singles] = {}
        for gas in sources:
            source = gas.source(low, high)
            if source is None:
                continue
            table = source.spectrum(self.wavenumber, low, high)
            depth = table[-1].max(axis=0) * GASES[source.name].largest_fraction * LONGEST_COLUMN
            if depth.max() > PRESENT:
                self.tables[source.name] = np.log(np.maximum(table, FLOOR)).astype(np.float32)
                moist = source.moist_spectrum(self.wavenumber, low, high)
                if moist is not None:
                    logarithm = np.log(np.maximum(moist, FLOOR)).astype(np.float32)
                    self.moist[source.name] = logarithm - self.tables[source.name][nodes.HUMID_PRESSURE :]

    def at_levels(self, state: PathState) -> dict[str, Singles]:
        """Absorption by gas per molecule of air at the levels of a state: dict of (L, K), m2; H2O means its lines."""
        dry = CrossSectionNodes(nodes.PRESSURE, nodes.TEMPERATURE)
        humid = CrossSectionNodes(nodes.PRESSURE[nodes.HUMID_PRESSURE :], nodes.TEMPERATURE, nodes.H2O_FRACTION)
        by_dry = dry.weights(state.pressure, state.temperature).astype(np.float32)
        by_humid = humid.weights(state.pressure, state.temperature, state.h2o_fraction).astype(np.float32)
        result = {}
        for gas, table in self.tables.items():
            logarithm = by_dry @ table.reshape(-1, table.shape[-1])
            if gas in self.moist:
                logarithm += by_humid @ self.moist[gas].reshape(-1, table.shape[-1])
            result[gas] = np.exp(logarithm) * state.fraction[gas][:, None].astype(np.float32)
        continuum = water_continuum(*self.water, self.wavenumber, state.pressure, state.temperature, state.h2o_fraction)
        result[CONTINUUM] = (continuum * state.h2o_fraction[:, None]).astype(np.float32)
        return result


def targets(spectra: Spectra, states: Sequence[PathState]) -> tuple[Singles, npt.NDArray[np.str_]]:
    """Rows whose interval mean the points have to reproduce.

    Returns
    -------
    rows : (M, K) float32 array
        Transmittances of the mixture and by gas, thermal path radiance over the blackbody of the warmest level.
    kind : (M,) array of str
        "mixture", "emission" or the name of a gas.
    """
    rows: list[Singles] = []
    kind: list[str] = []
    for state in states:
        levels = spectra.at_levels(state)
        columns = state.columns.astype(np.float32)
        depth = {gas: columns @ absorption for gas, absorption in levels.items()}
        rows.append(np.exp(-np.asarray(sum(depth.values()))))
        kind += ["mixture"] * len(columns)
        for gas in spectra.tables:
            transmittance = np.exp(-depth[gas][state.apart])
            matters = transmittance.min(axis=1) < 0.998
            rows.append(transmittance[matters])
            kind += [gas] * int(matters.sum())
        total = np.asarray(sum(levels.values()))
        source = planck_ratio(0.5 * (spectra.low + spectra.high), state.temperature)
        for slabs in state.emission:
            rows.append(slab_emission(slabs.astype(np.float32) @ total, source)[None])
            kind.append("emission")
    return np.concatenate(rows), np.array(kind)


def build_interval(
    sources: Sequence[GasSources[SpectralSource]],
    continua: ContinuumModel,
    low: float,
    high: float,
    training: Sequence[PathState],
    held_out: Sequence[PathState],
    *,
    tolerance: float,
    max_points: int,
    reference: Sequence[PathState] = (),
) -> IntervalPoints:
    """Choose the points of [low, high] and tabulate the cross sections there.

    Parameters
    ----------
    training, held_out : lists of PathState
    tolerance : float
        Scaled rms error at which no further points are added.
    reference : list of PathState, optional
        States for `IntervalPoints.reference`.
    """
    spectra = Spectra(sources, continua, low, high)
    rows, kind = targets(spectra, training)
    scale = np.where((kind == "mixture") | (kind == "emission"), 1.0, SINGLE_GAS_SCALE)
    candidates = _stratified(rows[kind == "mixture"], CANDIDATES, seed=round(low * 10))
    index, weight, _ = select_points(
        rows[:, candidates].T.astype(float),
        rows.mean(axis=1, dtype=float),
        tolerance=tolerance,
        max_points=max_points,
        total_weight=high - low,
        row_scale=scale,
        exchanges=EXCHANGES,
    )
    order = np.argsort(candidates[index])
    where, weight = candidates[index][order], weight[order]
    error, gas_error = _errors(spectra, held_out, where, weight / (high - low))
    wavenumber = spectra.wavenumber[where]
    cross_section, humid = {}, {}
    for gas in sources:
        source = gas.source(low, high)
        if source is not None and gas.name in spectra.tables:
            cross_section[gas.name], humid_ratio = source.points(wavenumber, low, high)
            if humid_ratio is not None:
                humid[gas.name] = humid_ratio
    continuum = np.array(continua.water_coefficients(wavenumber))
    means = _cell_means(spectra, reference) if reference else None
    return IntervalPoints(low, high, wavenumber, weight, cross_section, humid, continuum, error, gas_error, means)


def _cell_means(spectra: Spectra, states: Sequence[PathState]) -> Singles:
    """Values of the paths of all states, line by line, over each cell of an interval: (M, C)."""
    middle, cells = 0.5 * (spectra.low + spectra.high), round((spectra.high - spectra.low) / REFERENCE_CELL)
    rows = []
    for state in states:
        total = np.asarray(sum(spectra.at_levels(state).values()))
        rows.append(state.values(total, middle).reshape(len(state.columns) + len(state.emission), cells, -1).mean(-1))
    return np.concatenate(rows)


def _stratified(mixture: Singles, count: int, seed: int) -> Integers:
    """Fine wavenumbers spread evenly over the range of mean absorption, in two ways: of all paths and of thin ones."""
    rng = np.random.default_rng(seed)
    size = mixture.shape[1]
    if size <= count:
        return np.arange(size)
    mean = mixture.mean(axis=1)
    chosen = []
    for lowest in (0.0, 0.5):
        key = (mean >= lowest).astype(np.float32) @ mixture
        edges = np.linspace(0, size, count // 2 + 1).astype(int)
        order = np.argsort(key, kind="stable")
        chosen.append(order[rng.integers(edges[:-1], edges[1:])])
        extremes = [order[0], order[-1]]
    return np.unique(np.concatenate([*chosen, extremes]))


def _errors(
    spectra: Spectra, states: Sequence[PathState], where: Integers, weight: Floats
) -> tuple[Floats, dict[str, float]]:
    """Errors (4,) as `IntervalPoints.error`, and the rms error by gas."""
    rows, kind = targets(spectra, states)
    error = rows[:, where].astype(float) @ weight - rows.mean(axis=1, dtype=float)
    mixture, single = error[kind == "mixture"], error[(kind != "mixture") & (kind != "emission")]
    single = single if single.size else np.zeros(1)
    by_gas = {gas: float(np.sqrt(np.mean(error[kind == gas] ** 2))) for gas in spectra.tables if np.any(kind == gas)}
    summary = [np.sqrt(np.mean(mixture**2)), np.abs(mixture).max(), np.sqrt(np.mean(single**2)), np.abs(single).max()]
    return np.array(summary), by_gas
