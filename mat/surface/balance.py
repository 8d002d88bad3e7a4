"""The nonlinear heat balance of a surface: what it absorbs, emits, and gives to the air.

Sign: every function here counts heat that leaves the surface outwards as positive. Arrays are (columns, times) or
broadcast to that.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, fields

import numpy as np
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.materials.records import SurfaceProperties
from skyshine.schemas.errors import InputError

MELTING_POINT = 273.15  # K
STANDARD_PRESSURE = 101325.0  # Pa, ISO 2533
# Psychrometer constant over pressure [1/K]: FAO Irrigation and Drainage Paper 56 (Allen et al. 1998), eq. 8.
PSYCHROMETER_RATIO = 0.665e-3
# Specific heat of moist air [J kg^-1 K^-1]: Allen et al. 1998, eq. 8.
AIR_HEAT_CAPACITY = 1013.0
# Gas constant of dry air [J kg^-1 K^-1]: R / M with M = 28.9644 g/mol (ISO 2533).
AIR_GAS_CONSTANT = 287.053
# Least transfer coefficient where there is air [W m^-2 K^-1]: no outdoor air is still, and the periodic problem is
# well posed with it.
LEAST_CONVECTION = 2.0
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
# Width [K] over which the sign of the temperature difference turns, so that convection is smooth at zero.
_TURNOVER = 0.1
# Water on a surface is ice below this many degrees under the melting point and liquid above it, part of each between:
# chosen wide enough that the jump of the latent heat leaves the loss increasing with temperature at any pressure.
_FREEZING_RANGE = 2.0
# Latent heat of sublimation over that of vaporisation at 0 C: 2.834 and 2.501 MJ/kg, Rogers and Yau (1989), A Short
# Course in Cloud Physics, 3rd ed., table 2.1.
_SUBLIMATION_RATIO = 2.834 / 2.501
# Below 150 K water vapour over the surface is below 1e-5 Pa; the clip keeps Magnus' formula away from its pole.
_COLDEST_VAPOUR = 150.0


def saturation_pressure(temperature) -> np.ndarray:
    """Saturation vapour pressure over water [Pa] at temperatures [K].

    References
    ----------
    Magnus form with the constants of Sonntag (1990), Z. Meteorol. 70, 340-344; WMO-No. 8, Annex 4.B.
    """
    celsius = np.maximum(temperature, _COLDEST_VAPOUR) - ZERO_CELSIUS
    return 611.2 * np.exp(17.62 * celsius / (243.12 + celsius))


def surface_vapour(temperature) -> tuple[np.ndarray, np.ndarray]:
    """Vapour pressure of water or frost on a surface [Pa], and its latent heat over that of liquid water, one if all is
    liquid.

    References
    ----------
    Magnus forms over water and ice with the constants of Sonntag (1990); WMO-No. 8, Annex 4.B.
    """
    celsius = temperature - ZERO_CELSIUS
    coldest = celsius.min()
    if coldest < _COLDEST_VAPOUR - ZERO_CELSIUS:
        np.maximum(celsius, _COLDEST_VAPOUR - ZERO_CELSIUS, out=celsius)
    exponent = celsius + 243.12
    np.divide(17.62, exponent, out=exponent)
    latent_heat = np.ones((1,) * celsius.ndim, celsius.dtype)
    if coldest < 0:
        cold = celsius < 0
        below, water = celsius[cold], exponent[cold]
        frozen = _frozen(below)[0]
        exponent[cold] = water + frozen * (22.46 / (272.62 + below) - water)
        latent_heat = np.ones_like(celsius)
        latent_heat[cold] = 1 + (_SUBLIMATION_RATIO - 1) * frozen
    exponent *= celsius
    np.exp(exponent, out=exponent)
    exponent *= 611.2
    return exponent, latent_heat


def _frozen(celsius) -> tuple[np.ndarray, np.ndarray]:
    """Share of ice in the water on a surface and its derivative by temperature, both continuous."""
    depth = np.clip(-celsius / _FREEZING_RANGE, 0.0, 1.0)
    return depth**2 * (3 - 2 * depth), -6 * depth * (1 - depth) / _FREEZING_RANGE


def _surface_vapour_slopes(temperature, pressure) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of `surface_vapour` by temperature, given its pressure [Pa]."""
    celsius = np.maximum(temperature, _COLDEST_VAPOUR) - ZERO_CELSIUS
    frozen, freezing = _frozen(celsius)
    water, ice = 17.62 / (243.12 + celsius), 22.46 / (272.62 + celsius)
    slope = (1 - frozen) * 243.12 * water / (243.12 + celsius) + frozen * 272.62 * ice / (272.62 + celsius)
    slope = pressure * (slope + celsius * freezing * (ice - water))
    return np.where(temperature > _COLDEST_VAPOUR, slope, 0.0), (_SUBLIMATION_RATIO - 1) * freezing


