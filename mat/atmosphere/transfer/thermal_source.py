"""Thermal source function of air that scatters: emission, and diffuse radiation scattered into a line of sight.

Scattering by molecules is negligible at thermal wavelengths and is counted as absorption.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES, ScaledLayers, delta_fraction, solved_moments
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS, place
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers, Reals

# Points solved together: their arrays fit into a processor's cache.
_CHUNK = 64


@dataclass(frozen=True, eq=False)
class ThermalSource:
    """Source function of thermal radiation at N levels and P points, W m^-2 sr^-1 (cm^-1)^-1.

    Attributes
    ----------
    by_direction : (N, X, P) array
        For radiation that travels in each of the directions, or X = 1 where it is the same in all of them; single or
        double precision.
    angles : (X,) array
        Of the directions from the vertical, rad, increasing.
    shift : (N-1, X, P) array or None
        As of `diffuse_field.ScaledLayers.source`.
    """

    by_direction: Reals
    angles: Floats
    shift: Reals | None = None

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        shells: Shells,
        optics: SpectralOptics,
        nodes: int = NODES,
        angles: Sequence[float] = DIRECTIONS,
    ) -> ThermalSource:
        """The source function of a state, whose ground emits and reflects from below: the blackbody radiance alone
        where no particles scatter; with so many nodes of each hemisphere, in directions at angles from the vertical,
        rad.
        """
        if not np.any(optics.aerosol_scattering):
            return cls(optics.emission[:, None], np.zeros(1))
        points = optics.wavenumber.size
        source, shifts = np.empty((state.altitude.size, len(angles), points)), dict[int, Floats]()
        albedo = np.broadcast_to(state.albedo_at(optics.wavenumber), (points,))
        ground = (1 - albedo) * planck_wavenumber(optics.wavenumber, state.surface_temperature)
        moments, fraction = solved_moments(optics, nodes), delta_fraction(optics, nodes)

        def solve(start: int) -> None:
            part = slice(start, start + _CHUNK)
            few = optics.at(part)
            layers = ScaledLayers.of(shells, few, moments, fraction[:, part], molecules=False, azimuthal=1)
            rising, falling = layers.thermal(few.emission, ground[part], albedo[part])
            light, shift = layers.source(np.cos(angles), rising, falling, few.emission)
            source[..., part] = light[:, 0, :, 0]
            if shift is not None:
                shifts[start] = shift[:, 0, :, 0]

        parallel_map(solve, range(0, points, _CHUNK))
        whole = None
        if shifts:
            whole = np.zeros((state.altitude.size - 1, *source.shape[1:]))
            for start, values in shifts.items():
                whole[..., start : start + _CHUNK] = values
        return cls(source, np.array(angles), whole)

    @property
    def isotropic(self) -> bool:
        """Radiation is the same in all directions, as without particles."""
        return len(self.by_direction[0]) == 1

    @property
    def single(self) -> ThermalSource:
        """The same in single precision."""
        shift = None if self.shift is None else self.shift.astype(np.float32)
        return replace(self, by_direction=self.by_direction.astype(np.float32), shift=shift)

    def toward_observer(self, segments: Segments) -> tuple[Reals, Reals]:
        """Source function at the lower and at the upper level of each segment's layer, (K, P) each, for radiation that
        travels towards the observer.
        """
        table, layer = self.by_direction, segments.layer
        if self.isotropic:
            return table[layer, 0], table[layer + 1, 0]
        first, next_share = place(segments.upward_cosine, self.angles)
        share = next_share.astype(table.dtype)[:, None]

        def at_level(level: Integers) -> Reals:
            near, far = table[level, first], table[level, first + 1]
            if self.shift is not None:
                near += self.shift[layer, first]
                far += self.shift[layer, first + 1]
            far -= near
            far *= share
            far += near
            return far

        return at_level(layer), at_level(layer + 1)

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
        table = self.by_direction[layer : layer + 2]
        if self.isotropic:
            both = table[:, 0]
        else:
            if self.shift is not None:
                table = table + self.shift[layer]
            first, next_share = place(np.array([upward_cosine]), self.angles)
            both = table[:, first[0]] * (1 - next_share[0]) + table[:, first[0] + 1] * next_share[0]
        source: Floats = both[0] * (1 - share) + both[1] * share
        return source
