"""Compile a sensor band: the few spectral points that stand for all of them, for one state and the paths of its job.

The points of the band are reduced by the method that chose them within an interval (`selection.select_points`), with the in-band
quantities of a sample of the job's own paths as targets. What that costs is measured on other paths of the same job.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere import transfer
from skyshine.mat.atmosphere.air import SpectralAir
from skyshine.mat.atmosphere.geometry import Rays, scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.selection import select_points
from skyshine.mat.atmosphere.sky import direct_transmittance, sky_irradiance
from skyshine.mat.atmosphere.threads import each
from skyshine.schemas.errors import InputError

# Samples of the response inside an interval.
_RESPONSE_SAMPLES = 200
# Candidates beyond these many are thinned, evenly in mean logarithm of optical depth: 4,000 are more than enough for a band.
_MAX_CANDIDATES = 1600
# Size of the samples of paths: lines of sight for the fit and for the test, ranges on each; surfaces and elevations of the source for
# skylight, and for direct light, which costs little and varies much.
_TRAINING_RAYS, _TEST_RAYS, _RANGES, _SURFACES, _SKY_SOURCES, _DIRECT_SURFACES, _DIRECT_SOURCES = 160, 40, 12, 4, 3, 12, 30
# Lines of sight on which the gases are weighed.
_GAS_RAYS = 40
_SURFACE_HEIGHTS = (0.0, 1e3, 3e3, 10e3)  # m above the ground
# Errors count relative to the quantity, or to this fraction of its largest value where it is below.
_FLOOR = 0.1
# Gases left out may together take this fraction of the tolerance, in transmittance; the fit itself, on its own paths, the other.
# On other paths its error is two to three times that on its own.
_GAS_SHARE = 0.5
_FIT_SHARE = 0.3
_QUADRATURE = 4
# Points whose targets are computed together: the arrays of a path then stay in a processor's cache.
_CHUNK = 512
KINDS = ("transmittance", "path_thermal", "path_radiance", "sky_irradiance", "direct_irradiance")


@dataclass(frozen=True, eq=False)
class BandPoints:
    """Spectral points of a band, with the sensor's response in their weights.

    Attributes
    ----------
    points : SpectralPoints
    weight : (P,) array
        um; the sum is the integral of phi dlambda, and sum(weight * f) that of phi f dlambda.
    gases : tuple of str or None
        Those that absorb and count; None for all.
    """

    points: object
    weight: np.ndarray
    gases: tuple[str, ...] | None = None

    @property
    def wavenumber(self):
        """Middle of each point's interval, (P,) cm^-1."""
        return self.points.interval_edges.mean(axis=1)[self.points.interval]

    @property
    def width(self):
        """Width of each point's interval, (P,) cm^-1."""
        return np.diff(self.points.interval_edges, axis=1)[self.points.interval, 0]

    @property
    def radiance_weight(self):
        """(P,) cm^-1; sum(radiance_weight * radiance per cm^-1) is the band's radiance."""
        return self.weight * self.wavenumber**2 * 1e-4


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
        By quantity (`KINDS`): {"max", "p95", "rms"}, relative, on paths the points were not fitted to, against all points and all
        gases. Below 10 % of a quantity's largest value (of 1 for transmittance) errors count relative to that.
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


def band_points(points, response):
    """All points of a band.

    Parameters
    ----------
    points : SpectralPoints
        Of every interval that the response overlaps.
    response : SpectralResponse

    Returns
    -------
    BandPoints
        The points whose interval has a response above 0.

    Raises
    ------
    InputError
        If the response is 0 in all of them.
    """
    low, high = points.interval_edges.T
    sample = low[:, None] + (high - low)[:, None] * (np.arange(_RESPONSE_SAMPLES) + 0.5) / _RESPONSE_SAMPLES
    # Points of an interval stand for its distribution of absorption, not for their own place: each sees the interval's mean.
    micron = np.mean(response.at_wavenumber(sample) * 1e4 / sample**2, axis=1)
    weight = points.weight * micron[points.interval]
    inside = np.flatnonzero(weight > 0)
    if not inside.size:
        raise InputError(
            "the response is 0 in every interval of these spectral points; ask for the points of its own range"
        )
    points = points.subset(inside)
    return BandPoints(points, weight[inside], tuple(points.absorbing))


