"""CSV files with commented headers: tables of users, where each value knows its place, and data files of the package.

Lines that begin with ``#`` are comments, empty lines are skipped, and the first other line names the columns, with
units in brackets where they have any: ``altitude[km]``.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath

ROW_LIMIT = 100_000


@dataclass(frozen=True, eq=False)
class CsvTable:
    """Numbers of a CSV file.

    Attributes
    ----------
    file : Path
    names : tuple of str
        Of the C columns, without their units.
    units : tuple of str
        As written, empty where a column names none.
    values : (N, C) array
        Finite.
    header : int
        Line of the column names.
    places : dict
        (row, column) to (line, column) in the file, counted from 1; row -1 is the header.
    """

    file: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: npt.NDArray[np.float64]
    header: int
    places: dict[tuple[int, int], tuple[int, int]]

    def error(self, row: int, column: int, message: str) -> InputError:
        """An `InputError` at the place of a value; row -1 is the header."""
        line, place = self.places[row, column]
        return InputError(message, file=self.file, line=line, column=place)


def read_text(file: StrPath) -> str:
    """Text of a UTF-8 file.

    Raises
    ------
    InputError
        It cannot be read or is not UTF-8.
    """
    try:
        return Path(file).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=file) from None
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start}); save it as UTF-8", file=file) from None


def data_lines(text: str) -> list[tuple[int, str]]:
    """Lines that are neither empty nor comments, with their numbers, counted from 1."""
    return [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]


def named_unit(cell: str) -> tuple[str, str]:
    """Name and unit of a cell of the header, ``name[unit]``; the unit is empty where there is none."""
    name, _, unit = cell.partition("[")
    return name.strip(), unit.rstrip("] ").strip()


def parse_table(text: str, file: StrPath, least_rows: int = 2) -> CsvTable:
    """The table in a text.

    Parameters
    ----------
    text : str
    file : path
        Named in messages.
    least_rows : int

    Raises
    ------
    InputError
        At the file:line:column of what is not a finite number, of a column named twice or a row of another length.
    """
    file = Path(file)
    lines = data_lines(text)
    if not least_rows < len(lines) <= ROW_LIMIT:
        raise InputError(
            f"found {max(len(lines) - 1, 0)} rows of numbers; allowed: {least_rows} to {ROW_LIMIT} below a line of"
            " column names",
            file=file,
        )
    number, line = lines[0]
    heads: list[tuple[str, str]] = []
    places: dict[tuple[int, int], tuple[int, int]] = {}
    for index, (cell, column) in enumerate(cells(line)):
        places[-1, index] = (number, column)
        heads.append(named_unit(cell))
        if heads[-1][0] in [name for name, _ in heads[:-1]]:
            raise InputError(
                f"found the column '{heads[-1][0]}' twice; allowed: once; remove one",
                file=file,
                line=number,
                column=column,
            )
    rows = [_row(file, heads, row, *line, places) for row, line in enumerate(lines[1:])]
    names, units = zip(*heads, strict=True)
    return CsvTable(file, names, units, np.array(rows), number, places)


def cells(line: str) -> list[tuple[str, int]]:
    """Cells of a line with the column each begins at, counted from 1."""
    places, at = [], 0
    for cell in next(csv.reader([line], skipinitialspace=False)):
        place = line.find(cell, at) if cell else at
        places.append((cell.strip(), place + 1))
        at = max(line.find(",", place + len(cell)) + 1, place + len(cell))
    return places


def _row(
    file: Path,
    heads: Sequence[tuple[str, str]],
    row: int,
    number: int,
    line: str,
    places: dict[tuple[int, int], tuple[int, int]],
) -> list[float]:
    parts = cells(line)
    if len(parts) != len(heads):
        raise InputError(
            f"found {len(parts)} cells; allowed: {len(heads)}, one for each column", file=file, line=number, column=1
        )
    values = []
    for index, (cell, column) in enumerate(parts):
        places[row, index] = (number, column)
        try:
            value = float(cell)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise InputError(
                f"{heads[index][0]}: found '{cell[:40]}'; allowed: a finite number; correct or remove the line",
                file=file,
                line=number,
                column=column,
            )
        values.append(value)
    return values


def read_csv(path: StrPath) -> dict[str, npt.NDArray[Any]]:
    """Read a data file of the package, whose comments say where the numbers came from.

    Returns
    -------
    dict
        Column name, with its unit, to array; a column with text in it is an array of text.
    """
    names, *rows = csv.reader(line for _, line in data_lines(read_text(path)))
    return {name: _as_numbers(column) for name, column in zip(names, np.array(rows).T, strict=True)}


def write_csv(path: StrPath, header: Iterable[str], columns: Iterable[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write rows under commented header lines.

    Parameters
    ----------
    path : path
    header : iterable of str
        Lines of provenance; each is prefixed with ``#``.
    columns : iterable of str
        Column names, units in brackets.
    rows : iterable of sequences
        Text is written as it is, numbers with nine significant digits.
    """
    lines = [f"# {line}" for line in header]
    lines.append(",".join(columns))
    lines += [",".join(item if isinstance(item, str) else f"{float(item):.9g}" for item in row) for row in rows]
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _as_numbers(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    try:
        return column.astype(float)
    except ValueError:
        return column
