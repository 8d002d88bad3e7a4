"""Lists of the University of Wyoming: text in columns of fixed width, one sounding after another.

References
----------
University of Wyoming, Department of Atmospheric Science: Description of sounding columns
(weather.uwyo.edu/upperair/columns.html).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.soundings.readings import Readings
from skyshine.mat.atmosphere.soundings.units import NAMES, UNITS, to_si
from skyshine.schemas.column_names import unit_of
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.plain_numbers import plain_number

_HEADER = re.compile(r"\s*PRES\s+HGHT\s+TEMP\b")
_TITLE = re.compile(r"Observations at\s+(\d{1,2})Z\s+(\d{1,2}\s+[A-Z][a-z]{2}\s+\d{4})")
_TAG = re.compile(r"<[^<>]*>")


@dataclass(frozen=True)
class WyomingList:
    """Lines of one sounding with the number of the first, counted from 1, and its time; the header is the first."""

    file: Path
    line_number: int
    lines: tuple[str, ...]
    time: datetime | None

    def read(self) -> Readings:
        """Its levels.

        Raises
        ------
        InputError
            With file:line:column of a unit that is unknown or of what is no number.
        """
        columns = _columns(self)
        numbers: dict[str, list[float]] = {name: [] for name in columns}
        positions: dict[tuple[int, str], tuple[int, int]] = {}
        count = 0
        for line, text in enumerate(self.lines[2:], self.line_number + 2):
            if not text.strip() or not text.strip("-= "):
                continue
            if re.match(r"\s*[A-Za-z]", text) or _TITLE.search(text):
                break
            for name, (begin, end, _) in columns.items():
                cell = text[begin:end]
                positions[count, name] = (line, begin + len(cell) - len(cell.lstrip()) + 1)
                if _cut(text, begin) or _cut(text, end):
                    raise InputError(
                        f"{name}: found '{text.strip()[:40]}', whose columns are not aligned with their names; allowed:"
                        " the list as it was downloaded, in columns of fixed width",
                        file=self.file,
                        line=line,
                        column=begin + 1,
                    )
                numbers[name].append(_number(self.file, name, cell, positions[count, name]))
            count += 1
        raw = {name: np.array(column, float) for name, column in numbers.items()}
        values = {}
        for name, (_, _, unit) in columns.items():
            factor, offset = to_si(name, unit)
            values[name] = raw[name] * factor + offset
        return Readings(self.file, values, "any", self.time, raw, positions)


def wyoming_lists(text: str, file: Path) -> list[WyomingList]:
    """The soundings of a text, as it is or inside a page; none where it is no such list."""
    lines = [_TAG.sub("", line) for line in text.splitlines()]
    heads = [n for n, line in enumerate(lines) if _HEADER.match(line)]
    sounding_lists = []
    for n, after in pairwise([*heads, len(lines)]):
        before = "\n".join(lines[max(n - 8, 0) : n])
        titles = _TITLE.findall(before)
        end = next((m for m in range(n + 1, after) if re.match(r"\s*Station information", lines[m])), after)
        sounding_lists.append(WyomingList(file, n + 1, tuple(lines[n:end]), _moment(titles[-1]) if titles else None))
    return sounding_lists


def _columns(sounding: WyomingList) -> dict[str, tuple[int, int, str]]:
    """Begin and end in the line, and unit, of each column that is read, by quantity."""
    names = [(match[0], match.end()) for match in re.finditer(r"\S+", sounding.lines[0])]
    units = sounding.lines[1].split() if len(sounding.lines) > 1 else []
    if len(units) != len(names):
        raise InputError(
            f"found {len(units)} units below {len(names)} names of columns; allowed: one for each",
            file=sounding.file,
            line=sounding.line_number + 1,
            column=1,
        )
    columns: dict[str, tuple[int, int, str]] = {}
    for index, ((heading, end), unit) in enumerate(zip(names, units, strict=True)):
        name = NAMES.get(heading.lower())
        if name is None or name in columns:
            continue
        factor_offset = unit_of(unit, UNITS[name])
        if factor_offset is None:
            raise InputError(
                f"found the unit '{unit}' of {heading}; {nearest(unit, UNITS[name])}",
                file=sounding.file,
                line=sounding.line_number + 1,
                column=1,
            )
        columns[name] = (names[index - 1][1] if index else 0, end, factor_offset)
    for name in ("pressure", "geopotential_height", "temperature"):
        if name not in columns:
            raise InputError(
                f"the column of {name} is missing; allowed: PRES, HGHT, TEMP and a humidity",
                file=sounding.file,
                line=sounding.line_number,
                column=1,
            )
    return columns


def _cut(text: str, at: int) -> bool:
    """Whether the edge of a column cuts through a number."""
    return 0 < at < len(text) and not text[at - 1].isspace() and text[at] not in "- \t"


def _number(file: Path, name: str, cell: str, position: tuple[int, int]) -> float:
    if not cell.strip():
        return float(np.nan)
    try:
        return plain_number(cell)
    except ValueError:
        raise InputError(
            f"{name}: found '{cell.strip()[:40]}'; allowed: a finite number, or nothing",
            file=file,
            line=position[0],
            column=position[1],
        ) from None


def _moment(title: Sequence[str]) -> datetime | None:
    try:
        return datetime.strptime(f"{title[0]} {' '.join(title[1].split())}", "%H %d %b %Y").replace(tzinfo=UTC)
    except ValueError:
        return None
