"""Readings of a day out of a typical or measured year in EPW or TMY3, each at the end of its hour.

References
----------
EnergyPlus, Auxiliary Programs: EPW data dictionary, with the code of a missing value for each field; Wilcox and Marion
(2008), NREL/TP-581-43156: TMY3.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import cells as placed_cells
from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number

Kind = Literal["EPW", "TMY3"]
_GROUND_CELLS = 16  # ground cells of a depth in the header of EPW
_NO_GROUND = 90.0  # Celsius: beyond, a code for a missing value
_BYTE_LIMIT = 64_000_000  # bytes; a year of hours has 2 MB
_EPW_HEADER = 8  # lines, where none of them says where it ends
_DATES = {"EPW": ("year", "month", "day", "hour"), "TMY3": ("Date (MM/DD/YYYY)", "Time (HH:MM)")}


@dataclass(frozen=True)
class _Field:
    """Column of a quantity, by number in EPW and by name in TMY3; its mark of a missing value, and above;
    factor to the job's unit; limits of a value in that unit.
    """

    epw: int
    missing: float
    tmy3: str | None
    epw_factor: float
    low: float
    high: float
    tmy3_factor: float = 1.0


RAIN_DEPTH, RAIN_HOURS = "rain_mm", "rain_hours"
FIELDS = {
    "air_temperature_c": _Field(6, 99.9, "Dry-bulb (C)", 1.0, -90.0, 70.0),
    "dew_point_c": _Field(7, 99.9, "Dew-point (C)", 1.0, -120.0, 70.0),
    "relative_humidity_percent": _Field(8, 999.0, "RHum (%)", 1.0, 0.0, 110.0),
    "wind_speed_m_s": _Field(21, 999.0, "Wspd (m/s)", 1.0, 0.0, 60.0),
    "cloud_fraction": _Field(22, 99.0, "TotCld (tenths)", 0.1, 0.0, 1.0, 0.1),
    "pressure_hpa": _Field(9, 999999.0, "Pressure (mbar)", 0.01, 200.0, 1100.0),
    "direct_normal_w_m2": _Field(14, 9999.0, "DNI (W/m^2)", 1.0, 0.0, 1500.0),
    "diffuse_w_m2": _Field(15, 9999.0, "DHI (W/m^2)", 1.0, 0.0, 1500.0),
    "longwave_down_w_m2": _Field(12, 9999.0, None, 1.0, 20.0, 800.0),
    RAIN_DEPTH: _Field(33, 999.0, "Lprecip depth (mm)", 1.0, 0.0, 500.0),
    RAIN_HOURS: _Field(34, 99.0, "Lprecip quantity (hr)", 1.0, 0.0, 24.0),
}
_LAST = (RAIN_DEPTH, RAIN_HOURS)  # which older files end before
_TMY3_MISSING = -9900.0  # missing value of TMY3 (NREL/TP-581-43156)


@dataclass(frozen=True)
class Station:
    """Where weather was measured: degree, degree, m above sea level; None where a file does not say."""

    latitude: float
    longitude: float
    altitude: float | None


@dataclass(frozen=True)
class GroundTemperatures:
    """Of undisturbed ground at a depth [m], by month [Celsius]; diffusivity [m^2 s^-1] where the file tells it."""

    depth: float
    diffusivity: float | None
    by_month: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class YearFile:
    """The lines of a year.

    Attributes
    ----------
    utc_offset_h : float
        Offset of the file's clock from UTC [h].
    columns : dict of str to int
        Number of the column of each quantity that the file has.
    readings : list of (line, year, month, day, hour, cells)
        Readings in order; each covers the interval that ends at its hour, up to 24.
    per_hour : int
        Readings an hour.
    ground : tuple of GroundTemperatures
        Ground temperatures by depth; empty if the file has none.
    """

    file: Path
    kind: Kind
    station: Station
    utc_offset_h: float
    columns: Mapping[str, int]
    readings: Sequence[tuple[int, int, int, int, float, list[str]]]
    ground: tuple[GroundTemperatures, ...] = ()
    per_hour: int = 1

    def hours_of(self, day: date) -> list[int]:
        """Numbers of the readings of a day, of its own year where the file has it; in order of the hour.

        Raises
        ------
        InputError
            They are not those of 24 hours.
        """
        rows = [
            n
            for n, (_, _, month, of_month, _, _) in enumerate(self.readings)
            if (month, of_month) == (day.month, day.day)
        ]
        if len({self.readings[n][1] for n in rows}) > 1:
            rows = [n for n in rows if self.readings[n][1] == day.year]
        rows.sort(key=lambda n: self.readings[n][4])
        ends = [self.readings[n][4] for n in rows]
        if ends != [number / self.per_hour for number in range(1, 24 * self.per_hour + 1)]:
            raise self._wrong_hours(day, rows, ends)
        return rows

    def _wrong_hours(self, day: date, rows: list[int], ends: list[float]) -> InputError:
        """What is wrong with the readings of a day."""
        message = f"found {len(rows)} readings of {day:%d %B}; allowed: {24 * self.per_hour}"
        repeated = [n for n, before, after in zip(rows[1:], ends, ends[1:], strict=False) if before == after]
        line = self.readings[repeated[0] if repeated else rows[0]][0] if rows else None
        if not self.readings:
            message = f"found 0 hours of {day:%d %B}, and no others; allowed: readings below the header; check the file"
        elif not rows:
            start, stop = self.readings[0], self.readings[-1]
            message = (
                f"found 0 hours of {day:%d %B}; allowed: days from {start[2]}/{start[3]} to {stop[2]}/{stop[3]}"
                " (month/day); take another date or file"
            )
        elif min(ends) == 0:
            message = (
                f"found hours from 0 to {max(ends):g} of {day:%d %B}; allowed: 1 to 24, the ends of the hours; add 1 to"
                " all, if they name the beginnings"
            )
        elif repeated and len(rows) % 24 == 0 and len(rows) > 24 * self.per_hour:
            message += (
                f", for field 3 of DATA PERIODS states {self.per_hour} an hour; write {len(rows) // 24} there, and"
                " minutes to 60"
            )
        elif repeated:
            message += f"; that of {self.readings[repeated[0]][4]:g} h is there twice; remove one"
        else:
            steps = range(1, 24 * self.per_hour + 1)
            gone = [f"{number / self.per_hour:g}" for number in steps if number / self.per_hour not in ends]
            message += f"; those that end at {', '.join(gone[:6])} h are missing; take another date or file"
        return InputError(message, file=self.file, line=line)

    def values(self, quantity: str, hours: Sequence[int]) -> Floats:
        """Values of a quantity in the unit of the job's key; NaN where they are missing.

        Raises
        ------
        InputError
            With file:line:column of what is no such value.
        """
        if quantity not in self.columns:
            return np.full(len(hours), np.nan)
        field, column = FIELDS[quantity], self.columns[quantity]
        converted = np.empty(len(hours))
        for n, hour in enumerate(hours):
            cells = self.readings[hour][-1]
            try:
                number = plain_number(cells[column]) if "".join(cells[column : column + 1]).strip() else np.nan
            except ValueError:
                raise self._error(hour, quantity, f"found '{cells[column][:40]}'; allowed: a number") from None
            if self.kind == "EPW":
                missing = number >= field.missing or number <= _TMY3_MISSING  # which converted files keep
                converted[n] = np.nan if missing else number * field.epw_factor
            else:
                converted[n] = np.nan if number <= _TMY3_MISSING else number * field.tmy3_factor
            if converted[n] < field.low or converted[n] > field.high:
                raise self._error(
                    hour,
                    quantity,
                    f"found {cells[column].strip()[:40]}; allowed: numbers from {field.low:g} to {field.high:g} of"
                    f" {quantity}; the reading is wrong: take another date or file",
                )
        return converted

    def _error(self, hour: int, quantity: str, message: str) -> InputError:
        line, cells = self.readings[hour][0], self.readings[hour][-1]
        column = placed_cells(",".join(cells))[self.columns[quantity]][1]
        return InputError(f"{quantity}: {message}", file=self.file, line=line, column=column)


def is_tmy3(file: Path) -> bool:
    """Whether the second line is the header of a TMY3 file."""
    with file.open(encoding="utf-8", errors="replace") as lines:
        return any(lines.readline(4096).startswith(_DATES["TMY3"][0]) for _ in range(2))


def read_year(file: Path, kind: Kind) -> YearFile:
    """The lines of a year, read once for all states of a job.

    Raises
    ------
    InputError
        With file:line of a header, a date or a row that is none.
    """
    return _year(file, kind, file.stat().st_mtime_ns)


@lru_cache(maxsize=4)
def _year(file: Path, kind: Kind, changed_ns: int) -> YearFile:
    if file.stat().st_size > _BYTE_LIMIT:
        raise InputError(f"found {file.stat().st_size} bytes; allowed: at most {_BYTE_LIMIT}", file=file)
    content = file.read_bytes()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # names of places; everything else is ASCII
    lines = text.splitlines()
    try:
        rows = [next(csv.reader([line]), []) for line in lines]
    except csv.Error as error:
        raise InputError(f"is no {kind} file: {error}; check it", file=file) from None
    return _epw(file, rows) if kind == "EPW" else _tmy3(file, rows)


def _epw(file: Path, rows: list[list[str]]) -> YearFile:
    station, offset = _station(file, rows, "EPW", (6, 7, 9, 8))
    header_end = next(
        (n for n, row in enumerate(rows[:40]) if row and row[0].upper() == "DATA PERIODS"), _EPW_HEADER - 1
    )
    columns = {name: field.epw for name, field in FIELDS.items()}
    per_hour = _per_hour(file, rows, header_end)
    readings, fewest = [], 1 + max(column for name, column in columns.items() if name not in _LAST)
    for number, cells in enumerate(rows[header_end + 1 :], header_end + 2):
        if not any(cells):
            continue
        _refuse_short(file, number, cells, fewest)
        year, month, day, hour = (_whole(file, number, cells, n, _DATES["EPW"][n]) for n in range(4))
        end: float = hour
        if per_hour > 1:
            minute = _whole(file, number, cells, len(_DATES["EPW"]), "minute")
            end = round((hour - 1 + minute / 60) * per_hour) / per_hour
        readings.append((number, year, month, day, end, cells))
    ground = _ground(file, rows[: header_end + 1])
    return YearFile(file, "EPW", station, offset, columns, readings, ground, per_hour)


def _per_hour(file: Path, rows: list[list[str]], line: int) -> int:
    """Readings an hour, by field 3 of DATA PERIODS; 1 where there is none."""
    if line >= len(rows) or len(rows[line]) < 3 or rows[line][0].upper() != "DATA PERIODS":
        return 1
    count = _whole(file, line + 1, rows[line], 2, "records an hour")
    if not 1 <= count <= 60 or 60 % count:
        raise InputError(
            f"found {count} records an hour; allowed: 1 to 60, a divisor of 60; mend field 3 of DATA PERIODS",
            file=file,
            line=line + 1,
            column=1,
        )
    return count


def _ground(file: Path, header: list[list[str]]) -> tuple[GroundTemperatures, ...]:
    """The header's ground temperatures: a count, and for each depth conductivity, density, heat capacity, 12 months."""
    number = next((n for n, row in enumerate(header, 1) if row and row[0].upper() == "GROUND TEMPERATURES"), 0)
    cells = [cell.strip() for cell in header[number - 1][2:]] if number else []
    profiles = []
    for start in range(0, len(cells) - _GROUND_CELLS + 1, _GROUND_CELLS):
        block = cells[start : start + _GROUND_CELLS]
        try:
            depth, *months = (plain_number(cell) for cell in (block[0], *block[4:]))
            soil = [plain_number(cell) for cell in block[1:4]] if all(block[1:4]) else []
        except ValueError:
            column = placed_cells(",".join(header[number - 1]))[2 + start][1]
            raise InputError(
                "found ground temperatures that are no numbers; allowed: a depth, three numbers or none, 12 months",
                file=file,
                line=number,
                column=column,
            ) from None
        diffusivity = soil[0] / (soil[1] * soil[2]) if len(soil) == 3 and min(soil) > 0 else None
        if depth >= 0 and max(map(abs, months)) < _NO_GROUND:
            profiles.append(GroundTemperatures(depth, diffusivity, tuple(months)))
    return tuple(profiles)


