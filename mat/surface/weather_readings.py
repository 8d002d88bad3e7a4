"""Readings over time from CSV files, with units in the header and the place of what is wrong."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.convection import LEAST_HEIGHT
from skyshine.mat.surface.record import Record, equal_steps
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import Head, column_heads, data_lines, delimiter_of, read_text, row_cells
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.plain_numbers import plain_number

LEAST_READINGS = 4  # smallest number of readings of a record
MAXIMUM_GAP = 3 * 3600.0  # s that linear interpolation may bridge
MAXIMUM_STEPS = 200_000  # largest number of steps of a record: a year in steps of 3 minutes has 175,200
_SLIP = 0.75  # likeness of names, beyond which one is a slip of the pen for the other
MOST_MOISTURE = 0.95  # m3/m3, the porosity of the loosest peat


@dataclass(frozen=True)
class Column:
    """A column that a table may have.

    Attributes
    ----------
    units : dict of str to (float, float)
        Units that its header may name in brackets, as factor and offset to SI; the first is the default.
    low, high : float
        Limits of a value after conversion: wide enough for any place on Earth, narrow enough to catch another unit.
    """

    units: Mapping[str, tuple[float, float]]
    low: float
    high: float
    zero_allowed: bool = False  # whether 0 is allowed below the lowest: no air at all

    def to_si(self, cell: str, unit: str) -> float:
        """The value of a cell in a unit, by default the first; ValueError says what was found and what is allowed."""
        factor, offset = self.units[unit or next(iter(self.units))]
        try:
            value = plain_number(cell) * factor + offset
        except ValueError:
            value = np.nan
        if not (self.low <= value <= self.high or (self.zero_allowed and value == 0)):
            si_unit = next(iter(self.units)).replace("1", "")
            allowed = f"{self.low:g} to {self.high:g} {si_unit}".strip() + (
                " or 0, a vacuum" if self.zero_allowed else ""
            )
            raise ValueError(f"found '{cell}'; allowed: numbers from {allowed}; fix or remove the line")
        return value


AIR_COLUMNS = {
    "air_temperature": Column({"K": (1.0, 0.0), "C": (1.0, ZERO_CELSIUS), "F": (5 / 9, 459.67 * 5 / 9)}, 150.0, 350.0),
    "relative_humidity": Column({"%": (1.0, 0.0), "percent": (1.0, 0.0), "1": (100.0, 0.0)}, 0.0, 120.0),
    "wind_speed": Column({"m/s": (1.0, 0.0), "km/h": (1 / 3.6, 0.0), "kt": (1852 / 3600, 0.0)}, 0.0, 120.0),
    "pressure": Column({"Pa": (1.0, 0.0), "hPa": (100.0, 0.0), "kPa": (1000.0, 0.0)}, 20e3, 120e3, True),
}
# Heights of measurement, by default those of WMO-No. 8: 10 m and 2 m.
HEIGHT_COLUMNS = {name: Column({"m": (1.0, 0.0)}, LEAST_HEIGHT, 200.0) for name in ("wind_height", "air_height")}

# Thermopile pyranometers read a few W m^-2 below zero at night (thermal offset, BSRN: McArthur 2005, WMO/TD-No. 1274).
_WATTS = {"W/m2": (1.0, 0.0)}
RADIATION_COLUMNS = {
    "sw_down": Column(_WATTS, -25.0, 2000.0),
    "direct_normal": Column(_WATTS, -25.0, 1500.0),
    "diffuse": Column(_WATTS, -25.0, 1500.0),
    "lw_down": Column(_WATTS, 20.0, 800.0),
}
# On and in the ground. The heaviest rain of an hour on record is 305 mm, of a minute 31 mm.
WATER_COLUMNS = {
    "rain": Column({"mm/h": (1.0, 0.0)}, 0.0, 2000.0),
    "soil_moisture": Column({"m3/m3": (1.0, 0.0), "%": (0.01, 0.0)}, 0.0, MOST_MOISTURE),
}
# Weather columns of every weather table, in jobs and as the forcing of one surface.
WEATHER_COLUMNS = (
    AIR_COLUMNS
    | HEIGHT_COLUMNS
    | RADIATION_COLUMNS
    | WATER_COLUMNS
    | {"cloud_fraction": Column({"1": (1.0, 0.0), "%": (0.01, 0.0)}, 0.0, 1.0)}
)
NEEDED_COLUMNS = ("air_temperature", "relative_humidity", "wind_speed")  # needed columns of the forcing of one surface
# Columns of the surface itself, in the forcing of one surface: one of both.
SURFACE_COLUMNS = {
    "albedo": Column({"1": (1.0, 0.0), "%": (0.01, 0.0)}, 0.0, 1.0),
    "snow_age": Column({"d": (1.0, 0.0), "h": (1 / 24, 0.0)}, 0.0, 400.0),
}
# Columns of a surface beneath the instruments, where it was measured: its temperature, or the longwave that leaves it.
SKIN_COLUMNS = {
    "surface_temperature": Column(AIR_COLUMNS["air_temperature"].units, 100.0, 500.0),
    "lw_up": Column(_WATTS, 10.0, 3600.0),
}


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings in SI units.

    Attributes
    ----------
    lines : list of int
        Line of each reading in the file, counted from 1.
    time : (n,) ndarray
        Increasing, as the reader of times gives it [s].
    values : dict of str to (n,) ndarray
    notes : tuple of str
        What is to be said of the file.
    """

    file: Path
    lines: list[int]
    time: Floats
    values: dict[str, Floats]
    notes: tuple[str, ...] = ()

    def refuse_gaps(self, later: Floats, longest: float) -> None:
        """Raise InputError at the reading before which `later` [s], from its predecessor, exceeds `longest`."""
        if np.any(later > longest):
            wrong = int(np.argmax(later > longest))
            raise InputError(
                f"found a gap of {later[wrong] / 3600:.1f} h before this reading; allowed: {longest / 3600:g} h; "
                "fill it or use a shorter record",
                file=self.file,
                line=self.lines[(wrong + 1) % len(self.lines)],
                column=1,
            )


