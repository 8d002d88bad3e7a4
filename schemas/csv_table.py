"""CSV files with commented headers: tables of users, where each value knows its place, and data files of the package.

Lines that begin with ``#`` are comments, empty lines are skipped, and the first other line names the columns, with
units in brackets where they have any: ``altitude[km]``. Cells are separated by tabs, semicolons or commas, whichever of
them that line has first in this order, else by blanks; a comma between others is decimal.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath
from skyshine.schemas.plain_numbers import plain_number
from skyshine.schemas.regular_files import refuse_special_file

_ZIP = b"PK\x03\x04"
ROW_LIMIT = 100_000  # rows
_PLAIN = re.compile(r"[-+0-9.eE,;\t ]*")
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")
# A cell between blanks; a unit in brackets may follow after a blank.
_WORD = re.compile(r"[^\s\[(]*(?:[^\S\n]*[\[(][^\])]*[\])]?)|\S+")


@dataclass(frozen=True, eq=False)
class CsvTable:
    """Numbers of a CSV file.

    Attributes
    ----------
    names : tuple of str
        Names of the C columns, without their units.
    units : tuple of str
        Units as written, empty for a column that names none.
    values : (N, C) array
        Finite.
    header : int
        Line of the column names.
    lines : list of (int, str)
        Number and text of the header and of each row.
    """

    file: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: npt.NDArray[np.float64]
    header: int
    lines: list[tuple[int, str]]

    def place(self, row: int, column: int) -> tuple[int, int]:
        """Line and column of a value in the file, counted from 1; row -1 is the header."""
        number, line = self.lines[row + 1]
        return number, cells(line, delimiter_of(self.lines[0][1]))[column][1]

    def error(self, row: int, column: int, message: str) -> InputError:
        """An `InputError` at the place of a value; row -1 is the header."""
        line, position = self.place(row, column)
        return InputError(message, file=self.file, line=line, column=position)


def read_text(file: StrPath) -> str:
    """Text of a file in UTF-8, in UTF-16 that begins with its mark, or else in the code page of Western Windows.

    Raises
    ------
    InputError
        It is no regular file, cannot be read or is no text.
    """
    refuse_special_file(file)
    try:
        content = Path(file).read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=file) from None
    if content[:4] == _ZIP:
        raise InputError("is a zip archive; unpack it and name the file in it", file=file)
    for encoding in ("utf-16",) if content[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252"):
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text.replace("\r\n", "\n").replace("\r", "\n")
    raise InputError("is no text; save it as UTF-8", file=file)


def data_lines(text: str) -> list[tuple[int, str]]:
    """Lines that are neither empty nor comments, with their numbers, counted from 1."""
    return [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]


def parse_table(text: str, file: StrPath, least_rows: int = 2, header: str | None = None) -> CsvTable:
    """The table in a text.

    Parameters
    ----------
    file : path
        Named in messages.
    header : str, optional
        Line of column names of a text that has none.

    Raises
    ------
    InputError
        At the file:line:column of what is not a finite number, of a column named twice or a row of another length.
    """
    file = Path(file)
    lines = ([] if header is None else [(0, header)]) + data_lines(text)
    if not least_rows < len(lines) <= ROW_LIMIT:
        raise InputError(
            f"found {max(len(lines) - 1, 0)} rows of numbers; allowed: {least_rows} to {ROW_LIMIT} below a line of"
            " column names",
            file=file,
        )
    number, line = lines[0]
    heads, delimiter = column_heads(file, number, line), delimiter_of(line)
    values = _plain_rows([line for _, line in lines[1:]], len(heads), delimiter)
    if values is None:
        values = np.array(
            [_row(file, heads, n, row_cells(file, n, line, len(heads), delimiter)) for n, line in lines[1:]]
        )
    names, units = tuple(head.name for head in heads), tuple(head.unit for head in heads)
    return CsvTable(file, names, units, values, number, lines)


def _plain_rows(lines: list[str], columns: int, delimiter: str) -> npt.NDArray[np.float64] | None:
    """Finite numbers (N, C) of lines in which nothing else is, read at once; None of others."""
    text = delimiter.join(lines)
    if delimiter == " " or not _PLAIN.fullmatch(text) or any(line.count(delimiter) != columns - 1 for line in lines):
        return None
    try:
        values = np.array(text.split(delimiter), float).reshape(-1, columns)
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


@dataclass(frozen=True)
class Head:
    """Name and unit of a column, and the place in the header line at which it begins, counted from 1."""

    name: str
    unit: str
    column: int


def column_heads(file: Path, number: int, line: str) -> list[Head]:
    """Columns of a header such as ``time,altitude[km]`` in a line of a file.

    Raises
    ------
    InputError
        A column is named twice.
    """
    heads: list[Head] = []
    for cell, column in cells(line, delimiter_of(line)):
        name, _, unit = cell.partition("[")
        head = Head(name.strip(), unit.rstrip("] ").strip(), column)
        if head.name in [earlier.name for earlier in heads]:
            raise InputError(
                f"found the column '{head.name}' twice; allowed: once; remove one",
                file=file,
                line=number,
                column=column,
            )
        heads.append(head)
    return heads


def delimiter_of(line: str) -> str:
    """What separates the cells of a header: a tab, a semicolon, a comma, or else blanks."""
    return next((delimiter for delimiter in "\t;," if delimiter in line), " ")


def row_cells(file: Path, number: int, line: str, columns: int, delimiter: str = ",") -> list[tuple[str, int]]:
    """Cells of a line of a file with the column each begins at.

    Raises
    ------
    InputError
        The line has another number of cells than the header has columns.
    """
    parts = cells(line, delimiter)
    if delimiter != ",":
        parts = [(cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell, at) for cell, at in parts]
    if len(parts) != columns:
        raise InputError(
            f"found {len(parts)} cells; allowed: {columns}, one for each column", file=file, line=number, column=1
        )
    return parts


def cells(line: str, delimiter: str = ",") -> list[tuple[str, int]]:
    """Cells of a line with the column each begins at, counted from 1."""
    if delimiter == " ":
        return [(word.group(), word.start() + 1) for word in _WORD.finditer(line) if word.group().strip()]
    positions, at = [], 0
    for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=False)):
        position = line.find(cell, at) if cell else at
        positions.append((cell.strip(), position + 1))
        at = max(line.find(delimiter, position + len(cell)) + 1, position + len(cell))
    return positions


def _row(
    file: Path,
    heads: Sequence[Head],
    number: int,
    row_values: list[tuple[str, int]],
) -> list[float]:
    values = []
    for index, (cell, column) in enumerate(row_values):
        try:
            value = plain_number(cell)
        except ValueError:
            raise InputError(
                f"{heads[index].name}: found '{cell[:40]}'; allowed: a finite number; fix or remove the line",
                file=file,
                line=number,
                column=column,
            ) from None
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
