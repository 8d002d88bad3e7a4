"""Thermal source function of air that scatters: emission, and diffuse radiation scattered into a line of sight.

Scattering by molecules is negligible at thermal wavelengths and is counted as absorption.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from skyshine.mat.atmosphere.transfer.line_weights import LineWeights, source_weights_along, straight_weights
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates, ordinates
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments, emitted
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Reals

# Points solved together: their arrays fit into a processor's cache.
_CHUNK = 64
# Share of the extinction at all levels up to which scattering straight forward counts among the moments of the
# ordinates: thermal radiation changes by a fifth of it at most, along a level path, and needs one table instead of two.
_STRAIGHT = 0.006
_TABLES = "extinction", "scaled", "source", "straight"


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
    straight : (N, X, P) array or None
        Radiance at the levels by direction, which particles scatter straight forward; None where none do.
    angles : (X,) array
        Of its directions from the vertical, rad, increasing.
    """

    ordinates: Ordinates
    parts: LayerParts
    extinction: Floats
    scaled: Floats
    source: Reals
    straight: Reals | None
    angles: Floats

    @classmethod
    def of(
        cls, state: AtmosphericState, shells: Shells, optics: SpectralOptics, nodes: int, angles: Floats
    ) -> ThermalField:
        """The field of a state; arguments as of `ThermalSource.of`."""
        points, directions = optics.wavenumber.size, ordinates(nodes, 1)
        moments, fraction = solved_moments(optics, nodes), _delta_fraction(optics, nodes)
        parts = layer_parts(shells, optics, fraction, molecules=False)
        source = np.empty((parts.places, directions.pairs[0].size, points))
        straight = np.empty((state.altitude.size, angles.size, points)) if np.any(fraction) else None
        albedo = np.broadcast_to(state.albedo_at(optics.wavenumber), (points,))
        ground = (1 - albedo) * planck_wavenumber(optics.wavenumber, state.surface_temperature)

        def solve(start: int) -> None:
            part = slice(start, start + _CHUNK)
            few = optics.at(part)
            layers = ScaledLayers.of(shells, few, moments, fraction[:, part], molecules=False, azimuthal=1, parts=parts)
            rising, falling = layers.thermal(few.emission, ground[part], albedo[part])
            source[..., part] = layers.source(rising, falling, few.emission)[:, 0]
            if straight is not None:
                straight[..., part] = layers.radiance(np.cos(angles), rising, falling, few.emission)[:, :, 0, 0]

        parallel_map(solve, range(0, points, _CHUNK))
        scaled = optics.extinction - optics.aerosol_scattering * fraction
        return cls(directions, parts, optics.extinction, scaled, source, straight, angles)

    @property
    def single(self) -> ThermalField:
        """The same in single precision."""
        names = ("extinction", "scaled", "source") if self.straight is None else _TABLES
        return replace(self, **{name: getattr(self, name).astype(np.float32) for name in names})

    def along(self, segments: Segments, depths: Depths, levels: Floats) -> Reals:
        """As `ThermalSource.along`, with the altitudes (N,) [m] of the levels."""
        functions = self.ordinates.functions(segments.upward_cosine)
        scaled = depths if self.straight is None else Depths(segments.column(self.scaled))
        weights = source_weights_along(segments, depths, scaled, levels, self.scaled, self.parts, functions)
        radiance = _along(self.source, weights, segments)
        if self.straight is not None:
            weights = straight_weights(segments, depths, scaled, levels, self.angles)
            radiance += _along(self.straight, weights, segments)
        return radiance

    def at(self, layer: int, share: float, upward_cosine: float) -> Floats:
        """As `ThermalSource.at`."""
        direction = np.array([upward_cosine])
        places, weight = self.parts.at(layer, share)
        scattered = np.tensordot(weight, self.ordinates.functions(direction)[0] @ self.source[places], 1)
        ends, both = np.array([1 - share, share]), slice(layer, layer + 2)
        if self.straight is None:
            result: Floats = scattered
            return result
        straight = np.tensordot(ends[:, None] * direction_weights(direction, self.angles), self.straight[both], 2)
        whole, scaled = (ends @ part[both] for part in (self.extinction, self.scaled))
        source: Floats = (scaled * scattered + (whole - scaled) * straight) / np.where(whole > 0, whole, 1.0)
        return source


def _delta_fraction(optics: SpectralOptics, nodes: int) -> Floats:
    """`delta_fraction` of thermal radiation, (N, P): 0 where little of it is scattered straight forward."""
    fraction = delta_fraction(optics, nodes)
    share = optics.aerosol_scattering * fraction / np.where(optics.extinction > 0, optics.extinction, 1.0)
    result: Floats = np.where(np.max(share, axis=0) > _STRAIGHT, fraction, 0.0)
    return result


def _along(table: Reals, weights: LineWeights, segments: Segments) -> Reals:
    """Radiance (K, P) of light (Q, B, P) at the places of a table."""
    functions = slice(weights.first, weights.first + weights.factor.shape[2])
    light = np.empty(weights.weight.shape, table.dtype)
    for rows, places in weights.runs():
        np.matmul(weights.factor[rows].astype(table.dtype), table[places, functions], out=light[rows])
    light *= weights.weight
    return weights.summed(light, segments.index.size)
