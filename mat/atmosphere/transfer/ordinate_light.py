"""Light of Sun or Moon scattered more than once, from four streams a hemisphere: for the few points of a compiled band.

As `multiple`, with discrete ordinates and azimuthal moments in place of two streams. The phase functions are cut after
as many moments as there are streams; the share of particles' scattering that goes straight on is the next moment
(delta-M). `transfer` adds the last scattering of light that came straight from the source, with the true phase function
and the scaled extinction on both legs. Here all extinction counts between scattering and observer, and what particles
throw straight on into the line of sight is part of the source; of light scattered once it is left out, which matters
only to paths that end inside a cloud.

References
----------
Wiscombe 1977, J. Atmos. Sci. 34, 1408 (delta-M).
Nakajima and Tanaka 1988, J. Quant. Spectrosc. Radiat. Transfer 40, 51 (exact first scattering with scaled extinction).
Dahlback and Stamnes 1991, Planet. Space Sci. 39, 671 (beam through spherical layers over a plane diffuse field).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.transfer import ordinates
from skyshine.mat.atmosphere.transfer.optics import phase_moments
from skyshine.mat.atmosphere.transfer.two_stream_layers import vertical_column, vertical_parts
from skyshine.mat.atmosphere.transfer.two_stream_light import ELEVATIONS, layer_shares, source_nodes
from skyshine.mat.threads import parallel_map

# Angles from the vertical at which the source function stands; between them it is linear in the angle.
_DIRECTIONS = np.linspace(0.0, np.pi, 16)
# Points solved together: bounds memory to about 200 MB a thread.
_CHUNK = 32


@dataclass(frozen=True, eq=False)
class StreamLight:
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
    source : (N, X, U * M, P) array
        By the direction in which light leaves; coefficients of the cosines of 0 to M - 1 times the azimuth between that
        direction and the beam; single precision.
    falling : (N, U, P) array
        Diffuse flux on the levels, without the light thrown straight ahead.
    """

    levels: np.ndarray
    sine: np.ndarray
    extinction: np.ndarray
    source: np.ndarray
    falling: np.ndarray

    @classmethod
    def of(cls, state, shells, optics, straight, source_paths):
        """Solve the field of a state.

        Parameters
        ----------
        state : AtmosphericState
        shells : Shells
        optics : SpectralOptics
        straight : (N, P) array
            `straight_share` of the optics.
        source_paths : source_paths.SourcePaths
            Through the extinction without that share.
        """
        sine, cosine = np.sin(np.radians(ELEVATIONS)), np.cos(_DIRECTIONS)
        levels, points = state.altitude.size, optics.wavenumber.size
        source = np.empty((levels, _DIRECTIONS.size, sine.size * ordinates.AZIMUTHAL, points), np.float32)
        falling = np.empty((levels, sine.size, points))
        shape = phase_moments(optics.phase, ordinates.MOMENTS)

        def solve(start):
            part = slice(start, start + _CHUNK)
            some, ahead = optics.at(part), straight[:, part]
            scattering = _scattering(some, shape, ahead)
            paths = replace(source_paths, log_depth=source_paths.log_depth[..., part])
            beam = paths.optical_depth(state.altitude, np.broadcast_to(sine, (levels, sine.size))).astype(float)
            scaled = some.extinction - some.aerosol_scattering * ahead
            lower, upper = vertical_parts(shells, scaled)
            columns = vertical_column(shells, scattering.reshape(levels, -1)).reshape(levels - 1, *scattering.shape[1:])
            rising, down = ordinates.radiances(
                lower + upper, columns, np.swapaxes(beam, 1, 2), sine, state.surface_albedo
            )
            light = ordinates.scattered_into(scattering, rising, down, cosine)
            light /= _divisor(scaled)
            radiance = ordinates.along_directions(lower, upper, light, rising[0, :, 0, 0], cosine)
            light *= scaled[..., None, None, None]
            light += (some.aerosol_scattering * ahead)[..., None, None, None] * radiance
            light /= _divisor(some.extinction)
            source[..., part] = light.transpose(0, 3, 4, 2, 1).reshape(levels, _DIRECTIONS.size, -1, light.shape[1])
            falling[..., part] = np.swapaxes(ordinates.flux(down), 1, 2)

        parallel_map(solve, range(0, points, _CHUNK))
        return cls(state.altitude, sine, optics.extinction, source, falling)

    def spectral(self, segments, depths, cosine, deflection):
        """Radiance along a ray at each point.

        Parameters
        ----------
        segments : transfer.Segments
        depths : transfer.Depths
        cosine, deflection : (K+1, S) arrays
            Of the source's zenith angle and of the scattering angle at the segment ends.

        Returns
        -------
        (S, P) array
            sr^-1.
        """
        rows, share, turn = self._along(segments, cosine, deflection)
        light = np.stack(
            [
                np.einsum("lp,lxup->up", parts, self.source[row] * lean)
                for row, lean, parts in self._corners(rows, segments, depths)
            ]
        )  # (K, V * M, P)
        weight = (share[..., None] * turn[:, :, None]).reshape(*share.shape[:2], -1)  # (K, S, V * M)
        radiance = weight.transpose(1, 0, 2).reshape(share.shape[1], -1) @ light.reshape(-1, light.shape[2])
        return np.maximum(radiance, 0.0)

    def band(self, segments, depths, cosine, deflection, weight):
        """Radiance of a band from all segments up to each end, (K+1, S); `weight` (P,) as in
        `transfer.scattered_band`.
        """
        rows, share, turn = self._along(segments, cosine, deflection)
        scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
        unit = (weight / scale).astype(np.float32)
        light = np.stack(
            [
                np.sum(
                    np.matmul(self.source[row], (parts * unit)[:, None, :, None])[..., 0] * lean[..., 0], axis=(0, 1)
                )
                for row, lean, parts in self._corners(rows, segments, depths)
            ]
        )  # (K, V * M)
        by_turn = np.matmul(share, light.reshape(len(light), share.shape[2], -1))  # (K, S, M)
        radiance = np.zeros(cosine.shape)
        np.cumsum(np.maximum(np.sum(by_turn * turn, axis=-1), 0.0) * scale, axis=0, out=radiance[1:], dtype=float)
        return radiance

    def at(self, layer, share, rise, cosine, deflection):
        """Source function at one place, (S, P).

        Parameters
        ----------
        layer : int
        share : float
            Weight of its upper level.
        rise : float
            Cosine of the angle from the vertical at which light leaves.
        cosine, deflection : (S,) arrays
            Of the source's zenith angle, of the scattering angle.
        """
        nodes, weight = source_nodes(self.sine, np.stack([cosine, cosine]))
        turn = _turns(np.array([rise]), cosine[None], deflection[None])[0]  # (S, M)
        first, lean = _place(np.array([rise]))
        table = self.source[layer : layer + 2, first[0] : first[0] + 2, self._columns(nodes)]
        corner = np.outer([1 - share, share], [1 - lean[0], lean[0]])
        light = np.einsum("lx,lxup->up", corner, table)
        weight = (weight[0][..., None] * turn[:, None]).reshape(len(cosine), -1)
        return np.maximum(weight @ light, 0.0)

    def sky(self, altitude, source_elevation):
        """`falling` at altitudes (Z,) [m] and source elevations (S,) [rad]: (Z, S, P)."""
        place = np.clip(np.searchsorted(self.levels, altitude, side="right") - 1, 0, self.levels.size - 2)
        share = np.clip((altitude - self.levels[place]) / np.diff(self.levels)[place], 0.0, 1.0)[:, None, None]
        flux = self.falling[place] * (1 - share) + self.falling[place + 1] * share
        nodes, weight = source_nodes(self.sine, np.broadcast_to(np.sin(source_elevation), (2, source_elevation.size)))
        return np.maximum(weight[0].astype(float) @ flux[:, nodes], 0.0)

    def _along(self, segments, cosine, deflection):
        """Columns of `source`, weights (K, S, V) of the source's elevations and cosines (K, S, M) of multiples of
        azimuth.
        """
        nodes, share = source_nodes(self.sine, cosine)
        middle = [0.5 * (part[1:] + part[:-1]) for part in (cosine, deflection)]
        return self._columns(nodes), share, _turns(segments.rise, *middle)

    def _corners(self, columns, segments, depths):
        """Of each segment: index of the two levels, two directions and the columns; weights of directions, of levels
        (2, P).
        """
        first, lean = _place(segments.rise)
        below, above = layer_shares(segments, self.levels, self.extinction, depths)
        for layer, direction, part, *weights in zip(
            segments.layer, first, lean.astype(np.float32), below, above, strict=True
        ):
            index = slice(layer, layer + 2), slice(direction, direction + 2), columns
            yield index, np.array([1 - part, part], dtype=np.float32)[:, None, None], np.stack(weights)

    @staticmethod
    def _columns(nodes):
        return slice(nodes[0] * ordinates.AZIMUTHAL, (nodes[-1] + 1) * ordinates.AZIMUTHAL)