def forced_coefficient(wind_speed, pressure, air_temperature, surface: SurfaceProperties) -> np.ndarray:
    """Transfer coefficient of wind over a surface [W m^-2 K^-1].

    Parameters
    ----------
    wind_speed : array_like
        [m/s], at 10 m over open ground.
    pressure : array_like
        [Pa]
    air_temperature : array_like
        [K]
    surface : SurfaceProperties

    Notes
    -----
    Open ground rough on the scale of the wind profile obeys the logarithmic law between the surface and the heights at
    which wind and air temperature are measured; a plate shorter than that profile
    has its own thinner boundary layer. The larger of the two holds; a canopy always has the logarithmic law. The
    plate law, given for standard pressure, scales with density to the power 0.8 of turbulent plates.

    References
    ----------
    Plate: Juerges (1924) in McAdams (1954). Log law: Brutsaert (1982), Evaporation into the Atmosphere, section 4.2.
    """
    wind_speed = np.asarray(wind_speed, float)
    momentum = np.log1p(WIND_HEIGHT / surface.roughness_length)
    heat = np.log1p(AIR_HEIGHT * _ROUGHNESS_RATIO / surface.roughness_length)
    density = pressure / (AIR_GAS_CONSTANT * air_temperature)
    field = density * AIR_HEAT_CAPACITY * _VON_KARMAN**2 * wind_speed / (momentum * heat)
    if surface.canopy:
        return field
    kind = "rough" if surface.roughness_length > _ROUGH_PLATE else "smooth"
    plate = 5.678 * _PLATE[kind] * (_PLATE_WIND * wind_speed / 0.3048) ** _PLATE_POWER
    plate = plate * (pressure / STANDARD_PRESSURE) ** 0.8
    return np.maximum(field, plate)


def natural_coefficients(cos_slope, pressure) -> tuple[np.ndarray, np.ndarray]:
    """Factors of |dT|^(1/3) [W m^-2 K^-4/3] of free convection from an (unstable, stable) surface.

    Parameters
    ----------
    cos_slope : array_like
        1 face up, 0 a wall, -1 face down.
    pressure : array_like
        [Pa]

    Returns
    -------
    tuple of ndarray
        For a surface warmer than the air and for one colder. A face that looks down exchanges the two.

    References
    ----------
    Walton (1983), Thermal Analysis Research Program reference manual, NBSIR 83-2655: 9.482 |dT|^(1/3) /
    (7.238 - |cos|) unstable and 1.810 |dT|^(1/3) / (1.382 + |cos|) stable, for standard pressure; Rayleigh's number
    makes a coefficient that does not depend on length go with density to the power 2/3.
    """
    cos_slope = np.asarray(cos_slope, float)
    scale = (pressure / STANDARD_PRESSURE) ** (2 / 3)
    unstable = scale * 9.482 / (7.238 - np.abs(cos_slope))
    stable = scale * 1.810 / (1.382 + np.abs(cos_slope))
    up = cos_slope >= 0
    return np.where(up, unstable, stable), np.where(up, stable, unstable)