def _tmy3(file: Path, rows: list[list[str]]) -> YearFile:
    station, offset = _station(file, rows, "TMY3", (4, 5, 6, 3))
    names = [name.strip() for name in rows[1]] if len(rows) > 1 else []
    columns = {name: names.index(field.tmy3) for name, field in FIELDS.items() if field.tmy3 in names}
    dates = [names.index(name) if name in names else -1 for name in _DATES["TMY3"]]
    if min(dates) < 0 or "air_temperature_c" not in columns:
        raise InputError(
            "has no dates, times or dry-bulb temperatures; allowed: TMY3; check its header", file=file, line=2
        )
    readings = []
    for number, cells in enumerate(rows[2:], 3):
        if not any(cells):
            continue
        _refuse_short(file, number, cells, max(*columns.values(), *dates) + 1)
        try:
            month, day, year = map(int, cells[dates[0]].split("/"))
            hour, _ = map(int, cells[dates[1]].split(":"))
        except ValueError:
            raise InputError(
                f"found '{cells[dates[0]][:20]} {cells[dates[1]][:20]}'; allowed: MM/DD/YYYY and HH:MM",
                file=file,
                line=number,
                column=1,
            ) from None
        readings.append((number, year, month, day, hour, cells))
    return YearFile(file, "TMY3", station, offset, columns, readings)


