"""Season of the ground from a weather file that contains a whole year."""

from __future__ import annotations

import datetime
from functools import lru_cache
from pathlib import Path

import numpy as np

from skyshine.mat.job.ground import GroundYear
from skyshine.mat.job.typical_years import YearFile, is_tmy3, read_year
from skyshine.mat.job.weather_files import local_seconds
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.ground_year import YEAR, annual_harmonic, damping, spans_year
from skyshine.mat.surface.weather_readings import WEATHER_COLUMNS, read_readings
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Diffusivity of soil where an EPW header gives none: 0.025 ft2/h, with which its temperatures were computed (EnergyPlus
# Auxiliary Programs, "Ground Temperatures" of the weather converter) [m^2 s^-1].
_DIFFUSIVITY = 0.025 * 0.3048**2 / 3600
_BEFORE_MONTH = np.cumsum([0, 31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30])  # days, of a year without 29 February
_MIDDLES = (np.arange(12) + 0.5) * YEAR / 12  # day of the middle of each month


def ground_of_file(file: Path, utc_offset_h: float) -> GroundYear:
    """The season of the ground by the air of a file's whole year.

    Parameters
    ----------
    file : Path
        EPW, TMY3, or CSV with dates.
    utc_offset_h : float
        Offset of the local clock from UTC [h].

    Raises
    ------
    InputError
        With file:line:column of what does not fit; the readings do not span a year.
    """
    return _ground_of_air(file, utc_offset_h, file.stat().st_mtime_ns)


@lru_cache(maxsize=4)  # all states of a series have one
def _ground_of_air(file: Path, utc_offset_h: float, changed_ns: int) -> GroundYear:
    year = _typical_year(file)
    days, celsius = _of_table(file, utc_offset_h) if year is None else _of_year(year)
    try:
        return _rounded(*annual_harmonic(days, celsius))
    except InputError as error:
        raise InputError(error.message, file=file) from None


def ground_of_header(file: Path) -> GroundYear:
    """The season of the ground by the shallowest ground temperatures in the header of an EPW file, at the surface.

    Raises
    ------
    InputError
        The file has none.
    """
    year = read_year(file, "EPW") if file.suffix.lower() == ".epw" else None
    if year is None or not year.ground:
        raise InputError("found no ground temperatures in its header; allowed: an EPW with some; take file", file=file)
    ground = min(year.ground, key=lambda profile: profile.depth)
    mean, amplitude, coldest = annual_harmonic(_MIDDLES, np.array(ground.by_month))
    lag = damping(ground.depth, ground.diffusivity or _DIFFUSIVITY)
    return _rounded(mean, amplitude * np.exp(lag), (coldest - lag * YEAR / (2 * np.pi) - 1.0) % YEAR + 1.0)


def is_whole_year(file: Path) -> bool:
    """Whether a file is a typical year, EPW or TMY3, that leaves out no twelfth of it."""
    year = _typical_year(file)
    return year is not None and spans_year(_of_year(year)[0])


def _typical_year(file: Path) -> YearFile | None:
    if file.suffix.lower() == ".epw":
        return read_year(file, "EPW")
    return read_year(file, "TMY3") if is_tmy3(file) else None


@lru_cache(maxsize=4)
def _of_year(year: YearFile) -> tuple[Floats, Floats]:
    """Day of the year, 1 on 1 January, and air temperature [Celsius] of all readings of a typical year.

    Raises
    ------
    InputError
        With file:line of a date that is none, or a wrong reading.
    """
    for line, _, month, day, hour, _ in year.readings:
        if not (1 <= month <= 12 and 1 <= day <= 31 and 0 <= hour <= 24):
            raise InputError(
                f"found month {month}, day {day}, hour {hour}; allowed: a time of a year; mend the date",
                file=year.file,
                line=line,
                column=1,
            )
    days = [_BEFORE_MONTH[month - 1] + day + (hour - 0.5) / 24 for _, _, month, day, hour, _ in year.readings]
    return np.array(days), year.values("air_temperature_c", range(len(days)))


def _of_table(file: Path, utc_offset_h: float) -> tuple[Floats, Floats]:
    """Day of the year and air temperature [Celsius] of a table with dates; of times of the day alone, the first day."""
    table = read_readings(file, WEATHER_COLUMNS, ["air_temperature"], lambda cell: local_seconds(cell, utc_offset_h))
    number, of_day = np.divmod(table.time / 86400.0, 1.0)
    dates = [datetime.date.fromordinal(max(int(day), 1)) for day in number]
    days = np.array([date.timetuple().tm_yday for date in dates]) + of_day
    return days, table.values["air_temperature"] - ZERO_CELSIUS


def _rounded(mean: float, amplitude: float, coldest: float) -> GroundYear:
    return GroundYear(mean_c=round(mean, 1), amplitude_c=round(amplitude, 1), coldest_day=round(coldest, 1))
