"""Derive the lunar reflectance tables from the LIME coefficients and the Apollo sample spectra.

    python -m skyshine.mat.maintain.atmospheres.lunar FOLDER --out atmospheres/sources

FOLDER holds lime_coefficients_20231120.nc (Toledano et al. 2024), Apollo16.txt (sample 62231, Pieters 1999) and
Breccia.txt.
"""

from __future__ import annotations

from pathlib import Path

import click
import h5py
import numpy as np

from skyshine.schemas.csv_table import write_csv

COEFFICIENTS = (
    "a0",
    "a1",
    "a2",
    "a3",
    "b1",
    "b2",
    "b3",
    "c1",
    "c2",
    "c3",
    "c4",
    "d1",
    "d2",
    "d3",
    "p1",
    "p2",
    "p3",
    "p4",
)
SOIL_FRACTION = 0.95  # the rest breccia (Kieffer and Stone 2005, section 5)


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder to write to.")
def main(folder: Path, out: Path) -> None:
    with h5py.File(folder / "lime_coefficients_20231120.nc") as file:
        table = np.column_stack([file["wavelength"][:] * 1e-3, file["coeff"][:].T])
    header = (
        "Coefficients of the disk-equivalent reflectance of the Moon, LIME version 2023-11-20 (Toledano et al. 2024,",
        (
            "doi:10.5194/acp-24-3649-2024), in the form of Kieffer and Stone 2005. Derived by"
            " skyshine.mat.maintain.atmospheres.lunar."
        ),
    )
    write_csv(out / "lunar_coefficients.csv", header, ("wavelength[um]", *COEFFICIENTS), table)
    soil = np.loadtxt(folder / "Apollo16.txt", delimiter=",", usecols=(0, 1))
    breccia = np.loadtxt(folder / "Breccia.txt", delimiter=",")
    shape = SOIL_FRACTION * soil[:, 1] + (1 - SOIL_FRACTION) * np.interp(soil[:, 0], *breccia.T)
    header = (
        (
            "Spectral shape of lunar reflectance: 95 % Apollo 16 soil 62231 (Pieters 1999), 5 % breccia (Kieffer and"
            " Stone 2005)."
        ),
        "Derived by skyshine.mat.maintain.atmospheres.lunar.",
    )
    write_csv(
        out / "lunar_shape.csv", header, ("wavelength[um]", "reflectance"), zip(soil[:, 0] * 1e-3, shape, strict=True)
    )


if __name__ == "__main__":
    main()
