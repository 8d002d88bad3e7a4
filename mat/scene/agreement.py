"""Where weather, profile and sounding of a state disagree, and where tables and the day do."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.state.humidity import WATER_MOLAR_MASS
from skyshine.mat.atmosphere.state.levels import linear
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.model import Job
from skyshine.mat.job.site import Site
from skyshine.mat.job.warnings import merged
from skyshine.mat.radiometry.constants import GAS_CONSTANT
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state, profile_of, without_air_time
from skyshine.mat.scene.weather import ground_air, sun_path
from skyshine.mat.surface.weather import LAPSE_RATE
from skyshine.mat.tables.night import CIVIL_TWILIGHT, dark_elevation

# K between the weather's daily mean and the profile at the ground. Where paths do not follow the weather, the first is
# 0.35 K of a path of 1 km in 8 to 12 um and 0.9 K in 3 to 5 um (tests/validation/test_weather_air.py); most days are
# nearer to the profile of their place and season than the second.
NOT_FOLLOWED, FOLLOWED = 5.0, 12.0
# m, column of water over vapour density at the ground: 1.5 to 3.5 km in most air (Reitan 1963, J. Appl. Meteorol. 2,
# 776), less under a moist layer of fog, more in the dry mixed layer of a desert or above an Arctic inversion.
_LEAST_HEIGHT, _MOST_HEIGHT = 700.0, 7000.0
_VAPOUR_FACTOR, _VAPOUR = 1.5, 300.0  # Pa; both are to be exceeded


def air_warnings(job: Job) -> list[str]:
    """A line for each disagreement beyond the limits, with its numbers and the states that it concerns."""
    by_air: dict[tuple[object, ...], list[str]] = {}
    warnings = []
    for number, state in enumerate(job.states, 1):
        mean = state.weather.mean_air_temperature_c
        key = (air_key(state), mean, state.weather.relative_humidity_percent, state.weather.hourly is None)
        if key not in by_air:
            by_air[key] = _warnings(job.site, state)
        warnings += [(number, text) for text in by_air[key]]
    return merged(warnings)


def twilight_warnings(job: Job) -> list[str]:
    """A line where the atmospheric tables contain no twilight that the day of a state has."""
    if not job.bands or job.query_limits is not None:
        return []
    lowest = min(job.atmosphere_grid.source_elevation_deg)
    dark = dark_elevation(max(job.observer_altitudes_km))
    if lowest <= CIVIL_TWILIGHT:
        return []
    lines = []
    for number, state in enumerate(job.states, 1):
        elevation = sun_path(job.site.model_copy(update={"date": state.date or job.site.date})).solar_elevation
        hours = 24.0 * np.mean((elevation < lowest) & (elevation > dark))
        if hours > 0:
            lines.append(
                (
                    number,
                    f"tables contain no light of a Sun from {lowest:g} degrees down to {dark:.0f}, where it is dark:"
                    f" runtimes refuse {hours:.1f} h of the day; give a source_elevation_deg of {CIVIL_TWILIGHT:g} or"
                    " lower",
                )
            )
    return merged(lines)


def _water_doubt(air: AtmosphericState, source: str) -> list[str]:
    """A line where the water above the ground is not of the vapour at the ground."""
    present = air.mole_fraction["H2O"]
    density = present * air.pressure * WATER_MOLAR_MASS / (GAS_CONSTANT * air.temperature)  # kg m^-3
    column = float(np.trapezoid(density, air.altitude))
    height = column / float(density[0])
    if _LEAST_HEIGHT <= height <= _MOST_HEIGHT:
        return []
    return [
        f"{source} has {column:.1f} mm of water above {1e3 * density[0]:.2f} g m^-3 at the ground, a height of"
        f" {height / 1e3:.1f} km (usual: {_LEAST_HEIGHT / 1e3:g} to {_MOST_HEIGHT / 1e3:g} km); its humidity at the"
        " ground or aloft may be wrong"
    ]


def _warnings(site: Site, state: State) -> list[str]:
    follows, measured = state.air == "weather", state.sounding is not None
    ground, profile = 1e3 * site.altitude_km, profile_of(state)
    weather = ground_air(site, state.model_copy(update={"humidity_scale": 1.0, "gases": {}, "air_times": None}))
    kelvin = weather.mean_temperature + LAPSE_RATE * (weather.altitude - ground)
    source = f"the sounding {profile.name}" if measured else f"the profile {profile.name}"
    there = float(linear(ground, profile.altitude, profile.temperature))
    texts = []
    if abs(kelvin - there) > (FOLLOWED if follows and not measured else NOT_FOLLOWED):
        advice = (
            "paths follow the weather; check weather, date and profile"
            if follows
            else "paths do not follow the weather; check both, or give air: weather"
        )
        texts.append(
            f"weather of {kelvin:.1f} K at the ground (day's mean) and {source} of {there:.1f} K there are"
            f" {abs(kelvin - there):.1f} K apart; {advice}"
        )
    if measured:
        texts += _water_doubt(atmospheric_state(site, without_air_time(state)), source)
    if not follows or state.has_water_amount:
        air = atmospheric_state(site, without_air_time(state))
        station = (
            float(air.pressure_at(max(weather.altitude, ground))) if weather.pressure is None else weather.pressure
        )
        assert weather.mean_vapour_pressure is not None  # humidity_scale and gases were omitted above
        humid = weather.mean_vapour_pressure * float(air.pressure[0]) / station
        present = float(air.mole_fraction["H2O"][0] * air.pressure[0])
        low, high = np.sort([humid, present])
        if high > _VAPOUR_FACTOR * low and high - low > _VAPOUR:
            source = "humidity_scale or gases.H2O" if state.has_water_amount else source
            texts.append(
                f"weather with {humid / 100:.1f} hPa of water vapour at the ground (day's mean) and {source} with"
                f" {present / 100:.1f} hPa there disagree; air of paths has the latter, that of surfaces the former;"
                " check both"
            )
    return texts
