"""Radiative transfer along lines of sight: transmittance, emission, single scattering of a distant source.

Thermal radiation has a source function linear in optical depth inside a segment (`diffuse`). Without particles it is
the blackbody radiance of the air, and air of one temperature gives exactly (1 - transmittance) times that.

Light of Sun or Moon is scattered here once, with the true phase functions; inside a segment the whole optical depth
from the source to the observer is linear in distance. `multiple` holds what is scattered more often.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import Rays
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, rayleigh_phase
from skyshine.mat.atmosphere.transfer.source_paths import HIDDEN
from skyshine.mat.atmosphere.transfer.thermal_source import lean

# Below this optical depth the weight of a segment's far end goes in proportion to the depth, by type of number: a
# larger one costs accuracy in thin segments (this fraction of that weight), a smaller one cancellation.
_THIN = {np.dtype(np.float32): 1e-3, np.dtype(np.float64): 1e-6}
# From this many points on, adding row to row is quicker than numpy's running sum along the first axis.
_WIDE = 256


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
            index,
            rays.layer[row, index],
            rays.lower[row, index],
            rays.upper[row, index],
            rays.altitude[row, ends],
            rays.central_angle[row, ends],
            rays.direction[row, ends],
            rays.distance[row, ends],
        )

    def first(self, count):
        """The `count` segments nearest the observer."""
        return Segments(
            self.index[:count],
            self.layer[:count],
            self.lower[:count],
            self.upper[:count],
            self.altitude[: count + 1],
            self.central_angle[: count + 1],
            self.direction[: count + 1],
            self.distance[: count + 1],
        )

    def column(self, per_molecule):
        """Integral of a property (N, P) [m^2 per molecule] along each segment, (K, P)."""
        return self.lower[:, None] * per_molecule[self.layer] + self.upper[:, None] * per_molecule[self.layer + 1]

    def mean(self, values):
        """Mean over each segment's air of a property (N, ...) at the levels, (K, ...)."""
        share = (self.upper / (self.lower + self.upper)).reshape(-1, *(1,) * (values.ndim - 1))
        return values[self.layer] * (1 - share) + values[self.layer + 1] * share

    @cached_property
    def lean(self):
        """`diffuse.lean` of radiation that travels towards the observer, (K,)."""
        return lean(self.rise)

    @property
    def rise(self):
        """Cosine of the angle from the vertical at which radiation travels towards the observer, (K,)."""
        zenith = self.direction - self.central_angle  # local, of the line of sight; radiation travels the other way
        return -np.cos(0.5 * (zenith[1:] + zenith[:-1]))

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
            Its ends: the line has the mean of the source over the segment's air and the difference between the
            segment's ends.
        """
        share = self.lean.astype(mean.dtype)[:, None]
        below = mean[self.layer] + share * tilt[self.layer]
        above = mean[self.layer + 1] + share * tilt[self.layer + 1]
        climb = 0.5 * np.diff(self.altitude) / np.diff(levels)[self.layer]
        upper = self.upper / (self.lower + self.upper)
        rise = above - below
        middle = below + rise * upper.astype(mean.dtype)[:, None]
        half = np.clip(rise * climb.astype(mean.dtype)[:, None], -middle, middle)  # a source is never negative
        return middle - half, middle + half


@dataclass(frozen=True, eq=False)
class Depths:
    """Optical depth along the segments of a ray, and what follows from it, computed once.

    Attributes
    ----------
    each : (K, P) array
        Of each segment, single or double precision.
    """

    each: np.ndarray

    @cached_property
    def before(self):
        """From the observer to each segment end, (K+1, P)."""
        result = np.zeros((self.each.shape[0] + 1, self.each.shape[1]), dtype=self.each.dtype)
        if self.each.shape[1] < _WIDE:
            np.cumsum(self.each, axis=0, out=result[1:])
        else:
            for sum_before, here, sum_after in zip(result[:-1], self.each, result[1:], strict=True):
                np.add(sum_before, here, out=sum_after)
        return result

    @cached_property
    def through(self):
        """Transmittance from the observer to the near end of each segment, (K, P)."""
        return np.exp(-self.before[:-1])

    @cached_property
    def source_weights(self):
        """`source_weights` of the segments."""
        return source_weights(self.each)


def source_weights(optical_depth):
    """Weights of the source functions at the near and far end of segments, linear in optical depth between.

    Parameters
    ----------
    optical_depth : array
        0 to infinity; single or double precision.

    Returns
    -------
    near, far : arrays
        Their sum is 1 - exp(-optical_depth).
    """
    t = np.asarray(optical_depth)
    thin = t.dtype.type(_THIN[t.dtype])
    absorbed = np.expm1(-t)
    np.negative(absorbed, out=absorbed)
    far = np.maximum(absorbed, -np.expm1(-thin))  # at `thin` or more, where both terms below are safe
    far *= 1 + 1 / np.maximum(t, thin)
    far -= 1
    far *= np.minimum(t * (1 / thin), 1)
    return absorbed - far, far


def emitted(depths, near, far):
    """Emission of each segment that reaches the observer.

    Parameters
    ----------
    depths : Depths
    near, far : (K, P) arrays
        Source function at the segments' near and far ends.

    Returns
    -------
    (K, P) array
        Radiance.
    """
    weight_near, weight_far = depths.source_weights
    radiance = weight_near * near
    radiance += weight_far * far
    radiance *= depths.through
    return radiance


def mean_attenuation(first, last):
    """Mean of exp(-x) over segments in which x runs linearly from `first` to `last`; same shapes, single precision
    allowed.

    exp(-smaller) (1 - exp(-d)) / d, d the difference: without cancellation at any d; the tiny number added makes it 1
    at 0.
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


