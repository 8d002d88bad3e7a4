"""Random lines of sight on which the interpolation error of an atmospheric table is measured.

They look as scenes do (`scene_lines`), and their errors are stated by where they look and when.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skyshine.mat.atmosphere.transfer.scene_lines import SKY_KM, SceneLines, lines_in_cells, spread
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.tables.gridded import AXES, QUANTITIES
from skyshine.mat.tables.stated_error import ErrorMeasure, measure
from skyshine.schemas.arrays import Booleans, Floats, Integers


class Readable(Protocol):
    """A quantity that is read at coordinates by the names of `gridded.AXES`."""

    def read(self, coordinates: dict[str, Floats]) -> Floats: ...


OF_PATHS = ("beta_star", "path_radiance_ratio")


LINES = 500  # lines of sight on which tables are measured by default
PIXELS = 120  # lines to the ground alone, of one range each, on which errors are stated beside
_SOURCES = 2  # sources of each line
# Lines on which sky light is computed too, which takes as long as all the other quantities: its errors have no such
# tail.
AMBIENT = 96
# Lines along the horizon, and spans of their elevation and of the source's elevation and azimuth, degree.
GRAZING = 100
_NEARLY_LEVEL, _LOW, _AHEAD = (-1.5, 1.5), (-3.0, 4.0), (0.0, 12.0)
_SKIES = 12  # elevations of the source for which sky light is computed
# Elevation of the source at which civil twilight ends: lower down, scattered light is below a thousandth of the day's.
NIGHT_DEG = -6.0
# What a file says of its probes and their regions.
DRAWN = (
    "on random lines of sight: a third ends on the ground, a third lies in the cells of the axes, the others pass the"
    f" limb or go up; and on {PIXELS} pixels of the ground, seen from all heights; ground: ends on it; limb: looks down"
    f" past it; sky: upward to above {SKY_KM:g} km; air: all other lines; twilight: source 0 to {-NIGHT_DEG:g} degree"
    " down"
)


@dataclass(frozen=True, eq=False)
class Probes:
    """Lines of sight through the axes of a job, and the quantities computed directly on them.

    Attributes
    ----------
    scene_lines : SceneLines
        n lines at R ranges.
    coordinates : dict of str to array
        Coordinates by axis: range (n, R, 1), altitude and elevation (n, 1, 1), source angles (n, 1, S).
    ambient_at : (m,) int array
        The range at which ambient is known, of each of the first m lines for its first source.
    truth : AtmosphericQuantities
        Quantities computed directly, as by `BandAtmosphere.along_lines`.
    """

    scene_lines: SceneLines
    coordinates: dict[str, Floats]
    ambient_at: Integers
    truth: AtmosphericQuantities

    @classmethod
    def drawn(
        cls,
        air: BandAtmosphere,
        base: PathGrid,
        irradiance: Floats,
        generator: np.random.Generator,
        *,
        sky: int = AMBIENT,
        count: int = LINES,
        quantities: tuple[str, ...] = tuple(key for key, _ in QUANTITIES.values()),
    ) -> Probes:
        """Draw so many lines between the ends of the job's own axes and compute the quantities on them, ambient on the
        first `sky`.
        """
        scene_lines = SceneLines.drawn(air.air.shells, base, count, generator)
        altitude, elevation, ranges = scene_lines.altitude_km, scene_lines.elevation_deg, scene_lines.range_km
        lines, steps = np.arange(count), ranges.shape[1]
        source, azimuth = (
            spread(nodes, count * _SOURCES, generator).reshape(count, _SOURCES)
            for nodes in (base.source_elevation_deg, base.source_azimuth_deg)
        )
        source[:sky, 0] = spread(base.source_elevation_deg, _SKIES, generator)[lines[:sky] % _SKIES]
        ambient_at = np.where(scene_lines.on_ground[:sky], steps - 1, generator.permutation(sky) % steps)
        truth = air.along_lines(
            ranges, altitude, elevation, source, azimuth, ambient_at, irradiance, quantities=quantities
        )
        return cls(scene_lines, _coordinates(scene_lines, source, azimuth), ambient_at, truth)

    @classmethod
    def along_the_horizon(
        cls,
        air: BandAtmosphere,
        base: PathGrid,
        irradiance: Floats,
        generator: np.random.Generator,
        *,
        count: int = GRAZING,
    ) -> Probes:
        """Draw nearly level lines towards a low source, where path radiance changes most: transmittance and path
        radiance alone.
        """
        count = air.scope.lines(count)
        altitude, _, ranges = lines_in_cells(base, count, generator)
        elevation, source, azimuth = (
            np.clip(generator.uniform(*span, shape), nodes[0], nodes[-1])
            for span, shape, nodes in (
                (_NEARLY_LEVEL, count, base.elevation_deg),
                (_LOW, (count, _SOURCES), base.source_elevation_deg),
                (_AHEAD, (count, _SOURCES), base.source_azimuth_deg),
            )
        )
        no_surface = np.zeros(0, int)
        truth = air.along_lines(
            ranges, altitude, elevation, source, azimuth, no_surface, irradiance, quantities=OF_PATHS
        )
        scene_lines = SceneLines(altitude, elevation, ranges, np.zeros(count, bool))
        return cls(scene_lines, _coordinates(scene_lines, source, azimuth), no_surface, truth)

    @classmethod
    def of_pixels(
        cls, air: BandAtmosphere, base: PathGrid, irradiance: Floats, generator: np.random.Generator
    ) -> Probes | None:
        """Draw lines to the ground, which most pixels show: transmittance and path radiance alone; None where the job
        has none.
        """
        scene_lines = SceneLines.of_pixels(air.air.shells, base, air.scope.lines(PIXELS), generator)
        if scene_lines is None:
            return None
        altitude, elevation, ranges = scene_lines.altitude_km, scene_lines.elevation_deg, scene_lines.range_km
        shape = altitude.size, _SOURCES
        source, azimuth = (
            spread(nodes, altitude.size * _SOURCES, generator).reshape(shape)
            for nodes in (base.source_elevation_deg, base.source_azimuth_deg)
        )
        no_surface = np.zeros(0, int)
        truth = air.along_lines(
            ranges, altitude, elevation, source, azimuth, no_surface, irradiance, quantities=OF_PATHS
        )
        return cls(scene_lines, _coordinates(scene_lines, source, azimuth), no_surface, truth)

    def errors(self, tables: Mapping[str, Readable], scale: Scale | None) -> dict[str, Floats]:
        """Errors (k,) of each quantity's interpolation above the ground, in the scale's unit; without a scale in the
        quantity's own.
        """
        errors = {name: self.error(name, table, scale) for name, table in tables.items()}
        return {name: error[self.above_ground(name, error)] for name, error in errors.items()}

    def error(self, name: str, table: Readable, scale: Scale | None) -> Floats:
        """Error of a quantity's interpolation at all points of `at`, behind the ground too."""
        truth, coordinates = self.truth, self.at(name)
        exact, through = getattr(truth, QUANTITIES[name][0]), truth.transmittance[:, :, None]
        if name == "beta_star":
            exact = exact[:, :, None]
        elif name == "ambient_radiance":
            exact, through = exact[:, None, None], through[np.arange(exact.size), self.ambient_at][:, :, None]
        read = table.read(coordinates)
        return read - exact if scale is None else scale.error(name, read, exact, through, coordinates["range"])

    def at(self, name: str) -> dict[str, Floats]:
        """Places, by axis, at which a quantity is known."""
        if name != "ambient_radiance":
            return self.coordinates if name != "beta_star" else {axis: self.coordinates[axis] for axis in AXES[:3]}
        row = np.arange(self.ambient_at.size)
        coordinates = {axis: value[row, :, :1] for axis, value in self.coordinates.items()}
        return coordinates | {"range": coordinates["range"][row, self.ambient_at][:, None]}

    def above_ground(self, name: str, values: Floats) -> Booleans:
        """Which of values at a quantity's points count."""
        valid = self.truth.valid[:, :, None]
        if name == "ambient_radiance":
            valid = valid[np.arange(self.ambient_at.size), self.ambient_at][:, :, None]
        return np.broadcast_to(valid, values.shape)

    def regions(self, name: str) -> dict[str, Booleans]:
        """Which of the errors (k,) of a quantity lie in each region: lines that end on the ground, look down past it,
        leave the air, or end in it; by day, in twilight and by night where the source matters.
        """
        coordinates, where = self.at(name), self.scene_lines.regions()
        if name == "ambient_radiance":
            row = np.arange(self.ambient_at.size)
            where = {region: inside[row, self.ambient_at][:, None] for region, inside in where.items()}
        regions = {region: inside[:, :, None] for region, inside in where.items()}
        if "source_elevation" in coordinates:
            source = coordinates["source_elevation"]
            regions |= {
                "day": source > 0,
                "twilight": (source <= 0) & (source > NIGHT_DEG),
                "night": source <= NIGHT_DEG,
            }
        shape = np.broadcast_shapes(*(values.shape for values in coordinates.values()))
        counted = self.above_ground(name, np.empty(shape))
        return {region: np.broadcast_to(inside, shape)[counted] for region, inside in regions.items()}


def measured(
    groups: Sequence[Probes], tables: Mapping[str, Readable], kelvin: Scale, percent: Scale
) -> list[ErrorMeasure]:
    """Errors of each quantity's interpolation above the ground, with those of its parts, on groups of probes: the first
    with all quantities, the others with those of paths alone.
    """
    measures = []
    for name, table in tables.items():
        knowing = groups if name in OF_PATHS else groups[:1]
        errors = (
            np.concatenate([np.ravel(group.errors({name: table}, scale)[name]) for group in knowing])
            for scale in (None, kelvin, percent)
        )
        parts = [group.regions(name) for group in knowing]
        regions = {region: np.concatenate([part[region].ravel() for part in parts]) for region in parts[0]}
        measures.append(measure(name, *errors, regions=regions))
    return measures


def _coordinates(scene_lines: SceneLines, source: Floats, azimuth: Floats) -> dict[str, Floats]:
    """Places by axis, of lines at their ranges and of sources (n, S)."""
    observer = scene_lines.altitude_km[:, None, None], scene_lines.elevation_deg[:, None, None]
    return dict(
        zip(AXES, (scene_lines.range_km[:, :, None], *observer, source[:, None], azimuth[:, None]), strict=True)
    )
