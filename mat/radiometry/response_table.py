"""Sensor responses from tables: CSV, columns between blanks, with lines of text above them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.arrays import Floats
from skyshine.schemas.column_names import column_of, folded, unit_of
from skyshine.schemas.csv_table import CsvTable, cells, delimiter_of, parse_table
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.plain_numbers import plain_number

# The axis by its units: wavelength to um, wavenumber to cm^-1.
UNITS = {
    "wavelength": {
        "um": 1.0,
        "nm": 1e-3,
        "m": 1e6,
        **dict.fromkeys(("micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"), 1.0),
        **dict.fromkeys(("nanometer", "nanometers", "nanometre", "nanometres"), 1e-3),
    },
    "wavenumber": {"cm-1": 1.0, "cm^-1": 1.0, "1/cm": 1.0, "m-1": 1e-2},
}
_NAMES = dict.fromkeys(("wavelength", "wavelengths", "wave_length", "lambda", "wl", "wvl", "wave"), "wavelength")
_NAMES |= dict.fromkeys(("wavenumber", "wavenumbers", "wave_number", "wn", "nu"), "wavenumber")
# A column of such a name, or unit, counts photons; another is the response to energy.
_QUANTUM = re.compile(r"(^|_)[ei]?qe(_|$)|quantum|photon|electron|^e[-_]?/")
# A column of such a name is the scatter of another.
_SCATTER = re.compile(r"(^|_)(std|stdev|stddev|sd|sigma|error|err|unc|uncertainty|deviation)(_|$)|stdev")
# Likely wavelengths without a unit: from ultraviolet to far infrared light in each.
_LIKELY = {"um": (0.15, 100.0), "nm": (150.0, 1e5)}
_NOISE = 0.01  # fraction of the peak, below 0: dark noise of a monochromator; more is another quantity
_NEAR_ONE = 0.01  # by which a peak may differ from 1, or from 100 percent, without a word
_FLAT_ROWS = 2  # that a rectangle has: more of the same value may be a column of something else
# Between nodes of a wavenumber table the response is linear in wavenumber; a part of this ratio is linear in wavelength
# too, to (ratio - 1) / 4 of the change across it, and so is a quantum efficiency times wavelength.
_RATIO = 1.01


def parse_response(text: str, file: str | Path) -> SpectralResponse:
    """A response table, normalised to peak 1.

    Parameters
    ----------
    text : str
        A table with a column of wavelength (um, nm, m) or wavenumber (cm-1), its unit written as ``wavelength[um]``,
        ``wavelength (um)`` or ``wavelength_um``, or seen from its values; and the response, of any name and scale;
        other columns, of its scatter, may follow. A column named as a quantum efficiency (QE, quantum_efficiency,
        photon_response) is multiplied by wavelength, which gives the response to energy. Columns are separated by
        commas, semicolons, tabs or blanks. Lines before the numbers may say what the columns are.
    file : path
        Named in messages.

    Returns
    -------
    SpectralResponse
        Linear in the axis of the table; only the first and last row of 0 next to the band remain.

    Raises
    ------
    InputError
        With file:line:column of another number of columns or unit, values that are not in order or not above 0, a
        response far below 0; and for a response that is 0 everywhere.
    """
    return _read(text, file)[0]


def response_notes(text: str, file: str | Path) -> tuple[str, ...]:
    """What `parse_response` does with a table beyond reading it, a line each, after "the response FILE".

    Raises
    ------
    InputError
        As `parse_response`.
    """
    return _read(text, file)[1]


@lru_cache(maxsize=16)
def _read(text: str, file: str | Path) -> tuple[SpectralResponse, tuple[str, ...]]:
    table = _table(text, file)
    columns = _columns(table)
    value, kind = columns.value, columns.kind
    notes = list(columns.notes)
    axis, response = _values(table, columns, notes)
    positive = np.flatnonzero(response > 0)
    if not positive.size:
        raise table.error(0, value, "found a response of 0 in every row; allowed: at least one above 0")
    inside = slice(max(positive[0] - 1, 0), positive[-1] + 2)
    axis, response = axis[inside], response[inside]
    peak = float(response.max())
    if abs(peak - 1.0) > _NEAR_ONE and abs(peak - 100.0) > 100.0 * _NEAR_ONE:
        notes.append(f"peaks at {peak:g}; scaled to 1")
    if np.all(response == peak) and response.size > _FLAT_ROWS:
        notes.append(f"is flat over all {response.size} rows; read as a rectangle")
    quantum = any(_QUANTUM.search(folded(part)) for part in (table.names[value], table.units[value]))
    if kind == "wavenumber" or quantum:
        axis, response = _finer(axis, response)
    if kind == "wavenumber":
        axis = 1e4 / axis
    elif axis[0] > axis[-1]:
        notes.append("falls in wavelength from row to row; turned round")
    if quantum:  # photons in a joule are as many as the wavelength is long
        response = response * axis
        notes.append("counts photons; times wavelength, it is the response to energy")
    order = np.argsort(axis)
    return SpectralResponse(axis[order], response[order]), tuple(notes)


def _table(text: str, file: str | Path) -> CsvTable:
    """The table in a text, whose header may be a comment, one of several lines, or missing."""
    lines = text.splitlines()
    start = next((number for number, line in enumerate(lines) if _numbers(line)), len(lines))
    before = [number for number, line in enumerate(lines[:start]) if line.strip()]
    plain = [number for number in before if not lines[number].startswith("#")]
    if start == len(lines) or (len(plain) == 1 and plain[0] == before[-1]):
        return parse_table(text, file)
    delimiter = delimiter_of(lines[start])
    count = len(cells(lines[start], delimiter))
    names = None
    for number in reversed(before):
        words = lines[number].lstrip("#!%;* \t")
        heads = cells(words, delimiter_of(words))
        if len(heads) == count and any(column_of(head, _NAMES, UNITS)[0] for head, _ in heads):
            names = [re.sub(r"\s+", "_", head) for head, _ in heads]
            break
    if names is None:
        named = _named_axis(" ".join(lines[number] for number in before).lower())
        if named is None and max(map(abs, _numbers(lines[start]))) > _LIKELY["um"][1]:
            raise InputError(
                "names neither wavelength nor wavenumber; write a first line such as wavelength[nm],response",
                file=file,
                line=start + 1,
                column=1,
            )
        names = [named or "wavelength", "response", *(f"stdev_{number}" for number in range(2, count))]
    rows = "\n".join("" if number < start else line for number, line in enumerate(lines))
    return parse_table(rows, file, header=delimiter.join(names))


def _numbers(line: str) -> list[float]:
    """Numbers of a line that has two or more, and nothing else; else none."""
    try:
        numbers = [plain_number(word) for word in re.split(r"[;,\s]+", line) if word]
    except ValueError:
        return []
    return numbers if len(numbers) > 1 else []


def _named_axis(text: str) -> str | None:
    """Header of the axis by words of the lines above a table; None where they name none."""
    if re.search(r"wave ?number|cm\s*\^?-\s*1\b|1/cm", text):
        return "wavenumber[cm-1]"
    if re.search(r"\bnm\b|nanomet", text):
        return "wavelength[nm]"
    return "wavelength[um]" if re.search(r"\bum\b|\u00b5m|\u03bcm|micron|micromet", text) else None


@dataclass(frozen=True)
class _Columns:
    """Numbers of the columns of the response and of its axis, kind and unit of the axis, and what is said of them."""

    value: int
    axis: int
    kind: str
    unit: str
    notes: tuple[str, ...]


def _columns(table: CsvTable) -> _Columns:
    heads = [f"{name}[{unit}]" if unit else name for name, unit in zip(table.names, table.units, strict=True)]
    columns = [column_of(head, _NAMES, UNITS) for head in heads]
    axes = [index for index, (kind, _) in enumerate(columns) if kind is not None]
    values = [index for index in range(len(heads)) if index not in axes]
    scatter = [index for index in values if _SCATTER.search(folded(table.names[index]))]
    values = [index for index in values if index not in scatter]
    if len(axes) != 1 or len(values) != 1:
        raise table.error(
            -1,
            0,
            f"found the columns {' and '.join(table.names)[:80]}; allowed: response, and one of wavelength[um],"
            " wavenumber[cm-1]; remove or name others",
        )
    kind, unit_text = columns[axes[0]]
    assert kind is not None  # it is one of the axes
    notes = tuple(f"has the column {table.names[index]}, which is not read" for index in scatter)
    unit = unit_of(unit_text, UNITS[kind])
    if unit is None and not unit_text and kind == "wavelength":
        axis = table.values[:, axes[0]]
        unit = next((unit for unit, (low, high) in _LIKELY.items() if low <= axis.min() <= axis.max() <= high), None)
        notes += (f"names no unit; {axis.min():g} to {axis.max():g} is read in {unit}",)
    if unit is None:
        raise table.error(
            -1,
            axes[0],
            f"found {f'the unit {unit_text!r}' if unit_text else 'no unit'} of {kind};"
            f" {nearest(unit_text, UNITS[kind])};"
            f" write a first line such as {kind}[{next(iter(UNITS[kind]))}],response",
        )
    return _Columns(values[0], axes[0], kind, unit, notes)


def _values(table: CsvTable, columns: _Columns, notes: list[str]) -> tuple[Floats, Floats]:
    """The axis (n,) [um or cm^-1], and the response (n,), both checked; noise below 0 is 0."""
    kind, index, value = columns.kind, columns.axis, columns.value
    axis, response = table.values[:, index] * UNITS[kind][columns.unit], table.values[:, value]
    for row in np.flatnonzero(axis <= 0)[:1]:
        raise table.error(row, index, f"found {axis[row]:g}; allowed: a {kind} above 0")
    step = np.diff(axis) * (1.0 if axis[-1] > axis[0] else -1.0)
    for row in np.flatnonzero(step <= 0)[:1]:
        raise table.error(
            row + 1,
            index,
            f"found {axis[row + 1]:g} after {axis[row]:g}; allowed: a {kind} that rises, or falls, from row to row; "
            "sort the rows and merge repeated ones",
        )
    for row in np.flatnonzero(response < -_NOISE * response.max())[:1]:
        raise table.error(
            row,
            value,
            f"found {response[row]:g}; allowed: a response of at least 0, and noise to {_NOISE:g} of its peak",
        )
    below = int(np.sum(response < 0))
    if below:
        notes.append(f"has {below} values below 0, down to {response.min():g}; they are replaced by 0")
    return axis, np.maximum(response, 0.0)


def _finer(axis: Floats, response: Floats) -> tuple[Floats, Floats]:
    """Nodes between which a response that is linear in `axis` is linear in wavelength, or times wavelength, too."""
    ratio = np.maximum(axis[1:] / axis[:-1], axis[:-1] / axis[1:])
    parts = np.maximum(np.ceil(np.log(ratio) / np.log(_RATIO)), 1).astype(int)
    # Where the response does not change between two rows, no further nodes are needed.
    parts[np.diff(response) == 0] = 1
    pieces = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(axis[:-1], axis[1:], parts, strict=True)]
    nodes = np.append(np.concatenate(pieces), axis[-1])
    order = np.argsort(axis)
    return nodes, np.interp(nodes, axis[order], response[order])
