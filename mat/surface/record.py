"""Measured radiation and weather from a CSV file, as the forcing of one column over the whole record."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.balance import Forcing, saturation_pressure
from skyshine.schemas.csv_table import cells as line_cells
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.errors import InputError, nearest

# Column names with the units each may carry in brackets, as (factor, offset) to SI; the first is the default.
COLUMNS: dict[str, dict[str, tuple[float, float]]] = {
    "sw_down": {"W/m2": (1.0, 0.0)},
    "lw_down": {"W/m2": (1.0, 0.0)},
    "air_temperature": {"K": (1.0, 0.0), "C": (1.0, 273.15), "F": (5 / 9, 459.67 * 5 / 9)},
    "relative_humidity": {"%": (1.0, 0.0), "percent": (1.0, 0.0), "1": (100.0, 0.0)},
    "wind_speed": {"m/s": (1.0, 0.0), "km/h": (1 / 3.6, 0.0), "kt": (1852 / 3600, 0.0)},
    "pressure": {"Pa": (1.0, 0.0), "hPa": (100.0, 0.0), "kPa": (1000.0, 0.0)},
}
# What a value may be after conversion to SI: wide enough for any place on Earth, narrow enough to catch another unit.
# Thermopile pyranometers read a few W m^-2 below zero at night (thermal offset, BSRN: McArthur 2005, WMO/TD-No. 1274).
LIMITS = {
    "sw_down": (-25.0, 2000.0),
    "lw_down": (20.0, 800.0),
    "air_temperature": (150.0, 350.0),
    "relative_humidity": (0.0, 120.0),
    "wind_speed": (0.0, 120.0),
    "pressure": (0.0, 120e3),
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
    text = read_text(file)
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if len(lines) < 5:
        raise InputError(f"found {max(len(lines) - 1, 0)} readings; allowed: a header and at least 4", file=file)
    place, units = _header(file, *lines[0])
    rows = [_row(file, number, line, place, units) for number, line in lines[1:]]
    seconds = np.array([row[0] for row in rows])
    later = np.diff(seconds)
    if np.any(later <= 0):
        wrong = int(np.argmax(later <= 0)) + 1
        raise InputError(
            "found a time that is not after the one before; allowed: increasing times; sort the file",
            file=file,
            line=lines[wrong + 1][0],
            column=1,
        )
    if np.any(later > MAXIMUM_GAP):
        wrong = int(np.argmax(later > MAXIMUM_GAP)) + 1
        raise InputError(
            f"found a gap of {later[wrong - 1] / 3600:.1f} h before this reading; allowed: {MAXIMUM_GAP / 3600:g} h; "
            "fill it or use a shorter record",
            file=file,
            line=lines[wrong + 1][0],
            column=1,
        )
    return _equal_steps(file, seconds, {name: np.array([row[1][name] for row in rows]) for name in COLUMNS})


def _header(file: Path, number: int, line: str) -> tuple[dict[str, int], dict[str, tuple[float, float]]]:
    """Index of each column, and the conversion of each value."""
    place, units = {}, {}
    for index, (cell, column) in enumerate(line_cells(line)):
        name, _, unit = cell.partition("[")
        name, unit = name.strip(), unit.rstrip("] ").strip()

        def refuse(message: str, column=column) -> InputError:
            return InputError(message, file=file, line=number, column=column)

        if name != "time" and name not in COLUMNS:
            raise refuse(f"found the column '{name}'; {nearest(name, ['time', *COLUMNS])}")
        if name in place:
            raise refuse(f"found the column '{name}' twice; allowed: once; remove one")
        place[name] = index
        if name != "time":
            choices = COLUMNS[name]
            if unit and unit not in choices:
                raise refuse(f"found the unit '{unit}' of {name}; {nearest(unit, choices)}")
            units[name] = choices[unit] if unit else next(iter(choices.values()))
    missing = [name for name in ["time", *COLUMNS] if name not in place]
    if missing:
        raise InputError(f"the column '{missing[0]}' is missing; add it", file=file, line=number, column=1)
    return place, units


def _row(file: Path, number: int, line: str, place: dict, units: dict) -> tuple[float, dict[str, float]]:
    """Seconds since 1970 and the values in SI of a line."""
    cells = line_cells(line)
    if len(cells) != len(place):
        raise InputError(
            f"found {len(cells)} cells; allowed: {len(place)}, one for each column", file=file, line=number, column=1
        )
    values = {}
    for name, (factor, offset) in units.items():
        cell, column = cells[place[name]]
        low, high = LIMITS[name]
        try:
            value = float(cell) * factor + offset
        except ValueError:
            value = np.nan
        if not low <= value <= high:
            unit = next(iter(COLUMNS[name]))
            raise InputError(
                f"{name}: found '{cell}'; allowed: numbers worth {low:g} to {high:g} {unit}; mend or remove the line",
                file=file,
                line=number,
                column=column,
            )
        values[name] = value
    cell, column = cells[place["time"]]
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        raise InputError(
            f"time: found '{cell}'; allowed: ISO 8601 such as 2016-01-01T13:30:00Z",
            file=file,
            line=number,
            column=column,
        ) from None
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    return moment.timestamp(), values


def _equal_steps(file: Path, seconds: np.ndarray, values: dict[str, np.ndarray]) -> Record:
    step = float(np.median(np.diff(seconds)))
    steps = int(round((seconds[-1] - seconds[0]) / step)) + 1
    if steps > MAXIMUM_STEPS:
        raise InputError(f"found {steps} steps; allowed: {MAXIMUM_STEPS}; average the record or cut it", file=file)
    grid = seconds[0] + step * np.arange(steps)
    equal = {name: np.interp(grid, seconds, series) for name, series in values.items()}
    equal["sw_down"] = np.maximum(equal["sw_down"], 0.0)
    equal["relative_humidity"] = np.minimum(equal["relative_humidity"], 100.0)
    start = np.datetime64(int(round(1e3 * seconds[0])), "ms")
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
