"""Pictures of the frames of another renderer: what its buffers show, as a scene shows what rays meet."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from skyshine.mat.quantities.lines_of_sight import slope_and_azimuth
from skyshine.mat.render.buffer_geometry import (
    CameraView,
    Pose,
    distances,
    normals_from_depth,
    poses_of,
    view_of,
    world,
)
from skyshine.mat.render.buffers import MaterialTable, check_size, depth_of, normals_of, stored, sunlit_of
from skyshine.mat.render.camera import ViewRays
from skyshine.mat.render.databases import SceneTables
from skyshine.mat.render.exposure import SeenExposure, exposure_of
from skyshine.mat.render.frame_file import LoadedFrame, MeshScene
from skyshine.mat.render.frames import Picture, PictureMaker, SeenScene, check_hours, check_reach, check_source
from skyshine.mat.render.gltf_surface import mesh_surface
from skyshine.mat.render.rays import FewTriangles, RayCaster, ray_caster, start_height
from skyshine.mat.render.scene_file import Mesh
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface import Mixtures, SurfaceMaterials
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.mat.render.temperatures import SeenTemperatures, walls_of_day
from skyshine.mat.render.walls import WallKinds
from skyshine.mat.tables.axes import EXACT, AxisRule
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.threads import thread_count
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.progress import Progress, silent

# km beyond the altitudes of a table up to which its nearest is read: 0.13 K by the lapse of 6.5 K/km of the standard
# atmosphere, and more than a depth in 16 bits errs by.
ALTITUDE_REACH = 0.02
_PLACE = ("altitude", "azimuth", "slope")


Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class SeenFrame:
    """One frame read.

    Attributes
    ----------
    counts : dict of str to int
        Number of its pixels, and of those whose temperature is that of another slope.
    unknown : dict of str to int
        Ids without a material, with their pixels.
    """

    hours: list[float]
    scene: SeenScene
    counts: dict[str, int]
    unknown: dict[str, int]


@dataclass(frozen=True, eq=False)
class FrameMesh:
    """What casts shadows and hides sky.

    Attributes
    ----------
    codes : (2 K,) int array
        Codes of the materials in the databases, repeated for those in the shade of a photograph.
    """

    surface: SurfaceMesh
    materials: SurfaceMaterials
    codes: Integers

    @classmethod
    def of(cls, frame: LoadedFrame, mesh: Mesh, tables: SceneTables) -> FrameMesh:
        """Read the mesh of a frame; raises InputError where it does not fit the databases."""
        scene = MeshScene.of(frame, mesh)
        surface = mesh_surface(scene, mesh)
        materials = SurfaceMaterials(scene, surface)
        return cls(surface, materials, np.tile(tables.codes(materials.places, scene.error), 2))


class FrameRenderer(PictureMaker):
    """A frame file with its databases open."""

    def __init__(self, frame: LoadedFrame, progress: Progress = silent) -> None:
        """Open all that the file names.

        Raises
        ------
        InputError
            A file is missing or does not fit the others.
        """
        self.frame, self._progress = frame, progress
        tables = SceneTables.of_scene(frame)
        check_hours(frame, tables.surface)
        self._materials = MaterialTable(frame)
        keys = self._materials.places
        by_name = dict(zip(keys, tables.codes(keys, frame.error), strict=True))
        codes = np.array([by_name[name] for name in self._materials.names], int)
        self._mesh = None if frame.model.mesh is None else FrameMesh.of(frame, frame.model.mesh, tables)
        caster: RayCaster = _nothing() if self._mesh is None else ray_caster(self._mesh.surface)
        super().__init__(tables, caster, codes, frame.model.source, 1, frame.error)
        self._temperatures = lru_cache(maxsize=32)(lambda hour: HourTemperatures.of(frame, tables.surface, codes, hour))
        self._views = lru_cache(maxsize=thread_count())(lambda pose, size: view_of(frame.model, pose, size))
        self._poses = poses_of(frame)
        self._taken = Counter[str]()
        self._unknown = Counter[str]()

    def pictures(self) -> Iterator[tuple[str, Picture]]:
        """All pictures: of each frame, for each of its hours, its bands; with what tells the frame apart."""
        with self._progress(len(self.frame.hours) * len(self.tables.bands), "radiance") as advance:
            for mark, pictures in self._each(self._drawn):
                for picture in pictures:
                    yield mark, picture
                    advance(1)

    def check(self) -> None:
        """Read all that `pictures` reads, and compute no radiance.

        Raises
        ------
        InputError
            Those of `pictures`.
        """
        for _ in self._each(self._reach):
            pass

    @property
    def notes(self) -> list[str]:
        """What was taken of the pixels that have been read so far, where their buffers or the tables say nothing."""
        notes, pixels = [], self._taken["pixels"]
        if self._unknown:
            share = sum(self._unknown.values()) / pixels
            notes.append(
                f"{share:.2%} of the pixels have ids without a material ({', '.join(sorted(self._unknown))}); drawn as"
                f" {self.frame.model.default_material}"
            )
        if self._taken["downward"]:
            notes.append(
                f"{self._taken['downward'] / pixels:.2%} of the pixels look further down than a slope of"
                f" {self._steepest:g} degree; their temperature is that of this slope"
            )
        return notes

    def _each(self, action: Callable[[SeenFrame], Result]) -> Iterator[tuple[str, Result]]:
        """What an action makes of each frame, in their order; threads read and compute few frames at a time."""
        marks, hours = self.frame.marks, self.frame.hours
        of_frame = [hours] if len(marks) == 1 else [[hour] for hour in hours]
        poses = self._poses * len(marks) if len(self._poses) == 1 else self._poses

        def done(mark: str, pose: Pose, of_frame: list[float]) -> tuple[SeenFrame, Result]:
            frame = self._seen(mark, pose, of_frame)
            return frame, action(frame)

        with ThreadPoolExecutor(thread_count()) as pool:
            waiting: deque[Future[tuple[SeenFrame, Result]]] = deque()
            frames = zip(marks, poses, of_frame, strict=True)
            for mark in marks:
                while len(waiting) <= thread_count() and (following := next(frames, None)) is not None:
                    waiting.append(pool.submit(done, *following))
                frame_scene, result = waiting.popleft().result()
                self._taken.update(frame_scene.counts)
                self._unknown.update(frame_scene.unknown)
                yield mark, result

    def _drawn(self, frame: SeenFrame) -> list[Picture]:
        return [
            self._frame(frame.scene, number, hour, tables)
            for number, hour in enumerate(frame.hours)
            for tables in self.tables.bands
        ]

    def _reach(self, frame: SeenFrame) -> None:
        for tables in self.tables.bands:
            check_reach(self._refuse, tables.air, frame.scene)
            for hour in frame.hours:
                source = self.tables.surface.source_track(self._source, time=hour)
                check_source(self._refuse, self._source, tables.air, hour, float(source.elevation))

    def _seen(self, mark: str, pose: Pose, hours: list[float]) -> SeenFrame:
        frame = self.frame
        depth = depth_of(frame, stored(frame, "depth", mark))
        materials = self._materials.pixels(mark, np.isfinite(depth))
        hit = np.isfinite(depth) & (materials.share.sum(axis=-1) > 0)
        view = self._views(pose, (depth.shape[1], depth.shape[0]))
        points = self._surface(mark, pose, view, np.where(hit, distances(frame.model, depth, view.length), np.inf))
        mixtures = Mixtures(self._materials.names, materials.number[hit], materials.share[hit])
        points = replace(points, materials=mixtures)
        counts = {"pixels": depth.size, "downward": int(np.sum(points.slope > self._steepest + 1e-6))}
        mask = frame.model.buffers.sunlit
        if mask is None:
            return SeenFrame(hours, self._traced(view.rays, points, hours), counts, materials.unknown)
        buffer = stored(frame, "sunlit", mark)
        check_size(frame, "sunlit", buffer, depth.shape)
        lit_share = sunlit_of(buffer)[hit]
        sky_view = 1.0 - (1.0 - lit_share) * (1.0 - mask.open_sky)
        scene = SeenScene(view.rays, points, None, lit_share, sky_view, self._by_hour(points, lit_share, hours), None)
        return SeenFrame(hours, scene, counts, materials.unknown)

    def _surface(self, mark: str, pose: Pose, view: CameraView, distance: Floats) -> SeenSurface:
        """What the pixels see at distances (rows, columns) [m], without materials."""
        frame, pixel = self.frame, np.flatnonzero(np.isfinite(distance))
        normal = self._normals(mark, pose, view, distance)
        ahead, distance = view.rays.direction[pixel], distance.ravel()[pixel]
        point = view.rays.origin[pixel] + ahead * distance[:, None]
        normal[np.einsum("nx,nx->n", normal, ahead) > 0] *= -1.0
        slope, azimuth = slope_and_azimuth(normal)
        start = point if self._mesh is None else point + normal * start_height(self._mesh.surface)
        no_materials = Mixtures((), np.zeros((len(pixel), 1), int), np.ones((len(pixel), 1)))
        altitude = frame.model.altitude_km + point[:, 2] * 1e-3
        face, weights = np.zeros(len(pixel), int), np.zeros((len(pixel), 3))  # pixels of no triangle that is known
        return SeenSurface(
            pixel, face, weights, point, normal, start, distance * 1e-3, slope, azimuth, altitude, no_materials
        )

    def _normals(self, mark: str, pose: Pose, view: CameraView, distance: Floats) -> Floats:
        """Unit normals (n, 3) of the pixels that meet a surface, to east, north and up."""
        model, hit = self.frame.model, np.isfinite(distance)
        if model.buffers.normals is None:
            return normals_from_depth(view, pose, distance / view.length)[hit]
        buffer = stored(self.frame, "normals", mark)
        check_size(self.frame, "normals", buffer, hit.shape)
        normal = normals_of(buffer, hit)[hit]
        return world(model, normal) if model.buffers.normals.space == "world" else normal @ pose.turn.T

    def _traced(self, rays: ViewRays, surface_points: SeenSurface, hours: list[float]) -> SeenScene:
        """In the light, or in the shade of the mesh."""
        lit_share, view = np.ones(len(surface_points)), np.ones(len(surface_points))
        if self._mesh is None:
            return SeenScene(
                rays, surface_points, None, lit_share, view, self._by_hour(surface_points, lit_share, hours), None
            )
        mesh, table = self._mesh, self.tables.surface

        def exposed(points: SeenSurface, kinds: WallKinds | None = None) -> SeenExposure:
            return exposure_of(points, mesh.surface, self._caster, *self._sun_of_day, silent, kinds)

        kinds = WallKinds(mesh.surface, mesh.materials)
        exposure = exposed(surface_points, kinds)
        walls = walls_of_day(table, kinds, exposed, mesh.codes, mesh.materials.shaded_sky) if len(kinds) else None
        open_sky = np.full(len(self._codes), np.nan)
        columns = SeenTemperatures.of(
            table, self._within(surface_points), exposure, self._codes, open_sky, np.array(hours), walls
        )
        kelvin = self._own(surface_points, columns.present, columns.kelvin[columns.column])
        temperatures = SeenTemperatures(columns.present, np.arange(len(kelvin)), kelvin)
        return SeenScene(rays, surface_points, exposure, lit_share, exposure.sky_view, temperatures, walls)

    def _by_hour(self, points: SeenSurface, lit_share: Floats, hours: list[float]) -> SeenTemperatures:
        """Temperatures without shadows of a mesh."""
        present, within = points.materials.share > 0, self._within(points)
        row, part = np.nonzero(present)
        number = points.materials.number[row, part]
        kelvin = np.stack(
            [
                self._temperatures(hour).at(
                    number, within.altitude[row], points.azimuth[row], within.slope[row], lit_share[row]
                )
                for hour in hours
            ],
            axis=-1,
        )
        return SeenTemperatures(present, np.arange(len(row)), self._own(points, present, kelvin))

    def _own(self, points: SeenSurface, present: Booleans, kelvin: Floats) -> Floats:
        """Temperatures (u, H) of the used materials, with those of their own."""
        stated = self._materials.temperature[points.materials.number[present]]
        return np.where(np.isfinite(stated)[:, None], stated[:, None], kelvin)

    def _within(self, points: SeenSurface) -> SeenSurface:
        """The surface with slopes and altitudes that the table of temperatures has.

        Raises
        ------
        InputError
            An altitude is farther from them than `ALTITUDE_REACH`.
        """
        table = self.tables.surface
        low, high = table.root.axes["altitude"].values[[0, -1]].astype(float)
        if len(points) and (
            points.altitude.min() < low - ALTITUDE_REACH or points.altitude.max() > high + ALTITUDE_REACH
        ):
            raise self.frame.error(
                ("altitude_km",),
                f"the surface is at {points.altitude.min():.4g} to {points.altitude.max():.4g} km, {table.path.name}"
                f" covers {low:g} to {high:g}; change it or the pose, or widen surface_grid.altitude_km of the job and"
                " build again",
            )
        return replace(
            points, altitude=np.clip(points.altitude, low, high), slope=np.minimum(points.slope, self._steepest)
        )

    @property
    def _steepest(self) -> float:
        """Slope of the table of temperatures [degree]."""
        return float(self.tables.surface.root.axes["slope"].values[-1])


@dataclass(frozen=True, eq=False)
class HourTemperatures:
    """Temperatures of materials at one hour, in the light and in the shade of a mask, at the nodes of their places.

    Between the nodes they are linear, as those of the table are.

    Attributes
    ----------
    rules : tuple of AxisRule
        Axis rules of the entry, altitude, azimuth and slope.
    sunlit : (K, A, Z, S) array
        [K]
    shaded : (K, A, Z, S) array or None
        None: all is in the light.
    """

    rules: tuple[AxisRule, ...]
    sunlit: Floats
    shaded: Floats | None

    @classmethod
    def of(cls, frame: LoadedFrame, surface: TemperatureTable, codes: Integers, hour: float) -> HourTemperatures:
        """Read a table of temperatures.

        Raises
        ------
        InputError
            There is a mask of shade, and the table has no response to it.
        """
        rules = tuple(AxisRule.of(name, surface.root.axes[name]) for name in _PLACE)
        where: dict[str, Any] = dict(
            zip(("material", *_PLACE), np.ix_(codes, *(rule.nodes for rule in rules)), strict=True)
        )
        sunlit, shaded, mask = surface.temperature(**where, time=hour), None, frame.model.buffers.sunlit
        if mask is not None:
            start = 0.0 if mask.lasts_h == 24 else (hour - mask.lasts_h) % 24
            spell = (start, 24.0 if mask.lasts_h == 24 else hour)
            change = surface.absorbed_change(**where, shade=[spell], sky_view=mask.open_sky)
            shaded = surface.temperature(**where, time=hour, absorbed_change=change)
        entry = AxisRule("entry", np.arange(len(codes)), EXACT)
        return cls((entry, *rules), sunlit, shaded)

    def at(self, number: Integers, altitude: Floats, azimuth: Floats, slope: Floats, lit_share: Floats) -> Floats:
        """Temperatures (n,) [K] of entries at places, of which a share is in the light."""
        where = dict(zip(("entry", *_PLACE), (number, altitude, azimuth, slope), strict=True))
        kelvin = interpolate(self.sunlit, self.rules, where)
        rows = np.flatnonzero(lit_share < 1)
        if self.shaded is None or not rows.size:
            return kelvin
        dark = interpolate(self.shaded, self.rules, {name: values[rows] for name, values in where.items()})
        kelvin[rows] = lit_share[rows] * kelvin[rows] + (1.0 - lit_share[rows]) * dark
        return kelvin


def _nothing() -> FewTriangles:
    """A caster of no triangles, which hides nothing."""
    return FewTriangles(SurfaceMesh(np.zeros((0, 3, 3)), np.zeros(0, int), (), np.zeros((0, 3, 2)), 0.0))
