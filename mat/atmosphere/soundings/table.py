"""Soundings in CSV: our own columns, lists of radiosondes and of the University of Wyoming."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.soundings.readings import Readings
from skyshine.mat.atmosphere.soundings.units import HUMIDITY, NAMES, PARTS, UNITS, to_si
from skyshine.mat.atmosphere.state.profiles import GASES
from skyshine.schemas.column_names import column_of, folded, unit_of
from skyshine.schemas.csv_table import ROW_LIMIT, cells, data_lines, delimiter_of, row_cells
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.plain_numbers import plain_number

_NAMES = NAMES | {gas.lower(): gas for gas in GASES if gas != "H2O"}
_UNITS = UNITS | dict.fromkeys((gas for gas in GASES if gas != "H2O"), PARTS)
# Fraction of other columns, those that a slip of the pen made of ours.
_SLIP = 0.9
_CLOCKS = ("time", "elapsed_time", "flight_time", "seconds", "date_time", "datetime", "utc", "utc_time", "timestamp")
# Cells without a reading. Altitudes apart, which may be -999 ft, no quantity reaches the numbers.
_MISSING = re.compile(r"|-+|/+|[nN]/?[aA]|null|None")
_CODES = {-999.0, -999.9, -999.99, -9999.0, -9999.9, -99999.0, -32768.0}


def read_table(text: str, file: Path) -> Readings:
    """A sounding with one level a row.

    Parameters
    ----------
    text : str
        Columns named ``name[unit]``, ``name (unit)`` or ``name_unit``, between commas, semicolons or tabs: altitude or
        geopotential height, pressure, temperature, one or more measures of humidity, and gases. Other columns are left
        alone. A cell may be empty. Rows of a file with a column of times are those of a balloon.
    file : Path
        Named in messages.

    Raises
    ------
    InputError
        With file:line:column of a column that is missing or misspelt, of a unit, or of what is no number.
    """
    lines = data_lines(text)
    if not 2 < len(lines) <= ROW_LIMIT:
        raise InputError(
            f"found {max(len(lines) - 1, 0)} rows of numbers; allowed: 2 to {ROW_LIMIT} below a line of column names",
            file=file,
        )
    number, line = lines[0]
    delimiter = delimiter_of(line)
    heads = cells(line, delimiter)
    columns = _columns(file, number, heads)
    clock = next((i for i, (head, _) in enumerate(heads) if folded(re.split(r"[\[(]", head)[0]) in _CLOCKS), None)
    raw: dict[str, list[float]] = {name: [] for name in columns}
    positions: dict[tuple[int, str], tuple[int, int]] = {}
    time = None
    for row, (number, line) in enumerate(lines[1:]):
        words = row_cells(file, number, line, len(heads), delimiter)
        if clock is not None and row == 0:
            time = _moment(words[clock][0])
        for name, (index, _) in columns.items():
            cell, column = words[index]
            positions[row, name] = (number, column)
            raw[name].append(_number(file, name, cell, positions[row, name]))
    as_written = {name: np.array(numbers) for name, numbers in raw.items()}
    values = {}
    for name, (_, unit) in columns.items():
        factor, offset = to_si(name, unit)
        values[name] = as_written[name] * factor + offset
    return Readings(file, values, "sorted" if clock is None else "flown", time, as_written, positions)


def _columns(file: Path, line: int, heads: Sequence[tuple[str, int]]) -> dict[str, tuple[int, str]]:
    """Index and unit of each column that is read, by quantity or gas."""
    columns: dict[str, tuple[int, str]] = {}
    for index, (head, column) in enumerate(heads):
        name, unit_name = column_of(head, _NAMES, _UNITS)
        plain = re.split(r"[\[(]", head)[0].strip()
        if name is None:
            if difflib.get_close_matches(folded(plain), [*_NAMES], n=1, cutoff=_SLIP) and len(plain) > 4:
                raise InputError(
                    f"found the column '{plain}'; {nearest(plain, UNITS)}", file=file, line=line, column=column
                )
            continue
        if name in columns:
            raise InputError(
                f"found the column '{plain}' twice, as {name}; allowed: once; remove one",
                file=file,
                line=line,
                column=column,
            )
        unit = unit_of(unit_name, _UNITS[name])
        if unit is None:
            raise InputError(
                f"found {f'the unit {unit_name!r}' if unit_name else 'no unit'} of {name};"
                f" {nearest(unit_name, _UNITS[name])}; write {name}[unit]",
                file=file,
                line=line,
                column=column,
            )
        columns[name] = (index, unit)
    for name, others in (("altitude", ["geopotential_height"]), ("pressure", []), ("temperature", [])):
        if not any(alternative in columns for alternative in (name, *others)):
            message = f"the column '{name}' is missing; add it, with its unit: {name}[{next(iter(UNITS[name]))}]"
            raise InputError(message, file=file, line=line, column=1)
    if not any(name in columns for name in HUMIDITY):
        allowed = ", ".join(name for name in UNITS if name in HUMIDITY)
        raise InputError(f"found no humidity; allowed: one of {allowed}; add it", file=file, line=line, column=1)
    return columns


def _number(file: Path, name: str, cell: str, position: tuple[int, int]) -> float:
    if _MISSING.fullmatch(cell):
        return np.nan
    try:
        value = plain_number(cell)
    except ValueError:
        raise InputError(
            f"{name}: found '{cell[:40]}'; allowed: a finite number, or nothing; fix or remove the line",
            file=file,
            line=position[0],
            column=position[1],
        ) from None
    return np.nan if value in _CODES and name != "altitude" else value


def _moment(cell: str) -> datetime | None:
    """UTC of an ISO 8601 time; None for seconds since the launch and the like."""
    if not re.match(r"\d{4}-?\d\d-?\d\d[T ]", cell):
        return None
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        return None
    return moment.astimezone(UTC) if moment.tzinfo else moment.replace(tzinfo=UTC)
