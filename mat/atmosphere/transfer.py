"""Radiative transfer along lines of sight: transmittance, emission, single scattering of a distant source.

Thermal radiation has a source function linear in optical depth inside a segment (`diffuse`). Without particles it is the blackbody
radiance of the air, and air of one temperature gives exactly (1 - transmittance) times that.

Light of Sun or Moon is scattered here once, with the true phase functions; inside a segment the whole optical depth from the source
to the observer is linear in distance. `multiple` holds what is scattered more often.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.diffuse import lean
from skyshine.mat.atmosphere.geometry import EARTH_RADIUS, Rays, bending_to_space, trace
from skyshine.mat.atmosphere.optics import PHASE_ANGLES, rayleigh_phase

# Optical depth at which a source is as good as hidden: exp of its negative is 0 in single precision.
HIDDEN = 1e4
_SMALLEST_DEPTH = 1e-30
# Nodes of the source table. Down: the lowest point of the ray, as (i / n)^2 of the height above the ground. Up: degrees.
_GRAZING_NODES = 20
_UP_NODES = (0.2, 0.5, 1, 1.5, 2, 3, 4, 5.5, 7.5, 10, 14, 20, 28, 40, 55, 75, 90)
# A ray that passes this far above the ground (m) is the lowest that reaches space.
_CLEARANCE = 1e-3
# Scale height of the shell whose air mass divides the slant optical depths of the table; 8 km is the air's (any would do).
_SCALE_HEIGHT = 8e3


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of one ray that hold air, K of them, at P points.

    Attributes
    ----------
    index : (K,) int array
        Their place among the ray's segments.
    layer : (K,) int array
    lower, upper : (K,) arrays
        As in `geometry.Rays`.
    altitude : (K+1,) array
        Of the segment ends, m.
    central_angle, direction : (K+1,) arrays
        rad.
    distance : (K+1,) array
        From the observer, m.
    """

    index: np.ndarray
    layer: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    altitude: np.ndarray
    central_angle: np.ndarray
    direction: np.ndarray
    distance: np.ndarray

    @classmethod
    def of(cls, rays: Rays, row: int) -> Segments:
        """The segments of one ray that are longer than 0."""
        index = np.flatnonzero(rays.lower[row] + rays.upper[row] > 0)
        ends = np.append(index, index[-1] + 1 if index.size else 0)
        return cls(
            index, rays.layer[row, index], rays.lower[row, index], rays.upper[row, index], rays.altitude[row, ends],
            rays.central_angle[row, ends], rays.direction[row, ends], rays.distance[row, ends],
        )  # fmt: skip

    def first(self, count):
        """The `count` segments nearest the observer."""
        return Segments(
            self.index[:count], self.layer[:count], self.lower[:count], self.upper[:count], self.altitude[: count + 1],
            self.central_angle[: count + 1], self.direction[: count + 1], self.distance[: count + 1],
        )  # fmt: skip

    def column(self, per_molecule):
        """Integral of a property (N, P) [m^2 per molecule] along each segment, (K, P)."""
        return self.lower[:, None] * per_molecule[self.layer] + self.upper[:, None] * per_molecule[self.layer + 1]

    def mean(self, values):
        """Mean over each segment's air of a property (N, ...) at the levels, (K, ...)."""
        share = (self.upper / (self.lower + self.upper)).reshape(-1, *(1,) * (values.ndim - 1))
        return values[self.layer] * (1 - share) + values[self.layer + 1] * share

    @property
    def lean(self):
        """`diffuse.lean` of radiation that travels towards the observer, (K,)."""
        zenith = self.direction - self.central_angle  # local, of the line of sight; radiation travels the other way
        return lean(-np.cos(0.5 * (zenith[1:] + zenith[:-1])))

    def source(self, mean, tilt, levels):
        """A source function as the line that stands for it in each segment.

        Parameters
        ----------
        mean, tilt : (N, P) arrays
            At the levels, linear in altitude between them: `diffuse.ThermalSource`.
        levels : (N,) array
            m.

        Returns
        -------
        near, far : (K, P) arrays
            Its ends: the line has the mean of the source over the segment's air and the difference between the segment's ends.
        """
        share = self.lean[:, None]
        below = mean[self.layer] + share * tilt[self.layer]
        above = mean[self.layer + 1] + share * tilt[self.layer + 1]
        climb = np.diff(self.altitude) / np.diff(levels)[self.layer]
        middle = below + (above - below) * (self.upper / (self.lower + self.upper))[:, None]
        half = np.clip(0.5 * (above - below) * climb[:, None], -middle, middle)  # a source is never negative
        return middle - half, middle + half


