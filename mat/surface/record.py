"""Measured radiation and weather from a CSV file, as the forcing of one column over the whole record."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.balance import Forcing, saturation_pressure
from skyshine.mat.surface.weather_readings import AIR_COLUMNS, Column, read_readings
from skyshine.schemas.errors import InputError

# Thermopile pyranometers read a few W m^-2 below zero at night (thermal offset, BSRN: McArthur 2005, WMO/TD-No. 1274).
COLUMNS = {
    "sw_down": Column({"W/m2": (1.0, 0.0)}, -25.0, 2000.0),
    "lw_down": Column({"W/m2": (1.0, 0.0)}, 20.0, 800.0),
    **AIR_COLUMNS,
}
MAXIMUM_GAP = 3 * 3600.0  # s that linear interpolation may bridge
MAXIMUM_STEPS = 200_000


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
        By the names of `COLUMNS`; negative pyranometer readings are 0, humidity is at most 100.
    """

    start: np.datetime64
    step: float
    values: dict[str, np.ndarray]

    @property
    def times(self) -> np.ndarray:
        """(N,) datetime64[ms], UTC."""
        return self.start + np.round(1e3 * self.step * np.arange(self.steps)).astype("timedelta64[ms]")

    @property
    def steps(self) -> int:
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


def read_record(file: str | os.PathLike) -> Record:
    """Read a forcing CSV and bring it to equal steps.

    Parameters
    ----------
    file : path
        Columns time (ISO 8601; UTC where it names no zone) and all of `COLUMNS`, in any order; ``name[unit]`` in the
        header names another unit. Empty lines and lines that begin with # are skipped.

    Returns
    -------
    Record
        At the file's own median step; between readings linear.

    Raises
    ------
    InputError
        With file:line:column of what does not fit.
    """
    file = Path(file)
    table = read_readings(file, COLUMNS, COLUMNS, _moment)
    table.refuse_gaps(np.diff(table.time), MAXIMUM_GAP)
    return _equal_steps(file, table.time, table.values)


def _moment(cell: str) -> float:
    """Seconds since 1970 of an ISO 8601 time; ValueError says what was found and what is allowed."""
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        raise ValueError(f"found '{cell}'; allowed: ISO 8601 such as 2016-01-01T13:30:00Z") from None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _equal_steps(file: Path, seconds: np.ndarray, values: dict[str, np.ndarray]) -> Record:
    step = float(np.median(np.diff(seconds)))
    steps = round((seconds[-1] - seconds[0]) / step) + 1
    if steps > MAXIMUM_STEPS:
        raise InputError(f"found {steps} steps; allowed: {MAXIMUM_STEPS}; average the record or cut it", file=file)
    grid = seconds[0] + step * np.arange(steps)
    equal = {name: np.interp(grid, seconds, series) for name, series in values.items()}
    equal["sw_down"] = np.maximum(equal["sw_down"], 0.0)
    equal["relative_humidity"] = np.minimum(equal["relative_humidity"], 100.0)
    start = np.datetime64(round(1e3 * seconds[0]), "ms")
    return Record(start, step, equal)


def record_forcing(record: Record, shortwave, slope: float) -> Forcing:
    """Forcing of one column from a record.

    Parameters
    ----------
    record : Record
    shortwave : tuple of (N,) ndarray
        Direct, diffuse and ground-reflected irradiance on the plane [W m^-2].
    slope : float
        [degree]

    Returns
    -------
    Forcing
        (1, N); ground in view of a slope radiates as a black body at air temperature.
    """
    values = record.values
    cosine = np.cos(np.radians(slope))
    view = 0.5 * (1 + cosine)
    temperature = values["air_temperature"]
    return Forcing(
        *(np.atleast_2d(part) for part in shortwave),
        longwave_sky=np.atleast_2d(view * values["lw_down"]),
        longwave_ground=np.atleast_2d((1 - view) * Stefan_Boltzmann * temperature**4),
        air_temperature=np.atleast_2d(temperature),
        vapour_pressure=np.atleast_2d(values["relative_humidity"] / 100.0 * saturation_pressure(temperature)),
        pressure=np.atleast_2d(values["pressure"]),
        wind_speed=np.atleast_2d(values["wind_speed"]),
        cos_slope=np.array([[cosine]]),
    )