def compile_band(state, band, grid, source_irradiance, *, tolerance=1e-3, max_points=64, seed=0):
    """Reduce a band to the points that hold a tolerance on the paths of a job.

    Parameters
    ----------
    state : AtmosphericState
    band : BandPoints
        All points, from `band_points`.
    grid : quantities.PathGrid
        The job's own axes.
    source_irradiance : (P,) or (B, P) array
        At all points, W m^-2 (cm^-1)^-1, of one source or of each of several that are to share the compiled band.
    tolerance : float
        Relative rms error.
    max_points : int
    seed : int
        Of the choice of paths and of `select_points`.

    Returns
    -------
    CompiledBand
    """
    rng = np.random.default_rng(seed)
    training, test = (_Sample.of(state, grid, rays, rng) for rays in (_TRAINING_RAYS, _TEST_RAYS))
    irradiance = np.atleast_2d(np.asarray(source_irradiance, dtype=float))
    # Direct light of each source counts against its own brightness: moonlight like sunlight.
    brightness = np.maximum(irradiance.mean(axis=1), np.finfo(float).tiny)
    air = SpectralAir.of(state, band.points, band.gases, band.weight)
    kept, dropped = _drop_gases(air, band, training, tolerance * _GAS_SHARE)
    targets = _targets(air, training, irradiance, brightness)
    reference = {kind: values @ band.weight / band.weight.sum() for kind, values in targets.items()}
    # Each quantity counts the same, however many rows it has.
    scale = {kind: 1 / (_size(kind, values) * np.sqrt(values.size)) for kind, values in reference.items()}
    rows = np.concatenate([targets[kind] for kind in targets])
    candidates = _candidates(air, training)
    chosen, weight, ladder = select_points(
        rows[:, candidates].T,
        np.concatenate(list(reference.values())),
        tolerance=tolerance * _FIT_SHARE,
        max_points=max_points,
        total_weight=band.weight.sum(),
        exchanges=1,
        row_scale=np.concatenate(list(scale.values())) * np.sqrt(len(rows) / len(scale)),
        seed=seed,
    )
    order = np.argsort(candidates[chosen])
    index, weight = candidates[chosen][order], weight[order]
    compiled = BandPoints(band.points.subset(index), weight, kept)
    few = SpectralAir.of(state, compiled.points, compiled.gases, compiled.weight)
    exact = _in_band(air, band, test, irradiance, brightness)
    errors = _errors(exact, _in_band(few, compiled, test, irradiance[:, index], brightness))
    return CompiledBand(compiled, index, band.weight.size, errors, dropped, ladder)


def negligible_gases(state, band, grid, *, tolerance=1e-3, seed=0):
    """Gases that `compile_band` leaves out, with the largest change each makes in an in-band transmittance.

    Parameters
    ----------
    state, band, grid, tolerance, seed
        As `compile_band`.

    Returns
    -------
    dict of str to float
    """
    training = _Sample.of(state, grid, _TRAINING_RAYS, np.random.default_rng(seed))
    air = SpectralAir.of(state, band.points, band.gases, band.weight)
    return _drop_gases(air, band, training, tolerance * _GAS_SHARE)[1]


@dataclass(frozen=True, eq=False)
class _Sample:
    """Lines of sight drawn from a job's axes, each with ranges and a source; altitudes and sources for sky and direct light.

    altitude, elevation (M,) m, rad; ranges (M, R) m; source_elevation, source_azimuth (M,) rad; surface_altitude, direct_altitude (Z,), (Y,) m;
    sky_elevation, direct_elevation (S,), (D,) rad.
    """

    altitude: np.ndarray
    elevation: np.ndarray
    ranges: np.ndarray
    source_elevation: np.ndarray
    source_azimuth: np.ndarray
    surface_altitude: np.ndarray
    direct_altitude: np.ndarray
    sky_elevation: np.ndarray
    direct_elevation: np.ndarray

    @classmethod
    def of(cls, state, grid, rays, rng):
        """A Latin hypercube over the axes, even in their nodes."""

        def draw(axis, count):
            place = rng.permutation((np.arange(count) + rng.random(count)) / count) * (len(axis) - 1)
            return np.interp(place, np.arange(len(axis)), axis)

        ground = state.surface_altitude
        ranges = grid.range_km[grid.range_km > 0] if np.any(grid.range_km > 0) else np.array([1.0])
        altitude = np.maximum(draw(grid.altitude_km, rays) * 1e3, ground)
        # A source below the horizon has nothing to say about the choice of points.
        source = np.maximum(grid.source_elevation_deg, 0.0)
        return cls(
            altitude,
            np.radians(draw(grid.elevation_deg, rays)),
            draw(ranges, rays * _RANGES).reshape(rays, _RANGES) * 1e3,
            np.radians(draw(source, rays)),
            np.radians(draw(grid.source_azimuth_deg, rays)),
            ground + np.append(0.0, draw(np.array(_SURFACE_HEIGHTS), _SURFACES - 1)),
            ground + np.append(0.0, draw(np.array(_SURFACE_HEIGHTS), _DIRECT_SURFACES - 1)),
            np.radians(draw(source, _SKY_SOURCES)),
            np.radians(draw(source, _DIRECT_SOURCES)),
        )


def _paths(shells, sample):
    """Rays, and of each ray that meets air: its row, its segments and the segment ends of its ranges."""
    rays = trace(shells, sample.altitude, sample.elevation, sample.ranges)
    found = []
    for row in range(sample.altitude.size):
        segments = transfer.Segments.of(rays, row)
        node = np.minimum(np.searchsorted(segments.distance, sample.ranges[row]), segments.index.size)
        if np.any(node > 0):
            found.append((row, segments, np.unique(node[node > 0])))
    return rays, found