def read_readings(
    file: str | os.PathLike[str],
    columns: Mapping[str, Column],
    required: Iterable[str | tuple[str, ...]],
    read_time: Callable[[str], float],
    blank: Collection[str] = (),
) -> Readings:
    """Read a CSV file with a column time and some of `columns`, in any order.

    Parameters
    ----------
    file : path
        ``name[unit]`` in the header names another unit. Empty lines and lines that begin with # are skipped.
    columns : mapping
        Columns that are read; others are left alone, but a slip of the pen in a name is refused.
    required : iterable of str or tuple of str
        Those that it must have; of a tuple one.
    read_time : callable
        A cell to seconds; ValueError says what was found and what is allowed.
    blank : collection of str
        Columns whose cells may be empty; they are read as NaN.

    Raises
    ------
    InputError
        With file:line:column of what does not fit.
    """
    file = Path(file)
    lines = data_lines(read_text(file))
    if len(lines) < 1 + LEAST_READINGS:
        count = max(len(lines) - 1, 0)
        raise InputError(f"found {count} readings; allowed: a header and at least {LEAST_READINGS}", file=file)
    heads = _header(file, *lines[0], columns, ["time", *required])
    delimiter = delimiter_of(lines[0][1])
    rows = [
        _row(file, number, row_cells(file, number, line, len(heads), delimiter), heads, columns, read_time, blank)
        for number, line in lines[1:]
    ]
    numbers = [number for number, _ in lines[1:]]
    time = np.array([seconds for seconds, _ in rows])
    if np.any(np.diff(time) <= 0):
        raise InputError(
            "found a time that is not after the one before; allowed: increasing times; sort the file",
            file=file,
            line=numbers[int(np.argmax(np.diff(time) <= 0)) + 1],
            column=1,
        )
    names = [head.name for head in heads if head.name in columns]
    unread = ", ".join(head.name for head in heads if head.name not in columns and head.name != "time")
    notes = (f"has columns that are not read: {unread[:200]}",) if unread else ()
    values = {name: np.array([values[name] for _, values in rows]) for name in names}
    return Readings(file, numbers, time, values, notes)


