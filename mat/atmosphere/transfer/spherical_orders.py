"""Light of a low Sun by orders of scattering in spherical shells.

Plane layers under the local beam are too dark in twilight: light reaches the air in the Earth's shadow along lines of
sight from lit air on the side of the Sun. Here the first orders are summed along such lines, at some levels, directions
and elevations of the source. What follows them is to the last of them as in plane layers, so that clouds of any depth
are solved, and under a high Sun plane layers remain what they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.diffuse_field import ScaledLayers
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates, ordinates
from skyshine.mat.atmosphere.transfer.scattering_orders import first_orders
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.atmosphere.transfer.spherical_paths import BEAM_ELEVATIONS, DIRECTIONS, MOMENTS, Line, SphericalPaths
from skyshine.schemas.arrays import Floats, Reals, Singles

# Elevations of the source at which the orders are computed, degree: those of the field up to where it is plane, and of
# the air towards the Sun.
ELEVATIONS = np.array([-10, -8, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3.5, 5.5, 10])
# Air behind a place, over which the source is lower by this, degree, adds next to nothing.
_BEHIND = 5.0
# Below the first elevation, degree, the field is spherical, above the second plane.
_BLEND = (3.5, 5.5)
ORDERS = 3
# Vertical optical depth below which the light is that of plane layers times a factor: it is what came down through the
# layers above.
_DEEP = 3.0
# Times that light between levels is as bright as at the brighter of them, at most. Where plane layers are all but dark
# at one level, the ratio there is as large as they are dark, and says nothing of the light between it and the next.
_BRIGHTER = 3.0
# Radiances below count as none.
_DARK = 1e-30


@dataclass(frozen=True, eq=False)
class LowSun:
    """Lines along which light of a low source reaches the levels of a state.

    Attributes
    ----------
    ordinates : Ordinates
        Directions of the lines, and azimuthal moments of what is scattered along them.
    """

    paths: SphericalPaths
    ordinates: Ordinates

    @classmethod
    def of(cls, shells: Shells, nodes: int, sine: Floats) -> LowSun | None:
        """The lines along so many nodes a hemisphere; None if no source at elevations of sines (U,) is low."""
        if not np.any(_spherical_share(sine) > 0):
            return None
        directions = ordinates(nodes, MOMENTS)
        lowest = np.degrees(np.arcsin(np.min(sine))) - _BEHIND
        start = max(int(np.searchsorted(ELEVATIONS, lowest, side="right")) - 1, 0)
        return cls(SphericalPaths.of(shells, directions, ELEVATIONS[start:]), directions)

    def corrected(
        self,
        plane: tuple[Floats, Floats],
        layers: ScaledLayers,
        extinction: Floats,
        source_paths: SourcePaths,
        sine: Floats,
        albedo: Floats,
    ) -> tuple[Floats, Floats]:
        """The radiances of plane layers, made spherical where the source is low.

        Parameters
        ----------
        plane : two (N, M, n, U, P) arrays
            Radiances rising and falling at the levels of plane layers, for M azimuthal moments.
        extinction : (N, P) array
            Delta-scaled, m^2 per molecule.
        source_paths : SourcePaths
            Paths through that extinction.
        sine : (U,) array
            Sine of the source's elevation.
        albedo : (P,) array
            Albedo of the ground.
        """
        share = _spherical_share(sine)
        low = np.flatnonzero(share > 0)
        node_sines, levels = self.paths.sine, source_paths.levels
        both, inverse = np.unique(np.append(node_sines, sine[low]), return_inverse=True)
        beam = source_paths.optical_depth(levels, np.broadcast_to(both, (levels.size, both.size))).astype(float)
        flat = ordinates(self.ordinates.node.size, 1)
        parts = first_orders(flat, layers.depth, layers.weighted, beam, both, albedo, ORDERS)
        orders = [np.concatenate(part, axis=2)[:, 0][:, :, inverse] for part in parts]  # (N, 2 n, U, P) each
        radiance = np.concatenate([part[..., low, :] for part in plane], axis=2)
        computed = [order[:, :, node_sines.size :] for order in orders]
        # Sum of both sides together: a side that is dark in the last order need not be so in those after it.
        remainder = np.maximum(np.sum(radiance[:, 0] - sum(computed), axis=1, keepdims=True), 0.0)
        highest_order = np.sum(computed[-1], axis=1, keepdims=True)
        growth = 1 + remainder / np.where(highest_order > _DARK, highest_order, np.inf)
        spherical = np.zeros(radiance.shape)
        in_shells = self.orders(layers, extinction, source_paths, albedo, len(orders))
        for number, (order, of_paths) in enumerate(zip(orders, in_shells, strict=True)):
            modes = self._modes(of_paths, radiance.shape[1])
            ratio, shape, limit = self._ratios(modes, order[:, :, : node_sines.size], levels, sine[low])
            light = np.minimum(order[:, :, node_sines.size :] * ratio, _BRIGHTER * limit)
            spherical += (light * (growth if number == len(orders) - 1 else 1.0))[:, None] * shape
        spherical = self._deep(spherical, radiance, layers.depth)
        radiance += (spherical - radiance) * share[low][:, None]
        nodes, results = self.ordinates.node.size, []
        for part, side in zip(plane, (slice(0, nodes), slice(nodes, None)), strict=True):
            result = part.copy()
            result[..., low, :] = radiance[:, :, side]
            results.append(result)
        return results[0], results[1]

    def _deep(self, spherical: Floats, plane: Floats, depth: Floats) -> Floats:
        """The spherical radiances (N, M, 2 n, V, P), but below `_DEEP` the plane ones in their ratio at that depth; for
        the optical depth (N-1, P) of the layers.
        """
        above = np.append(np.cumsum(depth[::-1], axis=0)[::-1], np.zeros((1, depth.shape[1])), axis=0)
        level = self.paths.level[np.argmax(above[self.paths.level] <= _DEEP, axis=0)]  # (P,)
        points = np.arange(level.size)
        weights = np.tile(self.ordinates.weight, 2)[:, None]
        light, flat = (np.sum(part[level, 0, ..., points] * weights, axis=1).T for part in (spherical, plane))
        factor = np.where(flat > _DARK, light / np.where(flat > _DARK, flat, 1.0), 1.0)  # (V, P)
        is_deep = np.arange(len(plane))[:, None] < level
        result: Floats = np.where(is_deep[:, None, None, None], plane * factor, spherical)
        return result

    def orders(
        self, layers: ScaledLayers, extinction: Floats, source_paths: SourcePaths, albedo: Floats, count: int
    ) -> list[Singles]:
        """So many orders of radiance (Z, 2 n, A, U, P) at the levels of the paths, going up, then going down; arguments
        as of `corrected`.
        """
        sine = self.paths.sine
        direct = np.exp(-source_paths.optical_depth(source_paths.levels[:1], sine[None])[0])
        ground_irradiance = np.maximum(sine, 0.0)[:, None] * direct  # irradiance of the ground, (U, P)
        once = _Once.of(source_paths, layers)
        orders = [self._travelled(extinction, albedo, ground_irradiance, once.along)]
        while len(orders) < count:
            again = _Again(self._source(layers, source_paths.levels, orders[-1]))
            orders.append(self._travelled(extinction, albedo, np.zeros_like(ground_irradiance), again.along))
        return orders

    def _travelled(
        self,
        extinction: Floats,
        albedo: Floats,
        ground_irradiance: Floats,
        along: Callable[[Line, Singles, Singles], Singles],
    ) -> Singles:
        """Radiance (Z, 2 n, A, U, P) of one order, and what the ground reflects of it and of its irradiance (U, P)."""
        nodes, points = self.ordinates.node.size, extinction.shape[1]
        cases = self.paths.azimuth.size, self.paths.sine.size
        light = np.zeros((len(self.paths.lines), 2 * nodes, cases[0] * cases[1], points), np.float32)
        ground = np.zeros(ground_irradiance.shape, np.float32)
        for going in (slice(nodes, None), slice(0, nodes)):  # down to the ground first
            for result, lines in zip(light[:, going], self.paths.lines, strict=True):
                for radiance, line in zip(result, lines[going], strict=True):
                    depths = Depths(line.segments.column(extinction))
                    if line.segments.index.size:
                        near, far = depths.source_weights
                        weight = depths.transmittance * (near + far)
                        share = line.segments.upper_part(extinction, depths.per_segment)
                        radiance[:] = along(line, weight.astype(np.float32), share.astype(np.float32))
                    if line.ground is not None:
                        radiance += (line.ground @ ground) * np.exp(-depths.cumulative[-1]).astype(np.float32)
            mean = light[0, nodes:].reshape(nodes, *cases, points).mean(axis=1)
            ground = ((ground_irradiance + self.ordinates.flux(mean[None, None])[0]) * (albedo / np.pi)).astype(
                np.float32
            )
        return light.reshape(*light.shape[:2], *cases, points)

    def _source(self, layers: ScaledLayers, levels: Floats, radiance: Singles) -> Singles:
        """Source function (N, X, M, U, P) of an order of radiance, by the direction in which light leaves."""
        modes = _at_levels(self._modes(radiance, MOMENTS), levels[self.paths.level], levels).astype(float)
        nodes = self.ordinates.node.size
        rising, falling = modes[:, :, :nodes], modes[:, :, nodes:]
        light = self.ordinates.scattered_into(layers.at_levels, rising, falling, np.cos(DIRECTIONS))
        return np.ascontiguousarray(np.swapaxes(light, 1, 2), dtype=np.float32)

    def _modes(self, radiance: Singles, count: int) -> Singles:
        """Coefficients (Z, M, 2 n, U, P) of the cosines of multiples of the azimuth, of radiance (Z, 2 n, A, U, P); 0
        where so many azimuths cannot tell them.
        """
        azimuth = self.paths.azimuth
        multiple = np.arange(count)
        series = np.cos(multiple[:, None] * azimuth) * np.where(multiple == 0, 1, 2)[:, None] / azimuth.size
        series[azimuth.size :] = 0.0
        modes: Singles = np.einsum("ma,zdaup->zmdup", series.astype(np.float32), radiance, optimize=True)
        return modes

    def _ratios(self, modes: Singles, plane: Reals, levels: Floats, sine: Floats) -> tuple[Singles, Singles, Singles]:
        """Of an order under sources at elevations of sines (V,): its radiance over that in plane layers (N, 2 n, V, P),
        its moments over the first of them (N, M, 2 n, V, P), and the largest radiance at the levels and elevations
        between which each lies (N, 2 n, V, P).

        Parameters
        ----------
        modes : (Z, M, 2 n, U, P) array
            Modes of the order at the levels and elevations of the paths.
        plane : (N, 2 n, U, P) array
            The order in plane layers, averaged over azimuth.
        """
        mean, flat = modes[:, 0], plane[self.paths.level]
        bright = (flat > _DARK) & (mean > _DARK)
        ratio = np.log(np.where(bright, mean, 1.0) / np.where(bright, flat, 1.0))
        shape = modes / np.where(mean > _DARK, mean, 1.0)[:, None]
        nodes = self.paths.sine
        position = np.interp(np.clip(sine, nodes[0], nodes[-1]), nodes, np.arange(nodes.size))
        lower = np.minimum(position.astype(int), nodes.size - 2)
        share = (position - lower).astype(np.float32)[:, None]
        results, altitude = [], levels[self.paths.level]
        for values in (ratio, shape):
            near, far = (values[..., lower + step, :] for step in (0, 1))
            results.append(_at_levels(near + (far - near) * share, altitude, levels))
        brightest = np.maximum(mean[..., lower, :], mean[..., lower + 1, :])
        level = np.minimum(np.searchsorted(altitude, levels, side="right") - 1, altitude.size - 2)
        return np.exp(results[0]), results[1], np.maximum(brightest[level], brightest[level + 1])


@dataclass(frozen=True, eq=False)
class _Once:
    """Light of the source scattered once along lines.

    Attributes
    ----------
    beam : (N, E, P) array
        Transmittance from the source to the levels, at `BEAM_ELEVATIONS`.
    scattering : (N, L, P) array
        Albedo times 2 l + 1 times the moments of the phase function, sr^-1.
    """

    beam: Singles
    scattering: Singles

    @classmethod
    def of(cls, source_paths: SourcePaths, layers: ScaledLayers) -> _Once:
        """The light in the layers of a state."""
        levels, sine = source_paths.levels, np.sin(np.radians(BEAM_ELEVATIONS))
        beam = source_paths.optical_depth(levels, np.broadcast_to(sine, (levels.size, sine.size)))
        np.exp(-beam, out=beam)
        return cls(beam, (layers.at_levels / (4 * np.pi)).astype(np.float32))

    def along(self, line: Line, weight: Singles, share: Singles) -> Singles:
        """Radiance (S, P) of a line's segments of weights (K, P), with the share (K, P) of each one's upper level."""
        layer, upper = line.segments.layer, share[:, None]
        beam, scattering = (
            part[layer] + (part[layer + 1] - part[layer]) * upper for part in (self.beam, self.scattering)
        )
        scattering *= weight[:, None]  # (K, L, P)
        degree = scattering.shape[1]
        polynomials = np.polynomial.legendre.legvander(line.deflection, degree - 1).astype(np.float32)
        phase = polynomials @ np.swapaxes(scattering, 0, 1).reshape(degree, -1)
        table = beam.reshape(-1, beam.shape[-1])
        beam_light = table[line.beam]
        beam_light += (table[line.beam + 1] - beam_light) * line.next_beam
        radiance: Singles = np.einsum("skp,skp->sp", phase.reshape(beam_light.shape), beam_light)
        return np.maximum(radiance, 0.0, out=radiance)


@dataclass(frozen=True, eq=False)
class _Again:
    """Light scattered again along lines; `source` (N, X, M, U, P) is its source function."""

    source: Singles

    def along(self, line: Line, weight: Singles, share: Singles) -> Singles:
        """As `_Once.along`."""
        layer, direction, upper = line.segments.layer, line.direction, share[:, None, None]
        ends = []
        for level in (layer, layer + 1):
            near, far = self.source[level, direction], self.source[level, direction + 1]
            far -= near
            far *= line.next_direction
            near += far
            ends.append(near)
        light, above = ends
        above -= light
        above *= upper
        light += above
        light *= weight[:, None, None]
        radiance: Singles = line.across @ light.reshape(-1, light.shape[-1])
        return np.maximum(radiance, 0.0, out=radiance)


def _spherical_share(sine: Floats) -> Floats:
    """Weight (U,) of the spherical field under sources at elevations of sines (U,)."""
    low, high = np.sin(np.radians(_BLEND))
    share: Floats = np.clip((high - sine) / (high - low), 0.0, 1.0)
    return share


def _at_levels(values: Singles, altitude: Floats, levels: Floats) -> Singles:
    """Values (Z, ...) at altitudes (Z,), linear between them, at the levels (N,)."""
    position = np.interp(levels, altitude, np.arange(altitude.size))
    lower = np.minimum(position.astype(int), altitude.size - 2)
    share = (position - lower).astype(np.float32).reshape(-1, *(1,) * (values.ndim - 1))
    between: Singles = values[lower] + (values[lower + 1] - values[lower]) * share
    return between
