"""Weather of a day, and of the days before it, from a file: a typical year, a table, or netCDF."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field, replace
from datetime import date, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.soundings.netcdf import is_netcdf
from skyshine.mat.job.fields import hours_of
from skyshine.mat.job.surface import LONGEST_GAP_H, SUNLIGHT, TOTAL, HourlyWeather, RainKey
from skyshine.mat.job.typical_days import hourly_weather, typical_days
from skyshine.mat.job.typical_years import Station, YearFile, is_tmy3, read_year
from skyshine.mat.job.weather_netcdf import read_point
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.weather_forms import form_of, is_station_archive, read_form, read_station_archive
from skyshine.mat.surface.weather_history import NOTE, SUFFIX, read_history
from skyshine.mat.surface.weather_readings import HEIGHT_COLUMNS, WEATHER_COLUMNS, Readings, read_readings
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.errors import InputError
from skyshine.schemas.regular_files import refuse_special_file


@dataclass(frozen=True)
class FileWeather:
    """The weather of a day out of a file.

    Attributes
    ----------
    before : list of HourlyWeather
        Weather of the days before, oldest first.
    station : Station or None
        None for a table that states no place.
    utc_offset_h : float or None
        Clock offset from UTC [h] of a typical year; None for files whose times name their zone.
    notes : tuple of str
        Defaults used for what the file lacks.
    """

    hourly: HourlyWeather
    before: list[HourlyWeather] = field(default_factory=list)
    station: Station | None = None
    notes: tuple[str, ...] = ()
    utc_offset_h: float | None = None


def read_weather(
    file: Path,
    day: date,
    utc_offset_h: float,
    *,
    radiation: bool = False,
    stated: Container[str] = (),
    days_before: int = 0,
    rain: RainKey | None = None,
    place: tuple[float, float] | None = None,
) -> FileWeather:
    """The weather of a file on a day and on days before it, by local clock hours.

    Parameters
    ----------
    file : path
        ``.epw``; TMY3; a table of one of `FORMS`; a station file of BSRN; a ``.wth`` of DIRSIG; netCDF of a point by
        time; or CSV with columns time (08:30 of the local clock, or 2026-06-21T08:30Z, with a zone), air_temperature
        and any others of `WEATHER_COLUMNS` in SI and percent; sunlight and longwave are means over the time since the
        row before.
    day : date
        Month and day are taken from a typical year.
    utc_offset_h : float
        Offset of the local clock from UTC [h]; a typical year states its own.
    radiation : bool
        Whether the file must have measured sunlight; where it has, that is read, with sky longwave.
    stated : container of str
        Keys that the job writes itself: the file need not have them.
    days_before : int
        Days before the day that are wanted too; the day is not taken to repeat then.
    rain : 'file', 'none' or None
        Whether rain is read; by default that of a CSV table is, that of a typical year is not.
    place : (float, float), optional
        Latitude and longitude [degree] whose nearest point is read of netCDF with many.

    Raises
    ------
    InputError
        With file:line:column of what does not fit.
    """
    refuse_special_file(file)
    days = [day - timedelta(days=before) for before in range(days_before, -1, -1)]
    if file.suffix.lower() == ".epw":
        return _typical(read_year(file, "EPW"), days, utc_offset_h, radiation, stated, rain)
    if is_tmy3(file):
        return _typical(read_year(file, "TMY3"), days, utc_offset_h, radiation, stated, rain)
    weather = _day_tables(file, days, utc_offset_h, radiation, place)
    if rain == "file" and weather.hourly.rain_mm_h is None:
        raise InputError("has no column 'rain', which rain: file asks for; add it, or remove rain", file=file)
    return (
        weather
        if rain != "none"
        else replace(weather, hourly=_dry(weather.hourly), before=[*map(_dry, weather.before)])
    )


def _typical(
    year: YearFile,
    days: Sequence[date],
    utc_offset_h: float,
    radiation: bool,
    stated: Container[str],
    rain: RainKey | None,
) -> FileWeather:
    *before, hourly = (tables := typical_days(year, days, utc_offset_h, radiation, stated, rain)).hourly
    return FileWeather(hourly, before, year.station, tuple(tables.notes), year.utc_offset_h)


def _dry(table: HourlyWeather) -> HourlyWeather:
    return table.model_copy(update={"rain_mm_h": None})


def _day_tables(
    file: Path, days: Sequence[date], utc_offset_h: float, radiation: bool, place: tuple[float, float] | None
) -> FileWeather:
    """The rows of each day; a table by time of day, without dates, is one day."""
    table, station, typical = _table(file, utc_offset_h, place)
    has_sunlight = "sw_down" in table.values or {"direct_normal", "diffuse"} <= {*table.values}
    if radiation and not has_sunlight:
        raise InputError(
            "the columns 'direct_normal' and 'diffuse' are missing; add them, or sw_down, or take computed radiation",
            file=file,
        )
    notes = dict.fromkeys(table.notes)
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
        return FileWeather(_day_table(table, np.arange(number.size), station, notes), [], station, (*notes,))
    tables = []
    for day in days:
        rows = np.flatnonzero(number == day.toordinal())
        if not rows.size and typical:
            dates = [date.fromordinal(int(ordinal)) for ordinal in np.unique(number)]
            same_day = [
                ordinal.toordinal() for ordinal in dates if (ordinal.month, ordinal.day) == (day.month, day.day)
            ]
            rows = np.flatnonzero(np.isin(number, same_day[:1]))
        if not rows.size:
            earliest, latest = (date.fromordinal(int(at)) for at in number[[0, -1]])
            raise InputError(
                f"found no reading of {day}; allowed: days of the file, {earliest} to {latest}; take another date, or "
                "fewer history_days",
                file=file,
            )
        tables.append(_day_table(table, rows, station, notes))
    return FileWeather(tables[-1], tables[:-1], station, tuple(notes))


def _table(file: Path, utc_offset_h: float, place: tuple[float, float] | None) -> tuple[Readings, Station | None, bool]:
    """Readings in seconds of the local clock since midnight, or since that before year 1; where they were measured;
    whether their months are of several years.
    """
    if is_netcdf(file):
        readings, point, notes = read_point(file, place)
        return _local(readings, utc_offset_h, notes), None if point is None else Station(*point, None), False
    if file.suffix.lower() == SUFFIX:
        return replace(read_history(file), notes=(NOTE,)), None, False
    if is_station_archive(file):
        readings, location = read_station_archive(file)
        return _local(readings, utc_offset_h, ("is read as BSRN, by UTC",)), Station(*location), False
    text = read_text(file)
    form = form_of(text)
    if form is None:
        columns, needed = WEATHER_COLUMNS, ["air_temperature"]
        return read_readings(file, columns, needed, lambda cell: local_seconds(cell, utc_offset_h)), None, False
    form_file = read_form(text, file, form)
    station = None if form_file.location is None else Station(*form_file.location)
    return _local(form_file.readings, utc_offset_h, form_file.notes), station, form.typical


def _local(readings: Readings, utc_offset_h: float, notes: tuple[str, ...]) -> Readings:
    """Readings since 1970, UTC, by the local clock since the midnight before year 1."""
    since = 86400.0 * date(1970, 1, 1).toordinal() + 3600.0 * utc_offset_h
    return replace(readings, time=readings.time + since, notes=notes)


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


def _day_table(table: Readings, rows: Integers, station: Station | None, notes: dict[str, None]) -> HourlyWeather:
    """Some rows, which are those of one day, without gaps."""
    clock = np.mod(table.time[rows], 86400.0)
    lines, columns = [table.lines[n] for n in rows], {name: column[rows] for name, column in table.values.items()}
    part = Readings(table.file, lines, clock, columns)
    part.refuse_gaps(np.append(clock[1:], clock[0] + 86400.0) - clock, 3600.0 * LONGEST_GAP_H)
    values = {
        name: filled for name, column in columns.items() if (filled := _bridged(clock, name, column, notes)) is not None
    }
    fields: dict[str, Any] = {
        "time": [seconds / 3600 for seconds in clock],
        "air_temperature_c": values["air_temperature"] - ZERO_CELSIUS,
        "relative_humidity_percent": _least(values.get("relative_humidity"), 100.0),
        "wind_speed_m_s": values.get("wind_speed"),
        "cloud_fraction": values.get("cloud_fraction"),
        "pressure_hpa": values["pressure"] / 100.0 if "pressure" in values else None,
        "rain_mm_h": values.get("rain"),
        "soil_moisture_m3_m3": values.get("soil_moisture"),
        "altitude_km": None if station is None or station.altitude is None else station.altitude / 1e3,
    }
    for name in HEIGHT_COLUMNS:
        if name in values:
            fields[f"{name}_m"] = _constant(part, name)
    sunlight = [name.removesuffix("_w_m2") for name in SUNLIGHT]
    if {*sunlight} <= {*values} or "sw_down" in values:
        fields["longwave_down_w_m2"] = values.get("lw_down")
        # A thermopile's zero at night is a few watts off.
        if {*sunlight} <= {*values}:
            fields |= {f"{name}_w_m2": np.maximum(values[name], 0.0) for name in sunlight}
        else:
            fields[TOTAL] = np.maximum(values["sw_down"], 0.0)
    return hourly_weather(table.file, fields)


def _bridged(clock: Floats, name: str, values: Floats, notes: dict[str, None]) -> Floats | None:
    """Values of a day with those between them where a cell is missing; None beyond the longest gap."""
    present = np.isfinite(values)
    if present.all():
        return values
    gone = int(np.sum(~present))
    at = clock[present] / 3600.0
    if at.size and np.max(np.append(np.diff(at), at[0] + 24.0 - at[-1])) <= LONGEST_GAP_H:
        notes[f"has no {name} in {gone} of {len(values)} readings; interpolated"] = None
        return np.interp(clock, clock[present], values[present], period=86400.0)
    notes[f"has no {name} in {gone} of {len(values)} readings; not read on that day"] = None
    return None


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
