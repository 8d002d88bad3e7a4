"""The nonlinear heat balance of a surface: absorption, emission, and exchange of heat and water with the air.

Sign: every function here counts heat that leaves the surface outwards as positive. Arrays are (columns, times) or
broadcast to that.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.convection import AIR_HEAT_CAPACITY, air_density, forced_coefficient, natural_coefficients
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.vapour import surface_vapour, surface_vapour_slopes
from skyshine.materials.records import SurfaceProperties
from skyshine.schemas.arrays import Floats, Integers, Reals
from skyshine.schemas.errors import InputError

MELTING_POINT = ZERO_CELSIUS  # K, of ice at any pressure of the air
# Psychrometer constant over pressure [1/K]: FAO Irrigation and Drainage Paper 56 (Allen et al. 1998), eq. 8.
PSYCHROMETER_RATIO = 0.665e-3
# Least transfer coefficient where there is air [W m^-2 K^-1]: no outdoor air is still, and the periodic problem is
# well posed with it.
LEAST_CONVECTION = 2.0
# Width [K] over which the sign of the temperature difference turns, so that convection is smooth at zero.
_TURNOVER = 0.1
_LEAST_TEMPERATURE = 1.0  # K, of air


@dataclass(frozen=True, eq=False)
class Forcing:
    """Radiation and air at the surface of each column and time; every field is (columns, N) or broadcasts to it.

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

    shortwave_direct: Floats
    shortwave_diffuse: Floats
    shortwave_reflected: Floats
    longwave_sky: Floats
    longwave_ground: Floats
    air_temperature: Floats
    vapour_pressure: Floats
    pressure: Floats
    wind_speed: Floats
    cos_slope: Floats

    @property
    def shape(self) -> tuple[int, int]:
        """(columns, N)."""
        columns, steps = np.broadcast_shapes(*(np.shape(getattr(self, field.name)) for field in fields(self)))
        return columns, steps

    @classmethod
    def stacked(cls, parts: Sequence[Forcing]) -> Forcing:
        """The columns of several forcings of the same times, one after the other."""
        shapes = [part.shape for part in parts]
        whole = (
            np.concatenate(
                [np.broadcast_to(getattr(part, field.name), shape) for part, shape in zip(parts, shapes, strict=True)]
            )
            for field in fields(cls)
        )
        return cls(*whole)

    def columns(self, chosen: slice | Integers) -> Forcing:
        """The forcing of a slice or index array of columns."""
        return Forcing(*(_rows(getattr(self, field.name), chosen) for field in fields(self)))

    def times(self, chosen: Integers) -> Forcing:
        """The forcing at an index array of times."""
        steps = self.shape[1]
        parts = (np.atleast_2d(getattr(self, field.name)) for field in fields(self))
        return Forcing(*(part[:, chosen] if part.shape[1] == steps else part for part in parts))

    def check(self) -> None:
        """Refuse values that no balance can have.

        Raises
        ------
        InputError
            A value is not a number, or negative where only positive makes sense; it names field, column and time.
        """
        for field in fields(self):
            values = np.asarray(getattr(self, field.name), float)
            limit = {"air_temperature": _LEAST_TEMPERATURE, "cos_slope": -1.0}.get(field.name, 0.0)
            if values.min() >= limit and values.max() < np.inf:  # false where one is not a number
                continue
            wrong = ~(np.isfinite(values) & (values >= limit))
            place = np.argwhere(np.broadcast_to(wrong, self.shape))[0]
            value = np.broadcast_to(values, self.shape)[tuple(place)]
            raise InputError(
                f"found {field.name} = {value:g} in column {place[0]} at time step {place[1]}; "
                f"allowed: finite numbers of at least {limit:g}; check the weather or sky that it comes from"
            )


