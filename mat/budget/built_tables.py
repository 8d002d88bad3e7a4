"""Reading built databases as a runtime does: at the pixel, the centre of its frame and the vertices of its face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS
from skyshine.mat.budget.circumstances import Circumstances
from skyshine.mat.budget.runtime_terms import AtmosphereReadings, Emission, Finish, ReflectedLight, ratio
from skyshine.mat.budget.views import Views, on_axes
from skyshine.mat.job.model import Job
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction, slope_and_azimuth
from skyshine.mat.radiometry.spherical_harmonics import level_share
from skyshine.mat.runtime.by_wavelength import emitted_share, reflected
from skyshine.mat.runtime.walls import beside_walls, wall_as_it_shines
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.tables import response
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS
from skyshine.mat.tables.band import BandSpectra, BandTable
from skyshine.mat.tables.files import atmosphere_file, band_file, state_file
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.loader import open_as
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import open_tmm

# The centre of a frame looks at the ground of the same altitude; where that is further off, or not at all, it looks at
# something this many times as far as the pixel.
_FARTHEST = 3.0
_BUILD_AGAIN = "build the job again: mat build"


@dataclass(frozen=True, eq=False)
class Tables:
    """The databases of one state, band and source, with the texture databases of the job."""

    surface: TemperatureTable
    band: BandTable
    air: AtmosphereTable
    assigned_share: Floats | None
    textures: tuple[Path, ...] = ()

    @classmethod
    def open(cls, folder: Path, state: int, band: int, source: str, job: Job) -> Tables:
        """Open the databases that the job's build has written.

        Raises
        ------
        InputError
            One is missing or damaged, or two contain different materials.
        """
        names = [
            state_file(state, len(job.states)),
            band_file(band),
            atmosphere_file(state, band, source, len(job.states)),
        ]
        for name in names:
            if not (folder / name).is_file():
                raise InputError(f"has no {name}; build the job first: mat build", file=folder)
        surface = open_as(TemperatureTable, folder / names[0], _BUILD_AGAIN)
        properties = open_as(BandTable, folder / names[1], _BUILD_AGAIN)
        air = open_as(AtmosphereTable, folder / names[2], _BUILD_AGAIN)
        if list(surface.materials.values()) != list(properties.materials.values()):
            raise InputError(f"{names[0]} and {names[1]} contain different materials; build the job again", file=folder)
        textures = [folder / f"{texture.name}.tmm.h5" for texture in job.texture_jobs]
        textures += job.finished_textures
        textures = [file for file in textures if file.is_file()]
        share = _assigned_shares(textures, list(surface.materials))
        return cls(surface, properties, air, share, tuple(textures))

    @property
    def materials(self) -> tuple[str, ...]:
        """Names, in the order of the tables."""
        return tuple(self.surface.materials)

    @property
    def surface_axes(self) -> dict[str, Floats]:
        """Nodes of the temperature table's axes of place and time."""
        return {
            name: np.asarray(self.surface.root.axes[name].values, float)
            for name in ("altitude", "azimuth", "slope", "time")
        }

    @property
    def finish(self) -> Finish:
        """Band means of the materials."""
        names = ("reflectance", "specular_fraction", "shininess", "normalisation")
        return Finish(*(self.band.root.variables[name].data.astype(float) for name in names))

    @property
    def shades(self) -> bool:
        """Whether the temperatures come with their response to shadows and walls."""
        return response.KERNEL in self.surface.root.variables

    def absorbed_change(self, views: Views, surroundings: Sequence[Surroundings]) -> Floats:
        """Change of the absorbed heat of all materials by the surroundings of the faces, (n, M, steps) [W m^-2]."""
        slope, azimuth = slope_and_azimuth(views.normal)
        altitude = np.clip(views.surface_altitude, *self.surface_axes["altitude"][[0, -1]])
        codes = np.array(list(self.surface.materials.values()))
        return np.array(
            [
                self.surface.absorbed_change(
                    material=codes,
                    altitude=altitude[row],
                    azimuth=azimuth[row],
                    slope=slope[row],
                    shade=surrounding.shade,
                    sky_view=surrounding.sky_view,
                    facing=surrounding.facing,
                    facing_emissivity=surrounding.facing_emissivity,
                )
                for row, surrounding in enumerate(surroundings)
            ]
        )

    def temperature(self, views: Views, absorbed_change: Floats | None = None) -> Floats:
        """Interpolated temperatures (n, M) [K], of surfaces in the open or under a change of absorbed heat (n, M,
        steps) [W m^-2].
        """
        slope, azimuth = slope_and_azimuth(views.normal)
        codes = np.array(list(self.surface.materials.values()))
        columns = {"altitude": views.surface_altitude, "azimuth": azimuth, "slope": slope, "time": views.time}
        return self.surface.clamped().temperature(
            material=codes,
            absorbed_change=absorbed_change,
            **{name: values[:, None] for name, values in columns.items()},
        )

    def emission(self, temperature: Floats) -> Emission:
        """What the materials emit at temperatures (n, M) [K], with their reflectance weighted by Planck radiance."""
        codes = np.array(list(self.band.materials.values()))
        reflectance = self.band.clamped().value("reflectance_planck", material=codes, planck_temperature=temperature)
        return Emission(self.blackbody(temperature), reflectance)

    def blackbody(self, temperature: Floats) -> Floats:
        """Band radiance of black bodies."""
        return self.band.blackbody_radiance(temperature)

    @cached_property
    def _air(self) -> AtmosphereTable:
        """The air, read at the ends of its axes beyond them."""
        return self.air.clamped()

    def readings(self, views: Views, temperature: Floats | None = None) -> AtmosphereReadings:
        """Interpolated quantities of views; with temperatures (n, M) [K], the transmittance of what surfaces emit
        too.
        """
        lines, air = views.lines, self._air
        tau = self._transmittance(lines)
        ambient = self._of_faces(views) if self.has_harmonics else air.value("ambient_radiance", **lines.lit)
        values = (
            air.value("path_radiance_ratio", **lines.whole),
            ambient,
            air.value("direct_radiance", **lines.lit),
        )
        emitted = None if temperature is None else self.emitted_transmittance(views, temperature)
        through, ratio, ambient, direct = (value[:, None] for value in (tau, *values))
        return AtmosphereReadings(through, ratio, ambient, direct, emitted)

    @property
    def has_harmonics(self) -> bool:
        """Whether the air contains ambient light of tilted faces."""
        return AMBIENT_HARMONICS in self.air.quantities

    def _transmittance(self, lines: LinesOfSight) -> Floats:
        return self.air.transmittance(range=lines.range, beta_star=self._air.value("beta_star", **lines.path))

    def _of_faces(self, views: Views, *, by_wavelength: bool = False) -> Floats:
        """Ambient radiance of the faces of views: (n,), or by wavelength (n, B)."""
        slope, azimuth = slope_and_azimuth(views.normal)
        kelvin = self.air.ground_temperature(self.surface, time=views.time)
        turn = azimuth - views.source_azimuth
        return self._air.ambient_radiance(
            slope=slope,
            azimuth=turn,
            ground_temperature=kelvin,
            band=self.band,
            by_wavelength=by_wavelength,
            **views.lines.lit,
        )

    def level_ambient(self, views: Views) -> Floats:
        """Interpolated ambient radiance (n, 1) of level faces at the ends of views."""
        return self._air.value("ambient_radiance", **views.lines.lit)[:, None]

    def level_share(self, normal: Floats) -> Floats:
        """Change of the ambient light read for faces with normals (n, 3), (n, 1), over that of level faces."""
        if not self.has_harmonics:
            return np.ones((len(normal), 1))
        return level_share(normal[:, 2:], self.air.root.axes["harmonic"].values.size)

    def among_walls(self, views: Views, circumstances: Circumstances, ambient: Floats, level: Floats) -> Floats:
        """Ambient radiance (n, 1) of faces beside walls, from that in the open and that of level faces there."""
        kelvin = self.air.ground_temperature(self.surface, time=views.time)
        shines = self.wall_temperature(views, circumstances)
        wall, ground = (self.blackbody(np.asarray(k))[:, None] for k in (shines, kelvin))
        return _among_walls(views, circumstances, ambient, level, wall, ground)

    def wall_temperature(self, views: Views, circumstances: Circumstances) -> Floats:
        """Temperature (n,) [K] of walls without sunlight that shine as those of the faces do."""
        level = self.level_ambient(views)[:, 0]
        direct = self._air.value("direct_radiance", **views.lines.lit)
        ground = self.blackbody(np.asarray(self.air.ground_temperature(self.surface, time=views.time)))
        emissivity = circumstances.wall_emissivity
        return wall_as_it_shines(
            self.band,
            emissivity * self.blackbody(circumstances.wall_temperature),
            1 - emissivity,
            0.5 * (level + ground),
            (1 - emissivity) * circumstances.wall_beam * direct,
        )

    def emitted_transmittance(self, views: Views, temperature: Floats) -> Floats:
        """Transmittance (n, M) of what the materials emit at their temperatures (n, M)."""
        spectra, through = self._spectra(temperature), self._through_by_wavelength(views.lines)
        black = np.sum((1.0 - spectra.reflectance) * spectra.emission, axis=-1)
        return ratio(emitted_share(spectra, through), black)

    def reflected_light(self, views: Views, circumstances: Circumstances) -> ReflectedLight:
        """Light that the materials reflect by wavelength, of faces beside walls."""
        lines = views.lines
        level, direct = (
            self._air.value_by_wavelength(name, **lines.lit) for name in ("ambient_radiance", "direct_radiance")
        )
        ambient = self._of_faces(views, by_wavelength=True) if self.has_harmonics else level
        through, tau = self._through_by_wavelength(lines), self._transmittance(lines)
        kelvin = self.air.ground_temperature(self.surface, time=views.time)

        def glow(temperature: Floats) -> Floats:
            """Glow of a black body beside the faces, by wavelength (n, B)."""
            share = self._spectra(np.asarray(temperature)[:, None]).emission[:, 0]
            return self.blackbody(np.asarray(temperature))[:, None] * share * ratio(through, tau[:, None])

        ambient = _among_walls(
            views,
            circumstances,
            ambient,
            level,
            glow(self.wall_temperature(views, circumstances)),
            glow(np.asarray(kelvin)),
        )
        spectra = self._spectra(np.asarray(kelvin)[:, None])
        mean = self.finish.reflectance
        return ReflectedLight(
            ratio(reflected(spectra, ambient), mean * ambient.sum(axis=-1, keepdims=True)),
            ratio(reflected(spectra, direct), mean * direct.sum(axis=-1, keepdims=True)),
        )

    def _through_by_wavelength(self, lines: LinesOfSight) -> Floats:
        """Transmittance (n, B) of emitted light."""
        through: Floats = np.exp(-self._air.value_by_wavelength("optical_depth", **lines.path))
        return through

    def _spectra(self, temperature: Floats) -> BandSpectra:
        """Spectra of all materials at temperatures (n, M) [K], or of any number of them, (n, 1)."""
        return self.band.spectra(material=np.array(list(self.band.materials.values())), temperature=temperature)


