"""The lowest air over the sea, by bulk theory: scales of wind, temperature and humidity, and their profiles.

References
----------
Fairall et al. 2003, J. Climate 16, 571 (COARE 3.0: gustiness, roughness lengths). Edson et al. 2013, J. Phys. Oceanogr.
43, 1589 (COARE 3.5: Charnock's parameter by wind). Kraus and Businger 1994, Atmosphere-Ocean Interaction, section 2.6:
salt lowers the saturation over sea water to 0.98.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import STANDARD_GRAVITY
from skyshine.mat.surface.convection import VON_KARMAN
from skyshine.mat.surface.similarity import heat_profile, inverse_obukhov_length, momentum_profile
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats

SALT = 0.98
DRY_ADIABAT = STANDARD_GRAVITY / 1004.67  # K m^-1
_VAPOUR_RATIO = 0.622
# Edson et al. 2013: Charnock's parameter is 0.0017 U10 - 0.005 up to 19 m/s; smooth flow has 0.11 nu / u*.
_CHARNOCK, _CHARNOCK_OFFSET, _STRONGEST_WIND, _SMOOTH = 0.0017, -0.005, 19.0, 0.11
# COARE 3.5: roughness length of heat and vapour by the roughness Reynolds number.
_HEAT_ROUGHNESS, _HEAT_FACTOR, _HEAT_POWER = 1.6e-4, 5.8e-5, -0.72
# Fairall et al. 2003: gusts of a convective layer this deep [m], and least gusts [m/s].
_GUSTINESS, LAYER_DEPTH, _LEAST_GUST = 1.2, 600.0, 0.2
_MOST_STABLE, _MOST_UNSTABLE = 50.0, -200.0  # z / L, far beyond what is observed
_LEAST_RATIO = 1.0  # smallest ratio of logarithm less psi: keeps the scales finite in the freest convection
_ITERATIONS, _DAMPING = 60, 0.5
_REFERENCE = 10.0  # m


@dataclass(frozen=True)
class SeaSurface:
    """Surface layer over the sea.

    Attributes
    ----------
    temperature, humidity : float
        Temperature of the water's surface [K] and specific humidity of the air on it [kg/kg].
    friction_velocity, temperature_scale, humidity_scale : float
        u* [m/s], T* [K], q* [kg/kg]; the last two are negative where heat and vapour rise.
    inverse_length : float
        1 / L [m^-1], negative in unstable air.
    roughness, heat_roughness : float
        Roughness lengths of wind, and of temperature and humidity [m].
    steadiness : float
        Mean wind over the speed that gusts raise [1].
    """

    temperature: float
    humidity: float
    friction_velocity: float
    temperature_scale: float
    humidity_scale: float
    inverse_length: float
    roughness: float
    heat_roughness: float
    steadiness: float

    def wind_at(self, height: float) -> float:
        """Mean wind speed [m/s] at a height [m]."""
        speed = self.friction_velocity / VON_KARMAN * self.steadiness
        return speed * _momentum_logarithm(height, self.roughness, self.inverse_length)

    def air(self, height: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Temperature [K] and specific humidity [kg/kg] at heights [m] above the water, in their shape."""
        height = np.asarray(height, float)
        rise = _heat_logarithm(height, self.heat_roughness, self.inverse_length) / VON_KARMAN
        temperature = self.temperature + self.temperature_scale * rise - DRY_ADIABAT * height
        return temperature, np.maximum(self.humidity + self.humidity_scale * rise, 0.0)


