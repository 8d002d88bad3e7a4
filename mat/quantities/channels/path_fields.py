"""Fields of the channel tables along lines of sight: mean extinction of absorbers, thermal and scattered light.

Path radiance of either kind is divided by what the same path gives with one source function at all points of the band:
sum over j of e_j (1 - exp(-D_j)). The quotient hardly changes with range, unlike the quotient with in-band absorptance,
which follows the lines of the band.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight, lines_of_sight
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.quantities.channels.end_heights import end_rise
from skyshine.mat.quantities.channels.nodes import ChannelNodes
from skyshine.mat.quantities.channels.parts import Parts
from skyshine.mat.quantities.joined_paths import JoinedPaths, in_groups
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.quantities.path_radiance import PathLight, scattered_light, thermal_light
from skyshine.mat.quantities.scattering_points import ScatteringPoints
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats

REFERENCE = 288.0  # K, of the black body whose spectrum thermal path radiance is divided by; that of no scene matters
_SHORTEST = 1e-9  # m of air at the observer, used in place of a range of 0
_FIRST = 1e-3  # m of air, used in place of a range of 0 where light is divided by what it is of black air
LEAST_EXTINCTION = 1e-12  # km^-1


@dataclass(frozen=True, eq=False)
class BandLight:
    """Spectra, at the P points of a band, that path radiance is divided by.

    Attributes
    ----------
    thermal : (P,) array
        Radiance of a black body at `REFERENCE`, by the points' radiance weights, W m^-2 sr^-1.
    source : (P,) array
        Irradiance of the source outside the atmosphere, likewise; its sum is 1, or all are 0.
    scattering : ScatteringPoints
        Points at which scattered light of the source is computed.
    """

    thermal: Floats
    source: Floats
    scattering: ScatteringPoints

    @classmethod
    def of(cls, atmosphere: BandAtmosphere, irradiance: Floats) -> BandLight:
        """For a prepared band and the irradiance (P,) of a source [W m^-2 (cm^-1)^-1]."""
        weight = atmosphere.band.radiance_weight
        source = weight * irradiance
        total = source.sum()
        thermal = weight * planck_wavenumber(atmosphere.band.wavenumber, REFERENCE)
        points = ScatteringPoints.every(atmosphere.air, atmosphere.band, irradiance)
        return cls(thermal, source / total if total > 0 else source, points)

    def at_few_points(self, rows: Floats, allowed: float) -> BandLight:
        """With scattered light at the fewest points that give it on sample lines, of `light_of_lines`, within an error
        [W m^-2 sr^-1], root mean square; without any where it is fainter than that.
        """
        chosen = self.scattering.fewest(rows, allowed)
        return replace(self, scattering=chosen, source=self.source if chosen.index.size else np.zeros_like(self.source))


def light_of_lines(atmosphere: BandAtmosphere, lines: Iterable[tuple[LineOfSight, LineSources]]) -> Floats:
    """Scattered light (n, P) along lines under sources, per unit of their irradiance, sr^-1."""
    light = [
        atmosphere.air.scattered_light.along(
            path.segments, path.segment_depths, sources.to_source(path.ends), sources.deflection(path.ends)
        )[0]
        for path, sources in lines
        if path.segments.index.size
    ]
    return np.concatenate(light).astype(float) if light else np.zeros((0, atmosphere.band.weight.size))


@dataclass(frozen=True, eq=False)
class PathFields:
    """Fields on the nodes.

    Attributes
    ----------
    extinction : (R, X, Z, U) array
        Mean extinction of the absorbers to each node, km^-1.
    thermal : (X, Z, U) array
        Thermal path radiance over the reference's.
    scattered : (K, X, Z, U) array
        Scattered path radiance over the reference's, for K directions of the source, W m^-2 sr^-1.
    end_rise : (X, Z, U) array
        Height of the end of the path above that of a straight line, over the range.
    """

    extinction: Floats
    thermal: Floats
    scattered: Floats
    end_rise: Floats


def depth_of(atmosphere: BandAtmosphere, lines: JoinedPaths) -> Floats:
    """Optical depth (L, R, P) to each range of L lines, behind the ground as through the air above it; above 0 at a
    range of 0.
    """
    air = atmosphere.air
    depth = lines.depth + lines.beyond[..., None] * (air.shells.number_density[0] * air.optics.extinction[0])
    local = np.stack([path.local_extinction for path in lines.paths])[:, None]
    depth_above_0: Floats = np.maximum(depth, _SHORTEST * local)
    return depth_above_0


@dataclass(frozen=True, eq=False)
class LightOver:
    """What path radiance of L lines is divided by.

    Attributes
    ----------
    depth : (L, R, P) array
        Optical depth from `depth_of`.
    """

    atmosphere: BandAtmosphere
    lines: JoinedPaths
    depth: Floats

    @classmethod
    def of(cls, atmosphere: BandAtmosphere, lines: JoinedPaths) -> LightOver:
        """Fields of the lines of a prepared band."""
        return cls(atmosphere, lines, depth_of(atmosphere, lines))

    @cached_property
    def absorbed(self) -> Floats:
        """1 - exp(-depth), (L, R, P)."""
        absorbed: Floats = -np.expm1(-self.depth)
        return absorbed

    @cached_property
    def _absorptances(self) -> tuple[Floats, Floats]:
        """In-band absorptance (L, R) of the depths, and of those to the ground alone."""
        share = self.atmosphere.band.weight / self.atmosphere.band.weight.sum()
        return self.absorbed @ share, -np.expm1(-self.lines.depth) @ share

    def over(self, light: PathLight, reference: Floats) -> Floats:
        """Path radiance (L, R, S) of one kind over that of a source function e_j (P,) at all points alike, with its
        limit at a range of 0.
        """
        absorptance, to_ground = self._absorptances
        ratio = light.ratio(self.atmosphere.air, self.atmosphere.band, self.lines, to_ground)
        divisor = self.absorbed @ reference
        over: Floats = ratio * (absorptance / np.where(divisor > 0, divisor, np.inf))[..., None]
        return over

    def scattered(self, sources: Sequence[LineSources], light: BandLight) -> Floats:
        """Path radiance (L, R, S) of a source's light alone over the reference's."""
        atmosphere = self.atmosphere
        scattered = scattered_light(atmosphere.air, atmosphere.band, self.lines, sources, light.scattering)
        return np.maximum(self.over(scattered, light.source), 0.0)


def path_fields(
    atmosphere: BandAtmosphere,
    rays: RayCoordinates,
    nodes: ChannelNodes,
    absorbers: Parts,
    light: BandLight,
    source_elevation: Floats,
    scattering_angle: Floats,
    other_source: PathFields | None = None,
) -> PathFields:
    """Compute the fields.

    Parameters
    ----------
    absorbers : Parts
        Absorbers of the band's points.
    source_elevation, scattering_angle : (K,) arrays
        Directions of the source, rad.
    other_source : PathFields, optional
        Fields under another source, which share everything but scattered light.
    """
    atmosphere.air.prepare()
    scattered = np.empty((source_elevation.size, *nodes.shape))
    if other_source is not None:
        extinction, thermal, rise = other_source.extinction, other_source.thermal, other_source.end_rise
        if not source_elevation.size:
            return PathFields(extinction, thermal, scattered, rise)
    else:
        extinction, thermal = np.empty((absorbers.count, *nodes.shape)), np.empty(nodes.shape)
        rise = np.empty(nodes.shape)
    groups = list(in_groups(nodes.direction.size, source_elevation.size))

    def at_height(level: int) -> None:
        root = float(nodes.height_root[level])
        lines = [rays.line(root, float(direction), nodes.share) for direction in nodes.direction]
        paths = list(_paths(atmosphere, rays, root, lines))
        for group in groups:
            at = slice(None), slice(None), level, group
            reference = LightOver.of(atmosphere, JoinedPaths.of(paths[group]))
            if source_elevation.size:
                sources = [
                    LineSources.at_angle(path.elevation, source_elevation, scattering_angle) for path in paths[group]
                ]
                scattered[at] = reference.scattered(sources, light).T
            if other_source is None:
                emitted = thermal_light(atmosphere.air, atmosphere.band, reference.lines)
                thermal[at[1:]] = reference.over(emitted, light.thermal)[..., 0].T
                length = np.stack([of_line for _, _, of_line in lines[group]])
                extinction[at] = _mean_extinction(reference, absorbers, length).T
        for row, path in enumerate(paths if other_source is None else ()):
            rise[:, level, row] = end_rise(rays, root, lines[row][0], path)

    parallel_map(at_height, range(nodes.height_root.size))
    return PathFields(extinction, thermal, scattered, rise)


def _mean_extinction(reference: LightOver, absorbers: Parts, length: Floats) -> Floats:
    """Mean extinction (L, X, R) [km^-1] of the absorbers along L lines, for the lengths (L, X) [km] of their shares."""
    index, away = absorbers.index, length[..., None] > 0
    local = np.stack([path.local_extinction[index] for path in reference.lines.paths])[:, None] * 1e3
    mean = np.where(away, reference.depth[..., index] / np.where(away, length[..., None], 1.0), local)
    extinction: Floats = np.maximum(mean, LEAST_EXTINCTION)
    return extinction


def _paths(
    atmosphere: BandAtmosphere, rays: RayCoordinates, root: float, lines: list[tuple[float, Floats, Floats]]
) -> Iterator[LineOfSight]:
    ranges = np.stack([line[1] for line in lines]) * 1e3
    if ranges.shape[1] > 1:  # the ratio at a range of 0 is that of a short path
        ranges[:, 0] = np.maximum(ranges[:, 0], np.minimum(_FIRST, 0.5 * ranges[:, 1]))
    altitude = np.full(len(lines), (rays.ground_km + root**3) * 1e3)
    return lines_of_sight(atmosphere.air, ranges, altitude, np.radians([line[0] for line in lines]))
