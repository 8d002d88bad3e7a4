"""Line-by-line transmittance of a homogeneous path, interval by interval: what the band model is judged against.

``python -m skyshine.mat.spectroscopy.reference --help`` writes it as CSV; the tests hold one such file.
"""

from __future__ import annotations

from dataclasses import dataclass

import click
import numpy as np

from skyshine.mat.atmosphere.gases.absorption import CONTINUUM, water_continuum
from skyshine.mat.atmosphere.state.profiles import BOLTZMANN, PROFILES, load_profile
from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.continua import Continua
from skyshine.mat.spectroscopy.gases import GASES, LineLibrary
from skyshine.mat.spectroscopy.widths import interval_edges
from skyshine.schemas.csv_table import write_csv


@dataclass(frozen=True)
class Path:
    """A homogeneous path: pressure in Pa, temperature in K, length in m, mole fractions by gas with H2O among them."""

    pressure: float
    temperature: float
    length: float
    fraction: dict

    def column(self, gas) -> float:
        """Molecules m^-2 of a gas."""
        return self.fraction[gas] * self.pressure / (BOLTZMANN * self.temperature) * self.length


def interval_transmittance(library, continua, path, gas, low, high) -> float:
    """Mean transmittance of [low, high] cm^-1 by one gas, line by line.

    Parameters
    ----------
    library : LineLibrary
    continua : Continua
    path : Path
    gas : str
        H2O means its lines alone, H2O_continuum the continuum alone; other gases include theirs.
    """
    wavenumber = linebyline.interval_grid(low, high)
    pressure, temperature = np.array([path.pressure]), np.array([path.temperature])
    humidity = path.fraction["H2O"]
    if gas == CONTINUUM:
        coefficients = continua.water_coefficients(wavenumber)
        section = water_continuum(*coefficients, wavenumber, pressure, temperature, np.array([humidity]))[0]
        return float(np.mean(np.exp(-path.column("H2O") * section)))
    one = GASES[gas]
    own = humidity if gas == "H2O" else one.self_fraction
    lines = library.near(gas, low, high)
    section = linebyline.interval_spectrum(lines, low, high, pressure, temperature, own, one.shape)[0, 0]
    if one.continuum:
        section = section + getattr(continua, one.continuum)(wavenumber, path.pressure, path.temperature, humidity)
    return float(np.mean(np.exp(-path.column(gas) * section)))


def horizontal_path(atmosphere, length) -> Path:
    """A path at the lowest level of a standard atmosphere; length in m."""
    profile = load_profile(atmosphere)
    fraction = {gas: float(values[0]) for gas, values in profile.mole_fraction.items()}
    return Path(float(profile.pressure[0]), float(profile.temperature[0]), length, fraction)


@click.command()
@click.option("--lines", required=True, type=click.Path(exists=True), help="Folder of HITRAN records.")
@click.option("--continua", required=True, type=click.Path(exists=True), help="Folder of the MT_CKD files.")
@click.option("--atmosphere", default="tropical", type=click.Choice(PROFILES), show_default=True)
@click.option("--range", "range_km", default=5.0, show_default=True, help="Length of the path at the lowest level, km.")
@click.option("--wavenumber", default="700:1250", show_default=True, help="LO:HI in cm^-1.")
@click.option("--gas", "gases", multiple=True, default=("H2O", CONTINUUM, "CO2", "CH4"), show_default=True)
@click.option("--out", required=True, type=click.Path(), help="The CSV file to write.")
def main(lines, continua, atmosphere, range_km, wavenumber, gases, out):
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
        (
            f"Written by python -m skyshine.mat.spectroscopy.reference --wavenumber {wavenumber} (with --lines and"
            " --continua)."
        ),
    ]
    write_csv(out, header, ["low[cm-1]", "high[cm-1]", *gases], rows)


if __name__ == "__main__":
    main()