@dataclass(frozen=True, eq=False)
class Forcing:
    """What reaches the surface of each column at each time; every field is (columns, N) or broadcasts to it.

    Attributes
    ----------
    shortwave_direct, shortwave_diffuse, shortwave_reflected : ndarray
        On the plane of the column [W m^-2].
    longwave_sky, longwave_ground : ndarray
        On the plane, view factors included [W m^-2].
    air_temperature : ndarray
        [K]
    vapour_pressure, pressure : ndarray
        [Pa]; pressure 0 is vacuum.
    wind_speed : ndarray
        At 10 m [m/s].
    cos_slope : ndarray
        1 face up, 0 a wall, -1 face down.
    """

    shortwave_direct: np.ndarray
    shortwave_diffuse: np.ndarray
    shortwave_reflected: np.ndarray
    longwave_sky: np.ndarray
    longwave_ground: np.ndarray
    air_temperature: np.ndarray
    vapour_pressure: np.ndarray
    pressure: np.ndarray
    wind_speed: np.ndarray
    cos_slope: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """(columns, N)."""
        return np.broadcast_shapes(*(np.shape(getattr(self, field.name)) for field in fields(self)))

    def columns(self, chosen) -> Forcing:
        """The forcing of a slice or index array of columns."""
        shape = self.shape
        return Forcing(*(_rows(getattr(self, field.name), shape, chosen) for field in fields(self)))

    def check(self) -> None:
        """Refuse values that no balance can have.

        Raises
        ------
        InputError
            A value is not a number, or negative where only positive makes sense; it names field, column and time.
        """
        for field in fields(self):
            values = np.asarray(getattr(self, field.name), float)
            limit = {"air_temperature": 1.0, "cos_slope": -1.0}.get(field.name, 0.0)
            if values.min() >= limit and values.max() < np.inf:  # false where one is not a number
                continue
            wrong = ~(np.isfinite(values) & (values >= limit))
            place = np.argwhere(np.broadcast_to(wrong, self.shape))[0]
            found = np.broadcast_to(values, self.shape)[tuple(place)]
            raise InputError(
                f"found {field.name} = {found:g} in column {place[0]} at time step {place[1]}; "
                f"allowed: finite numbers of at least {limit:g}; mend the weather or sky that it comes from"
            )


def _rows(values, shape, chosen) -> np.ndarray:
    """Rows of an array that broadcasts to `shape`, without spreading an axis that all columns share."""
    values = np.asarray(values, float)
    if values.ndim < 2 or values.shape[0] == 1:
        return values
    return values[chosen]


