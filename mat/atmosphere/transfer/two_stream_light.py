"""Light of Sun or Moon that air, particles and ground scatter more than once.

The diffuse field is that of the delta-scaled two-stream equations with the coefficients of the practical improved flux
method, under a beam attenuated along its true path through spherical layers, to twilight and beyond; how much of the
beam's scattering goes up follows the true phase function, and the ground reflects beam and diffuse light. What this
field scatters into a line of sight follows the first two moments of the phase function.

The last scattering before the observer of light that came straight from the source is not in it: `transfer` adds that
with the true phase function. So that nothing counts twice, the beam that is scattered there is the scaled one: the
light which particles have thrown straight ahead belongs to the beam, on the way to the last scattering, in both. From
there to the observer all extinction counts. Light thrown straight ahead then reaches a horizontal surface with exactly
the energy the beam lost to it.

Two streams know no azimuth and too little of light close to the horizon. They serve where points are many, as in
choosing those of a band; `streams` serves the chosen ones.

References
----------
Zdunkowski, Welch and Korb 1980, Beitr. Phys. Atmos. 53, 147 (coefficients).
Joseph, Wiscombe and Weinman 1976, J. Atmos. Sci. 33, 2452 (delta scaling).
Dahlback and Stamnes 1991, Planet. Space Sci. 39, 671 (beam through spherical layers over a plane diffuse field).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES
from skyshine.mat.atmosphere.transfer.segments import mean_attenuation
from skyshine.mat.atmosphere.transfer.thermal_source import lean
from skyshine.mat.atmosphere.transfer.two_stream_layers import Slabs, join, vertical_column

# Elevations of the source at which the field is solved, degree; between them it is linear in the sine.
ELEVATIONS = (-20, -14, -10, -7, -5, -3.5, -2, -1, 0, 1, 2, 3.5, 5.5, 8, 12, 17, 23, 30, 38, 47, 57, 70, 90)
# Pure scattering has no decay, which the closed form of a layer divides by. This little absorption takes 1e-4 of the
# light from a layer of optical depth 1e4.
_LARGEST_ALBEDO = 1 - 1e-12
# Points solved together: bounds memory to about 100 MB.
_CHUNK = 512


@dataclass(frozen=True, eq=False)
class DiffuseLight:
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
    mean, tilt : (N, U, P) arrays
        As those of `diffuse.ThermalSource`; single precision.
    """

    levels: np.ndarray
    sine: np.ndarray
    extinction: np.ndarray
    mean: np.ndarray
    tilt: np.ndarray

    @classmethod
    def of(cls, state, shells, optics, scaled, source_paths):
        """Solve the field of a state.

        Parameters
        ----------
        state : AtmosphericState
        shells : Shells
        optics : SpectralOptics
        scaled : (N, P) array
            Extinction, m^2 per molecule, without the share asymmetry^2 of scattering by particles, which goes straight
            on.
        source_paths : source_paths.SourcePaths
            Through that extinction.
        """
        sine = np.sin(np.radians(ELEVATIONS))
        shape = (state.altitude.size, sine.size, optics.wavenumber.size)
        mean, tilt = np.empty(shape, np.float32), np.empty(shape, np.float32)
        whole = optics.rayleigh + optics.aerosol_scattering
        forward = optics.aerosol_scattering * optics.asymmetry
        over = 2 * np.pi * np.where(optics.extinction > 0, optics.extinction, 1.0)
        fluxes = level_fluxes(state.altitude, shells, optics, scaled, source_paths, sine, state.surface_albedo)
        for part, rising, falling in fluxes:
            mean[:, :, part[1]] = (whole / over)[part][:, None] * (rising + falling)
            tilt[:, :, part[1]] = (forward / over)[part][:, None] * (rising - falling)
        return cls(state.altitude, sine, optics.extinction, mean, tilt)

    def spectral(self, segments, depths, cosine, _deflection=None):
        """Radiance along a ray at each point.

        Parameters
        ----------
        segments : transfer.Segments
        depths : transfer.Depths
        cosine : (K+1, S) array
            Of the source's zenith angle at the segment ends.

        Returns
        -------
        (S, P) array
            sr^-1.
        """
        nodes, share = source_nodes(self.sine, cosine)
        below, above = layer_shares(segments, self.levels, self.extinction, depths)
        light = below[:, None] * self._toward(segments, segments.layer, nodes)
        light += above[:, None] * self._toward(segments, segments.layer + 1, nodes)  # (K, V, P)
        count = cosine.shape[1]
        return share.transpose(1, 0, 2).reshape(count, -1) @ light.reshape(share.shape[0] * nodes.size, -1)

    def band(self, segments, depths, cosine, _deflection, weight):
        """Radiance of a band from all segments up to each end, (K+1, S); `weight` (P,) as in
        `transfer.scattered_band`.
        """
        nodes, share = source_nodes(self.sine, cosine)
        scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
        unit = (weight / scale).astype(np.float32)
        light = 0.0
        for layer, part in zip(
            (segments.layer, segments.layer + 1),
            layer_shares(segments, self.levels, self.extinction, depths),
            strict=True,
        ):
            light = light + np.matmul(self._toward(segments, layer, nodes), (part * unit)[..., None])  # (K, V, 1)
        radiance = np.zeros((cosine.shape[0], cosine.shape[1]))
        np.cumsum(np.matmul(share, light)[..., 0].astype(float) * scale, axis=0, out=radiance[1:])
        return radiance

    def at(self, layer, share, rise, cosine, _deflection=None):
        """Source function at one place, (S, P).

        Parameters
        ----------
        layer : int
        share : float
            Weight of its upper level.
        rise : float
            Cosine of the angle from the vertical at which light leaves.
        cosine : (S,) array
            Of the source's zenith angle.
        """
        nodes, weight = source_nodes(self.sine, np.stack([cosine, cosine]))
        below, above = (self.mean[k, nodes] + lean(rise) * self.tilt[k, nodes] for k in (layer, layer + 1))
        return weight[0] @ (below * (1 - share) + above * share)

    def _toward(self, segments, layer, nodes):
        """Source function at one level of each segment's layer, for its direction, at elevations of the source: (K, V,
        P).
        """
        rows = layer[:, None], nodes
        return self.mean[rows] + segments.lean[:, None, None].astype(np.float32) * self.tilt[rows]