def _header(
    file: Path, number: int, line: str, columns: Mapping[str, Column], required: list[str | tuple[str, ...]]
) -> list[Head]:
    """Columns of the file; those that are read have a known unit, and none is missing."""
    heads = column_heads(file, number, line)
    for head in heads:
        if head.name == "time":
            continue
        if head.name not in columns:
            if difflib.get_close_matches(head.name, ["time", *columns], n=1, cutoff=_SLIP):
                message = f"found the column '{head.name}'; {nearest(head.name, ['time', *columns])}"
                raise InputError(message, file=file, line=number, column=head.column)
            continue
        units = columns[head.name].units
        if head.unit and head.unit not in units:
            message = f"found the unit '{head.unit}' of {head.name}; {nearest(head.unit, units)}"
            raise InputError(message, file=file, line=number, column=head.column)
    both = [head for head in heads if head.name in SURFACE_COLUMNS]
    if len(both) > 1:
        message = f"found {both[0].name} and {both[1].name}; allowed: one of them; remove one"
        raise InputError(message, file=file, line=number, column=both[1].column)
    names = [head.name for head in heads]
    choices = [(name,) if isinstance(name, str) else name for name in required]
    missing = [choice for choice in choices if not set(choice) & set(names)]
    if missing:
        wanted = " or ".join(f"'{name}'" for name in missing[0])
        raise InputError(f"the column {wanted} is missing; add it", file=file, line=number, column=1)
    return heads


def _row(
    file: Path,
    number: int,
    cells: list[tuple[str, int]],
    heads: list[Head],
    columns: Mapping[str, Column],
    read_time: Callable[[str], float],
    blank: Collection[str],
) -> tuple[float, dict[str, float]]:
    """Seconds and the values in SI of a line."""
    seconds, values = np.nan, {}
    for head, (cell, column) in zip(heads, cells, strict=True):
        try:
            if head.name == "time":
                seconds = read_time(cell)
            elif head.name not in columns:
                continue
            elif not cell and head.name in blank:
                values[head.name] = np.nan
            else:
                values[head.name] = columns[head.name].to_si(cell, head.unit)
        except ValueError as error:
            raise InputError(f"{head.name}: {error}", file=file, line=number, column=column) from None
    return seconds, values


def read_record(file: str | os.PathLike[str], altitude: float = 0.0) -> Record:
    """Read a weather table and bring it to equal steps.

    Parameters
    ----------
    file : path
        Columns time (ISO 8601; UTC where it names no zone), air_temperature, relative_humidity, wind_speed, and sw_down
        or both direct_normal and diffuse, which count where all three are there; by choice the others of
        `WEATHER_COLUMNS`, and one of `SURFACE_COLUMNS`; in any order. ``name[unit]`` in the header names another unit.
        Those of `SKIN_COLUMNS` may be there too. Empty lines and lines that begin with # are skipped.
    altitude : float
        Altitude of the site [m], for a pressure that the file does not give.

    Returns
    -------
    Record
        At the file's own median step; between readings linear.

    Raises
    ------
    InputError
        With file:line:column of what does not fit.
    """
    readings = record_readings(file, NEEDED_COLUMNS)
    if "sw_down" not in readings.values and not {"direct_normal", "diffuse"} <= {*readings.values}:
        raise InputError("the column 'sw_down' is missing; add it, or direct_normal and diffuse", file=readings.file)
    return forcing_of(readings, altitude)


def record_readings(file: str | os.PathLike[str], required: Iterable[str | tuple[str, ...]]) -> Readings:
    """Readings of a forcing CSV without long gaps, time in seconds since 1970; see `read_record`."""
    columns = WEATHER_COLUMNS | SURFACE_COLUMNS | SKIN_COLUMNS
    readings = read_readings(file, columns, required, _moment, blank=SKIN_COLUMNS)
    readings.refuse_gaps(np.diff(readings.time), MAXIMUM_GAP)
    _, steps = equal_steps(readings.time)
    if steps > MAXIMUM_STEPS:
        raise InputError(f"found {steps} steps; allowed: {MAXIMUM_STEPS}; average the record or cut it", file=file)
    return readings


def forcing_of(readings: Readings, altitude: float = 0.0) -> Record:
    """The weather of readings at equal steps, without what was measured of the skin; altitude [m] as `read_record`."""
    weather = {name: values for name, values in readings.values.items() if name not in SKIN_COLUMNS}
    return Record.of(readings.time, weather, altitude)


def _moment(cell: str) -> float:
    """Seconds since 1970 of an ISO 8601 time; ValueError says what was found and what is allowed."""
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        raise ValueError(f"found '{cell}'; allowed: ISO 8601 such as 2016-01-01T13:30:00Z") from None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