def _targets(air, sample, irradiance, brightness):
    """In-band targets at every point: dict of (M, P), in the measure of `BandPoints.weight` (per um).

    irradiance (B, P) of the sources; direct light is over the brightness (B,).
    """
    rays, paths = _paths(air.shells, sample)
    starts = range(0, air.optics.wavenumber.size, _CHUNK)

    def targets(part, start):
        return _part_of_targets(part, sample, rays, paths, irradiance[:, start : start + _CHUNK], brightness)

    parts = each(targets, air.parts(_CHUNK), starts)
    joined = {kind: np.concatenate([part[kind] for part in parts], axis=1) for kind in KINDS if parts[0][kind].size}
    return {kind: values for kind, values in joined.items() if np.any(values > 0)}


def _part_of_targets(air, sample, rays, paths, irradiance, brightness):
    """`_targets` at some of the points."""
    optics = air.optics
    per_micron = optics.wavenumber**2 * 1e-4
    sky = sky_irradiance(air, sample.surface_altitude, sample.sky_elevation, zeniths=_QUADRATURE, azimuths=_QUADRATURE)
    by_source = irradiance[:, None, None] * per_micron  # (B, 1, 1, P)
    irradiances = (sky.thermal[:, None] * per_micron + sky.scattered * by_source).reshape(-1, per_micron.size)
    direct = direct_transmittance(air.source_paths, sample.direct_altitude, sample.direct_elevation)
    direct = (direct * by_source / brightness[:, None, None, None]).reshape(-1, per_micron.size)
    result = {kind: [] for kind in KINDS}
    result["sky_irradiance"].append(irradiances)
    result["direct_irradiance"].append(direct)
    for row, segments, node in paths:
        depth = segments.column(optics.extinction)
        through = np.exp(-np.cumsum(depth, axis=0))[node - 1]
        thermal = air.thermal_radiance(segments, depth)[node] * per_micron
        one = slice(row, row + 1)
        ray = Rays(*(getattr(rays, name)[one] for name in rays.__dataclass_fields__))
        ends = np.append(segments.index, segments.index[-1] + 1)
        to_source, deflection = (
            angle(ray, sample.source_elevation[one], sample.source_azimuth[one])[0, ends]
            for angle in (source_cosine, scattering_cosine)
        )
        unit = air.scattered_radiance(segments, depth, to_source, deflection)
        result["transmittance"].append(through)
        result["path_thermal"].append(thermal)
        result["path_radiance"].append(thermal[-1:] + unit * by_source[:, 0, 0])
        # The products of (20) and (36): sky and direct light on the ground through the path.
        result["sky_irradiance"].append(irradiances[(row + np.arange(len(node))) % len(irradiances)] * through)
        result["direct_irradiance"].append(direct[(row + np.arange(len(node))) % len(direct)] * through)
    none = np.zeros((0, per_micron.size))
    return {kind: np.concatenate([none, *values]) for kind, values in result.items()}


def _size(kind, values):
    """What an error in each value is measured against."""
    return np.maximum(values, _FLOOR * (1.0 if kind == "transmittance" else values.max()))


def _candidates(air, sample):
    """Indices of candidate points, spread evenly over the mean logarithm of optical depth."""
    count = air.optics.wavenumber.size
    if count <= _MAX_CANDIDATES:
        return np.arange(count)
    _, paths = _paths(air.shells, sample)
    depth = np.array([segments.column(air.optics.extinction).sum(axis=0) for _, segments, _ in paths])
    order = np.argsort(np.mean(np.log(np.maximum(depth, 1e-30)), axis=0), kind="stable")
    return np.sort(order[np.linspace(0, count - 1, _MAX_CANDIDATES).astype(int)])


def _drop_gases(air, band, sample, allowed):
    """Gases kept, and those left out with the largest change each makes in an in-band transmittance."""
    paths = _paths(air.shells, sample)[1][:_GAS_RAYS]
    mean = band.weight / band.weight.sum()
    effect = dict.fromkeys(air.optics.absorption, 0.0)
    for _, segments, _ in paths:
        depth = segments.column(air.optics.extinction).sum(axis=0)
        for gas, section in air.optics.absorption.items():
            without = depth - segments.column(section).sum(axis=0)
            effect[gas] = max(effect[gas], float((np.exp(-without) - np.exp(-depth)) @ mean))
    dropped, total = {}, 0.0
    for gas in sorted(effect, key=effect.get):
        total += effect[gas]
        if total > allowed:
            break
        dropped[gas] = effect[gas]
    return tuple(gas for gas in effect if gas not in dropped), dropped


def _in_band(air, band, sample, irradiance, brightness):
    """In-band values of the targets, dict of (M,)."""
    return {
        kind: values @ band.weight / band.weight.sum()
        for kind, values in _targets(air, sample, irradiance, brightness).items()
    }


def _errors(exact, approximate):
    """Errors by quantity, from in-band values."""
    result = {}
    for kind, values in exact.items():
        error = (approximate[kind] - values) / _size(kind, values)
        result[kind] = {
            "max": float(np.abs(error).max()),
            "p95": float(np.percentile(np.abs(error), 95)),
            "rms": float(np.sqrt(np.mean(error**2))),
        }
    return result
