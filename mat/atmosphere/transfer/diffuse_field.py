"""Diffuse light of layers, by delta-M and discrete ordinates: what the solvers of layers start from, which of them
solves a point, and the source function.

The phase function is truncated after as many moments as there are nodes in both hemispheres; the fraction of the
particles' scattering that goes straight forward is the next moment (delta-M). The source function of the scaled layers
is therefore a sum of as many Legendre functions of direction; light scattered straight forward is tabulated by
direction.

References
----------
Wiscombe 1977, J. Atmos. Sci. 34, 1408 (delta-M).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.mat.atmosphere.transfer import adding, scattering_orders
from skyshine.mat.atmosphere.transfer.directions import along_directions, from_parts
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column, vertical_parts
from skyshine.mat.atmosphere.transfer.layer_modes import LARGEST_ALBEDO
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates, ordinates
from skyshine.schemas.arrays import Booleans, Floats, Reals

# Nodes of each hemisphere in clear air and haze (`stream_count`); `tests/bench/atmosphere.py` has the error of others.
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
    lower, upper : (N-1, P) arrays
        The parts of the layers' optical depth, from the ground up, that follow from the properties of each layer's
        lower and upper level.
    weighted : (N-1, L, P) array
        Single-scattering albedo of the layers times 2 l + 1 times the moments of the phase function.
    at_levels : (N, L, P) array
        The same at the levels.
    straight : bool
        Particles scatter light straight forward.
    parts : LayerParts
        How the layers are cut.
    """

    ordinates: Ordinates
    lower: Floats
    upper: Floats
    weighted: Floats
    at_levels: Floats
    straight: bool
    parts: LayerParts

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
        parts: LayerParts | None = None,
    ) -> ScaledLayers:
        """The layers of a state.

        Parameters
        ----------
        moments : (L, N, C) array
            `solved_moments` of the particles.
        fraction : (N, P) array
            `delta_fraction` of the optics.
        molecules : bool
            They scatter; otherwise their scattering counts as absorption.
        azimuthal : int
            Azimuthal moments of the light; 1 where it does not depend on azimuth.
        parts : LayerParts, optional
            How the layers are cut; by default not at all.
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
            bool(np.any(straight)),
            LayerParts.whole(len(lower)) if parts is None else parts,
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

    @cached_property
    def part_depth(self) -> Floats:
        """Optical depth of the parts, (K, P)."""
        low, high = self.parts.edges
        depth: Floats = self.depth[self.parts.layer] * (high - low)[:, None]
        return depth

    @cached_property
    def _part_weighted(self) -> Floats:
        """`weighted` of the parts, (K, L, P)."""
        return self.weighted[self.parts.layer] if self.parts.is_cut else self.weighted

    def sunlight(self, beam: Floats, sine: Floats, albedo: Floats) -> tuple[Floats, Floats]:
        """Diffuse radiances (K+1, M, n, U, P) rising and falling at the ends of the parts, of the beam (N, U, P);
        arguments as of `adding.sunlight`.
        """
        beam = self.parts.between(beam)
        shape = (len(beam), *self.ordinates.at_nodes.shape[::2], sine.size, beam.shape[2])
        rising, falling = np.empty(shape), np.empty(shape)
        for solve, selected in ((scattering_orders.sunlight, self.thin), (adding.sunlight, ~self.thin)):
            if np.any(selected):
                rising[..., selected], falling[..., selected] = solve(
                    self.ordinates,
                    self.part_depth[:, selected],
                    self._part_weighted[..., selected],
                    beam[..., selected],
                    sine,
                    albedo[selected],
                )
        return rising, falling

    def thermal(self, emission: Floats, ground: Floats, albedo: Floats) -> tuple[Floats, Floats]:
        """Thermal radiances (K+1, 1, n, 1, P) rising and falling at the ends of the parts, of the emission (N, P);
        arguments as of `adding.thermal`.
        """
        emission = self.parts.between(emission)
        shape = (len(emission), 1, self.ordinates.node.size, 1, emission.shape[1])
        rising, falling = np.empty(shape), np.empty(shape)
        for solve, selected in ((scattering_orders.thermal, self.thin), (adding.thermal, ~self.thin)):
            if np.any(selected):
                rising[..., selected], falling[..., selected] = solve(
                    self.ordinates,
                    self.part_depth[:, selected],
                    self._part_weighted[..., selected],
                    emission[:, selected],
                    ground[selected],
                    albedo[selected],
                )
        return rising, falling

    def source(self, rising: Reals, falling: Reals, emission: Floats | None = None) -> Reals:
        """Source function of the scaled layers, (Q, U, B, P): coefficients of the functions of direction
        `Ordinates.functions` at the places of the parts.

        Parameters
        ----------
        rising, falling : (K+1, M, n, U, P) arrays
            Radiances at the ends of the parts.
        emission : (N, P) array, optional
            Blackbody radiance at the levels, of thermal light.
        """
        moments = self._moments(rising, falling)
        layer, end = self.parts.inside
        azimuth, degree = self.ordinates.pairs
        source = np.empty((self.parts.places, moments.shape[3], degree.size, moments.shape[4]), moments.dtype)
        levels = len(self.at_levels)
        for rows, ends, weighted in (
            (slice(0, levels), self.parts.levels, self.at_levels),
            (slice(levels, None), end, self.weighted[layer]),
        ):
            coefficients = np.swapaxes(moments[ends][:, azimuth, degree], 1, 2)
            source[rows] = coefficients * weighted[:, None, degree].astype(coefficients.dtype)
        if emission is not None:
            source[:levels, 0, 0] += (1 - self.at_levels[:, 0]) * emission
            source[levels:, 0, 0] += (1 - self.weighted[layer, 0]) * self.parts.between(emission)[end]
        return source

    def radiance(self, cosine: Floats, rising: Reals, falling: Reals, emission: Floats | None = None) -> Floats:
        """Radiance (N, X, U, M, P) at the levels in directions of cosines (X,), positive up, none 0; other arguments as
        of `source`.
        """
        moments = self._moments(rising, falling)
        weighted, depth = self._part_weighted, self.part_depth
        between = None if emission is None else self.parts.between(emission)
        result = np.empty((len(self.at_levels), cosine.size, moments.shape[3], moments.shape[1], moments.shape[4]))
        for m, outgoing in enumerate(np.swapaxes(self.ordinates.legendre(cosine), -1, -2)):

            def source(end: slice, outgoing: Floats = outgoing, m: int = m) -> Reals:
                light = moments[end, m] * weighted.astype(moments.dtype)[:, :, None]
                flat = outgoing.astype(moments.dtype) @ light.reshape(*light.shape[:2], -1)
                of_end: Reals = flat.reshape(len(light), -1, *light.shape[2:])
                if between is not None and m == 0:
                    of_end += ((1 - weighted[:, 0]) * between[end])[:, None, None]
                return of_end

            below, above = source(slice(None, -1)), source(slice(1, None))
            emitted = from_parts(cosine, depth, below, above, self._bend(below, above))
            ground = rising[0, 0, 0] if m == 0 else np.zeros_like(rising[0, 0, 0])
            result[:, :, :, m] = along_directions(cosine, depth, emitted, ground)[self.parts.levels]
        return result

    def _moments(self, rising: Reals, falling: Reals) -> Reals:
        """Legendre moments (K+1, M, L, U, P) of the radiance, halved."""
        even, odd = self.ordinates.moments_at_levels(rising, falling)
        even += odd
        return even

    def _bend(self, below: Reals, above: Reals) -> Reals | None:
        """Half the second derivative in optical depth of a source (K, X, U, P) in each part, from three places: the
        ends of two parts of a layer; None where no layer is cut.
        """
        parts = self.parts
        if not parts.is_cut:
            return None
        number = np.arange(parts.layer.size) - parts.levels[parts.layer]
        even = np.flatnonzero((parts.count[parts.layer] > 1) & (number % 2 == 0))
        depth = np.maximum(self.part_depth, np.finfo(float).tiny)[:, None, None]
        slope = (above - below) / depth
        bend = np.zeros_like(slope)
        bend[even] = (slope[even + 1] - slope[even]) / (depth[even + 1] + depth[even])
        bend[even + 1] = bend[even]
        return bend


def layer_parts(shells: Shells, optics: SpectralOptics, fraction: Floats, *, molecules: bool) -> LayerParts:
    """How the layers of a state are cut, whatever the point; arguments as of `ScaledLayers.of`."""
    particles = optics.aerosol_scattering * (1 - fraction)
    scattering = particles + optics.rayleigh if molecules else particles
    scaled = optics.extinction - optics.aerosol_scattering * fraction
    return LayerParts.of(vertical_column(shells, scattering), vertical_column(shells, scaled))


def _scattering(optics: SpectralOptics, moments: Floats, fraction: Floats, molecules: bool) -> Floats:
    """Scattering times moments of the phase function at the levels, (N, L, P) m^2 per molecule, without the fraction
    (N, P) that goes straight forward.
    """
    particles = np.swapaxes(moments @ optics.phase_share, 0, 1) - fraction[:, None]
    result: Floats = optics.aerosol_scattering[:, None] * particles
    if molecules:
        gamma = optics.rayleigh_anisotropy
        result[:, 0] += optics.rayleigh
        result[:, 2] += optics.rayleigh * 0.1 * (1 - gamma) / (1 + 2 * gamma)  # as `optics.rayleigh_phase`
    return result


def _albedo(scattering: Floats, extinction: Floats) -> Floats:
    """Scattering (N, L, P) over extinction (N, P), without the last of it where nothing absorbs."""
    albedo = scattering / _divisor(extinction)[:, None]
    albedo *= np.minimum(LARGEST_ALBEDO / np.maximum(albedo[:, :1], LARGEST_ALBEDO), 1.0)
    return albedo


def _divisor(extinction: Floats) -> Floats:
    """Extinction with 1 where it is 0."""
    return np.where(extinction > 0, extinction, 1.0)
