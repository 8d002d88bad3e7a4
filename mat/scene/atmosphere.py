"""From a job to the objects of the physics: atmospheric states, bands, sources."""

from __future__ import annotations

import hashlib
from functools import lru_cache

import numpy as np

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import BOUNDARY_MODELS
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.sources.sun_and_moon import lunar_irradiance, position, solar_irradiance
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.sounding import read_sounding
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import clock_text
from skyshine.mat.job.model import Job, LoadedJob, Site, local_times_utc
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.response_table import parse_response
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import InputError

ZERO_CELSIUS = 273.15  # K
_AMOUNTS = ("scale", "ppm", "column_mm", "column_du")


def atmospheric_state(site: Site, state: State) -> AtmosphericState:
    """The atmospheric state of a job's state over the ground of its site.

    The ground below the paths has the mean of the day's air temperature.
    """
    mean = state.weather.mean_air_temperature_c + ZERO_CELSIUS
    profile = load_profile(state.profile)
    if state.sounding is not None:
        profile = read_sounding(state.sounding.text, state.sounding.path, profile)
    amounts = {
        unit: {gas: getattr(a, unit) for gas, a in state.gases.items() if getattr(a, unit) is not None}
        for unit in _AMOUNTS
    }
    winter = state.profile.endswith("winter")
    return AtmosphericState.from_profile(
        profile,
        surface_altitude=site.altitude_km * 1e3,
        co2_ppm=None if "CO2" in state.gases else state.co2_ppm,
        humidity_scale=state.humidity_scale,
        gas_scale=amounts["scale"],
        gas_ppm=amounts["ppm"],
        water_column=amounts["column_mm"].get("H2O"),
        ozone_column=amounts["column_du"].get("O3"),
        aerosol=state.aerosol,
        visibility_km=state.visibility_km,
        wind_speed=_mean_wind(state.weather),
        air_mass=state.air_mass,
        stratosphere=state.stratosphere,
        clouds=[cloud.layer() for cloud in state.clouds],
        rain=None if state.rain is None else RainLayer(state.rain.rate_mm_h, 1e3 * state.rain.top_km),
        season=state.season or ("fall_winter" if winter else "spring_summer"),
        surface_temperature=mean,
        surface_albedo=state.surface_albedo,
    )


def air_of(state: State) -> tuple[str, float | None]:
    """What of a state its air follows from: the same for states that differ in day, ground temperature and weather
    alone.
    """
    wind = _mean_wind(state.weather) if BOUNDARY_MODELS.get(state.aerosol, 0.0) is None else None
    return state.model_dump_json(exclude={"date", "series", "weather"}), wind


def _mean_wind(weather) -> float:
    """Mean of the day, m s^-1."""
    hourly = weather.hourly
    if hourly is None or hourly.wind_speed_m_s is None:
        return weather.wind_speed_m_s
    return float(np.mean(np.interp(np.arange(0, 24, 0.25), hourly.time, hourly.wind_speed_m_s, period=24)))


def response_of(band) -> SpectralResponse:
    """The sensor response of a job's band.

    Raises
    ------
    InputError
        At the place in a response table that is wrong.
    """
    if band.response is not None:
        return parse_response(band.response.text, band.response.path)
    if band.wavenumber_cm is not None:
        low, high = band.wavenumber_cm
        return SpectralResponse.rectangular(1e4 / high, 1e4 / low)
    return SpectralResponse.rectangular(*band.wavelength_um)


@lru_cache(maxsize=4)
def absorption_table(water_continuum: str = "mt_ckd_4.3") -> AbsorptionTable:
    """The packaged band model with one of the water vapour continua, opened once a process."""
    return AbsorptionTable.open(water_continuum=water_continuum)


def check_scene(loaded: LoadedJob) -> None:
    """Check what the models alone cannot: that the band model covers each band.

    Raises
    ------
    InputError
        At the place in the job.
    """
    table = absorption_table()
    for i, band in enumerate(loaded.job.bands):
        response = response_of(band)
        low, high = response.wavenumber_range
        if not any(start <= low and high <= end for start, end in table.coverage):
            spans = ", ".join(f"{1e4 / end:.4g} to {1e4 / start:.4g} um" for start, end in table.coverage)
            found = f"{response.lower:g} to {response.upper:g} um"
            raise loaded.document.error(
                ("bands", i), f"bands.{i}: found {found}; allowed: inside {spans}, which the band model covers"
            )
    for i, state in enumerate(loaded.job.states):
        try:
            atmospheric_state(loaded.job.site, state)
        except InputError as error:
            if error.file is not None:  # in a file of its own
                raise
            raise loaded.document.error(("states", i), f"states.{i}: {error.message}") from None


def source_irradiance(job: Job, source: str, wavenumber: np.ndarray, width: np.ndarray | None = None) -> np.ndarray:
    """Irradiance (P,) of a source outside the atmosphere on the day of the job, W m^-2 (cm^-1)^-1; mean over widths in
    cm^-1.

    The Sun at its distance at noon; the Moon at its phase and distance at local midnight, the middle of the night
    that its tables are for.
    """
    site = job.site
    hour = 12.0 if source == "sun" else 24.0
    where = position(source, local_times_utc(site, [hour]), site.latitude_deg, site.longitude_deg)
    if source == "sun":
        return solar_irradiance(wavenumber, width) / where.sun_distance[0] ** 2
    moon = lunar_irradiance(
        wavenumber, where.phase_angle[0], where.distance[0], where.sun_distance[0], bool(where.waxing[0]), width
    )
    return moon.total


def usual_irradiance(job: Job, source: str, wavenumber: np.ndarray, width: np.ndarray | None = None) -> np.ndarray:
    """As `source_irradiance`, the same for all days on which its spectrum has the same shape: the Sun at 1 au."""
    if source == "sun":
        return solar_irradiance(wavenumber, width)
    return source_irradiance(job, source, wavenumber, width)


def solar_spectrum() -> tuple[np.ndarray, np.ndarray]:
    """Sunlight outside the atmosphere at 1 au: wavelength (n,) um, increasing, and irradiance (n,) W m^-2 um^-1."""
    wavelength = np.geomspace(0.25, 25.0, 3000)
    wavenumber = 1e4 / wavelength
    return wavelength, solar_irradiance(wavenumber) * wavenumber**2 * 1e-4


def materials_digest(library: MaterialLibrary, names: tuple[str, ...]) -> str:
    """SHA-256 over all that the databases take from materials, so that a changed material is built anew."""
    digest = hashlib.sha256()
    for name in names:
        m = library[name]
        scalars = (m.code, m.name, m.thermal, m.surface, m.specular_fraction, m.lobe_fwhm)
        digest.update(repr(scalars).encode())
        for array in (m.wavelength, m.reflectance, m.absorptance):
            digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()


def source_hours(job: Job, step: float = 1 / 12) -> dict[str, list[tuple[str, str]]]:
    """Local clock times between which each source of the job stands above the horizon, to the step in hours."""
    hours = np.arange(0.0, 24.0, step)
    times = local_times_utc(job.site, hours)
    spans: dict[str, list[tuple[str, str]]] = {}
    for source in job.sources:
        up = position(source, times, job.site.latitude_deg, job.site.longitude_deg).elevation > 0
        edges = np.flatnonzero(np.diff(np.concatenate([[False], up, [False]]).astype(int)))
        spans[source] = [
            (clock_text(hours[a]), clock_text(hours[b - 1] + step))
            for a, b in zip(edges[::2], edges[1::2], strict=True)
        ]
    return spans
