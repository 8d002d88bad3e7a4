"""Compile a sensor band: the few spectral points that stand for all of them, for the air of a state and the paths of
its job.

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
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import spectral_optics

# Candidates beyond these many are thinned, evenly in mean logarithm of optical depth: 4,000 are more than enough for a
# band.
_MAX_CANDIDATES = 1600
# Lines of sight for the fit and for the test.
_TRAINING_RAYS, _TEST_RAYS = 160, 40
# Lines of sight on which the gases are weighed.
_GAS_RAYS = 40
# Errors count relative to the quantity, or to this fraction of its largest value where it is below.
_FLOOR = 0.1
# Gases left out may together take this fraction of the tolerance, in transmittance; the fit itself, on its own paths,
# the other. On other paths its error is two to three times that on its own.
_GAS_SHARE = 0.5
_FIT_SHARE = 0.3


@dataclass(frozen=True, eq=False)
class CompiledBand:
    """A band reduced to few points.

    Attributes
    ----------
    band : BandPoints
    index : (k,) int array
        The points' places among all of the band.
    total_points : int
        How many those are.
    errors : dict
        By quantity (`band_targets.KINDS`): {"max", "p95", "rms"}, relative, on paths the points were not fitted to,
        against all points and all gases. Below 10 % of a quantity's largest value (of 1 for transmittance) errors count
        relative to that.
    dropped : dict
        Gases left out: largest change of an in-band transmittance by each.
    ladder : (n,) array
        Error of the fit with 1, 2, ... points.
    """

    band: BandPoints
    index: np.ndarray
    total_points: int
    errors: dict[str, dict[str, float]]
    dropped: dict[str, float]
    ladder: np.ndarray


@dataclass(frozen=True, eq=False)
class FittedBand:
    """A band reduced to few points for some air, whatever the temperature of its ground and the distance of its
    sources.

    Attributes
    ----------
    band, index, total_points, dropped, ladder
        As `CompiledBand`.
    exact, found : band_targets.Responses
        On the paths that the points were not fitted to: of all points, of the few.
    """

    band: BandPoints
    index: np.ndarray
    total_points: int
    dropped: dict[str, float]
    ladder: np.ndarray
    exact: Responses
    found: Responses

    def measured(self, surface_temperature, source_irradiance):
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
        found = self.found.mean(surface_temperature, irradiance[:, self.index], brightness)
        return CompiledBand(self.band, self.index, self.total_points, _errors(exact, found), self.dropped, self.ladder)


def compile_band(state, band, grid, source_irradiance, *, tolerance=1e-3, max_points=64, seed=0):
    """Reduce a band to the points that hold a tolerance on the paths of a job.

    Parameters
    ----------
    state : AtmosphericState
    band : BandPoints
        All points, from `band_points`.
    grid : path_grid.PathGrid
        The job's own axes.
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
    settings = {"tolerance": tolerance, "max_points": max_points, "seed": seed}
    return fit_band(over_air(state), band, grid, source_irradiance, **settings).measured(
        state.surface_temperature, source_irradiance
    )


def over_air(state):
    """The state with a ground as warm as the air on it, to which the points of a band are fitted."""
    return replace(state, surface_temperature=float(state.temperature[0]))


def fit_band(state, band, grid, source_irradiance, *, tolerance, max_points, seed):
    """The points of a compiled band, with what its errors follow from in states that differ in ground temperature and
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
    kept, dropped = _drop_gases(air, band, training, tolerance * _GAS_SHARE)
    candidates = _candidates(air, training)
    fitted, exact = fitted_and_tested(air, band.weight, irradiance, brightness, training, candidates, test)
    # Each quantity counts the same, however many rows it has.
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
    few = BandPoints(band.points.subset(index), weight, kept)
    found = responses(
        replace(air, optics=spectral_optics(state, few.points, kept)), weight / weight.sum(), test, len(irradiance)
    )
    return FittedBand(few, index, band.weight.size, dropped, ladder, exact, found)


def _light(source_irradiance):
    """Irradiance (B, P) of the sources, and how bright each is: direct light counts against that, moonlight like
    sunlight.
    """
    irradiance = np.atleast_2d(np.asarray(source_irradiance, dtype=float))
    return irradiance, np.maximum(irradiance.mean(axis=1), np.finfo(float).tiny)


def negligible_gases(air, band, grid, *, tolerance=1e-3, seed=0):
    """Gases that `compile_band` leaves out, with the largest change each makes in an in-band transmittance.

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


def _size(kind, values):
    """What an error in each value is measured against."""
    return np.maximum(values, _FLOOR * (1.0 if kind == "transmittance" else values.max()))


def _candidates(air, sample):
    """Indices of candidate points, spread evenly over the mean logarithm of optical depth."""
    count = air.optics.wavenumber.size
    if count <= _MAX_CANDIDATES:
        return np.arange(count)
    depth = sample.optical_depth(air.optics.extinction)
    order = np.argsort(np.mean(np.log(np.maximum(depth, 1e-30)), axis=0), kind="stable")
    return np.sort(order[np.linspace(0, count - 1, _MAX_CANDIDATES).astype(int)])


def _drop_gases(air, band, sample, allowed):
    """Gases kept, and those left out with the largest change each makes in an in-band transmittance."""
    some = replace(sample, sights=sample.sights[:_GAS_RAYS])
    mean = band.weight / band.weight.sum()
    depth = some.optical_depth(air.optics.extinction)
    through = np.exp(-depth) @ mean
    effect = {}
    for gas, section in air.optics.absorption.items():
        without = np.maximum(depth - some.optical_depth(section), 0.0)
        effect[gas] = float(np.max(np.exp(-without) @ mean - through, initial=0.0))
    dropped, total = {}, 0.0
    for gas in sorted(effect, key=effect.get):
        total += effect[gas]
        if total > allowed:
            break
        dropped[gas] = effect[gas]
    return tuple(gas for gas in effect if gas not in dropped), dropped


def _errors(exact, approximate):
    """Errors by quantity, from in-band values."""
    result = {}
    for kind, values in exact.items():
        error = (approximate.get(kind, 0.0) - values) / _size(
            kind, values
        )  # a quantity that is 0 everywhere has no entry
        result[kind] = {
            "max": float(np.abs(error).max()),
            "p95": float(np.percentile(np.abs(error), 95)),
            "rms": float(np.sqrt(np.mean(error**2))),
        }
    return result
