"""Irradiance of a horizontal surface by the sky, and by Sun or Moon directly, at any altitude."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import trace
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.schemas.arrays import Floats

_TOGETHER = 4  # altitudes whose lines are computed together
# Directions of the hemisphere: Gauss nodes in the cosine of zenith angle; against 24, thermal radiation to 2e-4.
ZENITHS = 8


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
    air: SpectralAir, altitude: npt.ArrayLike, source_elevation: npt.ArrayLike, *, zeniths: int = ZENITHS
) -> SkyIrradiance:
    """The hemispheric integral of sky radiance times the cosine of its zenith angle.

    Thermal radiation is summed along lines of sight; light of a source is the flux of its field.

    Parameters
    ----------
    altitude : (Z,) array
        m.
    source_elevation : (S,) array
        Geometric elevations of the source at those points, rad.
    zeniths : int
        Directions of the quadrature.
    """
    altitude, elevation = np.asarray(altitude, dtype=float), np.asarray(source_elevation, dtype=float)
    thermal = _thermal(air, altitude, zeniths)
    if not (elevation.size and air.scatters):
        return SkyIrradiance(thermal, np.zeros((altitude.size, elevation.size, thermal.shape[1])))
    direct = direct_transmittance(air.source_paths, altitude, elevation)
    forward = np.maximum(np.sin(elevation), 0.0)[:, None] * forward_scattered(air, altitude, elevation, direct)
    return SkyIrradiance(thermal, air.diffuse_light.sky(altitude, elevation) + forward)


def zenith_angles(zeniths: int = ZENITHS) -> tuple[float, ...]:
    """Angles from the vertical, rad, decreasing, at which radiation comes down along the quadrature's directions."""
    return tuple(np.arccos(-_half_range(zeniths)[0]).tolist())


def _thermal(air: SpectralAir, altitude: Floats, zeniths: int) -> Floats:
    """Thermal sky irradiance (Z, P) from radiances along lines of sight."""
    cache = air.thermal_skies
    missing = np.unique([height for height in altitude.tolist() if (height, zeniths) not in cache])
    for start in range(0, missing.size, _TOGETHER):
        heights = missing[start : start + _TOGETHER]
        for height, irradiance in zip(heights.tolist(), _thermal_at(air, heights, zeniths), strict=True):
            cache[height, zeniths] = irradiance
    return np.stack([cache[height, zeniths] for height in altitude.tolist()])


def _thermal_at(air: SpectralAir, altitude: Floats, zeniths: int) -> Floats:
    """`_thermal` of few altitudes, whose lines of sight are joined."""
    cosine, weight = _half_range(zeniths)
    rays = trace(air.shells, np.repeat(altitude, zeniths), np.tile(np.arcsin(cosine), altitude.size))
    segments, starts = Segments.joined([Segments.of(rays, row) for row in range(altitude.size * zeniths)])
    if not segments.index.size:
        return np.zeros((altitude.size, air.optics.wavenumber.size))
    depths = Depths(segments.column(air.optics.extinction), starts)
    radiance = depths.summed(air.thermal_radiance(segments, depths))[np.append(starts[1:], segments.altitude.size) - 1]
    thermal: Floats = 2 * np.pi * (weight * cosine) @ radiance.reshape(altitude.size, zeniths, -1)
    return thermal


def direct_transmittance(source_paths: SourcePaths, altitude: npt.ArrayLike, source_elevation: npt.ArrayLike) -> Floats:
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
    transmittance: Floats = np.exp(-source_paths.optical_depth(altitude, cosine).astype(float))
    return transmittance


def forward_scattered(air: SpectralAir, altitude: Floats, elevation: Floats, direct: Floats) -> Floats:
    """Light that particles have scattered straight forward, which delta scaling counts as beam, (Z, S, P).

    Parameters
    ----------
    altitude, elevation : (Z,), (S,) arrays
        Altitudes and elevations as in `direct_transmittance`.
    direct : (Z, S, P) array
        Result of `direct_transmittance`.
    """
    if air.scaled_source_paths is air.source_paths:
        return np.zeros_like(direct)
    forward: Floats = np.maximum(direct_transmittance(air.scaled_source_paths, altitude, elevation) - direct, 0.0)
    return forward


@lru_cache
def _half_range(count: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights on 0 to 1."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return 0.5 * (node + 1), 0.5 * weight