class Balance:
    """Net heat that leaves the surfaces of some columns, as a function of their temperatures.

    Parameters
    ----------
    forcing : Forcing
    material : SurfaceMaterial

    Notes
    -----
    Convection blends forced and natural transfer by the cubes of their coefficients, as Churchill (1977), AIChE J. 23,
    10-16, does for assisting flow: h^3 = h_least^3 + h_forced^3 + c^3 |dT|, the natural law being c |dT|^(1/3). The
    turn of c between the unstable and stable side is smoothed over 0.1 K, so that h has all derivatives and is never
    below 2 W m^-2 K^-1 where there is air. Evaporation is the bulk latent flux
    wetness rho cp / gamma (e_sat(T) - e) / (r_a + r_s), r_a = rho cp / h, r_s the surface resistance (Penman 1948,
    Monteith 1965); the same path carries condensation when e > e_sat(T). Below freezing e_sat is that over ice and the
    flux carries the heat of sublimation: the water is frost.
    """

    def __init__(self, forcing: Forcing, material: SurfaceMaterial):
        self.shape = forcing.shape
        self.forcing, self.material = forcing, material
        self.absorbed = self.shortwave + self.longwave
        self.emission = material.thermal_emissivity * Stefan_Boltzmann
        self.air_temperature = forcing.air_temperature
        surface = material.surface
        self.airless = not np.any(forcing.pressure)
        if not self.airless:
            self._set_air(surface)
        self.wetness = 0.0 if self.airless else surface.wetness
        if self.wetness:
            self._set_water(surface)

    @property
    def shortwave(self) -> np.ndarray:
        """Absorbed from Sun and sky [W m^-2]."""
        forcing = self.forcing
        received = forcing.shortwave_direct + forcing.shortwave_diffuse + forcing.shortwave_reflected
        return self.material.solar_absorptance * received

    @property
    def longwave(self) -> np.ndarray:
        """Absorbed from sky and ground [W m^-2]."""
        return self.material.thermal_emissivity * (self.forcing.longwave_sky + self.forcing.longwave_ground)

    def columns(self, chosen) -> Balance:
        """The balance of a slice or index array of columns."""
        return Balance(self.forcing.columns(chosen), self.material)

    def single(self) -> Balance:
        """The same in single precision."""
        light = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                setattr(light, name, value.astype(np.float32))
        return light

    def _set_air(self, surface: SurfaceProperties) -> None:
        forcing = self.forcing
        if np.any(np.asarray(forcing.pressure) <= 0):
            raise InputError("found pressure 0 in some columns only; allowed: air in all of them or vacuum in all")
        forced = forced_coefficient(forcing.wind_speed, forcing.pressure, forcing.air_temperature, surface)
        warm, cold = natural_coefficients(forcing.cos_slope, forcing.pressure)
        self.even, self.odd = 0.5 * (warm**3 + cold**3), 0.5 * (warm**3 - cold**3)
        self.steady = LEAST_CONVECTION**3 + forced * forced * forced

    def _set_water(self, surface: SurfaceProperties) -> None:
        forcing = self.forcing
        density = forcing.pressure / (AIR_GAS_CONSTANT * forcing.air_temperature)
        self.resistance = surface.surface_resistance / (density * AIR_HEAT_CAPACITY)
        self.psychrometer = PSYCHROMETER_RATIO * forcing.pressure
        self.path = self.psychrometer * self.resistance
        self.vapour_pressure = forcing.vapour_pressure

    def loss(self, temperature: np.ndarray) -> np.ndarray:
        """Net outward flux f(T) [W m^-2], shape (columns, N)."""
        net = temperature * temperature
        net *= net if temperature.min() >= 0 else temperature * np.abs(temperature)
        net *= self.emission
        net -= self.absorbed
        if self.airless:
            return net
        difference = temperature - self.air_temperature
        coefficient = self._coefficient(difference)
        if self.wetness:
            net += self._latent(temperature, coefficient)
        difference *= coefficient
        net += difference
        return net

    def loss_and_slope(self, temperature: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """f(T) and its derivative by temperature [W m^-2 K^-1], each (columns, N)."""
        loss = self.loss(temperature)
        slope = 4 * self.emission * np.abs(temperature) ** 3
        if self.airless:
            return loss, slope + np.zeros(self.shape)
        difference = temperature - self.air_temperature
        coefficient = self._coefficient(difference)
        width = np.sqrt(difference**2 + _TURNOVER**2)
        bend = (self.even * difference / width + self.odd) / (3 * coefficient**2)
        slope = slope + coefficient + bend * difference
        if self.wetness:
            slope += self._latent_slope(temperature, coefficient, bend)
        return loss, slope

    def _coefficient(self, difference: np.ndarray) -> np.ndarray:
        """Convective transfer coefficient h [W m^-2 K^-1] at temperature differences to the air [K]."""
        cube = difference * difference
        cube += _TURNOVER**2
        np.sqrt(cube, out=cube)
        cube *= self.even
        cube += self.odd * difference
        cube += self.steady
        return np.cbrt(cube, out=cube)

    def _latent(self, temperature, coefficient) -> np.ndarray:
        vapour, latent_heat = surface_vapour(temperature)
        vapour -= self.vapour_pressure
        latent_heat *= self.wetness
        vapour *= latent_heat
        transfer = self.psychrometer / coefficient
        transfer += self.path
        vapour /= transfer
        return vapour

    def _latent_slope(self, temperature, coefficient, bend) -> np.ndarray:
        vapour, latent_heat = surface_vapour(temperature)
        vapour_slope, heat_slope = _surface_vapour_slopes(temperature, vapour)
        deficit = vapour - self.vapour_pressure
        transfer = 1 / (1 / coefficient + self.resistance)
        transfer_slope = transfer**2 * bend / coefficient**2
        rise = transfer * (latent_heat * vapour_slope + heat_slope * deficit) + transfer_slope * latent_heat * deficit
        return self.wetness * rise / self.psychrometer

    def fluxes(self, temperature: np.ndarray) -> dict[str, np.ndarray]:
        """Each flux by name [W m^-2], (columns, N): absorbed ones positive inwards, the others positive outwards."""
        zero = np.zeros(self.shape)
        parts = {
            "shortwave_absorbed": self.shortwave + zero,
            "longwave_absorbed": self.longwave + zero,
            "longwave_emitted": self.emission * np.abs(temperature) * temperature**3 + zero,
            "convection": zero,
            "evaporation": zero,
        }
        if not self.airless:
            difference = temperature - self.air_temperature
            coefficient = self._coefficient(difference)
            parts["convection"] = coefficient * difference
            if self.wetness:
                parts["evaporation"] = self._latent(temperature, coefficient)
        return parts
