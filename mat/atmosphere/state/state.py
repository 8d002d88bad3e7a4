"""One atmospheric state: what the air holds at each level, from the ground to space.

Between levels pressure, number density and gases are exponential in altitude, temperature is linear. Above the highest
level (100 km) there is nothing: the air left there has a vertical optical depth below 1e-6 in every band.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import constants

from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import aerosol_layers, default_visibility
from skyshine.mat.atmosphere.particles.cloud import check_phase
from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel
from skyshine.mat.atmosphere.particles.windblown import DEFAULT_AIR_MASS, DEFAULT_WIND
from skyshine.mat.atmosphere.state.gas_amounts import (
    DOBSON_UNIT,
    gas_factors,
    layer_columns,
    mean_exponential,
    ozone_factor,
    water_factor,
)
from skyshine.mat.atmosphere.state.humidity import WATER_MOLAR_MASS, saturation_pressure
from skyshine.mat.atmosphere.state.levels import exponential, level_altitudes, linear
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.schemas.errors import InputError

SURFACE_RANGE = (-500.0, 5900.0)  # m; below the Dead Sea, and below the 6 km where aerosol profiles meet the ground

# A profile that begins higher than this above the ground says nothing of the air there, m.
LARGEST_GAP = 500.0


@dataclass(frozen=True, eq=False)
class AerosolComponent:
    """One kind of particle in the air and how much of it there is.

    Attributes
    ----------
    model : AerosolModel or HenyeyGreensteinModel
    extinction_550 : (N,) array
        At 0.55 um, m^-1, at the levels of the state.
    """

    model: AerosolModel | HenyeyGreensteinModel
    extinction_550: np.ndarray


@dataclass(frozen=True, eq=False)
class AtmosphericState:
    """Air, gases and particles at N levels, and the ground below.

    Attributes
    ----------
    name : str
    altitude : (N,) array
        Above sea level, m, increasing; the first is the ground, the last the top of the atmosphere.
    pressure, temperature : (N,) arrays
        Pa, K.
    mole_fraction : dict of (N,) arrays
    aerosols : tuple of AerosolComponent
    surface_temperature : float
        K, of the ground below the paths.
    surface_albedo : float
        0 to 1, of the ground below the paths.
    hydrometeors : tuple of AerosolComponent
        Cloud and rain.
    """

    name: str
    altitude: np.ndarray
    pressure: np.ndarray
    temperature: np.ndarray
    mole_fraction: dict[str, np.ndarray]
    aerosols: tuple[AerosolComponent, ...]
    surface_temperature: float
    surface_albedo: float
    hydrometeors: tuple[AerosolComponent, ...] = ()

    def __post_init__(self):
        for label, values in (
            ("altitude", self.altitude),
            ("pressure", self.pressure),
            ("temperature", self.temperature),
        ):
            if values.shape != self.altitude.shape or not np.all(np.isfinite(values)):
                raise InputError(f"atmospheric state '{self.name}': {label} must be finite at every level")
        if self.altitude.size < 2 or np.any(np.diff(self.altitude) <= 0):
            raise InputError(
                f"atmospheric state '{self.name}': altitudes must increase, without repetition; sort the levels"
            )
        if np.any(self.pressure <= 0) or np.any(self.temperature <= 0):
            raise InputError(f"atmospheric state '{self.name}': pressure and temperature must be above 0")
        if not 0.0 <= self.surface_albedo <= 1.0:
            raise InputError(f"surface albedo {self.surface_albedo} is outside 0 to 1")
        if not 100.0 <= self.surface_temperature <= 500.0:
            raise InputError(f"surface temperature {self.surface_temperature} K is outside 100 to 500 K")

    @classmethod
    def from_profile(
        cls,
        profile,
        *,
        surface_altitude=0.0,
        co2_ppm=None,
        humidity_scale=1.0,
        gas_scale=None,
        gas_ppm=None,
        water_column=None,
        ozone_column=None,
        aerosol="rural",
        visibility_km=None,
        wind_speed=DEFAULT_WIND,
        air_mass=DEFAULT_AIR_MASS,
        stratosphere="background",
        clouds=(),
        rain=None,
        season=None,
        surface_temperature=None,
        surface_albedo=0.1,
    ):
        """The state of a standard profile.

        Parameters
        ----------
        profile : str or Profile
            A name of `profiles.PROFILES`, or a profile.
        surface_altitude : float
            Above sea level, m. The profile is cut there; below its lowest level it is continued.
        co2_ppm : float, optional
            At the ground; None keeps the profile's.
        humidity_scale : float
            Factor on water vapour. Where it is above 1, water vapour stops at saturation over water.
        gas_scale, gas_ppm : dict, optional
            Gas to factor; gas to parts per million at the ground, its profile scaled.
        water_column, ozone_column : float, optional
            Above the ground, kg m^-2 (mm of water) and Dobson units, the profile scaled; water vapour stops at
            saturation.
        aerosol : str
            Boundary-layer model of `aerosol_column.BOUNDARY_MODELS`, or "none" for air without particles at any height.
        visibility_km : float, optional
            0.1 to 300; by default that of the aerosol model (`aerosol_column.default_visibility`).
        wind_speed : float
            At 10 m, m s^-1, which raises the desert and Navy maritime aerosols.
        air_mass : int
            1 (open ocean) to 10 (continental): of the Navy maritime aerosol.
        stratosphere : str
            One of `aerosol_column.STRATOSPHERES`.
        clouds : sequence of CloudLayer
            Air in water cloud is saturated, as in LOWTRAN7 (SUBROUTINE AERNSM), unless a water column asks for less.
        rain : RainLayer, optional
        season : str, optional
            One of `aerosol_column.SEASONS`; by default that of the profile's name, spring_summer unless it is a
            winter's.
        surface_temperature : float, optional
            K; that of the lowest air by default.
        surface_albedo : float
            0 to 1.

        Raises
        ------
        InputError
            For anything outside its range.
        """
        profile = load_profile(profile) if isinstance(profile, str) else profile
        low, high = SURFACE_RANGE
        if not low <= surface_altitude <= high:
            raise InputError(f"surface altitude {surface_altitude:g} m is outside {low:g} to {high:g} m")
        if surface_altitude < profile.altitude[0] - LARGEST_GAP:
            raise InputError(
                f"surface altitude {surface_altitude:g} m lies more than {LARGEST_GAP:g} m below the lowest level of"
                f" '{profile.name}', {profile.altitude[0]:g} m; raise the ground, or begin the profile lower"
            )
        if not (np.isfinite(humidity_scale) and humidity_scale >= 0):
            raise InputError(f"humidity scale {humidity_scale} is not allowed; give a finite number of at least 0")
        falling = [*clouds, *([] if rain is None else [rain])]
        altitude = level_altitudes(
            surface_altitude, profile, [surface_altitude + z for layer in falling for z in layer.edges]
        )
        temperature = linear(altitude, profile.altitude, profile.temperature)
        pressure = np.exp(linear(altitude, profile.altitude, np.log(profile.pressure)))
        gases = {gas: exponential(altitude, profile.altitude, x) for gas, x in profile.mole_fraction.items()}
        factors = gas_factors(
            gases,
            {**(gas_scale or {}), "H2O": humidity_scale * (gas_scale or {}).get("H2O", 1.0)},
            {**(gas_ppm or {}), **({} if co2_ppm is None else {"CO2": co2_ppm})},
        )
        gases = {gas: fraction * factors.get(gas, 1.0) for gas, fraction in gases.items()}
        for layer in clouds:
            inside = np.linspace(layer.base, layer.top, 20) + surface_altitude
            check_phase(layer, np.interp(inside, altitude, temperature))
        density = pressure / (constants.k * temperature)
        if ozone_column is not None:
            gases["O3"] = gases["O3"] * ozone_factor(altitude, density * gases["O3"], ozone_column)
        saturated = saturation_pressure(temperature) / pressure
        for layer in clouds:
            if layer.phase == "water":
                inside = layer.extinction_550(altitude - surface_altitude) > 0
                gases["H2O"] = np.where(inside, np.maximum(gases["H2O"], saturated), gases["H2O"])
        if water_column is not None or factors["H2O"] > 1:
            scale = (
                1.0 if water_column is None else water_factor(altitude, density, gases["H2O"], saturated, water_column)
            )
            gases["H2O"] = np.minimum(gases["H2O"] * scale, saturated)
        if season is None:
            season = "fall_winter" if profile.name.endswith("winter") else "spring_summer"
        if visibility_km is None:
            humidity = float(100 * gases["H2O"][0] * pressure[0] / saturation_pressure(temperature[0]))
            visibility_km = default_visibility(aerosol, wind_speed, humidity, air_mass)
        layers = aerosol_layers(
            altitude,
            visibility_km,
            season,
            aerosol,
            surface_altitude,
            stratosphere=stratosphere,
            wind_speed=wind_speed,
            air_mass=air_mass,
        )
        return cls(
            name=profile.name,
            altitude=altitude,
            pressure=pressure,
            temperature=temperature,
            mole_fraction=gases,
            aerosols=tuple(
                AerosolComponent(model, extinction) for model, extinction in layers if np.any(extinction > 0)
            ),
            surface_temperature=float(temperature[0] if surface_temperature is None else surface_temperature),
            surface_albedo=float(surface_albedo),
            hydrometeors=tuple(
                AerosolComponent(layer.model, layer.extinction_550(altitude - surface_altitude)) for layer in falling
            ),
        )

    @property
    def particles(self):
        """All kinds of particle: aerosols and hydrometeors."""
        return self.aerosols + self.hydrometeors

    @property
    def surface_altitude(self):
        """m above sea level."""
        return float(self.altitude[0])

    @cached_property
    def number_density(self):
        """Molecules of air, (N,) m^-3, by the ideal gas law."""
        return self.pressure / (constants.k * self.temperature)

    @cached_property
    def relative_humidity(self):
        """Over liquid water, (N,) percent, at most 100: what particles grow with."""
        return np.minimum(
            100.0 * self.mole_fraction["H2O"] * self.pressure / saturation_pressure(self.temperature), 100.0
        )

    def temperature_at(self, altitude):
        """Air temperature [K] at altitudes [m], any shape."""
        return np.interp(altitude, self.altitude, self.temperature)

    def pressure_at(self, altitude):
        """Air pressure [Pa] at altitudes [m], any shape."""
        return np.exp(np.interp(altitude, self.altitude, np.log(self.pressure)))

    def mole_fraction_at(self, gas, altitude):
        """Mole fraction of a gas at altitudes [m], any shape."""
        return exponential(np.asarray(altitude, dtype=float), self.altitude, self.mole_fraction[gas])

    def precipitable_water(self, altitude):
        """Water vapour above altitudes [m], kg m^-2."""
        density = self.number_density * self.mole_fraction["H2O"]
        return self._column(density, altitude) * WATER_MOLAR_MASS / constants.N_A

    def ozone_column(self, altitude):
        """Ozone above altitudes [m], Dobson units."""
        return self._column(self.number_density * self.mole_fraction["O3"], altitude) / DOBSON_UNIT

    def aerosol_optical_depth(self, wavelength_nm, altitude):
        """Vertical aerosol optical depth above altitudes [m] at one wavelength [nm]."""
        total = np.zeros(np.shape(altitude))
        wavenumber = np.array([1e7 / wavelength_nm])
        for component in self.aerosols:
            relative = component.model.optics(wavenumber, self.relative_humidity).extinction[:, 0]
            total = total + self._column(component.extinction_550 * relative, altitude)
        return total

    def _column(self, density, altitude):
        """Integral of a density [x m^-3], exponential between levels, from altitudes to the top: [x m^-2]."""
        layer = layer_columns(self.altitude, density)
        above = np.append(np.cumsum(layer[::-1])[::-1], 0.0)
        altitude = np.clip(altitude, self.altitude[0], self.altitude[-1])
        lower = np.clip(np.searchsorted(self.altitude, altitude, side="right") - 1, 0, self.altitude.size - 2)
        upper = self.altitude[lower + 1]
        here = exponential(altitude, self.altitude, density)
        return above[lower + 1] + mean_exponential(here, density[lower + 1]) * (upper - altitude)
