"""A sample of a job's paths: random lines of sight, and surfaces under sky and source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import Shells, scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathAxes, PathScope
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.schemas.arrays import Floats, Integers

# Ranges on each line of sight; surfaces and elevations of the source for skylight, and for direct light, which costs
# little and varies much.
_RANGES, _SURFACES, _SKY_SOURCES, _DIRECT_SURFACES, _DIRECT_SOURCES = 12, 4, 3, 12, 30
_LEAST_ELEVATION = np.radians(1.0)  # of lines of sight that must meet air
_SURFACE_HEIGHTS = (0.0, 1e3, 3e3, 10e3)  # m above the ground
_TO_SPACE, _SPACE = (90.0, 40.0, 20.0, 10.0, 5.0), 1e7  # degree, and m beyond the air
_LOW_SKIES = 2  # surfaces under the sky where all are lower than that: their skies differ less


@dataclass(frozen=True, eq=False)
class SampledLine:
    """A line of sight of a sample.

    Attributes
    ----------
    segments : Segments
    node : (R,) int array
        Segment ends at its ranges, without the observer's place.
    to_source, deflection : (K+1, 1) arrays
        Cosines of the source's zenith angle and of the scattering angle at the segment ends.
    """

    segments: Segments
    node: Integers
    to_source: Floats
    deflection: Floats


@dataclass(frozen=True, eq=False)
class Sample:
    """Lines of sight that meet air, each with ranges and a source; altitudes and sources for sky and direct light.

    Attributes
    ----------
    lines : tuple of SampledLine
    surface_altitude, direct_altitude : (Z,), (Y,) arrays
        m.
    sky_elevation, direct_elevation : (S,), (D,) arrays
        Of the source, rad.
    """

    lines: tuple[SampledLine, ...]
    surface_altitude: Floats
    direct_altitude: Floats
    sky_elevation: Floats
    direct_elevation: Floats

    @classmethod
    def of(
        cls,
        shells: Shells,
        grid: PathAxes,
        count: int,
        rng: np.random.Generator,
        *,
        skies: int = _SURFACES,
        scope: PathScope = ALL_PATHS,
    ) -> Sample:
        """A Latin hypercube over the axes, uniform in the index of their nodes.

        Parameters
        ----------
        shells : Shells
        grid : PathAxes
        count : int
            Lines of sight; those that meet no air are omitted. Where none meets air, they start near the ground.
        rng : numpy.random.Generator
        skies : int
            Surfaces under the sky, one of them on the ground.
        scope : PathScope, optional
            Surfaces lie up to its highest; by default up to 10 km.
        """

        def draw(axis: Floats, count: int) -> Floats:
            place = rng.permutation((np.arange(count) + rng.random(count)) / count) * (len(axis) - 1)
            values: Floats = np.interp(place, np.arange(len(axis)), axis)
            return values

        ground = shells.altitude[0]
        surfaces = _surface_heights(scope)
        if surfaces.size < len(_SURFACE_HEIGHTS):
            skies = min(skies, _LOW_SKIES)
        ranges = grid.range_km[grid.range_km > 0] if np.any(grid.range_km > 0) else np.array([1.0])
        altitude = np.maximum(draw(grid.altitude_km, count) * 1e3, ground)
        # Light from a source below the horizon is too faint to matter for the choice of points.
        source = np.maximum(grid.source_elevation_deg, 0.0)
        elevation = np.radians(draw(grid.elevation_deg, count))
        ranges = draw(ranges, count * _RANGES).reshape(count, _RANGES) * 1e3
        angles = np.radians(draw(source, count)), np.radians(draw(grid.source_azimuth_deg, count))
        lines = _lines(shells, altitude, elevation, ranges, angles)
        if not lines:  # of observers so far away that none drawn looks at air: the points are those of views from below
            near = ground + np.resize(_SURFACE_HEIGHTS, count)
            lines = _lines(
                shells, near, np.maximum(np.abs(elevation), _LEAST_ELEVATION), np.maximum(ranges, 1e3), angles
            )
        return cls(
            lines,
            ground + np.append(0.0, draw(surfaces, skies - 1)),
            ground + np.append(0.0, draw(surfaces, _DIRECT_SURFACES - 1)),
            np.radians(draw(source, _SKY_SOURCES)),
            np.radians(draw(source, _DIRECT_SOURCES)),
        )

    def optical_depth(self, per_molecule: Floats) -> Floats:
        """Integral (M, P) of a property (N, P) [m^2 per molecule] along each line of sight until it leaves the air or
        meets the ground.
        """
        air = np.zeros((len(self.lines), len(per_molecule)))
        for row, line in zip(air, self.lines, strict=True):
            np.add.at(row, line.segments.layer, line.segments.lower)
            np.add.at(row, line.segments.layer + 1, line.segments.upper)
        return air @ per_molecule


def lines_to_space(shells: Shells) -> tuple[SampledLine, ...]:
    """Lines from the ground to space, along which light comes to surfaces however short the paths of a scene are."""
    elevation = np.radians(_TO_SPACE)
    none = np.zeros(elevation.size)
    ranges = np.full((elevation.size, 1), _SPACE)
    return _lines(shells, np.full(elevation.size, shells.altitude[0]), elevation, ranges, (none, none))


def _surface_heights(scope: PathScope) -> Floats:
    """Heights above the ground between which surfaces lie [m]."""
    inside = [height for height in _SURFACE_HEIGHTS if height < scope.highest_surface]
    if len(inside) == len(_SURFACE_HEIGHTS):
        return np.array(_SURFACE_HEIGHTS)
    return np.unique([*inside, max(scope.highest_surface, 1.0)])


def _lines(
    shells: Shells, altitude: Floats, elevation: Floats, ranges: Floats, angles: tuple[Floats, Floats]
) -> tuple[SampledLine, ...]:
    """Lines of sight that meet air, from observers (M,) [m] at elevations (M,) [rad] to ranges (M, R) [m]; `angles` are
    the source's elevations and azimuths (M,) [rad].
    """
    rays = trace(shells, altitude, elevation, ranges)
    lines = []
    for row in range(altitude.size):
        segments = Segments.of(rays, row)
        node = np.minimum(np.searchsorted(segments.distance, ranges[row]), segments.index.size)
        if np.any(node > 0):
            ray, (source_elevation, source_azimuth) = rays.at(row), (angle[row : row + 1] for angle in angles)
            to_source = source_cosine(ray, source_elevation, source_azimuth)[0, segments.ends]
            deflection = scattering_cosine(ray, source_elevation, source_azimuth)[0, segments.ends]
            lines.append(SampledLine(segments, np.unique(node[node > 0]), to_source, deflection))
    return tuple(lines)