def _rows(values: npt.ArrayLike, chosen: slice | Integers) -> Floats:
    """Rows of an array, or the array itself where all columns share one row."""
    values = np.asarray(values, float)
    if values.ndim < 2 or values.shape[0] == 1:
        return values
    rows: Floats = values[chosen]
    return rows


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

    def __init__(self, forcing: Forcing, material: SurfaceMaterial) -> None:
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
    def shortwave(self) -> Floats:
        """Absorbed from Sun, sky and ground [W m^-2]."""
        forcing = self.forcing
        received = forcing.shortwave_direct + forcing.shortwave_diffuse + forcing.shortwave_reflected
        return self.material.solar_absorptance * received

    @property
    def longwave(self) -> Floats:
        """Absorbed from sky and ground [W m^-2]."""
        return self.material.thermal_emissivity * (self.forcing.longwave_sky + self.forcing.longwave_ground)

    def columns(self, chosen: slice | Integers) -> Balance:
        """The balance of a slice or index array of columns."""
        return Balance(self.forcing.columns(chosen), self.material)

    def single(self) -> Balance:
        """The same in single precision."""
        balance = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                setattr(balance, name, value.astype(np.float32))
        return balance

    def _set_air(self, surface: SurfaceProperties) -> None:
        forcing = self.forcing
        if np.any(np.asarray(forcing.pressure) <= 0):
            raise InputError("found pressure 0 in some columns only; allowed: air in all of them or vacuum in all")
        forced = forced_coefficient(forcing.wind_speed, forcing.pressure, forcing.air_temperature, surface)
        warmer, colder = natural_coefficients(forcing.cos_slope, forcing.pressure)
        self.even, self.odd = 0.5 * (warmer**3 + colder**3), 0.5 * (warmer**3 - colder**3)
        self.forced_cube = LEAST_CONVECTION**3 + forced * forced * forced

    def _set_water(self, surface: SurfaceProperties) -> None:
        forcing = self.forcing
        heat_capacity = air_density(forcing.pressure, forcing.air_temperature) * AIR_HEAT_CAPACITY
        self.resistance = surface.surface_resistance / heat_capacity
        self.psychrometer = PSYCHROMETER_RATIO * forcing.pressure
        self.surface_path = self.psychrometer * self.resistance
        self.vapour_pressure = forcing.vapour_pressure

    def loss(self, temperature: Reals) -> Reals:
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

    def loss_and_slope(self, temperature: Reals) -> tuple[Reals, Reals]:
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

    def _coefficient(self, difference: Reals) -> Reals:
        """Convective transfer coefficient h [W m^-2 K^-1] at temperature differences to the air [K]."""
        cube = difference * difference
        cube += _TURNOVER**2
        np.sqrt(cube, out=cube)
        cube *= self.even
        cube += self.odd * difference
        cube += self.forced_cube
        return np.cbrt(cube, out=cube)

    def _latent(self, temperature: Reals, coefficient: Reals) -> Reals:
        """Latent heat flux [W m^-2], given the convective transfer coefficient."""
        vapour, latent_heat = surface_vapour(temperature)
        vapour -= self.vapour_pressure
        latent_heat *= self.wetness
        vapour *= latent_heat
        transfer = self.psychrometer / coefficient
        transfer += self.surface_path
        vapour /= transfer
        return vapour

    def _latent_slope(self, temperature: Reals, coefficient: Reals, bend: Reals) -> Reals:
        """Derivative of `_latent` by temperature, `bend` being that of the coefficient."""
        vapour, latent_heat = surface_vapour(temperature)
        vapour_slope, heat_slope = surface_vapour_slopes(temperature, vapour)
        deficit = vapour - self.vapour_pressure
        transfer = 1 / (1 / coefficient + self.resistance)
        transfer_slope = transfer**2 * bend / coefficient**2
        rise = transfer * (latent_heat * vapour_slope + heat_slope * deficit) + transfer_slope * latent_heat * deficit
        return self.wetness * rise / self.psychrometer

    def fluxes(self, temperature: Reals) -> dict[str, Reals]:
        """Each flux by name [W m^-2], (columns, N): absorbed ones positive inwards, the others positive outwards."""
        zero = np.zeros(self.shape)
        parts: dict[str, Reals] = {
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
