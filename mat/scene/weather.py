"""The weather of a job's state through its day, and the air that it gives to paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta

import numpy as np

from skyshine.mat.atmosphere.state.ground_air import GroundAir
from skyshine.mat.atmosphere.state.sea_air import SeaAir
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.site import Site
from skyshine.mat.job.surface import HourlyWeather, Weather
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.scene.sources import source_track
from skyshine.mat.surface.convection import WIND_HEIGHT, Wind
from skyshine.mat.surface.ground_year import GroundSeason
from skyshine.mat.surface.measured import MeasuredRadiation
from skyshine.mat.surface.sun_path import SunPath, sun_hours
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather import NearSurfaceAir, from_extremes, from_hours
from skyshine.schemas.arrays import Floats

_QUARTERS = np.arange(0, 24, 0.25)  # hours at which a mean of the day is taken


def sun_path(site: Site) -> SunPath:
    """The Sun through the day of a site."""
    sun = source_track(site, "sun", sun_hours())
    return SunPath(site.altitude_km * 1e3, sun.elevation, sun.azimuth, float(sun.sun_distance[0]))


def earlier_suns(site: Site, weather: Weather) -> list[SunPath]:
    """The Sun through each of the days of the weather before this one, oldest first."""
    days = len(weather.days_before)
    dates = [site.date - timedelta(days=before) for before in range(days, 0, -1)]
    return [sun_path(site.model_copy(update={"date": date})) for date in dates]


def near_surface_air(
    sun: SunPath, readings: Weather, earlier: Sequence[SunPath] = (), ground: GroundSeason | None = None
) -> NearSurfaceAir:
    """The weather of a state through its day, with the days before whose Sun is given, and the season of its ground,
    on all days that of the last.
    """
    if readings.hourly is None:
        daily = readings.relative_humidity_percent, readings.wind_speed_m_s, readings.cloud_fraction
        low, high = np.broadcast_to(np.asarray(readings.air_temperature_c, float), 2) + ZERO_CELSIUS
        return replace(_measured_at(readings, from_extremes(sun, low, high, *daily)), ground=ground)
    tables = [*readings.days_before, readings.hourly]
    first_day = len(tables) - 1 - len(earlier)
    days = enumerate((*earlier, sun), first_day)
    airs = [replace(_air_of_day(path, readings, tables, day), ground=ground) for day, path in days]
    return replace(airs[-1], before=tuple(zip(earlier, airs[:-1], strict=True)))


def _joined(days: Sequence[Floats], period: float = 0.0) -> Floats:
    """Values of consecutive days, before them the last of the first day and after them the first of the last day."""
    return np.concatenate([days[0][-1:] - period, *days, days[-1][:1] + period])


def _air_of_day(sun: SunPath, readings: Weather, tables: Sequence[HourlyWeather], day: int) -> NearSurfaceAir:
    """The air of one of consecutive days; the first follows on a day like itself, the last is followed by one."""
    hours = _joined([np.array(table.time) + 24.0 * (number - day) for number, table in enumerate(tables)], 24.0)

    def series(name: str, all_day: float = np.nan) -> Floats:
        by_hour = ((table, getattr(table, name)) for table in tables)
        return _joined(
            [
                np.full(len(table.time), all_day) if values is None else np.array(values, float)
                for table, values in by_hour
            ]
        )

    table, measured = tables[day], readings.measured
    air = from_hours(
        sun.altitude if table.altitude_km is None else 1e3 * table.altitude_km,
        hours,
        series("air_temperature_c") + ZERO_CELSIUS,
        series("relative_humidity_percent", readings.relative_humidity_percent),
        series("wind_speed_m_s", readings.wind_speed_m_s),
        series("cloud_fraction", readings.cloud_fraction),
        None if any(table_of_day.pressure_hpa is None for table_of_day in tables) else 100.0 * series("pressure_hpa"),
        measured_radiation(table, sun) if measured else None,
    )
    if table.rain_mm_h is not None:
        interval = np.searchsorted(hours, sun_hours(), side="left")
        air = replace(air, rain=series("rain_mm_h")[interval] / 3600.0)
    if table.soil_moisture_m3_m3 is not None:
        air = replace(air, soil_moisture=np.interp(sun_hours(), hours, series("soil_moisture_m3_m3")))
    return _measured_at(readings, air)


def _measured_at(readings: Weather, air: NearSurfaceAir) -> NearSurfaceAir:
    """The air with the heights at which it was measured, and the age of its snow."""
    wind_height, air_height = readings.heights_m
    age = None if readings.snow_age_days is None else np.full_like(air.air_temperature, readings.snow_age_days)
    return replace(air, wind_height=wind_height, air_height=air_height, snow_age=age)


def measured_radiation(table: HourlyWeather, sun: SunPath) -> MeasuredRadiation:
    """Measured light of a table that has it."""
    hours, longwave = np.array(table.time), table.longwave_down_w_m2
    sky = None if longwave is None else np.array(longwave)
    if table.global_horizontal_w_m2 is not None:
        return MeasuredRadiation.of_total(hours, np.array(table.global_horizontal_w_m2), sun, sky)
    return MeasuredRadiation(hours, np.array(table.direct_normal_w_m2), np.array(table.diffuse_w_m2), sky)


def ground_air(site: Site, state: State) -> GroundAir:
    """The weather of a state at the time of its air, by default the day's mean.

    The mean does not depend on the Sun, so that days of the same weather share their air.
    """
    mean, mean_vapour, pressure = daily_means(state.weather)
    table = state.weather.hourly
    altitude = 1e3 * (site.altitude_km if table is None or table.altitude_km is None else table.altitude_km)
    kelvin, vapour = mean, mean_vapour
    if state.air_time is not None:
        air = _air_of_state(site, state)
        kelvin, vapour = (_at(state.air_time, values) for values in (air.air_temperature, air.vapour_pressure))
    if state.has_water_amount:
        return GroundAir(altitude, kelvin, mean, pressure=pressure)
    return GroundAir(altitude, kelvin, mean, vapour, mean_vapour, pressure)


def sea_air(site: Site, state: State) -> SeaAir | None:
    """The sea of a state and the wind over it, at the time of its air or in the day's mean; None without a sea."""
    if state.sea_temperature_c is None:
        return None
    wind_height, air_height = state.weather.heights_m
    if state.air_time is None:
        speed = _mean_speed(state.weather)
    else:
        speed = _at(state.air_time, _air_of_state(site, state).wind_speed)
    return SeaAir(state.sea_temperature_c + ZERO_CELSIUS, speed, wind_height, air_height)


