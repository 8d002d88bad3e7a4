"""A sample of a job's paths: random lines of sight, and places from which sky and source are seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer import segments as transfer
from skyshine.mat.atmosphere.transfer.geometry import scattering_cosine, source_cosine, trace

# Ranges on each line of sight; surfaces and elevations of the source for skylight, and for direct light, which costs
# little and varies much.
_RANGES, _SURFACES, _SKY_SOURCES, _DIRECT_SURFACES, _DIRECT_SOURCES = 12, 4, 3, 12, 30
_SURFACE_HEIGHTS = (0.0, 1e3, 3e3, 10e3)  # m above the ground


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
        grid : path_grid.PathGrid
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
        """Of each line of sight to its farthest range and on, (M, P), through a property (N, P) [m^2 per molecule] of
        the air.
        """
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
