"""Derive the continua of water vapour, nitrogen and oxygen from the LOWTRAN7 source.

    python -m mat.maintain.atmospheres.lowtran_continua lowtran7.f --out atmospheres/continuum

The tables are in BLOCK DATA SF296, SF260, BFH2O (water vapour), C4D (nitrogen) and BO2C (oxygen) of Kneizys et al.
1988, AFGL-TR-88-0177. `skyshine.mat.spectroscopy.lowtran_continua` says how they are used.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from mat.maintain.atmospheres.fortran import block_data
from skyshine.mat.spectroscopy.continua import REFERENCE_PRESSURE, REFERENCE_TEMPERATURE
from skyshine.mat.spectroscopy.linebyline import ATMOSPHERE, CM2_TO_M2
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import write_csv

COLD_TEMPERATURE = 260.0  # K, the second temperature of the self continuum
UNIT = 1e-20 * CM2_TO_M2  # of the tables of water vapour, m2/molecule per cm^-1
FIRST_WAVENUMBER, STEP = -20.0, 10.0  # cm^-1, of the tables of water vapour
LOSCHMIDT = 2.6868e19  # molecules cm^-3 at 1 atm and 273.15 K, as LOWTRAN7 uses it
CM_PER_KM = 1e5
NITROGEN_WAVENUMBERS = np.arange(2080.0, 2741.0, 5.0)  # cm^-1 (SUBROUTINE C4DTA)
OXYGEN_FRACTION = 0.20946  # of dry air, by which SUBROUTINE O2CONT divides
PROVENANCE = (
    "LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177), a work of the US Government. Derived by",
    "mat.maintain.atmospheres.lowtran_continua.",
)


@click.command(help=__doc__)
@click.argument("source", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder to write to.")
def main(source: Path, out: Path) -> None:
    header: tuple[str, ...] = (
        "Water vapour continuum of LOWTRAN7, 296 K and 1013 hPa, without the radiation term; the self continuum goes",
        "with (296 K / T)^exponent, which is exact at 296 and 260 K.",
        *PROVENANCE,
    )
    per = "[m2/molecule per cm-1]"
    columns: tuple[str, ...] = ("wavenumber[cm-1]", f"self_continuum{per}", f"foreign_continuum{per}", "self_exponent")
    write_csv(out / "lowtran7.csv", header, columns, np.transpose(water_vapour(source)))
    header = ("Collision-induced band of N2 at 4.3 um of LOWTRAN7, in air of 1013.25 hPa and 273.15 K.", *PROVENANCE)
    write_csv(
        out / "lowtran7_n2.csv",
        header,
        ("wavenumber[cm-1]", "cross_section[m2/molecule]"),
        np.transpose(nitrogen(source)),
    )
    header = (
        "Collision-induced band of O2 at 6.4 um of LOWTRAN7, in air of 1013.25 hPa and 220 K; with temperature it goes",
        "with exp(linear (T - 220 K) + quadratic (T - 220 K)^2).",
        *PROVENANCE,
    )
    columns = ("wavenumber[cm-1]", "cross_section[m2/molecule]", "linear[K-1]", "quadratic[K-2]")
    write_csv(out / "lowtran7_o2.csv", header, columns, np.transpose(oxygen(source)))


def water_vapour(source: Path) -> tuple[Floats, Floats, Floats, Floats]:
    """Water vapour continuum, 0 to 20,000 cm^-1.

    Returns
    -------
    wavenumber : (K,) array, cm^-1
    self_continuum, foreign_continuum : (K,) arrays
        m2/molecule per cm^-1 at 296 K and 1013 hPa, without the radiation term.
    self_exponent : (K,) array
        Of 296 K / T, from the tables at 296 and 260 K.
    """
    at_296, at_260, foreign = (_joined(source, unit) for unit in ("SF296", "SF260", "BFH2O"))
    wavenumber = np.asarray(FIRST_WAVENUMBER + STEP * np.arange(at_296.size), float)
    # LOWTRAN7 refers densities to 1013.25 hPa, the band model to 1013 hPa.
    scale = UNIT * REFERENCE_PRESSURE / ATMOSPHERE
    exponent = np.log(at_260 / at_296) / np.log(REFERENCE_TEMPERATURE / COLD_TEMPERATURE)
    coefficients = (
        wavenumber,
        scale * at_296 * window_correction(wavenumber),
        scale * (foreign + far_wings(wavenumber)),
        exponent,
    )
    positive = wavenumber >= 0
    wavenumber, self_296, foreign, exponent = (values[positive] for values in coefficients)
    return wavenumber, self_296, foreign, exponent


def _joined(source: Path, unit: str) -> Floats:
    """One table from the arrays of 50 values that a BLOCK DATA unit is cut into, in the order of their numbers."""
    parts = {name: values for name, values in block_data(source, unit).items() if name[1:].isdigit() and len(name) == 5}
    return np.concatenate([parts[name] for name in sorted(parts)])


def window_correction(wavenumber: Floats) -> Floats:
    """Factor of the self continuum, 0.77 at 1050 cm^-1 (XH2O of SUBROUTINE TRANS, 1 September 1985)."""
    return 1 - 0.2333 * 200.0**2 / ((wavenumber - 1050.0) ** 2 + 200.0**2)


def far_wings(wavenumber: Floats) -> Floats:
    """Addition to the foreign continuum, 1e-20 cm3/molecule (SUBROUTINE FUDGE)."""
    infrared = 1.025 * 3.159e-8 * np.exp(-2.75e-4 * wavenumber)
    near_infrared = 8.97e-6 * np.exp(-1.3e-3 * wavenumber)
    return 1 / (1 / infrared + 1 / near_infrared)


def nitrogen(source: Path) -> tuple[Floats, Floats]:
    """Wavenumber (133,) cm^-1, and cross section (133,) m2 per N2 molecule in air of 1 atm and 273.15 K.

    LOWTRAN7's coefficient is for 1 km of air of that state, times the fraction of nitrogen.
    """
    tables = block_data(source, "C4D")
    coefficient = np.concatenate([tables["C401"], tables["C4115"]])
    return NITROGEN_WAVENUMBERS, coefficient / (LOSCHMIDT * CM_PER_KM) * CM2_TO_M2


def oxygen(source: Path) -> tuple[Floats, Floats, Floats, Floats]:
    """Wavenumber (74,) cm^-1, cross section (74,) m2 per O2 molecule in air of 1 atm and 220 K, and two coefficients.

    SUBROUTINE O2CONT expands the exponential of the temperature for sums along a path; the coefficients are of the
    exponential itself. Signs of the quadratic coefficient are those of the source.
    """
    tables = block_data(source, "BO2C")
    steps = np.arange(int(tables["NPTO2"][0]), dtype=float)
    wavenumber = tables["V1O2"][0] + tables["DVO2"][0] * steps
    strength = tables["O2S0"] / OXYGEN_FRACTION / LOSCHMIDT * CM2_TO_M2
    return wavenumber, strength, tables["O2A"], tables["O2B"]


if __name__ == "__main__":
    main()
