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


def scattered_spectral(
    segments: Segments, optics: SpectralOptics, attenuation: Singles, cosine: Floats, phase: Floats | None = None
) -> Floats:
    """Scattered radiance at each spectral point, per unit of the source's irradiance.

    Parameters
    ----------
    segments : Segments
    optics : SpectralOptics
    attenuation : (K, S, P) array
        Of `segment_attenuation`.
    cosine : (K+1, S) array
        Of the scattering angle at the segment ends.
    phase : (N, S, C) array, optional
        Phase function of the particles at the levels, in place of the one at that angle.

    Returns
    -------
    (S, P) array
        sr^-1.
    """
    light = scattering_of_segments(segments, optics, cosine, phase)
    radiance: Floats = np.einsum("ksp,ksp->sp", attenuation, light) / (4 * np.pi)
    return radiance


def scattering_of_segments(
    segments: Segments, optics: SpectralOptics, cosine: Floats, phase: Floats | None = None
) -> Singles:
    """Optical depth of scattering in each segment times the phase function, (K, S, P); arguments as
    `scattered_spectral`.
    """
    middle = 0.5 * (cosine[:-1] + cosine[1:])
    molecules = segments.column(optics.rayleigh).astype(np.float32, copy=False)[:, None]
    light: Singles = rayleigh_phase(middle, optics.rayleigh_anisotropy.mean()).astype(np.float32)[..., None] * molecules
    if np.any(optics.aerosol_scattering):
        particles = segments.column(optics.aerosol_scattering).astype(np.float32, copy=False)[:, None]
        shape: Reals = (
            aerosol_phase(segments, optics, cosine)
            if phase is None
            else segments.mean(phase, segments.upper_share_of(optics.aerosol_scattering))
        )
        light += (shape @ optics.phase_share).astype(np.float32) * particles
    return light


def scattered_band(
    segments: Segments,
    optics: SpectralOptics,
    depths: Depths,
    source_paths: SourcePaths,
    to_source: Floats,
    deflection: Floats,
    weight: Floats,
) -> Floats:
    """Scattered radiance of a band from each segment at the observer.

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
    (K, S) array
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
    radiance: Floats = np.sum(by_kind * np.concatenate(phases, axis=-1), axis=-1) * scale / (4 * np.pi)
    return radiance


def _light_in_band(
    segments: Segments, depths: Depths, source_paths: SourcePaths, cosine: Floats, column: Singles
) -> Floats:
    """Sum over points of a column (K, P, C) times the mean transmittance from source to observer, (K, S, C).

    It is computed at the elevations of the table of source paths; between them the optical depth of the band is a power
    of the air mass, for many sources at once.
    """
    depth, first, share, hidden = source_paths.along(segments.altitude, cosine)
    cumulative = depths.cumulative.astype(np.float32)[:, None]
    unlit = np.matmul(_segment_means(cumulative), column).astype(float)  # (K, 1, C)
    depth += cumulative
    lit = np.matmul(_segment_means(depth), column).astype(float)
    tiny = np.finfo(np.float32).tiny
    # Optical depth of the band between source and segment.
    band_depth = -np.log(np.clip(lit / np.where(unlit > 0, unlit, 1.0), tiny, 1.0))
    log_depth = np.log(np.maximum(band_depth, tiny))
    near, far = (np.take_along_axis(log_depth, (first + step)[..., None], axis=1) for step in (0, 1))
    light: Floats = unlit * np.exp(-np.exp(near + (far - near) * share[..., None]))
    light[hidden] = 0.0
    return light


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
