"""Light of Sun or Moon scattered into lines of sight: once, with the true phase functions and what scattering again and
again in the forward peak changes, and more often, by discrete ordinates. Computed in C (`mat/kernel/scattering.c`), in
single precision.

Inside a segment the optical depth from the source through the segment to the observer is linear in distance. Light
scattered once has the scaled extinction from the source to the observer; behind the last of several scatterings all
extinction applies, and diffuse light scattered straight forward into the line of sight is added.

References
----------
Nakajima and Tanaka 1988, J. Quant. Spectrosc. Radiat. Transfer 40, 51 (exact first scattering with scaled extinction).
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int64, c_void_p

import numpy as np

from skyshine.mat.atmosphere.transfer.forward_peak import ForwardPeak
from skyshine.mat.atmosphere.transfer.kernel_arrays import (
    SCRATCH,
    UNIT_OF_AIR,
    CubicsStructure,
    KernelArrays,
    LayersStructure,
    RaysStructure,
)
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinate_light import OrdinateLight
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_nodes import FALL, FALLING, elevation_cubics, first_smooth, typical_light
from skyshine.mat.atmosphere.transfer.source_paths import PathsStructure, SourcePaths
from skyshine.mat.kernel.library import function
from skyshine.schemas.arrays import Floats, Reals

_OF_BAND, _OF_LINES, _OF_SEGMENTS = range(3)  # as in scattering.h


class _PeakStructure(ctypes.Structure):
    """`Peak` of scattering.h."""

    _fields_ = (
        ("paths", PathsStructure),
        *((name, c_void_p) for name in ("few", "every", "change")),
        ("angles", c_int64),
        ("depths", c_int64),
        ("angle", c_void_p),
        *((name, c_double) for name in ("least_depth", "log_step", "none", "whole", "farthest")),
        ("spread", c_void_p),
        ("spread_next", c_void_p),
    )


class _ScatteringStructure(ctypes.Structure):
    """`Scattering` of scattering.h."""

    _fields_ = (
        ("classes", c_int64),
        ("angles", c_int64),
        *((name, c_void_p) for name in ("scaled", "rayleigh", "particles", "particle_sum", "phase_share", "phase")),
        ("angle_step", c_double),
        ("anisotropy", c_double),
        ("paths", PathsStructure),
        ("peak", _PeakStructure),
        ("elevations", c_int64),
        ("smooth", c_int64),
        ("sine", c_void_p),
        ("typical", c_void_p),
        *((name, c_double) for name in ("fall", "start", "end")),
        ("elevation", CubicsStructure),
        ("source", c_void_p),
        ("straight", c_void_p),
    )


_TABLES = (POINTER(RaysStructure), POINTER(LayersStructure), POINTER(_ScatteringStructure), c_int64)
_ARGUMENTS = (*_TABLES, c_void_p, c_void_p, c_void_p, c_int64, c_int64, *[c_void_p] * 4)


class ScatteredLight:
    """Tables of scattered light of a state at P points.

    Parameters
    ----------
    paths : SourcePaths
        Paths through the delta-scaled extinction.
    peak : ForwardPeak or None
        None where no particles scatter.
    """

    def __init__(
        self, optics: SpectralOptics, paths: SourcePaths, peak: ForwardPeak | None, diffuse: OrdinateLight
    ) -> None:
        arrays = self._arrays = KernelArrays()
        ordinates, points = diffuse.ordinates, optics.wavenumber.size
        self._points, self._classes = points, len(optics.phase_share)
        self._layers = arrays.layers(
            diffuse.levels, points, ordinates.moments, ordinates.azimuthal, diffuse.parts, diffuse.angles
        )
        scatters = bool(np.any(optics.aerosol_scattering))
        smooth = first_smooth(diffuse.sine)
        cubics = elevation_cubics(diffuse.sine, smooth)

        def section(values: Reals) -> int:
            return arrays.rows(values, np.float32, UNIT_OF_AIR)

        self._tables = _ScatteringStructure(
            self._classes,
            PHASE_ANGLES.size,
            section(diffuse.scaled),
            section(optics.rayleigh),
            section(optics.aerosol_scattering) if scatters else None,
            arrays.address(optics.aerosol_scattering.sum(axis=1, dtype=float)),
            arrays.rows(optics.phase_share, np.float32),
            arrays.address(optics.phase, np.float32),
            PHASE_ANGLES[1],
            optics.rayleigh_anisotropy.mean(),
            paths.structure(arrays),
            _PeakStructure() if peak is None else _peak_structure(peak, arrays),
            diffuse.sine.size,
            smooth,
            arrays.address(diffuse.sine),
            arrays.address(typical_light(diffuse.sine)),
            FALL,
            *FALLING,
            CubicsStructure() if cubics is None else arrays.cubics(cubics),
            arrays.rows(diffuse.source, np.float32),
            None if diffuse.straight is None else arrays.rows(diffuse.straight, np.float32),
        )

    def in_band(
        self, segments: Segments, depths: Depths, to_source: Floats, deflection: Floats, weight: Floats
    ) -> Floats:
        """Light in a band up to each end of the segments of joined lines.

        Parameters
        ----------
        to_source, deflection : (K+1, S) arrays
            Cosines of the source's zenith angle and of the scattering angle at the segment ends.
        weight : (P,) array
            Weights of the points, times the source's irradiance there.

        Returns
        -------
        (K+1, S) array
            In the unit of the weights, sr^-1.
        """
        light = np.empty(to_source.shape)
        self._compute(segments, depths, to_source, deflection, _OF_BAND, light, weight)
        return light

    def along(
        self,
        segments: Segments,
        depths: Depths,
        to_source: Floats,
        deflection: Floats,
        phase: Floats | None = None,
    ) -> Floats:
        """Light along each of L joined lines at each point, (L, S, P) sr^-1 per unit of the source's irradiance.

        `phase` (L, N, S, C) is the phase function of the particles at the levels, at the C wavelengths of
        `SpectralOptics.phase`, in place of the one at the scattering angle; other arguments as of `in_band`.
        """
        light = np.empty((depths.starts.size, to_source.shape[1], self._points))
        self._compute(segments, depths, to_source, deflection, _OF_LINES, light, phase=phase)
        return light

    def of_segments(self, segments: Segments, depths: Depths, to_source: Floats, deflection: Floats) -> Floats:
        """Light of each segment at the observer, (K, P) sr^-1, for one source; arguments as of `in_band`, S = 1."""
        light = np.empty((segments.layer.size, self._points))
        self._compute(segments, depths, to_source, deflection, _OF_SEGMENTS, light)
        return light

    def _compute(
        self,
        segments: Segments,
        depths: Depths,
        to_source: Floats,
        deflection: Floats,
        kind: int,
        light: Floats,
        weight: Floats | None = None,
        phase: Floats | None = None,
    ) -> None:
        arrays = KernelArrays()
        sources = to_source.shape[1]
        tables = arrays.rays(segments, depths.starts), self._layers, self._tables, sources
        size = function("scattered_light_scratch", (*_TABLES, c_int64), c_int64)(*tables, kind)
        function("scattered_light", _ARGUMENTS, None)(
            *tables,
            arrays.address(to_source),
            arrays.address(deflection),
            arrays.address(depths.per_segment, depths.per_segment.dtype),
            depths.per_segment.dtype == np.float64,
            kind,
            None if weight is None else arrays.address(weight),
            None if phase is None else arrays.address(phase),
            SCRATCH.of(size),
            light.ctypes.data,
        )


def _peak_structure(peak: ForwardPeak, arrays: KernelArrays) -> _PeakStructure:
    spread, share = peak.spread

    def section(values: Floats) -> int:
        return arrays.rows(values, np.float32, UNIT_OF_AIR)

    return _PeakStructure(
        peak.paths.structure(arrays),
        section(peak.scattering[:, peak.few]),
        section(peak.scattering),
        arrays.address(peak.mixed, np.float32),
        *peak.mixed.shape[1:3],
        arrays.address(peak.degrees),
        *peak.limits,
        arrays.address(spread, np.int64),
        arrays.rows(share, np.float32),
    )
