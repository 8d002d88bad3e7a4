"""Readings over time in CSV, with units in the header and the place of what is wrong."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.schemas.csv_table import cells as line_cells
from skyshine.schemas.csv_table import data_lines, named_unit, read_text
from skyshine.schemas.errors import InputError, nearest

LEAST_READINGS = 4


@dataclass(frozen=True)
class Column:
    """A column that a table may have.

    Attributes
    ----------
    units : dict of str to (float, float)
        Units that its header may name in brackets, as factor and offset to SI; the first is the default.
    low, high : float
        What a value may be after conversion: wide enough for any place on Earth, narrow enough to catch another unit.
    """

    units: Mapping[str, tuple[float, float]]
    low: float
    high: float


AIR_COLUMNS = {
    "air_temperature": Column({"K": (1.0, 0.0), "C": (1.0, 273.15), "F": (5 / 9, 459.67 * 5 / 9)}, 150.0, 350.0),
    "relative_humidity": Column({"%": (1.0, 0.0), "percent": (1.0, 0.0), "1": (100.0, 0.0)}, 0.0, 120.0),
    "wind_speed": Column({"m/s": (1.0, 0.0), "km/h": (1 / 3.6, 0.0), "kt": (1852 / 3600, 0.0)}, 0.0, 120.0),
    "pressure": Column({"Pa": (1.0, 0.0), "hPa": (100.0, 0.0), "kPa": (1000.0, 0.0)}, 0.0, 120e3),
}


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings in SI units.

    Attributes
    ----------
    file : Path
    lines : list of int
        Line of each reading in the file, counted from 1.
    time : (n,) ndarray
        Increasing, as the reader of times gives it [s].
    values : dict of str to (n,) ndarray
    """

    file: Path
    lines: list[int]
    time: np.ndarray
    values: dict[str, np.ndarray]

    def refuse_gaps(self, later: np.ndarray, longest: float) -> None:
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
    file: str | os.PathLike,
    columns: Mapping[str, Column],
    required: Iterable[str],
    read_time: Callable[[str], float],
) -> Readings:
    """Read a CSV file with a column time and some of `columns`, in any order.

    Parameters
    ----------
    file : path
        ``name[unit]`` in the header names another unit. Empty lines and lines that begin with # are skipped.
    columns : mapping
        Columns that it may have.
    required : iterable of str
        Those that it must have.
    read_time : callable
        A cell to seconds; ValueError says what was found and what is allowed.

    Raises
    ------
    InputError
        With file:line:column of what does not fit.
    """
    file = Path(file)
    text = read_text(file)
    lines = data_lines(text)
    if len(lines) < 1 + LEAST_READINGS:
        found = max(len(lines) - 1, 0)
        raise InputError(f"found {found} readings; allowed: a header and at least {LEAST_READINGS}", file=file)
    place, units = _header(file, *lines[0], columns, ["time", *required])
    rows = [_row(file, number, line, place, units, columns, read_time) for number, line in lines[1:]]
    numbers = [number for number, _ in lines[1:]]
    time = np.array([row[0] for row in rows])
    if np.any(np.diff(time) <= 0):
        raise InputError(
            "found a time that is not after the one before; allowed: increasing times; sort the file",
            file=file,
            line=numbers[int(np.argmax(np.diff(time) <= 0)) + 1],
            column=1,
        )
    return Readings(file, numbers, time, {name: np.array([row[1][name] for row in rows]) for name in units})


def _header(file: Path, number: int, line: str, columns, required) -> tuple[dict[str, int], dict]:
    """Index of each column, and the unit and conversion of each value."""
    place, units = {}, {}
    for index, (cell, column) in enumerate(line_cells(line)):
        name, unit = named_unit(cell)

        def refuse(message: str, column=column) -> InputError:
            return InputError(message, file=file, line=number, column=column)

        if name != "time" and name not in columns:
            raise refuse(f"found the column '{name}'; {nearest(name, ['time', *columns])}")
        if name in place:
            raise refuse(f"found the column '{name}' twice; allowed: once; remove one")
        place[name] = index
        if name != "time":
            choices = columns[name].units
            if unit and unit not in choices:
                raise refuse(f"found the unit '{unit}' of {name}; {nearest(unit, choices)}")
            units[name] = choices[unit or next(iter(choices))]
    missing = [name for name in required if name not in place]
    if missing:
        raise InputError(f"the column '{missing[0]}' is missing; add it", file=file, line=number, column=1)
    return place, units


def _row(file: Path, number: int, line: str, place: dict, units: dict, columns, read_time):
    """Seconds and the values in SI of a line."""
    cells = line_cells(line)
    if len(cells) != len(place):
        raise InputError(
            f"found {len(cells)} cells; allowed: {len(place)}, one for each column", file=file, line=number, column=1
        )
    values = {}
    for name, (factor, offset) in units.items():
        cell, column = cells[place[name]]
        low, high = columns[name].low, columns[name].high
        try:
            value = float(cell) * factor + offset
        except ValueError:
            value = np.nan
        if not low <= value <= high:
            unit = next(iter(columns[name].units)).replace("1", "")
            allowed = f"{low:g} to {high:g} {unit}".strip()
            raise InputError(
                f"{name}: found '{cell}'; allowed: numbers worth {allowed}; mend or remove the line",
                file=file,
                line=number,
                column=column,
            )
        values[name] = value
    cell, column = cells[place["time"]]
    try:
        return read_time(cell), values
    except ValueError as error:
        raise InputError(f"time: {error}", file=file, line=number, column=column) from None
