"""In-band path radiance of lines of sight, and its ratio to the absorptance of the path, equation (10)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.mat.atmosphere.transfer.single_scattering import scattered_spectral
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.quantities.joined_paths import JoinedPaths
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
    """In-band light of one kind along L joined lines of sight.

    Attributes
    ----------
    along : (K+1, S) array
        Path radiance from each line's observer up to each segment end, W m^-2 sr^-1.
    limit : callable
        Of the number of a line: path radiance over absorptance for short ranges, (S,) [W m^-2 sr^-1]; in space that of
        the highest air.
    """

    along: Floats
    limit: Callable[[int], Floats]

    def __add__(self, other: PathLight) -> PathLight:
        return PathLight(self.along + other.along, lambda line: self.limit(line) + other.limit(line))

    def ratio(self, air: SpectralAir, band: BandPoints, lines: JoinedPaths, absorptance: Floats) -> Floats:
        """Path radiance over absorptance (L, R) at each range, (L, R, S) [W m^-2 sr^-1]."""
        radiance = self.along[lines.node]
        behind = np.argwhere(lines.beyond > 0)
        if behind.size:
            absorptance = absorptance.copy()
            for line in np.unique(behind[:, 0]).tolist():
                path = lines.paths[line]
                if path.segments.index.size:
                    at = line, path.beyond > 0
                    along = self.along[lines.depths.first[line] :][: path.segments.distance.size]
                    radiance[at], absorptance[at] = _behind_ground(air, band, path, at[1], along)
        radiance /= np.where(absorptance > 0, absorptance, 1.0)[..., None]
        for line in np.flatnonzero(np.any(absorptance <= 0, axis=1)).tolist():
            radiance[line, absorptance[line] <= 0] = self.limit(line)
        return radiance


def thermal_light(air: SpectralAir, band: BandPoints, lines: JoinedPaths) -> PathLight:
    """Light that the air emits, and that of it which particles scatter; S = 1."""
    along: Floats = np.zeros((lines.segments.distance.size, 1))
    if lines.segments.index.size:
        emitted = air.thermal_radiance(lines.segments, lines.depths) @ band.radiance_weight
        along = lines.depths.summed(emitted[:, None]).astype(float, copy=False)

    def limit(line: int) -> Floats:
        path = lines.paths[line]
        point = _short_path(path)
        extinction = point.column(air.optics.extinction)
        source = air.thermal.at(path.local_layer, path.local_share, -np.sin(path.elevation))
        return _over_absorptance((extinction * source) @ band.radiance_weight, extinction, band)

    return PathLight(along, limit)


def scattered_light(
    air: SpectralAir, band: BandPoints, lines: JoinedPaths, sources: Sequence[LineSources], points: ScatteringPoints
) -> PathLight:
    """Light of each source alone, from some points of the band; other arguments as of `radiance_along`."""
    count, few = sources[0].elevation.size, points.air
    along = np.zeros((lines.segments.distance.size, count))
    if not (count and air.scatters and np.any(points.weight > 0)):
        return PathLight(along, lambda line: np.zeros(count))
    if lines.segments.index.size:
        to_source, deflection = (
            np.concatenate([angle(of_line, path.ends) for of_line, path in zip(sources, lines.paths, strict=True)])
            for angle in (LineSources.to_source, LineSources.deflection)
        )
        along = few.scattered_in_band(lines.segments, points.depths(lines.depths), to_source, deflection, points.weight)

    def limit(line: int) -> Floats:
        path, of_line = lines.paths[line], sources[line]
        point, angle = _short_path(path), of_line.local_deflection(path.elevation)
        light = direct_transmittance(few.scaled_source_paths, np.array([path.local_altitude]), of_line.elevation)
        once = scattered_spectral(point, few.optics, light.astype(np.float32), np.stack([angle, angle]))
        once += light[0] * few.forward_peak.at(point, path.local_altitude, np.sin(of_line.elevation), angle)
        again = few.diffuse_light.at(
            path.local_layer, path.local_share, -np.sin(path.elevation), np.sin(of_line.elevation), angle
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
    air: SpectralAir, band: BandPoints, lines: JoinedPaths, sources: Sequence[LineSources], irradiance: Floats
) -> PathLight:
    """Path radiance, thermal and of each source.

    Parameters
    ----------
    air : SpectralAir
    band : BandPoints
    lines : JoinedPaths
        L of them, through that air.
    sources : sequence of LineSources
        S of each line.
    irradiance : (P,) array
        Of the source outside the atmosphere, W m^-2 (cm^-1)^-1.
    """
    points = ScatteringPoints.every(air, band, irradiance)
    return scattered_light(air, band, lines, sources, points) + thermal_light(air, band, lines)


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
