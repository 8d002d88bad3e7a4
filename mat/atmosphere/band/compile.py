"""Compile a sensor band: choose and weight the few spectral points that replace all of them, for the air of a state and
the paths of its job.

The points of the band are reduced by the method that chose them within an interval (`selection.select_points`), with
the in-band quantities of a sample of the job's own paths as targets. What that costs is measured on other paths of the
same job, over the ground and in the light of the state itself; states that differ in these alone share the points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.band.sample import Sample
from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.band.targets import Responses, fitted_and_tested, responses
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import spectral_optics
from skyshine.mat.atmosphere.transfer.path_axes import PathAxes
from skyshine.schemas.arrays import Floats, Integers

# A larger number of candidates is thinned, evenly in mean logarithm of optical depth.
_MAX_CANDIDATES = 1600
# Lines of sight for the fit and for the test.
_TRAINING_RAYS, _TEST_RAYS = 160, 40
# Lines of sight on which the effect of each gas is measured.
_GAS_RAYS = 40
# Errors count relative to the quantity, or to this fraction of its largest value where it is below.
_FLOOR = 0.1
# Fractions of the tolerance for the omission of gases, in transmittance, and for the fit, on the paths it is made on.
# On other paths the error of the fit is two to three times as large.
_GAS_SHARE = 0.5
_FIT_SHARE = 0.3


@dataclass(frozen=True, eq=False)
class CompiledBand:
    """A band reduced to few points.

    Attributes
    ----------
    band : BandPoints
    index : (k,) int array
        The points' places among all points of the band.
    total_points : int
        Number of all points of the band.
    errors : dict
        By quantity (`targets.KINDS`): {"max", "p95", "rms"}, relative, on paths the points were not fitted to,
        against all points and all gases. Below 10 % of a quantity's largest value (of 1 for transmittance) errors count
        relative to that.
    dropped : dict
        Omitted gases: largest change of an in-band transmittance by each.
    ladder : (n,) array
        Error of the fit with 1, 2, ... points.
    """

    band: BandPoints
    index: Integers
    total_points: int
    errors: dict[str, dict[str, float]]
    dropped: dict[str, float]
    ladder: Floats


@dataclass(frozen=True, eq=False)
class FittedBand:
    """A band reduced to few points for some air, whatever the temperature of its ground and the distance of its
    sources.

    Attributes
    ----------
    band, index, total_points, dropped, ladder
        As `CompiledBand`.
    exact, approximate : targets.Responses
        Of all points and of the chosen ones, on the paths that the points were not fitted to.
    """

    band: BandPoints
    index: Integers
    total_points: int
    dropped: dict[str, float]
    ladder: Floats
    exact: Responses
    approximate: Responses

    def measured(self, surface_temperature: float, source_irradiance: Floats) -> CompiledBand:
        """The compiled band with its errors in one state.

        Parameters
        ----------
        surface_temperature : float
            K, of the ground.
        source_irradiance : (P,) or (B, P) array
            As `compile_band`.

        Returns
        -------
        CompiledBand
        """
        irradiance, brightness = _light(source_irradiance)
        exact = self.exact.mean(surface_temperature, irradiance, brightness)
        approximate = self.approximate.mean(surface_temperature, irradiance[:, self.index], brightness)
        errors = _errors(exact, approximate)
        return CompiledBand(self.band, self.index, self.total_points, errors, self.dropped, self.ladder)


def compile_band(
    state: AtmosphericState,
    band: BandPoints,
    grid: PathAxes,
    source_irradiance: Floats,
    *,
    tolerance: float = 1e-3,
    max_points: int = 64,
    seed: int = 0,
) -> CompiledBand:
    """Reduce a band to the points that meet a tolerance on the paths of a job.

    Parameters
    ----------
    state : AtmosphericState
    band : BandPoints
        All points, from `band_points`.
    grid : PathAxes
        The axes of the job's table.
    source_irradiance : (P,) or (B, P) array
        At all points, W m^-2 (cm^-1)^-1, of one source or of each of several that are to share the compiled band; the
        same at all points of an interval.
    tolerance : float
        Relative rms error.
    max_points : int
    seed : int
        Of the choice of paths and of `select_points`.

    Returns
    -------
    CompiledBand
    """
    fit = fit_band(
        over_air(state), band, grid, source_irradiance, tolerance=tolerance, max_points=max_points, seed=seed
    )
    return fit.measured(state.surface_temperature, source_irradiance)


def over_air(state: AtmosphericState) -> AtmosphericState:
    """The state with a ground as warm as the air on it, to which the points of a band are fitted."""
    return replace(state, surface_temperature=float(state.temperature[0]))


def fit_band(
    state: AtmosphericState,
    band: BandPoints,
    grid: PathAxes,
    source_irradiance: Floats,
    *,
    tolerance: float,
    max_points: int,
    seed: int,
) -> FittedBand:
    """The points of a compiled band, with the responses that give its errors under other ground temperatures and
    sources.

    Parameters
    ----------
    state, band, grid, source_irradiance, tolerance, max_points, seed
        As `compile_band`.

    Returns
    -------
    FittedBand
    """
    irradiance, brightness = _light(source_irradiance)
    air = SpectralAir.of(state, band.points, band.gases, band.weight)
    rng = np.random.default_rng(seed)
    training, test = (Sample.of(air.shells, grid, rays, rng) for rays in (_TRAINING_RAYS, _TEST_RAYS))
    gases, dropped = _drop_gases(air, band, training, tolerance * _GAS_SHARE)
    candidates = _candidates(air, training)
    fitted, exact = fitted_and_tested(air, band.weight, irradiance, brightness, training, candidates, test)
    # Each quantity has the same weight, whatever its number of rows.
    scale = {kind: 1 / (_size(kind, values) * np.sqrt(values.size)) for kind, values in fitted.mean.items()}
    chosen, weight, ladder = select_points(
        fitted.at_points.T,
        np.concatenate(list(fitted.mean.values())),
        tolerance=tolerance * _FIT_SHARE,
        max_points=max_points,
        total_weight=band.weight.sum(),
        exchanges=1,
        more_exchanges=2,
        row_scale=np.concatenate(list(scale.values())) * np.sqrt(len(fitted.at_points) / len(scale)),
        seed=seed,
    )
    order = np.argsort(candidates[chosen])
    index, weight = candidates[chosen][order], weight[order]
    few = BandPoints(band.points.subset(index), weight, gases)
    few_air = replace(air, optics=spectral_optics(state, few.points, gases))
    approximate = responses(few_air, weight / weight.sum(), test, len(irradiance))
    return FittedBand(few, index, band.weight.size, dropped, ladder, exact, approximate)


def _light(source_irradiance: Floats) -> tuple[Floats, Floats]:
    """Irradiance (B, P) of the sources and its mean (B,), by which errors in direct light are divided: moonlight counts
    like sunlight.
    """
    irradiance = np.atleast_2d(np.asarray(source_irradiance, dtype=float))
    return irradiance, np.maximum(irradiance.mean(axis=1), np.finfo(float).tiny)


def negligible_gases(
    air: SpectralAir, band: BandPoints, grid: PathAxes, *, tolerance: float = 1e-3, seed: int = 0
) -> dict[str, float]:
    """Gases that `compile_band` omits, with the largest change each makes in an in-band transmittance.

    Parameters
    ----------
    air : SpectralAir
        At all points of the band.
    band, grid, tolerance, seed
        As `compile_band`.

    Returns
    -------
    dict of str to float
    """
    training = Sample.of(air.shells, grid, _TRAINING_RAYS, np.random.default_rng(seed))
    return _drop_gases(air, band, training, tolerance * _GAS_SHARE)[1]


def _size(kind: str, values: Floats) -> Floats:
    """The values (M,) by which errors of a quantity's values (M,) are divided."""
    size: Floats = np.maximum(values, _FLOOR * (1.0 if kind == "transmittance" else values.max()))
    return size


