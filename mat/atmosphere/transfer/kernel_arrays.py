"""Arrays and structures of the kernel's functions (`mat/kernel`): tables by spectral point in rows of a multiple of
eight numbers, the segments of joined lines, the layers of a field of scattered light.
"""

from __future__ import annotations

import ctypes
import threading
from ctypes import c_int64, c_void_p
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.directions import direction_cubics
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.node_cubics import NodeCubics
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.schemas.arrays import Floats, Integers, Reals

# Molecules m^-2 that count as one, as in rays.h: air and cross sections are then inside the range of single precision.
UNIT_OF_AIR = 2.0**83
_ROW = 8


class RaysStructure(ctypes.Structure):
    """`Rays` of rays.h."""

    _fields_ = (
        ("lines", c_int64),
        ("segments", c_int64),
        *((name, c_void_p) for name in ("first", "layer", "lower", "upper", "altitude", "rise")),
    )


class CubicsStructure(ctypes.Structure):
    """`Cubics` of rays.h."""

    _fields_ = (
        ("nodes", c_int64),
        ("width", c_int64),
        *((name, c_void_p) for name in ("node", "first", "coefficient")),
    )


class PartsStructure(ctypes.Structure):
    """`Parts` of rays.h."""

    _fields_ = (("pairs", c_int64), *((name, c_void_p) for name in ("count", "edge", "place", "share")))


class LayersStructure(ctypes.Structure):
    """`Layers` of rays.h."""

    _fields_ = (
        *((name, c_int64) for name in ("levels", "points", "moments", "azimuthal")),
        ("altitude", c_void_p),
        ("parts", PartsStructure),
        ("directions", c_int64),
        ("above", c_int64),
        ("direction", CubicsStructure),
    )


def empty_rows(shape: tuple[int, ...], dtype: npt.DTypeLike) -> Any:
    """Zeros of a shape (..., P), whose rows have room for a multiple of eight numbers: `KernelArrays.rows` takes them
    as they are.
    """
    points = shape[-1]
    return np.zeros((*shape[:-1], padded(points)), dtype)[..., :points]


def padded(points: int) -> int:
    """Numbers in a row of so many spectral points."""
    return -(-points // _ROW) * _ROW


class KernelArrays:
    """Addresses of arrays, which live as long as this does."""

    def __init__(self) -> None:
        self._arrays: list[npt.NDArray[Any]] = []

    def address(self, array: npt.ArrayLike, dtype: npt.DTypeLike = float) -> int:
        """Address of an array of that type, one number after the other."""
        return self._kept(np.ascontiguousarray(array, dtype))

    def rows(self, array: Reals, dtype: npt.DTypeLike, scale: float = 1.0) -> int:
        """Address of an array (..., P) times a scale, in rows of a multiple of eight numbers, 0 beyond the points."""
        points, dtype = array.shape[-1], np.dtype(dtype)
        if scale == 1 and array.dtype == dtype and _has_rows(array):
            return self._kept(array)
        rows = np.zeros((*array.shape[:-1], padded(points)), dtype)
        np.multiply(array, scale, out=rows[..., :points], casting="same_kind")
        return self._kept(rows)

    def cubics(self, cubics: NodeCubics) -> CubicsStructure:
        """Cubics between nodes."""
        _, width, _ = cubics.coefficient.shape
        addresses = (
            self.address(cubics.nodes),
            self.address(cubics.first_node, np.int64),
            self.address(cubics.coefficient),
        )
        return CubicsStructure(cubics.nodes.size, width, *addresses)

    def layers(
        self, levels: Floats, points: int, moments: int, azimuthal: int, parts: LayerParts, angles: Floats
    ) -> LayersStructure:
        """Layers between levels (N,) [m] with so many points, Legendre and azimuthal moments, their parts, and the
        directions (X,) [rad] of light scattered straight forward.
        """
        edges, positions, shares = parts.pairs
        addresses = self.address(parts.count, np.int64), self.address(edges), self.address(positions, np.int64)
        of_parts = PartsStructure(len(positions), *addresses, self.address(shares))
        cubics, above = direction_cubics(tuple(angles.tolist()))
        return LayersStructure(
            levels.size,
            points,
            moments,
            azimuthal,
            self.address(levels),
            of_parts,
            angles.size,
            above,
            self.cubics(cubics),
        )

    def rays(self, segments: Segments, starts: Integers) -> RaysStructure:
        """The segments of joined lines whose first ends are (L,)."""
        integers = (self.address(numbers, np.int64) for numbers in (starts, segments.layer))
        reals = (segments.lower, segments.upper, segments.altitude, segments.upward_cosine)
        return RaysStructure(starts.size, segments.layer.size, *integers, *map(self.address, reals))

    def _kept(self, array: npt.NDArray[Any]) -> int:
        self._arrays.append(array)
        address: int = array.ctypes.data
        return address


def _has_rows(array: Reals) -> bool:
    """An array lies in memory as `KernelArrays.rows` makes it."""
    shape = (*array.shape[:-1], padded(array.shape[-1]))
    if array.shape == shape:
        return array.flags.c_contiguous
    base = array.base
    return isinstance(base, np.ndarray) and base.shape == shape and base.flags.c_contiguous


class Scratch(threading.local):
    """Memory that a thread's calls use one after the other."""

    def __init__(self) -> None:
        self._memory = np.empty(0)

    def of(self, size: int) -> int:
        """Address of so many bytes."""
        if self._memory.nbytes < size:
            self._memory = np.empty(-(-size // 8))
        address: int = self._memory.ctypes.data
        return address


SCRATCH = Scratch()
