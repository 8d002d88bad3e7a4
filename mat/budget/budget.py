"""The error budget of a built database: each source of error switched on alone, and all together.

The reference is the spectral integral over all points of the band, at the pixel itself, with temperatures solved there.
The sources are those of DSTO-TN-0193; each error is the change of radiance that one source makes alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.budget.built_tables import Tables, ViewLine, frame_centres, vertices
from skyshine.mat.budget.columns import temperatures_at
from skyshine.mat.budget.options import (
    FIELDS_OF_VIEW,
    BudgetViews,
    Option,
    frame_errors,
    options_of_averages,
    options_of_frames,
)
from skyshine.mat.budget.runtime_terms import (
    AtmosphereReadings,
    Finish,
    exact_normalisation,
    reflection,
    runtime_radiance,
    spectral_radiance,
)
from skyshine.mat.budget.views import Views, random_views, slope_and_azimuth
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.surface import at_kelvin
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.facet_light import Faces
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.spherical_harmonics import face_normal
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.sources import source_irradiance
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.arrays import Floats, Integers

FINE_STEPS = 288  # solver times of the reference temperatures
SOURCES = {
    "reflectance": "reflectance averaged over the band, outside the integral",
    "transmittance": "transmittance of the thermal term outside the integral",
    "compiled_band": "few spectral points in place of all",
    "solver_steps": "the heat balance at the job's solver_steps in place of 288 a day",
    "temperature_table": "interpolation of T",
    "beta_star_table": "interpolation of beta*",
    "path_radiance_table": "interpolation of L_path/(1 - tau)",
    "ambient_table": "interpolation of L_ambient",
    "tilted_sky": "sky of tilted faces: harmonics in place of the integral over a face's own hemisphere",
    "direct_table": "interpolation of L_direct",
    "tables": "interpolation of all five",
    "face": "radiance of the vertices interpolated across the face",
    "transmittance_extrapolation": "transmittance from beta* of the centre pixel",
    "radiance_extrapolation": "path, ambient and direct radiance from the centre pixel",
    "normalisation": "N_s averaged over source angles",
    "misclassification": "material codes of the textures",
    "all": "all together, as a runtime has them",
}


@dataclass(eq=False)
class Budget:
    """Errors of one state, band and source.

    Attributes
    ----------
    state, band : int
        Counted from 1.
    source : str
    materials : tuple of str
    views : Views
    response : SpectralResponse
    radiance : (n, M) array
        The reference, W m^-2 sr^-1.
    errors : dict of str to (n, M) array
        Of each source (`SOURCES`), W m^-2 sr^-1; that of misclassification (n, M, M), by the material
        assigned.
    assigned_share : (M, M) array or None
        Share of the texels of each material that the classifier assigns to each material.
    extrapolation : dict of str to (F, n, M) array
        The two errors of extrapolation for each of `FIELDS_OF_VIEW`.
    frames : dict of str to (F, n, M) array
        Errors of the stored tables off the centre of a frame, for each of `options.READINGS` and `FIELDS_OF_VIEW`.
    options : dict of str to Option
        Errors before and after other tables and readings, and what these cost.
    """

    state: int
    band: int
    source: str
    materials: tuple[str, ...]
    views: Views
    response: SpectralResponse
    radiance: Floats
    errors: dict[str, Floats] = field(default_factory=dict)
    assigned_share: Floats | None = None
    extrapolation: dict[str, Floats] = field(default_factory=dict)
    frames: dict[str, Floats] = field(default_factory=dict)
    options: dict[str, Option] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A state and band of a job, at all spectral points and at the few that its tables were computed with."""

    loaded: LoadedJob
    state: int
    band: int
    response: SpectralResponse
    exact: BandAtmosphere
    few: BandAtmosphere

    @classmethod
    def of(cls, loaded: LoadedJob, state: int, band: int) -> Prepared:
        """Prepare a state and band, counted from 1."""
        loaded = loaded.on_date_of_state(state)
        job, response = loaded.trimmed, response_of(loaded.trimmed.bands[band - 1])
        air = over_ground(atmospheric_state(job.site, job.states[state - 1]), job.states[state - 1], response)
        everything = band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
        compiled, _ = compiled_band(loaded, air, everything)
        exact, few = (BandAtmosphere.of(air, points) for points in (everything, compiled.band))
        return cls(loaded, state, band, response, exact, few)


