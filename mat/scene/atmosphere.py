"""From a job's state to the state of the air, and what caches and records know it by."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import WINDBLOWN, Aerosol, boundary_model
from skyshine.mat.atmosphere.particles.aerosol_layer import AerosolLayer
from skyshine.mat.atmosphere.particles.aerosol_table import (
    COVERED,
    parse_aerosol,
    parse_aerosol_optics,
    parse_extinction_profile,
    parse_refractive_index,
)
from skyshine.mat.atmosphere.particles.particles import SpectralModel
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.particles.size_distribution import LogNormalMode, RefractiveIndex, sphere_mixture
from skyshine.mat.atmosphere.state.climate import blended_profile
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.ground_air import GroundAir
from skyshine.mat.atmosphere.state.profiles import Profile
from skyshine.mat.atmosphere.state.sounding import continued
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job import aerosols
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import clock_text
from skyshine.mat.job.site import Site
from skyshine.mat.job.surface import RADIATION, TOTAL
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.scene.weather import ground_air, mean_wind, sea_air
from skyshine.materials.library import MaterialLibrary
from skyshine.materials.records import Material

_AMOUNTS = ("scale", "ppm", "column_mm", "column_du")


def aerosol_layers(state: State) -> list[AerosolLayer]:
    """The aerosol layers of a state in SI units.

    Raises
    ------
    InputError
        With file:line:column of what does not fit in a table.
    """
    layers: list[AerosolLayer] = []
    for layer in state.aerosol_layers:
        if layer.optics is not None:
            layers += parse_aerosol_optics(layer.optics.text, layer.optics.path)
        else:
            layers.append(_layer(state, layer))
    return layers


def _layer(state: State, layer: aerosols.AerosolLayer) -> AerosolLayer:
    model = _particles(state, layer)
    depth = layer.optical_depth
    if layer.profile is not None:
        height, extinction = parse_extinction_profile(layer.profile.text, layer.profile.path)
        return AerosolLayer.measured(model, height, extinction, depth)
    assert depth is not None  # the job's model asks for one without a profile
    if layer.height_km is not None:
        bottom, top = layer.height_km
        return AerosolLayer.even(model, 1e3 * bottom, 1e3 * top, depth)
    assert layer.scale_height_km is not None  # the job's model asks for one of the three
    return AerosolLayer.exponential(model, 1e3 * layer.scale_height_km, depth)


def _particles(state: State, layer: aerosols.AerosolLayer) -> AerosolModel | SpectralModel:
    if layer.table is not None:
        return parse_aerosol(layer.table.text, layer.table.path)
    if layer.size_distribution is not None:
        return sphere_mixture("spheres", tuple(_mode(mode) for mode in layer.size_distribution))
    assert layer.model is not None  # the job's model asks for one of the three
    return boundary_model(layer.model, mean_wind(state.weather), state.air_mass)


def _mode(mode: aerosols.Mode) -> LogNormalMode:
    index = mode.refractive_index
    if isinstance(index, tuple):
        refractive_index = RefractiveIndex(COVERED, (index[0],) * 2, (index[1],) * 2)
    else:
        refractive_index = parse_refractive_index(index.text, index.path)
    return LogNormalMode(mode.median_radius_um, mode.geometric_sd, mode.number, refractive_index)


def atmospheric_state(site: Site, state: State, weather_air: GroundAir | None = None) -> AtmosphericState:
    """The atmospheric state of a job's state over the ground of its site.

    The ground below the paths has the temperature of the weather: the day's mean, or that of the time of the air; a sea
    has its own.
    `weather_air` replaces the air that the state's weather gives.
    """
    follows, sea = state.air == "weather", sea_air(site, state)
    air = AtmosphericState.from_profile(
        profile_of(state),
        surface_altitude=site.altitude_km * 1e3,
        ground_air=(weather_air or ground_air(site, state)) if follows else None,
        sea=sea,
        gas_amounts=_gas_amounts(state),
        aerosol=_aerosol(state),
        aerosol_layers=aerosol_layers(state),
        clouds=[cloud.layer() for cloud in state.clouds],
        rain=None if state.rain is None else RainLayer(state.rain.rate_mm_h, 1e3 * state.rain.top_km),
        surface_temperature=None if follows or sea is not None else state.weather.mean_air_temperature_c + ZERO_CELSIUS,
        surface_albedo=state.surface_albedo,
    )
    return replace(air, night_sky=state.night_sky)


def air_text(state: State) -> str:
    """What the air near the ground follows, for files and people."""
    if state.air == "profile":
        return "profile" if state.sounding is None else "sounding"
    return "weather, day's mean" if state.air_time is None else f"weather at {clock_text(state.air_time)}"


def without_air_time(state: State) -> State:
    """The state with the day's mean air, which the sky over surfaces has all day."""
    return state.model_copy(update={"air_times": None})


