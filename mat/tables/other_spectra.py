"""Spectra of other programs: MODTRAN's tape7, `.tp7`, tape7.scn and `.7sc`, and CSV.

References
----------
Berk et al. 2003, MODTRAN4 Version 3 Revision 1 User's Manual, and 2011, MODTRAN 5.2.2 User's Manual (tape7; card 4,
FLAGS: per cm^-1, um or nm). PTH_THRML contains THRML_SCT: TOTAL_RAD is the sum of PTH_THRML, SURF_EMIS, SOL_SCAT and
GRND_RFLT.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats
from skyshine.schemas.column_names import folded
from skyshine.schemas.csv_table import parse_table, read_text
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath
from skyshine.schemas.plain_numbers import plain_number

QUANTITIES = ("transmittance", "path_thermal", "path_scattered")
# By unit of radiance: factor to W m^-2 sr^-1 per cm^-1, or per um where it is by wavelength.
_RADIANCE = {
    "Wm-2sr-1(cm-1)-1": (1.0, False),
    "Wm-2sr-1/cm-1": (1.0, False),
    "Wcm-2sr-1(cm-1)-1": (1e4, False),
    "Wcm-2sr-1/cm-1": (1e4, False),
    "Wm-2sr-1um-1": (1.0, True),
    "Wcm-2sr-1um-1": (1e4, True),
    "uWcm-2sr-1nm-1": (10.0, True),
}
_AXES = {"cm-1": "wavenumber", "um": "wavelength", "nm": "wavelength"}
# Labels of one or two words; the last alternative is any other column.
_LABELS = re.compile(
    r"WAVLEN[ _](?:MCRN|NM)|TOT[ _]TRANS|PTH[ _]THRML|THRML[ _]SCT|SURF[ _]EMIS|SOL[ _]SCAT|SING[ _]SCAT|GRND[ _]RFLT"
    r"|DRCT[ _]RFLT|TOTAL[ _]RAD|REF[ _]SOL|DIR[ _]EM|TOA[ _]SUN|SOL TR|[^\s%]+"
)
_MODTRAN_COLUMNS = {
    "FREQ": "cm-1",
    "WAVLEN_MCRN": "um",
    "WAVLEN_NM": "nm",
    "TOT_TRANS": "transmittance",
    "COMBIN": "transmittance",
    "TRANS": "transmittance",
    "PTH_THRML": "path_thermal",
    "SOL_SCAT": "path_scattered",
}
_OF_AXIS = {"cm-1": "Wcm-2sr-1(cm-1)-1", "um": "Wcm-2sr-1um-1", "nm": "uWcm-2sr-1nm-1"}
_ALIGNED = 3  # characters between the ends of a number and of its heading, at most
_END = -9999.0  # marks the end of a spectrum in MODTRAN's files


@dataclass(frozen=True, eq=False)
class OtherSpectrum:
    """A spectrum of another program.

    Attributes
    ----------
    wavenumber : (N,) array
        Increasing [cm^-1].
    values : dict of str to (N,) array
        Some of `QUANTITIES`: transmittance; radiance [W m^-2 sr^-1 (cm^-1)^-1].
    runs : int
        Spectra in the file, of which this is the first.
    """

    file: Path
    wavenumber: Floats
    values: dict[str, Floats]
    runs: int = 1


def read_other_spectrum(file: StrPath) -> OtherSpectrum:
    """The first spectrum of a file of MODTRAN, or the table of a CSV file.

    Parameters
    ----------
    file : path
        tape7, `.tp7`, tape7.scn or `.7sc` of MODTRAN 4 and 5; or CSV of ``wavenumber[cm^-1]`` or ``wavelength[um]``,
        ``transmittance``, and ``path_thermal`` and ``path_scattered`` with a unit of radiance.

    Raises
    ------
    InputError
        With file:line:column: no such column, an unknown unit, no number, a transmittance outside 0 to 1, or
        wavenumbers that neither rise nor fall.
    """
    path, text = Path(file), read_text(file)
    headings = [
        (number, line) for number, line in enumerate(text.splitlines()) if re.match(r"[%#]? *(FREQ|WAVLEN)\b", line)
    ]
    return _of_modtran(path, text.splitlines(), headings) if headings else _of_csv(path, text)


def _of_modtran(file: Path, lines: list[str], headings: list[tuple[int, str]]) -> OtherSpectrum:
    start, heading = headings[0]
    columns: dict[str, int] = {}  # by name: where its numbers end
    for match in _LABELS.finditer(heading):
        name = _MODTRAN_COLUMNS.get(match[0].replace(" ", "_"))
        if name is not None:
            columns.setdefault(name, match.end())
    axis = next((name for name in columns if name in _AXES), None)
    if axis is None or "transmittance" not in columns:
        raise InputError(
            "found no columns FREQ or WAVLEN and TOT_TRANS, COMBIN or TRANS; allowed: tape7 of a line of sight",
            file=file,
            line=start + 1,
        )
    rows: list[dict[str, float]] = []
    numbers: list[int] = []
    for number, line in enumerate(lines[start + 1 :], start + 2):
        row = _row(file, number, line, columns)
        if axis not in row:
            continue  # units of a second heading, blanks
        if row[axis] == _END:
            break
        rows.append(row)
        numbers.append(number)
    values = {name: np.array([row.get(name, np.nan) for row in rows]) for name in columns}
    for name, column in values.items():
        if name not in QUANTITIES or np.all(np.isfinite(column)) or not np.any(np.isfinite(column)):
            continue
        row_of_gap = int(np.flatnonzero(~np.isfinite(column))[0])
        raise InputError(f"has no {name} in this row; allowed: one in every row", file=file, line=numbers[row_of_gap])
    values = {name: column for name, column in values.items() if column.size and np.all(np.isfinite(column))}
    units = dict.fromkeys(QUANTITIES[1:], _OF_AXIS[axis])
    return _checked(file, axis, values, units, len(headings), lambda row, name: (numbers[row], None))


def _row(file: Path, number: int, line: str, columns: dict[str, int]) -> dict[str, float]:
    """Numbers of a line by the column whose heading ends where they do."""
    row: dict[str, float] = {}
    for match in re.finditer(r"\S+", line):
        name = min(columns, key=lambda name: abs(columns[name] - match.end()))
        if abs(columns[name] - match.end()) > _ALIGNED or name in row:
            continue
        try:
            row[name] = plain_number(match[0])
        except ValueError:
            if not row:
                return {}  # no row of numbers
            raise InputError(
                f"found '{match[0][:20]}' as {name}; allowed: a number",
                file=file,
                line=number,
                column=match.start() + 1,
            ) from None
    return row


def _of_csv(file: Path, text: str) -> OtherSpectrum:
    table = parse_table(text, file)
    values: dict[str, Floats] = {}
    units: dict[str, str] = {}
    places: dict[str, int] = {}
    for column, (head, unit) in enumerate(zip(table.names, table.units, strict=True)):
        name, plain = folded(head), re.sub(r"[\s^*]", "", unit)
        if name in QUANTITIES:
            values[name], units[name], places[name] = table.values[:, column], plain, column
        elif name in ("wavenumber", "wavelength") and _AXES.get(plain) == name:
            values[plain], places[plain] = table.values[:, column], column
        elif name in ("wavenumber", "wavelength"):
            raise table.error(
                -1, column, f"found the unit '{unit}' of {head}; allowed: cm^-1, um, nm; write {name}[um]"
            )
    axis = next((name for name in _AXES if name in values), None)
    if axis is None or len(values) < 2:
        raise InputError(
            f"found the columns {', '.join(table.names)}; allowed: wavenumber[cm^-1] or wavelength[um] and some of"
            f" {', '.join(QUANTITIES)}; or a tape7 of MODTRAN",
            file=file,
            line=table.header,
        )
    for name in QUANTITIES[1:]:
        if name in values and units[name] not in _RADIANCE:
            raise table.error(
                -1,
                places[name],
                f"found the unit '{table.units[places[name]]}' of {name}; allowed: W m^-2 sr^-1 (cm^-1)^-1,"
                " W cm^-2 sr^-1 (cm^-1)^-1, W m^-2 sr^-1 um^-1, W cm^-2 sr^-1 um^-1, uW cm^-2 sr^-1 nm^-1",
            )
    return _checked(file, axis, values, units, 1, lambda row, name: table.place(row, places[name]))


def _checked(
    file: Path,
    axis: str,
    values: Mapping[str, Floats],
    units: Mapping[str, str],
    runs: int,
    place: Callable[[int, str], tuple[int, int | None]],
) -> OtherSpectrum:
    """The spectrum by rising wavenumber, in our units."""

    def refuse(wrong: npt.NDArray[np.bool_], name: str, allowed: str) -> None:
        for row in np.flatnonzero(wrong)[:1]:
            line, column = place(int(row), name)
            message = f"found {values[name][row]:g} as {name}; allowed: {allowed}"
            raise InputError(message, file=file, line=line, column=column)

    if values[axis].size < 2 if axis in values else True:
        raise InputError("found less than 2 rows of numbers below the headings; allowed: 2 or more", file=file)
    refuse(values[axis] <= 0, axis, "above 0")
    steps = np.diff(values[axis])
    refuse(np.append(False, np.sign(steps) != np.sign(steps[0])), axis, "rows that rise or fall throughout")
    wavenumber = {"cm-1": values[axis], "um": 1e4 / values[axis], "nm": 1e7 / values[axis]}[axis]
    order = np.argsort(wavenumber)
    converted = {}
    for name in (name for name in QUANTITIES if name in values):
        if name == "transmittance":
            refuse((values[name] < 0) | (values[name] > 1 + 1e-6), name, "0 to 1")
            converted[name] = values[name][order]
        else:
            refuse(values[name] < 0, name, "at least 0")
            factor, by_wavelength = _RADIANCE[units[name]]
            per_wavenumber = 1e4 / wavenumber**2 if by_wavelength else 1.0  # um cm
            converted[name] = (values[name] * factor * per_wavenumber)[order]
    return OtherSpectrum(file, wavenumber[order], converted, runs)
