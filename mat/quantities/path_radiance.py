"""In-band path radiance of a line of sight, and its ratio to the absorptance of the path, equation (10)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.mat.atmosphere.transfer.single_scattering import scattered_spectral
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.quantities.scattering_points import ScatteringPoints
from skyshine.schemas.arrays import Booleans, Floats, Reals

# Fraction of a line's length before the ground whose source function is continued behind the ground.
_LAST_PART = 0.03
# Molecules m^-2 of a short path in the air at the observer: any amount gives the same ratio, this one, a metre at the
# density of the ground, stays inside single precision.
_SHORT_PATH = 1e25


@dataclass(frozen=True, eq=False)
class PathLight:
    """In-band light of one kind along a line of sight.

    Attributes
    ----------
    along : (K+1, S) array
        Path radiance up to each segment end, W m^-2 sr^-1.
    limit : callable
        Of path radiance over absorptance for short ranges, (S,) [W m^-2 sr^-1]; in space that of the highest air.
    """

    along: Floats
    limit: Callable[[], Floats]

    def __add__(self, other: PathLight) -> PathLight:
        return PathLight(self.along + other.along, lambda: self.limit() + other.limit())

    def ratio(self, air: SpectralAir, band: BandPoints, path: LineOfSight, absorptance: Floats) -> Floats:
        """Path radiance over absorptance (R,) at each range, (R, S) [W m^-2 sr^-1]."""
        radiance, behind = self.along[path.node], path.beyond > 0
        if np.any(behind) and path.segments.index.size:
            absorptance = absorptance.copy()
            radiance[behind], absorptance[behind] = _behind_ground(air, band, path, behind, self.along)
        radiance /= np.where(absorptance > 0, absorptance, 1.0)[:, None]
        empty = absorptance <= 0
        if np.any(empty):
            radiance[empty] = self.limit()
        return radiance


def thermal_light(air: SpectralAir, band: BandPoints, path: LineOfSight) -> PathLight:
    """Light that the air emits, and that of it which particles scatter; S = 1."""
    along = np.zeros((path.segments.distance.size, 1))
    if path.segments.index.size:
        emitted = air.thermal_radiance(path.segments, path.segment_depths) @ band.radiance_weight
        np.cumsum(emitted, out=along[1:, 0])

    def limit() -> Floats:
        point = _short_path(path)
        extinction = point.column(air.optics.extinction)
        source = air.thermal.at(path.local_layer, path.local_share, -np.sin(path.elevation))
        return _over_absorptance((extinction * source) @ band.radiance_weight, extinction, band)

    return PathLight(along, limit)


def scattered_light(
    air: SpectralAir, band: BandPoints, path: LineOfSight, sources: LineSources, points: ScatteringPoints
) -> PathLight:
    """Light of each source alone, from some points of the band; other arguments as of `radiance_along`."""
    count, few = sources.elevation.size, points.air
    if not (count and air.scatters and np.any(points.weight > 0)):
        return PathLight(np.zeros((path.segments.distance.size, count)), lambda: np.zeros(count))
    along = np.zeros((path.segments.distance.size, count))
    if path.segments.index.size:
        to_source, deflection = sources.to_source(path.ends), sources.deflection(path.ends)
        along = few.scattered_in_band(path.segments, points.depths(path), to_source, deflection, points.weight)

    def limit() -> Floats:
        point, angle = _short_path(path), sources.local_deflection(path.elevation)
        light = direct_transmittance(few.scaled_source_paths, np.array([path.local_altitude]), sources.elevation)
        once = scattered_spectral(point, few.optics, light.astype(np.float32), np.stack([angle, angle]))
        once += light[0] * few.forward_peak.at(point, path.local_altitude, np.sin(sources.elevation), angle)
        again = few.diffuse_light.at(
            path.local_layer, path.local_share, -np.sin(path.elevation), np.sin(sources.elevation), angle
        )
        scattered = once + point.column(few.optics.extinction) * again
        return _over_absorptance(scattered @ points.weight, point.column(air.optics.extinction), band)

    return PathLight(along, limit)


def _short_path(path: LineOfSight) -> Segments:
    """A short path in the air at the observer."""
    ends, share = np.zeros(2), path.local_share
    amount = _SHORT_PATH * np.array([[1 - share], [share]])
    return Segments(np.zeros(1, int), np.array([path.local_layer]), amount[0], amount[1], ends, ends, ends, ends)


def _over_absorptance(light: Floats, extinction: Reals, band: BandPoints) -> Floats:
    """In-band light (S,) of a short path over the in-band mean of its depths (1, P)."""
    ratio: Floats = light / (extinction[0] @ band.weight / band.weight.sum())
    return ratio


def radiance_along(
    air: SpectralAir, band: BandPoints, path: LineOfSight, sources: LineSources, irradiance: Floats
) -> PathLight:
    """Path radiance, thermal and of each source.

    Parameters
    ----------
    air : SpectralAir
    band : BandPoints
    path : LineOfSight
        Through that air.
    sources : LineSources
        S of them.
    irradiance : (P,) array
        Of the source outside the atmosphere, W m^-2 (cm^-1)^-1.
    """
    points = ScatteringPoints.every(air, band, irradiance)
    return scattered_light(air, band, path, sources, points) + thermal_light(air, band, path)


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
