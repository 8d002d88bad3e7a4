"""Light of Sun or Moon scattered more than once, by discrete ordinates.

Under a low source the field of plane layers is made spherical by `spherical_orders`.

`single_scattering` adds light scattered once, with the true phase function and the scaled extinction from the source to
the observer. Here all extinction applies between the last scattering and the observer, and diffuse light scattered
straight forward into the line of sight is added; light scattered once has no such part, which matters only to paths
that end inside a cloud.

References
----------
Nakajima and Tanaka 1988, J. Quant. Spectrosc. Radiat. Transfer 40, 51 (exact first scattering with scaled extinction).
Dahlback and Stamnes 1991, Planet. Space Sci. 39, 671 (beam through spherical layers over a plane diffuse field).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES, ScaledLayers, layer_parts, solved_moments
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS, direction_weights
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.line_weights import LineWeights, source_weights_along, straight_weights
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import AZIMUTHAL, Ordinates, ordinates
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS, source_nodes
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.atmosphere.transfer.spherical_orders import LowSun
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers, Singles

# Points solved together: bounds memory to about 200 MB a thread. Of a field of few directions and elevations more are
# solved together, up to `_MOST_POINTS`: their arrays are then of the same size.
_CHUNK, _MOST_POINTS = 32, 256


@dataclass(frozen=True, eq=False)
class OrdinateLight:
    """Source function of light scattered more than once, per unit of the source's irradiance outside the atmosphere
    [sr^-1].

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    sine : (U,) array
        Of the source's geometric elevation at the place of scattering, increasing.
    extinction, scaled : (N, P) arrays
        All, and delta-scaled, m^2 per molecule.
    ordinates : Ordinates
    parts : LayerParts
    source : (Q, U, B, P) array
        Of the scaled layers, by `Ordinates.functions` of the direction in which light leaves; those of azimuthal moment
        m times the cosine of m times the azimuth between that direction and the beam; single precision.
    straight : (N, U, X, M, P) array or None
        Radiance at the levels by direction, which particles scatter straight forward; coefficients of those cosines.
        None where no light is scattered so; single precision.
    angles : (X,) array
        Of its directions from the vertical, rad, increasing.
    falling : (N, U, P) array
        Diffuse flux on the levels, without the light scattered straight forward out of the beam.
    """

    levels: Floats
    sine: Floats
    extinction: Floats
    scaled: Floats
    ordinates: Ordinates
    parts: LayerParts
    source: Singles
    straight: Singles | None
    angles: Floats
    falling: Floats

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        shells: Shells,
        optics: SpectralOptics,
        fraction: Floats,
        source_paths: SourcePaths,
        elevations: Sequence[float] = ELEVATIONS,
        azimuthal: int = AZIMUTHAL,
        nodes: int = NODES,
        angles: Sequence[float] = DIRECTIONS,
        *,
        spherical: bool = True,
    ) -> OrdinateLight:
        """Solve the field of a state.

        Parameters
        ----------
        state : AtmosphericState
        shells : Shells
        optics : SpectralOptics
        fraction : (N, P) array
            `diffuse_field.delta_fraction` of the optics.
        source_paths : source_paths.SourcePaths
            Through the extinction without that fraction.
        elevations : sequence of float
            Of the source, at which the field is solved, degree, increasing.
        azimuthal : int
            Azimuthal moments of the field.
        nodes : int
            Of each hemisphere, for which the fraction is.
        spherical : bool
            The field under a low source is that of `LowSun`.
        angles : sequence of float
            From the vertical, of the directions in which light is scattered straight forward, rad, increasing; none is
            the horizon's.
        """
        sine = np.sin(np.radians(elevations))
        levels, points = state.altitude.size, optics.wavenumber.size
        directions, cosine = ordinates(nodes, azimuthal), np.cos(angles)
        parts = layer_parts(shells, optics, fraction, molecules=True)
        forward = optics.aerosol_scattering * fraction
        source = np.empty((parts.places, sine.size, directions.pairs[0].size, points), np.float32)
        straight = None
        if np.any(forward):
            straight = np.empty((levels, sine.size, cosine.size, azimuthal, points), np.float32)
        falling = np.empty((levels, sine.size, points))
        albedo = state.albedo_at(optics.wavenumber)

        numbers = AZIMUTHAL * NODES * len(ELEVATIONS) // (azimuthal * nodes * sine.size)
        together = min(max(_CHUNK * numbers, _CHUNK), _MOST_POINTS)

        def solve(start: int) -> None:
            part = slice(start, start + together)
            layers, rising, down = _field(
                state,
                shells,
                optics,
                moments,
                fraction,
                source_paths,
                sine,
                part,
                azimuthal,
                albedo,
                low_sun,
                parts,
            )
            falling[..., part] = directions.flux(down[parts.levels])
            source[..., part] = layers.source(rising, down)
            if straight is not None:
                straight[..., part] = np.swapaxes(layers.radiance(cosine, rising, down), 1, 2)

        moments = solved_moments(optics, nodes)
        low_sun = LowSun.of(shells, nodes, sine) if spherical else None
        parallel_map(solve, range(0, points, together))
        scaled = optics.extinction - forward
        angle = np.array(angles)
        return cls(state.altitude, sine, optics.extinction, scaled, directions, parts, source, straight, angle, falling)

    def part(self, points: slice | Integers) -> OrdinateLight:
        """The same at some of the points."""
        parts: dict[str, Any] = {}
        for name in ("extinction", "scaled", "source", "straight", "falling"):
            whole = getattr(self, name)
            parts[name] = None if whole is None else np.ascontiguousarray(whole[..., points])
        return replace(self, **parts)

    @property
    def single(self) -> OrdinateLight:
        """The same with the extinction in single precision."""
        return replace(self, extinction=self.extinction.astype(np.float32), scaled=self.scaled.astype(np.float32))

    def spectral(
        self, segments: Segments, depths: Depths, scaled: Depths, cosine: Floats, deflection: Floats
    ) -> Singles:
        """Radiance along L joined rays at each point.

        Parameters
        ----------
        segments : Segments
        depths, scaled : Depths
            Of all extinction, and delta-scaled.
        cosine, deflection : (K+1, S) arrays
            Of the source's zenith angle and of the scattering angle at the segment ends.

        Returns
        -------
        (L, S, P) array
            sr^-1.
        """
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        weight = share[..., None] * azimuth[:, :, None]  # (K, S, V, M)
        points = depths.per_segment.shape[1]
        light = np.zeros((len(share), nodes.size, azimuth.shape[2], points), np.float32)  # (K, V, M, P)
        for table, azimuthal, weights in self._tables(segments, depths, scaled, nodes):
            for place, some in weights.by_place():
                moments = _moments_from_place(table(place), azimuth.shape[2], azimuthal, weights.factor[some])
                moments *= weights.weight[some][:, None]
                segment, by_segment = weights.segment[some], np.swapaxes(moments, 0, 1)
                if self.parts.is_cut:  # a segment may meet a place twice
                    np.add.at(light, segment, by_segment)
                else:
                    light[segment] += by_segment
        of_segments = light.reshape(len(share), -1, points)
        radiance = depths.by_line(np.matmul(weight.reshape(*weight.shape[:2], -1), of_segments))
        return np.maximum(radiance, 0.0, out=radiance)

    def band(
        self, segments: Segments, depths: Depths, scaled: Depths, cosine: Floats, deflection: Floats, weight: Floats
    ) -> Floats:
        """Radiance of a band from each segment at the observer, (K, S), in the unit of the
        weights (P,) of the points times the source's irradiance there; other arguments as of `spectral`.
        """
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
        unit = (weight / scale).astype(np.float32)
        light = np.zeros((len(share), share.shape[2], azimuth.shape[2]), np.float32)  # (K, V, M)
        for table, azimuthal, weights in self._tables(segments, depths, scaled, nodes):
            of_points = (weights.weight * unit).astype(np.float32, copy=False)
            by_function = np.empty((weights.place.size, nodes.size * azimuthal.size), np.float32)
            for place, some in weights.by_place():
                np.matmul(of_points[some], table(place).reshape(-1, unit.size).T, out=by_function[some])
            moment = (azimuthal[:, None] == np.arange(light.shape[2])).astype(np.float32)  # (B, M)
            by_elevation = by_function.reshape(-1, nodes.size, azimuthal.size)
            by_elevation *= _by_function(weights.factor, azimuthal)[:, None]
            light += weights.summed(by_elevation @ moment, len(light))
        by_azimuth = np.matmul(share, light)  # (K, S, M)
        by_azimuth *= azimuth
        radiance: Floats = np.maximum(by_azimuth.sum(axis=-1), 0.0).astype(float) * scale
        return radiance

    def by_segment(
        self, segments: Segments, depths: Depths, scaled: Depths, cosine: Floats, deflection: Floats
    ) -> Singles:
        """Radiance of each segment of a ray at the observer, (K, P) sr^-1, for one source; arguments as `spectral`."""
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        weight = (share[:, 0, :, None] * azimuth[:, 0, None])[:, None]  # (K, 1, V, M)
        radiance = np.zeros(depths.per_segment.shape, np.float32)
        for table, azimuthal, weights in self._tables(segments, depths, scaled, nodes):
            for place, some in weights.by_place():
                segment = weights.segment[some]
                light = _from_place(table(place), weight[segment], azimuthal, weights.factor[some])[:, 0]
                light *= weights.weight[some]
                for number, part in zip(segment, light, strict=True):
                    radiance[number] += part
        return np.maximum(radiance, 0.0, out=radiance)

    def at(self, layer: int, share: float, upward_cosine: float, cosine: Floats, deflection: Floats) -> Floats:
        """Source function at one place, (S, P).

        Parameters
        ----------
        layer : int
        share : float
            Weight of its upper level.
        upward_cosine : float
            Of the angle from the vertical at which the light leaves.
        cosine, deflection : (S,) arrays
            Of the source's zenith angle, of the scattering angle.
        """
        direction = np.array([upward_cosine])
        nodes, weight = source_nodes(self.sine, np.stack([cosine, cosine]))
        count = self.ordinates.azimuthal
        azimuth = _azimuth_cosines(direction, cosine[None], deflection[None], count)[0]  # (S, M)
        by_node = (weight[0][..., None] * azimuth[:, None])[None]  # (1, S, V, M)
        functions = self.ordinates.functions(direction)
        source = sum(
            part * _from_place(self.source[place, nodes], by_node, self.ordinates.pairs[0], functions)[0]
            for place, part in zip(*self.parts.at(layer, share), strict=True)
        )
        ends = np.array([1 - share, share])
        whole, scaled = (ends @ part[layer : layer + 2] for part in (self.extinction, self.scaled))
        source = source * scaled
        if self.straight is not None:
            first, of_direction = direction_weights(direction, self.angles)
            near = self.straight[layer : layer + 2, nodes, first[0] : first[0] + of_direction.shape[1]]
            radiance = np.einsum("ed,evdmp->vmp", ends[:, None] * of_direction, near)
            source += (by_node[0].reshape(len(cosine), -1) @ radiance.reshape(-1, len(whole))) * (whole - scaled)
        result: Floats = np.maximum(source / np.where(whole > 0, whole, 1.0), 0.0)
        return result

    def sky(self, altitude: Floats, source_elevation: Floats) -> Floats:
        """`falling` at altitudes (Z,) [m] and source elevations (S,) [rad]: (Z, S, P)."""
        place = np.clip(np.searchsorted(self.levels, altitude, side="right") - 1, 0, self.levels.size - 2)
        share = np.clip((altitude - self.levels[place]) / np.diff(self.levels)[place], 0.0, 1.0)[:, None, None]
        flux = self.falling[place] * (1 - share) + self.falling[place + 1] * share
        nodes, weight = source_nodes(self.sine, np.broadcast_to(np.sin(source_elevation), (2, source_elevation.size)))
        sky: Floats = np.maximum(weight[0].astype(float) @ flux[:, nodes], 0.0)
        return sky

    def _along(self, segments: Segments, cosine: Floats, deflection: Floats) -> tuple[Integers, Singles, Singles]:
        """Elevations (V,) of the source that are needed, their weights (K, S, V), and cosines (K, S, M) of multiples of
        azimuth.
        """
        nodes, share = source_nodes(self.sine, cosine)
        to_source, angle = (0.5 * (part[1:] + part[:-1]) for part in (cosine, deflection))
        return nodes, share, _azimuth_cosines(segments.upward_cosine, to_source, angle, self.ordinates.azimuthal)

    def _tables(
        self, segments: Segments, depths: Depths, scaled: Depths, nodes: Integers
    ) -> list[tuple[Callable[[int], Singles], Integers, LineWeights]]:
        """Tables of light under some elevations of the source, (V, B, P) by place, with the azimuthal moments (B,) of
        their functions, and their weights along a ray.
        """
        used = slice(nodes[0], nodes[-1] + 1) if nodes.size else slice(0)
        functions = self.ordinates.functions(segments.upward_cosine)
        weights = source_weights_along(segments, depths, scaled, self.levels, self.scaled, self.parts, functions)

        def source(place: int) -> Singles:
            return self.source[place, used]

        if self.straight is None:
            return [(source, self.ordinates.pairs[0], weights)]
        table, count = self.straight, self.angles.size
        straight = straight_weights(segments, depths, scaled, self.levels, self.angles)
        width = straight.factor.shape[1]

        def radiance(place: int) -> Singles:
            level, first = divmod(place, count)
            some = table[level, used, first : first + width]  # (V, directions, M, P)
            return some.reshape(len(some), -1, some.shape[-1])

        moments = np.tile(np.arange(table.shape[3]), width)
        return [(source, self.ordinates.pairs[0], weights), (radiance, moments, straight)]


def _by_function(factor: Floats, azimuthal: Integers) -> Singles:
    """Factors (E, B) of functions, from those (E, B) or the same for several azimuthal moments, (E, fewer)."""
    repeated: Singles = np.repeat(factor, azimuthal.size // factor.shape[1], axis=1).astype(np.float32)
    return repeated


def _from_place(table: Singles, weight: Singles, azimuthal: Integers, factor: Floats) -> Singles:
    """Light (c, S, P) of a table (V, B, P), for weights (c, S, V, M) by elevation of the source and azimuthal moment,
    and factors (c, B) by direction.
    """
    rows = weight[..., azimuthal] * _by_function(factor, azimuthal)[:, None, None]
    light = rows.reshape(-1, table.shape[0] * table.shape[1]) @ table.reshape(-1, table.shape[2])
    result: Singles = light.reshape(*weight.shape[:2], -1).astype(np.float32, copy=False)
    return result


def _moments_from_place(table: Singles, count: int, azimuthal: Integers, factor: Floats) -> Singles:
    """Azimuthal moments (V, c, M, P), so many, of light of a table (V, B, P), for factors (c, B) by direction."""
    if factor.shape[1] < azimuthal.size:  # directions, with all moments of each
        every: Singles = np.matmul(factor.astype(np.float32), table.reshape(len(table), factor.shape[1], -1))
        return every.reshape(len(table), len(factor), count, -1)
    belongs = np.arange(count)[:, None] == azimuthal
    rows = _by_function(factor, azimuthal)[:, None] * belongs  # (c, M, B)
    moments: Singles = np.matmul(rows.reshape(-1, azimuthal.size), table)
    return moments.reshape(len(table), len(factor), count, -1)


def falling_fluxes(
    state: AtmosphericState,
    shells: Shells,
    optics: SpectralOptics,
    fraction: Floats,
    source_paths: SourcePaths,
    sine: Floats,
    albedo: npt.ArrayLike,
    nodes: int = NODES,
) -> Floats:
    """Falling diffuse flux (N, U, P) on the levels, under a source of unit irradiance at elevations of sines (U,).

    Other arguments as of `OrdinateLight.of`; `albedo` of the ground, one number or (P,). Light scattered straight
    forward counts as beam.
    """
    falling = np.empty((state.altitude.size, sine.size, optics.wavenumber.size))
    moments = solved_moments(optics, nodes)
    low_sun = LowSun.of(shells, nodes, sine)
    parts = layer_parts(shells, optics, fraction, molecules=True)

    def solve(start: int) -> None:
        part = slice(start, start + _CHUNK)
        layers, _, down = _field(
            state, shells, optics, moments, fraction, source_paths, sine, part, 1, albedo, low_sun, parts
        )
        falling[..., part] = layers.ordinates.flux(down[parts.levels])

    parallel_map(solve, range(0, optics.wavenumber.size, _CHUNK))
    return falling


def _field(
    state: AtmosphericState,
    shells: Shells,
    optics: SpectralOptics,
    moments: Floats,
    fraction: Floats,
    source_paths: SourcePaths,
    sine: Floats,
    part: slice,
    azimuthal: int,
    albedo: npt.ArrayLike,
    low_sun: LowSun | None,
    parts: LayerParts,
) -> tuple[ScaledLayers, Floats, Floats]:
    """The layers of a state at a part of the points, and radiances rising and falling at the ends of their parts."""
    layers = ScaledLayers.of(
        shells, optics.at(part), moments, fraction[:, part], molecules=True, azimuthal=azimuthal, parts=parts
    )
    paths = replace(source_paths, log_depth=source_paths.log_depth[..., part])
    shape = state.altitude.size, sine.size
    beam = paths.optical_depth(state.altitude, np.broadcast_to(sine, shape)).astype(float)
    ground = np.broadcast_to(np.asarray(albedo, dtype=float), (optics.wavenumber.size,))[part]
    plane = layers.sunlight(beam, sine, ground)
    if low_sun is None:
        return layers, *plane
    scaled = optics.extinction[:, part] - optics.aerosol_scattering[:, part] * fraction[:, part]
    at_levels = plane[0][parts.levels], plane[1][parts.levels]
    rising, falling = low_sun.corrected(at_levels, layers, scaled, paths, sine, ground)
    if not parts.is_cut:
        return layers, rising, falling
    up, down = (parts.between(new - old) for new, old in zip((rising, falling), at_levels, strict=True))
    return layers, plane[0] + up, plane[1] + down


def _azimuth_cosines(upward_cosine: Floats, to_source: Floats, deflection: Floats, count: int) -> Singles:
    """Cosines (K, S, M) of multiples of the azimuth between scattered light and the beam, from cosines: of the light's
    angle from the vertical (K,), of the source's zenith angle (K, S) and of the scattering angle (K, S).
    """
    rise = upward_cosine[:, None]
    across = np.sqrt(np.maximum((1 - rise**2) * (1 - to_source**2), 1e-12))
    cosine = np.clip((deflection + rise * to_source) / across, -1.0, 1.0).astype(np.float32)
    cosines = np.empty((*cosine.shape, count), np.float32)
    cosines[..., 0] = 1
    if count > 1:
        cosines[..., 1] = cosine
    for multiple in range(2, count):  # Chebyshev's recurrence
        cosines[..., multiple] = 2 * cosine * cosines[..., multiple - 1] - cosines[..., multiple - 2]
    return cosines
