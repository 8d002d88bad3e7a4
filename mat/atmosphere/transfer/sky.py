"""Irradiance of a horizontal surface by the sky, and by Sun or Moon directly, at any altitude."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skyshine.mat.atmosphere.transfer import segments as transfer
from skyshine.mat.atmosphere.transfer.geometry import scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES

# Directions of the hemisphere: Gauss nodes in the cosine of zenith angle, and in azimuth over half a turn (the other
# half mirrors it). Against 24 x 24: thermal to 2e-4, scattered light to 0.6 % rms, 2 % with the source in the zenith;
# more azimuths change less than that, for the cells below take most of it.
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

    thermal: np.ndarray
    scattered: np.ndarray


def sky_irradiance(air, altitude, source_elevation, *, zeniths=ZENITHS, azimuths=AZIMUTHS):
    """The hemispheric integral of sky radiance times the cosine of its zenith angle; scattered light of `streams` has
    its own.

    Parameters
    ----------
    air : air.SpectralAir
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
    optics = air.optics
    cosine, weight = _half_range(zeniths)
    turn, turn_weight = np.polynomial.legendre.leggauss(azimuths)
    turn, turn_weight = 0.5 * np.pi * (turn + 1), np.pi * turn_weight  # both halves: the weights sum to 2 pi
    altitude, source_elevation = np.asarray(altitude, dtype=float), np.asarray(source_elevation, dtype=float)
    if source_elevation.size and not air.scatters:
        thermal = sky_irradiance(air, altitude, np.zeros(0), zeniths=zeniths).thermal
        return SkyIrradiance(thermal, np.zeros((altitude.size, source_elevation.size, thermal.shape[1])))
    if air.streams and source_elevation.size:
        thermal = sky_irradiance(air, altitude, np.zeros(0), zeniths=zeniths).thermal
        direct = direct_transmittance(air.source_paths, altitude, source_elevation)
        ahead = np.maximum(np.sin(source_elevation), 0.0)[:, None] * thrown_ahead(
            air, altitude, source_elevation, direct
        )
        return SkyIrradiance(thermal, air.diffuse_light.sky(altitude, source_elevation) + ahead)
    elevations = np.repeat(source_elevation, azimuths)
    turns = np.tile(turn, source_elevation.size)

    rays = trace(air.shells, np.repeat(altitude, zeniths), np.tile(np.arcsin(cosine), altitude.size))
    to_source = source_cosine(rays, elevations, turns)
    deflection = scattering_cosine(rays, elevations, turns)
    thermal = np.zeros((altitude.size, optics.wavenumber.size))
    scattered = np.zeros((altitude.size, source_elevation.size, optics.wavenumber.size))
    # Particles scatter most within a few degrees of the source, which nodes miss or hit: each takes the mean over its
    # cell.
    phases = [_cell_phase(optics.phase, cell, source_elevation, azimuths) for cell in _cells(zeniths)]
    for row in range(altitude.size * zeniths):
        place, direction = divmod(row, zeniths)
        segments = transfer.Segments.of(rays, row)
        if not segments.index.size:
            continue
        depths = transfer.Depths(segments.column(optics.extinction))
        share = weight[direction] * cosine[direction]
        thermal[place] += 2 * np.pi * share * air.thermal_radiance(segments, depths).sum(axis=0)
        if not elevations.size:
            continue
        ends = np.append(segments.index, segments.index[-1] + 1)
        radiance = air.scattered_radiance(
            segments, depths, to_source[row, ends], deflection[row, ends], phases[direction]
        )
        by_turn = radiance.reshape(source_elevation.size, azimuths, -1)
        scattered[place] += share * np.einsum("sap,a->sp", by_turn, turn_weight)
    return SkyIrradiance(thermal, scattered)


def direct_transmittance(source_paths, altitude, source_elevation):
    """Transmittance from a source to points.

    Parameters
    ----------
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
    return np.exp(-source_paths.optical_depth(altitude, cosine).astype(float))


def thrown_ahead(air, altitude, elevation, direct):
    """Light that delta scaling counts as beam, but which particles have scattered, (Z, S, P).

    Parameters
    ----------
    air : air.SpectralAir
    altitude, elevation : (Z,), (S,) arrays
        As `direct_transmittance`.
    direct : (Z, S, P) array
        What that gives.
    """
    if air.scaled_source_paths is air.source_paths:
        return np.zeros_like(direct)
    return np.maximum(direct_transmittance(air.scaled_source_paths, altitude, elevation) - direct, 0.0)


def _cells(count):
    """Bounds (count, 2) of the cells of 0 to 1 that the nodes of `_half_range` stand for: each is as wide as its
    weight.
    """
    edges = np.append(0.0, np.cumsum(_half_range(count)[1]))
    return np.stack([edges[:-1], edges[1:]], axis=1)


def _cell_phase(phase, cell, source_elevation, azimuths):
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
    turn = np.pi * (_cells(azimuths)[:, :1] + np.diff(_cells(azimuths)) * part)[:, None]  # (azimuths, 1, samples)
    elevation = source_elevation[:, None, None, None]
    angle = np.sin(elevation) * cosine[:, None] + np.cos(elevation) * np.sqrt(1 - cosine**2)[:, None] * np.cos(turn)
    place = np.arccos(np.clip(angle, -1.0, 1.0)) / PHASE_ANGLES[1]
    place = place.reshape(source_elevation.size * azimuths, _SAMPLES**2)
    first = np.minimum(place.astype(int), PHASE_ANGLES.size - 2)
    index = first + np.arange(len(place))[:, None] * PHASE_ANGLES.size
    weight = np.zeros(len(place) * PHASE_ANGLES.size)
    np.add.at(weight, index, first + 1 - place)
    np.add.at(weight, index + 1, place - first)
    return np.einsum("sa,anc->nsc", weight.reshape(len(place), PHASE_ANGLES.size) / _SAMPLES**2, phase, optimize=True)


@lru_cache
def _half_range(count):
    """Gauss-Legendre nodes and weights on 0 to 1."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return 0.5 * (node + 1), 0.5 * weight
