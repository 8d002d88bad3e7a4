"""Air near the ground through the day: from the day's extremes or from a table by hour, and carried to other
altitudes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.convection import AIR_HEIGHT, WIND_HEIGHT
from skyshine.mat.surface.ground_year import GroundSeason
from skyshine.mat.surface.measured import MeasuredRadiation
from skyshine.mat.surface.sun_path import SunPath, sun_hours
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats

LAPSE_RATE = 6.5e-3  # K/m, ISO 2533
# Hours from the highest Sun to the highest air temperature: de Wit (1978), Simulation of Assimilation, Respiration and
# Transpiration of Crops, Pudoc: at 14 h solar time.
_WARMEST_AFTER_NOON = 2.0
_HORIZON = 0.0  # degree; the Sun counts as up above it


@dataclass(frozen=True)
class Wetting:
    """Whether a film of water may lie on surfaces, the mean moisture of soil where it is given by time, and by how much
    the mean of the ground is below 0 C [K], 0 where it is not frozen.
    """

    rain: bool = False
    soil_moisture: float | None = None
    frost: float = 0.0


DRY = Wetting()


@dataclass(frozen=True, eq=False)
class NearSurfaceAir:
    """Air near the ground through the day; arrays are (SUN_STEPS,), at `sun_hours()`.

    Attributes
    ----------
    altitude : float
        Altitude at which the air is described [m].
    air_temperature : ndarray
        [K]
    vapour_pressure : ndarray
        [Pa]
    wind_speed : ndarray
        [m/s]
    cloud_fraction : ndarray
        0 to 1.
    pressure : ndarray or None
        [Pa]; None takes that of the atmospheric state.
    radiation : MeasuredRadiation or None
        None takes sunlight and sky longwave of the atmospheric state.
    wind_height, air_height : float
        Heights at which wind, and temperature and humidity, are given [m].
    before : tuple of (SunPath, NearSurfaceAir)
        The days before this one that its ground remembers, oldest first; empty: the day repeats.
    rain : ndarray or None
        [kg m^-2 s^-1]; None: surfaces know no film of water.
    soil_moisture : ndarray or None
        Volume fraction of water; None takes the materials as they are.
    snow_age : ndarray or None
        Time since snow fell [d]; None takes snow as it is.
    ground : GroundSeason or None
        Ground temperature at `altitude`; None: backs of ground have the mean temperature of the air.
    """

    altitude: float
    air_temperature: Floats
    vapour_pressure: Floats
    wind_speed: Floats
    cloud_fraction: Floats
    pressure: Floats | None = None
    radiation: MeasuredRadiation | None = None
    wind_height: float = WIND_HEIGHT
    air_height: float = AIR_HEIGHT
    before: tuple[tuple[SunPath, NearSurfaceAir], ...] = ()
    rain: Floats | None = None
    soil_moisture: Floats | None = None
    snow_age: Floats | None = None
    ground: GroundSeason | None = None

    @property
    def wetting(self) -> Wetting:
        """What of it the skins of surfaces need to know beforehand."""
        moistures = [air.soil_moisture for _, air in self.before] + [self.soil_moisture]
        values = [moisture for moisture in moistures if moisture is not None]
        return Wetting(self.rain is not None, float(np.mean(values)) if values else None, self._frost)

    @property
    def _frost(self) -> float:
        """How much the surface of the ground is below 0 C by its season, or else the mean air of all days [K]."""
        air = [weather.air_temperature for _, weather in self.before] + [self.air_temperature]
        kelvin = float(np.mean(air)) if self.ground is None else float(self.ground.below(0.0))
        return max(ZERO_CELSIUS - kelvin, 0.0)

    def ground_at(self, altitude: Floats) -> dict[str, Floats]:
        """Fields of `Forcing` of the ground's season at altitudes (A,) [m], mean (A, 1) and others (1, 1): cooler
        upwards as the air; empty where none is given.
        """
        if self.ground is None:
            return {}
        return {
            "ground_mean": self.ground.mean - LAPSE_RATE * (np.asarray(altitude, float)[:, None] - self.altitude),
            "ground_amplitude": np.array([[self.ground.amplitude]]),
            "ground_day": np.array([[self.ground.since_coldest]]),
        }

    def at(self, altitude: Floats, pressure: Floats) -> tuple[Floats, Floats, Floats]:
        """Air temperature [K], vapour pressure and pressure [Pa] over surfaces at other altitudes.

        Parameters
        ----------
        altitude : (A,) ndarray
            [m]
        pressure : (A + 1,) ndarray
            Pressure of the atmospheric state [Pa] at these altitudes and, last, at the altitude of the weather.

        Returns
        -------
        temperature, vapour_pressure, pressure : ndarray
            Each (A, SUN_STEPS); pressure (A, 1) where it does not change. The air cools by 6.5 K/km upwards and keeps
            its mixing ratio to saturation; measured pressure shifts the state's by one factor.
        """
        temperature = self.air_temperature - LAPSE_RATE * (np.asarray(altitude, float)[:, None] - self.altitude)
        ratio = (pressure[:-1] / pressure[-1])[:, None]
        station = pressure[-1] if self.pressure is None else self.pressure
        vapour = np.minimum(self.vapour_pressure * ratio, saturation_pressure(temperature))
        return temperature, vapour, station * ratio


def from_extremes(
    sun: SunPath,
    low: float,
    high: float,
    relative_humidity: float,
    wind_speed: float,
    cloud_fraction: float,
) -> NearSurfaceAir:
    """The air of a day with given lowest and highest air temperatures.

    Parameters
    ----------
    low, high : float
        [K]
    relative_humidity : float
        Relative humidity at the mean of both temperatures [percent]; the vapour pressure is constant except where the
        air is saturated.
    wind_speed : float
        [m/s]
    cloud_fraction : float
        0 to 1.
    """
    temperature = air_temperature(sun, low, high)
    vapour = relative_humidity / 100.0 * saturation_pressure(0.5 * (low + high))
    return NearSurfaceAir(
        sun.altitude,
        temperature,
        np.minimum(vapour, saturation_pressure(temperature)),
        np.full_like(temperature, wind_speed),
        np.full_like(temperature, cloud_fraction),
    )


def from_hours(
    altitude: float,
    hours: Floats,
    air_temperature: npt.ArrayLike,
    relative_humidity: npt.ArrayLike,
    wind_speed: npt.ArrayLike,
    cloud_fraction: npt.ArrayLike,
    pressure: npt.ArrayLike | None = None,
    radiation: MeasuredRadiation | None = None,
) -> NearSurfaceAir:
    """The air of a table by local clock hours, linear between them.

    Parameters
    ----------
    altitude : float
        Altitude at which the air is described [m].
    hours : (n,) ndarray
        Hours of the local clock, increasing; without hours before 0 and from 24 on, of the days before and after, the
        day repeats.
    air_temperature, relative_humidity, wind_speed, cloud_fraction : float or (n,) array_like
        [K], [percent], [m/s], [1]
    pressure : float or (n,) array_like, optional
        [Pa]; None takes that of the atmospheric state.
    """
    air_temperature = np.asarray(air_temperature, float)
    vapour = np.asarray(relative_humidity) / 100.0 * saturation_pressure(air_temperature)
    period = None if hours[0] < 0 and hours[-1] >= 24 else 24.0

    def through_the_day(values: npt.ArrayLike) -> Floats:
        series: Floats = np.interp(sun_hours(), hours, np.broadcast_to(values, np.shape(hours)), period=period)
        return series

    temperature = through_the_day(air_temperature)
    return NearSurfaceAir(
        altitude,
        temperature,
        np.minimum(through_the_day(vapour), saturation_pressure(temperature)),
        through_the_day(wind_speed),
        through_the_day(cloud_fraction),
        None if pressure is None else through_the_day(pressure),
        radiation,
    )


def air_temperature(sun: SunPath, low: float, high: float) -> Floats:
    """Air temperature through the day at `sun_hours()` [K], (SUN_STEPS,).

    A half cosine up from the lowest at sunrise to the highest two hours after the highest Sun, and one down again.
    Where the Sun does not rise or set the lowest is at the lowest Sun.

    References
    ----------
    de Wit (1978); compared with measurements by Reicosky et al. (1989), Agric. For. Meteorol. 46, 193-209.
    """
    elevation, hours = np.asarray(sun.solar_elevation), sun_hours()
    up = elevation > _HORIZON
    rising = np.flatnonzero(up & ~np.roll(up, 1))
    coldest = hours[rising[0]] if rising.size else hours[np.argmin(elevation)]
    warmest = hours[np.argmax(elevation)] + _WARMEST_AFTER_NOON
    rise = (warmest - coldest) % 24.0
    since = (hours - coldest) % 24.0
    phase = np.where(since < rise, since / rise, 1 + (since - rise) / (24.0 - rise))
    temperature: Floats = 0.5 * (high + low) - 0.5 * (high - low) * np.cos(np.pi * phase)
    return temperature
