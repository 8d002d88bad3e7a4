"""Measured radiation and weather at equal steps, as the forcing of one column over the whole record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN, ZERO_CELSIUS
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.convection import AIR_HEIGHT, STANDARD_PRESSURE, WIND_HEIGHT
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather import Wetting
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# m, ISO 2533: where temperature stops falling and where it rises again, and R T / (M g) at 216.65 K between them.
_TROPOPAUSE, _HIGHEST, _SCALE_HEIGHT = 11e3, 20e3, 6341.6


@dataclass(frozen=True, eq=False)
class Record:
    """A weather record at equal steps, in SI units; all arrays (N,).

    Attributes
    ----------
    start : numpy.datetime64
        Time of the first step (UTC).
    step : float
        [s]; the record repeats after N steps.
    values : dict of str to ndarray
        "lw_down", and "sw_down" or "direct_normal" and "diffuse" or all three [W m^-2], "air_temperature" [K],
        "relative_humidity" [percent], "wind_speed" [m/s], "pressure" [Pa], "wind_height" and "air_height" [m]; by
        choice "rain" [mm/h], "soil_moisture" [m3/m3], "albedo" [1] or "snow_age" [d]. Negative readings of sunlight are
        0, humidity is at most 100.
    notes : tuple of str
        What is taken for what was not measured.
    """

    start: np.datetime64
    step: float
    values: dict[str, Floats]
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, seconds: Floats, values: Mapping[str, Floats], altitude: float = 0.0) -> Record:
        """The record of readings at their median step, linear between them; rain is a mean since the reading before.

        Parameters
        ----------
        seconds : (n,) ndarray
            Increasing, since 1970.
        values : mapping of str to (n,) ndarray
            Measured values as in `Record.values`, and "cloud_fraction". Heights are by default those of WMO-No. 8,
            pressure that of ISO 2533, longwave that of `sky_longwave`.
        altitude : float
            Altitude of the site [m].
        """
        step, steps = equal_steps(seconds)
        grid = seconds[0] + step * np.arange(steps)
        series = {name: np.interp(grid, seconds, readings) for name, readings in values.items()}
        if "rain" in values:
            series["rain"] = _interval_means(grid, seconds, values["rain"])
        series = {"wind_height": np.full(steps, WIND_HEIGHT), "air_height": np.full(steps, AIR_HEIGHT)} | series
        for name in ("sw_down", "direct_normal", "diffuse"):
            if name in series:
                series[name] = np.maximum(series[name], 0.0)
        series["relative_humidity"] = np.minimum(series["relative_humidity"], 100.0)
        notes = []
        if "pressure" not in series:
            pressure = standard_pressure(altitude)
            series["pressure"] = np.full(steps, pressure)
            notes.append(f"no pressure: {pressure / 100:.0f} hPa is taken, that of ISO 2533 at {altitude:g} m")
        cloud = series.pop("cloud_fraction", None)
        if "lw_down" not in series:
            temperature = series["air_temperature"]
            vapour = series["relative_humidity"] / 100.0 * saturation_pressure(temperature)
            series["lw_down"] = sky_longwave(temperature, vapour, np.zeros(steps) if cloud is None else cloud)
            sky = "a clear sky" if cloud is None else "its cloud_fraction"
            notes.append(f"no lw_down: that of the air near the ground under {sky} is taken (Prata 1996)")
        return cls(np.datetime64(round(1e3 * seconds[0]), "ms"), step, series, tuple(notes))

    @property
    def times(self) -> npt.NDArray[np.datetime64]:
        """(N,) datetime64[ms], UTC."""
        times: npt.NDArray[np.datetime64] = self.start + np.round(1e3 * self.step * np.arange(self.steps)).astype(
            "timedelta64[ms]"
        )
        return times

    @property
    def wetting(self) -> Wetting:
        """What of it the skin of a surface needs to know beforehand."""
        moisture = self.values.get("soil_moisture")
        frost = max(ZERO_CELSIUS - float(np.mean(self.values["air_temperature"])), 0.0)
        return Wetting("rain" in self.values, None if moisture is None else float(np.mean(moisture)), frost)

    @property
    def steps(self) -> int:
        """N."""
        return len(self.values["air_temperature"])

    @property
    def period(self) -> float:
        """[s]"""
        return self.step * self.steps

    def after_first_day(self, times: int) -> Record:
        """The record after its first day, so many times over; it is longer than a day."""
        day = round(86400.0 / self.step)
        start = self.start - np.timedelta64(round(1e3 * times * day * self.step), "ms")
        values = {name: np.concatenate([np.tile(series[:day], times), series]) for name, series in self.values.items()}
        return replace(self, start=start, values=values)

    def refined(self, factor: int) -> Record:
        """The record at `factor` times as many steps, linear between its own and periodic at its end."""
        grid = np.arange(self.steps * factor) / factor
        at = np.arange(self.steps + 1)
        values = {name: np.interp(grid, at, np.append(series, series[0])) for name, series in self.values.items()}
        return replace(self, step=self.step / factor, values=values)


def standard_pressure(altitude: float) -> float:
    """Pressure of ISO 2533 [Pa] at an altitude of up to 20 km [m].

    Raises
    ------
    InputError
        It is higher.

    Examples
    --------
    The tables have 226.32 hPa at 11 km and 54.75 hPa at 20 km:

    >>> round(standard_pressure(11e3)), round(standard_pressure(20e3))
    (22632, 5475)
    """
    if altitude > _HIGHEST:
        raise InputError(
            f"found no pressure at {altitude / 1e3:g} km; allowed: without it to {_HIGHEST / 1e3:g} km, as high as its"
            " standard law goes; add a column pressure (0 is a vacuum)"
        )
    lower = STANDARD_PRESSURE * (1 - 0.0065 * min(altitude, _TROPOPAUSE) / 288.15) ** 5.25588
    return float(lower * np.exp(-max(altitude - _TROPOPAUSE, 0.0) / _SCALE_HEIGHT))


def _interval_means(grid: Floats, seconds: Floats, means: Floats) -> Floats:
    """Means over the steps that end at `grid`, of means over the intervals that end at `seconds`: none is lost."""
    total = np.concatenate(([0.0], np.cumsum(means[1:] * np.diff(seconds))))
    initial = means[:1]
    later: Floats = np.diff(np.interp(grid, seconds, total)) / np.diff(grid)
    return np.concatenate([initial, later])


def sky_longwave(air_temperature: Floats, vapour_pressure: Floats, cloud_fraction: Floats) -> Floats:
    """Longwave irradiance of the sky on level ground, from the air near the ground.

    Parameters
    ----------
    air_temperature, vapour_pressure, cloud_fraction : (N,) ndarray
        [K], [Pa], [1]

    Returns
    -------
    (N,) ndarray
        [W m^-2]; within some 20 of measurements.

    References
    ----------
    Clear sky: Prata (1996), Q. J. R. Meteorol. Soc. 122, 1127-1151. Cloud as `skyshine.mat.surface.forcing.Sky` has it:
    Unsworth and Monteith (1975), ibid. 101, 13-24.
    """
    water = 0.465 * vapour_pressure / air_temperature  # precipitable water [g cm^-2]: 46.5 e / T with e in hPa
    emissivity = 1 - (1 + water) * np.exp(-np.sqrt(1.2 + 3.0 * water))
    emissivity = (1 - 0.84 * cloud_fraction) * emissivity + 0.84 * cloud_fraction
    longwave: Floats = emissivity * STEFAN_BOLTZMANN * air_temperature**4
    return longwave


def equal_steps(seconds: Floats) -> tuple[float, int]:
    """Median step [s] of increasing times (n,) [s], and the number of such steps that a record of them has."""
    step = float(np.median(np.diff(seconds)))
    return step, round((seconds[-1] - seconds[0]) / step) + 1


def record_forcing(
    record: Record,
    shortwave: tuple[Floats, Floats, Floats],
    slope: float,
    surroundings: Surroundings | None = None,
    sun_cosine: Floats | None = None,
) -> Forcing:
    """Forcing of one column from a record.

    Parameters
    ----------
    shortwave : tuple of (N,) ndarray
        Direct, diffuse and ground-reflected irradiance on the plane [W m^-2].
    slope : float
        [degree]
    surroundings : Surroundings, optional
        Its wall changes the longwave; its shade must be in `shortwave`.
    sun_cosine : (N,) ndarray, optional
        Cosine as in `Forcing`.

    Returns
    -------
    Forcing
        (1, N); ground in view of a slope radiates as a black body at air temperature.
    """
    values = record.values
    cosine = np.cos(np.radians(slope))
    view = 0.5 * (1 + cosine)
    temperature = values["air_temperature"]
    sky, ground = view * values["lw_down"], (1 - view) * STEFAN_BOLTZMANN * temperature**4
    if surroundings is not None:
        sky, ground = surroundings.longwave(view, values["lw_down"], temperature)
    direct, diffuse, reflected = (np.atleast_2d(part) for part in shortwave)
    return Forcing(
        shortwave_direct=direct,
        shortwave_diffuse=diffuse,
        shortwave_reflected=reflected,
        longwave_sky=np.atleast_2d(sky),
        longwave_ground=np.atleast_2d(ground),
        air_temperature=np.atleast_2d(temperature),
        vapour_pressure=np.atleast_2d(values["relative_humidity"] / 100.0 * saturation_pressure(temperature)),
        pressure=np.atleast_2d(values["pressure"]),
        wind_speed=np.atleast_2d(values["wind_speed"]),
        cos_slope=np.array([[cosine]]),
        wind_height=np.atleast_2d(values["wind_height"]),
        air_height=np.atleast_2d(values["air_height"]),
        sun_cosine=None if sun_cosine is None else np.atleast_2d(sun_cosine),
        rain=np.atleast_2d(values["rain"]) / 3600.0 if "rain" in values else None,
        **{name: np.atleast_2d(values[name]) for name in ("soil_moisture", "albedo", "snow_age") if name in values},
    )
