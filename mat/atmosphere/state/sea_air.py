"""The sea's surface layer as the lowest part of a profile: the air near the water, and how rays bend in it.

References
----------
Kunz 1996, Proc. SPIE 2828, 378, and van Eijk et al. 2000 (EOSTAR): bulk theory of the marine surface layer for
refraction. Born and Wolf 1999, Principles of Optics, section 3.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.state.humidity import mole_fraction
from skyshine.mat.atmosphere.state.levels import exponential, linear
from skyshine.mat.atmosphere.state.profiles import Profile
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, STANDARD_DENSITY, refractivity
from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.surface.sea_surface import SeaSurface, sea_surface, specific_humidity
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

COLDEST_SEA, WARMEST_SEA = 270.15, 315.15  # K: sea water freezes at 271.3 K; shallow gulfs reach 310 K
# Heights of levels above the water, m. Below the lowest, where waves are, the air is taken as even.
HEIGHTS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 35.0, 50.0)
_STABLE_DEPTH = 1.0  # z / L up to which the profiles of stable air are used (Beljaars and Holtslag 1991, figure 2)
# Height at which the difference between the layer's top and the profile above has faded; chosen: a convective layer.
_FADED = 1000.0  # m
_WAVENUMBER = 1000.0  # cm^-1, at which bending is stated; 0.5 um has 2 % more
_TURNING = 0.1  # m: a ray that comes closer to the water than this meets it


@dataclass(frozen=True)
class SeaAir:
    """What bulk theory needs beside the air.

    Attributes
    ----------
    temperature : float
        Temperature of the water's surface [K].
    wind_speed : float
        [m/s]
    wind_height, air_height : float
        Heights above the water at which wind and air were measured [m]; the lowest air of the profile is that at
        `air_height`.
    """

    temperature: float
    wind_speed: float
    wind_height: float
    air_height: float


@dataclass(frozen=True)
class Bending:
    """How level rays bend near the water.

    Attributes
    ----------
    curvature : float
        Curvature of level rays between 0.5 and 10 m over that of the Earth, positive towards the water [1].
    lowest_curvature : float
        The same between 0.5 and 2 m [1]; below 0 there is an inferior mirage.
    duct : float
        Height up to which rays cannot leave the lowest air [m]; 0 for no duct.
    horizon : float
        Distance of the horizon from 10 m [m]; infinite in a duct.
    """

    curvature: float
    lowest_curvature: float
    duct: float
    horizon: float


def with_sea_air(profile: Profile, ground: float, sea: SeaAir) -> tuple[Profile, SeaSurface]:
    """A profile whose lowest air is the surface layer over the sea, and its scales.

    Parameters
    ----------
    ground : float
        Altitude of the water [m].

    Returns
    -------
    Profile
        From the water up. To 50 m, in stable air to the Obukhov length, temperature and humidity are those of bulk
        theory; their difference from the profile at that height fades to nothing at 1 km.
    SeaSurface

    Raises
    ------
    InputError
        A sea that is frozen or too hot.
    """
    if not COLDEST_SEA <= sea.temperature <= WARMEST_SEA:
        raise InputError(f"found a sea of {sea.temperature:.1f} K; allowed: {COLDEST_SEA:g} to {WARMEST_SEA:g} K")
    pressure = float(np.exp(linear(ground, profile.altitude, np.log(profile.pressure))))
    kelvin = float(linear(ground, profile.altitude, profile.temperature))
    fraction = float(exponential(ground, profile.altitude, profile.mole_fraction["H2O"]))
    surface = sea_surface(
        sea.temperature,
        kelvin,
        specific_humidity(fraction * pressure, pressure),
        sea.wind_speed,
        pressure,
        wind_height=sea.wind_height,
        air_height=sea.air_height,
    )
    stable = surface.inverse_length * HEIGHTS[-1] > _STABLE_DEPTH
    top = max(_STABLE_DEPTH / surface.inverse_length, sea.air_height) if stable else HEIGHTS[-1]
    top = min(top, HEIGHTS[-1])
    heights = np.array([0.0, *(h for h in HEIGHTS if h < 0.99 * top), top])
    above = profile.altitude[profile.altitude > ground + top]
    fading = ground + np.linspace(top, _FADED, 6)[1:]
    altitude = np.union1d(np.union1d(ground + heights, above), fading)
    layer = altitude <= ground + top + 1e-6
    share = np.where(layer, 0.0, np.clip((ground + _FADED - altitude) / (_FADED - top), 0.0, 1.0))
    air, humidity = surface.air(np.maximum(altitude[layer] - ground, HEIGHTS[0]))
    log_pressure = linear(altitude, profile.altitude, np.log(profile.pressure))
    temperature = linear(altitude, profile.altitude, profile.temperature)
    gases = {gas: exponential(altitude, profile.altitude, x) for gas, x in profile.mole_fraction.items()}
    water = gases["H2O"]
    vapour = mole_fraction("specific_humidity", humidity, np.exp(log_pressure[layer]), air)
    edge = int(np.count_nonzero(layer)) - 1
    warmer, moister = air[-1] - temperature[edge], vapour[-1] / max(water[edge], 1e-30)
    temperature = temperature + warmer * share
    water = np.where(layer, 0.0, water * (1 + (moister - 1) * share))
    temperature[layer], water[layer] = air, vapour
    gases["H2O"] = np.minimum(water, saturation_pressure(temperature) / np.exp(log_pressure))
    return Profile(profile.name, altitude, np.exp(log_pressure), temperature, gases), surface


def bending_near_water(altitude: Floats, pressure: Floats, temperature: Floats) -> Bending:
    """How level rays bend in the lowest air.

    Parameters
    ----------
    altitude, pressure, temperature : (N,) arrays
        Levels from the water up [m, Pa, K].
    """
    height = np.array([0.0, *HEIGHTS, 75.0, 100.0])
    log_index = np.log1p(
        float(refractivity(_WAVENUMBER))
        * np.exp(np.interp(height + altitude[0], altitude, np.log(pressure)))
        / (BOLTZMANN * np.interp(height + altitude[0], altitude, temperature) * STANDARD_DENSITY)
    )
    modified = log_index + height / EARTH_RADIUS  # a ray follows the Earth where it does not change

    def curvature(lower: float, upper: float) -> float:
        fall = np.interp(lower, height, log_index) - np.interp(upper, height, log_index)
        return float(fall * EARTH_RADIUS / (upper - lower))

    falls = np.flatnonzero(np.diff(modified) <= 0)
    duct = float(height[falls[-1] + 1]) if falls.size else 0.0
    horizon = np.inf if duct > 0 else _distance(height, modified, 10.0)
    return Bending(curvature(0.5, 10.0), curvature(0.5, 2.0), duct, horizon)


def _distance(height: Floats, modified: Floats, observer: float) -> float:
    """Distance [m] at which a ray from an observer's height [m] is level at the water, where the modified index rises.

    Along a ray near the horizontal the square of its angle is twice the modified index above that of its turning point;
    in a layer where that is linear in height, the way is 2 dh / (angle below + angle above).
    """
    nodes = np.unique(np.append(height[(height > _TURNING) & (height < observer)], [_TURNING, observer]))
    angle = np.sqrt(2 * np.maximum(np.interp(nodes, height, modified) - np.interp(_TURNING, height, modified), 0.0))
    return float(np.sum(2 * np.diff(nodes) / (angle[1:] + angle[:-1])))
