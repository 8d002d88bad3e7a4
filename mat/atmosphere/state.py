"""One atmospheric state: what the air holds at each level, from the ground to space.

Between levels pressure, number density and gases are exponential in altitude, temperature is linear. Above the highest level
(100 km) there is nothing: the air left there has a vertical optical depth below 1e-6 in every band.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import constants

from skyshine.mat.atmosphere.aerosol import AerosolModel, aerosol_layers
from skyshine.mat.atmosphere.profiles import load_profile
from skyshine.schemas.errors import InputError

TOP = 100e3  # m
SURFACE_RANGE = (-500.0, 5900.0)  # m; below the Dead Sea, and below the 6 km where aerosol profiles meet the ground
# Spacing of levels by height above the ground: (up to, step) in m. Water vapour halves in about 1.4 km; 250 m keeps the
# error of a property linear between levels below 0.4 %.
SPACING = ((3e3, 250.0), (12e3, 500.0), (26e3, 1e3), (50e3, 2.5e3), (TOP, 10e3))

WATER_MOLAR_MASS = 18.01528e-3  # kg mol^-1 (IUPAC 2018)
DOBSON_UNIT = 2.6867e20  # molecules m^-2: 10 um of ozone at 0 C and 1 atm (Loschmidt constant, CODATA)
# The 330 ppmv of the standard profiles (Anderson et al. 1986) at the ground, which a job's CO2 replaces.
PROFILE_CO2_PPM = 330.0


@dataclass(frozen=True, eq=False)
class AerosolComponent:
    """One aerosol and how much of it there is.

    Attributes
    ----------
    model : AerosolModel
    extinction_550 : (N,) array
        At 0.55 um, m^-1, at the levels of the state.
    """

    model: AerosolModel
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
    """

    name: str
    altitude: np.ndarray
    pressure: np.ndarray
    temperature: np.ndarray
    mole_fraction: dict[str, np.ndarray]
    aerosols: tuple[AerosolComponent, ...]
    surface_temperature: float
    surface_albedo: float

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
        aerosol="rural",
        visibility_km=23.0,
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
        gas_scale : dict, optional
            Gas to factor.
        aerosol : str
            Boundary-layer model of `aerosol.MODELS`, or "none" for air without particles at any height.
        visibility_km : float
            0.1 to 300.
        season : str, optional
            One of `aerosol.SEASONS`; by default that of the profile's name, spring_summer unless it is a winter's.
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
        if not (np.isfinite(humidity_scale) and humidity_scale >= 0):
            raise InputError(f"humidity scale {humidity_scale} is not allowed; give a finite number of at least 0")
        factors = {**(gas_scale or {}), "H2O": humidity_scale * (gas_scale or {}).get("H2O", 1.0)}
        if co2_ppm is not None:
            factors["CO2"] = co2_ppm / PROFILE_CO2_PPM
        for gas, factor in factors.items():
            profile = profile.with_gas_scaled(gas, factor)
        altitude = _levels(surface_altitude)
        temperature = _linear(altitude, profile.altitude, profile.temperature)
        pressure = np.exp(_linear(altitude, profile.altitude, np.log(profile.pressure)))
        gases = {gas: _exponential(altitude, profile.altitude, x) for gas, x in profile.mole_fraction.items()}
        if humidity_scale > 1:
            gases["H2O"] = np.minimum(gases["H2O"], saturation_pressure(temperature) / pressure)
        if season is None:
            season = "fall_winter" if profile.name.endswith("winter") else "spring_summer"
        layers = aerosol_layers(altitude, visibility_km, season, aerosol, surface_altitude)
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
        )

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
        return _exponential(np.asarray(altitude, dtype=float), self.altitude, self.mole_fraction[gas])

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
        layer = _mean_exponential(density[:-1], density[1:]) * np.diff(self.altitude)
        above = np.append(np.cumsum(layer[::-1])[::-1], 0.0)
        altitude = np.clip(altitude, self.altitude[0], self.altitude[-1])
        lower = np.clip(np.searchsorted(self.altitude, altitude, side="right") - 1, 0, self.altitude.size - 2)
        upper = self.altitude[lower + 1]
        here = _exponential(altitude, self.altitude, density)
        return above[lower + 1] + _mean_exponential(here, density[lower + 1]) * (upper - altitude)


def saturation_pressure(temperature):
    """Saturation vapour pressure over liquid water, supercooled too [Pa], at temperatures [K].

    References
    ----------
    Murphy and Koop 2005, Q. J. R. Meteorol. Soc. 131, 1539, equation (10), 123 to 332 K.
    """
    t = np.asarray(temperature, dtype=float)
    first = 54.842763 - 6763.22 / t - 4.210 * np.log(t) + 0.000367 * t
    second = 53.878 - 1331.22 / t - 9.44523 * np.log(t) + 0.014025 * t
    return np.exp(first + np.tanh(0.0415 * (t - 218.8)) * second)


def _levels(surface_altitude):
    """Altitudes [m] from the ground to the top, fine near the ground."""
    pieces, start = [], surface_altitude
    for end, step in SPACING:
        # Above the boundary layer the levels stand at fixed altitudes above the sea, whatever the ground.
        end = end + surface_altitude if end <= 6e3 else end
        count = int(np.ceil((end - start) / step - 1e-9))
        if count > 0:
            pieces.append(np.linspace(start, end, count, endpoint=False))
            start = end
    return np.append(np.concatenate(pieces), TOP)


def _linear(points, nodes, values):
    """Linear interpolation; below the first node the lowest layer is continued."""
    slope = (values[1] - values[0]) / (nodes[1] - nodes[0])
    below = values[0] + slope * (points - nodes[0])
    return np.where(points < nodes[0], below, np.interp(points, nodes, values))


def _exponential(points, nodes, values):
    """Interpolation linear in the logarithm, in which a 0 stays 0."""
    tiny = np.finfo(float).tiny
    result = np.exp(_linear(points, nodes, np.log(np.maximum(values, tiny))))
    return np.where(result <= 2 * tiny, 0.0, result)


def _mean_exponential(first, second):
    """Mean of a quantity that runs exponentially from `first` to `second`; linear where one of them is 0."""
    high, low = np.maximum(first, second), np.minimum(first, second)
    usable = low > 0
    ratio = np.where(usable, high / np.where(usable, low, 1.0), 2.0)
    log = np.log(ratio)
    close = log < 1e-4
    exact = (high - low) / np.where(close, 1.0, log)
    return np.where(usable & ~close, exact, 0.5 * (first + second))
