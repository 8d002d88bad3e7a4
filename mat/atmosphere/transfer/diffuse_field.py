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
from skyshine.mat.atmosphere.transfer.directions import along_directions, from_parts, level_weights
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column, vertical_parts
from skyshine.mat.atmosphere.transfer.layer_modes import LARGEST_ALBEDO
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates, ordinates
from skyshine.schemas.arrays import Booleans, Floats, Integers, Reals

# Nodes of each hemisphere: `mat bench atmosphere` shows the error of fewer and more.
NODES = 4
# Vertical optical depth of scattering up to which orders of scattering converge quicker than layers are added.
_THIN = 0.3
# A layer that scatters more than the first of these optical depths is cut into an even number of parts, about as thin
# as the second, or into the most; those at its ends are the thinnest.
_EVEN, _PART, _MOST_PARTS = 0.01, 0.25, 16
_NOTHING = 1e-9  # absorptance of a layer below which its source function does not matter


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
    unscaled : tuple of two (N-1, P) arrays
        As `lower` and `upper`, of all extinction.
    """

    ordinates: Ordinates
    lower: Floats
    upper: Floats
    weighted: Floats
    at_levels: Floats
    scaled_share: Floats
    straight_share: Floats
    unscaled: tuple[Floats, Floats]

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
            vertical_parts(shells, optics.extinction),
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
    def parts(self) -> Integers:
        """Into how many each layer (N-1,) is cut."""
        scattering = self.weighted[:, 0] * self.depth
        needed = np.max(np.where(scattering > _EVEN, np.sqrt(scattering * self.depth), 0.0), axis=1)
        parts: Integers = np.clip(2 * np.ceil(needed / (2 * _PART)), 1, _MOST_PARTS).astype(int)
        return parts

    @property
    def is_cut(self) -> bool:
        """Any layer is cut into parts."""
        return self.layer.size > self.parts.size

    @cached_property
    def levels(self) -> Integers:
        """Places of the levels (N,) among those of the parts."""
        return np.append(0, np.cumsum(self.parts))

    @cached_property
    def layer(self) -> Integers:
        """The layer of each part, (K,)."""
        return np.repeat(np.arange(self.parts.size), self.parts)

    @cached_property
    def part_edges(self) -> tuple[Floats, Floats]:
        """Lower and upper end of each part (K,), as shares of its layer's optical depth."""
        number = np.arange(self.layer.size) - self.levels[self.layer]
        count = self.parts[self.layer]
        low, high = (0.5 - 0.5 * np.cos(np.pi * place / count) for place in (number, number + 1))
        return low, high

    @cached_property
    def part_depth(self) -> Floats:
        """Optical depth of the parts, (K, P)."""
        low, high = self.part_edges
        depth: Floats = self.depth[self.layer] * (high - low)[:, None]
        return depth

    def between(self, at_levels: Floats) -> Floats:
        """A property (N, ...) at the ends of the parts (K+1, ...), linear in the optical depth of each layer."""
        low = self.part_edges[0].reshape(-1, *(1,) * (at_levels.ndim - 1))
        inside = at_levels[self.layer] * (1 - low) + at_levels[self.layer + 1] * low
        return np.concatenate([inside, at_levels[-1:]])

    def sunlight(self, beam: Floats, sine: Floats, albedo: Floats) -> tuple[Floats, Floats]:
        """Diffuse radiances (K+1, M, n, U, P) rising and falling at the ends of the parts, of the beam (N, U, P);
        arguments as of `adding.sunlight`.
        """
        beam = self.between(beam)
        shape = (len(beam), *self.ordinates.at_nodes.shape[::2], sine.size, beam.shape[2])
        rising, falling = np.empty(shape), np.empty(shape)
        for solve, some in ((scattering_orders.sunlight, self.thin), (adding.sunlight, ~self.thin)):
            if np.any(some):
                rising[..., some], falling[..., some] = solve(
                    self.ordinates,
                    self.part_depth[:, some],
                    self.weighted[self.layer][..., some],
                    beam[..., some],
                    sine,
                    albedo[some],
                )
        return rising, falling

    def thermal(self, emission: Floats, ground: Floats, albedo: Floats) -> tuple[Floats, Floats]:
        """Thermal radiances (K+1, 1, n, 1, P) rising and falling at the ends of the parts, of the emission (N, P);
        arguments as of `adding.thermal`.
        """
        emission = self.between(emission)
        shape = (len(emission), 1, self.ordinates.node.size, 1, emission.shape[1])
        rising, falling = np.empty(shape), np.empty(shape)
        for solve, some in ((scattering_orders.thermal, self.thin), (adding.thermal, ~self.thin)):
            if np.any(some):
                rising[..., some], falling[..., some] = solve(
                    self.ordinates,
                    self.part_depth[:, some],
                    self.weighted[self.layer][..., some],
                    emission[:, some],
                    ground[some],
                    albedo[some],
                )
        return rising, falling

    def source(
        self, cosine: Floats, rising: Floats, falling: Floats, emission: Floats | None = None
    ) -> tuple[Reals, Floats | None]:
        """Source function for all extinction, of light in directions.

        Parameters
        ----------
        cosine : (X,) array
            Positive up; none is 0.
        rising, falling : (K+1, M, n, U, P) arrays
            Radiances at the ends of the parts.
        emission : (N, P) array, optional
            Blackbody radiance at the levels, of thermal light.

        Returns
        -------
        at_levels : (N, M, X, U, P) array
        shift : (N-1, M, X, U, P) array or None
            What is added to it at both levels of a layer, so that the light that leaves the whole layer is that of a
            source not linear in optical depth; None where all layers are thin, whose sunlight is in single precision.
        """
        even, odd = self.ordinates.moments_at_levels(rising, falling)
        even += odd
        cut = self.is_cut
        if not cut and emission is None:
            even = even.astype(np.float32)
        shape = (len(self.depth) + 1, even.shape[1], cosine.size, *even.shape[3:])
        light, shift = np.empty(shape, even.dtype), np.empty((shape[0] - 1, *shape[1:])) if cut else None
        for m, outgoing in enumerate(np.swapaxes(self.ordinates.legendre(cosine), -1, -2)):
            parts = _Parts(self, outgoing, even[:, m], emission if m == 0 else None)
            light[:, m] = parts.at_levels
            if not (cut or np.any(self.straight_share)):
                continue
            ground = rising[0, 0, 0] if m == 0 else np.zeros_like(rising[0, 0, 0])
            radiance = parts.radiance(cosine, ground) if cut else self._radiance(cosine, light[:, m], ground)
            light[:, m] *= self.scaled_share.astype(light.dtype)[:, None, None]
            light[:, m] += self.straight_share.astype(light.dtype)[:, None, None] * radiance
            if shift is not None:
                shift[:, m] = self._shift(cosine, light[:, m], radiance)
        return light, shift

    def _radiance(self, cosine: Floats, source: Reals, ground: Floats) -> Reals:
        """Radiance (N, X, U, P) at the levels, of a source between them as along a line of sight."""
        below, above = (part.astype(source.dtype)[:, :, None] for part in level_weights(cosine, self.lower, self.upper))
        return along_directions(cosine, self.depth, below * source[:-1] + above * source[1:], ground)

    def _shift(self, cosine: Floats, source: Floats, radiance: Floats) -> Floats:
        """`source`'s shift (N-1, X, U, P), from the source function and the radiance (N, X, U, P) at the levels."""
        below, above = (weight[:, :, None] for weight in level_weights(cosine, *self.unscaled))
        total = below + above
        rises = (cosine > 0)[:, None, None]
        enters, leaves = (
            np.where(rises, *ends) for ends in ((radiance[:-1], radiance[1:]), (radiance[1:], radiance[:-1]))
        )
        emitted = leaves - (1 - total) * enters
        missing = emitted - below * source[:-1] - above * source[1:]
        shift: Floats = np.where(total > _NOTHING, missing / np.maximum(total, _NOTHING), 0.0)
        return shift


