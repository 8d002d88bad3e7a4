"""A sample of a job's paths: random lines of sight, and surfaces under sky and source.

Those to which points are fitted are spread over the nodes of the axes; those on which points are tested look as scenes
do (`scene_lines`), for their errors are stated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import Shells, scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathAxes, PathScope
from skyshine.mat.atmosphere.transfer.scene_lines import REGIONS, SceneLines, spread
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.schemas.arrays import Floats, Integers

# Ranges on each line of sight of the fit; of the test one in so many of a job's.
_RANGES, _EVERY = 12, 3
# Surfaces and elevations of the source for skylight, and for direct light, which costs little and varies much.
_SURFACES, _SKY_SOURCES, _DIRECT_SURFACES, _DIRECT_SOURCES = 4, 3, 12, 30
NOWHERE = -1
# Emission, and light of the source, along one in so many lines: they take most of the time. The test has many lines,
# for transmittance and direct light cost little and differ most.
_FIT_STEPS, _TEST_STEPS = (1, 3), (4, 8)
_LEAST_ELEVATION = np.radians(1.0)  # smallest elevation of lines of sight that must meet air
_SURFACE_HEIGHTS = (0.0, 1e3, 3e3, 10e3)  # m above the ground
_TO_SPACE, _SPACE = (90.0, 40.0, 20.0, 10.0, 5.0), 1e7  # degree, and m beyond the air
_LOW_SKIES = 2  # surfaces under the sky where all are lower than that: their skies differ less


@dataclass(frozen=True, eq=False)
class SampledLine:
    """A line of sight of a sample.

    Attributes
    ----------
    node : (R,) int array
        Segment ends at its ranges, without the observer's place.
    to_source, deflection : (K+1, 1) arrays
        Cosines of the source's zenith angle and of the scattering angle at the segment ends.
    region : (R,) int array
        Places of its ranges in `REGIONS`, or `NOWHERE` of lines that no error is stated by.
    """

    segments: Segments
    node: Integers
    to_source: Floats
    deflection: Floats
    region: Integers


@dataclass(frozen=True, eq=False)
class Sample:
    """Lines of sight that meet air, each with ranges and a source; altitudes and sources for sky and direct light.

    Attributes
    ----------
    surface_altitude, direct_altitude : (Z,), (Y,) arrays
        m.
    sky_elevation, direct_elevation : (S,), (D,) arrays
        Elevations of the source, rad.
    emission_step, scattering_step : int
        Emission, and light of the source, are computed along one in so many lines.
    """

    lines: tuple[SampledLine, ...]
    surface_altitude: Floats
    direct_altitude: Floats
    sky_elevation: Floats
    direct_elevation: Floats
    emission_step: int
    scattering_step: int

    @classmethod
    def for_fit(
        cls, shells: Shells, grid: PathAxes, count: int, rng: np.random.Generator, *, scope: PathScope = ALL_PATHS
    ) -> Sample:
        """A Latin hypercube over the axes, uniform in the index of their nodes.

        Parameters
        ----------
        count : int
            Lines of sight; those that meet no air are omitted. Where none meets air, they start near the ground.
        scope : PathScope, optional
            Surfaces lie up to its highest; by default up to 10 km.
        """
        ground = shells.altitude[0]
        ranges = grid.range_km[grid.range_km > 0] if np.any(grid.range_km > 0) else np.array([1.0])
        altitude = np.maximum(spread(grid.altitude_km, count, rng) * 1e3, ground)
        elevation = np.radians(spread(grid.elevation_deg, count, rng))
        ranges = spread(ranges, count * _RANGES, rng).reshape(count, _RANGES) * 1e3
        angles = _source_angles(grid, count, rng)
        lines = _lines(shells, altitude, elevation, ranges, angles)
        if not lines:  # all observers are too far away to look at air: the points are those of views from below
            near = ground + np.resize(_SURFACE_HEIGHTS, count)
            lines = _lines(
                shells, near, np.maximum(np.abs(elevation), _LEAST_ELEVATION), np.maximum(ranges, 1e3), angles
            )
        return cls._over(lines, shells, grid, rng, scope, _SURFACES, _FIT_STEPS)

    @classmethod
    def for_test(
        cls,
        shells: Shells,
        grid: PathAxes,
        count: int,
        rng: np.random.Generator,
        *,
        skies: int = _SURFACES,
        scope: PathScope = ALL_PATHS,
    ) -> Sample:
        """Lines that look as scenes do, or where none meets air those of `for_fit`; parameters as there.

        Parameters
        ----------
        skies : int
            Surfaces under the sky, one of them on the ground.
        """
        scene_lines = SceneLines.drawn(shells, grid, count, rng)
        columns = np.arange(scene_lines.range_km.shape[1])[::-_EVERY][
            ::-1
        ]  # with the last, which may be that to the ground
        region = np.argmax([scene_lines.regions()[name][:, columns] for name in REGIONS], axis=0)
        altitude = np.maximum(scene_lines.altitude_km * 1e3, shells.altitude[0])
        ranges, angles = scene_lines.range_km[:, columns] * 1e3, _source_angles(grid, count, rng)
        lines = _lines(shells, altitude, np.radians(scene_lines.elevation_deg), ranges, angles, region)
        if not lines:  # lines of ranges of 0 alone, or of observers so far away that none drawn looks at air
            return cls.for_fit(shells, grid, -(-count // _TEST_STEPS[0]), rng, scope=scope)
        return cls._over(lines, shells, grid, rng, scope, skies, _TEST_STEPS)

    @classmethod
    def _over(
        cls,
        lines: tuple[SampledLine, ...],
        shells: Shells,
        grid: PathAxes,
        rng: np.random.Generator,
        scope: PathScope,
        skies: int,
        steps: tuple[int, int],
    ) -> Sample:
        """The lines, and surfaces under sky and source."""
        ground, surfaces = shells.altitude[0], _surface_heights(scope)
        if surfaces.size < len(_SURFACE_HEIGHTS):
            skies = min(skies, _LOW_SKIES)
        source = _risen(grid)
        return cls(
            lines,
            ground + np.append(0.0, spread(surfaces, skies - 1, rng)),
            ground + np.append(0.0, spread(surfaces, _DIRECT_SURFACES - 1, rng)),
            np.radians(spread(source, _SKY_SOURCES, rng)),
            np.radians(spread(source, _DIRECT_SOURCES, rng)),
            *steps,
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
    no_range = np.zeros(elevation.size)
    ranges = np.full((elevation.size, 1), _SPACE)
    return _lines(shells, np.full(elevation.size, shells.altitude[0]), elevation, ranges, (no_range, no_range))


def _risen(grid: PathAxes) -> Floats:
    """Elevations (SE,) of the source [degree]: light from below the horizon is too faint to matter for the points."""
    return np.maximum(grid.source_elevation_deg, 0.0)


def _source_angles(grid: PathAxes, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Random elevations and azimuths (count,) of the source [rad]."""
    return np.radians(spread(_risen(grid), count, rng)), np.radians(spread(grid.source_azimuth_deg, count, rng))


