"""Weather of a point by time out of ERA5 and other models in netCDF.

References
----------
ECMWF, ERA5: data documentation, tables 2 to 4: names, units, and that accumulations are of the hour before.
"""

from __future__ import annotations

from datetime import UTC
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.soundings.netcdf import opened
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather_readings import WEATHER_COLUMNS, Readings
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# By variable: quantity in SI, and its factor from the file's unit.
VARIABLES = {
    "t2m": ("air_temperature", 1.0),
    "d2m": ("dew_point", 1.0),
    "sp": ("pressure", 1.0),
    "tcc": ("cloud_fraction", 1.0),
    "u10": ("eastward", 1.0),
    "v10": ("northward", 1.0),
    "ssrd": ("sw_down", 1 / 3600.0),
    "strd": ("lw_down", 1 / 3600.0),
    "tp": ("rain", 1000.0),
}
_TIMES, _PLACES = ("valid_time", "time"), ("latitude", "longitude", "lat", "lon")
_HOUR = 3600.0


def read_point(file: Path) -> tuple[Readings, tuple[float, float] | None, tuple[str, ...]]:
    """Readings in seconds since 1970 [UTC], latitude and longitude [degree] where the file has them, and notes.

    Raises
    ------
    InputError
        It is no netCDF that can be read, contains more than one place, or lacks temperature or time.
    """
    with opened(file) as data:
        return _read(data, file)


def _read(data: Any, file: Path) -> tuple[Readings, tuple[float, float] | None, tuple[str, ...]]:
    import netCDF4

    clock = next((name for name in _TIMES if name in data.variables), None)
    if clock is None or "t2m" not in data.variables:
        raise InputError(
            f"has the variables {', '.join(data.variables)[:120]}; allowed: t2m over time; download 2m_temperature too",
            file=file,
        )
    axis = data.variables[clock]
    moments: Any = netCDF4.num2date(
        axis[:], axis.units, getattr(axis, "calendar", "standard"), only_use_cftime_datetimes=False
    )
    time = np.array([moment.replace(tzinfo=UTC).timestamp() for moment in np.atleast_1d(moments)])
    values: dict[str, Floats] = {}
    for name, (quantity, factor) in VARIABLES.items():
        if name in data.variables:
            values[quantity] = _series(data.variables[name], clock, file) * factor
    notes = ["is read as ERA5 of a point, by UTC"]
    if np.any(np.abs(np.diff(time) - _HOUR) > 1.0):
        for quantity in ("sw_down", "lw_down", "rain"):  # whose sums are of another time than an hour
            if values.pop(quantity, None) is not None:
                notes.append(f"has {quantity} as sums at steps that are no hours; not read")
    return Readings(file, [0] * len(time), time, _checked(values, file)), _place(data), tuple(notes)


def _series(variable: Any, clock: str, file: Path) -> Floats:
    """Values (n,) of a variable of one place; NaN where they are missing."""
    sizes = dict(zip(variable.dimensions, variable.shape, strict=True))
    if any(size != 1 for name, size in sizes.items() if name != clock):
        raise InputError(
            f"{variable.name}: found {' x '.join(f'{size} {name}' for name, size in sizes.items())}; allowed: one"
            " place; cut the nearest out, as `cdo remapnn,lon=LON/lat=LAT` does",
            file=file,
        )
    return np.ma.filled(np.ma.asarray(variable[:], float), np.nan).reshape(-1)


def _checked(values: dict[str, Floats], file: Path) -> dict[str, Floats]:
    """Quantities of `WEATHER_COLUMNS` within the limits that hold on Earth."""
    if "eastward" in values and "northward" in values:
        values["wind_speed"] = np.hypot(values.pop("eastward"), values.pop("northward"))
    if "dew_point" in values:
        ratio = saturation_pressure(values.pop("dew_point")) / saturation_pressure(values["air_temperature"])
        values["relative_humidity"] = np.minimum(100.0 * ratio, 100.0)
    values = {name: column_values for name, column_values in values.items() if name in WEATHER_COLUMNS}
    for name in ("sw_down", "rain", "cloud_fraction"):
        if name in values:
            values[name] = np.maximum(values[name], 0.0)  # of rounding in packed files
    for name, column_values in values.items():
        column = WEATHER_COLUMNS[name]
        wrong = column_values[(column_values < column.low) | (column_values > column.high + 1e-6)]
        if wrong.size:
            raise InputError(
                f"{name}: found {wrong[0]:g}; allowed: {column.low:g} to {column.high:g}; check its unit", file=file
            )
    return values


def _place(data: Any) -> tuple[float, float] | None:
    coordinates = [float(np.ravel(data.variables[name][:])[0]) for name in _PLACES if name in data.variables]
    return (coordinates[0], coordinates[1]) if len(coordinates) == 2 else None
