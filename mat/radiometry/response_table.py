"""Sensor responses from CSV tables."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.arrays import Floats
from skyshine.schemas.column_names import column_of, folded, unit_of
from skyshine.schemas.csv_table import CsvTable, parse_table
from skyshine.schemas.errors import nearest

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
# Between nodes of a wavenumber table the response is linear in wavenumber; a part of this ratio is linear in wavelength
# too, to (ratio - 1) / 4 of the change across it, and so is a quantum efficiency times wavelength.
_RATIO = 1.01


def parse_response(text: str, file: str | Path) -> SpectralResponse:
    """A response table, normalised to peak 1.

    Parameters
    ----------
    text : str
        CSV with two columns, ordered either way: wavelength (um, nm, m) or wavenumber (cm-1), its unit written as
        ``wavelength[um]``, ``wavelength (um)`` or ``wavelength_um``; and the response, of any name and scale. A column
        named as a quantum efficiency (QE, quantum_efficiency, photon_response) is multiplied by wavelength, which gives
        the response to energy. Cells stand between commas, semicolons or tabs.
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
        negative response; and for a response that is 0 everywhere.
    """
    table = parse_table(text, file)
    value, index, kind, unit = _columns(table)
    axis, response = _values(table, value, index, (kind, unit))
    positive = np.flatnonzero(response > 0)
    if not positive.size:
        raise table.error(0, value, "found a response of 0 in every row; allowed: at least one above 0")
    inside = slice(max(positive[0] - 1, 0), positive[-1] + 2)
    axis, response = axis[inside], response[inside]
    quantum = _counts_photons(table, value)
    if kind == "wavenumber" or quantum:
        axis, response = _finer(axis, response)
    if kind == "wavenumber":
        axis = 1e4 / axis
    if quantum:  # photons in a joule are as many as the wavelength is long
        response = response * axis
    order = np.argsort(axis)
    return SpectralResponse(axis[order], response[order])


def is_quantum(text: str, file: str | Path) -> bool:
    """Whether the response of a table counts photons, so that `parse_response` multiplies it by wavelength.

    Raises
    ------
    InputError
        As `parse_response`.
    """
    table = parse_table(text, file)
    return _counts_photons(table, _columns(table)[0])


def _counts_photons(table: CsvTable, value: int) -> bool:
    return any(_QUANTUM.search(folded(part)) for part in (table.names[value], table.units[value]))


def _columns(table: CsvTable) -> tuple[int, int, str, str]:
    """Numbers of the columns of the response and of its axis; kind of the axis and its unit."""
    heads = [f"{name}[{unit}]" if unit else name for name, unit in zip(table.names, table.units, strict=True)]
    found = [column_of(head, _NAMES, UNITS) for head in heads]
    axes = [index for index, (kind, _) in enumerate(found) if kind is not None]
    if len(table.names) != 2 or len(axes) != 1:
        raise table.error(
            -1,
            0,
            f"found the columns {' and '.join(table.names)[:80]}; allowed: response, and one of wavelength[um],"
            " wavenumber[cm-1]",
        )
    kind, written = found[axes[0]]
    assert kind is not None  # it is one of the axes
    unit = unit_of(written, UNITS[kind])
    if unit is None:
        raise table.error(
            -1,
            axes[0],
            f"found {f'the unit {written!r}' if written else 'no unit'} of {kind}; {nearest(written, UNITS[kind])}",
        )
    return 1 - axes[0], axes[0], kind, unit


def _values(table: CsvTable, value: int, index: int, written: tuple[str, str]) -> tuple[Floats, Floats]:
    """The axis (n,) [um or cm^-1] in column `index`, and the response (n,) in column `value`, both checked."""
    kind, unit = written
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
