"""Whether weather can be of its place and clock: what is hardly so is said in a line, with numbers and likely cause."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta

import numpy as np

from skyshine.mat.job.fields import clock_text
from skyshine.mat.job.site import Site
from skyshine.mat.job.surface import SUNLIGHT, TOTAL, HourlyWeather, Weather
from skyshine.schemas.arrays import Floats

FARTHEST_ZONE_H = 3.0  # farthest zone of a clock from the Sun's: western China keeps 2.9 h
_STRAY = 20.0  # W m^-2 that instruments may show at night
_NIGHT = -1.5  # degree, of the Sun's centre: refraction, the disc's radius, and the error of its place here
_OFF_NOON_H = 2.5  # distance of the middle of the day's light from noon: clouds of half a day shift it by less
_LEAST_LIGHT = 500.0  # W h m^-2 of a day of which the middle is compared
_LEAST_RANGE = 6.0  # K between the coldest and the warmest air of a day that has a course
_DEEP_NIGHT = -8.0  # degree: the warmest air of a clear day comes before
# Standard atmosphere (ISO 2533) to 11 km, and the share by which weather changes its pressure: at sea level 870 to
# 1085 hPa are the extremes on record.
_SEA_LEVEL_HPA, _EXPONENT, _SCALE_M = 1013.25, 5.25588, 44330.77
_PRESSURE_SHARE, _REDUCED_SHARE = 0.09, 0.05
# Extremes on record at the surface (WMO World Weather and Climate Extremes Archive), Celsius.
_COLDEST, _WARMEST = -89.2, 56.7
_STRONG_WIND, _DRY = 40.0, 1.0  # m/s as a mean; percent: less is a fraction of 1


def doubts(site: Site, weather: Weather) -> list[str]:
    """What of a weather by hours can hardly be, a line each.

    Parameters
    ----------
    site : Site
        Site on the date of the state.
    weather : Weather
        Its files read.
    """
    lines: dict[str, None] = {}
    for day_site, table in _days(site, weather):
        light = [*_night_doubts(day_site, table)] or [*_noon_doubts(day_site, table)]
        lines |= dict.fromkeys([*light, *_course_doubts(day_site, table), *_range_doubts(day_site, table)])
    return list(lines)


def has_wrong_light(site: Site, weather: Weather) -> bool:
    """Whether a weather by hours has light while the Sun is down; parameters as `doubts`."""
    return any(True for day_site, table in _days(site, weather) for _ in _night_doubts(day_site, table))


def _days(site: Site, weather: Weather) -> Iterator[tuple[Site, HourlyWeather]]:
    """The tables of a weather, oldest first, each with the site on its date."""
    tables = [*weather.days_before, *([] if weather.hourly is None else [weather.hourly])]
    for before, table in zip(range(len(tables) - 1, -1, -1), tables, strict=True):
        yield site.model_copy(update={"date": site.date - timedelta(days=before)}), table


def zone_doubt(utc_offset_h: float, longitude: float, of: str) -> str:
    """A line where a clock is far from the Sun's at a longitude [degree]; empty where it is not."""
    solar = longitude / 15.0
    apart = (utc_offset_h - solar + 12.0) % 24.0 - 12.0
    if abs(apart) <= FARTHEST_ZONE_H:
        return ""
    return (
        f"{of} the clock is UTC{utc_offset_h:+g} h, {abs(apart):.1f} h from the Sun's time at longitude {longitude:g}"
        f" (UTC{solar:+.1f} h; warned beyond {FARTHEST_ZONE_H:g} h): the sign, or the zone, may be wrong"
    )


def _night_doubts(site: Site, table: HourlyWeather) -> Iterator[str]:
    """A line where a table has light while the Sun is down."""
    light, (ends, _, elevation) = _light(table), _intervals(site, table)
    if light is None:
        return
    dark = (elevation.max(axis=1) < _NIGHT) & (light > _STRAY)
    if dark.any():
        brightest = int(np.argmax(np.where(dark, light, 0.0)))
        yield (
            f"has {light[brightest]:.0f} W m^-2 of sunlight in the time to {clock_text(ends[brightest] % 24)} on "
            f"{site.date}, when the Sun is {-elevation[brightest].max():.0f} degrees or more below the horizon, and "
            f"light in {dark.sum()} intervals of the night: its clock, zone or place may be another"
        )


def _noon_doubts(site: Site, table: HourlyWeather) -> Iterator[str]:
    """A line where the middle of a day's light is far from the Sun's."""
    light, (ends, steps, elevation) = _light(table), _intervals(site, table)
    if light is None or np.sum(light * steps) < _LEAST_LIGHT or elevation.max() <= 0:
        return
    middle, sun = ends - 0.5 * steps, np.maximum(np.sin(np.radians(elevation.mean(axis=1))), 0.0)
    apart = (_middle(middle, light * steps) - _middle(middle, sun * steps) + 12.0) % 24.0 - 12.0
    if abs(apart) > _OFF_NOON_H:
        yield (
            f"has the middle of its light on {site.date} {abs(apart):.1f} h {'after' if apart > 0 else 'before'} that"
            " of the Sun: its clock or zone may be another"
        )