def _air_of_state(site: Site, state: State) -> NearSurfaceAir:
    day = state.date or site.date
    return near_surface_air(sun_path(site.model_copy(update={"date": day})), state.weather)


def _at(hour: float, values: Floats) -> float:
    """Value at an hour of the day of a series at `sun_hours`."""
    return float(np.interp(hour, sun_hours(), values, period=24.0))


def daily_means(weather: Weather) -> tuple[float, float, float | None]:
    """Means of the day: air temperature [K], vapour pressure [Pa], pressure [Pa] where it is measured."""
    mean = weather.mean_air_temperature_c + ZERO_CELSIUS
    table = weather.hourly
    if table is None:
        return mean, weather.relative_humidity_percent / 100.0 * float(saturation_pressure(mean)), None

    def of_day(values: Floats) -> float:
        return float(np.mean(np.interp(_QUARTERS, table.time, values, period=24.0)))

    humidity = table.relative_humidity_percent
    percent = np.array(weather.relative_humidity_percent if humidity is None else humidity, float)
    vapour = percent / 100.0 * saturation_pressure(np.array(table.air_temperature_c) + ZERO_CELSIUS)
    pressure = None if table.pressure_hpa is None else 100.0 * of_day(np.array(table.pressure_hpa))
    return mean, of_day(vapour), pressure


def mean_wind(weather: Weather) -> float:
    """Wind speed at 10 m over open ground, mean of the day, m s^-1."""
    speed, height = _mean_speed(weather), weather.heights_m[0]
    return speed if height == WIND_HEIGHT else float(Wind(speed, height).at(WIND_HEIGHT))


def _mean_speed(weather: Weather) -> float:
    """Wind speed at its height of measurement, mean of the day, m s^-1."""
    hourly = weather.hourly
    if hourly is None or hourly.wind_speed_m_s is None:
        return weather.wind_speed_m_s
    return float(np.mean(np.interp(_QUARTERS, hourly.time, hourly.wind_speed_m_s, period=24)))