def _among_walls(
    views: Views, circumstances: Circumstances, ambient: Floats, level: Floats, wall: Floats, ground: Floats
) -> Floats:
    """Ambient light of faces beside walls, from that in the open, that of level faces, and what black bodies with the
    temperatures of walls, without sunlight on them, and ground emit: (n, 1), or (n, B) by wavelength.
    """
    return beside_walls(ambient, level, wall, ground, circumstances.sky_view, views.normal[:, 2])


def _assigned_shares(files: list[Path], names: list[str]) -> Floats | None:
    """Share of the texels of each material that the classifier assigns to each material, (M, M), from held-out seeds.

    Texels assigned to no material, or to one that is not built, are not counted. A material that was not tested counts
    as always right.
    """
    total = np.zeros((len(names), len(names)))
    index = {name: number for number, name in enumerate(names)}
    for file in files:
        with open_tmm(file) as texture:
            labels, confusion = list(texture.materials.values()), texture.array("quality/confusion")[:, 1:]
        numbers = [number for number, name in enumerate(labels) if name in index]
        rows = [index[labels[number]] for number in numbers]
        total[np.ix_(rows, rows)] += confusion[np.ix_(numbers, numbers)]
    if not total.any():
        return None
    tested = total.sum(axis=1) > 0
    total[~tested] = np.eye(len(names))[~tested]
    shares: Floats = total / total.sum(axis=1, keepdims=True)
    return shares


