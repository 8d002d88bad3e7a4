"""Line-by-line transmittance of a homogeneous path, interval by interval: the reference of the band model.

``python tests/validation/line_by_line_reference.py --lines DIR --continua DIR --out FILE`` writes it as CSV; the tests
contain one such file.
"""

from __future__ import annotations

from dataclasses import dataclass

import click
import numpy as np

from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, water_continuum
from skyshine.mat.atmosphere.state.profiles import PROFILES, load_profile
from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.continua import Continua, ContinuumModel
from skyshine.mat.spectroscopy.gases import GASES, LineLibrary
from skyshine.mat.spectroscopy.widths import interval_edges
from skyshine.schemas.csv_table import write_csv


@dataclass(frozen=True)
class Path:
    """A homogeneous path: pressure in Pa, temperature in K, length in m, mole fractions by gas with H2O among them."""

    pressure: float
    temperature: float
    length: float
    fraction: dict[str, float]

    def column(self, gas: str) -> float:
        """Molecules m^-2 of a gas."""
        return self.fraction[gas] * self.pressure / (BOLTZMANN * self.temperature) * self.length


def interval_transmittance(
    library: LineLibrary, continua: ContinuumModel, path: Path, gas: str, low: float, high: float
) -> float:
    """Mean transmittance of [low, high] cm^-1 by one gas, line by line.

    Parameters
    ----------
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
    self_fraction = humidity if gas == "H2O" else GASES[gas].self_fraction
    section = library.interval_spectrum(gas, low, high, pressure, temperature, self_fraction)[0, 0]
    continuum = continua.by_gas.get(gas)
    if continuum is not None:
        section = section + continuum(wavenumber, path.pressure, path.temperature, humidity)
    return float(np.mean(np.exp(-path.column(gas) * section)))


def horizontal_path(atmosphere: str, length: float) -> Path:
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
        "Written by python tests/validation/line_by_line_reference.py"
        f" --wavenumber {wavenumber} (with --lines and --continua).",
    ]
    write_csv(out, header, ["low[cm-1]", "high[cm-1]", *gases], rows)


if __name__ == "__main__":
    main()
