"""Frames of a scene: the radiance of every pixel by hour and band, from the tables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from skyshine.mat.job.fields import clock_text
from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.render.alike import alike
from skyshine.mat.render.camera import ViewRays, check_above_ground, is_still, view_rays
from skyshine.mat.render.databases import BandTables, Refuse, SceneTables, held_hours
from skyshine.mat.render.exposure import SeenExposure, exposure_of, hidden
from skyshine.mat.render.frame_file import LoadedFrame
from skyshine.mat.render.rays import RayCaster, ray_caster
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface import SurfaceMaterials, surface_of_scene
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.mat.render.temperatures import SeenTemperatures, walls_of_day
from skyshine.mat.render.vertices import SeenVertices
from skyshine.mat.render.walls import WallKinds, Walls
from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.mat.runtime.pixel import Faces, PixelRadiance, View, pixel_radiance, sky_radiance
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.night import SOURCE_ELEVATION
from skyshine.mat.tables.response import forcing_hours
from skyshine.mat.tables.tracks import SourceTrack
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.progress import Progress, silent

if TYPE_CHECKING:
    import xarray

_BLOCK = 1 << 13  # pixels read together, which bounds what light by wavelength takes


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame in one band.

    Attributes
    ----------
    hour : float
        Local clock.
    sun_elevation : float
        Elevation of the Sun's centre [degree].
    wavelength : (lower, upper)
        Limits of the band [um].
    radiance : (rows, columns) array
        Radiance at the observer, equation (1) [W m^-2 sr^-1].
    apparent_temperature : (rows, columns) array
        Temperature of a black body of that radiance in the band [K].
    surface_temperature : (rows, columns) array
        Mean over the materials of a pixel and its rays that meet the surface [K]; not a number where none does.
    range : (rows, columns) array
        Distance of the nearest point [km]; infinite where there is no surface.
    """

    hour: float
    sun_elevation: float
    band: str
    wavelength: tuple[float, float]
    radiance: Floats
    apparent_temperature: Floats
    surface_temperature: Floats
    range: Floats

    def to_xarray(self) -> xarray.Dataset:
        """The arrays as an `xarray.Dataset` over rows from the top and columns from the left."""
        rows, columns = self.radiance.shape
        arrays = {
            "radiance": ("W m^-2 sr^-1", self.radiance),
            "apparent_temperature": ("K", self.apparent_temperature),
            "surface_temperature": ("K", self.surface_temperature),
            "range": ("km", self.range),
        }
        return dataset(
            {"row": ("1", np.arange(rows)), "column": ("1", np.arange(columns))},
            {name: (("row", "column"), units, values) for name, (units, values) in arrays.items()},
            {"hour": self.hour, "band": self.band, "wavelength_um": list(self.wavelength)},
        )


@dataclass(frozen=True, eq=False)
class SeenScene:
    """What one camera place sees through the day.

    Attributes
    ----------
    exposure : SeenExposure or None
        None: without a mesh that casts shadows.
    lit_share, sky_view : (n,) array
        Share of direct light that shade of the whole day lets through, and open share of the sky.
    temperatures : SeenTemperatures
        Temperatures at the hours of the frames of this place: of what is seen, or of `vertices` where there are any.
    walls : Walls or None
        Walls that hide the sky; None where the whole sky is open.
    """

    rays: ViewRays
    points: SeenSurface
    exposure: SeenExposure | None
    lit_share: Floats
    sky_view: Floats
    temperatures: SeenTemperatures
    walls: Walls | None
    vertices: SeenVertices | None = None

    def temperature(self, hour: int, band: BandTable) -> Floats:
        """Temperatures (n, M) [K] of the materials that are seen, at an hour by its number."""
        if self.vertices is None:
            return self.temperatures.at(hour)
        kelvin = self.vertices.temperature(self.temperatures, hour, band)
        return np.broadcast_to(kelvin, self.points.materials.share.shape)