def _station(file: Path, rows: list[list[str]], kind: Kind, at: tuple[int, int, int, int]) -> tuple[Station, float]:
    """Latitude, longitude and altitude, and the offset of the clock [h], at these cells of the first line."""
    try:
        latitude, longitude, altitude, offset = (plain_number(rows[0][cell].strip()) for cell in at)
    except (IndexError, ValueError):
        raise InputError(
            f"found no place and time zone in the first line; allowed: the header of {kind}; check the file",
            file=file,
            line=1,
        ) from None
    if not (abs(latitude) <= 90 and abs(longitude) <= 360 and -600 <= altitude <= 9000 and abs(offset) <= 15):
        raise InputError(
            f"found latitude {latitude:g}, longitude {longitude:g}, altitude {altitude:g} m, time zone {offset:g};"
            " allowed: a place on Earth; check the header",
            file=file,
            line=1,
        )
    return Station(latitude, longitude, altitude), offset


def _refuse_short(file: Path, line: int, cells: list[str], fewest: int) -> None:
    if len(cells) < fewest:
        raise InputError(f"found {len(cells)} cells; allowed: {fewest} or more", file=file, line=line, column=1)


def _whole(file: Path, line: int, cells: list[str], column: int, name: str) -> int:
    try:
        return int(plain_number(cells[column].strip()))
    except ValueError:
        raise InputError(
            f"{name}: found '{cells[column][:40]}'; allowed: a whole number",
            file=file,
            line=line,
            column=placed_cells(",".join(cells))[column][1],
        ) from None
