"""Weather histories of DIRSIG, in the form of THERM (``.wth``): two days of a local clock, without date and place.

The first line has the number of rows and their step [h]. A row has 13 numbers in columns of fixed width, between which
blanks may be missing: hour, air temperature [C], pressure [hPa], relative humidity [1], dew point [C], wind speed
[m/s], direct and diffuse sunlight, exposure of the sky, types of clouds and rain, rate and temperature of the rain.

The manual names the first line, the two days and the clock. The order of the columns is that of a published history,
whose humidity follows from its dew point; in every file that is tested. Its sunlight fits langley an hour and mW/cm2
as well, which differ by 16 %: it is left alone.

References
----------
Rochester Institute of Technology: DIRSIG manual, pages "wth" and "therm_weather". The history ``saw.wth`` of the
repository KevinKearney/protoDIRSIG.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather_readings import WEATHER_COLUMNS, Readings
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.errors import InputError

SUFFIX = ".wth"
COLUMNS = ("hour", "air_temperature", "pressure", "relative_humidity", "dew_point", "wind_speed")
UNITS = {"air_temperature": "C", "pressure": "hPa", "wind_speed": "m/s"}
NUMBERS = 13  # numbers of a row
NOTE = (
    "is read as a weather history of DIRSIG, its second day by the local clock; its sunlight, whose unit is not"
    " sure, exposure of the sky, clouds and rain are not read"
)
_NUMBER = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+|\d+)")
_DAY_H, _MOST_ROWS = 24.0, 10_000  # [h]; rows of a file
_HUMIDITY_ERROR = 0.1  # between the humidity and that of the dew point, half of the rows: over water or over ice


def read_history(file: Path) -> Readings:
    """Readings of the second day in seconds since its midnight, in SI and percent.

    Raises
    ------
    InputError
        With file:line of what is no history, or where humidity does not follow from the dew point.
    """
    lines = read_text(file).splitlines()
    step = _step(lines, file)
    rows: list[list[float]] = []
    for number, line in enumerate(lines[1:], 2):
        cells = _NUMBER.findall(line)
        if len(cells) != NUMBERS or _NUMBER.sub("", line).strip():
            raise InputError(f"found {len(cells)} numbers; allowed: {NUMBERS}", file=file, line=number)
        if abs(float(cells[0]) - step * len(rows)) > 0.01:
            raise InputError(f"found hour {cells[0]}; allowed: {step * len(rows):g}", file=file, line=number)
        rows.append([_value(name, cell, file, number) for name, cell in zip(COLUMNS, cells, strict=False)])
    table = np.array(rows, float)
    hour, air, pressure, humidity, dew, wind = table.T
    error = np.median(np.abs(saturation_pressure(dew) / saturation_pressure(air) - humidity))
    if not error <= _HUMIDITY_ERROR:
        raise InputError(
            f"has humidities in column 4 that differ by {error:.2f} from those of the dew points in column 5; allowed:"
            f" {_HUMIDITY_ERROR}; write humidity as a share of 1, or the weather as CSV",
            file=file,
        )
    second = np.flatnonzero((hour >= _DAY_H) & (hour < 2 * _DAY_H))
    values = {
        "air_temperature": air,
        "pressure": pressure,
        "relative_humidity": np.clip(100.0 * humidity, 0.0, 100.0),
        "wind_speed": wind,
    }
    return Readings(
        file,
        [int(row) + 2 for row in second],
        3600.0 * (hour[second] - _DAY_H),
        {name: column[second] for name, column in values.items()},
    )


def _step(lines: list[str], file: Path) -> float:
    """Hours between rows, of the first line, which must fit the number of rows and two days."""
    numbers = _NUMBER.findall(lines[0]) if lines else []
    count, step = (int(numbers[0]), float(numbers[1])) if len(numbers) == 2 and numbers[0].isdecimal() else (0, 0.0)
    if not 0 < step <= 1 or count > _MOST_ROWS or abs((count - 1) * step - 2 * _DAY_H) > 0.01:
        heading = lines[0][:40] if lines else ""
        raise InputError(
            f"found '{heading}'; allowed: the number of rows and their step in hours, two days with both ends: 193"
            " 0.25",
            file=file,
            line=1,
        )
    while lines and not lines[-1].strip():
        lines.pop()
    if len(lines) - 1 != count:
        raise InputError(f"found {len(lines) - 1} rows; allowed: {count}, as this line states", file=file, line=1)
    return step


def _value(name: str, cell: str, file: Path, line: int) -> float:
    """A number of a row in SI; humidity as a share."""
    if name == "hour":
        return float(cell)
    if name == "relative_humidity":
        value = float(cell)
        if not 0 <= value <= 1.05:
            raise InputError(f"{name}: found {cell}; allowed: 0 to 1, a share", file=file, line=line)
        return value
    column = "air_temperature" if name == "dew_point" else name
    try:
        return WEATHER_COLUMNS[column].to_si(cell, UNITS[column])
    except ValueError as error:
        raise InputError(f"{name}: {error}", file=file, line=line) from None
