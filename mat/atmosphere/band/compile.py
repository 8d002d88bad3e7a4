"""Compile a sensor band: choose and weight the few spectral points that replace all of them, for the air of a state and
the paths of its job.

The points of the band are reduced by the method that chose them within an interval (`selection.select_points`), with
the in-band quantities of a sample of the job's own paths as targets. What that costs is measured on other paths of the
same job, over the ground and in the light of the state itself; states that differ in these alone share the points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.band.sample import Sample, SampledLine
from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.band.targets import (
    DIRECT,
    KINDS,
    Responses,
    Targets,
    fitted_and_tested,
    fitted_targets,
    responses,
    tested_responses,
)
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import spectral_optics
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathAxes, PathScope
from skyshine.mat.atmosphere.transfer.scene_lines import REGIONS
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.schemas.arrays import Floats, Integers, Reals

# A larger number of candidates is thinned, evenly in mean logarithm of optical depth.
_MAX_CANDIDATES = 1600
# Candidates tried at each step of the choice; with twice as many the fit is no better.
_SHORT_LIST = 6
# Lines of sight for the fit and for the test.
_TRAINING_RAYS, _TEST_RAYS = 160, 240
_FEWEST = 10  # errors of a region that is stated apart
# The same for each of the airs in which points that many states share are tested: they err alike.
_SHARED_TEST_RAYS, _SHARED_TEST_SKIES = 64, 2
_OWN_RAYS = 24  # on which transmittance alone is tested in the air of each of these states
# Choices of shared points at most, and the part of the tolerance at which the next aims where one misses it.
_CHOICES, _FINER = 3, 0.9
_TEST_STREAM = 1  # stream of random numbers: what a band is tested on does not depend on what it was fitted to
# Elevations of the source at which the field of light scattered more than once is solved, degree, and its azimuthal
# moments: fewer than in tables, as points are many and all of them are compared in the same field.
_ELEVATIONS = (-8.0, 0.0, 5.0, 20.0, 90.0)
_AZIMUTHAL = 1
_NODES = 2  # nodes of each hemisphere; points chosen with 4 err no less in a field of 4
_HORIZON_DROP = 1.0  # degree by which the Sun is lower, or higher, at the far end of a long line of sight
# Errors count relative to the quantity, or to this fraction of its largest value where it is below.
_FLOOR = 0.1
# Fraction of the tolerance for the fit, on the paths it is made on. On other paths its error is two to three times as
# large.
_FIT_SHARE = 0.3


EVERYWHERE = "everywhere"  # among the regions of errors
Absolute = dict[str, list[dict[str, dict[str, float]]]]  # statistics by quantity, source, region, name


@dataclass(frozen=True, eq=False)
class CompiledBand:
    """A band reduced to few points.

    Attributes
    ----------
    index : (k,) int array
        The points' places among all points of the band.
    total_points : int
        Number of all points of the band.
    errors : dict
        Errors by quantity (`targets.KINDS`): {"max", "p95", "rms"}, relative, on paths the points were not fitted to,
        against all points. Below 10 % of a quantity's largest value (of 1 for transmittance) errors are
        relative to that.
    ladder : (n,) array
        Error of the fit with 1, 2, ... points.
    absolute : dict
        Errors by quantity, for each source, by region (`EVERYWHERE` and those of `REGIONS` with some lines): {"max",
        "p99", "p95", "rms"}, absolute: of transmittance in 1, of the others in band, W m^-2 sr^-1 or W m^-2.
    """

    band: BandPoints
    index: Integers
    total_points: int
    errors: dict[str, dict[str, float]]
    ladder: Floats
    absolute: Absolute = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ChosenPoints:
    """The points of a band, chosen for one air or for several.

    Attributes
    ----------
    band, index, total_points, ladder
        As `CompiledBand`.
    """

    band: BandPoints
    index: Integers
    total_points: int
    ladder: Floats

    @property
    def width(self) -> float:
        """Width of the band, in the measure of `BandPoints.weight`."""
        return float(self.band.weight.sum())

    def is_limited(self, tolerance: float) -> bool:
        """Whether the largest number of points, not the tolerance, ended the choice."""
        return bool(self.ladder[-1] > tolerance * _FIT_SHARE)

    def with_errors(self, errors: dict[str, dict[str, float]], absolute: Absolute) -> CompiledBand:
        """The compiled band of these points."""
        return CompiledBand(self.band, self.index, self.total_points, errors, self.ladder, absolute)


@dataclass(frozen=True, eq=False)
class FittedBand:
    """A band reduced to few points, tested in some air, whatever the temperature of its ground and the distance of its
    sources.

    Attributes
    ----------
    exact, approximate : targets.Responses
        Responses of all points and of the chosen ones, on paths that the points were not fitted to.
    """

    chosen: ChosenPoints
    exact: Responses
    approximate: Responses

    def measured(self, surface_temperature: float, source_irradiance: Floats) -> CompiledBand:
        """The compiled band with its errors in one state.

        Parameters
        ----------
        surface_temperature : float
            K, of the ground.
        source_irradiance : (P,) or (B, P) array
            Irradiance as in `compile_band`.
        """
        chosen, (irradiance, brightness) = self.chosen, _light(source_irradiance)
        exact = self.exact.mean(surface_temperature, irradiance, brightness)
        approximate = self.approximate.mean(surface_temperature, irradiance[:, chosen.index], brightness)
        errors = _errors(exact, approximate), _absolute(exact, approximate, self.exact, brightness, chosen.width)
        return chosen.with_errors(*errors)


@dataclass(frozen=True, eq=False)
class AirTest:
    """In-band values of a sample in some air, at all points of a band and at the chosen ones.

    Attributes
    ----------
    exact, approximate : dict of (2, M) arrays
        Values by quantity at all points, and at the chosen ones: without light of a source, and what the usual light of
        the sources adds; direct light relative to its brightness.
    source, region : dict of (M,) int arrays
        Sources and regions, as in `Responses`.
    """

    exact: dict[str, Floats]
    approximate: dict[str, Floats]
    source: dict[str, Integers]
    region: dict[str, Integers]

    @classmethod
    def of(cls, fit: FittedBand, surface_temperature: float, usual_irradiance: Floats) -> AirTest:
        """The values of a fit over a ground [K], under usual sources (B, P)."""
        irradiance, brightness = _light(usual_irradiance)

        def parts(responses: Responses, light: Floats) -> dict[str, Floats]:
            lit = responses.mean(surface_temperature, light, brightness)
            dark = responses.mean(surface_temperature, np.zeros_like(light), brightness)
            unlit = {kind: dark.get(kind, np.zeros_like(values)) for kind, values in lit.items()}
            return {kind: np.stack([unlit[kind], values - unlit[kind]]) for kind, values in lit.items()}

        exact = parts(fit.exact, irradiance)
        approximate = parts(fit.approximate, irradiance[:, fit.chosen.index])
        places = ({kind: values[kind] for kind in exact} for values in (fit.exact.source, fit.exact.region))
        return cls(exact, {kind: approximate.get(kind, np.zeros_like(exact[kind])) for kind in exact}, *places)

    def errors(
        self, brighter: Floats, brightness: Floats, width: float
    ) -> tuple[dict[str, dict[str, float]], Absolute]:
        """`CompiledBand.errors` and `absolute` under sources of brightness (B,), so many times (B,) the usual ones."""

        def values(parts: dict[str, Floats]) -> dict[str, Floats]:
            return {
                kind: unlit + lit * (1.0 if kind == DIRECT else brighter[self.source[kind]])
                for kind, (unlit, lit) in parts.items()
            }

        exact, approximate = values(self.exact), values(self.approximate)
        return _errors(exact, approximate), _absolute(exact, approximate, self, brightness, width)


@dataclass(frozen=True, eq=False)
class SimilarAirs:
    """Airs of a cell over ground as warm as they are: `corners`, for which points are chosen, and others `inside`."""

    corners: tuple[AtmosphericState, ...]
    inside: tuple[AtmosphericState, ...]


@dataclass(frozen=True, eq=False)
class SharedPoints:
    """Points of a band for a cell of airs.

    Attributes
    ----------
    chosen : ChosenPoints
    tests : tuple of AirTest
        Tests in airs of the cell other than those for which the points were chosen.
    usual_brightness : (B,) array
        Brightness of the usual sources.
    """

    chosen: ChosenPoints
    tests: tuple[AirTest, ...]
    usual_brightness: Floats

    @property
    def worst(self) -> float:
        """The largest relative rms error of a quantity in the airs of the tests, under the usual sources."""
        bright = self.usual_brightness
        tests = (test.errors(np.ones_like(bright), bright, self.chosen.width)[0] for test in self.tests)
        return max(error["rms"] for errors in tests for error in errors.values())

    def measured(self, source_irradiance: Floats) -> CompiledBand:
        """The compiled band of a state of the cell under its sources; the errors are the largest of the tests."""
        _, brightness = _light(source_irradiance)
        brighter = brightness / self.usual_brightness
        tests = [test.errors(brighter, brightness, self.chosen.width) for test in self.tests]
        return self.chosen.with_errors(*(_largest(list(part)) for part in zip(*tests, strict=True)))


def _largest(parts: Sequence[Any]) -> Any:
    """The largest of numbers at the same places of nested dicts and lists; places need not be in all of them."""
    first = parts[0]
    if isinstance(first, dict):
        keys = dict.fromkeys(key for part in parts for key in part)
        return {key: _largest([part[key] for part in parts if key in part]) for key in keys}
    if isinstance(first, list):
        return [_largest(numbers) for numbers in zip(*parts, strict=True)]
    return max(parts)


def _absolute(
    exact: dict[str, Floats],
    approximate: dict[str, Floats],
    places: Responses | AirTest,
    brightness: Floats,
    width: float,
) -> Absolute:
    """`CompiledBand.absolute` of in-band means (M,) by quantity at places, direct light relative to brightness (B,)."""
    result: Absolute = {}
    for kind, values in exact.items():
        error, source = np.abs(approximate.get(kind, np.zeros(1)) - values), places.source[kind]
        region = places.region[kind]
        if kind != "transmittance":
            error = error * width
        if kind == DIRECT:
            error = error * brightness[source]
        sunlit = kind not in ("transmittance", "path_thermal")
        result[kind] = [
            _by_region(error[rows], region[rows])
            for rows in ((source == number) | (not sunlit) for number in range(brightness.size))
        ]
    return result


def compile_band(
    state: AtmosphericState,
    band: BandPoints,
    grid: PathAxes,
    source_irradiance: Floats,
    *,
    tolerance: float = 1e-3,
    max_points: int = 64,
    seed: int = 0,
    scope: PathScope = ALL_PATHS,
) -> CompiledBand:
    """Reduce a band to the points that meet a tolerance on the paths of a job.

    Parameters
    ----------
    band : BandPoints
        All points, from `band_points`.
    grid : PathAxes
        The axes of the job's table.
    source_irradiance : (P,) or (B, P) array
        Irradiance at all points, W m^-2 (cm^-1)^-1, of one source or of each of several that share the compiled band;
        the same at all points of an interval.
    tolerance : float
        Relative rms error.
    seed : int
        Seed of the choice of paths and of `select_points`.
    scope : PathScope, optional
        What the axes are of those of the job; by default all.
    """
    fit = fit_band(
        over_air(state),
        band,
        grid,
        source_irradiance,
        tolerance=tolerance,
        max_points=max_points,
        seed=seed,
        scope=scope,
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
    scope: PathScope = ALL_PATHS,
) -> FittedBand:
    """The points of a compiled band, with the responses that give its errors under other ground temperatures and
    sources.

    Parameters
    ----------
    state, band, grid, source_irradiance, tolerance, max_points, seed, scope
        As `compile_band`.
    """
    sampled = SampledBand.of(state, band, grid, source_irradiance, seed, scope)
    return sampled.fitted(tolerance, max_points)


@dataclass(frozen=True, eq=False)
class SampledBand:
    """All points of a band on sample paths through some air: what any tolerance chooses its points by.

    Attributes
    ----------
    state, band, seed
        As `compile_band`.
    sources : int
        Number of sources.
    air : SpectralAir
        Air at all points.
    test : Sample
        Paths on which points are tested, with the responses `exact` of all points there.
    candidates : (C,) int array
        Points that may be chosen, with their `targets` on the paths of the fit.
    """

    state: AtmosphericState
    band: BandPoints
    seed: int
    sources: int
    air: SpectralAir
    test: Sample
    candidates: Integers
    targets: Targets
    exact: Responses

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        band: BandPoints,
        grid: PathAxes,
        source_irradiance: Floats,
        seed: int,
        scope: PathScope = ALL_PATHS,
    ) -> SampledBand:
        """Sample a band; parameters as `compile_band`."""
        irradiance, brightness = _light(source_irradiance)
        air = _air(state, band, grid, scope)
        training = _training(air, grid, 1, np.random.default_rng(seed), scope)
        test = _test(air, grid, seed, scope)
        candidates = _candidates([air], [training])
        targets, exact = fitted_and_tested(air, band.weight, irradiance, brightness, training, candidates, test)
        return cls(state, band, seed, len(irradiance), air, test, candidates, targets, exact)

    def fitted(self, tolerance: float, max_points: int) -> FittedBand:
        """The points that meet a tolerance."""
        chosen = _chosen([self.targets], self.candidates, self.band, tolerance, max_points, self.seed)
        approximate = _approximate(chosen, self.state, self.air, self.test, self.sources)
        return FittedBand(chosen, self.exact, approximate)


def choose_points(
    states: Sequence[AtmosphericState],
    inside: Sequence[AtmosphericState],
    band: BandPoints,
    grid: PathAxes,
    source_irradiance: Floats,
    *,
    tolerance: float,
    max_points: int,
    seed: int,
    scope: PathScope = ALL_PATHS,
) -> SharedPoints:
    """Points of a band that are to suffice in several airs, and between them.

    Points that miss the tolerance inside are chosen anew by a finer one.

    Parameters
    ----------
    states : sequence of AtmosphericState
        Airs for which the points are chosen. Their sample of paths is about as large together as that of one state in
        `compile_band`.
    inside : sequence of AtmosphericState
        Airs between them, in which the points are tested.
    band, grid, source_irradiance, tolerance, max_points, seed, scope
        As `compile_band`.
    """
    irradiance, brightness = _light(source_irradiance)
    airs, generator = [_air(state, band, grid, scope) for state in states], np.random.default_rng(seed)
    training = [_training(air, grid, len(airs), generator, scope) for air in airs]
    candidates = _candidates(airs, training)
    targets = [
        fitted_targets(air, band.weight, irradiance, brightness, sample, candidates)
        for air, sample in zip(airs, training, strict=True)
    ]
    del airs  # their fields take 100 MB each
    tested = [_tested(state, band, grid, len(irradiance), seed, scope) for state in inside]
    aim = tolerance
    for _ in range(_CHOICES):
        chosen = _chosen(targets, candidates, band, aim, max_points, seed)
        fits = [
            FittedBand(chosen, exact, _approximate(chosen, state, air, test, len(irradiance)))
            for state, (air, test, exact) in zip(inside, tested, strict=True)
        ]
        tests = (
            AirTest.of(fit, state.surface_temperature, irradiance) for fit, state in zip(fits, inside, strict=True)
        )
        shared = SharedPoints(chosen, tuple(tests), brightness)
        if (worst := shared.worst) <= tolerance or chosen.index.size >= max_points:
            break
        aim *= _FINER * tolerance / worst
    return shared


def _tested(
    state: AtmosphericState, band: BandPoints, grid: PathAxes, sources: int, seed: int, scope: PathScope
) -> tuple[SpectralAir, Sample, Responses]:
    """Air of a state without its fields, paths in it, fewer than those on which `fit_band` tests, and the responses of
    all points there.
    """
    air = _air(state, band, grid, scope)
    test = _test(air, grid, seed, scope, _SHARED_TEST_RAYS, skies=_SHARED_TEST_SKIES)
    return replace(air), test, tested_responses(air, band.weight, test, sources)


def with_errors_of_own_air(
    compiled: CompiledBand,
    state: AtmosphericState,
    band: BandPoints,
    grid: PathAxes,
    seed: int,
    scope: PathScope = ALL_PATHS,
) -> CompiledBand:
    """A band of shared points with the errors of transmittance in a state's own air, on few paths, where these are
    larger; arguments as `compile_band`.
    """
    air, points = air_at_all_points(state, band), compiled.band
    test = _test(air, grid, seed, scope, _OWN_RAYS, skies=1)
    few = spectral_optics(state, points.points, points.gases).extinction.astype(np.float32)
    every = air.optics.extinction.astype(np.float32)
    shares = (weight / weight.sum() for weight in (band.weight, points.weight))
    exact, approximate = (
        np.concatenate([_transmittance(line, extinction) @ share for line in test.lines])
        for extinction, share in zip((every, few), shares, strict=True)
    )
    kind, region = KINDS[0], np.concatenate([line.region for line in test.lines])
    errors = _errors({kind: exact}, {kind: approximate})
    absolute = {kind: [_by_region(np.abs(approximate - exact), region)] * len(compiled.absolute[kind])}
    return replace(
        compiled,
        errors=_largest([compiled.errors, errors]),
        absolute=_largest([compiled.absolute, absolute]),
    )


@lru_cache(maxsize=1)
def air_at_all_points(state: AtmosphericState, band: BandPoints) -> SpectralAir:
    """Air of a state at all points of a band: of the last one, which both its points and its tables ask for."""
    return SpectralAir.of(state, band.points, band.gases, band.weight)


def _transmittance(line: SampledLine, extinction: Reals) -> Floats:
    """Transmittances (R, P) along a line to its ranges."""
    depths = Depths(line.segments.column(extinction))
    through: Floats = np.exp(-depths.cumulative[line.node].astype(float))
    return through


def _air(state: AtmosphericState, band: BandPoints, grid: PathAxes, scope: PathScope) -> SpectralAir:
    """Air at all points of a band; the field of the source's light is solved at few elevations, in plane layers: all
    points and the chosen ones are compared in the same field.
    """
    elevations = np.array(_ELEVATIONS)
    if scope.is_part:  # those around the source
        low, high = np.maximum(grid.source_elevation_deg[[0, -1]], 0.0)
        start = int(np.searchsorted(elevations, low - _HORIZON_DROP, side="right")) - 1
        elevations = elevations[start : int(np.searchsorted(elevations, high + _HORIZON_DROP)) + 1]
    air = SpectralAir.of(state, band.points, band.gases, band.weight)
    return replace(air, elevations=tuple(elevations.tolist()), azimuthal=_AZIMUTHAL, nodes=_NODES, spherical=False)


def _training(air: SpectralAir, grid: PathAxes, airs: int, generator: np.random.Generator, scope: PathScope) -> Sample:
    """The share of one of some airs in the paths to which points are fitted."""
    rays = scope.lines(_TRAINING_RAYS)
    return Sample.for_fit(air.shells, grid, -(-rays // airs), generator, scope=scope)


def _test(
    air: SpectralAir,
    grid: PathAxes,
    seed: int,
    scope: PathScope,
    rays: int = _TEST_RAYS,
    **settings: int,
) -> Sample:
    rays, generator = scope.lines(rays), np.random.default_rng([seed, _TEST_STREAM])
    return Sample.for_test(air.shells, grid, rays, generator, scope=scope, **settings)


def _approximate(
    chosen: ChosenPoints, state: AtmosphericState, air: SpectralAir, test: Sample, sources: int
) -> Responses:
    """Responses of the chosen points on the test paths through the air at all points."""
    reduced = chosen.band
    few_air = replace(air, optics=spectral_optics(state, reduced.points, reduced.gases))
    return responses(few_air, reduced.weight / reduced.weight.sum(), test, sources)


def _chosen(
    targets: Sequence[Targets],
    candidates: Integers,
    band: BandPoints,
    tolerance: float,
    max_points: int,
    seed: int,
) -> ChosenPoints:
    """Points among the candidates that meet the targets of one air or of each of several."""
    # Each quantity in each air has the same weight, whatever its number of rows.
    means = [(kind, values) for air in targets for kind, values in air.mean.items()]
    scale = np.concatenate([1 / (_size(kind, values) * np.sqrt(values.size)) for kind, values in means])
    index, weight, ladder = select_points(
        np.concatenate([air.at_points for air in targets]).T,
        np.concatenate([values for _, values in means]),
        tolerance=tolerance * _FIT_SHARE,
        max_points=max_points,
        total_weight=band.weight.sum(),
        exchanges=1,
        more_exchanges=2,
        short_list=_SHORT_LIST,
        row_scale=scale * np.sqrt(scale.size / len(means)),
        seed=seed,
    )
    order = np.argsort(candidates[index])
    index, weight = candidates[index][order], weight[order]
    reduced = BandPoints(band.points.subset(index), weight, band.gases)
    return ChosenPoints(reduced, index, band.weight.size, ladder)


def _light(source_irradiance: Floats) -> tuple[Floats, Floats]:
    """Irradiance (B, P) of the sources and its mean (B,), by which errors in direct light are divided: moonlight counts
    like sunlight.
    """
    irradiance = np.atleast_2d(np.asarray(source_irradiance, dtype=float))
    return irradiance, np.maximum(irradiance.mean(axis=1), np.finfo(float).tiny)


def _size(kind: str, values: Floats) -> Floats:
    """The values (M,) by which errors of a quantity's values (M,) are divided."""
    size: Floats = np.maximum(values, _FLOOR * (1.0 if kind == "transmittance" else values.max()))
    return size


