"""In-band path radiance of a line of sight, and its ratio to the absorptance of the path, equation (10)."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.mat.atmosphere.transfer.single_scattering import scattered_spectral
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.atmosphere.transfer.thermal_source import tilt_weight
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.schemas.arrays import Booleans, Floats, Reals

# Fraction of a line's length before the ground whose source function is continued behind the ground.
_LAST_PART = 0.03
# Molecules m^-2 of a short path in the air at the observer: any amount gives the same ratio, this one, a metre at the
# density of the ground, stays inside single precision.
_SHORT_PATH = 1e25


def radiance_along(
    air: SpectralAir, band: BandPoints, path: LineOfSight, sources: LineSources, irradiance: Floats
) -> Floats:
    """In-band path radiance up to each segment end, for each source.

    Parameters
    ----------
    air : SpectralAir
    band : BandPoints
    path : LineOfSight
        Through that air.
    sources : LineSources
    irradiance : (P,) array
        Of the source outside the atmosphere, W m^-2 (cm^-1)^-1.

    Returns
    -------
    (K+1, S) array
        W m^-2 sr^-1.
    """
    segments = path.segments
    total = np.zeros((segments.distance.size, sources.elevation.size))
    if segments.index.size:
        thermal = air.thermal_radiance(segments, path.segment_depths) @ band.radiance_weight
        total[1:] += np.cumsum(thermal)[:, None]
        if air.scatters and np.any(irradiance > 0):
            weight = band.radiance_weight * irradiance
            to_source, deflection = sources.to_source(path.ends), sources.deflection(path.ends)
            total += air.scattered_in_band(segments, path.segment_depths, to_source, deflection, weight)
    return total


def path_radiance_ratio(
    air: SpectralAir,
    band: BandPoints,
    path: LineOfSight,
    sources: LineSources,
    irradiance: Floats,
    absorptance: Floats,
) -> Floats:
    """Path radiance over absorptance at each range, (R, S) [W m^-2 sr^-1], with its limit where nothing is absorbed.

    Parameters
    ----------
    air, band, path, sources, irradiance
        As `radiance_along`.
    absorptance : (R,) array
        1 - in-band transmittance to each range.
    """
    along = radiance_along(air, band, path, sources, irradiance)
    radiance, behind = along[path.node], path.beyond > 0
    if np.any(behind) and path.segments.index.size:
        absorptance = absorptance.copy()
        radiance[behind], absorptance[behind] = _behind_ground(air, band, path, behind, along)
    radiance /= np.where(absorptance > 0, absorptance, 1.0)[:, None]
    empty = absorptance <= 0
    if np.any(empty):
        radiance[empty] = _short_path_limit(air, band, path, sources, irradiance)
    return radiance


def _behind_ground(
    air: SpectralAir, band: BandPoints, path: LineOfSight, behind: Booleans, along: Floats
) -> tuple[Floats, Floats]:
    """Path radiance (B, S) and absorptance (B,) at the ranges behind the ground.

    The line continues as for beta*, through air as bright as that before the ground, so that the ratio of the two is
    continuous at the ground.
    """
    end, weight, total = path.node[behind][0], band.weight, band.weight.sum()
    distance = path.segments.distance
    start = int(np.clip(np.searchsorted(distance, distance[end] * (1 - _LAST_PART)) - 1, 0, max(end - 1, 0)))
    before, ground = mean_transmittance(path.segment_depths.cumulative[[start, end]], weight, total)[1]
    absorptance = mean_transmittance(path.depth[behind] + path.depth_behind(air)[behind], weight, total)[1]
    increase = ground - before
    if increase > 1e-6 * ground:
        slope = (along[end] - along[start]) / increase
    else:
        slope = along[end] / ground if ground > 0 else np.zeros_like(along[end])
    return along[end] + np.maximum(absorptance - ground, 0.0)[:, None] * slope, absorptance


def _short_path_limit(
    air: SpectralAir, band: BandPoints, path: LineOfSight, sources: LineSources, irradiance: Floats
) -> Floats:
    """Limit (S,) of path radiance over absorptance for short ranges; in space that of the highest air."""
    layer, share, optics = path.local_layer, path.local_share, air.optics

    def local(values: Reals) -> Reals:
        between: Reals = values[layer] * (1 - share) + values[layer + 1] * share
        return between

    deflection = sources.local_deflection(path.elevation)
    ends = np.zeros(2)
    amount = _SHORT_PATH * np.array([[1 - share], [share]])
    point = Segments(np.zeros(1, int), np.array([layer]), amount[0], amount[1], ends, ends, ends, ends)
    extinction = point.column(optics.extinction)[0]
    upward_cosine = -np.sin(path.elevation)
    thermal = local(air.thermal.mean) + tilt_weight(upward_cosine) * local(air.thermal.tilt)
    source = np.broadcast_to(extinction * thermal, (deflection.size, extinction.size))
    if air.scatters:
        light = direct_transmittance(air.scaled_source_paths, np.array([path.local_altitude]), sources.elevation)
        once = scattered_spectral(point, optics, light.astype(np.float32), np.stack([deflection, deflection]))
        again = air.diffuse_light.at(layer, share, upward_cosine, np.sin(sources.elevation), deflection)
        source = source + (once + extinction * again) * irradiance
    limit: Floats = source @ band.radiance_weight / (extinction @ band.weight / band.weight.sum())
    return limit