def source_weights(optical_depth):
    """Weights of the source functions at the near and far end of segments, linear in optical depth between.

    Parameters
    ----------
    optical_depth : array
        0 to infinity.

    Returns
    -------
    near, far : arrays
        Their sum is 1 - exp(-optical_depth).
    """
    t = np.asarray(optical_depth, dtype=float)
    absorbed = -np.expm1(-t)
    small = t < 1e-3
    series = t * (1 / 2 - t * (1 / 3 - t * (1 / 8 - t / 30)))
    safe = np.where(small, 1.0, t)
    far = np.where(small, series, absorbed / safe - np.exp(-t))
    return absorbed - far, far


def emitted(optical_depth, near, far):
    """Emission of successive segments that reaches the observer.

    Parameters
    ----------
    optical_depth : (K, P) array
        Of each segment.
    near, far : (K, P) arrays
        Source function at its near and far end.

    Returns
    -------
    (K+1, P) array
        Radiance from all segments up to each end.
    """
    before = np.zeros((optical_depth.shape[0] + 1, optical_depth.shape[1]))
    np.cumsum(optical_depth, axis=0, out=before[1:])
    weight_near, weight_far = source_weights(optical_depth)
    radiance = np.zeros_like(before)
    np.cumsum(np.exp(-before[:-1]) * (weight_near * near + weight_far * far), axis=0, out=radiance[1:])
    return radiance


def mean_attenuation(first, last):
    """Mean of exp(-x) over segments in which x runs linearly from `first` to `last`; same shapes, single precision allowed.

    exp(-smaller) (1 - exp(-d)) / d, d the difference: without cancellation at any d; the tiny number added makes it 1 at 0.
    """
    difference = np.subtract(last, first)
    np.abs(difference, out=difference)
    difference += difference.dtype.type(1e-20)
    mean = np.minimum(first, last)
    np.exp(np.negative(mean, out=mean), out=mean)
    share = np.negative(difference)
    np.expm1(share, out=share)
    mean *= np.divide(share, difference, out=share)
    return np.negative(mean, out=mean)


