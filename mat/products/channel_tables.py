"""The tables in channels of one state, band and source."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.scene_lines import lines_in_cells
from skyshine.mat.measure.channel_nodes import WORST, PlacedChannels, largest_errors, placed_channels
from skyshine.mat.measure.probes import LINES, Probes
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.scale import Scale
from skyshine.mat.products.channel_start import FEWEST, channel_nodes
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.quantities.channels.end_heights import largest_change_of_beam
from skyshine.mat.quantities.channels.nodes import ChannelNodes, NodeCounts, elevation_nodes
from skyshine.mat.quantities.channels.parts import Parts, absorbers
from skyshine.mat.quantities.channels.path_fields import BandLight, PathFields, light_of_lines, path_fields
from skyshine.mat.quantities.channels.source_parts import (
    SKY_ELEVATIONS,
    SourceParts,
    all_directions,
    at_other_nodes,
    leading_parts,
    sampled_radiance,
    source_parts,
    telling_lines,
)
from skyshine.mat.quantities.channels.surface_light import EmittedLight, SurfaceLight, surface_light
from skyshine.mat.quantities.channels.wavelength_shares import PartedLight, SamplePaths, WavelengthShares
from skyshine.mat.quantities.grid import PathGrid, lines_of_sight
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.channels import ChannelContent, channel_group
from skyshine.mat.tables.night import dark_elevation
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.hdf5 import Group

_SAMPLE_LINES = 150  # on which absorbers are fitted
# On which directions of the source are chosen: lines of observers below and from above this height [km], where a source
# below the horizon lights the air down to another angle at each height; ranges of each line.
_SOURCE_LINES, _HIGH_KM, _SOURCE_RANGES = (54, 150), 15.0, 7
_LEVEL_SHARE = 0.25  # fraction of those, nearly level
_FACTOR_SHARE = 0.5  # fraction of those, by which factors at other nodes are fitted
_MOST_EFFORT = 3.0  # times as many lines, at most, where the tolerance is finer than `_START`
# Number of the lines on which nodes are placed, with sky light, which hardly depends on them.
_SKY_LINES, _FEWEST_SKY_LINES = 12, 4
_THROUGH = 300  # number of the sample's transmittances, with which light on surfaces is parted
# Shares of the tolerance, which the choice of absorbers and that of directions may miss, root mean square. A low Sun
# along the horizon errs by ten times as much as all lines do on average: 0.3 K asks for 17 directions.
_SHARE, _SOURCE_SHARE = 0.1, 0.03
_DIGITS_SHARE = 0.2  # fraction of the tolerance, below which digits of what a reader interpolates are not stored
# Tolerance, of the radiance seen, for which placing starts from all of `NodeCounts`: from fewer where it is coarser, as
# linear interpolation errs with the square of the step, but for `FEWEST` of them.
_START = 0.01
_POINT_LINES, _POINT_SOURCES = 60, 4  # on which points for scattered light are chosen; source directions of each
_LEVEL, _LOW_SOURCE, _ANY_SOURCE = (-2.0, 2.0), (-4.0, 6.0), (-6.0, 90.0)  # degree
# Shares of the tolerance, which these points may miss, root mean square: those of tables, and those of direct
# computation.
_POINT_SHARE, _TRUTH_SHARE = 0.03, 0.01
_SHARE_LINES = 120  # on which light is parted by wavelength
_SHARE_ELEVATIONS = (2.0, 90.0)  # source there, degree: lower down its light is faint in the blue alone
_LIGHT_SHARE = 0.1  # fraction of the tolerance, which light on surfaces may miss at most
_END_LINES = 100  # on which the heights of the ends of paths are compared
_LEVEL_LINES = 30  # along the horizon, on which nodes that states share are tried in each


@dataclass(frozen=True, eq=False)
class SharedNodes:
    """What the tables of several states share.

    Attributes
    ----------
    sources : SourceParts
        Light sources on the nodes' elevations and scattering angles.
    """

    nodes: ChannelNodes
    sources: SourceParts


@dataclass(frozen=True, eq=False)
class ChannelTables:
    """What the tables of one state, band and source in channels are built from.

    Attributes
    ----------
    base : PathGrid
        The job's axes: their ends, and by their cells how random points lie.
    irradiance : (P,) array
    scale : Scale
        Units in which the tolerance applies.
    all_points : pair of SpectralAir and PartedLight
        Air and light at all spectral points of the band.
    wavelength : (B,) array
        Wavelengths in the band by which light is divided [um].
    """

    air: BandAtmosphere
    base: PathGrid
    irradiance: Floats
    scale: Scale
    tolerance: float
    harmonics: int
    seed: int
    all_points: tuple[SpectralAir, PartedLight]
    wavelength: Floats

    @cached_property
    def _light(self) -> BandLight:
        return self._light_within(_POINT_SHARE)

    def _light_within(self, share: float) -> BandLight:
        """Scattered light at the fewest points that miss so much of the tolerance, root mean square."""
        scattered = self.irradiance if self.air.air.scatters else np.zeros_like(self.irradiance)
        light = BandLight.of(self.air, scattered)
        if not light.source.any():
            return light
        return light.at_few_points(self._scattered_sample, share * self.tolerance / self.scale.factor)

    @cached_property
    def _scattered_sample(self) -> Floats:
        """Scattered light of random paths under directions of a source, per unit of its irradiance."""
        self.air.air.prepare()
        return light_of_lines(self.air, self._sample_under_sources())

    @cached_property
    def direct(self) -> BandAtmosphere:
        """The air for direct computation on lines of sight, with scattered light at points of its own."""
        return replace(self.air, scattering=self._light_within(_TRUTH_SHARE).scattering)

    @cached_property
    def _emitted(self) -> EmittedLight:
        return EmittedLight.of(self.air, self.harmonics)

    @cached_property
    def _known(self) -> dict[bytes, PathFields]:
        """The fields of the nodes seen last, of which all but scattered light is the same under another source."""
        return {}

    def under(
        self, air: BandAtmosphere, irradiance: Floats, scale: Scale, all_points: tuple[SpectralAir, PartedLight]
    ) -> ChannelTables:
        """The tables of another source in the same air: what does not depend on the source is computed once."""
        relit = replace(self, air=air, irradiance=irradiance, scale=scale, all_points=all_points)
        reused = {"_sample", "_scattered_sample", "_emitted"}
        if scale == self.scale:
            reused |= {"absorbers", "_known"}
        vars(relit).update({name: value for name, value in vars(self).items() if name in reused})
        return relit

    def _sample_under_sources(self) -> Iterator[tuple[LineOfSight, LineSources]]:
        """Random paths, each with directions of the source."""
        generator = random_stream(self.seed, Stream.CHANNELS, 4)
        count = self.air.scope.lines(_POINT_LINES)
        altitude, elevation, ranges = lines_in_cells(self.base, count, generator)
        distance = ranges[np.arange(count), generator.permutation(count) % ranges.shape[1]]
        ends = self.base.source_elevation_deg[[0, -1]]
        # Half of them nearly level, towards a low source: what horizon and aureole scatter is most of all.
        level = generator.random(count) < 0.5
        elevation = np.where(
            level,
            np.clip(generator.uniform(*_LEVEL, count), self.base.elevation_deg[0], self.base.elevation_deg[-1]),
            elevation,
        )
        paths = lines_of_sight(self.air.air, distance[:, None], altitude, elevation)
        for path, along in zip(paths, level, strict=True):
            low, high = np.clip(_LOW_SOURCE if along else _ANY_SOURCE, *ends)
            up = np.radians(generator.uniform(low, high, _POINT_SOURCES))
            angle = np.radians(180.0 * generator.random(_POINT_SOURCES) ** (4 if along else 1))
            yield path, LineSources.at_angle(path.elevation, up, angle)

    @cached_property
    def _sample(self) -> tuple[Floats, Floats]:
        """Optical depths (n, P) and lengths (n,) [km] of random paths above the ground."""
        altitude, elevation, ranges = lines_in_cells(
            self.base, self.air.scope.lines(_SAMPLE_LINES), random_stream(self.seed, Stream.CHANNELS, 0)
        )
        depth, length = [], []
        for path, reach in zip(lines_of_sight(self.air.air, ranges, altitude, elevation), ranges, strict=True):
            inside = path.valid & (reach > 0)
            depth.append(path.depth[inside].astype(float))
            length.append(reach[inside])
            local = path.local_extinction
        if not sum(map(len, length)):  # a job of a range of 0, or of lines behind the ground, still has its air
            return local[None].astype(float), np.array([1e-3])
        return np.concatenate(depth), np.concatenate(length)

    @cached_property
    def absorbers(self) -> Parts:
        """The points whose optical depths give those of all."""
        allowed = _SHARE * self.tolerance / (self.scale.background * self.scale.factor)
        return absorbers(*self._sample, self.air.band.weight, allowed)

    def sources(self, nodes: ChannelNodes) -> SourceParts:
        """The directions of the source whose path radiance gives that under all: chosen once, on the nodes from which
        placing starts.
        """
        key = nodes.source_elevation.tobytes(), nodes.scattering_angle.tobytes()
        if key not in self._chosen:
            self._chosen[key] = self._sources(nodes)
        return self._chosen[key]

    @cached_property
    def _chosen(self) -> dict[tuple[bytes, bytes], SourceParts]:
        """Those of nodes seen before: a pass of placing often leaves them as they are."""
        return {}

    @cached_property
    def _first_sources(self) -> tuple[SourceParts, Integers]:
        """The directions chosen on the nodes from which placing starts, and the lines of their sample by which their
        factors at other nodes are fitted.
        """
        start = self.nodes(NodeCounts())
        elevation, angle = start.source_elevation, start.scattering_angle
        if not self.is_lit:
            return source_parts(elevation, angle, [], 0.0), np.zeros(0, int)
        sample = self.source_sample(start, self._source_count)
        parts = source_parts(elevation, angle, [sample], _SOURCE_SHARE * self.tolerance / self.scale.factor)
        return parts, telling_lines(sample, math.ceil(_FACTOR_SHARE * self._source_count))

    @property
    def _effort(self) -> float:
        """Nodes on an axis, and lines, that the tolerance takes, over those for `_START`."""
        return float(np.sqrt(_START * self.scale.background * self.scale.factor / self.tolerance))

    @property
    def _source_count(self) -> int:
        """Lines on which directions of the source are chosen: the finer the tolerance, the more weigh rare ones."""
        lines = _SOURCE_LINES[bool(self.base.altitude_km[-1] > _HIGH_KM)]
        return self.air.scope.lines(math.ceil(lines * float(np.clip(self._effort, 1.0, _MOST_EFFORT))))

    def _sources(self, nodes: ChannelNodes) -> SourceParts:
        reference, lines = self._first_sources
        elevation, angle = nodes.source_elevation, nodes.scattering_angle
        if not self.is_lit:
            return source_parts(elevation, angle, [], 0.0)
        if np.array_equal(elevation, reference.elevation) and np.array_equal(angle, reference.angle):
            return reference
        chosen, directions = (reference.chosen_elevation, reference.chosen_angle), all_directions(elevation, angle)
        up, away = (np.concatenate(pair) for pair in zip(chosen, directions, strict=True))
        positions = [part[lines] for part in self._source_lines(self._source_count)]
        _, radiance = sampled_radiance(self.air, self._light, up, away, (positions[0], positions[1], positions[2]))
        return at_other_nodes(reference, elevation, angle, radiance)

    @property
    def is_lit(self) -> bool:
        """Whether air scatters light of the source."""
        return bool(self._light.source.any())

    def source_sample(self, nodes: ChannelNodes, count: int) -> tuple[Integers, Floats]:
        """Path radiance of so many sample lines under all directions of the source."""
        directions = all_directions(nodes.source_elevation, nodes.scattering_angle)
        return sampled_radiance(self.air, self._light, *directions, self._source_lines(count))

    def _source_lines(self, count: int) -> tuple[Floats, Floats, Floats]:
        """Altitude and elevation (n,) and ranges (n, R) of so many sample lines."""
        generator = random_stream(self.seed, Stream.CHANNELS, 1)
        altitude, elevation, ranges = lines_in_cells(self.base, count, generator)
        # Some nearly level: along the horizon a low source lights the air as along no other lines.
        level = generator.random(count) < _LEVEL_SHARE
        low, high = self.base.elevation_deg[[0, -1]]
        elevation = np.where(level, np.clip(generator.uniform(*_LEVEL, count), low, high), elevation)
        return altitude, elevation, ranges[:, :: max(1, ranges.shape[1] // _SOURCE_RANGES)]

    @cached_property
    def surface(self) -> SurfaceLight:
        """Light on the surfaces at the ends of paths."""
        depth = self._sample[0]
        through = np.exp(-depth[:: max(1, len(depth) // _THROUGH)])
        elevation = elevation_nodes(SKY_ELEVATIONS, *self.base.source_elevation_deg[[0, -1]])
        allowed = _LIGHT_SHARE * self.tolerance / (self.scale.factor * self.scale.reflectance)
        return surface_light(self.air, self.irradiance, elevation, through, self._emitted, allowed)

    @cached_property
    def _bends_paths(self) -> bool:
        """Whether the ends of some paths are bent so far that their beam changes by more than it may miss."""
        generator = random_stream(self.seed, Stream.CHANNELS, 5)
        change = largest_change_of_beam(
            self.air,
            RayCoordinates.of(self.air.air.shells, self.nodes(NodeCounts()).height_root),
            self.irradiance,
            (float(self.base.source_elevation_deg[0]), float(self.base.source_elevation_deg[-1])),
            lines_in_cells(self.base, _END_LINES, generator),
        )
        return change * self.scale.factor * self.scale.reflectance > _LIGHT_SHARE * self.tolerance

    @cached_property
    def _shares(self) -> WavelengthShares:
        """Where in the band the light of the channels lies."""
        generator, count = random_stream(self.seed, Stream.CHANNELS, 3), self.air.scope.lines(_SHARE_LINES)
        altitude, elevation, ranges = lines_in_cells(self.base, count, generator)
        distance = ranges[np.arange(count), generator.permutation(count) % ranges.shape[1]]
        low, high = np.clip(self.base.source_elevation_deg[[0, -1]], *_SHARE_ELEVATIONS)
        paths = SamplePaths(
            distance * 1e3,
            altitude * 1e3,
            np.radians(elevation),
            np.radians(generator.uniform(low, high, count)),
        )
        band = self.air.band
        sampled_light = PartedLight.of(band.wavenumber, band.radiance_weight, self.irradiance)
        return WavelengthShares.fitted(self.wavelength, paths, self.all_points, (self.air.air, sampled_light))

    def nodes(self, counts: NodeCounts) -> ChannelNodes:
        """So many nodes between the ends of the job's axes."""
        return channel_nodes(self.base, self.air.air.state.surface_altitude / 1e3, counts)

    def table(self, nodes: ChannelNodes, sources: SourceParts | None = None) -> AtmosphereTable:
        """The table on some nodes, in memory; by default of the directions of the source that are chosen for it."""
        base, sources = self.base, sources or self.sources(nodes)
        ends = float(base.altitude_km[0]), float(base.altitude_km[-1])
        rays = RayCoordinates.of(self.air.air.shells, nodes.height_root)
        key = b"".join(values.tobytes() for values in (nodes.share, nodes.height_root, nodes.direction))
        cached = self._known.get(key)
        fields = path_fields(
            self.air,
            rays,
            nodes,
            self.absorbers,
            self._light,
            np.radians(sources.chosen_elevation),
            np.radians(sources.chosen_angle),
            cached,
        )
        self._known.clear()
        self._known[key] = replace(fields, scattered=fields.scattered[:0])
        step = _DIGITS_SHARE * self.tolerance / self.scale.factor
        factor, scattered = leading_parts(
            sources.factor, fields.scattered, _SOURCE_SHARE * self.tolerance / self.scale.factor
        )
        sources, fields = replace(sources, factor=factor), replace(fields, scattered=scattered)
        content = ChannelContent(
            rays,
            nodes,
            self.air.band.wavenumber,
            self.air.band.weight,
            self.absorbers,
            self._light,
            fields,
            sources,
            self.surface,
            self._shares,
            self._bends_paths,
            (float(base.range_km[0]), float(base.range_km[-1])),
            ends,
            dark_elevation(ends[1]),
            step / self.scale.background,
            step,
        )
        group = channel_group(content, Group(), {})
        return AtmosphereTable(Path("in memory"), "atmq", group, group.attributes)

    def on_shared(self, common: SharedNodes, probes: Probes) -> PlacedChannels | None:
        """The table on nodes that states share, if they meet the tolerance on probes, and along the horizon."""
        if self.is_lit != bool(common.sources.chosen_angle.size):
            return None
        table = self.table(common.nodes, common.sources)
        generator = random_stream(self.seed, Stream.CHANNELS, 6)
        level = Probes.along_the_horizon(self.direct, self.base, self.irradiance, generator, count=_LEVEL_LINES)
        p99, largest = largest_errors(table, [probes, level], self.scale)
        accepted = p99 <= self.tolerance and largest <= WORST * self.tolerance
        return PlacedChannels(table, common.nodes, p99, largest) if accepted else None

    def shared(self, similar: Sequence[ChannelTables], most_nodes: int) -> SharedNodes:
        """The fewest nodes that meet the tolerance, with directions of the source for this air and similar ones;
        most_nodes : of all fields together.
        """
        nodes = self.placed(most_nodes, fewest=True).nodes
        count = math.ceil(self._source_count / (1 + len(similar)))
        samples = [tables.source_sample(nodes, count) for tables in (self, *similar) if tables.is_lit]
        allowed = _SOURCE_SHARE * self.tolerance / self.scale.factor
        return SharedNodes(nodes, source_parts(nodes.source_elevation, nodes.scattering_angle, samples, allowed))

    def placed(self, most_nodes: int, *, fewest: bool = False, insist: bool = True) -> PlacedChannels:
        """The table on few nodes that meet the tolerance.

        Parameters
        ----------
        most_nodes : int
            Largest number of nodes of all fields together.
        fewest, insist : bool
            Options of `channel_nodes.placed_channels`.
        """
        generator, scope = random_stream(self.seed, Stream.CHANNELS, 2), self.air.scope
        probes = [
            Probes.drawn(
                self.direct,
                self.base,
                self.irradiance,
                generator,
                sky=scope.lines(_SKY_LINES, _FEWEST_SKY_LINES),
                count=scope.lines(LINES),
            ),
            Probes.along_the_horizon(self.direct, self.base, self.irradiance, generator),
        ]
        nodes = self.nodes(NodeCounts().scaled(float(np.clip(self._effort, FEWEST, 1.0))))
        fields = self._fields(self.sources(nodes).chosen_angle.size)
        return placed_channels(
            self.table,
            probes,
            nodes,
            self.scale,
            self.tolerance,
            max_nodes=most_nodes // fields,
            fewest=fewest,
            insist=insist,
        )

    def _fields(self, source_parts: int) -> int:
        """Number of arrays on the nodes of paths."""
        return self.absorbers.count + 1 + max(source_parts, 1) + self._bends_paths

    def notes(self, sampled: PlacedChannels) -> dict[str, Any]:
        """What the file says of its channels."""
        return {
            "channels": int(self.air.band.weight.size),
            "absorbers": self.absorbers.count,
            "source_parts": sampled.table.root.axes["source_part"].values.size if self.is_lit else 0,
            "field_nodes": sampled.nodes.size,
        }

    def words(self, sampled: PlacedChannels) -> str:
        """What a build says of them."""
        fields = self._fields(sampled.table.root.axes["source_part"].values.size)
        reads = f"{sampled.p99:.2g} in 99 % of the reads, {sampled.largest:.2g} in nearly all"
        return f"{fields} fields of {sampled.nodes.size:,} nodes for a tolerance of {self.tolerance:g}: {reads}"
