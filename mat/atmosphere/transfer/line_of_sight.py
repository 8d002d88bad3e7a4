"""A line of sight through the air, with what is known at the ends of its ranges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer import segments as transfer
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Rays

# A range to the ground within this relative difference of the computed one ends on it, not below.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class LineOfSight:
    """One line of sight from an observer, ended at R ranges, at P spectral points.

    Attributes
    ----------
    elevation : float
        At the observer, rad.
    segments : transfer.Segments
    ends : geometry.Rays
        Of the segments, as one ray.
    segment_depths : transfer.Depths
    depth : (R, P) array
        Optical depth to each range.
    length, beyond : (R,) arrays
        What of each range lies before the ground and behind it, m.
    node : (R,) int array
        Segment end at each range.
    surface_altitude : (R,) array
        Of the end of each range, m.
    valid : (R,) bool array
        False where the range would pass through the ground.
    local_altitude, local_layer, local_share, local_extinction
        Of the air at the observer, or of the highest air below him: altitude [m], number of the layer, share of the
        layer below it, extinction (P,) [m^-1].
    """

    elevation: float
    segments: transfer.Segments
    ends: Rays
    segment_depths: transfer.Depths
    depth: np.ndarray
    length: np.ndarray
    beyond: np.ndarray
    node: np.ndarray
    surface_altitude: np.ndarray
    valid: np.ndarray
    local_altitude: float
    local_layer: int
    local_share: float
    local_extinction: np.ndarray

    @classmethod
    def of(cls, air, rays, row, altitude, elevation, ranges) -> LineOfSight:
        """From one ray of `geometry.trace`.

        Parameters
        ----------
        air : air.SpectralAir
        rays : geometry.Rays
        row : int
        altitude, elevation : float
            Of observer and line there, m and rad.
        ranges : (R,) array
            Increasing, m; among those the ray was traced with.
        """
        segments = transfer.Segments.of(rays, row)
        depths = transfer.Depths(segments.column(air.optics.extinction))
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
            depths.before[node],
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

    def depth_behind(self, air) -> np.ndarray:
        """Optical depth (R, P) of what of each range is behind the ground, as if the air of the ground went on."""
        return self.beyond[:, None] * (air.shells.number_density[0] * air.optics.extinction[0])


def _ends(rays, row, segments):
    """The segment ends of one ray, in the shape that `geometry` takes."""
    none = np.zeros((1, 0))
    return Rays(
        segments.distance[None],
        segments.altitude[None],
        segments.central_angle[None],
        segments.direction[None],
        none,
        none,
        none,
        rays.end[row : row + 1],
        rays.ground[row : row + 1],
    )


def _end_altitude(segments, node, length, altitude, elevation):
    """Altitude [m] of the end of each range, (R,), in space too."""

    def straight(start, sine, distance):
        radius = EARTH_RADIUS + start
        gain = distance**2 + 2 * radius * distance * sine
        return start + gain / (radius + np.sqrt(radius**2 + gain))

    first, last = segments.distance[0], segments.distance[-1]
    if not segments.index.size:
        return straight(altitude, np.sin(elevation), length)
    leaving = np.cos(segments.direction[-1] - segments.central_angle[-1])
    beyond = straight(segments.altitude[-1], leaving, np.maximum(length - last, 0.0))
    before = straight(altitude, np.sin(elevation), np.minimum(length, first))
    return np.select([length < first, length > last], [before, beyond], segments.altitude[node])