@dataclass(frozen=True, eq=False)
class SourcePaths:
    """Optical depth from a distant source to any point, by altitude and geometric elevation.

    The refracted rays from each of N levels to space at U apparent elevations, from the one that grazes the ground to the
    vertical. A source below the grazing ray is hidden by the Earth.

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    elevation : (N, U) array
        Geometric elevation, rad, increasing along U.
    log_depth : (N, U, P) array
        Logarithm of optical depth over the air mass of a shell, single precision.
    """

    levels: np.ndarray
    elevation: np.ndarray
    log_depth: np.ndarray

    @classmethod
    def of(cls, shells, extinction):
        """Tabulate the rays of `geometry.Shells` for an extinction (N, P) [m^2 per molecule]."""
        apparent = _apparent_elevations(shells)
        count, nodes = apparent.shape
        rays = trace(shells, np.repeat(shells.altitude, nodes), apparent.ravel())
        elevation = (np.pi / 2 - bending_to_space(rays)).reshape(count, nodes)
        elevation = np.maximum.accumulate(elevation, axis=1)
        # Each ray's segments run down through all layers, then up through all: fold both onto the levels.
        down, up = np.split(np.arange(rays.layer.shape[1]), 2)
        air = np.zeros((count * nodes, count))
        air[:, :-1] += rays.lower[:, down[::-1]] + rays.lower[:, up]
        air[:, 1:] += rays.upper[:, down[::-1]] + rays.upper[:, up]
        depth = (air @ extinction).reshape(count, nodes, -1)
        air_mass = _shell_air_mass(shells.altitude[:, None], elevation)
        log_depth = np.log(np.maximum(depth, _SMALLEST_DEPTH)) - np.log(air_mass)[..., None]
        return cls(shells.altitude, elevation, log_depth.astype(np.float32))

    def optical_depth(self, altitude, cosine):
        """Optical depth to the source.

        Parameters
        ----------
        altitude : (K,) array
            Of the points, m.
        cosine : (K, S) array
            Of the source's geometric zenith angle at each point.

        Returns
        -------
        (K, S, P) array
            Single precision; `HIDDEN` or more where the Earth hides the source.
        """
        altitude, elevation, clear = self._entering(
            np.asarray(altitude, dtype=float), np.arcsin(np.clip(cosine, -1.0, 1.0))
        )
        lower = np.clip(np.searchsorted(self.levels, altitude, side="right") - 1, 0, self.levels.size - 2)
        share = np.clip((altitude - self.levels[lower]) / np.diff(self.levels)[lower], 0.0, 1.0)
        nodes = self.elevation[lower] * (1 - share)[:, None] + self.elevation[lower + 1] * share[:, None]
        place = _fractional_index(nodes, elevation)
        hidden = (elevation < nodes[:, :1]) & ~clear
        first = np.minimum(place.astype(int), nodes.shape[1] - 2)
        fraction, share = (place - first), share[:, None]
        row = lower[:, None] * nodes.shape[1] + first
        table = self.log_depth.reshape(-1, self.log_depth.shape[2])
        corners = (
            (row, (1 - share) * (1 - fraction)),
            (row + 1, (1 - share) * fraction),
            (row + nodes.shape[1], share * (1 - fraction)),
            (row + nodes.shape[1] + 1, share * fraction),
        )
        depth = np.zeros((*row.shape, table.shape[1]), dtype=np.float32)
        for corner, weight in corners:
            if np.any(weight):
                depth += table[corner] * weight.astype(np.float32)[..., None]
        depth += np.log(_shell_air_mass(altitude[:, None], elevation)).astype(np.float32)[..., None]
        np.exp(depth, out=depth)
        depth[clear] = 0.0
        depth[hidden] += HIDDEN
        return depth

    def _entering(self, altitude, elevation):
        """Points in space move along the ray to where it enters the atmosphere; `clear` (K, S) where it never does."""
        top = self.levels[-1]
        outside = (altitude > top)[:, None]
        ratio = ((EARTH_RADIUS + altitude) / (EARTH_RADIUS + np.minimum(altitude, top)))[:, None] * np.cos(elevation)
        clear = outside & ((elevation >= 0) | (ratio >= 1))
        entering = -np.arccos(np.clip(ratio, 0.0, 1.0))
        return np.minimum(altitude, top), np.where(outside & ~clear, entering, elevation), clear


def _apparent_elevations(shells):
    """Apparent elevations (N, U) [rad] of rays to space from each level, increasing."""
    invariant = shells.index * shells.radius
    step = (np.arange(_GRAZING_NODES + 1) / _GRAZING_NODES) ** 2
    lowest = shells.altitude[0] + (shells.altitude - shells.altitude[0])[:, None] * step
    at_lowest = np.interp(lowest, shells.altitude, invariant)
    at_lowest = np.maximum(at_lowest, invariant[0] * (1 + _CLEARANCE / shells.radius[0]))
    down = -np.arccos(np.minimum(at_lowest / invariant[:, None], 1.0))
    down[0] = 0.0
    up = np.broadcast_to(np.radians(_UP_NODES), (shells.altitude.size, len(_UP_NODES)))
    return np.concatenate([down, up], axis=1)


def _shell_air_mass(altitude, elevation):
    """Air mass of a homogeneous shell above a point: smooth in elevation at any altitude, above and below the horizon."""
    height = (EARTH_RADIUS + altitude) / _SCALE_HEIGHT
    across = height * np.sin(elevation)
    root = np.sqrt(across**2 + 2 * height + 1)
    # Of the two equal forms, the one without cancellation.
    return np.where(across > 0, (2 * height + 1) / (root + np.abs(across)), root + np.abs(across))


def _fractional_index(nodes, points):
    """Place of points (K, S) among increasing nodes (K, U), as an index with a fraction, held at both ends."""
    index = np.arange(nodes.shape[1], dtype=float)
    return np.stack([np.interp(point, node, index) for node, point in zip(nodes, points, strict=True)])


