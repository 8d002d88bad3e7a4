"""The nonlinear heat balance of a surface: absorption, emission, and exchange of heat and water with the air.

Sign: every function here counts heat that leaves the surface outwards as positive. Arrays are (columns, times) or
broadcast to that.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN, ZERO_CELSIUS
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.convection import (
    AIR_HEAT_CAPACITY,
    Wind,
    air_density,
    forced_coefficient,
    natural_coefficients,
    stratified,
)
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.soil_moisture import resistance
from skyshine.mat.surface.stability import Stability
from skyshine.mat.surface.stomata import canopy_resistance
from skyshine.mat.surface.vapour import surface_vapour, surface_vapour_and_slopes
from skyshine.mat.surface.wet_skin import aged_albedo
from skyshine.materials.records import SurfaceProperties
from skyshine.schemas.arrays import Floats, Integers, Reals
from skyshine.schemas.errors import InputError

CELLS_RATED = 298.15  # K: of the standard test conditions, IEC 60904-3
MELTING_POINT = ZERO_CELSIUS  # K, of ice at any pressure of the air
# Psychrometer constant over pressure [1/K]: FAO Irrigation and Drainage Paper 56 (Allen et al. 1998), eq. 8.
PSYCHROMETER_RATIO = 0.665e-3
# Least transfer coefficient where there is air [W m^-2 K^-1]: no outdoor air is still, and the periodic problem is well
# posed with it. On ground that faces up, over which cold air lies still, half of it: over the snow of Col de Porte, a
# calm clearing (winter 2005/06, daily means, measured radiation), 0.5 errs by 0.97 K rms, 1 by 0.94 K, 2 by 1.41 K.
LEAST_CONVECTION, LEAST_OVER_GROUND = 2.0, 1.0
# Width [K] over which the sign of the temperature difference turns, so that convection is smooth at zero.
_TURNOVER = 0.1


@dataclass(frozen=True, eq=False)
class Skin:
    """What the heat balance takes of a surface: numbers, or arrays (rows, N)."""

    solar_absorptance: float | Floats
    thermal_emissivity: float | Floats
    wetness: float | Floats
    surface_resistance: float | Floats


def skin_of(material: SurfaceMaterial, forcing: Forcing) -> Skin:
    """The skin of a material under a forcing, which may tell moisture, film, age of snow, or albedo."""
    surface = material.surface
    absorptance: float | Floats = material.solar_absorptance
    emissivity: float | Floats = material.thermal_emissivity
    wetness: float | Floats = surface.wetness
    resists: float | Floats = surface.surface_resistance
    if material.moist is not None and forcing.soil_moisture is not None:
        table = material.moist
        moisture = np.minimum(forcing.soil_moisture, table.moisture[-1])
        absorptance = np.interp(moisture, table.moisture, table.solar_absorptance)
        emissivity = np.interp(moisture, table.moisture, table.thermal_emissivity)
        wetness, resists = 1.0, resistance(table.texture, moisture)
    if surface.snow and forcing.snow_age is not None:
        absorptance = 1 - aged_albedo(1 - material.solar_absorptance, forcing.snow_age, forcing.air_temperature)
    if forcing.albedo is not None:
        absorptance = 1 - forcing.albedo
    if material.film is not None and forcing.film is not None:
        film, share = material.film, forcing.film
        if forcing.albedo is None:  # a measured albedo is that of the surface as it was, wet or dry
            absorptance = absorptance + share * (film.solar_absorptance - absorptance)
        emissivity = emissivity + share * (film.thermal_emissivity - emissivity)
    return Skin(absorptance, emissivity, wetness, resists)


class Balance:
    """Net heat that leaves the surfaces of some columns, as a function of their temperatures.

    Notes
    -----
    Convection blends forced and natural transfer by the cubes of their coefficients, as Churchill (1977), AIChE J. 23,
    10-16, does for assisting flow: h^3 = h_least^3 + h_forced^3 + c^3 |dT|, the natural law being c |dT|^(1/3). The
    turn of c between the unstable and stable side is smoothed over 0.1 K, and h is never below 2 W m^-2 K^-1 where
    there is air. On a field h_forced depends on the temperature difference too, by `Stability`, but for trees, over
    which the similarity of the surface layer underestimates the exchange (Thom et al. 1975, Q. J. R. Meteorol. Soc.
    101, 93-105; Garratt 1980, ibid. 106, 803-819). Evaporation is the bulk latent flux wetness rho cp / gamma
    (e_sat(T) - e) / (r_a + r_s), r_a = rho cp / h, r_s the surface resistance (Penman 1948, Monteith 1965); the same
    path carries condensation when e > e_sat(T). Below freezing e_sat is that over ice and the flux carries the heat of
    sublimation: the water is frost. Cells deliver the share delivered (1 + b (T - 25 C)) of the light on them as power
    (Evans 1977, Proc. IEEE Photovoltaic Spec. Conf., as Skoplaki and Palyvos 2009, Solar Energy 83, 614-624, have it).
    """

    def __init__(self, forcing: Forcing, material: SurfaceMaterial) -> None:
        self.shape = forcing.shape
        self.forcing, self.material, self.skin = forcing, material, skin_of(material, forcing)
        self.absorbed = self.shortwave + self.longwave
        self.delivers = bool(material.surface.delivered)
        self.delivered_slope = material.surface.delivered * material.surface.delivered_per_kelvin * self.received
        if self.delivers:
            self.absorbed = self.absorbed - self._delivered_at_zero
        self.emission = self.skin.thermal_emissivity * STEFAN_BOLTZMANN
        self.air_temperature = forcing.air_temperature
        surface = material.surface
        self.airless = not np.any(forcing.pressure)
        if not self.airless:
            self._set_air(surface)
        self.wetness = 0.0 if self.airless else self.skin.wetness
        self.filmed = not self.airless and material.film is not None and forcing.film is not None
        self.film = forcing.film if self.filmed and forcing.film is not None else np.zeros((1, 1))
        self.evaporates = self.filmed or bool(np.any(self.wetness))
        if self.evaporates:
            self._set_water(surface)

    @property
    def shortwave(self) -> Floats:
        """Absorbed from Sun, sky and ground [W m^-2]."""
        return self.skin.solar_absorptance * self.received

    @property
    def received(self) -> Floats:
        """Sunlight on the plane [W m^-2]."""
        forcing = self.forcing
        return forcing.shortwave_direct + forcing.shortwave_diffuse + forcing.shortwave_reflected

    @property
    def _delivered_at_zero(self) -> Floats:
        """Power that the law of the cells has at 0 K [W m^-2]."""
        surface = self.material.surface
        power: Floats = surface.delivered * (1 - surface.delivered_per_kelvin * CELLS_RATED) * self.received
        return power

    @property
    def longwave(self) -> Floats:
        """Absorbed from sky and ground [W m^-2]."""
        return self.skin.thermal_emissivity * (self.forcing.longwave_sky + self.forcing.longwave_ground)

    @property
    def bends(self) -> bool:
        """Whether the exchange with the air bends at the temperature of the air, as that of a field does."""
        return not self.airless and self.stability is not None

    def columns(self, chosen: slice | Integers) -> Balance:
        """The balance of a slice or index array of columns."""
        return Balance(self.forcing.columns(chosen), self.material)

    def single(self) -> Balance:
        """The same in single precision."""
        balance = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                setattr(balance, name, value.astype(np.float32))
        if not self.airless and self.stability is not None:
            balance.stability = self.stability.single()
        return balance

    def _set_air(self, surface: SurfaceProperties) -> None:
        forcing = self.forcing
        if np.any(np.asarray(forcing.pressure) <= 0):
            raise InputError("found pressure 0 in some columns only; allowed: air in all of them or vacuum in all")
        wind = Wind(forcing.wind_speed, forcing.wind_height, forcing.air_height)
        forced = forced_coefficient(wind, forcing.pressure, forcing.air_temperature, surface)
        warmer, colder = natural_coefficients(forcing.cos_slope, forcing.pressure, surface)
        self.even, self.odd = 0.5 * (warmer**3 + colder**3), 0.5 * (warmer**3 - colder**3)
        natural = np.where(stratified(surface) & (forcing.cos_slope >= 0), LEAST_OVER_GROUND, LEAST_CONVECTION)
        self.least_cube, self.forced_cube = natural**3, forced * forced * forced
        self.stability = None
        if stratified(surface):
            self.stability = Stability.of(wind, forcing.air_temperature, forcing.cos_slope, surface.roughness_length)

    def _set_water(self, surface: SurfaceProperties) -> None:
        forcing = self.forcing
        heat_capacity = air_density(forcing.pressure, forcing.air_temperature) * AIR_HEAT_CAPACITY
        resistance = self.skin.surface_resistance
        if surface.canopy:
            air = forcing.vapour_pressure, forcing.pressure
            resistance = canopy_resistance(
                surface.surface_resistance, surface.roughness_length, forcing.open_light, forcing.air_temperature, air
            )
        self.resistance = resistance / heat_capacity
        self.psychrometer = PSYCHROMETER_RATIO * forcing.pressure
        self.surface_path = self.psychrometer * self.resistance
        self.vapour_pressure = forcing.vapour_pressure

    def loss(self, temperature: Reals) -> Reals:
        """Net outward flux f(T) [W m^-2], shape (columns, N)."""
        net = temperature * temperature
        net *= net if temperature.min() >= 0 else temperature * np.abs(temperature)
        net *= self.emission
        net -= self.absorbed
        if self.delivers:
            net += self.delivered_slope * temperature
        if self.airless:
            return net
        difference = temperature - self.air_temperature
        coefficient = self._coefficient(difference)
        if self.evaporates:
            net += self._latent(temperature, coefficient)
        difference *= coefficient
        net += difference
        return net

    def loss_and_slope(self, temperature: Reals) -> tuple[Reals, Reals]:
        """f(T) and its derivative by temperature [W m^-2 K^-1], each (columns, N)."""
        slope = np.abs(temperature)
        slope *= slope * slope
        slope *= self.emission
        net = slope * temperature
        net -= self.absorbed
        slope *= 4.0
        if self.delivers:
            net += self.delivered_slope * temperature
            slope = slope + self.delivered_slope
        if self.airless:
            return net, slope
        difference = temperature - self.air_temperature
        coefficient, bend = self._coefficient_and_bend(difference)
        if self.evaporates:
            latent, latent_slope = self._latent_and_slope(temperature, coefficient, bend)
            net += latent
            slope = slope + latent_slope
        slope = slope + coefficient
        bend *= difference
        slope += bend
        difference *= coefficient
        net += difference
        return net, slope

    def given_to_air(self, temperature: Reals, coefficient: Floats) -> tuple[Reals, Reals]:
        """Heat and water that pass a transfer coefficient [W m^-2], and their derivative, each (columns, N)."""
        net, slope = coefficient * (temperature - self.air_temperature), coefficient + 0.0 * temperature
        if self.evaporates:
            latent, latent_slope = self._latent_and_slope(temperature, slope, 0.0 * temperature)
            net, slope = net + latent, slope + latent_slope
        return net, slope

    def _coefficient(self, difference: Reals) -> Reals:
        """Convective transfer coefficient h [W m^-2 K^-1] at temperature differences to the air [K]."""
        cube = difference * difference
        cube += _TURNOVER**2
        np.sqrt(cube, out=cube)
        cube *= self.even
        cube += self.odd * difference
        if self.stability is None:
            cube += self.forced_cube
        else:
            factor = self.stability.factor(difference)
            cube += self.forced_cube * factor * factor * factor
        cube += self.least_cube
        return _cube_root(cube)

    def _coefficient_and_bend(self, difference: Reals) -> tuple[Reals, Reals]:
        """`_coefficient` and its derivative by temperature [W m^-2 K^-2]."""
        width = difference * difference
        width += _TURNOVER**2
        np.sqrt(width, out=width)
        cube = self.even * width
        cube += self.odd * difference
        bend = difference / width
        bend *= self.even
        bend += self.odd
        if self.stability is None:
            cube += self.forced_cube
        else:
            factor, slope = self.stability.factor_and_slope(difference)
            forced = self.forced_cube * factor
            forced *= factor
            slope *= forced
            slope *= 3.0
            bend += slope
            forced *= factor
            cube += forced
        cube += self.least_cube
        coefficient = _cube_root(cube)
        cube = coefficient * coefficient
        cube *= 3.0
        bend /= cube
        return coefficient, bend

    def _latent(self, temperature: Reals, coefficient: Reals) -> Reals:
        """Latent heat flux [W m^-2], given the convective transfer coefficient."""
        vapour, latent_heat = surface_vapour(temperature)
        vapour -= self.vapour_pressure
        if self.filmed:
            return vapour * latent_heat * self._exchange(vapour, self.psychrometer / coefficient)
        vapour *= latent_heat * self.wetness
        transfer = self.psychrometer / coefficient
        transfer += self.surface_path
        vapour /= transfer
        return vapour

    def _exchange(self, deficit: Reals, path: Reals) -> Reals:
        """Latent heat flux over the deficit of vapour pressure [W m^-2 Pa^-1]: that of the film, over the air's path
        alone, and of the rest; dew covers all.
        """
        covered = np.where(deficit > 0, self.film, 1.0)
        exchange: Reals = covered / path + (1 - covered) * self.wetness / (path + self.surface_path)
        return exchange

    def latent_of_film(self, temperature: Reals) -> Reals:
        """Latent heat flux of a surface as wet as its film says, without what else evaporates [W m^-2]."""
        vapour, latent_heat = surface_vapour(temperature)
        vapour -= self.vapour_pressure
        coefficient = self._coefficient(temperature - self.air_temperature)
        flux: Reals = vapour * latent_heat * self.film * coefficient / self.psychrometer
        return flux

    def _latent_and_slope(self, temperature: Reals, coefficient: Reals, bend: Reals) -> tuple[Reals, Reals]:
        """`_latent` and its derivative by temperature, `bend` being that of the coefficient."""
        vapour, latent_heat, slope, heat_slope = surface_vapour_and_slopes(temperature)
        vapour -= self.vapour_pressure
        slope *= latent_heat
        slope += heat_slope * vapour
        if self.filmed:
            return self._film_and_slope(vapour, latent_heat, slope, self.psychrometer / coefficient, bend / coefficient)
        vapour *= latent_heat
        path = self.psychrometer / coefficient
        transfer = path + self.surface_path
        vapour *= self.wetness / transfer
        slope *= self.wetness / transfer
        path *= bend
        path /= coefficient
        path /= transfer
        path *= vapour
        slope += path
        return vapour, slope

    def _film_and_slope(
        self, deficit: Reals, latent_heat: Reals, slope: Reals, path: Reals, bend: Reals
    ) -> tuple[Reals, Reals]:
        """Latent heat flux and its derivative; `slope` is that of deficit times latent heat, `bend` that of the
        logarithm of the transfer coefficient.
        """
        covered = np.where(deficit > 0, self.film, 1.0)
        resistance = path + self.surface_path
        film, uncovered = covered / path, (1 - covered) * self.wetness / resistance
        flux: Reals = deficit * latent_heat * (film + uncovered)
        slopes: Reals = slope * (film + uncovered) + deficit * latent_heat * bend * (
            film + uncovered * path / resistance
        )
        return flux, slopes

    def fluxes(self, temperature: Reals) -> dict[str, Reals]:
        """Each flux by name [W m^-2], (columns, N): absorbed ones positive inwards, the others positive outwards.

        Sunlight is less the power that is delivered.
        """
        zero = np.zeros(self.shape)
        parts: dict[str, Reals] = {
            "shortwave_absorbed": self.shortwave - self._delivered_at_zero - self.delivered_slope * temperature + zero,
            "longwave_absorbed": self.longwave + zero,
            "longwave_emitted": self.emission * np.abs(temperature) * temperature**3 + zero,
            "convection": zero,
            "evaporation": zero,
        }
        if not self.airless:
            difference = temperature - self.air_temperature
            coefficient = self._coefficient(difference)
            parts["convection"] = coefficient * difference
            if self.evaporates:
                parts["evaporation"] = self._latent(temperature, coefficient)
        return parts


def _cube_root(cube: Reals) -> Reals:
    """Cube root of numbers between 1 and 1e30, to 1e-6 in single and 1e-12 in double precision.

    Logarithm and exponential of single precision are several times as fast as numpy's own cube root; one step of
    Newton's method doubles their digits.
    """
    root = np.log(cube, dtype=np.float32, casting="same_kind")
    root *= np.float32(1 / 3)
    np.exp(root, out=root)
    if cube.dtype == np.float32:
        return root
    fine = root.astype(float)
    ratio = fine * fine
    np.divide(cube, ratio, out=ratio)
    ratio -= fine
    ratio *= 1 / 3
    fine += ratio
    return fine
