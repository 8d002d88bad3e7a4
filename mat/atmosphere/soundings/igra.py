"""Integrated Global Radiosonde Archive, version 2: records of fixed width, one sounding after another.

References
----------
NOAA National Centers for Environmental Information: IGRA v2 sounding data, igra2-data-format.txt; Durre et al. (2018),
J. Atmos. Oceanic Technol. 35, 1753.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.soundings.readings import Readings
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.schemas.errors import InputError

_HEADER = re.compile(r"#[A-Z0-9-]{11} (\d{4}) (\d\d| \d) (\d\d| \d) (\d\d| \d) ([ \d]{4}) ([ \d]{4}) ")
# By quantity: first and last character, counted from 1, and factor to SI or, for temperatures, to kelvin.
_FIELDS = {
    "pressure": (10, 15, 1.0),
    "geopotential_height": (17, 21, 1.0),
    "temperature": (23, 27, 0.1),
    "relative_humidity": (29, 33, 1e-3),
    "dew_point_depression": (35, 39, 0.1),
}
_MISSING = (-9999, -8888)  # not measured, removed by the quality control
_NO_HOUR, _NO_TIME = 99, 9999


@dataclass(frozen=True)
class IgraSounding:
    """Records of one sounding with the number of the line of its header, counted from 1, and its nominal time."""

    file: Path
    header: int
    lines: tuple[str, ...]
    time: datetime | None

    def read(self) -> Readings:
        """Its levels.

        Raises
        ------
        InputError
            With file:line:column of what is no number.
        """
        numbers: dict[str, list[float]] = {name: [] for name in _FIELDS}
        positions: dict[tuple[int, str], tuple[int, int]] = {}
        for row, text in enumerate(self.lines):
            for name, (start, stop, _) in _FIELDS.items():
                cell = text[start - 1 : stop]
                positions[row, name] = (self.header + 1 + row, start)
                if not re.fullmatch(r" *-?\d+", cell):
                    raise InputError(
                        f"{name}: found '{cell.strip()[:40]}'; allowed: a whole number in characters {start} to {stop};"
                        " take the file as it was downloaded",
                        file=self.file,
                        line=positions[row, name][0],
                        column=start,
                    )
                numbers[name].append(np.nan if int(cell) in _MISSING else int(cell))
        raw = {name: np.array(column, float) for name, column in numbers.items()}
        values = {name: raw[name] * factor for name, (_, _, factor) in _FIELDS.items()}
        values["temperature"] += ZERO_CELSIUS
        values["dew_point"] = values["temperature"] - values.pop("dew_point_depression")
        raw["dew_point"] = raw.pop("dew_point_depression")
        positions |= {(row, "dew_point"): positions[row, "dew_point_depression"] for row in range(len(self.lines))}
        return Readings(self.file, values, "any", self.time, raw, positions)


def igra_soundings(text: str, file: Path) -> list[IgraSounding]:
    """The soundings of a text; none where it does not begin as such a file does.

    Raises
    ------
    InputError
        At the header of a sounding whose levels are not those that it counts.
    """
    lines = text.rstrip().splitlines()
    if not lines or not _HEADER.match(lines[0]):
        return []
    soundings, at = [], 0
    while at < len(lines):
        head = _HEADER.match(lines[at])
        count = int(head[6]) if head is not None and head[6].strip() else -1
        levels = tuple(lines[at + 1 : at + 1 + count])
        if head is None or count < 0 or len(levels) < count or any(line.startswith("#") for line in levels):
            raise InputError(
                "found no header of a sounding with as many levels as it counts; allowed: records of IGRA v2 as they"
                " were downloaded; repair or remove these lines",
                file=file,
                line=at + 1,
                column=1,
            )
        soundings.append(IgraSounding(file, at + 1, levels, _moment(head)))
        at += 1 + count
    return soundings


def _moment(head: re.Match[str]) -> datetime | None:
    """The nominal hour, or the time of the release where there is none."""
    year, month, day, hour, released = (
        int(head[number]) if head[number].strip() else _NO_TIME for number in range(1, 6)
    )
    minute = 0
    if hour >= _NO_HOUR and released != _NO_TIME:
        hour, minute = divmod(released, 100)
    try:
        return datetime(year, month, day, hour, minute, tzinfo=UTC)
    except ValueError:
        return None
