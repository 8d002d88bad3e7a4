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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

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

# Points solved together: bounds memory to about 200 MB a thread.
_CHUNK = 32
_GATHERED = 1 << 21  # numbers of light at the places of a ray held at once


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

        def solve(start: int) -> None:
            part = slice(start, start + _CHUNK)
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
        parallel_map(solve, range(0, points, _CHUNK))
        scaled = optics.extinction - forward
        angle = np.array(angles)
        return cls(state.altitude, sine, optics.extinction, scaled, directions, parts, source, straight, angle, falling)

    @property
    def single(self) -> OrdinateLight:
        """The same with the extinction in single precision."""
        return replace(self, extinction=self.extinction.astype(np.float32), scaled=self.scaled.astype(np.float32))

    def spectral(
        self, segments: Segments, depths: Depths, scaled: Depths, cosine: Floats, deflection: Floats
    ) -> Singles:
        """Radiance along a ray at each point.

        Parameters
        ----------
        segments : Segments
        depths, scaled : Depths
            Of all extinction, and delta-scaled.
        cosine, deflection : (K+1, S) arrays
            Of the source's zenith angle and of the scattering angle at the segment ends.

        Returns
        -------
        (S, P) array
            sr^-1.
        """
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        by_segment = np.einsum("ksv,ksm->skvm", share, azimuth)
        radiance = np.zeros((share.shape[1], depths.per_segment.shape[1]), np.float32)
        for table in self._tables(segments, depths, scaled, nodes):
            for rows, points, light in table.moments(azimuth.shape[2]):
                weight = np.swapaxes(by_segment[:, table.weights.segment[rows]], 2, 3)  # (S, R, V, C, M)
                radiance[:, points] += weight.reshape(len(radiance), -1) @ light.reshape(-1, light.shape[-1])
        return np.maximum(radiance, 0.0, out=radiance)

    def band(
        self, segments: Segments, depths: Depths, scaled: Depths, cosine: Floats, deflection: Floats, weight: Floats
    ) -> Floats:
        """Radiance of a band from all segments up to each end, (K+1, S); `weight` (P,) as in
        `single_scattering.scattered_band`, other arguments as of `spectral`.
        """
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
        unit = (weight / scale).astype(np.float32)
        light = np.zeros((len(share), share.shape[2], azimuth.shape[2]), np.float32)  # (K, V, M)
        for table in self._tables(segments, depths, scaled, nodes):
            light += table.weights.summed(table.in_band(unit, light.shape[2]), len(light))
        by_azimuth = np.matmul(share, light)  # (K, S, M)
        radiance = np.zeros(cosine.shape)
        np.cumsum(np.maximum(np.sum(by_azimuth * azimuth, axis=-1), 0.0) * scale, axis=0, out=radiance[1:], dtype=float)
        return radiance

    def by_segment(
        self, segments: Segments, depths: Depths, scaled: Depths, cosine: Floats, deflection: Floats
    ) -> Singles:
        """Radiance of each segment of a ray at the observer, (K, P) sr^-1, for one source; arguments as `spectral`."""
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        radiance = np.zeros(depths.per_segment.shape, np.float32)
        for table in self._tables(segments, depths, scaled, nodes):
            radiance += table.weights.summed(table.radiance(share[:, 0], azimuth[:, 0]), len(radiance))
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
        by_node = weight[0][..., None] * azimuth[:, None]  # (S, V, M)
        places, part = self.parts.at(layer, share)
        light = np.tensordot(part, self.source[places][:, nodes], 1)  # (V, B, P)
        rows = by_node[..., self.ordinates.pairs[0]] * self.ordinates.functions(direction)[0]
        source = rows.reshape(len(cosine), -1) @ light.reshape(-1, light.shape[-1])
        ends = np.array([1 - share, share])
        whole, scaled = (ends @ part[layer : layer + 2] for part in (self.extinction, self.scaled))
        source = source * scaled
        if self.straight is not None:
            corner = ends[:, None] * direction_weights(direction, self.angles)
            radiance = np.einsum("nx,nvxmp->vmp", corner, self.straight[layer : layer + 2, nodes], optimize=True)
            source += (by_node.reshape(len(cosine), -1) @ radiance.reshape(-1, len(whole))) * (whole - scaled)
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

    def _tables(self, segments: Segments, depths: Depths, scaled: Depths, nodes: Integers) -> list[_Table]:
        """Tables of light under some elevations of the source, with their weights along a ray."""
        used = slice(nodes[0], nodes[-1] + 1) if nodes.size else slice(0)
        functions = self.ordinates.functions(segments.upward_cosine)
        weights = source_weights_along(segments, depths, scaled, self.levels, self.scaled, self.parts, functions)
        source = _Table(self.source[:, used], self.ordinates.pairs[0], weights)
        if self.straight is None:
            return [source]
        table = self.straight[:, used]
        levels, elevations, _, count, points = table.shape
        straight = straight_weights(segments, depths, scaled, self.levels, self.angles)
        width = straight.factor.shape[2]
        by_direction = table[:, :, straight.first : straight.first + width]
        straight = replace(straight, factor=np.repeat(straight.factor, count, axis=2))
        light = by_direction.reshape(levels, elevations, width * count, points)
        return [source, _Table(light, np.tile(np.arange(count), width), straight)]


