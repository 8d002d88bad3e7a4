"""A user's aerosol: extinction, single-scattering albedo and asymmetry by wavelength, from CSV."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel
from skyshine.schemas.csv_table import parse_table
from skyshine.schemas.errors import nearest

COLUMNS = {"wavelength": "um", "extinction": "", "single_scattering_albedo": "", "asymmetry": ""}
# The heat balance asks for all light from 0.3 um on; beyond 30 um little is left of what a warm body emits.
COVERED = (0.299, 30.0)


def parse_aerosol(text: str, file: str | Path) -> HenyeyGreensteinModel:
    """An aerosol from a table.

    Parameters
    ----------
    text : str
        CSV with the columns wavelength[um], extinction (any measure: only its spectrum counts),
        single_scattering_albedo and asymmetry; wavelengths rise from 0.299 um or less to 30 um or more.
    file : path
        Named in messages.

    Returns
    -------
    HenyeyGreensteinModel

    Raises
    ------
    InputError
        With file:line:column of another column or unit, a value outside its range, wavelengths that do not rise or do
        not cover the spectrum.
    """
    table = parse_table(text, file)
    for index, (name, unit) in enumerate(zip(table.names, table.units, strict=True)):
        if name not in COLUMNS:
            raise table.error(-1, index, f"found the column '{name}'; {nearest(name, COLUMNS)}")
        if name == "wavelength" and unit != "um":
            raise table.error(
                -1, index, f"found {f'the unit {unit!r}' if unit else 'no unit'} of wavelength; allowed: um"
            )
    if sorted(table.names) != sorted(COLUMNS):
        raise table.error(
            -1, 0, f"found the columns {', '.join(table.names)}; allowed: {', '.join(COLUMNS)}, each once"
        )
    place = {name: table.names.index(name) for name in COLUMNS}
    wavelength, extinction, albedo, asymmetry = (table.values[:, index] for index in place.values())
    for row in np.flatnonzero(np.diff(wavelength) <= 0)[:1]:
        found = f"{wavelength[row + 1]:g} after {wavelength[row]:g}"
        raise table.error(
            row + 1, place["wavelength"], f"found {found}; allowed: a wavelength that rises; sort the rows"
        )
    first, last = wavelength[0], wavelength[-1]
    if not 0 < first <= COVERED[0] or last < COVERED[1]:
        raise table.error(
            0 if not 0 < first <= COVERED[0] else wavelength.size - 1,
            place["wavelength"],
            f"found wavelengths from {first:g} to {last:g} um; allowed: from {COVERED[0]:g} um or less, above 0, to"
            f" {COVERED[1]:g} um or more; add rows",
        )
    for name, fits, words in (
        ("extinction", extinction > 0, "above 0, in any measure"),
        ("single_scattering_albedo", (albedo >= 0) & (albedo <= 1), "0 to 1"),
        ("asymmetry", np.abs(asymmetry) < 1, "between -1 and 1"),
    ):
        for row in np.flatnonzero(~fits)[:1]:
            raise table.error(row, place[name], f"found {table.values[row, place[name]]:g}; allowed: {words}")
    absorption = extinction * (1 - albedo)
    return HenyeyGreensteinModel.of_table(Path(file).name, wavelength, extinction, absorption, asymmetry)[0]
