"""Aerosols that wind raises: the desert's, and the Navy maritime one, in which sea spray joins particles of the
continent.

References
----------
Longtin et al. 1988, AFGL-TR-88-0112 (desert). Gathman 1983, Opt. Eng. 22, 57 (Navy maritime).
LOWTRAN7, SUBROUTINES DESATT and MARINE (Kneizys et al. 1988, AFGL-TR-88-0177).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from skyshine.mat.atmosphere.particles import tables
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel, interpolate_humidity, log_humidity_weights
from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel, linear_weights
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

DEFAULT_WIND = 10.0  # m/s, which LOWTRAN7 takes for the desert where none is given (SUBROUTINE DESATT)
AIR_MASSES = (1, 10)  # open ocean to strong continental influence
DEFAULT_AIR_MASS = 3  # air mass character of the Navy Maritime model: 1 is open ocean, 10 coastal
STRONGEST_WIND = 20.0  # m/s; LOWTRAN7 takes stronger wind as this
# Humidities, percent, at which the mixture is tabulated; its parts are known at 50, 85, 95 and 98.
HUMIDITY = np.append(np.arange(50.0, 95.0, 2.5), [95.0, 96.0, 97.0, 98.0])


def desert_model(wind_speed: float) -> HenyeyGreensteinModel:
    """The desert aerosol at a wind speed [m/s] at 10 m.

    Logarithms of extinction and absorption, and asymmetry, are linear in wind speed (LOWTRAN7, SUBROUTINE DESATT).

    Raises
    ------
    InputError
        For a wind speed outside the tables, 0 to 30 m/s.
    """
    return desert_with_amount(float(wind_speed))[0]


@lru_cache(maxsize=8)
def desert_with_amount(wind_speed: float) -> tuple[HenyeyGreensteinModel, float]:
    """The model, and its extinction at 0.55 um in km^-1."""
    table = tables.desert_table()
    winds = np.unique(table["wind_speed[m/s]"])
    if not winds[0] <= wind_speed <= winds[-1]:
        raise InputError(
            f"wind speed {wind_speed:g} m/s is outside {winds[0]:g} to {winds[-1]:g} m/s, which the desert aerosol"
            " covers"
        )
    weights = linear_weights(winds, np.array([wind_speed]))[:, 0]
    wavelength, extinction, absorption, asymmetry = (table[name].reshape(len(winds), -1) for name in list(table)[1:])
    extinction, absorption = (np.exp(weights @ np.log(values)) for values in (extinction, absorption))
    return HenyeyGreensteinModel.of_table("desert", wavelength[0], extinction, absorption, weights @ asymmetry)


def navy_maritime_model(wind_speed: float, air_mass: int = DEFAULT_AIR_MASS) -> AerosolModel:
    """The Navy maritime aerosol at a wind speed [m/s] and air mass (1 to 10), with asymmetry and phase functions of the
    maritime one.

    `InputError` as `navy_maritime_extinction`.
    """
    return navy_maritime_with_amount(float(wind_speed), air_mass)[0]


@lru_cache(maxsize=8)
def navy_maritime_with_amount(wind_speed: float, air_mass: int) -> tuple[AerosolModel, Floats]:
    """The model, and its extinction at 0.55 um in km^-1 at the humidities of its table."""
    wavelength, extinction, absorption = navy_maritime_extinction(wind_speed, air_mass)
    at_550 = extinction[:, np.searchsorted(wavelength, 0.55)]
    sea = AerosolModel.load("maritime")
    humid = log_humidity_weights(sea.humidity, HUMIDITY)
    model = AerosolModel(
        name="navy_maritime",
        humidity=HUMIDITY,
        wavelength=wavelength,
        extinction=extinction / at_550[:, None],
        absorption=absorption / at_550[:, None],
        asymmetry=interpolate_humidity(humid, sea.asymmetry) @ linear_weights(sea.wavelength, wavelength),
        phase_angle=sea.phase_angle,
        phase_wavelength=sea.phase_wavelength,
        phase=np.einsum("ahv,hn->anv", sea.phase, humid),
        moments=np.einsum("mhv,hn->mnv", sea.moments, humid),
    )
    return model, at_550


@lru_cache(maxsize=8)
def navy_maritime_extinction(wind_speed: float, air_mass: int) -> tuple[Floats, Floats, Floats]:
    """Optical properties at W wavelengths and the humidities `HUMIDITY` (H,).

    Parameters
    ----------
    wind_speed : float
        Wind speed at 10 m, present and mean of the last day, m s^-1.
    air_mass : int
        1 to 10.

    Returns
    -------
    wavelength : (W,) array, um
    extinction, absorption : (H, W) arrays, km^-1

    Raises
    ------
    InputError
        For a wind that is negative or not a number, or another air mass.
    """
    if not 0 <= wind_speed < np.inf:
        raise InputError(f"wind speed {wind_speed} m/s is not allowed; give a finite number of at least 0")
    low, high = AIR_MASSES
    if air_mass not in range(low, high + 1):
        raise InputError(
            f"air mass {air_mass} is not allowed; give a whole number from {low} (open ocean) to {high} (continental)"
        )
    table = tables.navy_maritime_table()
    nodes = np.unique(table["relative_humidity[percent]"])
    wind = min(wind_speed, STRONGEST_WIND)
    amounts = (2000.0 * air_mass**2, max(5.866 * (wind - 2.2), 0.5), 10 ** (0.06 * wind - 2.8))
    growth = ((2 - HUMIDITY / 100) / (6 * (1 - HUMIDITY / 100))) ** (1 / 3)

    def mixture(kind: str) -> Floats:
        """Sum over the three parts of the aerosol (H, W), km^-1."""
        total = np.zeros((HUMIDITY.size, table["wavelength[um]"].size // nodes.size))
        for part, amount in enumerate(amounts, start=1):
            logarithm = table[f"log_{kind}_{part}"].reshape(nodes.size, -1)
            total = total + amount * 10 ** np.array([np.interp(HUMIDITY, nodes, column) for column in logarithm.T]).T
        return 1e-3 * np.pi * total / growth[:, None]

    return table["wavelength[um]"].reshape(nodes.size, -1)[0], mixture("extinction"), mixture("absorption")
