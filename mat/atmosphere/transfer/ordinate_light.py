"""Light of Sun or Moon scattered more than once, by discrete ordinates.

Under a low source the field of plane layers is made spherical by `spherical_orders`.

`single_scattering` adds light scattered once, with the true phase function and the scaled extinction from the source to
the observer. Here all extinction applies between the last scattering and the observer, and diffuse light scattered
straight forward into the line of sight is part of the source function; light scattered once has no such part, which
matters only to paths that end inside a cloud.

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
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES, ScaledLayers, solved_moments
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS, place
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import AZIMUTHAL
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS, layer_weights, source_nodes
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.atmosphere.transfer.spherical_orders import LowSun
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers, Singles

# Points solved together: bounds memory to about 200 MB a thread.
_CHUNK = 32
_GATHERED = 1 << 18  # numbers of the source function copied at once for the segments of a ray


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
    extinction : (N, P) array
        m^2 per molecule.
    source : (N, X, U, M, P) array
        By the direction in which light leaves; coefficients of the cosines of 0 to M - 1 times the azimuth between that
        direction and the beam; single precision.
    falling : (N, U, P) array
        Diffuse flux on the levels, without the light scattered straight forward out of the beam.
    angles : (X,) array
        Of those directions from the vertical, rad, increasing.
    shift : (N-1, X, U, M, P) array or None
        As of `diffuse_field.ScaledLayers.source`, single precision.
    """

    levels: Floats
    sine: Floats
    extinction: Floats
    source: Singles
    falling: Floats
    angles: Floats
    shift: Singles | None = None

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
            From the vertical, of the directions of the source function, rad, increasing; none is the horizon's.
        """
        sine = np.sin(np.radians(elevations))
        levels, points = state.altitude.size, optics.wavenumber.size
        source = np.empty((levels, len(angles), sine.size, azimuthal, points), np.float32)
        parts = range(0, points, _CHUNK)
        shifts: dict[int, Singles] = {}
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
            )
            falling[..., part] = layers.ordinates.flux(down[layers.levels])
            light, shift = layers.source(np.cos(angles), rising, down)
            source[..., part] = light.transpose(0, 2, 3, 1, 4)
            if shift is not None:
                shifts[start] = shift.transpose(0, 2, 3, 1, 4).astype(np.float32)

        moments = solved_moments(optics, nodes)
        low_sun = LowSun.of(shells, nodes, sine) if spherical else None
        parallel_map(solve, parts)
        shift = None
        if shifts:
            shift = np.zeros((levels - 1, *source.shape[1:]), np.float32)
            for start, values in shifts.items():
                shift[..., start : start + _CHUNK] = values
        return cls(state.altitude, sine, optics.extinction, source, falling, np.array(angles), shift)

    def spectral(self, segments: Segments, depths: Depths, cosine: Floats, deflection: Floats) -> Singles:
        """Radiance along a ray at each point.

        Parameters
        ----------
        segments : Segments
        depths : Depths
        cosine, deflection : (K+1, S) arrays
            Of the source's zenith angle and of the scattering angle at the segment ends.

        Returns
        -------
        (S, P) array
            sr^-1.
        """
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        light = np.concatenate(
            [
                np.einsum("klp,klvmp->kvmp", by_level, np.sum(table * by_direction[..., None], axis=2))
                for table, by_direction, by_level in self._tables(nodes, segments, depths)
            ]
        )  # (K, V, M, P)
        weight = share[..., None] * azimuth[:, :, None]  # (K, S, V, M)
        radiance = np.swapaxes(weight, 0, 1).reshape(share.shape[1], -1) @ light.reshape(-1, light.shape[-1])
        positive: Singles = np.maximum(radiance, 0.0)
        return positive

    def band(self, segments: Segments, depths: Depths, cosine: Floats, deflection: Floats, weight: Floats) -> Floats:
        """Radiance of a band from all segments up to each end, (K+1, S); `weight` (P,) as in
        `single_scattering.scattered_band`.
        """
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
        unit = (weight / scale).astype(np.float32)
        light = np.concatenate(
            [
                np.sum(
                    np.matmul(table, (by_level * unit)[:, :, None, None, :, None])[..., 0] * by_direction, axis=(1, 2)
                )
                for table, by_direction, by_level in self._tables(nodes, segments, depths)
            ]
        )  # (K, V, M)
        by_azimuth = np.matmul(share, light)  # (K, S, M)
        radiance = np.zeros(cosine.shape)
        np.cumsum(np.maximum(np.sum(by_azimuth * azimuth, axis=-1), 0.0) * scale, axis=0, out=radiance[1:], dtype=float)
        return radiance

    def by_segment(self, segments: Segments, depths: Depths, cosine: Floats, deflection: Floats) -> Singles:
        """Radiance of each segment of a ray at the observer, (K, P) sr^-1, for one source; arguments as `spectral`."""
        nodes, share, azimuth = self._along(segments, cosine, deflection)
        weight = (share[:, 0, :, None] * azimuth[:, 0, None])[:, None]  # (K, 1, V, M)
        radiance = np.empty(depths.per_segment.shape, np.float32)
        start = 0
        for table, by_direction, by_level in self._tables(nodes, segments, depths):
            part = slice(start, start + len(table))
            start = part.stop
            both = (by_direction[:, 0] * weight[part]).reshape(len(table), 1, 1, -1)
            light = np.matmul(both, table.reshape(*table.shape[:2], -1, table.shape[-1]))[:, :, 0]
            radiance[part] = np.sum(np.maximum(light, 0.0) * by_level, axis=1)
        return radiance

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
        azimuth = _azimuth_cosines(direction, cosine[None], deflection[None], self.source.shape[3])[0]  # (S, M)
        first, next_share = place(direction, self.angles)
        table = self.source[layer : layer + 2, first[0] : first[0] + 2, nodes]
        if self.shift is not None:
            table = table + self.shift[layer][first[0] : first[0] + 2, nodes]
        corner = np.outer([1 - share, share], [1 - next_share[0], next_share[0]])
        light = np.tensordot(corner, table, 2)  # (V, M, P)
        by_node = (weight[0][..., None] * azimuth[:, None]).reshape(len(cosine), -1)
        source: Floats = np.maximum(by_node @ light.reshape(-1, light.shape[-1]), 0.0)
        return source

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
        return nodes, share, _azimuth_cosines(segments.upward_cosine, to_source, angle, self.source.shape[3])

    def _tables(
        self, nodes: Integers, segments: Segments, depths: Depths
    ) -> Iterator[tuple[Singles, Singles, Singles]]:
        """Of some segments at a time: the source function (k, 2, 2, V, M, P) at their levels and directions, with
        weights of the directions (k, 1, 2, 1, 1) and of the levels (k, 2, P).
        """
        first, next_share = place(segments.upward_cosine, self.angles)
        by_level = np.stack(layer_weights(segments, self.levels, self.extinction, depths), axis=1)
        by_direction = np.stack([1 - next_share, next_share], axis=-1).astype(np.float32)[:, None, :, None, None]
        step = np.arange(2)[:, None]
        levels, directions = segments.layer[:, None, None, None] + step[:, None], first[:, None, None, None] + step
        at_once = max(1, _GATHERED // (4 * nodes.size * self.source[0, 0, 0].size))
        for start in range(0, first.size, at_once):
            part = slice(start, start + at_once)
            table = self.source[levels[part], directions[part], nodes]
            if self.shift is not None:
                table += self.shift[levels[part][:, :1], directions[part], nodes]
            yield table, by_direction[part], by_level[part]


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

    def solve(start: int) -> None:
        part = slice(start, start + _CHUNK)
        layers, _, down = _field(state, shells, optics, moments, fraction, source_paths, sine, part, 1, albedo, low_sun)
        falling[..., part] = layers.ordinates.flux(down[layers.levels])

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
) -> tuple[ScaledLayers, Floats, Floats]:
    """The layers of a state at a part of the points, and radiances rising and falling at the ends of their parts."""
    layers = ScaledLayers.of(shells, optics.at(part), moments, fraction[:, part], molecules=True, azimuthal=azimuthal)
    paths = replace(source_paths, log_depth=source_paths.log_depth[..., part])
    shape = state.altitude.size, sine.size
    beam = paths.optical_depth(state.altitude, np.broadcast_to(sine, shape)).astype(float)
    ground = np.broadcast_to(np.asarray(albedo, dtype=float), (optics.wavenumber.size,))[part]
    plane = layers.sunlight(beam, sine, ground)
    if low_sun is None:
        return layers, *plane
    scaled = optics.extinction[:, part] - optics.aerosol_scattering[:, part] * fraction[:, part]
    at_levels = plane[0][layers.levels], plane[1][layers.levels]
    rising, falling = low_sun.corrected(at_levels, layers, scaled, paths, sine, ground)
    if not layers.is_cut:
        return layers, rising, falling
    changes = (layers.between(new - old) for new, old in zip((rising, falling), at_levels, strict=True))
    return layers, *(part + change for part, change in zip(plane, changes, strict=True))


def _azimuth_cosines(upward_cosine: Floats, to_source: Floats, deflection: Floats, count: int) -> Singles:
    """Cosines (K, S, M) of multiples of the azimuth between scattered light and the beam, from cosines: of the light's
    angle from the vertical (K,), of the source's zenith angle (K, S) and of the scattering angle (K, S).
    """
    rise = upward_cosine[:, None]
    across = np.sqrt(np.maximum((1 - rise**2) * (1 - to_source**2), 1e-12))
    azimuth = np.arccos(np.clip((deflection + rise * to_source) / across, -1.0, 1.0))
    cosines: Singles = np.cos(azimuth[..., None] * np.arange(count)).astype(np.float32)
    return cosines
