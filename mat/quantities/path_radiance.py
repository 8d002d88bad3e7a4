"""In-band path radiance of lines of sight, and its ratio to the absorptance of the path, equation (10)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.quantities.joined_paths import JoinedPaths
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.quantities.scattering_points import ScatteringPoints
from skyshine.schemas.arrays import Booleans, Floats

# Fraction of a line's length before the ground whose source function is continued behind the ground.
_LAST_PART = 0.03
# Largest optical depth of a short path in the air at the observer: light and absorptance are proportional to it.
_SHORT_PATH = 1e-6
_LEAST_SECTION = 1e-40  # m^2 per molecule, in air that absorbs nothing


@dataclass(frozen=True, eq=False)
class PathLight:
    """In-band light of one kind along L joined lines of sight.

    Attributes
    ----------
    along : (K+1, S) array
        Path radiance from each line's observer up to each segment end, W m^-2 sr^-1.
    limit : callable
        Function of the number of a line: path radiance over absorptance for short ranges, (S,) [W m^-2 sr^-1]; in space
        that of the highest air.
    """

    along: Floats
    limit: Callable[[int], Floats]

    def __add__(self, light: PathLight) -> PathLight:
        return PathLight(self.along + light.along, lambda line: self.limit(line) + light.limit(line))

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
                    along = self.along[lines.depths.starts[line] :][: path.segments.distance.size]
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
        point, depths = _short_path(air, path)
        return _over_absorptance(air.thermal_radiance(point, depths)[0] @ band.radiance_weight, depths, band)

    return PathLight(along, limit)


def scattered_light(
    air: SpectralAir, band: BandPoints, lines: JoinedPaths, sources: Sequence[LineSources], points: ScatteringPoints
) -> PathLight:
    """Light of each source alone, from some points of the band; other arguments as of `radiance_along`."""
    count, reduced_air = sources[0].elevation.size, points.air
    along = np.zeros((lines.segments.distance.size, count))
    if not (count and air.scatters and np.any(points.weight > 0)):
        return PathLight(along, lambda line: np.zeros(count))
    if lines.segments.index.size:
        to_source, deflection = (
            np.concatenate([angle(of_line, path.ends) for of_line, path in zip(sources, lines.paths, strict=True)])
            for angle in (LineSources.to_source, LineSources.deflection)
        )
        along = reduced_air.scattered_light.in_band(
            lines.segments, points.depths(lines.depths), to_source, deflection, points.weight
        )

    def limit(line: int) -> Floats:
        of_line = sources[line]
        point, depths = _short_path(air, lines.paths[line])
        to_source = np.tile(np.sin(of_line.elevation), (2, 1))
        deflection = np.tile(of_line.local_deflection(lines.paths[line].elevation), (2, 1))
        light = reduced_air.scattered_light.in_band(point, points.depths(depths), to_source, deflection, points.weight)
        return _over_absorptance(light[1], depths, band)

    return PathLight(along, limit)


def _short_path(air: SpectralAir, path: LineOfSight) -> tuple[Segments, Depths]:
    """A short path in the air at the observer and its optical depth."""
    share, layer = path.local_share, np.array([path.local_layer])
    extinction = air.optics.extinction[path.local_layer :][:2].max()
    amount = _SHORT_PATH / max(extinction, _LEAST_SECTION) * np.array([[1 - share], [share]])
    ends = (np.full(2, value) for value in (path.local_altitude, 0.0, np.pi / 2 - path.elevation, 0.0))
    segments = Segments(np.zeros(1, int), layer, *amount, *ends)
    return segments, Depths(segments.column(air.optics.extinction))


def _over_absorptance(light: Floats | float, depths: Depths, band: BandPoints) -> Floats:
    """In-band light (S,) of a short path over the in-band mean of its depths (1, P)."""
    ratio: Floats = light / (depths.per_segment[0] @ band.weight / band.weight.sum())
    return np.atleast_1d(ratio)


def radiance_along(
    air: SpectralAir, band: BandPoints, lines: JoinedPaths, sources: Sequence[LineSources], irradiance: Floats
) -> PathLight:
    """Path radiance, thermal and of each source.

    Parameters
    ----------
    lines : JoinedPaths
        L of them, through that air.
    sources : sequence of LineSources
        S of each line.
    irradiance : (P,) array
        Irradiance of the source outside the atmosphere, W m^-2 (cm^-1)^-1.
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
