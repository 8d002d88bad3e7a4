"""The radiance of faces by brute force: what every table of a job is judged against.

All spectral points of the band, the light of sky and ground over each face's own hemisphere, temperatures from the
heat balance of each face under its own shadows and beside its own walls, paths and light with the job's air.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.transfer.bounds import Scattering
from skyshine.mat.budget.circumstances import Circumstances
from skyshine.mat.budget.runtime_terms import Finish, exact_normalisation, reflection, spectral_radiance
from skyshine.mat.budget.views import Views
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.facet_light import Facets, Walls
from skyshine.mat.quantities.lines_of_sight import slope_and_azimuth
from skyshine.mat.quantities.results import SpectralLines
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.spherical_harmonics import face_normal
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import all_points
from skyshine.mat.scene.compiled import StateBand
from skyshine.mat.scene.continuum_spread import other_continua
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.omission import Omission
from skyshine.mat.scene.sources import irradiance_of_sources, source_irradiance
from skyshine.mat.scene.surface import given_temperatures, scene_inputs, surface_materials
from skyshine.mat.surface.back_boundary import at_hours
from skyshine.mat.surface.days import joined_days, solve_days
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.reading import at_hours_of_day
from skyshine.mat.surface.sun_path import SunPath
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.arrays import Floats

FINE_STEPS = 288  # solver times of a day


def temperatures_at(
    materials: Sequence[SurfaceMaterial],
    inputs: tuple[SunPath, NearSurfaceAir, Sky],
    altitude_km: Floats,
    azimuth_deg: Floats,
    slope_deg: Floats,
    time_h: Floats,
    *,
    steps: int,
    material_temperatures: Mapping[str, float | tuple[float, ...]] | None = None,
    surroundings: Sequence[Surroundings] | None = None,
) -> Floats:
    """Temperature of every material at every place.

    Parameters
    ----------
    materials : sequence of M SurfaceMaterial
    inputs : SunPath, NearSurfaceAir, Sky
        Inputs from `scene.surface.scene_inputs`.
    altitude_km, azimuth_deg, slope_deg, time_h : (n,) arrays
    steps : int
        Solver times of a day, a divisor of 576.
    material_temperatures : mapping, optional
        Temperatures of materials that are not computed, as for `surface.table.temperature_table`.
    surroundings : sequence of n Surroundings, optional
        Surroundings of each place; by default none.

    Returns
    -------
    (n, M) ndarray
        K; linear between the solver's times.
    """
    columns = [np.asarray(a, float) for a in (altitude_km, azimuth_deg, slope_deg, time_h)]
    altitude, azimuth, slope, time = columns
    per_row = [None] * time.size if surroundings is None else list(surroundings)
    scenes = [
        Scene(*inputs, altitude[row : row + 1] * 1e3, slope[row : row + 1], azimuth[row : row + 1], per_row[row])
        for row in range(time.size)
    ]
    days = joined_days(scenes) if scenes else []
    result = np.empty((time.size, len(materials)))
    for number, material in enumerate(materials):
        if material_temperatures and material.name in material_temperatures:
            result[:, number] = at_hours(material_temperatures[material.name], time)
            continue
        for rows, solution in solve_days(material, days, steps=steps) if scenes else ():
            result[rows, number] = _at_time(solution.temperature, time[rows])
    return result


def _at_time(temperature: Floats, time_h: Floats) -> Floats:
    """Interpolated periodic temperatures (n, N), each row at its own hour, as tables are read from a solution."""
    rows = zip(temperature, time_h, strict=True)
    return np.array([at_hours_of_day(day[None], np.array([hour]))[0, 0] for day, hour in rows])


@dataclass(frozen=True, eq=False)
class Prepared:
    """A state and band of a job.

    Attributes
    ----------
    state, band : int
        Counted from 1.
    exact, reduced : BandAtmosphere
        Atmosphere at all spectral points, and at those of the tables.
    inputs : SunPath, NearSurfaceAir, Sky
        Inputs of the heat balance.
    others : tuple of BandAtmosphere
        The few points with the other water vapour continua of MT_CKD.
    unscattered : set of str
        Sources whose scattered light the job's `negligible_k` omits, by a bound.
    """

    loaded: LoadedJob
    state: int
    band: int
    response: SpectralResponse
    exact: BandAtmosphere
    reduced: BandAtmosphere
    inputs: tuple[SunPath, NearSurfaceAir, Sky]
    others: tuple[BandAtmosphere, ...]
    unscattered: frozenset[str]

    @classmethod
    def of(cls, loaded: LoadedJob, state: int, band: int) -> Prepared:
        """Prepare a state and band, counted from 1."""
        loaded = loaded.on_date_of_state(state)
        job, of_band = loaded.trimmed, StateBand.of(loaded, state, band)
        response, air, compiled = of_band.response, of_band.air, of_band.compiled
        exact, reduced = (BandAtmosphere.of(air, points) for points in (of_band.everything, compiled.band))
        light = irradiance_of_sources(job, compiled.band)
        bounds = Scattering.of(reduced.air).radiance(light, compiled.band.radiance_weight)
        omission = Omission.of(job, job.sources, air, response, bounds)
        others = tuple(
            BandAtmosphere.of(air, replace(reduced.band, points=part))
            for name in other_continua(job)
            for part in [all_points(response, name).points.subset(compiled.index)]
        )
        inputs = scene_inputs(job, state)
        return cls(loaded, state, band, response, exact, reduced, inputs, others, frozenset(omission.scattered))

    def at_hour(self, hour: float) -> BandAtmosphere:
        """The few points in the air that the weather has at a local clock hour, without scattered light.

        Raises
        ------
        InputError
            Air cannot be as the weather says.
        """
        job = self.loaded.trimmed
        state = job.states[self.state - 1].model_copy(update={"air": "weather", "air_times": [hour]})
        over = over_ground(atmospheric_state(job.site, state), state, self.response, job_library(job))
        air = BandAtmosphere.of(over, self.reduced.band)
        return replace(air, air=replace(air.air, scatters=False))

    @property
    def has_air_of_an_hour(self) -> bool:
        """Whether the paths of the state have the air of one time, not that of all hours."""
        state = self.loaded.trimmed.states[self.state - 1]
        return state.air == "weather" and state.air_time is not None

    def lit(self, air: BandAtmosphere, source: str) -> BandAtmosphere:
        """One of the two atmospheres, under a source whose light is scattered unless that is negligible."""
        return replace(air, air=replace(air.air, scatters=False)) if source in self.unscattered else air


@dataclass(frozen=True, eq=False)
class FacetRadiance:
    """Radiance of n views of M materials, with what it is made of.

    Attributes
    ----------
    open_air, shadowed, kelvin : (n, M) arrays
        Temperatures [K] in the open, under the shadows alone, and under shadows and beside walls.
    bounce : (n, M) array
        Reflection terms, as of `runtime_terms.reflection`.
    radiance : (n, M) array
        Radiance at the observers, W m^-2 sr^-1.
    """

    open_air: Floats
    shadowed: Floats
    kelvin: Floats
    lines: SpectralLines
    bounce: Floats
    radiance: Floats


class FacetTruth:
    """Temperature and radiance of faces of some materials, computed directly.

    Parameters
    ----------
    names : sequence of M str
        Names of the materials.
    source : {'sun', 'moon'}
    """

    def __init__(self, prepared: Prepared, library: MaterialLibrary, names: Sequence[str], source: str) -> None:
        job, chosen = prepared.loaded.trimmed, [library[name] for name in names]
        self.source, self._prepared, self._chosen = source, prepared, chosen
        self._enter(prepared.exact)
        self.inputs = prepared.inputs
        self.materials = surface_materials(chosen, job.operated, self.inputs[1].wetting)
        self.given = given_temperatures(job, job.states[prepared.state - 1])
        ground = job.states[prepared.state - 1].ground_material
        self._ground = surface_materials(
            [] if ground is None else [library[ground]], job.operated, self.inputs[1].wetting
        )
        self._lowest = job.site.altitude_km
        self._ground_kelvin: dict[Views, Floats] = {}

    def _enter(self, air: BandAtmosphere) -> None:
        """Take the light, at the points of some air."""
        self.air = self._prepared.lit(air, self.source)
        points = air.band.wavenumber, air.band.width
        self.irradiance = source_irradiance(self._prepared.loaded.trimmed, self.source, *points)
        micron = 1e4 / air.band.wavenumber
        self.reflectance = np.array([np.interp(micron, m.wavelength, m.reflectance) for m in self._chosen])

    def in_air(self, air: BandAtmosphere) -> FacetTruth:
        """The same at other points of the band, or with light of other detail."""
        other = copy(self)
        other._enter(air)
        return other

    @property
    def mean_air_temperature(self) -> float:
        """Mean air temperature of the day, at the weather's altitude [K]."""
        return float(np.mean(self.inputs[1].air_temperature))

    def temperature(
        self,
        normal: Floats,
        altitude: Floats,
        time: Floats,
        surroundings: Sequence[Surroundings] | None = None,
        steps: int = FINE_STEPS,
    ) -> Floats:
        """Temperatures (n, M) [K] from the heat balance of each face.

        Parameters
        ----------
        normal : (n, 3) array
            East, north, up.
        altitude, time : (n,) arrays
            km; local clock, h.
        surroundings : sequence of n Surroundings, optional
            Surroundings of each face; by default none.
        steps : int
            Solver times of a day.
        """
        slope, azimuth = slope_and_azimuth(normal)
        location = altitude, azimuth, slope, time
        return temperatures_at(
            self.materials,
            self.inputs,
            *location,
            steps=steps,
            material_temperatures=self.given,
            surroundings=surroundings,
        )

    def temperatures_among(self, views: Views, circumstances: Circumstances) -> tuple[Floats, Floats, Floats]:
        """Temperatures (n, M) [K] of the faces of views in the open, under their shadows alone, and under shadows and
        beside walls.
        """
        open_air = self.temperature(views.normal, views.surface_altitude, views.time)
        results = [open_air]
        for chosen, surroundings in (
            (circumstances.shaded, circumstances.shadows_alone),
            (circumstances.walled, circumstances.surroundings),
        ):
            kelvin, rows = results[-1].copy(), np.flatnonzero(chosen)
            part = views.take(chosen)
            selected = [surroundings[row] for row in rows]
            kelvin[rows] = self.temperature(part.normal, part.surface_altitude, part.time, selected)
            results.append(kelvin)
        return results[0], results[1], results[2]

    def faces(self, views: Views, circumstances: Circumstances | None = None) -> Facets:
        """The faces of views, over ground whose temperature is solved at their times, among walls or in the open."""
        slope, azimuth = slope_and_azimuth(views.normal)
        walls = None
        if circumstances is not None:
            walls = Walls(circumstances.sky_view, circumstances.wall_temperature, circumstances.wall_emissivity)
        normal = face_normal(slope, azimuth - views.source_azimuth)
        return Facets(normal, self._ground_temperature(views), views.surface_altitude * 1e3, walls)

    def _ground_temperature(self, views: Views) -> Floats:
        """Temperature (n,) [K] of the ground at the times of views, solved once for light of all kinds of air."""
        if not self._ground:
            return np.full(len(views), self.air.air.state.surface_temperature)
        if views not in self._ground_kelvin:
            level, altitude = np.zeros(len(views)), np.full(len(views), self._lowest)
            self._ground_kelvin[views] = temperatures_at(
                self._ground,
                self.inputs,
                altitude,
                level,
                level,
                views.time,
                steps=FINE_STEPS,
                material_temperatures=self.given,
            )[:, 0]
        return self._ground_kelvin[views]

    def lines(self, views: Views, circumstances: Circumstances) -> SpectralLines:
        """Spectra of the lines of sight and of the light on the faces, that of the Sun on their walls among it."""
        lines = self.air.spectral_at_points(views.lines, self.irradiance, self.faces(views, circumstances))
        from_walls = self.light_of_walls(views, circumstances)[:, None] * lines.direct_irradiance
        return replace(lines, sky_irradiance=lines.sky_irradiance + from_walls)

    def light_of_walls(self, views: Views, circumstances: Circumstances) -> Floats:
        """Light (n,) that walls reflect onto faces, over that of the Sun on a surface across it."""
        hidden = (1 - circumstances.sky_view) * 0.5 * (1 + views.normal[:, 2])
        light: Floats = hidden * (1 - circumstances.wall_emissivity) * circumstances.wall_beam
        return light

    def bounce(self, views: Views, normal: Floats, finish: Finish, in_shade: Circumstances) -> Floats:
        """Reflection terms, as `runtime_terms.reflection`; 0 where a face is in the Sun's shade."""
        return self.lit_share(in_shade)[:, None] * reflection(views, normal, finish)

    def lit_share(self, circumstances: Circumstances) -> Floats:
        """Share (n,) of the source's direct light that reaches faces: none in the Sun's shade."""
        return np.where(circumstances.in_shade & (self.source == "sun"), 0.0, 1.0)

    def of(self, views: Views, circumstances: Circumstances, finish: Finish) -> FacetRadiance:
        """Radiance of the faces of views, of all materials.

        Parameters
        ----------
        circumstances : Circumstances
            Circumstances of the faces.
        finish : Finish
            Finish of the materials; its lobes alone count, with N_s of (43) at each angle of incidence.
        """
        open_air, shadowed, kelvin = self.temperatures_among(views, circumstances)
        lines = self.lines(views, circumstances)
        exact = exact_normalisation(finish.shininess, views, views.normal)
        bounce = self.bounce(views, views.normal, replace(finish, normalisation=exact), circumstances)
        radiance = spectral_radiance(lines, self.air.band, kelvin, self.reflectance, bounce)
        return FacetRadiance(open_air, shadowed, kelvin, lines, bounce, radiance)
