"""Heat transfer coefficients of air over a surface: forced by wind, and free."""

from __future__ import annotations

from dataclasses import dataclass

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
_PLATE_HEIGHT = 2.0  # m: chosen for vehicles and equipment on open ground
# Roughness length [m] above which a plate counts as rough: grains of 1 mm, by Nikuradse's (1933) rule of a thirtieth
# of the grain.
_ROUGH_PLATE = 3e-5
_OPEN_GROUND = 0.03  # m: roughness length of open ground, over which stations measure; WMO-No. 8, part I, chapter 5
VON_KARMAN = 0.40  # Hogstrom (1988)
WIND_HEIGHT = 10.0  # m, WMO-No. 8 standard height of wind measurement
AIR_HEIGHT = 2.0  # m, WMO-No. 8: air temperature and humidity are measured at 1.25 to 2 m
LEAST_HEIGHT = 0.1  # m, of measurements: above the roughness of open ground
# ln of momentum over heat roughness length, kB^-1: Garratt and Hicks (1973), Q. J. R. Meteorol. Soc. 99, 680-687:
# about 2 for vegetation, from canopies to bare fields.
_ROUGHNESS_RATIO = np.exp(2.0)
TREE_ROUGHNESS = 0.3  # m: roughness length of trees 3 m tall, a tenth of their height (Oke 1987)
# m/s: no outdoor air is calmer. Chosen: a fifth of the 0.5 m/s at which anemometers of WMO-No. 8 begin to turn.
_LEAST_WIND = 0.1
# Multipliers of building surfaces from glass to stucco: Walton (1983). They are given by kind of surface; the lengths
# [m] are those that the library gives to glass, sheet metal, concrete, brick and gravel.
_ROUGHNESSES = np.array([1e-5, 1e-4, 1e-3, 2e-3, 1e-2])
_MULTIPLIERS = np.array([1.00, 1.11, 1.52, 1.67, 2.17])
_ROOF_HEIGHT, _ROOF_RUN = 6.0, 5.0  # m: height, and way of the wind from the edge; chosen: a house 10 m wide
# Properties of air at 20 C: conductivity [W m^-1 K^-1], viscosity [Pa s], Prandtl number. Incropera and DeWitt (2002),
# Fundamentals of Heat and Mass Transfer, 5th ed., table A.4, between 250 and 300 K.
_CONDUCTIVITY, _VISCOSITY, _PRANDTL = 0.0257, 1.81e-5, 0.71


@dataclass(frozen=True, eq=False)
class Wind:
    """Wind as it was measured; the fields broadcast.

    Attributes
    ----------
    speed : array_like
        [m/s]
    height, air_height : array_like
        Heights at which wind, and temperature and humidity, were measured, above open ground or above the level from
        which a canopy's roughness counts [m].
    """

    speed: npt.ArrayLike
    height: npt.ArrayLike = WIND_HEIGHT
    air_height: npt.ArrayLike = AIR_HEIGHT

    def at(self, height: npt.ArrayLike) -> Floats:
        """Speed [m/s] at another height [m] over open ground, by the neutral logarithmic profile."""
        ratio = np.log(np.asarray(height, float) / _OPEN_GROUND) / np.log(np.asarray(self.height, float) / _OPEN_GROUND)
        speed: Floats = np.asarray(self.speed, float) * ratio
        return speed


def air_density(pressure: npt.ArrayLike, temperature: npt.ArrayLike) -> Floats:
    """Density of dry air [kg m^-3] at a pressure [Pa] and a temperature [K], which broadcast."""
    density: Floats = np.asarray(pressure, float) / (AIR_GAS_CONSTANT * np.asarray(temperature, float))
    return density