def profile_of(state: State) -> Profile:
    """The profile of a state as it is written or measured, whatever the weather."""
    profile = blended_profile(state.profile_weights)
    if state.sounding is None:
        return profile
    assert state.sounding.levels is not None  # a loaded job has read them
    return continued(state.sounding.levels, profile)


def _gas_amounts(state: State) -> GasAmounts:
    amounts = {
        unit: {gas: getattr(a, unit) for gas, a in state.gases.items() if getattr(a, unit) is not None}
        for unit in _AMOUNTS
    }
    ppm, scale = amounts["ppm"], amounts["scale"]
    return GasAmounts(
        scale={**scale, "H2O": state.humidity_scale * scale.get("H2O", 1.0)},
        ppm=ppm if "CO2" in state.gases else {**ppm, "CO2": state.co2_ppm},
        water_column=amounts["column_mm"].get("H2O"),
        ozone_column=amounts["column_du"].get("O3"),
    )


def _aerosol(state: State) -> Aerosol:
    table = state.aerosol_table
    return Aerosol(
        state.aerosol,
        visibility_km=state.visibility_km,
        wind_speed=mean_wind(state.weather),
        air_mass=state.air_mass,
        stratosphere=state.stratosphere,
        season=aerosol_season(state),
        optical_depth=state.optical_depth,
        angstrom_exponent=state.angstrom_exponent,
        optics=None if table is None else parse_aerosol(table.text, table.path),
    )


def aerosol_season(state: State) -> str:
    """Season of the aerosol: as written, or that of most of the profile's blend."""
    winter = sum(weight for name, weight in state.profile_weights.items() if name.endswith("winter")) > 0.5
    return state.season or ("fall_winter" if winter else "spring_summer")


def air_key(state: State) -> tuple[str, float | None, str]:
    """Cache key of a state's air: the same for states that differ in day, ground temperature and weather alone, as far
    as the air does not follow the weather.
    """
    models = (state.aerosol, *(layer.model or "none" for layer in state.aerosol_layers))
    sea = state.sea_temperature_c is not None
    wind = mean_wind(state.weather) if sea or set(models) & set(WINDBLOWN) else None
    followed = ""
    if state.air == "weather":
        date = None if state.air_time is None else state.date  # the hour of the highest temperature is the Sun's
        weather, table = state.weather, state.weather.hourly
        humidity = weather.relative_humidity_percent
        still = () if sea else ("wind_speed_m_s",)
        readings = None if table is None else table.model_dump(exclude={*still, "cloud_fraction", *RADIATION, TOTAL})
        followed = repr((weather.air_temperature_c, humidity, readings, date, weather.heights_m if sea else None))
    return state.model_dump_json(exclude={"date", "series", "weather", "ground_material"}), wind, followed


def materials_digest(library: MaterialLibrary, names: tuple[str, ...]) -> str:
    """SHA-256 over all that the databases take from materials, so that a changed material is built anew."""
    digest = hashlib.sha256()
    for name in names:
        for part in _parts(library[name]):
            digest.update(part)
    return digest.hexdigest()


def _parts(m: Material) -> Iterator[bytes]:
    """What databases take from a material, with leaves and soil of an open stand."""
    yield repr((m.code, m.name, m.thermal, m.surface, m.specular_fraction, m.lobe_fwhm)).encode()
    for array in (m.wavelength, m.reflectance, m.absorptance):
        yield np.ascontiguousarray(array, dtype="<f8").tobytes()
    if m.opened is not None:
        yield repr(m.opened.leaf_area).encode()
        for part in (m.opened.leaves, m.opened.soil):
            yield from _parts(part)
