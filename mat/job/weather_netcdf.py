"""Weather of a point, or of the nearest of many, by time out of ERA5 and other models in netCDF.

References
----------
ECMWF, ERA5: data documentation, tables 2 to 4: names, units, and that accumulations are of the hour before.
"""

from __future__ import annotations

from datetime import UTC
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.soundings.netcdf import opened
from skyshine.mat.job.site import great_circle
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
_TIMES, _PLACES = ("valid_time", "time"), ("latitude", "lat", "longitude", "lon")
_HOUR = 3600.0


def read_point(
    file: Path, place: tuple[float, float] | None = None
) -> tuple[Readings, tuple[float, float] | None, tuple[str, ...]]:
    """Readings in seconds since 1970 [UTC], latitude and longitude [degree] where the file has them, and notes.

    Parameters
    ----------
    place : (float, float), optional
        Latitude and longitude [degree]: of a file of many points the nearest that has temperatures is read.

    Raises
    ------
    InputError
        It is no netCDF that can be read, lacks temperature or time, or contains many places where none is asked for.
    """
    return _read_once(file, place, file.stat().st_mtime_ns)


@lru_cache(maxsize=4)  # all states of a series have one
def _read_once(
    file: Path, place: tuple[float, float] | None, changed_ns: int
) -> tuple[Readings, tuple[float, float] | None, tuple[str, ...]]:
    with opened(file) as data:
        return _read(data, file, place)


def _read(
    data: Any, file: Path, place: tuple[float, float] | None
) -> tuple[Readings, tuple[float, float] | None, tuple[str, ...]]:
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
    point, position, notes = _nearest(data, clock, place)
    values: dict[str, Floats] = {}
    for name, (quantity, factor) in VARIABLES.items():
        if name in data.variables:
            values[quantity] = _series(data.variables[name], clock, point, file) * factor
    if np.any(np.abs(np.diff(time) - _HOUR) > 1.0):
        for quantity in ("sw_down", "lw_down", "rain"):  # whose sums are of another time than an hour
            if values.pop(quantity, None) is not None:
                notes.append(f"has {quantity} as sums at steps that are no hours; not read")
    return Readings(file, [0] * len(time), time, _checked(values, file)), position, tuple(notes)


def _nearest(
    data: Any, clock: str, place: tuple[float, float] | None
) -> tuple[dict[str, int], tuple[float, float] | None, list[str]]:
    """Indices by dimension of the point nearest to a place, among those with a temperature at the first time; its
    latitude and longitude; what is read, in words.
    """
    names = [name for name in _PLACES if name in data.variables]
    if len(names) != 2:
        return {}, None, ["is read as ERA5 of a point, by UTC"]
    coordinates: list[Floats] = [np.ma.filled(np.ma.asarray(data.variables[name][:], float), np.nan) for name in names]
    latitude, longitude = coordinates
    if place is None or latitude.size * longitude.size == 1 or not {*names} <= {*data.variables["t2m"].dimensions}:
        return {}, (float(latitude.flat[0]), float(longitude.flat[0])), ["is read as ERA5 of a point, by UTC"]
    variable = data.variables["t2m"]
    dimensions = [name for name in variable.dimensions if name in names]
    selection = tuple(
        slice(None) if name in names else 0 for name in variable.dimensions
    )  # the first time, and the first of any other axis
    present = np.isfinite(np.ma.filled(np.ma.asarray(variable[selection], float), np.nan))
    if dimensions != names:
        present = present.T
    distance = np.array(
        [[great_circle(*place, row, (column + 180) % 360 - 180) for column in longitude] for row in latitude]
    )
    if not present.any():
        return dict.fromkeys(names, 0), (float(latitude[0]), float(longitude[0])), []
    i, j = np.unravel_index(int(np.argmin(np.where(present, distance, np.inf))), distance.shape)
    found = float(latitude[i]), float((longitude[j] + 180) % 360 - 180)
    words = f"is read at its nearest point, latitude {found[0]:g}, longitude {found[1]:g}, by UTC"
    return {names[0]: int(i), names[1]: int(j)}, found, [words]


def _series(variable: Any, clock: str, point: dict[str, int], file: Path) -> Floats:
    """Values (n,) of a variable at a point; NaN where they are missing."""
    sizes = dict(zip(variable.dimensions, variable.shape, strict=True))
    if any(size != 1 for name, size in sizes.items() if name != clock and name not in point):
        raise InputError(
            f"{variable.name}: found {' x '.join(f'{size} {name}' for name, size in sizes.items())}; allowed: one"
            " place, or latitude and longitude alone; cut the nearest out, as `cdo remapnn,lon=LON/lat=LAT` does",
            file=file,
        )
    selection = tuple(point.get(name, slice(None)) for name in variable.dimensions)
    return np.ma.filled(np.ma.asarray(variable[selection], float), np.nan).reshape(-1)


def _checked(values: dict[str, Floats], file: Path) -> dict[str, Floats]:
    """Quantities of `WEATHER_COLUMNS` within the limits of the Earth."""
    if "eastward" in values and "northward" in values:
        values["wind_speed"] = np.hypot(values.pop("eastward"), values.pop("northward"))
    if "dew_point" in values:
        ratio = saturation_pressure(values.pop("dew_point")) / saturation_pressure(values["air_temperature"])
        values["relative_humidity"] = np.minimum(100.0 * ratio, 100.0)
    values = {name: column_values for name, column_values in values.items() if name in WEATHER_COLUMNS}
    for name in ("sw_down", "rain", "cloud_fraction"):
        if name in values:
            values[name] = np.maximum(values[name], 0.0)  # negative values of rounding in packed files
    for name, column_values in values.items():
        column = WEATHER_COLUMNS[name]
        wrong = column_values[(column_values < column.low) | (column_values > column.high + 1e-6)]
        if wrong.size:
            raise InputError(
                f"{name}: found {wrong[0]:g}; allowed: {column.low:g} to {column.high:g}; check its unit", file=file
            )
    return values
