"""Write line-by-line transmittances of a homogeneous path, interval by interval, as CSV.

python -m mat.maintain.atmospheres.line_by_line --lines DIR --continua DIR --out FILE
"""

from __future__ import annotations

import click

from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM
from skyshine.mat.atmosphere.state.profiles import PROFILES
from skyshine.mat.spectroscopy.continua import Continua
from skyshine.mat.spectroscopy.gases import LineLibrary
from skyshine.mat.spectroscopy.reference import horizontal_path, interval_transmittance
from skyshine.mat.spectroscopy.widths import interval_edges
from skyshine.schemas.csv_table import write_csv


@click.command()
@click.option("--lines", required=True, type=click.Path(exists=True), help="Folder of HITRAN records.")
@click.option("--continua", required=True, type=click.Path(exists=True), help="Folder of the MT_CKD files.")
@click.option("--atmosphere", default="tropical", type=click.Choice(PROFILES), show_default=True)
@click.option("--range", "range_km", default=5.0, show_default=True, help="Length of the path at the lowest level, km.")
@click.option("--wavenumber", default="700:1250", show_default=True, help="LO:HI in cm^-1.")
@click.option("--gas", "gases", multiple=True, default=("H2O", CONTINUUM, "CO2", "CH4"), show_default=True)
@click.option("--out", required=True, type=click.Path(), help="The CSV file to write.")
def main(
    lines: str, continua: str, atmosphere: str, range_km: float, wavenumber: str, gases: tuple[str, ...], out: str
) -> None:
    """Write line-by-line transmittances of 5 cm^-1 intervals by gas."""
    low, high = (float(part) for part in wavenumber.split(":"))
    path = horizontal_path(atmosphere, range_km * 1e3)
    library, coefficients = LineLibrary(lines), Continua(continua)
    rows = []
    for start, end in interval_edges(low, high):
        values = [interval_transmittance(library, coefficients, path, gas, start, end) for gas in gases]
        rows.append([start, end, *values])
    header = [
        (
            f"Transmittance of {range_km:g} km at the lowest level of the {atmosphere} atmosphere, line by line,"
            " interval means."
        ),
        f"pressure_Pa={path.pressure:.6g} temperature_K={path.temperature:.6g} length_m={path.length:.6g} "
        + " ".join(f"{gas}={path.fraction[gas]:.9g}" for gas in gases if gas != CONTINUUM),
        "Lines: HITRAN2012 (Rothman et al. 2013). Continua: MT_CKD 4.3 (Mlawer et al. 2012, 2023).",
        "Written by python -m mat.maintain.atmospheres.line_by_line"
        f" --wavenumber {wavenumber} (with --lines and --continua).",
    ]
    write_csv(out, header, ["low[cm-1]", "high[cm-1]", *gases], rows)


if __name__ == "__main__":
    main()
