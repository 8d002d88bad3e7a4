"""The four quantities of the atmospheric tables, equations (8), (10), (20) and (36), for a state, a band and a source.

Angles: source elevation is geometric (without refraction), line-of-sight elevation apparent. For the path radiance both
source angles are those at the observer, azimuth counted from that of the line of sight; for ambient and direct the
source elevation is that at the surface point, the end of the line of sight.

In-band transmittance weights wavelengths: integral of phi tau dlambda over integral of phi dlambda.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES
from skyshine.mat.atmosphere.transfer.geometry import Rays, trace
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight, lines_of_sight
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathScope
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.atmosphere.transfer.source_nodes import elevations_from
from skyshine.mat.quantities.facet_light import Facets, light_among_walls
from skyshine.mat.quantities.formulas import beta_star, mean_transmittance
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.joined_paths import JoinedPaths, in_groups
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.quantities.path_radiance import radiance_along, scattered_light, thermal_light
from skyshine.mat.quantities.results import QUANTITIES, AtmosphericQuantities, SpectralLines
from skyshine.mat.quantities.scattering_points import ScatteringPoints
from skyshine.mat.quantities.sky_table import SkyTable
from skyshine.mat.quantities.surface_light import ambient, direct, radiance_weight
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError

# Points whose field of scattered light is in memory at once in `BandAtmosphere.spectral_at_points`.
_SPECTRAL_CHUNK = 256
# One in so many of them is solved for light scattered more than once: 3-5 um by day err by 0.0005 K at most.
_EVERY = 8
# The same of the points of a table of clear air, and the largest wavenumber [cm^-1] of a band in which it is: a path of
# 3-5 um errs by 0.013 K at most by day and in twilight, in haze of 4 km by 0.03 K of 300 K of sunlight, which the
# stated errors do not have: of finer tolerances all points are solved. At 4 um 1 % of the radiance is 0.25 K.
_EVERY_CHANNEL, _THERMAL = 4, 3400.0
_COARSE = {"K": 0.3, "%": 1.0}


@dataclass(frozen=True, eq=False)
class BandAtmosphere:
    """A state prepared for a band: everything that does not depend on grid or source.

    Attributes
    ----------
    band : BandPoints
        All points of the band (`points.band_points`) or the compiled ones (`compile.compile_band`); the response is in
        their weights.
    scope : PathScope
        Up to which height light on surfaces is tabulated.
    scattering : ScatteringPoints or None
        Points at which light scattered along lines of sight is computed, for the one source to which they belong; by
        default all points.
    """

    band: BandPoints
    air: SpectralAir
    scope: PathScope = ALL_PATHS
    scattering: ScatteringPoints | None = None

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        band: BandPoints,
        *,
        scope: PathScope = ALL_PATHS,
    ) -> BandAtmosphere:
        """Prepare a state for a band."""
        air = SpectralAir.of(state, band.points, band.gases, band.weight)
        return cls(band, replace(air, elevations=elevations_from(scope.lowest_source)), scope)

    def tabulated(self, tolerance: float, unit: str) -> BandAtmosphere:
        """The same for tables of a tolerance in kelvin or percent: in clear air and thermal bands, diffuse light is
        solved at few of the points, unless the tolerance is fine.
        """
        fine = tolerance < _COARSE.get(unit, math.inf)
        if fine or self.air.nodes > NODES or self.band.wavenumber.max() > _THERMAL:
            return self
        return replace(self, air=replace(self.air, every=_EVERY_CHANNEL))

    def table(
        self,
        grid: PathGrid,
        source_irradiance: npt.ArrayLike,
        *,
        quantities: Collection[str] = QUANTITIES,
        progress: Callable[[int], None] | None = None,
    ) -> AtmosphericQuantities:
        """The quantities on a grid.

        Parameters
        ----------
        source_irradiance : (P,) array
            Irradiance of the source outside the atmosphere, normal to the beam, at `band.points`, W m^-2 (cm^-1)^-1.
        quantities : names out of `QUANTITIES`
            Only these are computed; the others are None.
        progress : callable, optional
            Called with the number of lines of sight done since the last call; there are A * E.

        Raises
        ------
        InputError
            For an observer below the ground, a negative range, or an irradiance that is negative or of another length.
        """
        irradiance = _checked(source_irradiance, self.band)
        ranges, elevation = grid.range_km * 1e3, np.radians(grid.elevation_deg)
        source, azimuth = np.radians(grid.source_elevation_deg), np.radians(grid.source_azimuth_deg)
        self.air.prepare()
        sky = None
        if "ambient" in quantities:
            sky = SkyTable.over_ground(self.air, source, irradiance, self.scope)
        result = _empty(grid.shape, quantities)
        reach = np.broadcast_to(ranges, (elevation.size, ranges.size))

        def line(rays: Rays, altitude: float, row: int) -> dict[str, Floats | Booleans]:
            path = LineOfSight.of(self.air, rays, row, altitude, elevation[row], ranges)
            sources = LineSources.of_axes(source, azimuth)
            return self._along([path], [sources], [source], irradiance, sky, quantities)[0]

        for level, altitude in enumerate(grid.altitude_km * 1e3):
            rays = trace(self.air.shells, np.full(elevation.size, altitude), elevation, reach)
            for row, values in enumerate(parallel_map(partial(line, rays, altitude), range(elevation.size))):
                for name, of_line in values.items():
                    result[name][:, level, row] = of_line
            if progress is not None:
                progress(elevation.size)
        return AtmosphericQuantities(**result)

    def at_points(self, lines: LinesOfSight, source_irradiance: npt.ArrayLike) -> AtmosphericQuantities:
        """The quantities at single points, computed directly.

        Parameters
        ----------
        lines : LinesOfSight
            Lines of sight with the source; broadcast to (n,).
        source_irradiance : (P,) array

        Returns
        -------
        AtmosphericQuantities
            Of (n,) arrays.
        """
        irradiance = _checked(source_irradiance, self.band)
        ranges, altitude, elevation, source, azimuth = _in_si(*np.broadcast_arrays(*np.atleast_1d(*lines.place)))
        points: dict[str, list[float | bool]] = {name: [] for name in _empty((), QUANTITIES)}
        for row, path in enumerate(lines_of_sight(self.air, ranges[:, None], altitude, elevation)):
            at = slice(row, row + 1)
            sky = SkyTable.of(self.air, path.surface_altitude, source[at], irradiance)
            sources = LineSources.at(source[at], azimuth[at])
            for name, value in self._along([path], [sources], [source[at]], irradiance, sky, QUANTITIES)[0].items():
                points[name].append(value.item())
        return AtmosphericQuantities(**{name: np.array(values) for name, values in points.items()})

    def ambient_on_faces(self, lines: LinesOfSight, source_irradiance: npt.ArrayLike, faces: Facets) -> Floats:
        """Ambient radiance (n,) of n faces, integrated over their hemispheres, W m^-2 sr^-1.

        Parameters
        ----------
        lines : LinesOfSight
            Lines of sight to the faces (n,), with the source.
        source_irradiance : (P,) array
        """
        irradiance = _checked(source_irradiance, self.band)
        ranges, altitude, elevation, source, _ = _in_si(*lines.place)
        paths = list(lines_of_sight(self.air, ranges[:, None], altitude, elevation))
        end = np.array([path.surface_altitude[0] for path in paths])
        weight = np.array([radiance_weight(self.band, path)[0] for path in paths])
        light: Floats = np.sum(weight * _on_faces(self.air, end, source, irradiance, faces), axis=1)
        return light

    def along_lines(
        self,
        range_km: npt.ArrayLike,
        altitude_km: npt.ArrayLike,
        elevation_deg: npt.ArrayLike,
        source_elevation_deg: npt.ArrayLike,
        source_azimuth_deg: npt.ArrayLike,
        ambient_at: Integers,
        source_irradiance: npt.ArrayLike,
        *,
        quantities: Collection[str] = QUANTITIES,
    ) -> AtmosphericQuantities:
        """The quantities on n lines of sight at R ranges and for S sources each, computed directly; ambient at one
        range of some.

        Parameters
        ----------
        range_km : (n, R) array
            Increasing along each line.
        altitude_km, elevation_deg : (n,) arrays
        source_elevation_deg, source_azimuth_deg : (n, S) arrays
            Sky light is computed for the first source; lines that share its elevation cost less.
        ambient_at : (m,) int array
            Number of the range at which it is computed, for each of the first m lines.
        source_irradiance : (P,) array
        quantities : names out of `QUANTITIES`
            Only these are computed; the others are None, except ambient, which is computed wherever `ambient_at` asks
            for it.

        Returns
        -------
        AtmosphericQuantities
            beta_star, valid, transmittance (n, R); path_radiance_ratio, direct (n, R, S); ambient (m,).
        """
        irradiance = _checked(source_irradiance, self.band)
        ranges, altitude, elevation, source, azimuth = _in_si(
            range_km, altitude_km, elevation_deg, source_elevation_deg, source_azimuth_deg
        )
        quantities = [name for name in quantities if name != "ambient"]
        lines: dict[str, list[Floats | Booleans]] = {name: [] for name in ("valid", "transmittance", *quantities)}
        end, weight = np.empty(len(ambient_at)), np.empty((len(ambient_at), irradiance.size))
        paths = list(lines_of_sight(self.air, ranges, altitude, elevation))
        for group in in_groups(len(paths), source.shape[1]):
            sources = [LineSources.at(*angles) for angles in zip(source[group], azimuth[group], strict=True)]
            for of_line in self._along(paths[group], sources, source[group], irradiance, None, quantities):
                for name, values in of_line.items():
                    lines[name].append(values[..., 0] if name == "path_radiance_ratio" else values)
        for row, (path, range_index) in enumerate(zip(paths, ambient_at, strict=False)):
            end[row] = path.surface_altitude[range_index]
            weight[row] = radiance_weight(self.band, path)[range_index]
        ambient_light = self._ambient(end, weight, source[: end.size, 0], irradiance)
        arrays: dict[str, Any] = {name: np.array(values) for name, values in lines.items()}
        return AtmosphericQuantities(**{**dict.fromkeys(QUANTITIES), "ambient": ambient_light, **arrays})

    def spectral_at_points(
        self, lines: LinesOfSight, source_irradiance: npt.ArrayLike, faces: Facets | None = None
    ) -> SpectralLines:
        """The spectra whose integrals the quantities are, at n single points; arguments as in `at_points`.

        With n faces, the sky irradiance is that of each, by all around it, instead of that of a level surface.
        """
        irradiance = _checked(source_irradiance, self.band)
        points = _in_si(*(np.asarray(part, float) for part in lines.place))
        parts = []
        for start in range(0, irradiance.size, _SPECTRAL_CHUNK):
            index = np.arange(start, min(start + _SPECTRAL_CHUNK, irradiance.size))
            air = self.air.part(slice(start, start + _SPECTRAL_CHUNK))
            if air.scatters and index.size == _SPECTRAL_CHUNK:
                air = replace(air, every=_EVERY)
            band = BandPoints(self.band.points.subset(index), self.band.weight[index], self.band.gases)
            parts.append(_spectral_part(air, band, *points, irradiance[index], faces))
        return SpectralLines(
            np.concatenate([part.transmittance for part in parts], axis=1),
            np.concatenate([part.sky_irradiance for part in parts], axis=1),
            np.concatenate([part.direct_irradiance for part in parts], axis=1),
            sum((part.path_radiance for part in parts), start=np.zeros(points[0].size)),
            parts[0].valid,
        )

    def _along(
        self,
        paths: Sequence[LineOfSight],
        sources: Sequence[LineSources],
        source_elevation: Sequence[Floats] | Floats,
        irradiance: Floats,
        sky: SkyTable | None,
        quantities: Collection[str],
    ) -> list[dict[str, Floats | Booleans]]:
        """The wanted quantities of lines of sight computed together, each by name of the fields of
        `AtmosphericQuantities`: (R,), for ambient and direct (R, SE), for the path radiance (R, SE, SA).
        """
        band, result = self.band, []
        through = [mean_transmittance(path.depth, band.weight, band.weight.sum()) for path in paths]
        for path, elevation, (ln_tau, _) in zip(paths, source_elevation, through, strict=True):
            values: dict[str, Floats | Booleans] = {"valid": path.valid, "transmittance": np.exp(ln_tau)}
            if "beta_star" in quantities:
                values["beta_star"] = self._beta_star(path)
            if sky is not None or "direct" in quantities:
                weight = radiance_weight(band, path)
                if sky is not None:
                    values["ambient"] = ambient(path, weight, sky)
                if "direct" in quantities:
                    values["direct"] = direct(self.air, path, weight, elevation, irradiance)
            result.append(values)
        if "path_radiance_ratio" in quantities:
            lines = JoinedPaths.of(paths)
            absorptance = np.stack([absorbed for _, absorbed in through])
            points = self.scattering or ScatteringPoints.every(self.air, band, irradiance)
            light = thermal_light(self.air, band, lines) + scattered_light(self.air, band, lines, sources, points)
            ratios = light.ratio(self.air, band, lines, absorptance)
            for values, ratio, elevation in zip(result, ratios, source_elevation, strict=True):
                values["path_radiance_ratio"] = ratio.reshape(len(ratio), elevation.size, -1)
        return result

    def _beta_star(self, path: LineOfSight) -> Floats:
        """beta* [km] of each range, (R,)."""
        weight, total = self.band.weight, self.band.weight.sum()
        ln_tau, _ = mean_transmittance(path.depth + path.depth_behind(self.air), weight, total)
        return beta_star(path.length + path.beyond, ln_tau, path.local_extinction @ weight / total)

    def _ambient(self, altitude: Floats, weight: Floats, source_elevation: Floats, irradiance: Floats) -> Floats:
        """Ambient (m,) of surfaces at altitudes (m,) [m] under sources at elevations (m,) [rad], with weights (m, P) of
        `radiance_weight`.
        """
        result = np.empty(altitude.size)
        for elevation in np.unique(source_elevation):
            rows = source_elevation == elevation
            sky = SkyTable.of(self.air, altitude[rows], np.array([elevation]), irradiance).at(altitude[rows])[:, 0]
            result[rows] = np.sum(weight[rows] * sky, axis=1)
        return result


def _spectral_part(
    air: SpectralAir,
    band: BandPoints,
    ranges: Floats,
    altitude: Floats,
    elevation: Floats,
    source_elevation: Floats,
    source_azimuth: Floats,
    irradiance: Floats,
    faces: Facets | None,
) -> SpectralLines:
    """The spectra at the points of a part of a band, which are those of the air; arguments (n,) in m and rad."""
    shape = ranges.size, irradiance.size
    lines = SpectralLines(
        np.empty(shape), np.empty(shape), np.empty(shape), np.empty(ranges.size), np.empty(ranges.size, dtype=bool)
    )
    end = np.empty(ranges.size)
    for row, path in enumerate(lines_of_sight(air, ranges[:, None], altitude, elevation)):
        source, surface = source_elevation[row : row + 1], path.surface_altitude
        end[row] = surface[0]
        sources = LineSources.at(source, source_azimuth[row : row + 1])
        lines.transmittance[row] = np.exp(-path.depth[0])
        if faces is None:
            lines.sky_irradiance[row] = SkyTable.of(air, surface, source, irradiance).at(surface)[0, 0]
        lines.direct_irradiance[row] = irradiance * direct_transmittance(air.source_paths, surface, source)[0, 0]
        light = radiance_along(air, band, JoinedPaths.of([path]), [sources], irradiance)
        lines.path_radiance[row] = light.along[path.node[0], 0]
        lines.valid[row] = path.valid[0]
    if faces is not None:
        lines.sky_irradiance[:] = _on_faces(air, end, source_elevation, irradiance, faces)
    return lines


def _on_faces(
    air: SpectralAir, altitude: Floats, source_elevation: Floats, irradiance: Floats, faces: Facets
) -> Floats:
    """Irradiance (n, P) of faces at altitudes (n,) [m]."""
    inside = np.minimum(altitude if faces.altitude is None else faces.altitude, air.shells.top)
    return light_among_walls(air, inside, source_elevation, irradiance, faces)


def _in_si(
    range_km: npt.ArrayLike,
    altitude_km: npt.ArrayLike,
    elevation_deg: npt.ArrayLike,
    source_elevation_deg: npt.ArrayLike,
    source_azimuth_deg: npt.ArrayLike,
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The places in m and rad."""
    return (
        np.asarray(range_km, dtype=float) * 1e3,
        np.asarray(altitude_km, dtype=float) * 1e3,
        np.radians(elevation_deg),
        np.radians(source_elevation_deg),
        np.radians(source_azimuth_deg),
    )


def _checked(source_irradiance: npt.ArrayLike, band: BandPoints) -> Floats:
    """The irradiance as an array (P,)."""
    irradiance = np.asarray(source_irradiance, dtype=float)
    if irradiance.shape != band.weight.shape:
        raise InputError(
            f"source irradiance has shape {irradiance.shape}; give one for each of {band.weight.size} points"
        )
    if not np.all(np.isfinite(irradiance) & (irradiance >= 0)):
        raise InputError("source irradiance must be finite and not negative")
    return irradiance


def _empty(shape: tuple[int, ...], quantities: Collection[str]) -> dict[str, Any]:
    """Arrays for the fields of `AtmosphericQuantities` on a grid (R, A, E, SE, SA); None for those not wanted."""
    path, source = shape[:3], shape[:4]
    sizes = {"beta_star": path, "path_radiance_ratio": shape, "ambient": source, "direct": source}
    arrays = {name: np.empty(size) if name in quantities else None for name, size in sizes.items()}
    return arrays | {"valid": np.empty(path, dtype=bool), "transmittance": np.empty(path)}
