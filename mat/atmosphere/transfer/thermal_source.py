"""Thermal source function of air that scatters: emission, and diffuse radiation scattered into a line of sight.

Scattering by molecules is negligible at thermal wavelengths and is counted as absorption.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates, ordinates
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers

# Points solved together in a field of so many nodes a hemisphere, more where nodes are fewer: their arrays fit into a
# processor's cache.
_CHUNK, _CHUNK_NODES = 64, 8
_SPECTRAL = ("extinction", "scaled", "source", "straight")  # arrays of a field by spectral point


@dataclass(frozen=True, eq=False)
class ThermalSource:
    """Source function of thermal radiation at N levels and P points, W m^-2 sr^-1 (cm^-1)^-1.

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    emission : (N, P) array
        Blackbody radiance of the air: the source function where no particles scatter.
    field : ThermalField or None
        What scattering makes of it; None where no particles scatter, and radiation is the same in all directions.
    """

    levels: Floats
    emission: Floats
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


def level_emission(
    state: AtmosphericState, shells: Shells, optics: SpectralOptics, nodes: int = NODES
) -> tuple[Floats, Floats]:
    """Rising and falling thermal flux on the levels, (N, P) W m^-2 (cm^-1)^-1; arguments as of `ThermalSource.of`."""
    rising, falling = np.empty((2, state.altitude.size, optics.wavenumber.size))
    parts = layer_parts(shells, optics, delta_fraction(optics, nodes), molecules=False)

    def take(part: slice, reduced: SpectralOptics, layers: ScaledLayers, up: Floats, down: Floats) -> None:
        rising[:, part] = layers.ordinates.flux(up[parts.levels])[:, 0]
        falling[:, part] = layers.ordinates.flux(down[parts.levels])[:, 0]

    _solve(state, shells, optics, nodes, parts, take)
    return rising, falling


def _solve(
    state: AtmosphericState,
    shells: Shells,
    optics: SpectralOptics,
    nodes: int,
    parts: LayerParts,
    take: Callable[[slice, SpectralOptics, ScaledLayers, Floats, Floats], None],
) -> None:
    """Hand over the layers, and thermal radiances rising and falling at the ends of their parts, some points at a
    time.
    """
    points = optics.wavenumber.size
    moments, fraction = solved_moments(optics, nodes), delta_fraction(optics, nodes)
    albedo = np.broadcast_to(state.albedo_at(optics.wavenumber), (points,))
    ground = (1 - albedo) * planck_wavenumber(optics.wavenumber, state.surface_temperature)
    together = _CHUNK * max(1, _CHUNK_NODES // nodes)

    def solve(start: int) -> None:
        part = slice(start, start + together)
        reduced = optics.at(part)
        layers = ScaledLayers.of(shells, reduced, moments, fraction[:, part], molecules=False, azimuthal=1, parts=parts)
        take(part, reduced, layers, *layers.thermal(reduced.emission, ground[part], albedo[part]))

    parallel_map(solve, range(0, points, together))


@dataclass(frozen=True, eq=False)
class ThermalField:
    """Thermal radiation among particles.

    Attributes
    ----------
    ordinates : Ordinates
        Ordinates of radiation that does not depend on azimuth.
    extinction, scaled : (N, P) arrays
        All, and delta-scaled, m^2 per molecule.
    source : (Q, B, P) array
        Source function of the scaled layers, by `Ordinates.functions` of direction.
    straight : (N, X, P) array
        Radiance at the levels by direction, which particles scatter straight forward.
    angles : (X,) array
        Angles of its directions from the vertical, rad, increasing.
    """

    ordinates: Ordinates
    parts: LayerParts
    extinction: Floats
    scaled: Floats
    source: Floats
    straight: Floats
    angles: Floats

    @classmethod
    def of(
        cls, state: AtmosphericState, shells: Shells, optics: SpectralOptics, nodes: int, angles: Floats
    ) -> ThermalField:
        """The field of a state; arguments as of `ThermalSource.of`."""
        points, directions = optics.wavenumber.size, ordinates(nodes, 1)
        fraction = delta_fraction(optics, nodes)
        parts = layer_parts(shells, optics, fraction, molecules=False)
        source = np.empty((parts.places, directions.pairs[0].size, points))
        straight = np.empty((state.altitude.size, angles.size, points))

        def take(part: slice, reduced: SpectralOptics, layers: ScaledLayers, up: Floats, down: Floats) -> None:
            source[..., part] = layers.source(up, down, reduced.emission)[:, 0]
            straight[..., part] = layers.radiance(np.cos(angles), up, down, reduced.emission)[:, :, 0, 0]

        _solve(state, shells, optics, nodes, parts, take)
        scaled = optics.extinction - optics.aerosol_scattering * fraction
        return cls(directions, parts, optics.extinction, scaled, source, straight, angles)

    def part(self, points: slice | Integers) -> ThermalField:
        """The same at some of the points."""
        parts: dict[str, Any] = {name: np.ascontiguousarray(getattr(self, name)[..., points]) for name in _SPECTRAL}
        return replace(self, **parts)