def _intervals(site: Site, table: HourlyWeather) -> tuple[Floats, Floats, Floats]:
    """Ends and lengths (n,) of the intervals of a table [h], and the Sun's elevation (n, 5) through them [degree]."""
    ends = np.array(table.time)
    steps = np.diff(ends, prepend=ends[-1] - 24.0)
    inside = ends[:, None] - steps[:, None] * np.linspace(0.0, 1.0, 5)
    return ends, steps, _elevation(site, inside)


def _light(table: HourlyWeather) -> Floats | None:
    """The strongest of what a table has of sunlight [W m^-2]."""
    columns = [getattr(table, name) for name in (*SUNLIGHT, TOTAL)]
    present = [np.array(column) for column in columns if column is not None]
    return np.max(present, axis=0) if present else None


def _middle(hours: Floats, weights: Floats) -> float:
    """Hour of the day at the middle of what is spread over it, as the angle of a clock."""
    angle = np.angle(np.sum(weights * np.exp(2j * np.pi * hours / 24.0)))
    return float(angle * 24.0 / (2.0 * np.pi))


def _elevation(site: Site, hours: Floats) -> Floats:
    """The Sun's centre at local clock hours of a day [degree], to half a degree (Spencer 1971, as in pvlib)."""
    from pvlib import solarposition

    day = site.date.timetuple().tm_yday
    noon = 12.0 - solarposition.equation_of_time_spencer71(day) / 60.0
    angle = np.radians(15.0 * (hours - site.utc_offset_h - noon) + site.longitude_deg)
    latitude, declination = np.radians(site.latitude_deg), solarposition.declination_spencer71(day)
    elevation: Floats = 90.0 - np.degrees(solarposition.solar_zenith_analytical(latitude, angle, declination))
    return elevation


def _course_doubts(site: Site, table: HourlyWeather) -> Iterator[str]:
    """A line where the warmest air of a day with a course comes in the night."""
    celsius, hours = np.array(table.air_temperature_c), np.array(table.time)
    if np.ptp(celsius) < _LEAST_RANGE:
        return
    warmest = hours[int(np.argmax(celsius))]
    through = _elevation(site, np.arange(0.0, 24.0, 0.5))
    elevation = float(_elevation(site, np.array([warmest]))[0])
    if elevation < _DEEP_NIGHT and through.max() > 0:
        yield (
            f"has its warmest air, {celsius.max():.1f} C, at {clock_text(warmest)} on {site.date}, when the Sun is"
            f" {-elevation:.0f} degrees below the horizon: its clock or zone may be another"
        )


def _range_doubts(site: Site, table: HourlyWeather) -> Iterator[str]:
    """Lines of values that are hardly on record, or of another unit."""
    celsius = np.array(table.air_temperature_c)
    if celsius.max() > _WARMEST or celsius.min() < _COLDEST:
        yield (
            f"has air of {celsius.min():.1f} to {celsius.max():.1f} C; on record are {_COLDEST:g} to {_WARMEST:g} C:"
            " its unit may be another"
        )
    if table.pressure_hpa is not None:
        altitude = 1e3 * (site.altitude_km if table.altitude_km is None else table.altitude_km)
        usual, mean = standard_pressure_hpa(altitude), float(np.mean(table.pressure_hpa))
        if abs(mean / usual - 1.0) > _PRESSURE_SHARE:
            reduced = abs(mean / _SEA_LEVEL_HPA - 1.0) < _REDUCED_SHARE
            cause = "it may be reduced to sea level" if reduced else "its unit may be another"
            yield f"has a pressure of {mean:.0f} hPa at {altitude:.0f} m, where {usual:.0f} hPa is usual: {cause}"
    humidity = table.relative_humidity_percent
    if humidity is not None and max(humidity) <= _DRY:
        yield f"has a relative humidity of at most {max(humidity):g} percent: it may be a share of 1"
    if table.wind_speed_m_s is not None and max(table.wind_speed_m_s) > _STRONG_WIND:
        yield f"has wind of {max(table.wind_speed_m_s):.0f} m/s: its unit may be another"


def standard_pressure_hpa(altitude: float) -> float:
    """Pressure of the standard atmosphere at an altitude [m].

    Examples
    --------
    >>> round(standard_pressure_hpa(1000.0), 1)
    898.7
    """
    return float(_SEA_LEVEL_HPA * (1.0 - altitude / _SCALE_M) ** _EXPONENT)
