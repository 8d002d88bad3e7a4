"""Light of Sun or Moon scattered once into a line of sight, with the true phase functions.

Inside a segment the optical depth from the source through the segment to the observer is linear in distance.
Light scattered more often is in `ordinate_light`.
"""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, SpectralOptics, rayleigh_phase
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_paths import HIDDEN, SourcePaths
from skyshine.schemas.arrays import Floats, Integers, Reals, Singles


def segment_attenuation(segments: Segments, depths: Depths, source_paths: SourcePaths, cosine: Floats) -> Singles:
    """Mean transmittance for a source's light, from the source to each segment and on to the observer.

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
    depth += np.minimum(depths.cumulative, HIDDEN).astype(np.float32)[:, None]
    return _segment_means(depth)


def aerosol_phase(segments: Segments, optics: SpectralOptics, cosine: Floats) -> Floats:
    """Phase function of the particles in each segment; where rain or cloud ends theirs, not that of the haze above.

    Parameters
    ----------
    segments : Segments
    optics : SpectralOptics
    cosine : (K+1, S) array
        Of the scattering angle at the segment ends.

    Returns
    -------
    (K, S, C) array
        At the C wavelengths of `optics.phase`.
    """
    angle = np.arccos(np.clip(0.5 * (cosine[:-1] + cosine[1:]), -1.0, 1.0))
    place = angle / PHASE_ANGLES[1]
    first = np.minimum(place.astype(int), PHASE_ANGLES.size - 2)
    fraction = (place - first)[..., None]
    share = segments.upper_share_of(optics.aerosol_scattering)[:, None, None]
    layer = segments.layer[:, None]

    def at_level(level: Integers) -> Floats:
        near, far = optics.phase[first, level], optics.phase[first + 1, level]
        phase: Floats = near + (far - near) * fraction
        return phase

    return (1 - share) * at_level(layer) + share * at_level(layer + 1)


def scattered_spectral(segments: Segments, optics: SpectralOptics, attenuation: Singles, cosine: Floats) -> Floats:
    """Scattered radiance at each spectral point, per unit of the source's irradiance.

    Parameters
    ----------
    segments : Segments
    optics : SpectralOptics
    attenuation : (K, S, P) array
        Of `segment_attenuation`.
    cosine : (K+1, S) array
        Of the scattering angle at the segment ends.

    Returns
    -------
    (S, P) array
        sr^-1.
    """
    light = scattering_of_segments(segments, optics, cosine)
    radiance: Floats = np.einsum("ksp,ksp->sp", attenuation, light) / (4 * np.pi)
    return radiance


def scattering_of_segments(
    segments: Segments,
    optics: SpectralOptics,
    cosine: Floats,
    phase: Floats | None = None,
    line: Integers | None = None,
) -> Singles:
    """Optical depth of scattering in each segment times the phase function, (K, S, P).

    Parameters
    ----------
    segments, optics, cosine
        As of `scattered_spectral`.
    phase : (L, N, S, C) array, optional
        Phase function of the particles at the levels, by line, in place of the one at that angle.
    line : (K,) int array
        Of each segment, where there is such a phase function.
    """
    middle = 0.5 * (cosine[:-1] + cosine[1:])
    molecules = segments.column(optics.rayleigh).astype(np.float32, copy=False)[:, None]
    light: Singles = rayleigh_phase(middle, optics.rayleigh_anisotropy.mean()).astype(np.float32)[..., None] * molecules
    if np.any(optics.aerosol_scattering):
        particles = segments.column(optics.aerosol_scattering).astype(np.float32, copy=False)[:, None]
        shape: Reals = (
            aerosol_phase(segments, optics, cosine)
            if phase is None
            else _between_levels(segments, phase, line, segments.upper_share_of(optics.aerosol_scattering))
        )
        shares = optics.phase_share.astype(np.float32)
        phases = shape.astype(np.float32).reshape(-1, len(shares)) @ shares
        phases = phases.reshape(light.shape)
        phases *= particles
        light += phases
    return light


def _between_levels(segments: Segments, phase: Floats, line: Integers | None, upper_share: Floats) -> Floats:
    """Mean over each segment of a property (L, N, S, C) at the levels of its line, (K, S, C)."""
    of_line = np.zeros(upper_share.size, int) if line is None else line
    share = upper_share[:, None, None]
    mean: Floats = phase[of_line, segments.layer] * (1 - share) + phase[of_line, segments.layer + 1] * share
    return mean


def _segment_means(depth: Singles) -> Singles:
    """`segments.mean_attenuation` between neighbours along the first axis, (K, ...) of (K+1, ...); 0 below 1e-19."""
    through = np.exp(-depth)
    difference = np.diff(depth, axis=0)
    square: Singles = np.square(difference)
    series = square / np.float32(80)
    series += 1
    series *= square
    series /= 24
    series += 1
    series *= np.sqrt(through[1:] * through[:-1])
    wide = square > 1
    np.subtract(through[:-1], through[1:], out=square)
    np.divide(square, difference, out=series, where=wide)
    return series