def segment_attenuation(segments, depths, source_paths, cosine):
    """Mean attenuation of a source's light, down to each segment and on to the observer.

    Parameters
    ----------
    segments : Segments
    depths : Depths
    source_paths : SourcePaths
    cosine : (K+1, S) array
        Of the source's zenith angle at the segment ends.

    Returns
    -------
    (K, S, P) array, single precision
    """
    depth = source_paths.optical_depth(segments.altitude, cosine)
    depth += np.minimum(depths.before, HIDDEN).astype(np.float32)[:, None]
    return _segment_means(depth)


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


def scattered_band(segments, optics, depths, source_paths, to_source, deflection, weight):
    """Scattered radiance of a band from all segments up to each end.

    Parameters
    ----------
    segments : Segments
    optics : SpectralOptics
    depths : Depths
    source_paths : SourcePaths
    to_source, deflection : (K+1, S) arrays
        Cosines of the source's zenith angle and of the scattering angle at the segment ends.
    weight : (P,) array
        Of the spectral points, times the source's irradiance there.

    Returns
    -------
    (K+1, S) array
        In the units of `weight`, sr^-1.
    """
    middle = 0.5 * (deflection[:-1] + deflection[1:])
    molecules = segments.column(optics.rayleigh) * weight
    parts = [molecules[..., None]]
    phases = [rayleigh_phase(middle, optics.rayleigh_anisotropy.mean())[..., None]]
    if np.any(optics.aerosol_scattering):
        particles = segments.column(optics.aerosol_scattering) * weight
        parts.append(particles[..., None] * optics.phase_share.T)
        phases.append(aerosol_phase(segments, optics, deflection))
    scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
    column = (np.concatenate(parts, axis=-1) / scale).astype(np.float32)  # (K, P, 1 + C)
    by_kind = _light_in_band(segments, depths, source_paths, to_source, column)
    radiance = np.zeros((middle.shape[0] + 1, middle.shape[1]))
    np.cumsum(
        np.sum(by_kind * np.concatenate(phases, axis=-1), axis=-1) * scale / (4 * np.pi), axis=0, out=radiance[1:]
    )
    return radiance


def _light_in_band(segments, depths, source_paths, cosine, column):
    """Sum over points of a column (K, P, C) times the mean attenuation from source to observer, (K, S, C).

    It is computed at the elevations of the table of source paths and goes between them with a power of the air mass,
    many sources at once.
    """
    depth, first, share, hidden = source_paths.along(segments.altitude, cosine)
    before = depths.before.astype(np.float32)[:, None]
    unlit = np.matmul(_segment_means(before), column).astype(float)  # (K, 1, C)
    depth += before
    lit = np.matmul(_segment_means(depth), column).astype(float)
    tiny = np.finfo(np.float32).tiny
    # Depth of the band between source and segment.
    band = -np.log(np.clip(lit / np.where(unlit > 0, unlit, 1.0), tiny, 1.0))
    log_band = np.log(np.maximum(band, tiny))
    near, far = (np.take_along_axis(log_band, (first + step)[..., None], axis=1) for step in (0, 1))
    light = unlit * np.exp(-np.exp(near + (far - near) * share[..., None]))
    light[hidden] = 0.0
    return light


def _segment_means(depth):
    """`mean_attenuation` between neighbours along the first axis, (K, ...) of (K+1, ...); 0 where light is below
    1e-19.
    """
    through = np.exp(-depth)
    difference = np.diff(depth, axis=0)
    square = np.square(difference)
    series = square / 80
    series += 1
    series *= square
    series /= 24
    series += 1
    series *= np.sqrt(through[1:] * through[:-1])
    wide = square > 1
    np.subtract(through[:-1], through[1:], out=square)
    return np.divide(square, difference, out=series, where=wide)
