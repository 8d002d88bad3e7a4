"""Thermal source function of air that scatters: emission, and diffuse radiation scattered into a line of sight.

Scattering by molecules is negligible at thermal wavelengths and is counted as absorption.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.diffuse_field import (
    NODES,
    ScaledLayers,
    delta_fraction,
    layer_parts,
    solved_moments,
)
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS, direction_weights
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.line_weights import end_weights, part_weights, straight_places, straight_share
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates, ordinates
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments, emitted
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers, Reals

# Points solved together in a field of so many nodes a hemisphere, more where nodes are fewer: their arrays fit into a
# processor's cache.
_CHUNK, _CHUNK_NODES = 64, 8
_SPECTRAL = ("extinction", "scaled", "source", "straight")  # arrays of a field by spectral point
_GATHERED = 1 << 18  # numbers of a table copied at once for a ray


@dataclass(frozen=True, eq=False)
class ThermalSource:
    """Source function of thermal radiation at N levels and P points, W m^-2 sr^-1 (cm^-1)^-1.

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    emission : (N, P) array, single or double precision
        Blackbody radiance of the air: the source function where no particles scatter.
    field : ThermalField or None
        What scattering makes of it; None where no particles scatter, and radiation is the same in all directions.
    """

    levels: Floats
    emission: Reals
    field: ThermalField | None

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        shells: Shells,
        optics: SpectralOptics,
        nodes: int = NODES,
        angles: Sequence[float] = DIRECTIONS,
    ) -> ThermalSource:
        """The source function of a state, whose ground emits and reflects from below; with so many nodes of each
        hemisphere, and radiation scattered straight forward by directions at angles from the vertical, rad.
        """
        if not np.any(optics.aerosol_scattering):
            return cls(state.altitude, optics.emission, None)
        return cls(state.altitude, optics.emission, ThermalField.of(state, shells, optics, nodes, np.array(angles)))

    def part(self, points: slice | Integers) -> ThermalSource:
        """The same at some of the points."""
        field = None if self.field is None else self.field.part(points)
        return replace(self, emission=self.emission[:, points], field=field)

    @property
    def single(self) -> ThermalSource:
        """The same in single precision."""
        field = None if self.field is None else self.field.single
        return replace(self, emission=self.emission.astype(np.float32), field=field)

    def along(self, segments: Segments, depths: Depths) -> Reals:
        """Radiance of each segment of a ray at the observer, (K, P), in the depths' precision."""
        if self.field is not None:
            return self.field.along(segments, depths, self.levels)
        layer = segments.layer
        near, far = segments.source_ends(self.emission[layer], self.emission[layer + 1], self.levels)
        return emitted(depths, near, far)

    def at(self, layer: int, share: float, upward_cosine: float) -> Floats:
        """Source function (P,) at one place.

        Parameters
        ----------
        layer : int
        share : float
            Weight of its upper level.
        upward_cosine : float
            Of the angle from the vertical at which the radiation travels.
        """
        if self.field is not None:
            return self.field.at(layer, share, upward_cosine)
        source: Floats = self.emission[layer] * (1 - share) + self.emission[layer + 1] * share
        return source


