"""The weather near the ground as the lowest part of a profile: air mass, mixed layer, surface inversion.

The day's mean weather moves the whole lower troposphere, since it belongs to an air mass: its difference from the
profile fades to nothing at 10 km, near the tropopause, above which departures of temperature change their sign. A time
of the day shapes the boundary layer alone: where its air is warmer than the day's mean, a layer mixed from the ground;
where it is colder, a surface inversion.

References
----------
Holzworth (1967), J. Appl. Meteorol. 6, 1039: mixing height by the parcel method. Stull (1988), An Introduction to
Boundary Layer Meteorology, chapters 11 (mixed layer) and 12 (stable layer). Yamada (1979), J. Appl. Meteorol. 18, 526:
cubic inversion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from skyshine.mat.atmosphere.soundings.levels import HIGHEST_PRESSURE, TEMPERATURES
from skyshine.mat.atmosphere.state.hydrostatics import DRY_AIR_MOLAR_MASS, gravity
from skyshine.mat.atmosphere.state.levels import exponential, linear
from skyshine.mat.atmosphere.state.profiles import Profile
from skyshine.mat.radiometry.constants import GAS_CONSTANT, STANDARD_GRAVITY
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather import LAPSE_RATE
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.errors import InputError

# K m^-1; heat capacity of dry air at constant pressure: Stull 1988, appendix C
DRY_ADIABAT = STANDARD_GRAVITY / 1004.67
AIR_MASS_DEPTH = 10e3  # m
# Height at which a surface inversion ends; the cubic has an eighth of its strength at half of it. Nights make some
# 100 to 500 m (Stull 1988, chapter 12).
INVERSION_HEIGHT = 500.0  # m
_ROUNDING = 1e-6  # m
_HEIGHTS = np.concatenate([[0, 10], np.arange(25, 200, 25), np.arange(200, 500, 50), np.arange(500, 5001, 250)])


@dataclass(frozen=True)
class GroundAir:
    """Air near the ground, by the weather.

    Attributes
    ----------
    altitude : float
        Altitude at which the air is described, m.
    temperature, mean_temperature : float
        Temperature at the time of the profile, and mean of its day, K.
    vapour_pressure, mean_vapour_pressure : float, optional
        Likewise, Pa. Without them the profile's water vapour stays, mixed as the air is.
    pressure : float, optional
        Mean of the day, Pa; by default that of the profile.
    """

    altitude: float
    temperature: float
    mean_temperature: float
    vapour_pressure: float | None = None
    mean_vapour_pressure: float | None = None
    pressure: float | None = None


def with_ground_air(profile: Profile, ground: float, air: GroundAir) -> Profile:
    """A profile whose lowest part has the weather's temperature, humidity and pressure.

    Parameters
    ----------
    ground : float
        Altitude of the ground, m. The air is carried there from its own altitude: 6.5 K/km, mixing ratio constant.

    Returns
    -------
    Profile
        From the ground up. Temperature and water vapour above 10 km, and all other gases, are those of the profile.
        The change of pressure at the ground and the weight of the warmer air change pressure above by a factor.

    Raises
    ------
    InputError
        Air that is hotter, colder or denser than any in nature, or humid air with a profile that has no water vapour
        at the ground.
    """
    altitude = np.union1d(ground + _HEIGHTS, profile.altitude[profile.altitude > ground])
    carried = LAPSE_RATE * (air.altitude - ground)
    at_ground, mean = air.temperature + carried, air.mean_temperature + carried
    _check_temperature(at_ground, mean)
    altitude = np.union1d(altitude, ground + _mixing_height(profile, altitude, at_ground, mean))
    temperature, mixed = _temperature(profile, altitude, at_ground, mean)
    pressure = _pressure(profile, altitude, temperature, air)
    water = _water(profile, altitude, mixed, air)
    saturated = saturation_pressure(temperature) / pressure
    gases = {gas: exponential(altitude, profile.altitude, x) for gas, x in profile.mole_fraction.items()}
    gases["H2O"] = np.minimum(water, saturated)
    return Profile(profile.name, altitude, pressure, temperature, gases)


def _check_temperature(*kelvin: float) -> None:
    low, high = TEMPERATURES
    for value in kelvin:
        if not low <= value <= high:
            raise InputError(
                f"found air of {value:.1f} K at the ground by the weather; allowed: {low:g} to {high:g} K for the air"
                " of paths; fix the weather, or give air: profile"
            )


def _air_mass_share(height: Floats) -> Floats:
    """Share of a departure at the ground that the air at a height [m] has."""
    return np.maximum(1.0 - height / AIR_MASS_DEPTH, 0.0)


def _inversion_share(height: Floats) -> Floats:
    share: Floats = np.maximum(1.0 - height / INVERSION_HEIGHT, 0.0) ** 3
    return share


def _air_mass(profile: Profile, altitude: Floats, mean: float) -> Floats:
    """The profile's temperature, moved to the day's mean at the ground."""
    before = linear(altitude, profile.altitude, profile.temperature)
    moved: Floats = before + (mean - before[0]) * _air_mass_share(altitude - altitude[0])
    return moved


def _mixing_height(profile: Profile, altitude: Floats, at_ground: float, mean: float) -> float:
    """Height above the ground at which a parcel that rises from it dry adiabatically meets the air mass, m; 0 where the
    ground does not warm the air.
    """
    height = altitude - altitude[0]
    buoyancy = max(at_ground, mean) - DRY_ADIABAT * height - _air_mass(profile, altitude, mean)
    ends = np.flatnonzero(buoyancy[1:] <= 0)
    end = ends[0] + 1
    if end == 1 and buoyancy[0] <= 0:
        return 0.0
    below, above = buoyancy[end - 1], buoyancy[end]
    crossing: float = height[end - 1] + (height[end] - height[end - 1]) * below / (below - above)
    return crossing


def _temperature(profile: Profile, altitude: Floats, at_ground: float, mean: float) -> tuple[Floats, Booleans]:
    """Temperature (N,) at levels, one of which is the mixing height, and the levels (N,) that are mixed."""
    height, air_mass = altitude - altitude[0], _air_mass(profile, altitude, mean)
    mixed = height <= _mixing_height(profile, altitude, at_ground, mean) + _ROUNDING
    if not np.any(mixed[1:]):
        mixed = np.zeros_like(mixed)
    temperature = np.where(mixed, max(at_ground, mean) - DRY_ADIABAT * height, air_mass)
    return temperature + min(at_ground - mean, 0.0) * _inversion_share(height), mixed


def _pressure(profile: Profile, altitude: Floats, temperature: Floats, air: GroundAir) -> Floats:
    """Pressure in hydrostatic balance as far as the profile's own is, with that of the weather at its altitude."""
    before = linear(altitude, profile.altitude, np.log(profile.pressure))
    expansion = 1 / linear(altitude, profile.altitude, profile.temperature) - 1 / temperature
    weight = DRY_AIR_MOLAR_MASS / GAS_CONSTANT * gravity(altitude) * expansion
    raised = np.append(0.0, np.cumsum(0.5 * (weight[1:] + weight[:-1]) * np.diff(altitude)))
    factor = 1.0 if air.pressure is None else air.pressure / _station_pressure(profile, air.altitude)
    pressure: Floats = factor * np.exp(before + raised)
    if pressure[0] > HIGHEST_PRESSURE:
        raise InputError(
            f"found air of {pressure[0] / 100:.0f} hPa at the ground by the weather; allowed: at most"
            f" {HIGHEST_PRESSURE / 100:g} hPa; fix the weather's pressure or altitude, or give air: profile"
        )
    return pressure