class PictureMaker:
    """Radiance of what is seen, from the tables."""

    def __init__(
        self, tables: SceneTables, caster: RayCaster, codes: Integers, source: str, samples: int, refuse: Refuse
    ) -> None:
        """What all pictures read.

        Parameters
        ----------
        caster : RayCaster
            Caster of rays towards the source.
        codes : (K,) int array
            Codes of the materials by their number in `SeenSurface`.
        source : {'sun', 'moon'}
        samples : int
            Rays along each side of a pixel.
        refuse : callable
            Makes the error for a key and a message.
        """
        self.tables, self._caster, self._codes = tables, caster, codes
        self._source, self._samples, self._refuse = source, samples, refuse

    @cached_property
    def _sun_of_day(self) -> tuple[Floats, Floats]:
        """Elevation and azimuth of the Sun at the steps of the day whose light the temperatures follow."""
        track = self.tables.surface.source_track("sun", time=forcing_hours())
        return track.elevation, track.azimuth

    def _frame(self, scene: SeenScene, number: int, hour: float, tables: BandTables) -> Picture:
        count, points = scene.rays.size[0] * scene.rays.size[1], scene.points
        source = self.tables.surface.source_track(self._source, time=hour)
        check_reach(self._refuse, tables.air, scene)
        check_source(self._refuse, self._source, tables.air, hour, float(source.elevation))
        lit_share = scene.lit_share * ~hidden(points, self._caster, direction(source.elevation, source.azimuth))
        kelvin = scene.temperature(number, tables.band)
        radiance, mean, distance = np.empty(count), np.full(count, np.nan), np.full(count, np.inf)
        distance[points.pixel] = points.range
        pixel, kind = self._kinds(scene, lit_share, kelvin)
        terms = [
            self._pixels(scene, pixel[start : start + _BLOCK], kelvin, lit_share, hour, tables, source)
            for start in range(0, pixel.size, _BLOCK)
        ]
        if terms:
            radiance[points.pixel] = np.concatenate([part.radiance for part in terms])[kind]
            mean[points.pixel] = np.concatenate([part.temperature for part in terms])[kind]
        self._fill_air(scene, radiance, tables.air, source)
        lower, upper = (float(limit) for limit in tables.air.attributes["wavelength_um"])
        parts = [self._parts(scene, values) for values in (radiance, mean, distance)]
        hit_count = np.maximum(np.isfinite(parts[1]).sum(axis=-1), 1)
        kelvin = np.where(np.isfinite(parts[1]).any(axis=-1), np.nansum(parts[1], axis=-1) / hit_count, np.nan)
        observed = parts[0].mean(axis=-1)
        apparent = equivalent_temperature(tables.band, observed)
        sun = float(self.tables.surface.source_track("sun", time=hour).elevation)
        range_km = parts[2].min(axis=-1)
        return Picture(hour, sun, tables.name, (lower, upper), observed, apparent, kelvin, range_km)

    def _parts(self, scene: SeenScene, values: Floats) -> Floats:
        """Values of the rays of each pixel, (rows, columns, rays of a pixel)."""
        side = self._samples
        columns, rows = (count // side for count in scene.rays.size)
        squares = values.reshape(rows, side, columns, side)
        return squares.transpose(0, 2, 1, 3).reshape(rows, columns, side * side)

    def _kinds(self, scene: SeenScene, lit_share: Floats, kelvin: Floats) -> tuple[Integers, Integers]:
        """Pixels that differ, and the kind of each; the pixels of a perspective all do."""
        points, rows = scene.points, np.arange(len(scene.points))
        if scene.rays.side == 0 or not rows.size:
            return rows, rows
        mixture = points.materials
        return alike(
            points.range, points.altitude, points.slope, points.azimuth, mixture.number, mixture.share, kelvin,
            lit_share, scene.sky_view, np.zeros((rows.size, 0)) if scene.exposure is None else scene.exposure.walls,
        )  # fmt: skip

    def _pixels(
        self,
        scene: SeenScene,
        rows: Integers,
        kelvin: Floats,
        lit_share: Floats,
        hour: float,
        tables: BandTables,
        source: SourceTrack,
    ) -> PixelRadiance:
        """Radiance of some of the pixels that meet the surface, by their rows."""
        points = scene.points
        faces = self._faces(scene, rows, kelvin[rows], lit_share[rows], hour)
        view = _view(tables.air, scene.rays, points.pixel[rows], points.range[rows], points.normal[rows], source)
        if scene.walls is not None and faces.wall_temperature is not None:
            kelvin_of_walls = self._wall_temperature(scene, scene.walls, rows, faces, view, tables)
            faces = replace(faces, wall_temperature=kelvin_of_walls)
        return pixel_radiance(self.tables.surface, tables.band, tables.air, faces, view)

    def _wall_temperature(
        self, scene: SeenScene, walls: Walls, rows: Integers, faces: Faces, view: View, tables: BandTables
    ) -> Floats:
        """Temperature [K] of what hides the sky of some pixels, as it shines in a band; its light is that at the pixel
        in the middle of the ranges.
        """
        exposure, hidden_sky = scene.exposure, 1 - scene.sky_view[rows]
        assert exposure is not None  # walls are known from it
        resolved = np.divide(1 - exposure.sky_view[rows], hidden_sky, out=np.zeros(rows.size), where=hidden_sky > 0)
        shares = exposure.walls[rows] * np.minimum(resolved, 1.0)[:, None]
        middle = np.argsort(view.range)[[rows.size // 2]]
        ground = faces.ground_temperature
        if ground is None:
            ground = tables.air.ground_temperature(self.tables.surface, time=faces.time)
        assert faces.wall_temperature is not None
        return walls.in_band(
            tables,
            shares,
            float(faces.time[0]),
            view.lines.take(middle),
            float(faces.wall_temperature[middle[0]]),
            float(np.broadcast_to(ground, faces.time.shape)[middle[0]]),
            sun=self._source == "sun",
        )

    def _fill_air(self, scene: SeenScene, radiance: Floats, air: AtmosphereTable, source: SourceTrack) -> None:
        """Write the radiance of pixels that meet nothing: of the air along the longest range of the table."""
        unmet = np.ones(radiance.size, bool)
        unmet[scene.points.pixel] = False
        air_pixels = np.flatnonzero(unmet)
        farthest = air.rules("beta_star")[0].nodes[-1]
        for start in range(0, air_pixels.size, _BLOCK):
            pixel = air_pixels[start : start + _BLOCK]
            up = np.broadcast_to([0.0, 0.0, 1.0], (pixel.size, 3))
            view = _view(air, scene.rays, pixel, np.full(pixel.size, farthest), up, source)
            radiance[pixel] = sky_radiance(air, view)

    def _faces(self, scene: SeenScene, rows: Integers, kelvin: Floats, lit_share: Floats, hour: float) -> Faces:
        points, table = scene.points, self.tables.surface
        view = scene.sky_view[rows]
        count = view.size
        wall = None
        if np.any(view < 1):
            nodes = np.asarray(table.root.axes["altitude"].values, float)
            altitude = np.clip(points.altitude[rows], nodes[0], nodes[-1])
            wall = table.value("air_temperature", altitude=altitude, forcing_time=hour)
        return Faces(
            codes=self._codes[points.materials.number[rows]],
            shares=points.materials.share[rows],
            altitude=points.altitude[rows],
            azimuth=points.azimuth[rows],
            slope=points.slope[rows],
            time=np.full(count, hour),
            temperature=kelvin,
            lit_share=lit_share,
            sky_view=None if wall is None else view,
            wall_temperature=wall,
        )


class Renderer(PictureMaker):
    """A scene with its surface, its databases and its textures open.

    Attributes
    ----------
    tables : SceneTables
    surface : SurfaceMesh
    """

    def __init__(self, scene: LoadedScene, progress: Progress = silent) -> None:
        """Open all that the scene names.

        Raises
        ------
        InputError
            A file is missing or does not fit the others, or the camera is below the surface.
        """
        self.scene, self._progress = scene, progress
        self.surface: SurfaceMesh = surface_of_scene(scene)
        caster = ray_caster(self.surface)
        check_above_ground(scene, self.surface, caster)
        tables = SceneTables.of_scene(scene)
        check_hours(scene, tables.surface)
        self._materials = SurfaceMaterials(scene, self.surface)
        try:
            # In sunlight and, once more, in the shade of the photograph.
            codes = np.tile(tables.codes(self._materials.places, scene.error), 2)
        except BaseException:
            self.close()
            raise
        model = scene.model
        super().__init__(tables, caster, codes, model.source, model.camera.samples, scene.error)

    def frames(self) -> Iterator[Picture]:
        """All frames: for each hour, its bands."""
        hours = self.scene.hours
        still = self._see(0, np.array(hours)) if is_still(self.scene) else None
        with self._progress(len(hours) * len(self.tables.bands), "radiance") as advance:
            for number, hour in enumerate(hours):
                scene = still or self._see(number, np.array([hour]))
                for tables in self.tables.bands:
                    yield self._frame(scene, number if still else 0, hour, tables)
                    advance(1)

    def _see(self, number: int, hours: Floats) -> SeenScene:
        rays = view_rays(self.scene, self.surface, number)
        hits = SeenSurface.of(rays, self.surface, self._materials, self._caster)
        kinds, texel = WallKinds(self.surface, self._materials), self.scene.model.surface.vertices
        exposure = history = self._exposed(hits, kinds)
        vertices, points = None, hits
        if texel is not None:
            vertices = SeenVertices.of(hits, self.surface, self._materials, texel)
            points = vertices.points
            history = self._exposed(points, kinds)
            exposure = exposure.before(len(kinds))  # the vertices may have walls that the pixels have not
        codes, table = self._codes, self.tables.surface
        shaded_sky = self._materials.shaded_sky
        walls = walls_of_day(table, kinds, self._exposed, codes, shaded_sky) if len(kinds) else None
        mixture = hits.materials
        lit_share, sky_view = exposure.of_mixtures(mixture.share, shaded_sky[mixture.number])
        temperatures = SeenTemperatures.of(table, points, history, codes, shaded_sky, hours, walls, self._progress)
        return SeenScene(rays, hits, exposure, lit_share, sky_view, temperatures, walls, vertices)

    def _exposed(self, points: SeenSurface, kinds: WallKinds | None = None) -> SeenExposure:
        return exposure_of(points, self.surface, self._caster, *self._sun_of_day, self._progress, kinds)

    def close(self) -> None:
        self._materials.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def check_hours(scene: LoadedScene | LoadedFrame, surface: TemperatureTable) -> None:
    """Refuse hours at which a table has no temperatures.

    Raises
    ------
    InputError
    """
    hours = np.array(scene.hours)
    missing = hours[~held_hours(surface, hours)]
    if missing.size:
        raise scene.error(
            ("hours",),
            f"found {clock_text(missing[0])}, at which {surface.path.name} has no temperatures; change the hours, or"
            " widen needs.hours or surface_grid.time of the job and build again",
        )


def check_reach(refuse: Refuse, air: AtmosphereTable, scene: SeenScene) -> None:
    """Refuse lines of sight that a table does not contain.

    Raises
    ------
    InputError
    """
    reach = {rule.name: rule.nodes[[0, -1]] for rule in air.rules("beta_star")}
    coordinates = {
        "altitude": (scene.rays.altitude, "km of the observer"),
        "elevation": (scene.rays.elevation, "degree of elevation"),
        "range": (np.maximum(scene.points.range, reach["range"][0]), "km of range"),
    }
    for axis, (values, units) in coordinates.items():
        low, high = reach[axis]
        outside: Booleans = (values < low - 1e-9) | (values > high + 1e-9)
        if outside.any():
            raise refuse(
                ("camera",),
                f"found {values[outside][0]:.6g} {units}; {air.path.name} has {low:g} to {high:g}; move the camera,"
                " or widen atmosphere_grid of the job and build again",
            )


def check_source(refuse: Refuse, source: str, air: AtmosphereTable, hour: float, elevation: float) -> None:
    """Refuse an hour at which the source is higher than any node of a table; below, the rule of the night is for it.

    Raises
    ------
    InputError
    """
    highest = min(
        float(rule.nodes[-1])
        for quantity in ("direct_radiance", "path_radiance_ratio")
        for rule in air.rules(quantity)
        if rule.name == SOURCE_ELEVATION
    )
    if elevation > highest:
        raise refuse(
            ("hours",),
            f"found the {source} at {elevation:.3g} degree at {clock_text(hour)}; {air.path.name} has up"
            f" to {highest:g}; change the hours, or widen atmosphere_grid.source_elevation_deg of the job and build"
            " again",
        )


def _view(
    air: AtmosphereTable, rays: ViewRays, pixel: Integers, distance: Floats, normal: Floats, source: SourceTrack
) -> View:
    """Lines of sight of some pixels, over ranges [km]; all tables are read at the pixel itself."""
    nearest = float(air.rules("beta_star")[0].nodes[0])
    heading = rays.azimuth[pixel]
    lines = LinesOfSight(
        np.maximum(distance, nearest),
        rays.altitude[pixel],
        rays.elevation[pixel],
        np.full(pixel.size, float(source.elevation)),
        source.azimuth - heading,
    )
    to_source = np.broadcast_to(direction(source.elevation, source.azimuth), (pixel.size, 3))
    towards = np.full(pixel.size, float(source.azimuth))
    return View(lines, distance, normal, to_source, -rays.direction[pixel], towards)
