"""Thermal radiation along lines of sight, computed in C (`mat/kernel/thermal.c`).

The source function is linear in optical depth inside a segment, or, among particles, in each part of a cut layer
quadratic; diffuse radiation that particles scatter straight forward is added. Air of one temperature without particles
gives exactly (1 - transmittance) times its blackbody radiance.
"""

from __future__ import annotations

from ctypes import POINTER, c_int64, c_void_p

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.kernel_arrays import (
    SCRATCH,
    UNIT_OF_AIR,
    KernelArrays,
    LayersStructure,
    RaysStructure,
    padded,
)
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalSource
from skyshine.mat.kernel.library import function
from skyshine.schemas.arrays import Reals

_RAYS, _LAYERS = POINTER(RaysStructure), POINTER(LayersStructure)
_EMITTED = (_RAYS, c_int64, c_void_p, c_void_p, c_void_p, c_void_p, c_void_p)
_THERMAL = (_RAYS, _LAYERS, *[c_void_p] * 7)
_ROWS = 8  # rows of scratch, of which each function uses as many or fewer


class ThermalLight:
    """Tables of a source function in single or double precision.

    Parameters
    ----------
    real : dtype
        float32 or float64.
    """

    def __init__(self, source: ThermalSource, real: npt.DTypeLike) -> None:
        self._arrays, self._real = KernelArrays(), np.dtype(real)
        self._points, self._field = source.emission.shape[1], source.field
        self._suffix = "f" if self._real == np.float32 else "d"
        self._levels = self._arrays.address(source.levels)
        field = source.field
        if field is None:
            self._emission = self._arrays.rows(source.emission, self._real)
            return
        self._layers = self._arrays.layers(
            source.levels, self._points, field.ordinates.moments, 1, field.parts, field.angles
        )
        self._tables = (
            self._arrays.rows(field.scaled, self._real, UNIT_OF_AIR),
            self._arrays.rows(field.source, self._real),
            self._arrays.rows(field.straight, self._real),
        )

    def of_segments(self, segments: Segments, depths: Depths) -> Reals:
        """Radiance of each segment of joined lines at the observer, (K, P), of depths in this precision."""
        arrays = KernelArrays()
        rays = arrays.rays(segments, depths.starts)
        depth = arrays.address(depths.per_segment, self._real)
        radiance = np.zeros(depths.per_segment.shape, self._real)
        row = padded(self._points) * self._real.itemsize
        if self._field is None:
            scratch = SCRATCH.of(_ROWS * row)
            kernel = function(f"emitted_{self._suffix}", _EMITTED, None)
            kernel(rays, self._points, self._levels, self._emission, depth, scratch, radiance.ctypes.data)
            return radiance
        functions = 8 * self._field.ordinates.pairs[0].size
        scratch = SCRATCH.of(functions + _ROWS * row)
        kernel = function(f"thermal_{self._suffix}", _THERMAL, None)
        kernel(rays, self._layers, *self._tables, depth, scratch, scratch + functions, radiance.ctypes.data)
        return radiance