@dataclass(frozen=True, eq=False)
class _Table:
    """Light at places along a ray, in functions of direction that each belong to an azimuthal moment.

    Attributes
    ----------
    light : (Q, V, B, P) array
        Under sources at V elevations.
    azimuthal : (B,) int array
        The moment of each function.
    weights : LineWeights
    """

    light: Singles
    azimuthal: Integers
    weights: LineWeights

    def moments(self, count: int) -> Iterator[tuple[slice, slice, Singles]]:
        """Light (R, V, C, M, P) of so many azimuthal moments at the observer, with its rows of the weights and its
        points: by parts that follow one another in the table, and few enough to hold.
        """
        of_moment = self._of_moment(count).T
        for rows, places in self.weights.runs():
            light = self.light[places]
            factor = self.weights.factor[rows].astype(np.float32)  # (R, C, B)
            of_places = (factor[:, :, None] * of_moment).reshape(len(factor), 1, -1, factor.shape[2])
            shape = (*light.shape[:2], factor.shape[1], count)
            at_once = max(1, _GATHERED // max(1, int(np.prod(shape))))
            for start in range(0, light.shape[3], at_once):
                points = slice(start, start + at_once)
                some = np.matmul(of_places, light[..., points])
                some = some.reshape(*shape, -1)
                some *= self.weights.weight[rows][:, None, :, None, points]
                yield rows, points, some

    def in_band(self, unit: Singles, count: int) -> Singles:
        """Light (R, C, V, M) of so many azimuthal moments at the observer, summed over the points by weights (P,)."""
        of_points = (self.weights.weight * unit).astype(np.float32, copy=False)[:, None]  # (R, 1, C, P)
        result = np.empty((*self.weights.segment.shape, self.light.shape[1], count), np.float32)
        of_moment = self._of_moment(count)
        for rows, places in self.weights.runs():
            light = np.matmul(of_points[rows], np.swapaxes(self.light[places], 2, 3))  # (R, V, C, B)
            light *= self.weights.factor[rows][:, None]
            result[rows] = np.swapaxes(light @ of_moment, 1, 2)
        return result

    def radiance(self, share: Singles, azimuth: Singles) -> Singles:
        """Light (R, C, P) at the observer, of one source, from weights of segments: (K, V) by its elevation and (K, M)
        by azimuthal moment.
        """
        segment = self.weights.segment
        factor = self.weights.factor * azimuth[segment][..., self.azimuthal]  # (R, C, B)
        of_places = share[segment][..., None] * factor[:, :, None].astype(np.float32)  # (R, C, V, B)
        result = np.zeros(self.weights.weight.shape, np.float32)
        for rows, places in self.weights.runs():
            for elevation in range(self.light.shape[1]):
                result[rows] += np.matmul(of_places[rows, :, elevation], self.light[places, elevation])
        result *= self.weights.weight
        return result

    def _of_moment(self, count: int) -> Singles:
        """1 where a function (B,) belongs to an azimuthal moment (M,), and else 0."""
        belongs: Singles = (self.azimuthal[:, None] == np.arange(count)).astype(np.float32)
        return belongs


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
    azimuth = np.arccos(np.clip((deflection + rise * to_source) / across, -1.0, 1.0))
    cosines: Singles = np.cos(azimuth[..., None] * np.arange(count)).astype(np.float32)
    return cosines