def source_nodes(sine, cosine):
    """Of elevations of the source those needed (V,), and the linear weight of each in the middle of segments (K, S, V).

    Parameters
    ----------
    sine : (U,) array
        Of those elevations.
    cosine : (K+1, S) array
        Of the source's zenith angle at the segment ends.
    """
    middle = np.clip(0.5 * (cosine[:-1] + cosine[1:]), sine[0], sine[-1])
    place = np.interp(middle, sine, np.arange(sine.size))
    nodes = np.arange(int(place.min()), int(np.ceil(place.max())) + 1)
    return nodes, np.maximum(1 - np.abs(place[..., None] - nodes), 0.0).astype(np.float32)


def layer_shares(segments, levels, extinction, depths):
    """Weights of the source function at the lower and the upper level of each segment's layer, (K, P) each, at the
    observer.

    For a source linear in optical depth between the segment's ends, whose mean counts each level by its extinction (N,
    P) [m^2 per molecule]; never below 0. `depths` as in `transfer.Depths`.
    """
    near, far = depths.source_weights
    whole = near + far
    climb = (0.5 * np.diff(segments.altitude) / np.diff(levels)[segments.layer]).astype(near.dtype)[:, None]
    of_upper = segments.upper[:, None] * extinction[segments.layer + 1]
    upper = (of_upper / np.maximum(depths.each, np.finfo(np.float32).tiny)).astype(near.dtype)
    above = np.clip(whole * upper + (far - near) * climb, 0, whole)
    whole -= above
    return tuple((depths.through * part).astype(np.float32, copy=False) for part in (whole, above))