def _candidates(airs: Sequence[SpectralAir], samples: Sequence[Sample]) -> Integers:
    """Indices of candidate points, spread evenly over the mean logarithm of optical depth."""
    count = airs[0].optics.wavenumber.size
    if count <= _MAX_CANDIDATES:
        return np.arange(count)
    mean = np.zeros(count)
    for air, sample in zip(airs, samples, strict=True):
        depth = sample.optical_depth(air.optics.extinction)
        mean += np.mean(np.log(np.maximum(depth, 1e-30)), axis=0)
    order = np.argsort(mean, kind="stable")
    return np.sort(order[np.linspace(0, count - 1, _MAX_CANDIDATES).astype(int)])


def _errors(exact: dict[str, Floats], approximate: dict[str, Floats]) -> dict[str, dict[str, float]]:
    """Relative errors by quantity, from in-band values (M,)."""
    result = {}
    for kind, values in exact.items():
        # A quantity that is 0 everywhere has no entry.
        error = np.abs(approximate.get(kind, np.zeros(1)) - values) / _size(kind, values)
        statistics = _statistics(error)
        result[kind] = {name: statistics[name] for name in ("max", "p95", "rms")}
    return result


def _by_region(error: Floats, region: Integers) -> dict[str, dict[str, float]]:
    """Statistics of the sizes of errors (M,), of all and of each region that has enough."""
    rows = {name: region == number for number, name in enumerate(REGIONS)}
    parts = {name: error[inside] for name, inside in rows.items() if np.count_nonzero(inside) >= _FEWEST}
    return {name: _statistics(values) for name, values in ({EVERYWHERE: error} | parts).items()}


def _statistics(error: Floats) -> dict[str, float]:
    """Statistics of the sizes of errors (M,); 0 of none."""
    if not error.size:
        return dict.fromkeys(("max", "p99", "p95", "rms"), 0.0)
    p99, p95 = np.percentile(error, (99, 95))
    return {
        "max": float(error.max()),
        "p99": float(p99),
        "p95": float(p95),
        "rms": float(np.sqrt(np.mean(error**2))),
    }