def forced_coefficient(
    wind: Wind, pressure: npt.ArrayLike, air_temperature: npt.ArrayLike, surface: SurfaceProperties
) -> Floats:
    """Transfer coefficient of wind over a surface, before `stability` changes that of a field.

    Parameters
    ----------
    pressure : array_like
        [Pa]
    air_temperature : array_like
        [K]

    Returns
    -------
    ndarray
        [W m^-2 K^-1], of the shape to which the arguments broadcast.

    Notes
    -----
    A field, endless ground or canopy, obeys the logarithmic law between the surface and the heights of measurement. A
    plate is shorter than that profile and has a thinner boundary layer of its own; roofs and walls have those of
    buildings. Laws given for standard pressure scale with density to the power 0.8 of turbulent plates. Wind has no
    direction: a wall takes the mean of the windward and the leeward law.

    References
    ----------
    field: Brutsaert (1982), Evaporation into the Atmosphere, section 4.2. plate: Juerges (1924) in McAdams (1954).
    roof: Clear, Gartland and Winkelmann (2003), Energy and Buildings 35, 797-811, forced part. wall: Yazdanian and
    Klems (1994), ASHRAE Transactions 100 (1), 1087-1096, rough ones by Walton's multiplier as DOE-2 does.
    """
    if surface.exposure == "field":
        return _log_law(wind, pressure, air_temperature, surface)
    if surface.exposure == "plate":
        kind = "rough" if surface.roughness_length > _ROUGH_PLATE else "smooth"
        coefficient = 5.678 * _PLATE[kind] * (wind.at(_PLATE_HEIGHT) / 0.3048) ** _PLATE_POWER
    elif surface.exposure == "roof":
        density = STANDARD_PRESSURE / (AIR_GAS_CONSTANT * 293.15)
        reynolds = density * wind.at(_ROOF_HEIGHT) * _ROOF_RUN / _VISCOSITY
        coefficient = _multiplier(surface) * 0.0296 * _CONDUCTIVITY / _ROOF_RUN * reynolds**0.8 * _PRANDTL ** (1 / 3)
    else:
        speed = wind.at(WIND_HEIGHT)
        coefficient = _multiplier(surface) * 0.5 * (3.26 * speed**0.89 + 3.55 * speed**0.617)
    scaled: Floats = coefficient * (np.asarray(pressure, float) / STANDARD_PRESSURE) ** 0.8
    return scaled


def _log_law(wind: Wind, pressure: npt.ArrayLike, air_temperature: npt.ArrayLike, surface: SurfaceProperties) -> Floats:
    capacity = air_density(pressure, air_temperature) * AIR_HEAT_CAPACITY
    momentum = momentum_logarithm(wind.height, surface.roughness_length)
    coefficient: Floats = capacity * VON_KARMAN**2 * lively(wind.speed)
    return coefficient / (momentum * heat_logarithm(wind.air_height, surface.roughness_length))


def _multiplier(surface: SurfaceProperties) -> float:
    """Walton's multiplier of a rough building surface."""
    return float(np.interp(np.log(surface.roughness_length), np.log(_ROUGHNESSES), _MULTIPLIERS))


def lively(speed: npt.ArrayLike) -> Floats:
    """Wind speed [m/s], kept smoothly above that of the stillest outdoor air."""
    speed_floor: Floats = np.hypot(np.asarray(speed, float), _LEAST_WIND)
    return speed_floor


def momentum_logarithm(height: npt.ArrayLike, roughness_length: float) -> Floats:
    """k U / u* of the neutral profile at a height [m]."""
    logarithm: Floats = np.log1p(np.asarray(height, float) / roughness_length)
    return logarithm


def heat_logarithm(height: npt.ArrayLike, roughness_length: float) -> Floats:
    """k dT / T* of the neutral profile at a height [m], from the surface's own temperature on."""
    logarithm: Floats = np.log1p(np.asarray(height, float) * _ROUGHNESS_RATIO / roughness_length)
    return logarithm


def stratified(surface: SurfaceProperties) -> bool:
    """Whether the surface is ground or a low canopy, whose warmth or cold stratifies the air over it."""
    return surface.exposure == "field" and surface.roughness_length <= TREE_ROUGHNESS


def natural_coefficients(
    cos_slope: npt.ArrayLike, pressure: npt.ArrayLike, surface: SurfaceProperties
) -> tuple[Floats, Floats]:
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

    Notes
    -----
    Cold air runs off the edges of a level plate, but not off ground, which has none: on ground that faces up the stable
    coefficient grows with the angle from none to that of a wall (linearly, chosen: as readers of the response to shade
    interpolate between level and upright faces). Ground does not hang; plates' law is taken.

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
    if stratified(surface):
        steep = 1.0 - np.arcsin(np.clip(cos_slope, 0.0, 1.0)) / (np.pi / 2)
        stable = np.where(up, scale * (1.810 / 1.382) * steep, stable)
    return np.where(up, unstable, stable), np.where(up, stable, unstable)
