"""Optical depth from a distant source to any point of the atmosphere."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int64, c_void_p
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells, departure_angle, trace
from skyshine.mat.atmosphere.transfer.kernel_arrays import SCRATCH, KernelArrays, padded
from skyshine.mat.kernel.library import function
from skyshine.schemas.arrays import Floats, Singles

_SMALLEST_DEPTH = 1e-30  # optical depth whose logarithm is finite in single precision
# Nodes of the source table. Down: the lowest point of the ray, as (i / n)^2 of the height above the ground. Up:
# degrees.
_GRAZING_NODES = 20
_UP_NODES = (0.2, 0.5, 1, 1.5, 2, 3, 4, 5.5, 7.5, 10, 14, 20, 28, 40, 55, 75, 90)
# A ray that passes this far above the ground (m) is the lowest that reaches space.
_CLEARANCE = 1e-3
# Scale height of the shell whose air mass divides the slant optical depths of the table; 8 km is the air's (any would
# do).
_SCALE_HEIGHT = 8e3


class PathsStructure(ctypes.Structure):
    """`SourcePaths` of source_paths.h."""

    _fields_ = (
        *((name, c_int64) for name in ("levels", "nodes", "points")),
        ("earth_radius", c_double),
        ("scale_height", c_double),
        *((name, c_void_p) for name in ("altitude", "elevation", "log_depth")),
    )


_ARGUMENTS = (POINTER(PathsStructure), c_int64, c_int64, *[c_void_p] * 5)
_SCRATCH = 72  # bytes of `source_depth` for each source: three numbers and a place in the table


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

    def structure(self, arrays: KernelArrays) -> PathsStructure:
        """The tables as the kernel reads them."""
        addresses = arrays.address(self.levels), arrays.address(self.elevation), arrays.rows(self.log_depth, np.float32)
        return PathsStructure(*self.log_depth.shape, EARTH_RADIUS, _SCALE_HEIGHT, *addresses)

    def optical_depth(self, altitude: npt.ArrayLike, cosine: Floats) -> Singles:
        """Optical depth to the source.

        Parameters
        ----------
        altitude : (K,) array
            Altitudes of the points, m.
        cosine : (K, S) array
            Cosine of the source's geometric zenith angle at each point.

        Returns
        -------
        (K, S, P) array
            Single precision; 1e4 or more where the Earth hides the source.
        """
        altitude = np.asarray(altitude, dtype=float)
        count, points = cosine.shape[1], self.log_depth.shape[2]
        arrays, row = KernelArrays(), padded(points)
        depth: Singles = np.empty((*cosine.shape, points), np.float32)
        scratch = SCRATCH.of(4 * row + _SCRATCH * padded(count))
        addresses = arrays.address(altitude), arrays.address(cosine), scratch, scratch + 4 * row, depth.ctypes.data
        function("source_depth", _ARGUMENTS, None)(self._structure, altitude.size, count, *addresses)
        return depth

    @cached_property
    def _structure(self) -> PathsStructure:
        arrays = KernelArrays()
        structure = self.structure(arrays)
        structure.arrays = arrays  # they live as long
        return structure


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
    # This is the one of two equal forms that has no cancellation.
    return np.where(across > 0, (2 * height + 1) / (root + np.abs(across)), root + np.abs(across))