def _candidates(air: SpectralAir, sample: Sample) -> Integers:
    """Indices of candidate points, spread evenly over the mean logarithm of optical depth."""
    count = air.optics.wavenumber.size
    if count <= _MAX_CANDIDATES:
        return np.arange(count)
    depth = sample.optical_depth(air.optics.extinction)
    order = np.argsort(np.mean(np.log(np.maximum(depth, 1e-30)), axis=0), kind="stable")
    return np.sort(order[np.linspace(0, count - 1, _MAX_CANDIDATES).astype(int)])


def _drop_gases(
    air: SpectralAir, band: BandPoints, sample: Sample, allowed: float
) -> tuple[tuple[str, ...], dict[str, float]]:
    """Gases that remain, and those omitted with the largest change each makes in an in-band transmittance; the changes
    sum to at most `allowed`.
    """
    gas_sample = replace(sample, lines=sample.lines[:_GAS_RAYS])
    mean = band.weight / band.weight.sum()
    depth = gas_sample.optical_depth(air.optics.extinction)
    transmittance = np.exp(-depth) @ mean
    effect: dict[str, float] = {}
    for gas, section in air.optics.absorption.items():
        without = np.maximum(depth - gas_sample.optical_depth(section), 0.0)
        effect[gas] = float(np.max(np.exp(-without) @ mean - transmittance, initial=0.0))
    dropped, total = {}, 0.0
    for gas in sorted(effect, key=effect.__getitem__):
        total += effect[gas]
        if total > allowed:
            break
        dropped[gas] = effect[gas]
    return tuple(gas for gas in effect if gas not in dropped), dropped


def _errors(exact: dict[str, Floats], approximate: dict[str, Floats]) -> dict[str, dict[str, float]]:
    """Relative errors by quantity, from in-band values (M,)."""
    result = {}
    for kind, values in exact.items():
        # A quantity that is 0 everywhere has no entry.
        error = (approximate.get(kind, np.zeros(1)) - values) / _size(kind, values)
        result[kind] = {
            "max": float(np.abs(error).max()),
            "p95": float(np.percentile(np.abs(error), 95)),
            "rms": float(np.sqrt(np.mean(error**2))),
        }
    return result
