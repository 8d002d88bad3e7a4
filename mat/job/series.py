"""States in series: one description of a job becomes a state for each day of a span, row of a table, or sounding."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date, timedelta
from pathlib import Path
from typing import Any, Self

import pydantic
from pydantic import Field

from skyshine.mat.job.soundings import soundings_of_folder
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.documents import StrictModel, plain_value
from skyshine.schemas.errors import InputError

MEMBER_LIMIT = 9999  # states of a job


class Series(StrictModel):
    """What differs between the states of a series: the day, the values of a table, or the sounding."""

    first: date | None = Field(None, description="First day of a span.")
    last: date | None = Field(None, description="Last day of a span.")
    step_days: int = Field(1, ge=1, le=366, description="Interval between the days of a span.")
    table: str | None = Field(
        None,
        min_length=1,
        description=(
            "CSV, relative to the job: a column for each key that differs (date, visibility_km,"
            " weather.wind_speed_m_s), a row for each state."
        ),
    )
    soundings: str | None = Field(
        None,
        min_length=1,
        description=(
            "Folder, relative to the job: a state for each sounding in its files, on the day of the sounding or of its"
            " file's name."
        ),
    )

    @property
    def days(self) -> tuple[date, date] | None:
        """First and last day of a span; None for a table or a folder."""
        return None if self.first is None or self.last is None else (self.first, self.last)

    @pydantic.model_validator(mode="after")
    def _one_kind(self) -> Self:
        days = self.days
        kinds = [kind for kind in (days, self.table, self.soundings) if kind is not None]
        if len(kinds) != 1 or (self.first is None) != (self.last is None):
            raise ValueError(
                "found none or several; allowed: 'first' and 'last', or 'table', or 'soundings'; give one of the three"
            )
        if days is not None and days[1] < days[0]:
            raise ValueError(f"found last {self.last} before first {self.first}; allowed: first to last; swap them")
        if days is not None and (days[1] - days[0]).days // self.step_days >= MEMBER_LIMIT:
            raise ValueError(
                f"found more than {MEMBER_LIMIT} days; allowed: at most that many; take a larger step_days"
            )
        return self


@dataclass(frozen=True)
class Member:
    """One state of a series.

    Attributes
    ----------
    changes : dict of str to value
        Changed values by key of the state, with dots between keys and inner keys.
    file, line : where it is written, for messages; None for a day of a span.
    """

    changes: dict[str, Any]
    file: Path | None = None
    line: int | None = None


def members(series: Series, folder: Path, utc_offset_h: float = 0.0) -> Iterator[Member]:
    """The states of a series, in order; days of soundings are those of a local clock.

    Raises
    ------
    InputError
        The table cannot be read, has a row of another length, or a cell that is no plain value.
    """
    if series.table is not None:
        file = folder / series.table
        yield from (Member(values, file, line) for values, line in rows_of_table(file))
        return
    if series.soundings is not None:
        yield from _soundings(folder, series.soundings, utc_offset_h)
        return
    if series.days is None:
        return
    day, end = series.days
    while day <= end:
        yield Member({"date": day.isoformat()})
        day += timedelta(days=series.step_days)


def _soundings(folder: Path, name: str, utc_offset_h: float) -> Iterator[Member]:
    soundings = soundings_of_folder(folder, name, utc_offset_h)
    if not 0 < len(soundings) <= MEMBER_LIMIT:
        raise InputError(f"contains {len(soundings)} soundings; allowed: 1 to {MEMBER_LIMIT}", file=folder / name)
    for changes in soundings:
        yield Member(changes)


def rows_of_table(file: Path) -> Iterator[tuple[dict[str, Any], int]]:
    """The values of each row of a CSV table by column, and its line.

    Raises
    ------
    InputError
        It cannot be read, has no rows or too many, a row of another length, or a cell that is no plain value.
    """
    lines = csv.reader(read_text(file).splitlines(), skipinitialspace=True)
    header: list[str] | None = None
    count = 0
    try:
        for cells in lines:
            if not cells or cells[0].lstrip().startswith("#"):
                continue
            cells = [cell.strip() for cell in cells]
            if header is None:
                header = _header(cells, file, lines.line_num)
                continue
            count += 1
            if len(cells) != len(header) or count > MEMBER_LIMIT:
                raise InputError(
                    f"found {len(cells)} cells in row {count}; allowed: {len(header)} cells, {MEMBER_LIMIT} rows",
                    file=file,
                    line=lines.line_num,
                )
            line = lines.line_num
            yield {key: plain_value(cell, file, line) for key, cell in zip(header, cells, strict=True)}, line
    except csv.Error as error:
        raise InputError(f"is not CSV: {error}", file=file, line=lines.line_num) from None
    if not count:
        raise InputError("has no rows; write the names of keys, then a row for each", file=file)


def _header(cells: list[str], file: Path, line: int) -> list[str]:
    for cell in cells:
        if cells.count(cell) > 1 or not all(cell.split(".")):
            raise InputError(f"found the column '{cell}'; allowed: keys of a state, each once", file=file, line=line)
    return cells


def changed(state: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A state as a job writes it, with other values for some of its keys."""
    result = {key: value for key, value in state.items() if key != "series"}
    for path, value in changes.items():
        *parents, leaf = path.split(".")
        inner = result
        for key in parents:
            branch = inner.get(key)
            inner[key] = dict(branch) if isinstance(branch, dict) else {}
            inner = inner[key]
        inner[leaf] = value
    return result
