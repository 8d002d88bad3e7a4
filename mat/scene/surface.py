"""From a job to what the surface heat balance needs: Sun, weather, sky, surroundings, materials."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.load import load_job
from skyshine.mat.job.model import Job
from skyshine.mat.job.surface import Operation, at_kelvin
from skyshine.mat.job.surroundings import StateSurroundings
from skyshine.mat.scene.atmosphere import atmospheric_state, materials_digest, without_air_time
from skyshine.mat.scene.canopy import NO_LEAVES
from skyshine.mat.scene.clear_sky import band_model_sky
from skyshine.mat.scene.moisture import film_skin, job_library, moist, moist_skin, optics
from skyshine.mat.scene.weather import earlier_suns, measured_radiation, near_surface_air, sun_path
from skyshine.mat.surface.canopy import mixed_absorptance, mixed_emissivity
from skyshine.mat.surface.enclosed import GivenEmitter, solved_enclosure
from skyshine.mat.surface.enclosure import Enclosure
from skyshine.mat.surface.forcing import Sky
from skyshine.mat.surface.horizon import Horizon
from skyshine.mat.surface.material import Canopy, SurfaceMaterial
from skyshine.mat.surface.sun_path import SunPath
from skyshine.mat.surface.weather import DRY, NearSurfaceAir, Wetting
from skyshine.materials.records import Material, OpenStand
from skyshine.schemas.errors import InputError

SEA_WATER = ("water_sea", "water_coastal")


def surface_inputs(
    source: str | os.PathLike[str] | Mapping[str, Any], state_index: int = 1
) -> tuple[Job, tuple[SunPath, NearSurfaceAir, Sky]]:
    """A job, with Sun, weather and sky of one of its states, counted from 1.

    Raises
    ------
    InputError
        The job does not fit, or has no such state.
    """
    loaded = load_job(source)
    job = loaded.trimmed
    if not 1 <= state_index <= len(job.states):
        raise InputError(f"found state {state_index}; allowed: 1 to {len(job.states)}", file=loaded.file)
    return job, scene_inputs(job, state_index)


def scene_inputs(job: Job, state_index: int) -> tuple[SunPath, NearSurfaceAir, Sky]:
    """Sun, weather and sky of a state, counted from 1, the sky with the ground and walls that the state names."""
    state = job.states[state_index - 1]
    site = job.on_date_of_state(state_index).site
    sun = sun_path(site)
    air = atmospheric_state(site, without_air_time(state))
    sky = band_model_sky(
        air, job.surface_altitudes_km[-1] * 1e3, ground_albedo(job, state), sun.sun_distance, job.water_continuum
    )
    year = state.weather.ground_year
    ground = None if year is None else year.on(site.date)
    weather = near_surface_air(sun, state.weather, earlier_suns(site, state.weather), ground)
    if state.clouds:  # their layers are in the sky already, on the days before as on this
        weather = replace(_cloudless(weather), before=tuple((sun, _cloudless(air)) for sun, air in weather.before))
    return sun, weather, replace(sky, enclosure=_enclosure(job, state, sun, weather, sky))


def _cloudless(weather: NearSurfaceAir) -> NearSurfaceAir:
    return replace(weather, cloud_fraction=np.zeros_like(weather.cloud_fraction))


def has_enclosure(state: State) -> bool:
    """Whether a state names ground or walls around its surfaces."""
    return state.ground_material is not None or not (state.surroundings or StateSurroundings()).open


def ground_albedo(job: Job, state: State) -> float:
    """Albedo of the ground for sunlight: as given, else that of the ground's material."""
    if state.ground_material is None or "ground_albedo" in state.weather.model_fields_set:
        return state.weather.ground_albedo
    (material,) = surface_materials([job_library(job)[state.ground_material]])
    return 1 - material.solar_absorptance


def _enclosure(job: Job, state: State, sun: SunPath, weather: NearSurfaceAir, sky: Sky) -> Enclosure | None:
    """Ground and walls of a state, with their temperatures; None on an open plain without a material."""
    if not has_enclosure(state):
        return None
    surroundings = state.surroundings or StateSurroundings()
    ground = GivenEmitter(1.0, sky.ground_albedo)
    if state.ground_material is not None:
        ground = replace(_emitter(job, state, state.ground_material, weather.wetting), albedo=sky.ground_albedo)
    wall, (azimuth, elevation) = surroundings.wall, surroundings.horizon
    if wall.material is not None:
        walls = _emitter(job, state, wall.material, weather.wetting)
    else:
        celsius = wall.temperature_c
        walls = GivenEmitter(wall.emissivity, wall.albedo, None if celsius is None else at_kelvin(celsius))
    return solved_enclosure(
        sun,
        weather,
        sky,
        [1e3 * altitude for altitude in job.surface_altitudes_km],
        ground=ground,
        walls=walls,
        horizon=Horizon(azimuth, elevation),
        sky_view=surroundings.sky_view,
        steps=job.accuracy.solver_steps,
    )


