"""Errors of one set of tables on views: one part of the whole truth replaced at a time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyshine.mat.budget.built_tables import Tables, frame_centres, vertices
from skyshine.mat.budget.circumstances import Circumstances
from skyshine.mat.budget.frames import FIELDS_OF_VIEW, frame_errors
from skyshine.mat.budget.pixel import integrated_light, integrated_readings, pixel_radiance, temperature_among
from skyshine.mat.budget.runtime_terms import (
    AtmosphereReadings,
    Emission,
    ReflectedLight,
    exact_normalisation,
    runtime_radiance,
)
from skyshine.mat.budget.truth import FacetTruth, Prepared
from skyshine.mat.budget.vertices import drawn_materials, vertex_materials
from skyshine.mat.budget.views import Views
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.facet_light import Facets
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.scene.sources import source_irradiance
from skyshine.schemas.arrays import Floats, Integers


@dataclass(frozen=True, eq=False)
class Extrapolation:
    """Errors of faces and frames: `Budget.errors`, `extrapolation` and `frames` of them."""

    errors: dict[str, Floats]
    by_field: dict[str, Floats]
    frames: dict[str, Floats]


class Measurement:
    """The truth of n views of M materials, and what tables and averages make of it.

    Parameters
    ----------
    around : Circumstances
        Circumstances of the faces.
    grid : PathGrid
        Path grid of the tables.

    Attributes
    ----------
    radiance : (n, M) array
        The truth, W m^-2 sr^-1.
    """

    def __init__(
        self,
        prepared: Prepared,
        tables: Tables,
        truth: FacetTruth,
        views: Views,
        circumstances: Circumstances,
        grid: PathGrid,
    ) -> None:
        job = prepared.loaded.trimmed
        self.prepared = prepared
        self.tables, self.truth, self.views, self.circumstances, self.grid = tables, truth, views, circumstances, grid
        self.reduced, self.steps, self.finish = (
            prepared.lit(prepared.reduced, truth.source),
            job.accuracy.solver_steps,
            tables.finish,
        )
        self.reduced_light = source_irradiance(job, truth.source, self.reduced.band.wavenumber, self.reduced.band.width)
        facets = truth.of(views, circumstances, self.finish)
        self.open_air, self.shadowed, self.kelvin = facets.open_air, facets.shadowed, facets.kelvin
        self.lines, self.bounce, self.radiance = facets.lines, facets.bounce, facets.radiance
        self.full, self.light = integrated_readings(truth, facets), integrated_light(tables, truth, facets)
        self.emission = tables.emission(self.kelvin)
        self.base = self._shown(self.full)

    def _shown(
        self,
        readings: AtmosphereReadings,
        emission: Emission | None = None,
        bounce: Floats | None = None,
        light: ReflectedLight | None = None,
    ) -> Floats:
        """Radiance of the runtime's equations, by default with the true temperatures and lobes, and with the true
        spectrum of reflected light where its tables have one.
        """
        bounce = self.bounce if bounce is None else bounce
        return runtime_radiance(readings, emission or self.emission, bounce, self.finish, light or self.light)

    @cached_property
    def _level(self) -> AtmosphereReadings:
        """Quantities of level faces in the open, computed at the few points."""
        direct = AtmosphereReadings.of(self.reduced.at_points(self.views.lines, self.reduced_light))
        return replace(direct, emitted=self.full.emitted)

    @cached_property
    def _among_walls(self) -> AtmosphereReadings:
        """Quantities of the faces, computed at the few points."""
        walls = self.truth.light_of_walls(self.views, self.circumstances)[:, None] * self._level.direct
        return replace(self._level, ambient=self._ambient(self.circumstances) + walls)

    @cached_property
    def _in_the_open(self) -> Floats:
        """Ambient radiance (n, 1) of the faces without their walls."""
        return self._ambient(None) if self.circumstances.walled.any() else self._among_walls.ambient

    def _ambient(self, circumstances: Circumstances | None) -> Floats:
        faces = self.truth.faces(self.views, circumstances)
        return self.reduced.ambient_on_faces(self.views.lines, self.reduced_light, faces)[:, None]

    @cached_property
    def _direct(self) -> Floats:
        """Radiance with everything computed at the few points."""
        return self._shown(self._among_walls)

    @cached_property
    def _read(self) -> AtmosphereReadings:
        return self.tables.readings(self.views, self.kelvin)

    @cached_property
    def _level_read(self) -> Floats:
        return self.tables.level_ambient(self.views)

    @cached_property
    def _solved_in_steps(self) -> Floats:
        """Temperatures in the open with the solver's steps of the job."""
        views = self.views
        return self.truth.temperature(views.normal, views.surface_altitude, views.time, steps=self.steps)

    @cached_property
    def _temperatures_read(self) -> tuple[Floats, Floats, Floats]:
        """Temperatures of a runtime: in the open, under shadows alone, and under shadows and beside walls."""
        tables, views = self.tables, self.views
        in_the_open = tables.temperature(views)
        if not tables.shades:
            return in_the_open, in_the_open, in_the_open
        shadowed = tables.temperature(
            views, absorbed_change=tables.absorbed_change(views, self.circumstances.shadows_alone)
        )
        return in_the_open, shadowed, temperature_among(tables, views, self.circumstances)

    def of_light(self) -> dict[str, Floats]:
        """The few spectral points, the reflectance that goes with emission, and the wavelengths at which emitted and
        reflected light lies.
        """
        by_wavelength = self.tables.emitted_transmittance(self.views, self.kelvin)
        emitted = self._shown(replace(self._among_walls, emitted=by_wavelength)) - self._direct
        light = self.tables.reflected_light(self.views, self.circumstances)
        return {
            "compiled_band": self._direct - self.base,
            "reflectance": self.base - self.radiance,
            "emitted_transmittance": np.where(self.views.near[:, None], 0.0, emitted),
            "reflected_wavelengths": self._shown(self._among_walls, light=light) - self._direct,
        }

    def of_temperatures(self) -> dict[str, Floats]:
        """The solver's steps, their table, and the response to shadows and walls."""
        in_the_open, shadowed, beside = self._temperatures_read
        changes = {
            "solver_steps": self._solved_in_steps - self.open_air,
            "temperature_table": in_the_open - self._solved_in_steps,
            "shade": shadowed - in_the_open - (self.shadowed - self.open_air),
            "surroundings": beside - shadowed - (self.kelvin - self.shadowed),
        }
        errors = {name: self.warmer(change) - self.base for name, change in changes.items()}
        ambient = self.tables.among_walls(self.views, self.circumstances, self._in_the_open, self._level.ambient)
        errors["surroundings"] += self._shown(replace(self._among_walls, ambient=ambient)) - self._direct
        return errors

    def warmer(self, change: Floats) -> Floats:
        """Radiance with temperatures changed by (n, M) [K]."""
        return self._shown(self.full, self.tables.emission(self.kelvin + change))

    def of_ambient(self, light: Floats) -> Floats:
        """Radiance of more ambient light (n, 1) [W m^-2 sr^-1] on all materials."""
        reflected: Floats = light * self.finish.reflectance * self.full.transmittance
        return reflected

    def reflected_by(self, bounce: Floats) -> Floats:
        """Radiance with another reflection (n, M) of the direct light."""
        return self._shown(self.full, bounce=bounce)

    def at_range(self, distance: Floats) -> Floats:
        """Radiance over other ranges (n,) [km] along the same lines."""
        return self._shown(self.full.at_range(self.views.range, distance))

    def of_atmosphere(self) -> dict[str, Floats]:
        """Interpolation: of each quantity, then of all; against direct computation with the same points."""
        direct, read, near = self._among_walls, self._read, self.views.near[:, None]
        level_error = self._level_read - self._level.ambient
        # What harmonics give with the level value computed directly.
        level_error *= self.tables.level_share(self.views.normal)
        tilt_error = read.ambient - self._in_the_open - level_error
        emitted = read.emitted
        assert emitted is not None  # read at temperatures
        paths = {"transmittance": read.transmittance, "path_radiance_ratio": read.path_radiance_ratio}
        changes = {
            "beta_star_table": {"transmittance": read.transmittance},
            "path_radiance_table": {"path_radiance_ratio": read.path_radiance_ratio},
            "near_range": paths | {"emitted": emitted},
            "ambient_table": {"ambient": direct.ambient + level_error},
            "tilted_sky": {"ambient": direct.ambient + tilt_error},
            "direct_table": {"direct": read.direct},
        }
        errors = {name: self._shown(replace(direct, **change)) - self._direct for name, change in changes.items()}
        for name in ("beta_star_table", "path_radiance_table"):
            errors[name] = np.where(near, 0.0, errors[name])
        errors["near_range"] = np.where(near, errors["near_range"], 0.0)
        warmer = self.tables.emission(self.kelvin + self._temperatures_read[0] - self._solved_in_steps)
        everything = replace(read, ambient=direct.ambient + level_error + tilt_error)
        errors["tables"] = self._shown(everything, warmer) - self._direct
        return errors

    def pixel(self) -> Floats:
        """Error of a runtime that reads all tables at the pixel."""
        kelvin = self._temperatures_read[-1]
        return pixel_radiance(self.tables, self.truth, self.views, self.circumstances, kelvin) - self.radiance

    def of_normalisation(self) -> Floats:
        """The mean N_s, as a runtime reads it, for that of the very angle."""
        bounce = self.truth.bounce(self.views, self.views.normal, self.finish, self.circumstances)
        return self._shown(self.full, bounce=bounce) - self.base

    def of_materials(self) -> dict[str, Floats]:
        """Change of radiance where a texture names another material, (n, M, M)."""
        if self.tables.assigned_share is None:
            return {}
        return {"misclassification": self.base[:, None, :] - self.base[:, :, None]}

    def of_vertices(self, generator: np.random.Generator) -> dict[str, Floats]:
        """Black-body radiance between two vertices of a face, each of the material of one texel of the textures.

        All else is that of the pixel, as is the change of temperature by shadows and walls.
        """
        shares = vertex_materials(self.tables.textures, self.tables.materials, generator)
        if not shares:
            return {}
        views, change = self.views, self.kelvin - self._solved_in_steps
        errors = dict.fromkeys(shares, -self.base)
        flat = replace(views, bend=np.zeros(len(views)))
        for end, weight in zip(vertices(flat, self.grid, self.tables), (1 - views.share, views.share), strict=True):
            kelvin = self.truth.temperature(end.normal, end.surface_altitude, views.time, steps=self.steps) + change
            blackbody = self.tables.blackbody(kelvin)
            for name, share in shares.items():
                chosen = drawn_materials(share, generator, kelvin.shape)
                emission = replace(self.emission, blackbody=np.take_along_axis(blackbody, chosen, axis=1))
                errors[name] = errors[name] + weight[:, None] * self._shown(self.full, emission)
        return errors

    def of_weather(self) -> dict[str, Floats]:
        """Paths and sky through the job's air in place of that which the weather has at the hour; thermal light alone.

        Raises
        ------
        InputError
            Air cannot be as the weather says.
        """
        if self.prepared.has_air_of_an_hour:
            return {}
        views, faces = self.views, self.truth.faces(self.views, self.circumstances)
        of_job = replace(self.reduced, air=replace(self.reduced.air, scatters=False))
        error = np.empty(self.kelvin.shape)
        for hour in np.unique(views.time):
            rows = views.time == hour
            part, selected = views.take(rows), faces.take(rows)
            airs = of_job, self.prepared.at_hour(float(hour))
            radiances = [self._shown_through(air, part, selected, np.flatnonzero(rows)) for air in airs]
            error[rows] = radiances[0] - radiances[1]
        return {"weather_of_the_air": error}

    def of_continua(self) -> dict[str, Floats]:
        """Paths and sky with another water vapour continuum of MT_CKD in place of the job's, whichever changes most;
        thermal light alone.
        """
        if not self.prepared.others:
            return {}
        faces, atmospheres = self.truth.faces(self.views, self.circumstances), (self.reduced, *self.prepared.others)
        thermal = [replace(air, air=replace(air.air, scatters=False)) for air in atmospheres]
        reference, *others = (
            self._shown_through(air, self.views, faces, np.arange(len(self.views))) for air in thermal
        )
        changes = np.array(others) - reference
        largest: Floats = np.take_along_axis(changes, np.abs(changes).argmax(axis=0)[None], axis=0)[0]
        return {"water_continuum": largest}

    def _shown_through(self, air: BandAtmosphere, part: Views, faces: Facets, rows: Integers) -> Floats:
        """Radiance of some of the views through other air, with the true temperatures."""
        readings = AtmosphereReadings.of(air.at_points(part.lines, self.reduced_light))
        ambient = air.ambient_on_faces(part.lines, self.reduced_light, faces)[:, None]
        assert self.full.emitted is not None  # integrated
        ratio = readings.transmittance / np.maximum(self._level.transmittance[rows], np.finfo(float).tiny)
        readings = replace(readings, ambient=ambient, emitted=self.full.emitted[rows] * ratio)
        emission = Emission(self.emission.blackbody[rows], self.emission.reflectance[rows])
        return runtime_radiance(readings, emission, self.bounce[rows], self.finish)

    def of_frames(self, generator: np.random.Generator) -> Extrapolation:
        """Faces, extrapolation from the centre pixel, and everything together.

        The change of temperature by shadows and walls is that at the pixel.
        """
        tables, views = self.tables, self.views
        pixel = replace(self._level, ambient=self._tilted(self._level, views).ambient)
        here = self._shown(pixel)
        ends = vertices(views, self.grid, tables)
        errors = {"face": self._across_faces(pixel, ends) - here}
        offset = generator.uniform(-0.5, 0.5, (2, len(views)))
        chosen = generator.integers(len(FIELDS_OF_VIEW), size=len(views))
        assigned = drawn_materials(tables.assigned_share, generator, (here.shape[0], here.shape[1]))
        parts: dict[str, list[Floats]] = {"transmittance_extrapolation": [], "radiance_extrapolation": []}
        together = np.empty_like(here)
        for number, width in enumerate(FIELDS_OF_VIEW):
            centre = frame_centres(views, self.grid, offset * width)
            at_centre = AtmosphereReadings.of(self.reduced.at_points(centre.lines, self.reduced_light))
            at_centre = self._tilted(at_centre, centre)
            through = at_centre.at_range(centre.range, views.range).transmittance
            extrapolated = (
                pixel.with_transmittance(through),
                replace(at_centre, transmittance=pixel.transmittance, emitted=pixel.emitted),
            )
            for name, readings in zip(parts, extrapolated, strict=True):
                parts[name].append(self._shown(readings) - here)
            rows = chosen == number
            together[rows] = self._all_together(ends, centre, assigned)[rows]
        by_field = {name: np.array(values) for name, values in parts.items()}
        row = np.arange(len(views))
        errors |= {name: values[chosen, row] for name, values in by_field.items()}
        errors["all"] = together - self.radiance
        frames = frame_errors(tables, views, self.grid, offset, here, self._shown, self.kelvin)
        return Extrapolation(errors, by_field, frames)

    def _tilted(self, readings: AtmosphereReadings, views: Views) -> AtmosphereReadings:
        """Readings of level faces with the difference that the tables give for the faces of views."""
        tilt = self.tables.readings(views).ambient - self.tables.level_ambient(views)
        return replace(readings, ambient=readings.ambient + tilt)

    def _across_faces(self, pixel: AtmosphereReadings, ends: tuple[Views, Views]) -> Floats:
        """Radiance (n, M) interpolated between the vertices, with quantities and temperatures computed there."""
        views, radiance = self.views, np.zeros(self.kelvin.shape)
        for end, weight in zip(ends, (1 - views.share, views.share), strict=True):
            kelvin = self.truth.temperature(end.normal, end.surface_altitude, views.time, steps=self.steps)
            emission = self.tables.emission(kelvin + self.kelvin - self._solved_in_steps)
            readings = AtmosphereReadings.of(self.reduced.at_points(end.lines, self.reduced_light))
            readings = self._tilted(
                replace(readings, emitted=pixel.with_transmittance(readings.transmittance).emitted), end
            )
            exact = exact_normalisation(self.finish.shininess, views, end.normal)
            bounce = self.truth.bounce(views, end.normal, replace(self.finish, normalisation=exact), self.circumstances)
            radiance = radiance + weight[:, None] * self._shown(readings, emission, bounce)
        return radiance

    def _all_together(self, ends: tuple[Views, Views], centre: Views, assigned: Integers) -> Floats:
        """Radiance (n, M) of a runtime: tables at the centre pixel, vertices, mean N_s, materials of the textures."""
        tables, views = self.tables, self.views
        in_the_open, _, beside = self._temperatures_read
        read = tables.readings(centre, beside)
        level = tables.level_ambient(centre)
        read = replace(read, ambient=tables.among_walls(views, self.circumstances, read.ambient, level))
        total = np.zeros(assigned.shape)
        for end, weight in zip(ends, (1 - views.share, views.share), strict=True):
            emission = tables.emission(tables.temperature(end) + beside - in_the_open)
            bounce = self.truth.bounce(views, end.normal, self.finish, self.circumstances)
            values = self._shown(read.at_range(centre.range, end.range), emission, bounce)
            total = total + weight[:, None] * np.take_along_axis(values, assigned, axis=1)
        return total
