"""What the points of a band give on a sample of a job's paths: the targets a band is compiled to, and tested on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere import transfer
from skyshine.mat.atmosphere.geometry import scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.sky import direct_transmittance, sky_irradiance
from skyshine.mat.atmosphere.threads import each

KINDS = ("transmittance", "path_thermal", "path_radiance", "sky_irradiance", "direct_irradiance")
# Ranges on each line of sight; surfaces and elevations of the source for skylight, and for direct light, which costs little and
# varies much.
_RANGES, _SURFACES, _SKY_SOURCES, _DIRECT_SURFACES, _DIRECT_SOURCES = 12, 4, 3, 12, 30
_SURFACE_HEIGHTS = (0.0, 1e3, 3e3, 10e3)  # m above the ground
# Directions of the sky. The cells of their quadrature take the mean of the phase function, and nothing else changes with azimuth but
# through the curvature of the Earth.
_ZENITHS, _AZIMUTHS = 4, 1
# Points whose targets are computed together: the arrays of a path then stay in a processor's cache.
_CHUNK = 1024


@dataclass(frozen=True, eq=False)
class Sight:
    """A line of sight of a sample.

    Attributes
    ----------
    segments : transfer.Segments
    node : (R,) int array
        Segment ends at its ranges, without the observer's place.
    to_source, deflection : (K+1, 1) arrays
        Cosines of the source's zenith angle and of the scattering angle at the segment ends.
    """

    segments: transfer.Segments
    node: np.ndarray
    to_source: np.ndarray
    deflection: np.ndarray


@dataclass(frozen=True, eq=False)
class Sample:
    """Lines of sight that meet air, each with ranges and a source; altitudes and sources for sky and direct light.

    Attributes
    ----------
    sights : tuple of Sight
    surface_altitude, direct_altitude : (Z,), (Y,) arrays
        m.
    sky_elevation, direct_elevation : (S,), (D,) arrays
        Of the source, rad.
    """

    sights: tuple[Sight, ...]
    surface_altitude: np.ndarray
    direct_altitude: np.ndarray
    sky_elevation: np.ndarray
    direct_elevation: np.ndarray

    @classmethod
    def of(cls, shells, grid, count, rng):
        """A Latin hypercube over the axes, even in their nodes.

        Parameters
        ----------
        shells : Shells
        grid : quantities.PathGrid
        count : int
            Lines of sight; those that meet no air are left out.
        rng : numpy.random.Generator
        """

        def draw(axis, count):
            place = rng.permutation((np.arange(count) + rng.random(count)) / count) * (len(axis) - 1)
            return np.interp(place, np.arange(len(axis)), axis)

        ground = shells.altitude[0]
        ranges = grid.range_km[grid.range_km > 0] if np.any(grid.range_km > 0) else np.array([1.0])
        altitude = np.maximum(draw(grid.altitude_km, count) * 1e3, ground)
        # A source below the horizon has nothing to say about the choice of points.
        source = np.maximum(grid.source_elevation_deg, 0.0)
        elevation = np.radians(draw(grid.elevation_deg, count))
        ranges = draw(ranges, count * _RANGES).reshape(count, _RANGES) * 1e3
        angles = np.radians(draw(source, count)), np.radians(draw(grid.source_azimuth_deg, count))
        return cls(
            _sights(shells, altitude, elevation, ranges, angles),
            ground + np.append(0.0, draw(np.array(_SURFACE_HEIGHTS), _SURFACES - 1)),
            ground + np.append(0.0, draw(np.array(_SURFACE_HEIGHTS), _DIRECT_SURFACES - 1)),
            np.radians(draw(source, _SKY_SOURCES)),
            np.radians(draw(source, _DIRECT_SOURCES)),
        )

    def optical_depth(self, per_molecule):
        """Of each line of sight to its farthest range and on, (M, P), through a property (N, P) [m^2 per molecule] of the air."""
        air = np.zeros((len(self.sights), len(per_molecule)))
        for row, sight in zip(air, self.sights, strict=True):
            np.add.at(row, sight.segments.layer, sight.segments.lower)
            np.add.at(row, sight.segments.layer + 1, sight.segments.upper)
        return air @ per_molecule


def _sights(shells, altitude, elevation, ranges, angles):
    """Lines of sight that meet air; `angles` of the source: elevations and azimuths, rad."""
    rays = trace(shells, altitude, elevation, ranges)
    found = []
    for row in range(altitude.size):
        segments = transfer.Segments.of(rays, row)
        node = np.minimum(np.searchsorted(segments.distance, ranges[row]), segments.index.size)
        if np.any(node > 0):
            ray, source = rays.at(row), [angle[row : row + 1] for angle in angles]
            ends = np.append(segments.index, segments.index[-1] + 1)
            cosines = (cosine(ray, *source)[0, ends] for cosine in (source_cosine, scattering_cosine))
            found.append(Sight(segments, np.unique(node[node > 0]), *cosines))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Targets:
    """Of one sample, by quantity (`KINDS`); those that are 0 everywhere are left out.

    Attributes
    ----------
    mean : dict of (M,) arrays
        In band.
    at_points : (all M, C) array
        At the points that were asked for, one quantity after another, in the measure of `BandPoints.weight` (per um).
    """

    mean: dict[str, np.ndarray]
    at_points: np.ndarray


def targets(air, weight, samples, irradiance, brightness, points):
    """Targets of samples.

    Parameters
    ----------
    air : SpectralAir
        At all P points.
    weight : (P,) array
        `BandPoints.weight`.
    samples : sequence of Sample
    irradiance : (B, P) array
        Of the sources, W m^-2 (cm^-1)^-1.
    brightness : (B,) array
        Direct light counts relative to it.
    points : sequence of int arrays, increasing
        For each sample the points whose targets are kept.

    Returns
    -------
    list of Targets
    """
    count = weight.size
    pieces = 2 * -(-count // (2 * _CHUNK)) if count > _CHUNK // 2 else 1  # even in number, for threads in pairs
    edges = np.linspace(0, count, pieces + 1).astype(int)
    mean = weight / weight.sum()

    def part(start, end):
        some = air.part(slice(start, end))
        found = []
        for sample, wanted in zip(samples, points, strict=True):
            columns = wanted[(wanted >= start) & (wanted < end)] - start
            means = {kind: [np.zeros(0)] for kind in KINDS}
            kept = {kind: [np.zeros((0, columns.size))] for kind in KINDS}
            for kind, rows in _values(some, sample, irradiance[:, start:end], brightness):
                means[kind].append(rows @ mean[start:end])
                kept[kind].append(rows[:, columns])
            found.append((means, kept))
        return found

    parts = each(part, edges[:-1], edges[1:])
    result = []
    for chunks in zip(*parts, strict=True):
        means = {kind: sum(np.concatenate(found[kind]) for found, _ in chunks) for kind in KINDS}
        means = {kind: values for kind, values in means.items() if np.any(values > 0)}
        kept = [np.concatenate([rows for kind in means for rows in found[kind]]) for _, found in chunks]
        result.append(Targets(means, np.concatenate(kept, axis=1)))
    return result


def _values(air, sample, irradiance, brightness):
    """Targets of a sample at the points of `air`: pairs of their kind and values (m, P)."""
    optics = air.optics
    per_micron = optics.wavenumber**2 * 1e-4
    sky = sky_irradiance(air, sample.surface_altitude, sample.sky_elevation, zeniths=_ZENITHS, azimuths=_AZIMUTHS)
    by_source = irradiance[:, None, None] * per_micron  # (B, 1, 1, P)
    irradiances = (sky.thermal[:, None] * per_micron + sky.scattered * by_source).reshape(-1, per_micron.size)
    direct = direct_transmittance(air.source_paths, sample.direct_altitude, sample.direct_elevation)
    direct = (direct * by_source / brightness[:, None, None, None]).reshape(-1, per_micron.size)
    yield "sky_irradiance", irradiances
    yield "direct_irradiance", direct
    for number, sight in enumerate(sample.sights):
        segments, node = sight.segments, sight.node
        depths = transfer.Depths(segments.column(optics.extinction).astype(np.float32))
        through = np.exp(-depths.before[node].astype(float))
        within = (np.arange(segments.index.size) < node[:, None]).astype(np.float32)
        thermal = (within @ air.thermal_radiance(segments, depths)) * per_micron
        light = air.scattered_radiance(segments, depths, sight.to_source, sight.deflection)
        yield "transmittance", through
        yield "path_thermal", thermal
        yield "path_radiance", thermal[-1:] + light * by_source[:, 0, 0]
        # The products of (20) and (36): sky and direct light on the ground through the path.
        place = number + np.arange(node.size)
        yield "sky_irradiance", irradiances[place % len(irradiances)] * through
        yield "direct_irradiance", direct[place % len(direct)] * through
