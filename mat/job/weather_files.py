"""Weather of one day from a file: EPW, TMY3, or a CSV table by time of day."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from datetime import date
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from skyshine.mat.job.fields import clock_text, hours_of
from skyshine.mat.job.surface import LONGEST_GAP_H, HourlyWeather
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.weather_readings import AIR_COLUMNS, Column, read_readings
from skyshine.schemas.errors import InputError
from skyshine.schemas.regular_files import refuse_special_file

_WATTS = {"W/m2": (1.0, 0.0)}
COLUMNS = AIR_COLUMNS | {
    "cloud_fraction": Column({"1": (1.0, 0.0), "%": (0.01, 0.0)}, 0.0, 1.0),
    "direct_normal": Column(_WATTS, 0.0, 1500.0),
    "diffuse": Column(_WATTS, 0.0, 1500.0),
    "lw_down": Column(_WATTS, 20.0, 800.0),
}


@dataclass(frozen=True)
class Station:
    """Where a typical year was measured: degree, degree, m above sea level."""

    latitude: float
    longitude: float
    altitude: float


@dataclass(frozen=True)
class _TypicalYear:
    """How a format of typical years holds its readings: pvlib's names with factor to the unit of the job's key.

    Attributes
    ----------
    name : str
    header : int
        Lines before the first reading.
    label : numpy.timedelta64
        From the beginning of an hour to the label that pvlib gives it.
    columns, radiation : dict of str to (str, float)
    """

    name: str
    header: int
    label: np.timedelta64
    columns: dict[str, tuple[str, float]]
    radiation: dict[str, tuple[str, float]]


_COMMON = {
    "air_temperature_c": ("temp_air", 1.0),
    "relative_humidity_percent": ("relative_humidity", 1.0),
    "wind_speed_m_s": ("wind_speed", 1.0),
}
_SUNLIGHT = {"direct_normal_w_m2": ("dni", 1.0), "diffuse_w_m2": ("dhi", 1.0)}
# EnergyPlus, Auxiliary Programs: EPW data dictionary; Wilcox and Marion (2008), NREL/TP-581-43156: TMY3.
_EPW = _TypicalYear(
    "EPW",
    8,
    np.timedelta64(0, "h"),
    _COMMON | {"cloud_fraction": ("total_sky_cover", 0.1), "pressure_hpa": ("atmospheric_pressure", 0.01)},
    _SUNLIGHT | {"longwave_down_w_m2": ("ghi_infrared", 1.0)},
)
_TMY3 = _TypicalYear(
    "TMY3",
    2,
    np.timedelta64(1, "h"),
    _COMMON | {"cloud_fraction": ("TotCld (tenths)", 0.1), "pressure_hpa": ("pressure", 1.0)},
    _SUNLIGHT,
)
# What a reading may be: a missing one stands as 99 or more of its digits.
_LIMITS = {
    "air_temperature_c": (-90.0, 70.0),
    "relative_humidity_percent": (0.0, 110.0),
    "wind_speed_m_s": (0.0, 60.0),
    "cloud_fraction": (0.0, 1.0),
    "pressure_hpa": (200.0, 1100.0),
    "direct_normal_w_m2": (0.0, 1500.0),
    "diffuse_w_m2": (0.0, 1500.0),
    "longwave_down_w_m2": (20.0, 800.0),
}


def read_weather(file: Path, day: date, utc_offset_h: float, *, radiation: bool = False) -> HourlyWeather:
    """The weather of a file on a day, by local clock hours.

    Parameters
    ----------
    file : path
        ``.epw``; TMY3 in ``.csv``; or another ``.csv`` with columns time (such as 08:30, local clock),
        air_temperature and any of relative_humidity, wind_speed, pressure, cloud_fraction in SI and percent, and of
        direct_normal, diffuse and lw_down, means over the time since the row before.
    day : date
        Month and day are taken from a typical year.
    utc_offset_h : float
        Of the local clock; a typical year has its own.
    radiation : bool
        Read measured sunlight and, where the file has it, sky longwave too.

    Raises
    ------
    InputError
        With file:line of what does not fit.
    """
    refuse_special_file(file)
    if file.suffix.lower() == ".epw":
        return _typical_day(file, _EPW, day, utc_offset_h, radiation)
    if file.suffix.lower() == ".csv":
        return (
            _typical_day(file, _TMY3, day, utc_offset_h, radiation) if _is_tmy3(file) else _day_table(file, radiation)
        )
    raise InputError(f"found the ending '{file.suffix}'; allowed: .epw or .csv; convert the file", file=file)


def station_of(file: Path) -> Station | None:
    """Place in the header of a typical year; None for a table by time of day, which has none."""
    kind = _EPW if file.suffix.lower() == ".epw" else _TMY3 if _is_tmy3(file) else None
    if kind is None:
        return None
    station = _year(file, file.stat().st_mtime_ns, kind.name)[1]
    return Station(*(float(station[name]) for name in ("latitude", "longitude", "altitude")))


def _is_tmy3(file: Path) -> bool:
    """Whether the second line is the header of a TMY3 file."""
    with file.open(encoding="utf-8", errors="replace") as lines:
        return any(line.startswith("Date (MM/DD/YYYY)") for line in itertools.islice(lines, 2))


def _day_table(file: Path, radiation: bool) -> HourlyWeather:
    needed = ["air_temperature", *(("direct_normal", "diffuse") if radiation else ())]
    table = read_readings(file, COLUMNS, needed, lambda cell: 3600.0 * hours_of(cell))
    following = np.append(table.time[1:], table.time[0] + 86400.0)
    table.refuse_gaps(following - table.time, 3600.0 * LONGEST_GAP_H)
    values = table.values
    found = {
        "time": [seconds / 3600 for seconds in table.time],
        "air_temperature_c": values["air_temperature"] - ZERO_CELSIUS,
        "relative_humidity_percent": _least(values.get("relative_humidity"), 100.0),
        "wind_speed_m_s": values.get("wind_speed"),
        "cloud_fraction": values.get("cloud_fraction"),
        "pressure_hpa": values["pressure"] / 100.0 if "pressure" in values else None,
    }
    if radiation:
        found |= {
            "direct_normal_w_m2": values["direct_normal"],
            "diffuse_w_m2": values["diffuse"],
            "longwave_down_w_m2": values.get("lw_down"),
        }
    return _hourly(file, found)


def _least(values: np.ndarray | None, limit: float) -> np.ndarray | None:
    return None if values is None else np.minimum(values, limit)


def _typical_day(file: Path, kind: _TypicalYear, day: date, utc_offset_h: float, radiation: bool) -> HourlyWeather:
    """The 24 readings of a day of a typical year, each at the end of its hour as both formats define it."""
    import pandas

    data, station = _year(file, file.stat().st_mtime_ns, kind.name)
    begin = data.index - kind.label
    rows = np.flatnonzero((begin.month == day.month) & (begin.day == day.day))
    if rows.size != 24:
        raise InputError(
            f"found {rows.size} hours of {day:%d %B}; allowed: the 24 of a day; take another date or file", file=file
        )
    hours = (np.asarray(begin.hour[rows]) + 1 + utc_offset_h - float(station["TZ"])) % 24.0
    order = np.argsort(hours)
    found: dict[str, Any] = {"time": list(hours[order]), "altitude_km": float(station["altitude"]) / 1e3}
    for name, (source, factor) in (kind.columns | kind.radiation if radiation else kind.columns).items():
        if source not in data:
            raise InputError(f"has no {source}, which {kind.name} has; check its header", file=file)
        cells = data[source].iloc[rows]
        values = factor * pandas.to_numeric(cells, errors="coerce").to_numpy(float)
        low, high = _LIMITS[name]
        wrong = np.flatnonzero(~((values >= low) & (values <= high)))
        if wrong.size:
            raise InputError(
                f"{source}: found {str(cells.iloc[wrong[0]])[:40]}; allowed: numbers worth {low:g} to {high:g} of"
                f" {name}; the reading is missing or wrong: take another date or file",
                file=file,
                line=int(rows[wrong[0]]) + kind.header + 1,
            )
        found[name] = values[order]
    found["relative_humidity_percent"] = _least(found["relative_humidity_percent"], 100.0)
    return _hourly(file, found)


@lru_cache(maxsize=4)
def _year(file: Path, changed_ns: int, name: str) -> tuple[Any, dict[str, Any]]:
    """All readings of a typical year with its station, read once for all states of a job."""
    from pvlib import iotools

    try:
        if name == _EPW.name:
            data, station = iotools.read_epw(file)
        else:
            data, station = iotools.read_tmy3(file, map_variables=True)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError) as error:  # pvlib's own
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"is not a file that pvlib reads as {name}: {reason}; check it", file=file) from None
    return data, station


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
