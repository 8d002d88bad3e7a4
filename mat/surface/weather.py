"""Air near the ground through the day: from the day's extremes or from a table by hour, and carried to other
altitudes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.surface.balance import saturation_pressure
from skyshine.mat.surface.measured import MeasuredRadiation
from skyshine.mat.surface.site import Site, sun_hours

LAPSE_RATE = 6.5e-3  # K/m, ISO 2533
# Hours from the highest Sun to the highest air temperature: de Wit (1978), Simulation of Assimilation, Respiration and
# Transpiration of Crops, Pudoc: at 14 h solar time.
_WARMEST_AFTER_NOON = 2.0
_HORIZON = 0.0  # degree; the Sun counts as up above it


@dataclass(frozen=True, eq=False)
class Weather:
    """Air near the ground through the day; arrays are (SUN_STEPS,), at `sun_hours()`.

    Attributes
    ----------
    altitude : float
        At which the air is described [m].
    air_temperature : ndarray
        [K]
    vapour_pressure : ndarray
        [Pa]
    wind_speed : ndarray
        At 10 m above the ground [m/s].
    cloud_fraction : ndarray
        0 to 1.
    pressure : ndarray or None
        [Pa]; None takes that of the atmospheric state.
    radiation : MeasuredRadiation or None
        None takes sunlight and sky longwave of the atmospheric state.
    """

    altitude: float
    air_temperature: np.ndarray
    vapour_pressure: np.ndarray
    wind_speed: np.ndarray
    cloud_fraction: np.ndarray
    pressure: np.ndarray | None = None
    radiation: MeasuredRadiation | None = None

    def at(self, altitude: np.ndarray, pressure: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Air temperature [K], vapour pressure and pressure [Pa] over surfaces at other altitudes.

        Parameters
        ----------
        altitude : (A,) ndarray
            [m]
        pressure : (A + 1,) ndarray
            Of the atmospheric state [Pa] at these altitudes and, last, at the altitude of the weather.

        Returns
        -------
        tuple of ndarray
            Each (A, SUN_STEPS); pressure (A, 1) where it does not change. The air cools by 6.5 K/km upwards and keeps
            its mixing ratio to saturation; measured pressure shifts the state's by one factor.
        """
        temperature = self.air_temperature - LAPSE_RATE * (np.asarray(altitude, float)[:, None] - self.altitude)
        ratio = (pressure[:-1] / pressure[-1])[:, None]
        own = pressure[-1] if self.pressure is None else self.pressure
        vapour = np.minimum(self.vapour_pressure * ratio, saturation_pressure(temperature))
        return temperature, vapour, own * ratio


def from_extremes(
    site: Site,
    low: float,
    high: float,
    relative_humidity: float,
    wind_speed: float,
    cloud_fraction: float,
) -> Weather:
    """The weather of a day with these lowest and highest air temperatures [K].

    Humidity [percent] holds at their mean; the vapour pressure is constant but where the air is saturated.
    """
    temperature = air_temperature(site, low, high)
    vapour = relative_humidity / 100.0 * saturation_pressure(0.5 * (low + high))
    return Weather(
        site.altitude,
        temperature,
        np.minimum(vapour, saturation_pressure(temperature)),
        *(np.full_like(temperature, value) for value in (wind_speed, cloud_fraction)),
    )


def from_hours(
    altitude: float,
    hours: np.ndarray,
    air_temperature: np.ndarray,
    relative_humidity: np.ndarray,
    wind_speed: np.ndarray,
    cloud_fraction: np.ndarray,
    pressure: np.ndarray | None = None,
    radiation: MeasuredRadiation | None = None,
) -> Weather:
    """The weather of a table by local clock hours (n,), linear between them and periodic; K, percent, m/s, 1, Pa."""
    air_temperature = np.asarray(air_temperature, float)
    vapour = np.asarray(relative_humidity) / 100.0 * saturation_pressure(air_temperature)

    def through_the_day(values):
        return np.interp(sun_hours(), hours, np.broadcast_to(values, np.shape(hours)), period=24.0)

    series = [through_the_day(values) for values in (air_temperature, vapour, wind_speed, cloud_fraction)]
    series[1] = np.minimum(series[1], saturation_pressure(series[0]))
    return Weather(altitude, *series, None if pressure is None else through_the_day(pressure), radiation)


def air_temperature(site: Site, low: float, high: float) -> np.ndarray:
    """Air temperature through the day at `sun_hours()` [K], (SUN_STEPS,).

    A half cosine up from the lowest at sunrise to the highest two hours after the highest Sun, and one down again.
    Where the Sun does not rise or set the lowest is at the lowest Sun.

    References
    ----------
    de Wit (1978); compared with measurements by Reicosky et al. (1989), Agric. For. Meteorol. 46, 193-209.
    """
    elevation, hours = np.asarray(site.solar_elevation), sun_hours()
    up = elevation > _HORIZON
    rising = np.flatnonzero(up & ~np.roll(up, 1))
    coldest = hours[rising[0]] if rising.size else hours[np.argmin(elevation)]
    warmest = hours[np.argmax(elevation)] + _WARMEST_AFTER_NOON
    rise = (warmest - coldest) % 24.0
    since = (hours - coldest) % 24.0
    phase = np.where(since < rise, since / rise, 1 + (since - rise) / (24.0 - rise))
    return 0.5 * (high + low) - 0.5 * (high - low) * np.cos(np.pi * phase)