def level_fluxes(altitude, shells, optics, scaled, source_paths, sine, albedo):
    """Diffuse fluxes at the levels under a source of unit irradiance, a few points at a time.

    Parameters
    ----------
    altitude : (N,) array
        Of the levels, m.
    shells, optics, scaled, source_paths
        As `DiffuseLight.of`.
    sine : (U,) array
        Of the source's elevation, the same at every level.
    albedo : float
        Of the ground.

    Yields
    ------
    part : tuple of slice
        All levels, and the points.
    rising, falling : (N, U, p) arrays
        Of delta-scaled light: what goes straight on counts as beam.
    """
    straight = optics.aerosol_scattering * optics.asymmetry**2
    whole = optics.rayleigh + optics.aerosol_scattering
    forward = optics.aerosol_scattering * optics.asymmetry
    risen = upward_share(optics.phase, sine)
    count = altitude.size
    for start in range(0, optics.wavenumber.size, _CHUNK):
        part = np.s_[:, start : start + _CHUNK]
        paths = replace(source_paths, log_depth=source_paths.log_depth[..., part[1]])
        beam = paths.optical_depth(altitude, np.broadcast_to(sine, (count, sine.size))).astype(float)
        columns = (vertical_column(shells, values[part]) for values in (scaled, whole - straight, forward - straight))
        up = optics.aerosol_scattering[part][:, None] * (risen @ optics.phase_share[:, part[1]])
        up = (up + 0.5 * optics.rayleigh[part][:, None]).reshape(count, -1)
        upward = vertical_column(shells, up).reshape(count - 1, sine.size, -1)
        yield part, *diffuse_fluxes(*columns, upward, beam, sine, albedo)


def upward_share(phase, sine):
    """Share of a beam's scattering that goes up.

    Parameters
    ----------
    phase : (A, N, C) array
        Phase function at `optics.PHASE_ANGLES`.
    sine : (U,) array
        Of the source's elevation.

    Returns
    -------
    (N, U, C) array
    """
    # Of the circle of directions at one angle from the beam, the part above the horizon.
    beam = np.sqrt(np.maximum(1 - sine**2, 1e-12))[:, None] * np.sin(PHASE_ANGLES)
    rim = sine[:, None] * np.cos(PHASE_ANGLES) / np.maximum(beam, 1e-12)
    part = np.arccos(np.clip(rim, -1.0, 1.0)) / np.pi
    edges = np.concatenate([[0.0], 0.5 * (PHASE_ANGLES[1:] + PHASE_ANGLES[:-1]), [np.pi]])
    weight = -np.diff(np.cos(edges))
    whole = np.einsum("a,anc->nc", weight, phase)
    return np.einsum("ua,anc->nuc", part * weight, phase) / whole[:, None]


def diffuse_fluxes(depth, scattering, forward, upward, beam, sine, albedo):
    """Diffuse fluxes under a beam of unit irradiance.

    Parameters
    ----------
    depth, scattering, forward : (N-1, P) arrays
        Of the layers from the ground up, delta scaled: optical depth, that of scattering, and that times the asymmetry.
    upward : (N-1, U, P) array
        Optical depth of that scattering of the beam which goes up.
    beam : (N, U, P) array
        Optical depth from the source to each level, delta scaled.
    sine : (U,) array
        Of the source's elevation.
    albedo : float
        Of the ground.

    Returns
    -------
    rising, falling : (N, U, P) arrays
    """
    depth = depth[:, None]
    some, scatters = depth > 0, scattering[:, None] > 0
    share = np.where(some, scattering[:, None] / np.where(some, depth, 1.0), 0.0)
    share = np.minimum(share, _LARGEST_ALBEDO)
    asymmetry = np.where(scatters, forward[:, None] / np.where(scatters, scattering[:, None], 1.0), 0.0)
    same, other = 2 - share * (1.25 + 0.75 * asymmetry), 0.75 * share * (1 - asymmetry)
    slabs = Slabs.of(same, other, depth)

    # The beam falls exponentially inside a layer; `first` and `last` are its mean over the layer, weighted with the
    # decay of diffuse light on the way to the top and to the bottom.
    fall = np.maximum(beam[:-1] - beam[1:], 0.0)
    vertical = slabs.decay * depth
    scattered = share * depth * np.exp(-beam[1:])
    first = mean_attenuation(np.zeros_like(fall), vertical + fall) * scattered
    last = mean_attenuation(np.broadcast_to(vertical, fall.shape), fall) * scattered
    # Share of the beam's scattering that goes up; what stays after scaling bounds it.
    back = np.clip(np.where(scatters, upward / np.where(scatters, scattering[:, None], 1.0), 0.5), 0.0, 1.0)
    deep, left = slabs.deep, slabs.left
    closed = 1 - (deep * left) ** 2
    upward = (back * (first - deep**2 * left * last) + (1 - back) * deep * (first - left * last)) / closed
    downward = ((1 - back) * (last - deep**2 * left * first) + back * deep * (last - left * first)) / closed
    ground = albedo * np.maximum(sine, 0.0)[:, None] * np.exp(-beam[0])
    return join(slabs.reflection, slabs.transmission, upward, downward, albedo, ground)
