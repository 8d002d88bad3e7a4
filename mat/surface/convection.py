"""Heat transfer coefficients of air over a surface: forced by wind, and free."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.materials.records import SurfaceProperties
from skyshine.schemas.arrays import Floats

STANDARD_PRESSURE = 101325.0  # Pa, ISO 2533
# Specific heat of moist air [J kg^-1 K^-1]: FAO Irrigation and Drainage Paper 56 (Allen et al. 1998), eq. 8.
AIR_HEAT_CAPACITY = 1013.0
# Gas constant of dry air [J kg^-1 K^-1]: R / M with M = 28.9644 g/mol (ISO 2533).
AIR_GAS_CONSTANT = 287.053
# b of h = 5.678 b (V / 0.3048)^0.78 for a plate: McAdams (1954), Heat Transmission, 3rd ed., after Juerges (1924).
# Below 4.88 m/s they fit a + b V, whose constant is the free convection that is a law of its own here.
_PLATE = {"smooth": 0.50, "rough": 0.53}
_PLATE_POWER = 0.78
# Wind at a plate over that at 10 m: logarithmic profile at 2 m, chosen for objects on open ground, whose roughness
# length is 0.03 m (WMO-No. 8, part I, chapter 5).
_PLATE_WIND = np.log(2.0 / 0.03) / np.log(10.0 / 0.03)
# Roughness length [m] above which a plate counts as rough: grains of 1 mm, by Nikuradse's (1933) rule of a thirtieth
# of the grain.
_ROUGH_PLATE = 3e-5
_VON_KARMAN = 0.40  # Hogstrom (1988)
WIND_HEIGHT = 10.0  # m, WMO-No. 8 standard height of wind measurement
AIR_HEIGHT = 2.0  # m, WMO-No. 8: air temperature and humidity are measured at 1.25 to 2 m
# ln of momentum over heat roughness length, kB^-1: Garratt and Hicks (1973), Q. J. R. Meteorol. Soc. 99, 680-687:
# about 2 for vegetation, from canopies to bare fields.
_ROUGHNESS_RATIO = np.exp(2.0)


def air_density(pressure: npt.ArrayLike, temperature: npt.ArrayLike) -> Floats:
    """Density of dry air [kg m^-3] at a pressure [Pa] and a temperature [K], which broadcast."""
    density: Floats = np.asarray(pressure, float) / (AIR_GAS_CONSTANT * np.asarray(temperature, float))
    return density


def forced_coefficient(
    wind_speed: npt.ArrayLike, pressure: npt.ArrayLike, air_temperature: npt.ArrayLike, surface: SurfaceProperties
) -> Floats:
    """Transfer coefficient of wind over a surface.

    Parameters
    ----------
    wind_speed : array_like
        [m/s], at 10 m over open ground.
    pressure : array_like
        [Pa]
    air_temperature : array_like
        [K]
    surface : SurfaceProperties

    Returns
    -------
    ndarray
        [W m^-2 K^-1], of the shape to which the arguments broadcast.

    Notes
    -----
    Open ground rough on the scale of the wind profile obeys the logarithmic law between the surface and the heights at
    which wind and air temperature are measured; a plate shorter than that profile has a thinner boundary layer of its
    own. The larger coefficient holds; a canopy always has that of the logarithmic law. The plate law, given for
    standard pressure, scales with density to the power 0.8 of turbulent plates.

    References
    ----------
    Plate: Juerges (1924) in McAdams (1954). Log law: Brutsaert (1982), Evaporation into the Atmosphere, section 4.2.
    """
    wind_speed, pressure = np.asarray(wind_speed, float), np.asarray(pressure, float)
    momentum = np.log1p(WIND_HEIGHT / surface.roughness_length)
    heat = np.log1p(AIR_HEIGHT * _ROUGHNESS_RATIO / surface.roughness_length)
    capacity = air_density(pressure, air_temperature) * AIR_HEAT_CAPACITY
    log_law: Floats = capacity * _VON_KARMAN**2 * wind_speed / (momentum * heat)
    if surface.canopy:
        return log_law
    kind = "rough" if surface.roughness_length > _ROUGH_PLATE else "smooth"
    plate = 5.678 * _PLATE[kind] * (_PLATE_WIND * wind_speed / 0.3048) ** _PLATE_POWER
    plate = plate * (pressure / STANDARD_PRESSURE) ** 0.8
    coefficient: Floats = np.maximum(log_law, plate)
    return coefficient


def natural_coefficients(cos_slope: npt.ArrayLike, pressure: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Factors c of free convection, whose transfer coefficient is c |dT|^(1/3).

    Parameters
    ----------
    cos_slope : array_like
        1 face up, 0 a wall, -1 face down.
    pressure : array_like
        [Pa]

    Returns
    -------
    warmer, colder : ndarray
        For a surface warmer and one colder than the air [W m^-2 K^-4/3]. A face that looks down exchanges the two.

    References
    ----------
    Walton (1983), Thermal Analysis Research Program reference manual, NBSIR 83-2655: 9.482 |dT|^(1/3) /
    (7.238 - |cos|) unstable and 1.810 |dT|^(1/3) / (1.382 + |cos|) stable, for standard pressure; by
    Rayleigh's number a coefficient that does not depend on length goes with density to the power 2/3.
    """
    cos_slope = np.asarray(cos_slope, float)
    scale = (np.asarray(pressure, float) / STANDARD_PRESSURE) ** (2 / 3)
    unstable = scale * 9.482 / (7.238 - np.abs(cos_slope))
    stable = scale * 1.810 / (1.382 + np.abs(cos_slope))
    up = cos_slope >= 0
    return np.where(up, unstable, stable), np.where(up, stable, unstable)
