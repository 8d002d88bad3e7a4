"""A line of sight through the air and its optical depth at the ends of its ranges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Rays, trace
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.schemas.arrays import Booleans, Floats, Integers, Reals

# A range to the ground within this relative difference of the computed one ends on it, not below.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class LineOfSight:
    """One line of sight from an observer, ended at R ranges, at P spectral points.

    Attributes
    ----------
    elevation : float
        Elevation of the line at the observer, rad.
    ends : geometry.Rays
        Ends of the segments, as one ray.
    depth : (R, P) array
        Optical depth to each range.
    length, beyond : (R,) arrays
        The parts of each range before the ground and behind it, m.
    node : (R,) int array
        Segment end at each range.
    surface_altitude : (R,) array
        Altitude of the end of each range, m.
    valid : (R,) bool array
        False where the range would pass through the ground.
    local_altitude, local_layer, local_share, local_extinction
        Of the air at the observer, or of the highest air below an observer in space: altitude [m], number of the layer,
        fraction of the layer below that altitude, extinction (P,) [m^-1].
    """

    elevation: float
    segments: Segments
    ends: Rays
    segment_depths: Depths
    depth: Reals
    length: Floats
    beyond: Floats
    node: Integers
    surface_altitude: Floats
    valid: Booleans
    local_altitude: float
    local_layer: int
    local_share: float
    local_extinction: Floats

    @classmethod
    def of(
        cls, air: SpectralAir, rays: Rays, row: int, altitude: float, elevation: float, ranges: Floats
    ) -> LineOfSight:
        """The line of sight along one ray of `geometry.trace`.

        Parameters
        ----------
        altitude, elevation : float
            Altitude of the observer and elevation of the line there, m and rad.
        ranges : (R,) array
            Increasing, m; among those the ray was traced with.
        """
        segments = Segments.of(rays, row)
        depths = Depths(segments.column(air.optics.extinction))
        end, ground = rays.end[row], bool(rays.ground[row])
        length = np.minimum(ranges, end) if ground else ranges
        valid = ranges <= end * (1 + _ROUNDING) if ground else np.ones(ranges.shape, dtype=bool)
        node = np.minimum(np.searchsorted(segments.distance, length), segments.distance.size - 1)
        local = float(np.clip(altitude, air.state.surface_altitude, air.shells.top))
        levels = air.shells.altitude
        layer = int(np.clip(np.searchsorted(levels, local, side="right") - 1, 0, levels.size - 2))
        share = (local - levels[layer]) / (levels[layer + 1] - levels[layer])
        section = air.optics.extinction[layer] * (1 - share) + air.optics.extinction[layer + 1] * share
        density = (
            np.exp(np.interp(local, levels, np.log(air.shells.number_density))) if altitude <= air.shells.top else 0.0
        )
        return cls(
            elevation,
            segments,
            _ends(rays, row, segments),
            depths,
            depths.cumulative[node],
            length,
            ranges - length,
            node,
            _end_altitude(segments, node, length, altitude, elevation),
            valid,
            local,
            layer,
            share,
            density * section,
        )

    def depth_behind(self, air: SpectralAir) -> Floats:
        """Optical depth (R, P) of the part of each range behind the ground, through air as at the ground."""
        depth: Floats = self.beyond[:, None] * (air.shells.number_density[0] * air.optics.extinction[0])
        return depth


def _ends(rays: Rays, row: int, segments: Segments) -> Rays:
    """The ends of the segments of one ray as `Rays` without segments."""
    empty = np.zeros((1, 0))
    return Rays(
        segments.distance[None],
        segments.altitude[None],
        segments.central_angle[None],
        segments.direction[None],
        empty.astype(int),
        empty,
        empty,
        rays.end[row : row + 1],
        rays.ground[row : row + 1],
    )


def _end_altitude(segments: Segments, node: Integers, length: Floats, altitude: float, elevation: float) -> Floats:
    """Altitude [m] of the end of each range, (R,), in space too."""

    def straight(start: float, sine: float, distance: Floats) -> Floats:
        radius = EARTH_RADIUS + start
        gain = distance**2 + 2 * radius * distance * sine
        altitude: Floats = start + gain / (radius + np.sqrt(radius**2 + gain))
        return altitude

    nearest, farthest = segments.distance[0], segments.distance[-1]
    if not segments.index.size:
        return straight(altitude, np.sin(elevation), length)
    end: Floats = segments.altitude[node]
    before, beyond = length < nearest, length > farthest
    if before.any():
        end[before] = straight(altitude, np.sin(elevation), length[before])
    if beyond.any():
        leaving = np.cos(segments.direction[-1] - segments.central_angle[-1])
        end[beyond] = straight(segments.altitude[-1], leaving, length[beyond] - farthest)
    return end


def lines_of_sight(air: SpectralAir, ranges: Floats, altitude: Floats, elevation: Floats) -> Iterator[LineOfSight]:
    """The lines of sight from n observers, one after the other.

    Parameters
    ----------
    ranges : (n, R) array
        Increasing along each line, m.
    altitude, elevation : (n,) arrays
        Altitudes of the observers above sea level, m; elevations of the lines there, rad.

    Raises
    ------
    InputError
        As `geometry.trace`.
    """
    rays = trace(air.shells, altitude, elevation, ranges)
    for row in range(altitude.size):
        yield LineOfSight.of(air, rays, row, altitude[row], elevation[row], ranges[row])