def _emitter(job: Job, state: State, name: str, wetting: Wetting) -> GivenEmitter:
    """A material as ground or wall, at the temperature that the job gives or that its heat balance has."""
    (material,) = surface_materials([job_library(job)[name]], job.operated, wetting)
    kelvin = given_temperatures(job, state).get(name)
    return GivenEmitter(
        material.thermal_emissivity,
        1 - material.solar_absorptance,
        material if kelvin is None else kelvin,
    )


def given_temperatures(job: Job, state: State) -> dict[str, float | tuple[float, ...]]:
    """Temperatures [K] of materials that the job gives; sea water that it neither gives nor operates has that of the
    state's sea.
    """
    sea = state.sea_temperature_c
    celsius = {} if sea is None else {name: sea for name in SEA_WATER if name not in job.operated}
    return {name: at_kelvin(value) for name, value in {**celsius, **job.temperatures_c}.items()}


def surroundings_identity(job: Job, state_index: int) -> dict[str, Any]:
    """What a table of temperatures depends on by the surroundings of a state, counted from 1; empty without any."""
    state = job.states[state_index - 1]
    if not has_enclosure(state):
        return {}
    names = state.surrounding_materials
    content: dict[str, Any] = {"ground_albedo": ground_albedo(job, state)}
    if state.surroundings is not None:
        content |= state.surroundings.content()
    for name in names:
        if name in job.operated:
            content.setdefault("operated", {})[name] = job.operated[name].model_dump(mode="json")
        if name in job.temperatures_c:
            content.setdefault("temperatures_c", {})[name] = job.temperatures_c[name]
    return {"surroundings": content | {"materials_sha256": materials_digest(job_library(job), names)}}


def check_measured_light(job: Job, state_index: int) -> None:
    """Check that the measured light of a state, counted from 1, fits its Sun.

    Raises
    ------
    InputError
        Light was measured while the Sun is down.
    """
    weather, site = job.states[state_index - 1].weather, job.on_date_of_state(state_index).site
    if weather.measured and weather.hourly is not None:
        suns = [*earlier_suns(site, weather), sun_path(site)]
        for table, sun in zip([*weather.days_before, weather.hourly], suns, strict=True):
            measured_radiation(table, sun).refuse_light_at_night(sun)


def surface_materials(
    materials: Sequence[Material], operated: Mapping[str, Operation] | None = None, wetting: Wetting = DRY
) -> list[SurfaceMaterial]:
    """Materials of the library as the heat balance sees them, those in operation with the back of the job, and as
    the weather wets them.
    """
    return [_surface_material(material, operated or {}, wetting) for material in materials]


def _surface_material(material: Material, operated: Mapping[str, Operation], wetting: Wetting) -> SurfaceMaterial:
    if material.opened is not None:
        return _open_stand(material.name, material.opened, wetting)
    film, by_moisture = None, None
    if wetting.soil_moisture is not None and material.soil is not None:
        dry = material.dry or material
        by_moisture, material = moist_skin(dry), moist(dry, wetting.soil_moisture, wetting.frost)
    elif wetting.frost and material.moisture:
        material = moist(material.dry or material, material.moisture, wetting.frost)
    if wetting.rain:
        film = film_skin(material)
    thermal = material.thermal
    if material.name in operated:
        thermal = replace(thermal, back=operated[material.name].back)
    return SurfaceMaterial(material.name, thermal, material.surface, *optics(material), film, by_moisture)


def _open_stand(name: str, stand: OpenStand, wetting: Wetting) -> SurfaceMaterial:
    """Leaves and soil as the heat balance sees them; the soil alone where there are no leaves."""
    leaves, soil = (_surface_material(part, {}, wetting) for part in (stand.leaves, stand.soil))
    if stand.leaf_area < NO_LEAVES:
        return replace(soil, name=name)
    canopy = Canopy(stand.leaf_area, replace(leaves, name=name), soil)
    return replace(
        canopy.leaves,
        film=None,
        solar_absorptance=mixed_absorptance(canopy),
        thermal_emissivity=mixed_emissivity(canopy),
        canopy=canopy,
    )
