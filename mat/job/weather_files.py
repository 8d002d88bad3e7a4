"""Weather of a day, and of the days before it, from a file: EPW, TMY3, or a CSV table."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pydantic
from scipy import constants

from skyshine.mat.job.fields import clock_text, hours_of
from skyshine.mat.job.file_rain import hourly_rain
from skyshine.mat.job.surface import (
    HOURLY_QUANTITIES,
    LONGEST_GAP_H,
    RADIATION,
    SUNLIGHT,
    TOTAL,
    HourlyWeather,
    RainKey,
)
from skyshine.mat.job.typical_years import Station, YearFile, is_tmy3, read_year
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather_readings import HEIGHT_COLUMNS, WEATHER_COLUMNS, Readings, read_readings
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.regular_files import refuse_special_file

# What stands in the place of a quantity that a typical year lacks for longer than linear interpolation may bridge.
_INSTEAD = {
    "relative_humidity_percent": "weather.relative_humidity_percent of the job, or its default, stands for it",
    "wind_speed_m_s": "weather.wind_speed_m_s of the job, or its default, stands for it",
    "cloud_fraction": "weather.cloud_fraction of the job, or its default, a clear sky, stands for it",
    "pressure_hpa": "that of the state's profile stands for it",
    "longwave_down_w_m2": "that of the state stands for it",
}
_SAID_MM = 0.1  # of a day's rain: less wets nothing for an hour
_READ = ("air_temperature_c", *HOURLY_QUANTITIES, "pressure_hpa")


@dataclass(frozen=True)
class FileWeather:
    """The weather of a day out of a file.

    Attributes
    ----------
    hourly : HourlyWeather
    before : list of HourlyWeather
        Of the days before, oldest first.
    station : Station or None
        None for a CSV table, which has no place.
    notes : tuple of str
        What stands in the place of what the file lacks.
    """

    hourly: HourlyWeather
    before: list[HourlyWeather] = field(default_factory=list)
    station: Station | None = None
    notes: tuple[str, ...] = ()


def read_weather(
    file: Path,
    day: date,
    utc_offset_h: float,
    *,
    radiation: bool = False,
    given: Container[str] = (),
    days_before: int = 0,
    rain: RainKey | None = None,
) -> FileWeather:
    """The weather of a file on a day and on days before it, by local clock hours.

    Parameters
    ----------
    file : path
        ``.epw``; TMY3 in ``.csv``; or another ``.csv`` with columns time (08:30 of the local clock, or
        2026-06-21T08:30Z, with a zone), air_temperature and any others of `WEATHER_COLUMNS` in SI and percent;
        sunlight and longwave are means over the time since the row before.
    day : date
        Month and day are taken from a typical year.
    utc_offset_h : float
        Of the local clock; a typical year has its own.
    radiation : bool
        Read measured sunlight and, where the file has it, sky longwave too.
    given : container of str
        Keys that the job writes itself: the file need not have them.
    days_before : int
        Days before the day that are wanted too; the day is not taken to repeat then.
    rain : 'file', 'none' or None
        Whether rain is read; by default that of a CSV table is, that of a typical year is not.

    Raises
    ------
    InputError
        With file:line:column of what does not fit.
    """
    refuse_special_file(file)
    days = [day - timedelta(days=before) for before in range(days_before, -1, -1)]
    if file.suffix.lower() == ".epw":
        return _typical_days(read_year(file, "EPW"), days, utc_offset_h, radiation, given, rain)
    if file.suffix.lower() == ".csv":
        if is_tmy3(file):
            return _typical_days(read_year(file, "TMY3"), days, utc_offset_h, radiation, given, rain)
        *before, hourly = _day_tables(file, days, utc_offset_h, radiation)
        if rain == "file" and hourly.rain_mm_h is None:
            raise InputError("has no column 'rain', which rain: file asks for; add it, or remove rain", file=file)
        if rain == "none":
            before, hourly = [_dry(table) for table in before], _dry(hourly)
        return FileWeather(hourly, before)
    raise InputError(f"found the ending '{file.suffix}'; allowed: .epw or .csv; convert the file", file=file)


def _dry(table: HourlyWeather) -> HourlyWeather:
    return table.model_copy(update={"rain_mm_h": None})


def _day_tables(file: Path, days: Sequence[date], utc_offset_h: float, radiation: bool) -> list[HourlyWeather]:
    """The rows of each day; a table by time of day, without dates, is one day."""
    table = read_readings(file, WEATHER_COLUMNS, ["air_temperature"], lambda cell: local_seconds(cell, utc_offset_h))
    if radiation and "sw_down" not in table.values and not {"direct_normal", "diffuse"} <= {*table.values}:
        raise InputError(
            "the columns 'direct_normal' and 'diffuse' are missing; add them, or sw_down, or take computed radiation",
            file=file,
        )
    number = np.floor_divide(table.time, 86400.0).astype(int)
    if number[0] == 0:
        if len(days) > 1 or number[-1] > 0:
            raise InputError(
                "found a time of day; allowed: dates too where days before are wanted, on all lines; write such as"
                f" {days[-1]}T08:30Z",
                file=file,
                line=table.lines[0],
                column=1,
            )
        return [_day_table(table, slice(None), radiation)]
    tables = []
    for day in days:
        rows = np.flatnonzero(number == day.toordinal())
        if not rows.size:
            first, last = (date.fromordinal(int(at)) for at in number[[0, -1]])
            raise InputError(
                f"found no reading of {day}; allowed: days of the file, {first} to {last}; take another date, or fewer"
                " history_days",
                file=file,
            )
        tables.append(_day_table(table, slice(rows[0], rows[-1] + 1), radiation))
    return tables


def local_seconds(cell: str, utc_offset_h: float) -> float:
    """Seconds of the local clock since midnight of a time of day, or since that before year 1 of a date and time."""
    if "-" not in cell:
        return 3600.0 * hours_of(cell)
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        raise ValueError(f"found '{cell}'; allowed: a time such as 08:30, or 2026-06-21T08:30-07:00") from None
    zone = timezone(timedelta(hours=utc_offset_h))
    if moment.tzinfo is None:
        local = moment.replace(tzinfo=zone).isoformat()
        raise ValueError(
            f"found '{cell}', which names no zone; allowed: with one; write {local}, or Z after it for UTC"
        )
    moment = moment.astimezone(zone)
    of_day = moment - datetime.combine(moment.date(), datetime.min.time(), moment.tzinfo)
    return 86400.0 * moment.toordinal() + of_day.total_seconds()


def _day_table(table: Readings, rows: slice, radiation: bool) -> HourlyWeather:
    """Some rows, which are those of one day."""
    clock = np.mod(table.time[rows], 86400.0)
    part = Readings(table.file, table.lines[rows], clock, {name: each[rows] for name, each in table.values.items()})
    part.refuse_gaps(np.append(clock[1:], clock[0] + 86400.0) - clock, 3600.0 * LONGEST_GAP_H)
    values = part.values
    found = {
        "time": [seconds / 3600 for seconds in clock],
        "air_temperature_c": values["air_temperature"] - ZERO_CELSIUS,
        "relative_humidity_percent": _least(values.get("relative_humidity"), 100.0),
        "wind_speed_m_s": values.get("wind_speed"),
        "cloud_fraction": values.get("cloud_fraction"),
        "pressure_hpa": values["pressure"] / 100.0 if "pressure" in values else None,
        "rain_mm_h": values.get("rain"),
        "soil_moisture_m3_m3": values.get("soil_moisture"),
    }
    for name in HEIGHT_COLUMNS:
        if name in values:
            found[f"{name}_m"] = _constant(part, name)
    if radiation:
        found["longwave_down_w_m2"] = values.get("lw_down")
        # A thermopile's zero at night is a few watts off.
        if {"direct_normal", "diffuse"} <= {*values}:
            found |= {key: np.maximum(values[key.removesuffix("_w_m2")], 0.0) for key in SUNLIGHT}
        else:
            found[TOTAL] = np.maximum(values["sw_down"], 0.0)
    return _hourly(table.file, found)


def _constant(table: Readings, name: str) -> float:
    """The one value of a column; InputError at the line of another."""
    values = table.values[name]
    if np.any(values != values[0]):
        wrong = int(np.argmax(values != values[0]))
        raise InputError(
            f"{name}: found {values[wrong]:g} after {values[0]:g}; allowed: one height for the day; split the file",
            file=table.file,
            line=table.lines[wrong],
        )
    return float(values[0])


def _least(values: Floats | None, limit: float) -> Floats | None:
    return None if values is None else np.minimum(values, limit)


def _typical_days(
    year: YearFile,
    days: Sequence[date],
    utc_offset_h: float,
    radiation: bool,
    given: Container[str],
    rain: RainKey | None,
) -> FileWeather:
    """Each of consecutive days; a single one is taken to repeat."""
    notes: dict[str, None] = {}
    tables = []
    for day in days:
        table, rows = _typical_day(year, day, utc_offset_h, radiation, given, notes, repeats=len(days) == 1)
        tables.append(table if rain == "none" else _with_rain(year, table, rows, rain == "file", notes))
    if rain == "file" and all(table.rain_mm_h is None for table in tables):
        raise InputError(
            f"tells no liquid precipitation on {' and '.join(f'{day:%d %B}' for day in days[-1:])}, which rain: file"
            " asks for; allowed: days with depths in mm; take another date or file, or remove rain",
            file=year.file,
        )
    if rain == "file":
        tables = [
            table if table.rain_mm_h is not None else table.model_copy(update={"rain_mm_h": [0.0] * len(table.time)})
            for table in tables
        ]
    return FileWeather(tables[-1], tables[:-1], year.station, tuple(notes))


def _with_rain(
    year: YearFile, table: HourlyWeather, rows: list[int], wanted: bool, notes: dict[str, None]
) -> HourlyWeather:
    """The day with its rain, where it is wanted and told; else it is said that it rained."""
    try:
        rain = hourly_rain(year, rows)
    except InputError:
        if wanted:
            raise
        return table  # who asks for no rain is not stopped by a wrong depth
    silent = int(np.count_nonzero(np.isnan(rain)))
    if not wanted:
        fallen = float(np.nansum(rain))
        if fallen >= _SAID_MM:
            notes[
                f"has {fallen:.1f} mm of rain on a day that is read, which leaves surfaces dry; rain: file of the"
                " weather wets them"
            ] = None
        return table
    if silent:
        notes[f"tells no rain in {silent} of 24 hours; none stands for it"] = None
    if silent == len(rows):
        return table
    return table.model_copy(update={"rain_mm_h": [float(value) for value in np.nan_to_num(rain)]})


def _typical_day(
    year: YearFile,
    day: date,
    utc_offset_h: float,
    radiation: bool,
    given: Container[str],
    notes: dict[str, None],
    *,
    repeats: bool,
) -> tuple[HourlyWeather, list[int]]:
    """The 24 readings of a day of a typical year, each at the end of its hour as both formats define it, and their
    numbers.
    """
    rows, hours = _readings_of(year, day, utc_offset_h - year.utc_offset_h, repeats, notes)
    found: dict[str, Any] = {"time": list(hours), "altitude_km": year.station.altitude / 1e3}
    for name in (*_READ, *RADIATION) if radiation else _READ:
        if name in given or (name == "longwave_down_w_m2" and name not in year.columns):
            continue
        found[name] = _instead(year, rows, name, year.values(name, rows), notes)
    found["relative_humidity_percent"] = _least(found.get("relative_humidity_percent"), 100.0)
    return _hourly(year.file, found), rows


def _readings_of(
    year: YearFile, day: date, ahead_h: float, repeats: bool, notes: dict[str, None]
) -> tuple[list[int], Floats]:
    """Numbers of 24 readings and their local clock hours, ascending: of the file's day, or of the clock's where days
    do not repeat, to which the days beside it lend theirs.
    """
    found = []
    for shift in (0,) if repeats else (-1, 0, 1):
        beside = day + timedelta(days=shift)
        if not repeats and not -24.0 <= 24.0 * shift + ahead_h < 23.0:  # none of its hours 1 to 24 is in the day
            continue
        if (beside.month, beside.day) == (2, 29) and not any(reading[2:4] == (2, 29) for reading in year.readings):
            beside = beside.replace(day=28)
            notes["has no 29 February; the 28th stands for it"] = None
        found += [(24.0 * shift + hour + ahead_h, row) for hour, row in enumerate(year.hours_of(beside), 1)]
    inside = sorted((hour % 24.0, row) for hour, row in found if repeats or 0 <= hour < 24)
    return [row for _, row in inside], np.array([hour for hour, _ in inside])


def _instead(year: YearFile, rows: list[int], name: str, values: Floats, notes: dict[str, None]) -> Floats | None:
    """Values without gaps: short ones interpolated, long ones by other readings; None where the job must say."""
    missing = np.isnan(values)
    count = int(np.count_nonzero(missing))
    if not count:
        return values
    known, hours = np.flatnonzero(~missing), np.arange(24)
    if known.size and np.max(np.diff([*known, known[0] + 24])) <= LONGEST_GAP_H:
        notes[f"has no {name} in {count} of 24 hours; interpolated"] = None
        return np.interp(hours, known, values[known], period=24)
    other = None
    if name == "relative_humidity_percent":
        other = _humidity_of_dew_point(year, rows), "the dew point"
    elif name == "cloud_fraction":
        other = _cloud_of_longwave(year, rows), "the longwave radiation of the sky (Clark and Allen)"
    if other is not None and np.all(np.isfinite(other[0])):
        notes[f"has no {name} in {count} of 24 hours; it follows from {other[1]}"] = None
        return np.where(missing, other[0], values)
    if name not in _INSTEAD:
        line = min(year.readings[rows[number]][0] for number in np.flatnonzero(missing))
        raise InputError(
            f"has no {name} in {count} of the 24 hours; allowed: gaps up to {LONGEST_GAP_H:g} h; take another date or"
            " file",
            file=year.file,
            line=line,
        )
    notes[f"has no {name} in {count} of 24 hours; {_INSTEAD[name]}"] = None
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
    ratio = longwave / (constants.Stefan_Boltzmann * (celsius + ZERO_CELSIUS) ** 4 * clear)
    tenths = np.linspace(0.0, 10.0, 101)
    fraction: Floats = 0.1 * np.interp(ratio, 1 + 0.0224 * tenths - 0.0035 * tenths**2 + 0.00028 * tenths**3, tenths)
    return fraction


def _hourly(file: Path, found: dict[str, Any]) -> HourlyWeather:
    """The model of values that were checked with their lines; what is left to refuse concerns the file as a whole."""
    plain = {
        name: [float(value) for value in values] if isinstance(values, np.ndarray) else values
        for name, values in found.items()
    }
    plain["time"] = [clock_text(hours) for hours in plain["time"]]
    try:
        return HourlyWeather.model_validate(plain)
    except pydantic.ValidationError as error:
        raise InputError(error.errors()[0]["msg"].removeprefix("Value error, "), file=file) from None
