"""Measured radiation and weather at equal steps, as the forcing of one column over the whole record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.balance import Forcing
from skyshine.mat.surface.convection import AIR_HEIGHT, WIND_HEIGHT
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class Record:
    """A weather record at equal steps, in SI units; all arrays (N,).

    Attributes
    ----------
    start : numpy.datetime64
        Of the first step (UTC).
    step : float
        [s]; the record repeats after N steps.
    values : dict of str to ndarray
        "sw_down" and "lw_down" [W m^-2], "air_temperature" [K], "relative_humidity" [percent], "wind_speed" [m/s],
        "pressure" [Pa], "wind_height" and "air_height" [m]. Negative pyranometer readings are 0, humidity is at most
        100.
    """

    start: np.datetime64
    step: float
    values: dict[str, Floats]

    @classmethod
    def of(cls, seconds: Floats, values: Mapping[str, Floats]) -> Record:
        """The record of readings (n,) at increasing times since 1970 [s], linear between them, at their median step;
        heights that are not given are those of WMO-No. 8.
        """
        step, steps = equal_steps(seconds)
        grid = seconds[0] + step * np.arange(steps)
        series = {name: np.interp(grid, seconds, readings) for name, readings in values.items()}
        series = {"wind_height": np.full(steps, WIND_HEIGHT), "air_height": np.full(steps, AIR_HEIGHT)} | series
        series["sw_down"] = np.maximum(series["sw_down"], 0.0)
        series["relative_humidity"] = np.minimum(series["relative_humidity"], 100.0)
        return cls(np.datetime64(round(1e3 * seconds[0]), "ms"), step, series)

    @property
    def times(self) -> npt.NDArray[np.datetime64]:
        """(N,) datetime64[ms], UTC."""
        times: npt.NDArray[np.datetime64] = self.start + np.round(1e3 * self.step * np.arange(self.steps)).astype(
            "timedelta64[ms]"
        )
        return times

    @property
    def steps(self) -> int:
        """N."""
        return len(self.values["sw_down"])

    @property
    def period(self) -> float:
        """[s]"""
        return self.step * self.steps

    def refined(self, factor: int) -> Record:
        """The record at `factor` times as many steps, linear between its own and periodic at its end."""
        grid = np.arange(self.steps * factor) / factor
        at = np.arange(self.steps + 1)
        values = {name: np.interp(grid, at, np.append(series, series[0])) for name, series in self.values.items()}
        return Record(self.start, self.step / factor, values)


def equal_steps(seconds: Floats) -> tuple[float, int]:
    """Median step [s] of increasing times (n,) [s], and the number of such steps that a record of them has."""
    step = float(np.median(np.diff(seconds)))
    return step, round((seconds[-1] - seconds[0]) / step) + 1


def record_forcing(
    record: Record,
    shortwave: tuple[Floats, Floats, Floats],
    slope: float,
    surroundings: Surroundings | None = None,
) -> Forcing:
    """Forcing of one column from a record.

    Parameters
    ----------
    record : Record
    shortwave : tuple of (N,) ndarray
        Direct, diffuse and ground-reflected irradiance on the plane [W m^-2].
    slope : float
        [degree]
    surroundings : Surroundings, optional
        Its wall changes the longwave; its shade must be in `shortwave`.

    Returns
    -------
    Forcing
        (1, N); ground in view of a slope radiates as a black body at air temperature.
    """
    values = record.values
    cosine = np.cos(np.radians(slope))
    view = 0.5 * (1 + cosine)
    temperature = values["air_temperature"]
    sky, ground = view * values["lw_down"], (1 - view) * Stefan_Boltzmann * temperature**4
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
    )
