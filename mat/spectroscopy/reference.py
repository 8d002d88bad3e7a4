"""Line-by-line transmittance of a homogeneous path, interval by interval: the reference of the band model.

`mat.maintain.atmospheres.line_by_line` writes it as CSV; the tests contain one such file.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, water_continuum
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.continua import ContinuumModel
from skyshine.mat.spectroscopy.gases import GASES, LineLibrary


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