def _surface_heights(scope: PathScope) -> Floats:
    """Heights above the ground between which surfaces lie [m]."""
    inside = [height for height in _SURFACE_HEIGHTS if height < scope.highest_surface]
    if len(inside) == len(_SURFACE_HEIGHTS):
        return np.array(_SURFACE_HEIGHTS)
    return np.unique([*inside, max(scope.highest_surface, 1.0)])


def _lines(
    shells: Shells,
    altitude: Floats,
    elevation: Floats,
    ranges: Floats,
    angles: tuple[Floats, Floats],
    region: Integers | None = None,
) -> tuple[SampledLine, ...]:
    """Lines of sight that meet air, from observers (M,) [m] at elevations (M,) [rad] to ranges (M, R) [m]; `angles` are
    the source's elevations and azimuths (M,) [rad], `region` (M, R) as of `SampledLine`.
    """
    rays = trace(shells, altitude, elevation, ranges)
    lines = []
    for row in range(altitude.size):
        segments = Segments.of(rays, row)
        ends = np.minimum(np.searchsorted(segments.distance, ranges[row]), segments.index.size)
        node, index = np.unique(ends, return_index=True)
        if node[-1] > 0:
            ray, (source_elevation, source_azimuth) = rays.at(row), (angle[row : row + 1] for angle in angles)
            to_source = source_cosine(ray, source_elevation, source_azimuth)[0, segments.ends]
            deflection = scattering_cosine(ray, source_elevation, source_azimuth)[0, segments.ends]
            where = np.full(index.size, NOWHERE) if region is None else region[row, index]
            lines.append(SampledLine(segments, node[node > 0], to_source, deflection, where[node > 0]))
    return tuple(lines)
