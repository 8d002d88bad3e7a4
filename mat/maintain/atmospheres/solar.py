"""Derive the solar irradiance table from TSIS-1 HSRS and ASTM E490.

    python -m mat.maintain.atmospheres.solar tsis1_hsrs_p1nm.nc e490_00a.dat --out atmospheres/sources

TSIS-1 hybrid solar reference spectrum, version 2 (Coddington et al. 2021, 2023), from 0.202 to 2.73 um; ASTM E490-00a,
as the package pyspectral carries it, outside. Each value is the mean over its bin of wavenumber, so that the table
conserves energy.
"""

from __future__ import annotations

from pathlib import Path

import click
import h5py
import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import write_csv

# Bins [cm^-1]: 5 where the band model works (0.3 um and longer), wider in the ultraviolet, to the ends of E490.
EDGES = np.concatenate([np.arange(10, 33500, 5), np.arange(33500, 49500, 50), np.arange(49500, 83501, 500)]).astype(
    float
)
E490_SAMPLES = 400_000  # log-spaced wavelengths from 0.12 to 1000 um: ten in the narrowest bin


@click.command(help=__doc__)
@click.argument("tsis", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("e490", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder to write to.")
def main(tsis: Path, e490: Path, out: Path) -> None:
    wavelength, irradiance = join(*read_tsis(tsis), *np.loadtxt(e490, comments="#", unpack=True))
    mean = bin_means(wavelength, irradiance, EDGES)
    header = (
        (
            "Solar spectral irradiance at 1 au, mean over the bin that begins at the wavenumber of the row and ends at"
            " the next."
        ),
        (
            "0.202 to 2.73 um: TSIS-1 HSRS version 2 (Coddington et al. 2021, doi:10.1029/2020GL091709); outside: ASTM"
            " E490-00a."
        ),
        "Derived by mat.maintain.atmospheres.solar.",
    )
    rows = zip(EDGES, (f"{value:.6e}" for value in np.append(mean, 0.0)), strict=True)
    write_csv(out / "solar.csv", header, ("wavenumber[cm-1]", "irradiance[W m-2 (cm-1)-1]"), rows)
    click.echo(f"total {np.sum(mean * np.diff(EDGES)):.3f} W m-2")


def read_tsis(path: Path) -> tuple[Floats, Floats]:
    """Wavelength [um] and irradiance [W m^-2 um^-1] of the netCDF file of the HSRS."""
    with h5py.File(path) as file:
        return file["Vacuum Wavelength"][:] * 1e-3, file["SSI"][:] * 1e3


def join(
    wavelength: Floats, irradiance: Floats, e490_wavelength: Floats, e490_irradiance: Floats
) -> tuple[Floats, Floats]:
    """One spectrum: E490 (log-log interpolated between its nodes) outside the range of the first."""
    dense = np.geomspace(e490_wavelength[0], e490_wavelength[-1], E490_SAMPLES)
    values = np.exp(np.interp(np.log(dense), np.log(e490_wavelength), np.log(e490_irradiance)))
    below, above = dense < wavelength[0], dense > wavelength[-1]
    return (
        np.concatenate([dense[below], wavelength, dense[above]]),
        np.concatenate([values[below], irradiance, values[above]]),
    )


def bin_means(wavelength: Floats, irradiance: Floats, edges: Floats) -> Floats:
    """Mean irradiance per cm^-1 over bins of wavenumber.

    The running integral over wavelength, exact for a piecewise linear spectrum, is taken at the edges.
    """
    steps = 0.5 * (irradiance[1:] + irradiance[:-1]) * np.diff(wavelength)
    running = np.concatenate([[0.0], np.cumsum(steps)])
    position = 1e4 / edges
    index = np.clip(np.searchsorted(wavelength, position) - 1, 0, len(wavelength) - 2)
    offset = position - wavelength[index]
    slope = (irradiance[index + 1] - irradiance[index]) / (wavelength[index + 1] - wavelength[index])
    integral = running[index] + offset * (irradiance[index] + 0.5 * slope * offset)
    return np.asarray(-np.diff(integral) / np.diff(edges))


if __name__ == "__main__":
    main()
