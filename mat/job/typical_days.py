"""Days of a typical or measured year, EPW or TMY3, as the weather of a job."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from skyshine.mat.job.fields import clock_text
from skyshine.mat.job.surface import HOURLY_QUANTITIES, LONGEST_GAP_H, RADIATION, HourlyWeather, RainKey
from skyshine.mat.job.typical_years import RAIN_DEPTH, RAIN_HOURS, YearFile
from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN, ZERO_CELSIUS
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Substitute for a quantity that a typical year lacks for longer than linear interpolation may bridge.
_INSTEAD = {
    "relative_humidity_percent": "weather.relative_humidity_percent of the job, or its default, is taken",
    "wind_speed_m_s": "weather.wind_speed_m_s of the job, or its default, is taken",
    "cloud_fraction": "weather.cloud_fraction of the job, or its default, a clear sky, is taken",
    "pressure_hpa": "that of the state's profile is taken",
    "longwave_down_w_m2": "that of the state is taken",
}
_SAID_MM = 0.1  # least rain of a day that is reported: less wets nothing for an hour
_READ = ("air_temperature_c", *HOURLY_QUANTITIES, "pressure_hpa")


_LONGEST = 24  # hours over which a depth may have been gathered


def hourly_rain(year: YearFile, hours: Sequence[int]) -> Floats:
    """Rain in the hour that ends at each reading [mm h^-1]; NaN where the file tells none.

    Parameters
    ----------
    hours : sequence of int
        Numbers of readings.

    Notes
    -----
    A depth is with the hours over which it was gathered, which end at its reading (EnergyPlus, Auxiliary Programs,
    "Liquid Precipitation Depth" and "Quantity"; Wilcox and Marion 2008, table 1-3), one where they are missing. What a
    depth of several hours has beyond those that readings among them tell falls evenly in the others, whose readings
    tell none or 0: files write 0 for hours that nobody read.

    Raises
    ------
    InputError
        With file:line:column of what is no depth.
    """
    longest = _LONGEST * year.per_hour
    low, high = min(hours), min(max(hours) + longest, len(year.readings))
    low = max(low - longest, 0)
    span = range(low, high)
    depth, gathered = (year.values(name, span) for name in (RAIN_DEPTH, RAIN_HOURS))
    readings = np.where(np.isfinite(gathered), gathered * year.per_hour, 1.0)
    spans = np.clip(readings, 1.0, longest).round().astype(int)
    rain = np.where(spans == 1, depth, np.nan)
    for end in np.flatnonzero((spans > 1) & np.isfinite(depth)):
        part = np.arange(max(end - spans[end] + 1, 0), end + 1)
        known_rain = np.nan_to_num(rain[part])
        silent = part[known_rain <= 0]
        if silent.size:
            rain[silent] = max(depth[end] - known_rain.sum(), 0.0) / silent.size
    chosen: Floats = rain[np.asarray(hours) - low] * year.per_hour
    return chosen


@dataclass(frozen=True)
class TypicalDays:
    """Consecutive days of a typical year, and what is to be said of them."""

    hourly: list[HourlyWeather]
    notes: list[str]


def typical_days(
    year: YearFile,
    days: Sequence[date],
    utc_offset_h: float,
    radiation: bool,
    stated: Container[str],
    rain: RainKey | None,
) -> TypicalDays:
    """Each of consecutive days; a single one is taken to repeat.

    Raises
    ------
    InputError
        With file:line:column of what does not fit; see `read_weather`, also for the parameters.
    """
    notes: dict[str, None] = {}
    tables = []
    radiation = radiation or all(_is_lit(year, day) for day in days)
    for day in days:
        table, rows = _typical_day(year, day, utc_offset_h, radiation, stated, notes, repeats=len(days) == 1)
        tables.append(table if rain == "none" else _with_rain(year, table, rows, rain == "file", notes))
    if rain == "file" and all(table.rain_mm_h is None for table in tables):
        raise InputError(
            f"tells no liquid precipitation on {' and '.join(f'{day:%d %B}' for day in days[-1:])}, which rain: file"
            " asks for; allowed: days with depths in mm; take another date or file, or remove rain",
            file=year.file,
        )
    if any(table.rain_mm_h is not None for table in tables):
        tables = [
            table if table.rain_mm_h is not None else table.model_copy(update={"rain_mm_h": [0.0] * len(table.time)})
            for table in tables
        ]
    return TypicalDays(tables, list(notes))


def _is_lit(year: YearFile, day: date) -> bool:
    """Whether a day has light without wrong readings, and sunlight without gaps that may not be bridged."""
    try:
        rows = year.hours_of(_in_year(year, day))
        direct, diffuse, _ = (year.values(name, rows) for name in RADIATION)
    except InputError:
        return False  # where the day is read, what is wrong with it is said
    measured = np.flatnonzero(np.isfinite(direct + diffuse))
    gaps = np.diff([*measured, measured[0] + len(rows)]) if measured.size else np.array([len(rows)])
    return bool(gaps.max() <= LONGEST_GAP_H * year.per_hour and np.nansum(diffuse) > 0)


def _with_rain(
    year: YearFile, table: HourlyWeather, rows: list[int], requested: bool, notes: dict[str, None]
) -> HourlyWeather:
    """The day with its rain, where it is wanted or falls, which is said then."""
    try:
        rain = hourly_rain(year, rows)
    except InputError:
        if requested:
            raise
        return table  # who does not ask for rain is not stopped by a wrong depth
    silent = int(np.count_nonzero(np.isnan(rain)))
    if not requested:
        fallen = float(np.nansum(rain)) / year.per_hour
        if fallen < _SAID_MM:
            return table
        notes[
            f"has {fallen:.1f} mm of rain on a day that is read, which wets surfaces; rain: none of the weather leaves"
            " them dry"
        ] = None
    if silent:
        notes[f"has no rain value in {silent} of {len(rows)} hours; these are taken as dry"] = None
    if silent == len(rows):
        return table
    return table.model_copy(update={"rain_mm_h": [float(value) for value in np.nan_to_num(rain)]})


def _typical_day(
    year: YearFile,
    day: date,
    utc_offset_h: float,
    radiation: bool,
    stated: Container[str],
    notes: dict[str, None],
    *,
    repeats: bool,
) -> tuple[HourlyWeather, list[int]]:
    """The readings of a day of a typical year, each at the end of its hour as both formats define it, and their
    numbers.
    """
    rows, hours = _readings_of(year, day, utc_offset_h - year.utc_offset_h, repeats, notes)
    columns: dict[str, Any] = {
        "time": list(hours),
        "altitude_km": None if year.station.altitude is None else year.station.altitude / 1e3,
    }
    for name in (*_READ, *RADIATION) if radiation else _READ:
        if name in stated or (name == "longwave_down_w_m2" and name not in year.columns):
            continue
        columns[name] = _instead(year, rows, name, year.values(name, rows), notes)
    columns["relative_humidity_percent"] = _least(columns.get("relative_humidity_percent"))
    return hourly_weather(year.file, columns), rows


def _readings_of(
    year: YearFile, day: date, ahead_h: float, repeats: bool, notes: dict[str, None]
) -> tuple[list[int], Floats]:
    """Numbers of the readings of 24 hours and their local clock hours, ascending: of the file's day, or of the clock's
    where days do not repeat, to which the days beside it lend theirs.
    """
    readings = []
    for shift in (0,) if repeats else (-1, 0, 1):
        beside = day + timedelta(days=shift)
        interval = 1 / year.per_hour
        if not repeats and not -24.0 <= 24.0 * shift + ahead_h < 24.0 - interval:  # none of its readings is in the day
            continue
        if _in_year(year, beside) != beside:
            beside = _in_year(year, beside)
            notes["has no 29 February; the 28th is taken"] = None
        readings += [(24.0 * shift + year.readings[row][4] + ahead_h, row) for row in year.hours_of(beside)]
    inside = sorted((hour % 24.0, row) for hour, row in readings if repeats or 0 <= hour < 24)
    return [row for _, row in inside], np.array([hour for hour, _ in inside])


def _in_year(year: YearFile, day: date) -> date:
    """A day, or 28 February in the place of a 29th that the year lacks."""
    if (day.month, day.day) == (2, 29) and not any(reading[2:4] == (2, 29) for reading in year.readings):
        return day.replace(day=28)
    return day


def _instead(year: YearFile, rows: list[int], name: str, values: Floats, notes: dict[str, None]) -> Floats | None:
    """Values without gaps: short ones interpolated, long ones by other readings; None where the job must say."""
    missing = np.isnan(values)
    count = int(np.count_nonzero(missing))
    if not count:
        return values
    size = len(values)
    words = f"has no {name} in {count} of {size} {'hours' if year.per_hour == 1 else 'readings'}"
    present = np.flatnonzero(~missing)
    if present.size and np.max(np.diff([*present, present[0] + size])) <= LONGEST_GAP_H * year.per_hour:
        notes[f"{words}; interpolated"] = None
        return np.interp(np.arange(size), present, values[present], period=size)
    derived = None
    if name == "relative_humidity_percent":
        derived = _humidity_of_dew_point(year, rows), "the dew point"
    elif name == "cloud_fraction":
        derived = _cloud_of_longwave(year, rows), "the longwave radiation of the sky (Clark and Allen)"
    if derived is not None and np.all(np.isfinite(derived[0])):
        notes[f"{words}; it follows from {derived[1]}"] = None
        return np.where(missing, derived[0], values)
    if name not in _INSTEAD:
        line = min(year.readings[rows[number]][0] for number in np.flatnonzero(missing))
        raise InputError(
            f"{words.replace(' of ', ' of the ')}; allowed: gaps up to {LONGEST_GAP_H:g} h; take another date or file",
            file=year.file,
            line=line,
        )
    notes[f"{words}; {_INSTEAD[name]}"] = None
    return None


def _humidity_of_dew_point(year: YearFile, rows: list[int]) -> Floats:
    """Relative humidity over water, percent."""
    dew, air = (year.values(name, rows) + ZERO_CELSIUS for name in ("dew_point_c", "air_temperature_c"))
    return np.clip(100.0 * saturation_pressure(dew) / saturation_pressure(air), 0.0, 100.0)


def _cloud_of_longwave(year: YearFile, rows: list[int]) -> Floats:
    """Cloud fraction with which the emissivity of the sky is that of the horizontal infrared radiation.

    References
    ----------
    Clark and Allen (1978), Proc. 2nd National Passive Solar Conference, 675, with clouds by Walton (1983), NBSIR
    83-2655; as in the EnergyPlus Engineering Reference, "Sky Radiation Modeling".
    """
    longwave, celsius = year.values("longwave_down_w_m2", rows), year.values("air_temperature_c", rows)
    dew = year.values("dew_point_c", rows) + ZERO_CELSIUS
    clear = 0.787 + 0.764 * np.log(dew / 273.0)
    ratio = longwave / (STEFAN_BOLTZMANN * (celsius + ZERO_CELSIUS) ** 4 * clear)
    tenths = np.linspace(0.0, 10.0, 101)
    fraction: Floats = 0.1 * np.interp(ratio, 1 + 0.0224 * tenths - 0.0035 * tenths**2 + 0.00028 * tenths**3, tenths)
    return fraction


def _least(percent: Floats | None) -> Floats | None:
    return None if percent is None else np.minimum(percent, 100.0)


def hourly_weather(file: Path, columns: dict[str, Any]) -> HourlyWeather:
    """The model of values that were checked with their lines; what is left to refuse concerns the file as a whole."""
    plain = {
        name: [float(value) for value in values] if isinstance(values, np.ndarray) else values
        for name, values in columns.items()
    }
    plain["time"] = [clock_text(hours) for hours in plain["time"]]
    try:
        return HourlyWeather.model_validate(plain)
    except pydantic.ValidationError as error:
        raise InputError(error.errors()[0]["msg"].removeprefix("Value error, "), file=file) from None