def straight_share(optics):
    """Share (N, P) of the scattering by particles that goes straight on: the first moment of the phase function left
    out.
    """
    moment = phase_moments(optics.phase, ordinates.MOMENTS + 1)[-1]
    return np.clip(moment @ optics.phase_share, 0.0, None)


def _scattering(optics, shape, straight):
    """Scattering times moments of the phase function at the levels, (N, P, L) m^2 per molecule, without what goes
    straight on.
    """
    particles = np.moveaxis(shape @ optics.phase_share, 0, -1) - straight[..., None]
    result = optics.aerosol_scattering[..., None] * particles
    gamma = optics.rayleigh_anisotropy
    result[..., 0] += optics.rayleigh
    result[..., 2] += optics.rayleigh * 0.1 * (1 - gamma) / (1 + 2 * gamma)  # of `optics.rayleigh_phase`
    return result


def _divisor(extinction):
    return np.where(extinction > 0, extinction, 1.0)[..., None, None, None]


def _place(rise):
    """Lower neighbour (K,) of directions among `_DIRECTIONS`, and the weight of the next."""
    place = np.arccos(np.clip(rise, -1.0, 1.0)) / _DIRECTIONS[1]
    first = np.minimum(place.astype(int), _DIRECTIONS.size - 2)
    return first, place - first


def _turns(rise, to_source, deflection):
    """Cosines (K, S, M) of multiples of the azimuth between light that leaves and the beam."""
    rise = rise[:, None]
    across = np.sqrt(np.maximum((1 - rise**2) * (1 - to_source**2), 1e-12))
    turn = np.arccos(np.clip((deflection + rise * to_source) / across, -1.0, 1.0))
    return np.cos(turn[..., None] * np.arange(ordinates.AZIMUTHAL)).astype(np.float32)
