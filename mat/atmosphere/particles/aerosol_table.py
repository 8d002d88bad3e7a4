"""What a user measured of an aerosol, from CSV: optical properties, refractive index, extinction by height."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles.aerosol_layer import AerosolLayer
from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel
from skyshine.mat.atmosphere.particles.size_distribution import RefractiveIndex
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import CsvTable, parse_table
from skyshine.schemas.errors import nearest

COLUMNS = {"wavelength": "um", "extinction": "", "single_scattering_albedo": "", "asymmetry": ""}
INDEX_COLUMNS = {"wavelength": "um", "real": "", "imaginary": ""}
PROFILE_COLUMNS = {"height": "km", "extinction": "km^-1"}
OPTICS_COLUMNS = {
    "height": "km",
    "wavelength": "um",
    "extinction": "km^-1",
    "single_scattering_albedo": "",
    "asymmetry": "",
}
# The heat balance asks for all light from 0.3 um on; beyond 30 um little is left of what a warm body emits.
COVERED = (0.299, 30.0)
LARGEST_INDEX = 10.0
HIGHEST = 80.0  # km above the ground, of a profile
MOST_HEIGHTS = 100
MOST_OPTICS_HEIGHTS = 24  # each is a kind of particle of its own in light along lines


def parse_aerosol(text: str, file: str | Path) -> HenyeyGreensteinModel:
    """An aerosol from a table.

    Parameters
    ----------
    text : str
        CSV with the columns wavelength[um], extinction (any measure: only its spectrum counts),
        single_scattering_albedo and asymmetry; wavelengths rise from 0.299 um or less to 30 um or more.
    file : path
        Named in messages.

    Raises
    ------
    InputError
        With file:line:column of another column or unit, a value outside its range, wavelengths that do not rise or do
        not cover the spectrum.
    """
    table = parse_table(text, file)
    wavelength, extinction, albedo, asymmetry = _columns(table, COLUMNS)
    _check_wavelengths(table, wavelength)
    _check(table, "extinction", extinction > 0, "above 0, in any measure")
    _check_scattering(table, albedo, asymmetry)
    absorption = extinction * (1 - albedo)
    return HenyeyGreensteinModel.of_table(Path(file).name, wavelength, extinction, absorption, asymmetry)[0]


def parse_aerosol_optics(text: str, file: str | Path) -> list[AerosolLayer]:
    """Aerosol whose optical properties depend on height: extinction and scattered light by height and wavelength.

    Between two heights extinction, scattering, and scattering times phase function are linear in height: the particles
    of each height are a layer of their own, whose amount falls to 0 at its neighbours.

    Parameters
    ----------
    text : str
        CSV with the columns height[km] above the ground, wavelength[um], extinction[km^-1], single_scattering_albedo
        and asymmetry, sorted by height, then wavelength. Each height has wavelengths of its own, from 0.299 um or less
        to 30 um or more. A height without particles has an extinction of 0 at all of them.
    file : path
        Named in messages.

    Returns
    -------
    list of AerosolLayer
        One for each height with particles, from the ground up.

    Raises
    ------
    InputError
        As `parse_aerosol`; and for heights that fall, that are more than 24, or that have no particles.
    """
    table = parse_table(text, file)
    height, wavelength, extinction, albedo, asymmetry = _columns(table, OPTICS_COLUMNS)
    column = table.names.index("height")
    for row in np.flatnonzero(np.diff(height) < 0)[:1]:
        raise table.error(
            row + 1, column, f"found {height[row + 1]:g} after {height[row]:g}; allowed: a height that rises; sort rows"
        )
    _check(table, "height", (height >= 0) & (height <= HIGHEST), f"0 to {HIGHEST:g}")
    _check(table, "extinction", extinction >= 0, "at least 0")
    _check_scattering(table, albedo, asymmetry)
    nodes, start = np.unique(height, return_index=True)
    if not 2 <= nodes.size <= MOST_OPTICS_HEIGHTS:
        raise table.error(
            start[-1], column, f"found {nodes.size} heights; allowed: 2 to {MOST_OPTICS_HEIGHTS}; add or thin out some"
        )
    if not np.any(extinction > 0):
        raise table.error(0, table.names.index("extinction"), "found no extinction; allowed: some above 0; add it")
    layers = []
    for node, rows in enumerate(map(slice, start, [*start[1:], height.size])):
        _check_wavelengths(table, wavelength[rows], rows.start)
        empty = extinction[rows] == 0
        if np.all(empty):
            continue
        for row in np.flatnonzero(empty)[:1]:
            raise table.error(
                rows.start + row,
                table.names.index("extinction"),
                "found 0; allowed: above 0, or 0 at all wavelengths of a height without particles",
            )
        model, at_550 = HenyeyGreensteinModel.of_table(
            Path(file).name,
            wavelength[rows],
            extinction[rows],
            extinction[rows] * (1 - albedo[rows]),
            asymmetry[rows],
        )
        near = slice(max(node - 1, 0), node + 2)
        amount = np.where(np.arange(nodes.size) == node, 1e-3 * at_550, 0.0)
        layers.append(AerosolLayer.measured(model, 1e3 * nodes[near], amount[near], None))
    return layers


def parse_refractive_index(text: str, file: str | Path) -> RefractiveIndex:
    """A refractive index n + ik from CSV with the columns wavelength[um], real and imaginary; parameters and errors as
    `parse_aerosol`.
    """
    table = parse_table(text, file)
    wavelength, real, imaginary = _columns(table, INDEX_COLUMNS)
    _check_wavelengths(table, wavelength)
    _check(table, "real", (real > 0) & (real <= LARGEST_INDEX), f"above 0, up to {LARGEST_INDEX:g}")
    _check(table, "imaginary", (imaginary >= 0) & (imaginary <= LARGEST_INDEX), f"0 to {LARGEST_INDEX:g}")
    return RefractiveIndex(tuple(wavelength), tuple(real), tuple(imaginary))


def parse_extinction_profile(text: str, file: str | Path) -> tuple[Floats, Floats]:
    """Heights above the ground [m] and extinction at 0.55 um [m^-1], (K,) each, from CSV with the columns height[km]
    and extinction[km^-1]; parameters and errors as `parse_aerosol`.
    """
    table = parse_table(text, file)
    height, extinction = _columns(table, PROFILE_COLUMNS)
    _check_rising(table, "height", height)
    _check(table, "height", (height >= 0) & (height <= HIGHEST), f"0 to {HIGHEST:g}")
    _check(table, "extinction", extinction >= 0, "at least 0")
    if height.size > MOST_HEIGHTS:
        raise table.error(MOST_HEIGHTS, 0, f"found {height.size} rows; allowed: up to {MOST_HEIGHTS}; thin them out")
    if not np.any(extinction > 0):
        raise table.error(0, table.names.index("extinction"), "found no extinction; allowed: some above 0; add it")
    return 1e3 * height, 1e-3 * extinction


def _columns(table: CsvTable, columns: dict[str, str]) -> list[Floats]:
    """The columns (N,) of a table in the order of `columns`, each with its unit."""
    for index, (name, unit) in enumerate(zip(table.names, table.units, strict=True)):
        if name not in columns:
            raise table.error(-1, index, f"found the column '{name}'; {nearest(name, columns)}")
        if columns[name] and unit != columns[name]:
            raise table.error(
                -1, index, f"found {f'the unit {unit!r}' if unit else 'no unit'} of {name}; allowed: {columns[name]}"
            )
    if sorted(table.names) != sorted(columns):
        raise table.error(
            -1, 0, f"found the columns {', '.join(table.names)}; allowed: {', '.join(columns)}, each once"
        )
    return [table.values[:, table.names.index(name)] for name in columns]


def _check_scattering(table: CsvTable, albedo: Floats, asymmetry: Floats) -> None:
    _check(table, "single_scattering_albedo", (albedo >= 0) & (albedo <= 1), "0 to 1")
    _check(table, "asymmetry", np.abs(asymmetry) < 1, "between -1 and 1")


def _check_wavelengths(table: CsvTable, wavelength: Floats, start: int = 0) -> None:
    """Check wavelengths (W,) of the rows of a table from one on."""
    _check_rising(table, "wavelength", wavelength, start)
    shortest, longest = wavelength[0], wavelength[-1]
    if not 0 < shortest <= COVERED[0] or longest < COVERED[1]:
        raise table.error(
            start + (0 if not 0 < shortest <= COVERED[0] else wavelength.size - 1),
            table.names.index("wavelength"),
            f"found wavelengths from {shortest:g} to {longest:g} um; allowed: from {COVERED[0]:g} um or less, above 0,"
            f" to {COVERED[1]:g} um or more; add rows",
        )


def _check_rising(table: CsvTable, name: str, values: Floats, start: int = 0) -> None:
    for row in np.flatnonzero(np.diff(values) <= 0)[:1]:
        raise table.error(
            start + row + 1,
            table.names.index(name),
            f"found {values[row + 1]:g} after {values[row]:g}; allowed: a {name} that rises; sort the rows",
        )


def _check(table: CsvTable, name: str, fits: npt.NDArray[np.bool_], words: str) -> None:
    column = table.names.index(name)
    for row in np.flatnonzero(~fits)[:1]:
        raise table.error(row, column, f"found {table.values[row, column]:g}; allowed: {words}")
