"""Irradiance of a horizontal surface by the sky, and by Sun or Moon directly, at any altitude."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.atmosphere.transfer.two_stream_light import TwoStreamLight
from skyshine.schemas.arrays import Floats

# Directions of the hemisphere: Gauss nodes in the cosine of zenith angle, and in azimuth over half a turn (the other
# half mirrors it). Against 24 x 24: thermal to 2e-4, scattered light to 0.6 % rms, 2 % with the source in the zenith;
# more azimuths change less, because the phase function is averaged over the cells below.
ZENITHS, AZIMUTHS = 8, 4
# Directions within a cell, each way, over which the phase function is averaged.
_SAMPLES = 8


@dataclass(frozen=True, eq=False)
class SkyIrradiance:
    """Downwelling diffuse irradiance at Z altitudes and P points.

    Attributes
    ----------
    thermal : (Z, P) array
        Emitted by the air, W m^-2 (cm^-1)^-1.
    scattered : (Z, S, P) array
        Scattered light of a source at each of S elevations, per unit of its irradiance normal to the beam outside the
        atmosphere.
    """

    thermal: Floats
    scattered: Floats


def sky_irradiance(
    air: SpectralAir,
    altitude: npt.ArrayLike,
    source_elevation: npt.ArrayLike,
    *,
    zeniths: int = ZENITHS,
    azimuths: int = AZIMUTHS,
) -> SkyIrradiance:
    """The hemispheric integral of sky radiance times the cosine of its zenith angle.

    Light scattered more than once is taken from the fluxes of `OrdinateLight` where the air has it.

    Parameters
    ----------
    air : SpectralAir
    altitude : (Z,) array
        m.
    source_elevation : (S,) array
        Geometric elevations of the source at those points, rad.
    zeniths, azimuths : int
        Directions of the quadrature.

    Returns
    -------
    SkyIrradiance
    """
    altitude, elevation = np.asarray(altitude, dtype=float), np.asarray(source_elevation, dtype=float)
    if not (elevation.size and air.scatters):
        thermal = _by_quadrature(air, altitude, np.zeros(0), zeniths, azimuths).thermal
        return SkyIrradiance(thermal, np.zeros((altitude.size, elevation.size, thermal.shape[1])))
    light = air.diffuse_light
    if isinstance(light, TwoStreamLight):
        return _by_quadrature(air, altitude, elevation, zeniths, azimuths)
    thermal = _by_quadrature(air, altitude, np.zeros(0), zeniths, azimuths).thermal
    direct = direct_transmittance(air.source_paths, altitude, elevation)
    forward = np.maximum(np.sin(elevation), 0.0)[:, None] * forward_scattered(air, altitude, elevation, direct)
    return SkyIrradiance(thermal, light.sky(altitude, elevation) + forward)


def _by_quadrature(
    air: SpectralAir, altitude: Floats, source_elevation: Floats, zeniths: int, azimuths: int
) -> SkyIrradiance:
    """Sky irradiance from radiances along lines of sight; arguments as `sky_irradiance`."""
    cosine, weight = _half_range(zeniths)
    node, node_weight = np.polynomial.legendre.leggauss(azimuths)
    azimuth, azimuth_weight = 0.5 * np.pi * (node + 1), np.pi * node_weight  # both halves: the weights sum to 2 pi
    rays = trace(air.shells, np.repeat(altitude, zeniths), np.tile(np.arcsin(cosine), altitude.size))
    sources = np.repeat(source_elevation, azimuths), np.tile(azimuth, source_elevation.size)
    to_source, deflection = source_cosine(rays, *sources), scattering_cosine(rays, *sources)
    points = air.optics.wavenumber.size
    thermal = np.zeros((altitude.size, points))
    scattered = np.zeros((altitude.size, source_elevation.size, points))
    # Particles scatter most within a few degrees of the source, which single directions of the quadrature would miss:
    # each takes the mean over its cell.
    phases = [_cell_phase(air.optics.phase, cell, source_elevation, azimuths) for cell in _cells(zeniths)]
    for row in range(altitude.size * zeniths):
        place, direction = divmod(row, zeniths)
        segments = Segments.of(rays, row)
        if not segments.index.size:
            continue
        depths = Depths(segments.column(air.optics.extinction))
        share = weight[direction] * cosine[direction]
        thermal[place] += 2 * np.pi * share * air.thermal_radiance(segments, depths).sum(axis=0)
        if not source_elevation.size:
            continue
        ends = segments.ends
        radiance = air.scattered_radiance(
            segments, depths, to_source[row, ends], deflection[row, ends], phases[direction]
        )
        by_azimuth = radiance.reshape(source_elevation.size, azimuths, -1)
        scattered[place] += share * np.einsum("sap,a->sp", by_azimuth, azimuth_weight)
    return SkyIrradiance(thermal, scattered)


def direct_transmittance(source_paths: SourcePaths, altitude: npt.ArrayLike, source_elevation: npt.ArrayLike) -> Floats:
    """Transmittance from a source to points.

    Parameters
    ----------
    source_paths : SourcePaths
    altitude : (Z,) array
        m.
    source_elevation : (S,) array
        Geometric, at those points, rad.

    Returns
    -------
    (Z, S, P) array
        0 where the Earth hides the source.
    """
    cosine = np.broadcast_to(np.sin(source_elevation), (np.size(altitude), np.size(source_elevation)))
    transmittance: Floats = np.exp(-source_paths.optical_depth(altitude, cosine).astype(float))
    return transmittance


def forward_scattered(air: SpectralAir, altitude: Floats, elevation: Floats, direct: Floats) -> Floats:
    """Light that particles have scattered straight forward, which delta scaling counts as beam, (Z, S, P).

    Parameters
    ----------
    air : SpectralAir
    altitude, elevation : (Z,), (S,) arrays
        As in `direct_transmittance`.
    direct : (Z, S, P) array
        Result of `direct_transmittance`.
    """
    if air.scaled_source_paths is air.source_paths:
        return np.zeros_like(direct)
    forward: Floats = np.maximum(direct_transmittance(air.scaled_source_paths, altitude, elevation) - direct, 0.0)
    return forward


def _cells(count: int) -> Floats:
    """Bounds (count, 2) of the cells of 0 to 1 around the nodes of `_half_range`: each is as wide as its weight."""
    edges = np.append(0.0, np.cumsum(_half_range(count)[1]))
    return np.stack([edges[:-1], edges[1:]], axis=1)


def _cell_phase(phase: Floats, cell: Floats, source_elevation: Floats, azimuths: int) -> Floats:
    """Phase function of particles, mean over the cells of one zenith angle.

    Parameters
    ----------
    phase : (A, N, C) array
        At `PHASE_ANGLES`.
    cell : (2,) array
        Bounds of the cosine of zenith angle.
    source_elevation : (S,) array
        rad.
    azimuths : int
        Of the quadrature.

    Returns
    -------
    (N, S * azimuths, C) array
    """
    part = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    cosine = cell[0] + (cell[1] - cell[0]) * part
    azimuth = np.pi * (_cells(azimuths)[:, :1] + np.diff(_cells(azimuths)) * part)[:, None]  # (azimuths, 1, samples)
    elevation = source_elevation[:, None, None, None]
    angle = np.sin(elevation) * cosine[:, None] + np.cos(elevation) * np.sqrt(1 - cosine**2)[:, None] * np.cos(azimuth)
    place = np.arccos(np.clip(angle, -1.0, 1.0)) / PHASE_ANGLES[1]
    place = place.reshape(source_elevation.size * azimuths, _SAMPLES**2)
    first = np.minimum(place.astype(int), PHASE_ANGLES.size - 2)
    index = first + np.arange(len(place))[:, None] * PHASE_ANGLES.size
    weight = np.zeros(len(place) * PHASE_ANGLES.size)
    np.add.at(weight, index, first + 1 - place)
    np.add.at(weight, index + 1, place - first)
    share = weight.reshape(len(place), PHASE_ANGLES.size) / _SAMPLES**2
    mean: Floats = np.einsum("sa,anc->nsc", share, phase, optimize=True)
    return mean


@lru_cache
def _half_range(count: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights on 0 to 1."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return 0.5 * (node + 1), 0.5 * weight
