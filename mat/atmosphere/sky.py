"""Irradiance of a horizontal surface by the sky, and by Sun or Moon directly, at any altitude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere import transfer
from skyshine.mat.atmosphere.geometry import scattering_cosine, source_cosine, trace

# Directions of the hemisphere: Gauss nodes in the cosine of zenith angle, and in azimuth over half a turn (the other half
# mirrors it). Against 48 x 48: thermal to 2e-4, scattered light to 2 %, to 5 % with the source in the zenith.
ZENITHS, AZIMUTHS = 8, 8


@dataclass(frozen=True, eq=False)
class SkyIrradiance:
    """Downwelling diffuse irradiance at Z altitudes and P points.

    Attributes
    ----------
    thermal : (Z, P) array
        Emitted by the air, W m^-2 (cm^-1)^-1.
    scattered : (Z, S, P) array
        Scattered light of a source at each of S elevations, per unit of its irradiance normal to the beam outside the atmosphere.
    """

    thermal: np.ndarray
    scattered: np.ndarray


def sky_irradiance(air, altitude, source_elevation, *, zeniths=ZENITHS, azimuths=AZIMUTHS):
    """The hemispheric integral of sky radiance times the cosine of its zenith angle.

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
    elevations = np.repeat(source_elevation, azimuths)
    turns = np.tile(turn, source_elevation.size)

    rays = trace(air.shells, np.repeat(altitude, zeniths), np.tile(np.arcsin(cosine), altitude.size))
    to_source = source_cosine(rays, elevations, turns)
    deflection = scattering_cosine(rays, elevations, turns)
    thermal = np.zeros((altitude.size, optics.wavenumber.size))
    scattered = np.zeros((altitude.size, source_elevation.size, optics.wavenumber.size))
    for row in range(altitude.size * zeniths):
        place, direction = divmod(row, zeniths)
        segments = transfer.Segments.of(rays, row)
        if not segments.index.size:
            continue
        depth = segments.column(optics.extinction)
        share = weight[direction] * cosine[direction]
        thermal[place] += 2 * np.pi * share * air.thermal_radiance(segments, depth)[-1]
        if not elevations.size:
            continue
        ends = np.append(segments.index, segments.index[-1] + 1)
        radiance = air.scattered_radiance(segments, depth, to_source[row, ends], deflection[row, ends])
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


def _half_range(count):
    """Gauss-Legendre nodes and weights on 0 to 1."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return 0.5 * (node + 1), 0.5 * weight