def error_budget(
    prepared: Prepared, folder: Path, library: MaterialLibrary, *, source: str, scenes: int, seed: int
) -> Budget | None:
    """Measure the errors of one set of tables.

    Parameters
    ----------
    folder : Path
        Of the built databases.
    source : {'sun', 'moon'}
    scenes, seed : int
        Number of random views, and what they are drawn with.

    Returns
    -------
    Budget or None
        None where the tables leave no room for a view with the source above the horizon.

    Raises
    ------
    InputError
        A database is missing or does not belong to the job.
    """
    job = prepared.loaded.trimmed
    tables = Tables.open(folder, prepared.state, prepared.band, source, job)
    scene = _Scene(prepared, library, tables, source)
    views = random_views(job, source, scene.grid, tables.surface_axes, prepared.exact.air.shells, scenes, seed)
    if not len(views):
        return None
    return scene.budget(views, random_stream(seed, Stream.BUDGET))


class _Scene:
    """Tables, materials and forcing of the budget of one state, band and source."""

    def __init__(self, prepared: Prepared, library: MaterialLibrary, tables: Tables, source: str) -> None:
        job = prepared.loaded.trimmed
        self.tables, self.source = tables, source
        self.state, self.band = prepared.state, prepared.band
        self.response, self.grid = prepared.response, path_grid(job)
        self.exact, self.few = prepared.exact, prepared.few
        self.ground_material = job.states[prepared.state - 1].ground_material
        self.light, self.few_light = (
            source_irradiance(job, source, air.band.wavenumber, air.band.width) for air in (self.exact, self.few)
        )
        chosen = [library[name] for name in tables.materials]
        self.materials, self.inputs = surface_materials(chosen, job.operated), scene_inputs(job, prepared.state)
        self.given = {name: at_kelvin(celsius) for name, celsius in job.temperatures_c.items()}
        self.steps = job.accuracy.solver_steps
        micron = 1e4 / self.exact.band.wavenumber
        self.reflectance = np.array([np.interp(micron, m.wavelength, m.reflectance) for m in chosen])

    def budget(self, views: Views, generator: np.random.Generator) -> Budget:
        band, tables, finish = self.exact.band, self.tables, self.tables.finish
        place = (views.range, views.altitude, views.elevation, views.source_elevation, views.relative_azimuth)
        faces = self._faces(views)
        lines = self.exact.spectral_at_points(*place, self.light, faces)
        best = self._finish(views, views.normal)
        bounce = reflection(views, views.normal, best)
        fine, coarse = (
            self._temperature(views, views.normal, views.surface_altitude, steps) for steps in (FINE_STEPS, self.steps)
        )
        truth = spectral_radiance(lines, band, fine, self.reflectance, bounce)
        full, level = (
            AtmosphereReadings.integrated(lines, band),
            AtmosphereReadings.of(self.few.at_points(*place, self.few_light)),
        )
        few = replace(level, ambient=self.few.ambient_on_faces(*place[:4], self.few_light, faces)[:, None])
        read = tables.readings(views)
        glow = tables.blackbody(fine)
        base = runtime_radiance(full, glow, bounce, finish)
        budget = Budget(self.state, self.band, self.source, tables.materials, views, self.response, truth)
        flat = np.repeat(finish.reflectance[:, None], band.weight.size, axis=1)
        outside = np.repeat(full.transmittance, band.weight.size, axis=1)
        errors = budget.errors
        errors["reflectance"] = spectral_radiance(lines, band, fine, flat, bounce) - truth
        errors["transmittance"] = spectral_radiance(lines, band, fine, self.reflectance, bounce, outside) - truth
        errors["compiled_band"] = runtime_radiance(few, glow, bounce, finish) - base
        errors["solver_steps"] = runtime_radiance(full, tables.blackbody(coarse), bounce, finish) - base
        self._of_tables(budget, views, coarse, few, level, read, bounce)
        self._of_faces_and_frames(budget, views, coarse, self._tilted(level, views), bounce, generator)
        mean = reflection(views, views.normal, finish)
        errors["normalisation"] = runtime_radiance(full, glow, mean, finish) - base
        self._of_materials(budget, full, glow, bounce, best)
        seen = BudgetViews(views, lines, band, self.reflectance, fine, glow, bounce, full, truth, base)
        budget.options = options_of_averages(tables, seen, errors["normalisation"]) | budget.options
        return budget

    def _finish(self, views: Views, normal: Floats) -> Finish:
        """The tables' finish with N_s at the exact angles of incidence."""
        finish = self.tables.finish
        return replace(finish, normalisation=exact_normalisation(finish.shininess, views, normal))

    def _temperature(self, views: Views, normal: Floats, altitude: Floats, steps: int) -> Floats:
        slope, azimuth = self.tables.facing(normal)
        return temperatures_at(
            self.materials, self.inputs, altitude, azimuth, slope, views.time, steps=steps, given=self.given
        )

    def _faces(self, views: Views) -> Faces:
        """The faces of views, over ground whose temperature is solved at their times."""
        slope, azimuth = slope_and_azimuth(views.normal)
        ground = np.full(len(views), self.exact.air.state.surface_temperature)
        if self.ground_material is not None:
            level = np.zeros(len(views))
            altitude = np.full(len(views), self.tables.surface_axes["altitude"][0])
            chosen = [material for material in self.materials if material.name == self.ground_material]
            ground = temperatures_at(
                chosen, self.inputs, altitude, level, level, views.time, steps=FINE_STEPS, given=self.given
            )[:, 0]
        return Faces(face_normal(slope, azimuth - views.source_azimuth), ground)

    def _tilted(self, readings: AtmosphereReadings, views: Views, line: ViewLine | None = None) -> AtmosphereReadings:
        """Readings of level faces with the difference that the tables give for the faces of the views, or of a line."""
        tilt = self.tables.readings(views, line).ambient - self.tables.level_ambient(views, line)
        return replace(readings, ambient=readings.ambient + tilt)

    def _of_tables(
        self,
        budget: Budget,
        views: Views,
        temperature: Floats,
        few: AtmosphereReadings,
        level: AtmosphereReadings,
        read: AtmosphereReadings,
        bounce: Floats,
    ) -> None:
        """Interpolation: of each quantity, then of all; against direct computation with the same points and solver.

        `few` has the ambient light of the faces, `level` that of level ones.
        """
        tables, finish = self.tables, self.tables.finish
        read_glow = tables.blackbody(tables.temperature(views, views.normal, views.surface_altitude))
        glow = tables.blackbody(temperature)
        direct = runtime_radiance(few, glow, bounce, finish)
        budget.errors["temperature_table"] = runtime_radiance(few, read_glow, bounce, finish) - direct
        level_error = tables.level_ambient(views) - level.ambient
        # What harmonics give with the level value computed directly.
        share = tables.level_share(views.normal)
        for name, change in (
            ("beta_star_table", {"transmittance": read.transmittance}),
            ("path_radiance_table", {"path_radiance_ratio": read.path_radiance_ratio}),
            ("ambient_table", {"ambient": few.ambient + share * level_error}),
            ("tilted_sky", {"ambient": read.ambient - share * level_error}),
            ("direct_table", {"direct": read.direct}),
        ):
            budget.errors[name] = runtime_radiance(replace(few, **change), glow, bounce, finish) - direct
        budget.errors["tables"] = runtime_radiance(read, read_glow, bounce, finish) - direct

    def _of_faces_and_frames(
        self,
        budget: Budget,
        views: Views,
        temperature: Floats,
        few: AtmosphereReadings,
        bounce: Floats,
        generator: np.random.Generator,
    ) -> None:
        """Faces, extrapolation from the centre pixel, and everything together."""
        tables, finish = self.tables, self.tables.finish
        glow = tables.blackbody(temperature)
        here = runtime_radiance(few, glow, bounce, finish)
        ends = vertices(views, self.grid, tables)
        budget.errors["face"] = self._across_faces(views, ends) - here
        offset = generator.uniform(-0.5, 0.5, (2, len(views)))
        chosen = generator.integers(len(FIELDS_OF_VIEW), size=len(views))
        assigned = tables.assigned_materials(generator, (here.shape[0], here.shape[1]))
        errors: dict[str, list[Floats]] = {"transmittance_extrapolation": [], "radiance_extrapolation": []}
        together = np.empty_like(here)
        for number, width in enumerate(FIELDS_OF_VIEW):
            centre = frame_centres(views, self.grid, offset * width)
            at_centre = AtmosphereReadings.of(self.few.at_points(*centre.place(views), self.few_light))
            at_centre = self._tilted(at_centre, views, centre)
            extrapolated = (
                replace(few, transmittance=at_centre.at_range(centre.range, views.range)),
                replace(at_centre, transmittance=few.transmittance),
            )
            for name, readings in zip(errors, extrapolated, strict=True):
                errors[name].append(runtime_radiance(readings, glow, bounce, finish) - here)
            rows = chosen == number
            together[rows] = self._all_together(views, ends, tables.readings(views, centre), centre, assigned)[rows]
        budget.extrapolation = {name: np.array(values) for name, values in errors.items()}
        row = np.arange(len(views))
        for name, by_field in budget.extrapolation.items():
            budget.errors[name] = by_field[chosen, row]
        budget.errors["all"] = together - budget.radiance
        budget.frames = frame_errors(
            tables, views, self.grid, offset, here, lambda read: runtime_radiance(read, glow, bounce, finish)
        )
        budget.options |= options_of_frames(tables, views, self.grid, budget.frames, chosen)

    def _across_faces(self, views: Views, ends: tuple[ViewLine, ViewLine]) -> Floats:
        """Radiance (n, M) interpolated between the vertices, with quantities and temperatures computed there."""
        radiance = np.zeros((len(views), len(self.materials)))
        for end, weight in zip(ends, (1 - views.share, views.share), strict=True):
            glow = self.tables.blackbody(self._temperature(views, end.normal, end.surface_altitude, self.steps))
            readings = AtmosphereReadings.of(self.few.at_points(*end.place(views), self.few_light))
            readings = self._tilted(readings, views, end)
            bounce = reflection(views, end.normal, self._finish(views, end.normal))
            radiance = radiance + weight[:, None] * runtime_radiance(readings, glow, bounce, self.tables.finish)
        return radiance

    def _all_together(
        self,
        views: Views,
        ends: tuple[ViewLine, ViewLine],
        read: AtmosphereReadings,
        centre: ViewLine,
        assigned: Integers,
    ) -> Floats:
        """Radiance (n, M) of a runtime: tables at the centre pixel, vertices, mean N_s, materials of the textures."""
        tables, finish = self.tables, self.tables.finish
        shown = np.zeros(assigned.shape)
        for end, weight in zip(ends, (1 - views.share, views.share), strict=True):
            readings = replace(read, transmittance=read.at_range(centre.range, end.range))
            glow = tables.blackbody(tables.temperature(views, end.normal, end.surface_altitude))
            values = runtime_radiance(readings, glow, reflection(views, end.normal, finish), finish)
            shown = shown + weight[:, None] * np.take_along_axis(values, assigned, axis=1)
        return shown

    def _of_materials(
        self, budget: Budget, full: AtmosphereReadings, glow: Floats, bounce: Floats, finish: Finish
    ) -> None:
        """Change of radiance where a texture names another material."""
        share = self.tables.assigned_share
        if share is None:
            return
        radiance = runtime_radiance(full, glow, bounce, finish)
        budget.assigned_share = share
        budget.errors["misclassification"] = radiance[:, None, :] - radiance[:, :, None]
