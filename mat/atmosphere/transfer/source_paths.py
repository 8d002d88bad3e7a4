"""Optical depth from a distant source to any point of the atmosphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells, departure_angle, trace
from skyshine.schemas.arrays import Booleans, Floats, Singles

# Optical depth of a hidden source: exp of its negative is 0 in single precision.
HIDDEN = 1e4
_SMALLEST_DEPTH = 1e-30
# Nodes of the source table. Down: the lowest point of the ray, as (i / n)^2 of the height above the ground. Up:
# degrees.
_GRAZING_NODES = 20
_UP_NODES = (0.2, 0.5, 1, 1.5, 2, 3, 4, 5.5, 7.5, 10, 14, 20, 28, 40, 55, 75, 90)
# A ray that passes this far above the ground (m) is the lowest that reaches space.
_CLEARANCE = 1e-3
# Scale height of the shell whose air mass divides the slant optical depths of the table; 8 km is the air's (any would
# do).
_SCALE_HEIGHT = 8e3


@dataclass(frozen=True, eq=False)
class SourceRays:
    """The refracted rays from each of N levels to space at U apparent elevations, from the one that grazes the ground
    to the vertical.

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    elevation : (N, U) array
        Geometric elevation at which each leaves for space, rad, increasing along U.
    log_air_mass : (N, U) array
        Logarithm of the air mass of a homogeneous shell, by which `SourcePaths` divides its optical depths.
    air : (N * U, N) array
        Air of each ray, molecules m^-2, by the level whose properties apply to it.
    """

    levels: Floats
    elevation: Floats
    log_air_mass: Floats
    air: Floats

    @classmethod
    def of(cls, shells: Shells) -> SourceRays:
        """The rays from the levels of shells."""
        apparent = _apparent_elevations(shells)
        count, nodes = apparent.shape
        rays = trace(shells, np.repeat(shells.altitude, nodes), apparent.ravel())
        elevation = (np.pi / 2 - departure_angle(rays)).reshape(count, nodes)
        elevation = np.maximum.accumulate(elevation, axis=1)
        # Each ray's segments run down through all layers, then up through all: fold both onto the levels.
        down, up = np.split(np.arange(rays.layer.shape[1]), 2)
        air = np.zeros((count * nodes, count))
        air[:, :-1] += rays.lower[:, down[::-1]] + rays.lower[:, up]
        air[:, 1:] += rays.upper[:, down[::-1]] + rays.upper[:, up]
        return cls(shells.altitude, elevation, np.log(_shell_air_mass(shells.altitude[:, None], elevation)), air)

    def rise_at(self, altitude: npt.ArrayLike) -> Floats:
        """Geometric elevation [rad] at which a source rises for points at altitudes [m], in space too."""
        top = float(self.levels[-1])
        altitude = np.asarray(altitude, float)
        inside = np.interp(altitude, self.levels, self.elevation[:, 0])
        # The ray that grazes the ground leaves the atmosphere on a straight line.
        ratio = (EARTH_RADIUS + top) / (EARTH_RADIUS + np.maximum(altitude, top))
        rise: Floats = -np.arccos(np.minimum(np.cos(inside) * ratio, 1.0))
        return rise


@dataclass(frozen=True, eq=False)
class SourcePaths:
    """Optical depth from a distant source to any point, by altitude and geometric elevation.

    The rays are those of `SourceRays`. A source below the grazing ray is hidden by the Earth.

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    elevation : (N, U) array
        Geometric elevation, rad, increasing along U.
    log_depth : (N, U, P) array
        Logarithm of optical depth over the air mass of a shell, single precision.
    """

    levels: Floats
    elevation: Floats
    log_depth: Singles

    @classmethod
    def of(cls, rays: SourceRays, extinction: Floats) -> SourcePaths:
        """The paths through an extinction (N, P) [m^2 per molecule]."""
        count, nodes = rays.elevation.shape
        depth = (rays.air @ extinction).reshape(count, nodes, -1)
        np.log(np.maximum(depth, _SMALLEST_DEPTH, out=depth), out=depth)
        depth -= rays.log_air_mass[..., None]
        return cls(rays.levels, rays.elevation, depth.astype(np.float32))

    def optical_depth(self, altitude: npt.ArrayLike, cosine: Floats) -> Singles:
        """Optical depth to the source.

        Parameters
        ----------
        altitude : (K,) array
            Of the points, m.
        cosine : (K, S) array
            Of the source's geometric zenith angle at each point.

        Returns
        -------
        (K, S, P) array
            Single precision; `HIDDEN` or more where the Earth hides the source.
        """
        altitude, elevation, clear = self._entering(
            np.asarray(altitude, dtype=float), np.arcsin(np.clip(cosine, -1.0, 1.0))
        )
        lower = np.clip(np.searchsorted(self.levels, altitude, side="right") - 1, 0, self.levels.size - 2)
        share = np.clip((altitude - self.levels[lower]) / np.diff(self.levels)[lower], 0.0, 1.0)
        nodes = self.elevation[lower] * (1 - share)[:, None] + self.elevation[lower + 1] * share[:, None]
        place = _fractional_index(nodes, elevation)
        hidden = (elevation < nodes[:, :1]) & ~clear
        first = np.minimum(place.astype(int), nodes.shape[1] - 2)
        fraction, share = (place - first), share[:, None]
        row = lower[:, None] * nodes.shape[1] + first
        table = self.log_depth.reshape(-1, self.log_depth.shape[2])
        corners = (
            (row, (1 - share) * (1 - fraction)),
            (row + 1, (1 - share) * fraction),
            (row + nodes.shape[1], share * (1 - fraction)),
            (row + nodes.shape[1] + 1, share * fraction),
        )
        depth = np.zeros((*row.shape, table.shape[1]), dtype=np.float32)
        for corner, weight in corners:
            if np.any(weight):
                depth += table[corner] * weight.astype(np.float32)[..., None]
        depth += np.log(_shell_air_mass(altitude[:, None], elevation)).astype(np.float32)[..., None]
        np.exp(depth, out=depth)
        depth[clear] = 0.0
        depth[hidden] += HIDDEN
        return depth

    def _entering(self, altitude: Floats, elevation: Floats) -> tuple[Floats, Floats, Booleans]:
        """Altitude (K,) [m] and elevation (K, S) [rad] with points in space moved along the ray to where it enters the
        atmosphere; `clear` (K, S) where it never does.
        """
        top = self.levels[-1]
        outside = (altitude > top)[:, None]
        ratio = ((EARTH_RADIUS + altitude) / (EARTH_RADIUS + np.minimum(altitude, top)))[:, None] * np.cos(elevation)
        clear = outside & ((elevation >= 0) | (ratio >= 1))
        entering = -np.arccos(np.clip(ratio, 0.0, 1.0))
        return np.minimum(altitude, top), np.where(outside & ~clear, entering, elevation), clear


def _apparent_elevations(shells: Shells) -> Floats:
    """Apparent elevations (N, U) [rad] of rays to space from each level, increasing."""
    invariant = shells.index * shells.radius
    step = (np.arange(_GRAZING_NODES + 1) / _GRAZING_NODES) ** 2
    lowest = shells.altitude[0] + (shells.altitude - shells.altitude[0])[:, None] * step
    at_lowest = np.interp(lowest, shells.altitude, invariant)
    at_lowest = np.maximum(at_lowest, invariant[0] * (1 + _CLEARANCE / shells.radius[0]))
    down = -np.arccos(np.minimum(at_lowest / invariant[:, None], 1.0))
    down[0] = 0.0
    up = np.broadcast_to(np.radians(_UP_NODES), (shells.altitude.size, len(_UP_NODES)))
    return np.concatenate([down, up], axis=1)


def _shell_air_mass(altitude: Floats, elevation: Floats) -> Floats:
    """Air mass of a homogeneous shell above a point at an altitude [m], towards an elevation [rad]: smooth in
    elevation, above and below the horizon.
    """
    height = (EARTH_RADIUS + altitude) / _SCALE_HEIGHT
    across = height * np.sin(elevation)
    root = np.sqrt(across**2 + 2 * height + 1)
    # Of the two equal forms, the one without cancellation.
    return np.where(across > 0, (2 * height + 1) / (root + np.abs(across)), root + np.abs(across))


def _fractional_index(nodes: Floats, points: Floats) -> Floats:
    """Place of angles (K, S) among increasing nodes (K, U) [rad], as an index with a fraction, held at both ends."""
    # One interpolation for all rows, each moved beyond the one before: quicker than one interpolation a row.
    move = 2 * np.pi * np.arange(len(nodes))[:, None]
    index = np.broadcast_to(np.arange(nodes.shape[1], dtype=float), nodes.shape)
    clipped = np.clip(points, nodes[:, :1], nodes[:, -1:])
    place: Floats = np.interp(clipped + move, (nodes + move).ravel(), index.ravel())
    return place
