"""Derive phase functions and Legendre moments of droplets of cloud and fog and of rain drops from Mie theory.

    python -m mat.maintain.atmospheres.phase FOLDER --out atmospheres/cloud/phase.h5

FOLDER contains H2O__Segelstein.yml (Segelstein 1981: cloud and rain) and H2O__Hale.yml (Hale and Querry 1973: the fogs
of Shettle and Fenn 1979) of the refractiveindex.info database. Size distributions are those of the tables of
extinction, water.csv, rain.csv, and fog_advection.csv and fog_radiation.csv of the aerosol.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
import numpy.typing as npt

from mat.maintain.atmospheres.cloud import (
    DROPS,
    RAIN_RATES,
    VARIANCE,
    WATER_RADII,
    WAVELENGTHS,
    refractive_index,
)
from skyshine.mat.atmosphere.particles.mie import phase_of_spheres
from skyshine.mat.atmosphere.particles.moments import MOMENTS
from skyshine.mat.atmosphere.particles.rain import SLOPE_EXPONENT, SLOPE_PER_CM
from skyshine.mat.atmosphere.particles.tables import PHASE_FILETYPE, aerosol_table
from skyshine.schemas.arrays import Floats
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file

# Degree: fine in the forward peak, about the rainbows and in the glory.
_BACKWARD = (
    np.arange(12, 126, 3),
    np.arange(126, 150, 1),
    np.arange(150, 170, 2),
    np.arange(170, 176, 1),
    np.arange(176, 180.1, 0.5),
)
DROP_ANGLES = np.concatenate(
    [
        np.arange(0, 0.3, 0.05),
        np.arange(0.3, 1, 0.1),
        np.arange(1, 2, 0.2),
        np.arange(2, 6, 0.5),
        np.arange(6, 12, 1),
        *_BACKWARD,
    ]
).round(2)
DROPLET_ANGLES = np.concatenate(
    [
        np.arange(0, 0.3, 0.05),
        np.arange(0.3, 2, 0.1),
        np.arange(2, 5, 0.25),
        np.arange(5, 10, 0.5),
        np.arange(10, 12, 1),
        *_BACKWARD,
    ]
).round(2)
# Radii integrated over, um: close enough that the interference in spheres of single sizes averages out.
DROPLETS = np.geomspace(0.05, 150, 2500)
# Shettle and Fenn 1979 (AFGL-TR-79-0214), fog models 1 and 4: number r^exponent exp(-slope r), r in um.
FOGS = {"fog_advection": (3, 0.3), "fog_radiation": (6, 3.0)}
# Bits of the fractions of stored numbers: 1.2e-4 of a phase function, 1.5e-5 of moments at least.
PHASE_BITS, MOMENT_BITS = 12, 15


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), required=True, help="File to write.")
def main(folder: Path, out: Path) -> None:
    segelstein = refractive_index(folder / "H2O__Segelstein.yml")
    cloud = np.array(
        [DROPLETS ** ((1 - 3 * VARIANCE) / VARIANCE) * np.exp(-DROPLETS / (r * VARIANCE)) for r in WATER_RADII]
    )
    rain = np.array([np.exp(-SLOPE_PER_CM * rate**SLOPE_EXPONENT * 2 * DROPS * 1e-4) for rate in RAIN_RATES])
    groups = {
        "water": tabulated(
            Axis(np.array(WATER_RADII, float), "um", "effective radius"), DROPLETS, cloud, WAVELENGTHS, segelstein
        ),
        "rain": tabulated(
            Axis(np.array(RAIN_RATES, float), "mm/h", "rain rate"),
            DROPS,
            rain,
            WAVELENGTHS,
            segelstein,
            angles=DROP_ANGLES,
            averaged=True,
        ),
    }
    for name, (exponent, slope) in FOGS.items():
        wavelengths = np.unique(aerosol_table(name)["wavelength[um]"])
        hale = refractive_index(folder / "H2O__Hale.yml", wavelengths)
        number = DROPLETS**exponent * np.exp(-slope * DROPLETS)
        groups[name] = tabulated(
            Axis(np.array([0.0]), "percent", "humidity"), DROPLETS, number[None], wavelengths, hale
        )
    about = {
        "source": "Mie theory; refractive index of water by Segelstein 1981 (fogs: Hale and Querry 1973), from the"
        " refractiveindex.info database (CC0)",
        "program": "mat.maintain.atmospheres.phase",
    }
    header = Header(PHASE_FILETYPE, "1", "", "Phase functions of droplets and drops of water")
    write_file(out, Group(groups=groups, attributes=about), header)


def tabulated(
    node: Axis,
    radii: Floats,
    number: Floats,
    wavelengths: Floats,
    index: npt.NDArray[np.complex128],
    *,
    angles: Floats = DROPLET_ANGLES,
    averaged: bool = False,
    progress: Callable[[str], None] = click.echo,
) -> Group:
    """Phase functions at angles (A,) [degree], and moments, of size distributions (E, K) at radii (K,) and wavelengths
    (W,) [um].
    """
    phase = np.empty((len(number), wavelengths.size, angles.size))
    moments = np.empty((len(number), wavelengths.size, MOMENTS))
    for column, (wavelength, refractive) in enumerate(zip(wavelengths, index, strict=True)):
        progress(f"{node.long_name} {wavelength:g} um")
        _, phase[:, column], moments[:, column] = phase_of_spheres(
            radii, number, refractive, wavelength, np.radians(angles), MOMENTS, averaged=averaged
        )
    axes = {
        "node": node,
        "wavelength": Axis(wavelengths, "um", "wavelength"),
        "angle": Axis(angles, "degree", "scattering angle"),
        "order": Axis(np.arange(MOMENTS), "1", "order of the Legendre polynomial"),
    }
    variables = {
        "phase": Variable(("node", "wavelength", "angle"), shortened(phase, PHASE_BITS), "1", "phase function, mean 1"),
        "moments": Variable(
            ("node", "wavelength", "order"), shortened(moments, MOMENT_BITS), "1", "Legendre moments, the first 1"
        ),
    }
    return Group(axes, variables)


def shortened(values: Floats, bits: int) -> Floats:
    """Numbers rounded to so many binary digits, which pack tighter."""
    fraction, exponent = np.frexp(values)
    rounded: Floats = np.ldexp(np.round(fraction * 2**bits) / 2**bits, exponent)
    return rounded


if __name__ == "__main__":
    main()