def sea_surface(
    sea_temperature: float,
    air_temperature: float,
    air_humidity: float,
    wind_speed: float,
    pressure: float,
    *,
    wind_height: float,
    air_height: float,
    layer_depth: float = LAYER_DEPTH,
) -> SeaSurface:
    """Scales of the surface layer over the sea by COARE 3.5, without waves or ocean currents.

    Parameters
    ----------
    sea_temperature, air_temperature : float
        Temperature of the water's surface, and of the air at `air_height` [K].
    air_humidity : float
        Specific humidity of the air at `air_height` [kg/kg].
    wind_speed : float
        Wind speed at `wind_height` [m/s].
    pressure : float
        [Pa]
    wind_height, air_height, layer_depth : float
        Heights of measurement, and depth of the convective layer whose gusts stir calm air [m].

    Examples
    --------
    Air of 15 C and 80 % over a sea of the same temperature, 6 m/s:

    >>> sea = sea_surface(288.15, 288.15, 0.0085, 6.0, 101200.0, wind_height=10.0, air_height=10.0)
    >>> round(sea.friction_velocity, 2), sea.inverse_length < 0
    (0.2, True)
    """
    at_sea = SALT * float(saturation_pressure(sea_temperature))
    humidity = specific_humidity(at_sea, pressure)
    warmth = air_temperature + DRY_ADIABAT * air_height - sea_temperature
    moisture = air_humidity - humidity
    viscosity = kinematic_viscosity(air_temperature)
    inverse, gust, speed_10, steadiness = 0.0, 0.5, wind_speed, 1.0
    friction = max(0.035 * wind_speed, 0.01)
    for _ in range(_ITERATIONS):
        charnock = max(_CHARNOCK * min(speed_10, _STRONGEST_WIND) + _CHARNOCK_OFFSET, 0.0)
        roughness = charnock * friction**2 / STANDARD_GRAVITY + _SMOOTH * viscosity / friction
        reynolds = roughness * friction / viscosity
        heat_roughness = min(_HEAT_ROUGHNESS, _HEAT_FACTOR * reynolds**_HEAT_POWER)
        total = float(np.hypot(wind_speed, gust))
        momentum = _momentum_logarithm(wind_height, roughness, inverse)
        heat = float(_heat_logarithm(air_height, heat_roughness, inverse))
        new_friction = VON_KARMAN * total / momentum
        friction += _DAMPING * (new_friction - friction)
        temperature_scale, humidity_scale = VON_KARMAN * warmth / heat, VON_KARMAN * moisture / heat
        new_inverse = float(inverse_obukhov_length(friction, temperature_scale, humidity_scale, air_temperature))
        highest = max(wind_height, air_height)
        new_inverse = float(np.clip(new_inverse, _MOST_UNSTABLE / highest, _MOST_STABLE / highest))
        inverse += _DAMPING * (new_inverse - inverse)
        buoyancy = (
            -STANDARD_GRAVITY
            / air_temperature
            * friction
            * (temperature_scale + 0.61 * air_temperature * humidity_scale)
        )
        gust = max(_GUSTINESS * float(np.cbrt(max(buoyancy, 0.0) * layer_depth)), _LEAST_GUST)
        steadiness = wind_speed / total
        speed_10 = friction / VON_KARMAN * _momentum_logarithm(_REFERENCE, roughness, inverse) * steadiness
    return SeaSurface(
        sea_temperature,
        humidity,
        friction,
        temperature_scale,
        humidity_scale,
        inverse,
        roughness,
        heat_roughness,
        steadiness,
    )


def kinematic_viscosity(temperature: float) -> float:
    """Kinematic viscosity of air near sea level [m^2 s^-1] at a temperature [K]: Andreas 1989, CRREL Report 89-11."""
    celsius = temperature - 273.15
    return 1.326e-5 * (1 + celsius * (6.542e-3 + celsius * (8.301e-6 - 4.84e-9 * celsius)))


def specific_humidity(vapour_pressure: float, pressure: float) -> float:
    """Specific humidity [kg/kg] of a vapour pressure in air of a pressure [Pa]."""
    return _VAPOUR_RATIO * vapour_pressure / (pressure - (1 - _VAPOUR_RATIO) * vapour_pressure)


def _momentum_logarithm(height: float, roughness: float, inverse_length: float) -> float:
    return max(float(np.log(height / roughness) - momentum_profile(height * inverse_length)), _LEAST_RATIO)


def _heat_logarithm(height: npt.ArrayLike, roughness: float, inverse_length: float) -> Floats:
    height = np.asarray(height, float)
    logarithm: Floats = np.maximum(np.log(height / roughness) - heat_profile(height * inverse_length), 0.0)
    return logarithm