def vertices(views: Views, grid: PathGrid, tables: Tables) -> tuple[Views, Views]:
    """The two vertices between which a pixel's radiance is interpolated."""
    start, second = (_face_point(views, grid, tables, share) for share in (-views.share, 1 - views.share))
    return start, second


def _face_point(views: Views, grid: PathGrid, tables: Tables, share: Floats) -> Views:
    """Views of the point of the face that is `share` (n,) of its length from the pixel."""
    step = views.along * (share * views.face)[:, None] * 1e-3
    line = direction(views.elevation, views.heading) * views.range[:, None] + step
    distance = np.linalg.norm(line, axis=1)
    # The Earth curves too little along a face to be seen: only the difference to the pixel counts.
    elevation = views.elevation + np.degrees(
        np.arcsin(np.clip(line[:, 2] / distance, -1, 1)) - np.arcsin(np.sin(np.radians(views.elevation)))
    )
    normal = views.normal + views.along * (np.tan(views.bend) * share)[:, None]
    low, high = tables.surface_axes["altitude"][[0, -1]]
    return replace(
        views,
        range=np.clip(distance, grid.range_km[0], grid.range_km[-1]),
        elevation=np.clip(elevation, grid.elevation_deg[0], grid.elevation_deg[-1]),
        heading=np.degrees(np.arctan2(line[:, 0], line[:, 1])),
        surface_altitude=np.clip(views.surface_altitude + step[:, 2], low, high),
        normal=on_axes(normal / np.linalg.norm(normal, axis=1, keepdims=True), tables.surface_axes),
    )


def frame_centres(views: Views, grid: PathGrid, offset: Floats) -> Views:
    """Views of the centre pixels, `offset` (2, n) degree across and down from the views."""
    elevation = np.clip(views.elevation + offset[1], grid.elevation_deg[0], grid.elevation_deg[-1])
    heading = views.heading + offset[0] / np.maximum(np.cos(np.radians(views.elevation)), 0.05)
    start, end = (EARTH_RADIUS * 1e-3 + altitude for altitude in (views.altitude, views.surface_altitude))
    sine = np.sin(np.radians(elevation))
    inside = (start * sine) ** 2 - (start**2 - end**2)
    level = -start * sine - np.sqrt(np.maximum(inside, 0.0))
    far = _FARTHEST * views.range
    distance = np.where((inside >= 0) & (level > 0), np.minimum(level, far), far)
    distance = np.clip(distance, grid.range_km[0], grid.range_km[-1])
    return replace(views, range=distance, elevation=elevation, heading=heading)