def _station_pressure(profile: Profile, altitude: float) -> float:
    return float(np.exp(linear(altitude, profile.altitude, np.log(profile.pressure))))


def _water(profile: Profile, altitude: Floats, mixed: Booleans, air: GroundAir) -> Floats:
    """Mole fraction of water vapour (N,), of air that may be supersaturated."""
    fraction = exponential(altitude, profile.altitude, profile.mole_fraction["H2O"])
    ratio = fraction / (1 - fraction)  # vapour per dry air, which mixing keeps
    height = altitude - altitude[0]
    if air.vapour_pressure is None or air.mean_vapour_pressure is None:
        if np.any(mixed):
            weight = -np.gradient(np.exp(linear(altitude, profile.altitude, np.log(profile.pressure))), altitude)
            column = scipy.integrate.trapezoid((weight * ratio)[mixed], altitude[mixed])
            ratio = np.where(mixed, column / scipy.integrate.trapezoid(weight[mixed], altitude[mixed]), ratio)
    else:
        station = _station_pressure(profile, air.altitude) if air.pressure is None else air.pressure
        if max(air.vapour_pressure, air.mean_vapour_pressure) >= 0.5 * station:
            largest = max(air.vapour_pressure, air.mean_vapour_pressure)
            raise InputError(
                f"found air of {station / 100:.0f} hPa that has water vapour of {largest / 100:.0f} hPa in the"
                " weather; allowed: less than half; fix temperature, humidity or pressure"
            )
        at_ground, mean = (part / (station - part) for part in (air.vapour_pressure, air.mean_vapour_pressure))
        if mean > 0 and ratio[0] <= 0:
            raise InputError(
                "the profile has no water vapour at the ground that the weather's humidity could scale; give air:"
                " profile, or humidity in the sounding"
            )
        share = _air_mass_share(height)
        factor = np.where(share > 0, 0.0, 1.0) if mean <= 0 else (mean / ratio[0]) ** share
        near_ground = (at_ground - mean) * _inversion_share(height)
        well_mixed = at_ground if air.temperature >= air.mean_temperature else mean + near_ground
        ratio = np.where(mixed, well_mixed, np.maximum(ratio * factor + near_ground, 0.0))
    water: Floats = ratio / (1 + ratio)
    return water
