"""Derive the six AFGL standard profiles from the LOWTRAN7 source.

    python -m mat.maintain.atmospheres.profiles lowtran7.f --out atmospheres/profiles

The tables are in BLOCK DATA MLATMB (Kneizys et al. 1988, AFGL-TR-88-0177); they are those of Anderson et al. 1986,
AFGL-TR-86-0110. Numbers are carried over unchanged.
"""

from __future__ import annotations

from pathlib import Path

import click

from mat.maintain.atmospheres.fortran import block_data
from skyshine.mat.atmosphere.state.profiles import PROFILES
from skyshine.schemas.csv_table import write_csv

# Second digit of the arrays AMOLpg: p the profile, g the gas.
MAIN_GASES = ("H2O", "CO2", "O3", "N2O", "CO", "CH4", "O2")
# Arrays common to all six profiles.
TRACE_GASES = {"N2": "AN2", "NO": "ANO", "SO2": "SO2", "NO2": "ANO2", "NH3": "ANH3", "HNO3": "HNO3"}


@click.command(help=__doc__)
@click.argument("source", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder to write to.")
def main(source: Path, out: Path) -> None:
    data = block_data(source, "MLATMB")
    for number, name in enumerate(PROFILES, start=1):
        columns = {
            "altitude[km]": data["ALT"],
            "pressure[hPa]": data[f"P{number}"],
            "temperature[K]": data[f"T{number}"],
        }
        for gas_number, gas in enumerate(MAIN_GASES, start=1):
            columns[f"{gas}[ppmv]"] = data[f"AMOL{number}{gas_number}"]
        for gas, array in TRACE_GASES.items():
            columns[f"{gas}[ppmv]"] = data[array]
        header = (
            f"AFGL standard atmosphere: {name.replace('_', ' ')}",
            "Anderson et al. 1986, AFGL-TR-86-0110, as tabulated in LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177,",
            "BLOCK DATA MLATMB), a work of the US Government. Derived by mat.maintain.atmospheres.profiles.",
        )
        write_csv(out / f"{name}.csv", header, columns, zip(*columns.values(), strict=True))


if __name__ == "__main__":
    main()