@dataclass(frozen=True, eq=False)
class _Parts:
    """Scattered light of one azimuthal moment inside the parts of layers, in X directions.

    Attributes
    ----------
    layers : ScaledLayers
    outgoing : (X, L) array
        Associated Legendre functions of the directions.
    moments : (K+1, L, U, P) array
        Of the radiance at the ends of the parts, halved; single or double precision.
    emission : (N, P) array or None
        Blackbody radiance at the levels.
    """

    layers: ScaledLayers
    outgoing: Floats
    moments: Reals
    emission: Floats | None

    @property
    def at_levels(self) -> Reals:
        """Source function (N, X, U, P) at the levels, of the scaled extinction."""
        layers = self.layers
        return self._source(layers.at_levels, self.moments[layers.levels], self.emission)

    def radiance(self, cosine: Floats, ground: Floats) -> Floats:
        """Radiance (N, X, U, P) at the levels."""
        layers = self.layers
        weighted = layers.weighted[layers.layer]
        emission = None if self.emission is None else layers.between(self.emission)
        below, above = (
            self._source(weighted, self.moments[end], None if emission is None else emission[end])
            for end in (np.s_[:-1], np.s_[1:])
        )
        emitted = from_parts(cosine, layers.part_depth, below, above, self._bend(below, above))
        radiance: Floats = along_directions(cosine, layers.part_depth, emitted, ground)[layers.levels]
        return radiance

    def _source(self, weighted: Floats, moments: Reals, emission: Floats | None) -> Reals:
        light = moments * weighted.astype(moments.dtype)[:, :, None]
        source = (self.outgoing.astype(moments.dtype) @ light.reshape(*light.shape[:2], -1)).reshape(
            len(light), -1, *light.shape[2:]
        )
        if emission is not None:
            source += ((1 - weighted[:, 0]) * emission)[:, None, None]
        return source

    def _bend(self, below: Reals, above: Reals) -> Floats:
        """Half the second derivative in optical depth in each part, from the source at three places: the ends of two
        parts of a layer.
        """
        layers = self.layers
        number = np.arange(layers.layer.size) - layers.levels[layers.layer]
        first = np.flatnonzero((layers.parts[layers.layer] > 1) & (number % 2 == 0))
        depth = np.maximum(layers.part_depth, np.finfo(float).tiny)[:, None, None]
        slope = (above - below) / depth
        bend = np.zeros_like(below)
        bend[first] = (slope[first + 1] - slope[first]) / (depth[first + 1] + depth[first])
        bend[first + 1] = bend[first]
        return bend


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
