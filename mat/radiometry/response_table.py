"""Sensor responses from CSV tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import CsvTable, parse_table
from skyshine.schemas.errors import nearest

# First column by its units: wavelength to um, wavenumber to cm^-1.
UNITS = {
    "wavelength": {"um": 1.0, "nm": 1e-3, "m": 1e6},
    "wavenumber": {"cm-1": 1.0, "cm^-1": 1.0, "1/cm": 1.0, "m-1": 1e-2},
}
# Between nodes of a wavenumber table the response is linear in wavenumber; a part of this ratio is linear in wavelength
# too, to (ratio - 1) / 4 of the change across it.
_RATIO = 1.01


def parse_response(text: str, file: str | Path) -> SpectralResponse:
    """A response table, normalised to peak 1.

    Parameters
    ----------
    text : str
        CSV with the columns wavelength[um] (or nm) or wavenumber[cm-1], and response (any scale), ordered either way.
    file : path
        Named in messages.

    Returns
    -------
    SpectralResponse
        Linear in the axis of the table; only the first and last row of 0 next to the band remain.

    Raises
    ------
    InputError
        With file:line:column of another column or unit, values that are not in order or not above 0, a negative
        response; and for a response that is 0 everywhere.
    """
    table = parse_table(text, file)
    value, index = _columns(table)
    kind = table.names[index]
    axis, response = _values(table, value, index)
    positive = np.flatnonzero(response > 0)
    if not positive.size:
        raise table.error(0, value, "found a response of 0 in every row; allowed: at least one above 0")
    inside = slice(max(positive[0] - 1, 0), positive[-1] + 2)
    axis, response = axis[inside], response[inside]
    if kind == "wavenumber":
        axis, response = _in_wavelength(axis, response)
    order = np.argsort(axis)
    return SpectralResponse(axis[order], response[order])


def _columns(table: CsvTable) -> tuple[int, int]:
    """Numbers of the columns of the response and of its axis."""
    for index, name in enumerate(table.names):
        if name not in (*UNITS, "response"):
            raise table.error(-1, index, f"found the column '{name}'; {nearest(name, [*UNITS, 'response'])}")
    if len(table.names) != 2 or "response" not in table.names:
        raise table.error(
            -1,
            0,
            f"found the columns {' and '.join(table.names)}; allowed: response, and one of wavelength[um],"
            " wavenumber[cm-1]",
        )
    value = table.names.index("response")
    return value, 1 - value


def _values(table: CsvTable, value: int, index: int) -> tuple[Floats, Floats]:
    """The axis (n,) [um or cm^-1] in column `index`, and the response (n,) in column `value`, both checked."""
    kind, unit = table.names[index], table.units[index]
    if unit not in UNITS[kind]:
        raise table.error(
            -1, index, f"found {f'the unit {unit!r}' if unit else 'no unit'} of {kind}; {nearest(unit, UNITS[kind])}"
        )
    axis, response = table.values[:, index] * UNITS[kind][unit], table.values[:, value]
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
    for row in np.flatnonzero(response < 0)[:1]:
        raise table.error(row, value, f"found {response[row]:g}; allowed: a response of at least 0; cut the noise off")
    return axis, response


def _in_wavelength(wavenumber: Floats, response: Floats) -> tuple[Floats, Floats]:
    """Nodes in um between which the response, linear in wavenumber, is linear in wavelength too."""
    ratio = np.maximum(wavenumber[1:] / wavenumber[:-1], wavenumber[:-1] / wavenumber[1:])
    parts = np.maximum(np.ceil(np.log(ratio) / np.log(_RATIO)), 1).astype(int)
    # Where the response does not change between two rows, no further nodes are needed.
    parts[np.diff(response) == 0] = 1
    pieces = [
        np.linspace(a, b, n, endpoint=False) for a, b, n in zip(wavenumber[:-1], wavenumber[1:], parts, strict=True)
    ]
    nodes = np.append(np.concatenate(pieces), wavenumber[-1])
    order = np.argsort(wavenumber)
    return 1e4 / nodes, np.interp(nodes, wavenumber[order], response[order])