def segment_attenuation(segments, optical_depth, source_paths, cosine):
    """Mean attenuation of a source's light, down to each segment and on to the observer.

    Parameters
    ----------
    segments : Segments
    optical_depth : (K, P) array
        Of each segment.
    source_paths : SourcePaths
    cosine : (K+1, S) array
        Of the source's zenith angle at the segment ends.

    Returns
    -------
    (K, S, P) array, single precision
    """
    depth = source_paths.optical_depth(segments.altitude, cosine)
    before = np.zeros((optical_depth.shape[0] + 1, 1, optical_depth.shape[1]), dtype=np.float32)
    np.cumsum(optical_depth, axis=0, out=before[1:, 0])
    depth += np.minimum(before, HIDDEN)
    return mean_attenuation(depth[:-1], depth[1:])


def aerosol_phase(segments, optics, cosine):
    """Phase function of the particles in each segment, (K, S, C) at the C wavelengths of `optics.phase`.

    cosine : (K+1, S) array
        Of the scattering angle at the segment ends.
    """
    angle = np.arccos(np.clip(0.5 * (cosine[:-1] + cosine[1:]), -1.0, 1.0))
    place = angle / PHASE_ANGLES[1]
    first = np.minimum(place.astype(int), PHASE_ANGLES.size - 2)
    fraction = (place - first)[..., None]
    share = (segments.upper / (segments.lower + segments.upper))[:, None, None]
    layer = segments.layer[:, None]
    result = 0.0
    for level, weight in ((layer, 1 - share), (layer + 1, share)):
        near, far = optics.phase[first, level], optics.phase[first + 1, level]
        result = result + weight * (near + (far - near) * fraction)
    return result


def scattered_spectral(segments, optics, attenuation, cosine, phase=None):
    """Scattered radiance at each spectral point, per unit of the source's irradiance.

    Parameters
    ----------
    segments : Segments
    optics : SpectralOptics
    attenuation : (K, S, P) array
    cosine : (K+1, S) array
        Of the scattering angle at the segment ends.
    phase : (N, S, C) array, optional
        Phase function of the particles at the levels, where it is not to be the one at that angle.

    Returns
    -------
    (S, P) array
        sr^-1.
    """
    middle = 0.5 * (cosine[:-1] + cosine[1:])
    molecules = segments.column(optics.rayleigh).astype(np.float32)[:, None]
    light = rayleigh_phase(middle, optics.rayleigh_anisotropy.mean()).astype(np.float32)[..., None] * molecules
    if np.any(optics.aerosol_scattering):
        particles = segments.column(optics.aerosol_scattering).astype(np.float32)[:, None]
        shape = aerosol_phase(segments, optics, cosine) if phase is None else segments.mean(phase)
        light += (shape @ optics.phase_share).astype(np.float32) * particles
    return np.einsum("ksp,ksp->sp", attenuation, light) / (4 * np.pi)


def scattered_band(segments, optics, attenuation, cosine, weight):
    """Scattered radiance of a band from all segments up to each end.

    Parameters
    ----------
    segments, optics, attenuation, cosine
        As `scattered_spectral`.
    weight : (P,) array
        Of the spectral points, times the source's irradiance there.

    Returns
    -------
    (K+1, S) array
        In the units of `weight`, sr^-1.
    """
    middle = 0.5 * (cosine[:-1] + cosine[1:])
    molecules = segments.column(optics.rayleigh) * weight
    parts = [molecules[..., None]]
    phases = [rayleigh_phase(middle, optics.rayleigh_anisotropy.mean())[..., None]]
    if np.any(optics.aerosol_scattering):
        particles = segments.column(optics.aerosol_scattering) * weight
        parts.append(particles[..., None] * optics.phase_share.T)
        phases.append(aerosol_phase(segments, optics, cosine))
    scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
    column = (np.concatenate(parts, axis=-1) / scale).astype(np.float32)  # (K, P, 1 + C)
    by_kind = np.matmul(attenuation, column)
    radiance = np.zeros((middle.shape[0] + 1, middle.shape[1]))
    np.cumsum(
        np.sum(by_kind * np.concatenate(phases, axis=-1), axis=-1) * scale / (4 * np.pi), axis=0, out=radiance[1:]
    )
    return radiance