@dataclass(frozen=True, eq=False)
class ThermalField:
    """Thermal radiation among particles.

    Attributes
    ----------
    ordinates : Ordinates
        Of radiation that does not depend on azimuth.
    parts : LayerParts
    extinction, scaled : (N, P) arrays
        All, and delta-scaled, m^2 per molecule.
    source : (Q, B, P) array
        Source function of the scaled layers, by `Ordinates.functions` of direction.
    straight : (N, X, P) array
        Radiance at the levels by direction, which particles scatter straight forward.
    angles : (X,) array
        Of its directions from the vertical, rad, increasing.
    """

    ordinates: Ordinates
    parts: LayerParts
    extinction: Floats
    scaled: Floats
    source: Reals
    straight: Reals
    angles: Floats

    @classmethod
    def of(
        cls, state: AtmosphericState, shells: Shells, optics: SpectralOptics, nodes: int, angles: Floats
    ) -> ThermalField:
        """The field of a state; arguments as of `ThermalSource.of`."""
        points, directions = optics.wavenumber.size, ordinates(nodes, 1)
        moments, fraction = solved_moments(optics, nodes), delta_fraction(optics, nodes)
        parts = layer_parts(shells, optics, fraction, molecules=False)
        source = np.empty((parts.places, directions.pairs[0].size, points))
        straight = np.empty((state.altitude.size, angles.size, points))
        albedo = np.broadcast_to(state.albedo_at(optics.wavenumber), (points,))
        ground = (1 - albedo) * planck_wavenumber(optics.wavenumber, state.surface_temperature)

        together = _CHUNK * max(1, _CHUNK_NODES // nodes)

        def solve(start: int) -> None:
            part = slice(start, start + together)
            few = optics.at(part)
            layers = ScaledLayers.of(shells, few, moments, fraction[:, part], molecules=False, azimuthal=1, parts=parts)
            rising, falling = layers.thermal(few.emission, ground[part], albedo[part])
            source[..., part] = layers.source(rising, falling, few.emission)[:, 0]
            straight[..., part] = layers.radiance(np.cos(angles), rising, falling, few.emission)[:, :, 0, 0]

        parallel_map(solve, range(0, points, together))
        scaled = optics.extinction - optics.aerosol_scattering * fraction
        return cls(directions, parts, optics.extinction, scaled, source, straight, angles)

    def part(self, points: slice | Integers) -> ThermalField:
        """The same at some of the points."""
        parts: dict[str, Any] = {name: np.ascontiguousarray(getattr(self, name)[..., points]) for name in _SPECTRAL}
        return replace(self, **parts)

    @property
    def single(self) -> ThermalField:
        """The same in single precision."""
        return replace(self, **{name: getattr(self, name).astype(np.float32) for name in _SPECTRAL})

    def along(self, segments: Segments, depths: Depths, levels: Floats) -> Reals:
        """As `ThermalSource.along`, with the altitudes (N,) [m] of the levels."""
        functions, layer = self.ordinates.functions(segments.upward_cosine), segments.layer
        scaled = Depths(segments.column(self.scaled), depths.first)
        radiance = self._straight_along(segments, depths, scaled, levels)
        cut = self.parts.count[layer] > 1
        whole = np.flatnonzero(~cut)
        ends = end_weights(segments, depths, scaled, levels, self.scaled, whole)
        for place, weight in zip((layer[whole], layer[whole] + 1), ends, strict=True):
            radiance[whole] += weight * self._source(place, functions[whole])
        if np.any(cut):
            row, place, weight = part_weights(segments, depths, scaled, levels, self.parts, np.flatnonzero(cut))
            np.add.at(radiance, row, weight * self._source(place, functions[row]))
        return radiance

    def _source(self, place: Integers, functions: Floats) -> Reals:
        """Source function (E, P) at places (E,), of functions of direction (E, B)."""
        count = functions.shape[1]
        return _looked_up(self.source, place[:, None] * count + np.arange(count), functions)

    def _straight_along(self, segments: Segments, depths: Depths, scaled: Depths, levels: Floats) -> Reals:
        """Radiance (K, P) that the segments scatter straight forward; arguments as of `along`."""
        share, first, of_direction = straight_places(segments, levels, self.angles)
        near = (segments.layer * self.angles.size + first)[:, None] + np.arange(of_direction.shape[1])
        rows = np.concatenate([near, near + self.angles.size], axis=1)
        factor = np.concatenate([(1 - share)[:, None] * of_direction, share[:, None] * of_direction], axis=1)
        return straight_share(depths, scaled) * _looked_up(self.straight, rows, factor)

    def at(self, layer: int, share: float, upward_cosine: float) -> Floats:
        """As `ThermalSource.at`."""
        direction = np.array([upward_cosine])
        places, weight = self.parts.at(layer, share)
        scattered = np.tensordot(weight, self.ordinates.functions(direction)[0] @ self.source[places], 1)
        ends, both = np.array([1 - share, share]), slice(layer, layer + 2)
        first, of_direction = direction_weights(direction, self.angles)
        near = slice(first[0], first[0] + of_direction.shape[1])
        straight = np.tensordot(ends[:, None] * of_direction, self.straight[both, near], 2)
        whole, scaled = (ends @ part[both] for part in (self.extinction, self.scaled))
        source: Floats = (scaled * scattered + (whole - scaled) * straight) / np.where(whole > 0, whole, 1.0)
        return source


def _looked_up(table: Reals, rows: Integers, factor: Floats) -> Reals:
    """Sums (E, P) of rows (E, B) of a table (..., P), counted through all its axes but the last, times factors."""
    table = table.reshape(-1, table.shape[-1])
    result = np.empty((len(rows), table.shape[1]), table.dtype)
    factor = factor[:, None].astype(table.dtype)
    at_once = max(1, _GATHERED // (rows.shape[1] * table.shape[1]))
    for start in range(0, len(rows), at_once):
        some = slice(start, start + at_once)
        result[some] = (factor[some] @ table[rows[some]])[:, 0]
    return result
