"""Standard atmospheric profiles.

The six profiles of Anderson et al. 1986 (AFGL-TR-86-0110) at 50 levels from 0 to 120 km. Mixing ratios are as
tabulated: carbon dioxide is 330 ppmv, the value of that report; jobs and commands scale it to the present
(`gas_amounts`). Halocarbons, which the report does not tabulate with the profiles, have the amounts of 2020.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache

import numpy as np

from skyshine import atmospheres
from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_csv
from skyshine.schemas.errors import InputError

PROFILES = (
    "tropical",
    "midlatitude_summer",
    "midlatitude_winter",
    "subarctic_summer",
    "subarctic_winter",
    "us_standard",
)

GASES = (
    "H2O",
    "CO2",
    "O3",
    "N2O",
    "CO",
    "CH4",
    "O2",
    "N2",
    "NO",
    "SO2",
    "NO2",
    "NH3",
    "HNO3",
    "CFC-11",
    "CFC-12",
    "HCFC-22",
    "CCl4",
)

# Mole fractions in the troposphere in 2020 (WMO, Scientific Assessment of Ozone Depletion 2022, chapter 1: NOAA and
# AGAGE means), and whose decrease above the tropopause each follows: CCl4 is destroyed as CFC-11 is, in the middle
# stratosphere; HCFC-22 lives there at least as long as CFC-12.
HALOCARBONS = {
    "CFC-11": (224e-12, "CFC-11"),
    "CFC-12": (500e-12, "CFC-12"),
    "HCFC-22": (247e-12, "CFC-12"),
    "CCl4": (77e-12, "CFC-11"),
}
# Above the tropopause the mole fraction goes with a power of pressure, which depends on latitude (Kiehl et al. 1998, J.
# Climate 11, 1131: CCM3; its description NCAR/TN-420, 1996): power at the equator and its slope per degree up to 45
# degrees, power there and its slope beyond.
HALOCARBON_POWERS = {"CFC-11": (0.7273, 0.00606, 1.0, 0.013333), "CFC-12": (0.4, 0.00222, 0.5, 0.024444)}
LATITUDES = {  # degree; those that Anderson et al. 1986 give for their profiles
    "tropical": 15.0,
    "midlatitude_summer": 45.0,
    "midlatitude_winter": 45.0,
    "subarctic_summer": 60.0,
    "subarctic_winter": 60.0,
    "us_standard": 45.0,
}


@dataclass(frozen=True)
class Profile:
    """Pressure, temperature and composition against altitude.

    Attributes
    ----------
    altitude : (N,) array
        Geometric altitude above sea level, m, increasing.
    pressure : (N,) array
        Pa.
    temperature : (N,) array
        K.
    mole_fraction : dict of (N,) arrays
        Gas formula to mole fraction.
    """

    name: str
    altitude: Floats
    pressure: Floats
    temperature: Floats
    mole_fraction: dict[str, Floats]

    @property
    def number_density(self) -> Floats:
        """Molecules of air, m^-3, shape (N,), by the ideal gas law."""
        return self.pressure / (BOLTZMANN * self.temperature)


def load_profile(name: str) -> Profile:
    """Load a standard profile.

    Parameters
    ----------
    name : str
        One of `PROFILES`.

    Returns
    -------
    Profile
        Gases H2O, CO2, O3, N2O, CO, CH4, O2, N2, the minor NO, SO2, NO2, NH3, HNO3 and the halocarbons.

    Raises
    ------
    InputError
        For any other name; the message contains the nearest one.
    """
    if name not in PROFILES:
        nearest = get_close_matches(str(name), PROFILES, n=1, cutoff=0.0)[0]
        raise InputError(f"no standard atmosphere '{name}'; did you mean '{nearest}'? Allowed: {', '.join(PROFILES)}")
    packaged = _packaged(name)
    return replace(packaged, mole_fraction=dict(packaged.mole_fraction))


@cache
def _packaged(name: str) -> Profile:
    """A standard profile, whose arrays cannot be written: thousands of states share them."""
    table = read_csv(atmospheres.path(f"profiles/{name}.csv"))
    gases = {
        column.removesuffix("[ppmv]"): values * 1e-6 for column, values in table.items() if column.endswith("[ppmv]")
    }
    pressure = table["pressure[hPa]"] * 1e2
    gases |= halocarbons(pressure, LATITUDES[name])
    profile = Profile(
        name=name,
        altitude=table["altitude[km]"] * 1e3,
        pressure=pressure,
        temperature=table["temperature[K]"],
        mole_fraction=gases,
    )
    for array in (profile.altitude, profile.pressure, profile.temperature, *gases.values()):
        array.setflags(write=False)
    return profile


def halocarbons(pressure: Floats, latitude: float) -> dict[str, Floats]:
    """Mole fractions of the halocarbons of 2020: even below the tropopause, falling with a power of pressure above.

    Parameters
    ----------
    pressure : (N,) array, Pa
    latitude : float, degree

    Returns
    -------
    dict of (N,) arrays

    References
    ----------
    Kiehl et al. 1998, J. Climate 11, 1131 (tropopause and powers); WMO 2022 (amounts).
    """
    latitude = abs(latitude)
    tropopause = 250e2 - 150e2 * np.cos(np.radians(latitude)) ** 2  # Pa
    above = np.minimum(np.asarray(pressure, float) / tropopause, 1.0)
    result = {}
    for gas, (amount, like) in HALOCARBONS.items():
        equator, slope, middle, beyond = HALOCARBON_POWERS[like]
        power = equator + slope * latitude if latitude <= 45 else middle + beyond * (latitude - 45)
        result[gas] = amount * above**power
    return result
