"""Derive the lunar reflectance tables from the coefficients of ROLO and LIME and the Apollo sample spectra.

    python -m mat.maintain.atmospheres.lunar FOLDER --out atmospheres/sources

FOLDER contains lime_coefficients_20231120.nc (Toledano et al. 2024), Apollo16.txt (sample 62231, Pieters 1999) and
Breccia.txt; the coefficients of ROLO are those of the packaged lunar_rolo.csv, as published.

The spectral shape of the samples is taken out of ROLO's constant term. What remains scatters by some percent from one
filter to the next; a line through its neighbours, weighted by a Gaussian in the logarithm of wavelength, gives each
coefficient at each node. The mean ratio of LIME to the result, over the phase angles that both were fitted to and where
neither has its surge, becomes part of the constant term.
"""

from __future__ import annotations

from pathlib import Path

import click
import h5py
import numpy as np

from skyshine import atmospheres
from skyshine.mat.atmosphere.sources.lunar import P1, P2, P3, P4
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_csv, write_csv

COEFFICIENTS = ("a0", "a1", "a2", "a3", "b1", "b2", "b3", "d1", "d2", "d3")
NODES = np.round(np.concatenate([np.arange(0.35, 1.0, 0.025), np.arange(1.0, 2.35, 0.05), [2.3836]]), 4)  # um
SMOOTHING = 0.08  # standard deviation in the natural logarithm of wavelength
LEVEL_PHASES = np.arange(7.0, 75.5)  # degree
SOIL_FRACTION = 0.95  # the rest breccia (Kieffer and Stone 2005, section 5)


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder to write to.")
def main(folder: Path, out: Path) -> None:
    soil = np.loadtxt(folder / "Apollo16.txt", delimiter=",", usecols=(0, 1))
    breccia = np.loadtxt(folder / "Breccia.txt", delimiter=",")
    shape = SOIL_FRACTION * soil[:, 1] + (1 - SOIL_FRACTION) * np.interp(soil[:, 0], *breccia.T)
    rolo = read_csv(atmospheres.path("sources/lunar_rolo.csv"))
    with h5py.File(folder / "lime_coefficients_20231120.nc") as file:
        lime_wavelength, lime = file["wavelength"][:] * 1e-3, file["coeff"][:].T

    def logarithm_of_shape(wavelength: Floats) -> Floats:
        return np.log(np.interp(wavelength, soil[:, 0] * 1e-3, shape))

    table = np.column_stack([rolo[name] for name in COEFFICIENTS])
    table[:, 0] -= logarithm_of_shape(rolo["wavelength[um]"])
    smooth = _smoother(rolo["wavelength[um]"], NODES) @ table
    at_lime = _smoother(rolo["wavelength[um]"], lime_wavelength) @ table
    level = [
        np.mean([_of_lime(row, g) - _of_rolo(at_wavelength, g) for g in LEVEL_PHASES])
        for row, at_wavelength in zip(lime, at_lime, strict=True)
    ] - logarithm_of_shape(lime_wavelength)
    smooth[:, 0] += np.interp(NODES, lime_wavelength, level)
    header = (
        "Coefficients of the disk-equivalent reflectance of the Moon over that of lunar_shape.csv: ROLO model 311g",
        "(Kieffer and Stone 2005, doi:10.1086/430185), smoothed, at the level of LIME version 2023-11-20 (Toledano et",
        "al. 2024, doi:10.5194/acp-24-3649-2024). Derived by mat.maintain.atmospheres.lunar.",
    )
    write_csv(
        out / "lunar_coefficients.csv",
        header,
        ("wavelength[um]", *COEFFICIENTS),
        np.column_stack([NODES, np.round(smooth, 6)]),
    )
    shape_header = (
        (
            "Spectral shape of lunar reflectance: 95 % Apollo 16 soil 62231 (Pieters 1999), 5 % breccia (Kieffer and"
            " Stone 2005)."
        ),
        "Derived by mat.maintain.atmospheres.lunar.",
    )
    write_csv(
        out / "lunar_shape.csv",
        shape_header,
        ("wavelength[um]", "reflectance"),
        zip(soil[:, 0] * 1e-3, shape, strict=True),
    )


def _smoother(wavelength: Floats, node: Floats) -> Floats:
    """Weights (K, N) that give the values at K nodes from those at N wavelengths."""
    rows = []
    for apart in np.log(wavelength) - np.log(node)[:, None]:
        weight = np.exp(-0.5 * (apart / SMOOTHING) ** 2)
        line = np.stack([np.ones_like(apart), apart])
        rows.append(np.linalg.solve((line * weight) @ line.T, line * weight)[0])
    return np.array(rows)


def _of_rolo(row: Floats, degrees: float) -> float:
    """Logarithm of the reflectance, without the Sun's longitude; coefficients (10,) as `COEFFICIENTS`."""
    polynomial = np.polynomial.polynomial.polyval(np.radians(degrees), row[:4])
    surge = row[7] * np.exp(-degrees / P1) + row[8] * np.exp(-degrees / P2)
    return float(polynomial + surge + row[9] * np.cos((degrees - P3) / P4))


def _of_lime(row: Floats, degrees: float) -> float:
    """As `_of_rolo`, from the (18,) coefficients of LIME: a0 to a3, b1 to b3, c1 to c4, d1 to d3, p1 to p4."""
    d1, d2, d3, p1, p2, p3, p4 = row[11:]
    polynomial = np.polynomial.polynomial.polyval(np.radians(degrees), row[:4])
    surge = d1 * np.exp(-degrees / p1) + d2 * np.exp(-degrees / p2)
    return float(polynomial + surge + d3 * np.cos((degrees - p3) / p4))


if __name__ == "__main__":
    main()
