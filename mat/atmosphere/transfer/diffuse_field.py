"""Diffuse light of layers, by delta-M and discrete ordinates: what the solvers of layers start from, which of them
solves a point, and the source function.

The phase function is truncated after as many moments as there are nodes in both hemispheres; the fraction of the
particles' scattering that goes straight forward is the next moment (delta-M). All extinction applies between the last
scattering and an observer, and light scattered straight forward into the line of sight is part of the source function.

References
----------
Wiscombe 1977, J. Atmos. Sci. 34, 1408 (delta-M).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.mat.atmosphere.transfer import adding, scattering_orders
from skyshine.mat.atmosphere.transfer.directions import COSINES, along_directions
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column, vertical_parts
from skyshine.mat.atmosphere.transfer.layer_modes import LARGEST_ALBEDO
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates, ordinates
from skyshine.schemas.arrays import Booleans, Floats

# Nodes of each hemisphere: `mat bench atmosphere` shows the error of fewer and more.
NODES = 4
# Vertical optical depth of scattering up to which orders of scattering converge quicker than layers are added.
_THIN = 0.3


def solved_moments(optics: SpectralOptics, nodes: int) -> Floats:
    """Legendre moments (L, N, C) of the particles' phase function that a solution of so many nodes has, at
    `optics.phase_share`'s wavelengths.
    """
    return optics.moments[: 2 * nodes]


def delta_fraction(optics: SpectralOptics, nodes: int = NODES) -> Floats:
    """Fraction (N, P) of the scattering by particles that goes straight forward: f of delta-M, the first moment of the
    phase function beyond those of the solution.

    References
    ----------
    Wiscombe 1977, J. Atmos. Sci. 34, 1408.
    """
    fraction: Floats = np.clip(optics.moments[2 * nodes] @ optics.phase_share, 0.0, None)
    return fraction


@dataclass(frozen=True, eq=False)
class ScaledLayers:
    """Delta-scaled layers between N levels at P points.

    Attributes
    ----------
    ordinates : Ordinates
    lower, upper : (N-1, P) arrays
        The parts of the layers' optical depth, from the ground up, that follow from the properties of each layer's
        lower and upper level.
    weighted : (N-1, L, P) array
        Single-scattering albedo of the layers times 2 l + 1 times the moments of the phase function.
    at_levels : (N, L, P) array
        The same at the levels.
    scaled_share, straight_share : (N, P) arrays
        Of the extinction at the levels: what is left of it, and scattering straight forward.
    """

    ordinates: Ordinates
    lower: Floats
    upper: Floats
    weighted: Floats
    at_levels: Floats
    scaled_share: Floats
    straight_share: Floats

    @classmethod
    def of(
        cls,
        shells: Shells,
        optics: SpectralOptics,
        moments: Floats,
        fraction: Floats,
        *,
        molecules: bool,
        azimuthal: int,
    ) -> ScaledLayers:
        """The layers of a state.

        Parameters
        ----------
        shells : Shells
        optics : SpectralOptics
        moments : (L, N, C) array
            `solved_moments` of the particles.
        fraction : (N, P) array
            `delta_fraction` of the optics.
        molecules : bool
            They scatter; otherwise their scattering counts as absorption.
        azimuthal : int
            Azimuthal moments of the light; 1 where it does not depend on azimuth.
        """
        directions = ordinates(len(moments) // 2, azimuthal)
        scattering = _scattering(optics, moments, fraction, molecules)  # (N, L, P)
        straight = optics.aerosol_scattering * fraction
        scaled = optics.extinction - straight
        lower, upper = vertical_parts(shells, scaled)
        columns = vertical_column(shells, scattering.reshape(len(scattering), -1)).reshape(-1, *scattering.shape[1:])
        factor = directions.factor[:, None]
        return cls(
            directions,
            lower,
            upper,
            _albedo(columns, lower + upper) * factor,
            _albedo(scattering, scaled) * factor,
            *(part / _divisor(optics.extinction) for part in (scaled, straight)),
        )

    @cached_property
    def depth(self) -> Floats:
        """Optical depth of the layers, (N-1, P)."""
        return self.lower + self.upper

    @cached_property
    def thin(self) -> Booleans:
        """Points (P,) whose layers scatter little."""
        thin: Booleans = np.sum(self.weighted[:, 0] * self.depth, axis=0) <= _THIN
        return thin

    def sunlight(self, beam: Floats, sine: Floats, albedo: Floats) -> tuple[Floats, Floats]:
        """Diffuse radiances (N, M, n, U, P) rising and falling at the levels; arguments as of `adding.sunlight`."""
        shape = (len(beam), *self.ordinates.at_nodes.shape[::2], sine.size, beam.shape[2])
        rising, falling = np.empty(shape), np.empty(shape)
        for solve, some in ((scattering_orders.sunlight, self.thin), (adding.sunlight, ~self.thin)):
            if np.any(some):
                rising[..., some], falling[..., some] = solve(
                    self.ordinates,
                    self.depth[:, some],
                    self.weighted[..., some],
                    beam[..., some],
                    sine,
                    albedo[some],
                )
        return rising, falling

    def thermal(self, emission: Floats, ground: Floats, albedo: Floats) -> tuple[Floats, Floats]:
        """Thermal radiances (N, 1, n, 1, P) rising and falling at the levels; arguments as of `adding.thermal`."""
        shape = (len(emission), 1, self.ordinates.node.size, 1, emission.shape[1])
        rising, falling = np.empty(shape), np.empty(shape)
        for solve, some in ((scattering_orders.thermal, self.thin), (adding.thermal, ~self.thin)):
            if np.any(some):
                rising[..., some], falling[..., some] = solve(
                    self.ordinates,
                    self.depth[:, some],
                    self.weighted[..., some],
                    emission[:, some],
                    ground[some],
                    albedo[some],
                )
        return rising, falling

    def source(self, rising: Floats, falling: Floats, emission: Floats | None = None) -> Floats:
        """Source function (N, M, X, U, P) at the levels for light in `DIRECTIONS`, for all extinction; of the radiances
        at the levels and, of thermal light, the blackbody radiance (N, P).
        """
        light = self.ordinates.scattered_into(self.at_levels, rising, falling, COSINES)
        if emission is not None:
            light += ((1 - self.at_levels[:, 0]) * emission)[:, None, None, None]
        if not np.any(self.straight_share):
            return light
        radiance = along_directions(self.lower, self.upper, light, rising[0, 0, 0])
        light *= self.scaled_share[:, None, None, None]
        radiance *= self.straight_share[:, None, None, None]
        light += radiance
        return light


def _scattering(optics: SpectralOptics, moments: Floats, fraction: Floats, molecules: bool) -> Floats:
    """Scattering times moments of the phase function at the levels, (N, L, P) m^2 per molecule, without the fraction
    (N, P) that goes straight forward.
    """
    particles = np.swapaxes(moments @ optics.phase_share, 0, 1) - fraction[:, None]
    result: Floats = optics.aerosol_scattering[:, None] * particles
    if molecules:
        gamma = optics.rayleigh_anisotropy
        result[:, 0] += optics.rayleigh
        result[:, 2] += optics.rayleigh * 0.1 * (1 - gamma) / (1 + 2 * gamma)  # of `optics.rayleigh_phase`
    return result


def _albedo(scattering: Floats, extinction: Floats) -> Floats:
    """Scattering (N, L, P) over extinction (N, P), without the last of it where nothing absorbs."""
    albedo = scattering / _divisor(extinction)[:, None]
    albedo *= np.minimum(LARGEST_ALBEDO / np.maximum(albedo[:, :1], LARGEST_ALBEDO), 1.0)
    return albedo


def _divisor(extinction: Floats) -> Floats:
    """Extinction with 1 where it is 0."""
    return np.where(extinction > 0, extinction, 1.0)
