"""Columns of ERA5 and other gridded models in netCDF on pressure levels, by the CF conventions.

References
----------
NetCDF Climate and Forecast (CF) Metadata Conventions 1.11; ECMWF, ERA5: data documentation (names and units of `t`,
`q`, `r`, `z`, `o3`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.soundings.choice import FARTHEST_HOURS, Choice, hours, index_of, weights
from skyshine.mat.atmosphere.soundings.readings import Readings
from skyshine.mat.atmosphere.soundings.units import UNITS, to_si
from skyshine.mat.atmosphere.state.hydrostatics import DRY_AIR_MOLAR_MASS
from skyshine.mat.radiometry.constants import STANDARD_GRAVITY
from skyshine.schemas.arrays import Floats
from skyshine.schemas.column_names import unit_of
from skyshine.schemas.errors import InputError

_MAGIC = (b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02", b"CDF\x05")
# Names that a variable may have where it has no standard name, by quantity.
VARIABLES = {
    "temperature": ("air_temperature", "t", "ta", "temperature", "temp"),
    "specific_humidity": ("specific_humidity", "q", "hus", "qv", "shum"),
    "relative_humidity": ("relative_humidity", "r", "rh", "hur"),
    "mixing_ratio": ("humidity_mixing_ratio", "mixing_ratio"),
    "dew_point": ("dew_point_temperature", "td", "dew_point"),
    "geopotential": ("geopotential", "z", "phi"),
    "geopotential_height": ("geopotential_height", "zg", "gh", "hgt"),
    "altitude": ("altitude", "height"),
    "ozone": ("mass_fraction_of_ozone_in_air", "o3"),
}
_AXES = {
    "time": ("time", "valid_time", "t"),
    "pressure": ("air_pressure", "pressure_level", "level", "plev", "isobaricinhpa", "isobaric", "pressure", "lev"),
    "latitude": ("latitude", "lat"),
    "longitude": ("longitude", "lon"),
}
_UNITS = {
    "geopotential": {"m**2 s**-2": 1 / STANDARD_GRAVITY, "m2 s-2": 1 / STANDARD_GRAVITY, "m2/s2": 1 / STANDARD_GRAVITY},
    "ozone": {"kg kg**-1": 1.0, "kg kg-1": 1.0, "kg/kg": 1.0, "1": 1.0},
}
_SPELLINGS = {"kg kg**-1": "kg/kg", "kg kg-1": "kg/kg", "millibars": "mbar", "millibar": "mbar", "kelvin": "K", "": ""}
_ALL = slice(None)
OZONE_MOLAR_MASS = 47.9982e-3  # kg mol^-1 (IUPAC 2018)
MOST_LEVELS, MOST_NODES = 1000, 2_000_000  # sizes of a column, and of an axis of the grid


def is_netcdf(file: Path) -> bool:
    """Whether a file begins as netCDF does."""
    with file.open("rb") as stream:
        return stream.read(8).startswith(_MAGIC)


def times_in(file: Path) -> list[datetime | None]:
    """Times of the columns of a file.

    Raises
    ------
    InputError
        As `read_column`.
    """
    with opened(file) as data:
        temperature = _find(data, file, "temperature")
        return _times(data, _axes(data, temperature, file), file)


def read_column(file: Path, choice: Choice) -> Readings:
    """The column of a file at a place and time.

    Raises
    ------
    InputError
        It cannot be read, lacks temperature, humidity, geopotential or an axis, names an unknown unit, contains several
        places or times and none is chosen, or the place lies outside its grid.
    """
    with opened(file) as data:
        temperature = _find(data, file, "temperature")
        axes = _axes(data, temperature, file)
        times = _times(data, axes, file)
        at: dict[str, dict[int, float]] = {}
        time = None
        if "time" in axes:
            at[axes["time"]] = _at_time(times, choice, file)
            time = choice.time if len(at[axes["time"]]) > 1 else times[next(iter(at[axes["time"]]))]
        at |= _at_place(data, axes, choice, file)
        values = {"pressure": _pressure(data, axes["pressure"], file)}
        for name in VARIABLES:
            variable = _variable(data, name)
            if variable is not None and axes["pressure"] in variable.dimensions:
                values[name] = _in_si(file, name, variable, _column(file, variable, axes["pressure"], at))
    if "geopotential" in values:
        values["geopotential_height"] = values.pop("geopotential")
    if "ozone" in values:
        values["O3"] = values.pop("ozone") * DRY_AIR_MOLAR_MASS / OZONE_MOLAR_MASS
    if "geopotential_height" not in values and "altitude" not in values:
        raise InputError("has no geopotential on its pressure levels; download it (z) with the others", file=file)
    return Readings(file, values, "any", time)


@contextmanager
def opened(file: Path) -> Iterator[Any]:
    """The open netCDF4 dataset of a file.

    Raises
    ------
    InputError
        netCDF4 is not installed, or the file cannot be read, also while it is open.
    """
    try:
        import netCDF4
    except ImportError:
        raise InputError(
            "is netCDF, which needs the package netCDF4: pip install 'skyshine[netcdf]'", file=file
        ) from None
    try:
        data = netCDF4.Dataset(file)
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(
            f"is no netCDF that can be read: {str(error)[:80]}; check or download it again", file=file
        ) from None
    try:
        with data:
            yield data
    except (
        OSError,
        RuntimeError,
        ValueError,
        IndexError,
        TypeError,
        OverflowError,
        AttributeError,
        MemoryError,
    ) as error:
        raise InputError(f"is netCDF that cannot be read: {str(error)[:80]}; check it", file=file) from None


def _variable(data: Any, name: str) -> Any:
    """The variable of a quantity by its standard name, or by its own; None where there is none."""
    named = VARIABLES[name]
    by_standard = [v for v in data.variables.values() if getattr(v, "standard_name", None) == named[0] and v.ndim > 0]
    by_name = [
        v for key, v in data.variables.items() if key.lower() in named and v.ndim > 0 and key not in data.dimensions
    ]
    return next(iter([*by_standard, *by_name]), None)


def _find(data: Any, file: Path, name: str) -> Any:
    variable = _variable(data, name)
    if variable is None:
        raise InputError(
            f"has no {name}: found the variables {', '.join(list(data.variables)[:12])}; allowed: one with the standard"
            f" name {VARIABLES[name][0]}, or named {' or '.join(VARIABLES[name][1:3])}",
            file=file,
        )
    return variable


def _axes(data: Any, temperature: Any, file: Path) -> dict[str, str]:
    """Dimension of the temperature that is time, pressure, latitude and longitude; others have one node."""
    axes: dict[str, str] = {}
    for dimension in temperature.dimensions:
        coordinate = data.variables.get(dimension)
        standard = "" if coordinate is None else getattr(coordinate, "standard_name", "")
        kind = next((k for k, names in _AXES.items() if standard == names[0] or dimension.lower() in names), None)
        if kind is not None and coordinate is not None:
            if coordinate.size > MOST_NODES:
                raise InputError(
                    f"found {coordinate.size} nodes of {dimension}; allowed: at most {MOST_NODES}", file=file
                )
            axes[kind] = dimension
        elif len(data.dimensions[dimension]) != 1:
            raise InputError(
                f"found the axis '{dimension}' of {len(data.dimensions[dimension])} nodes; allowed: time, pressure,"
                " latitude and longitude; take one part of it",
                file=file,
            )
    if "pressure" not in axes:
        raise InputError("has no temperature on pressure levels; download pressure levels, not model levels", file=file)
    return axes


def _numbers(variable: Any) -> Floats:
    """All numbers of a variable; NaN where it has none."""
    return np.ma.filled(np.ma.asarray(variable[:], dtype=float), np.nan)


def _times(data: Any, axes: dict[str, str], file: Path) -> list[datetime | None]:
    import netCDF4

    if "time" not in axes:
        return [None]
    variable = data.variables[axes["time"]]
    if not hasattr(variable, "units"):
        raise InputError(
            f"has no units of its times, {axes['time']}; allowed: such as hours since 1900-01-01", file=file
        )
    dates = netCDF4.num2date(
        np.atleast_1d(_numbers(variable)), variable.units, getattr(variable, "calendar", "standard")
    )
    return [
        datetime(d.year, d.month, d.day, d.hour, d.minute, d.second, tzinfo=UTC) if d is not None else None
        for d in np.ma.filled(np.ma.asarray(dates), None)
    ]


def _at_time(times: list[datetime | None], choice: Choice, file: Path) -> dict[int, float]:
    if choice.time is None or not choice.interpolated or len(times) == 1:
        return {index_of(times, choice, file): 1.0}
    nearest = index_of(times, choice, file)
    apart = np.array([np.nan if time is None else hours(choice.time, time) for time in times])
    nearest_times = weights(np.where(np.isnan(apart), np.inf, apart), 0.0, interpolated=True)
    nodes = apart[list(nearest_times)]
    return nearest_times if np.ptp(nodes) <= FARTHEST_HOURS else {nearest: 1.0}


def _at_place(data: Any, axes: dict[str, str], choice: Choice, file: Path) -> dict[str, dict[int, float]]:
    """Weights of the columns around a place, by dimension."""
    selected: dict[str, dict[int, float]] = {}
    for kind, here in zip(("latitude", "longitude"), choice.place or (None, None), strict=True):
        if kind not in axes:
            continue
        nodes = _numbers(data.variables[axes[kind]])
        if here is None:
            if nodes.size > 1:
                raise InputError(
                    f"has columns at {nodes.size} nodes of {kind}; allowed: one, or a job whose site is the place",
                    file=file,
                )
            selected[axes[kind]] = {0: 1.0}
            continue
        apart = nodes - here if kind == "latitude" else (nodes - here + 180.0) % 360.0 - 180.0
        if not np.all(np.isfinite(apart)):
            raise InputError(f"found {kind}s that are no numbers; check the file", file=file)
        step = np.median(np.diff(np.sort(nodes))) if nodes.size > 1 else 1.0
        if np.min(np.abs(apart)) > step:
            raise InputError(
                f"begins at {kind} {nodes.min():g} and ends at {nodes.max():g}; the site lies outside, at {here:g};"
                " allowed: a site inside the grid or within a step of it",
                file=file,
            )
        selected[axes[kind]] = weights(apart, 0.0, choice.interpolated)
    return selected


def _pressure(data: Any, dimension: str, file: Path) -> Floats:
    variable = data.variables[dimension]
    if variable.ndim != 1 or not 2 <= variable.size <= MOST_LEVELS:
        raise InputError(f"found {variable.size} pressure levels; allowed: 2 to {MOST_LEVELS}", file=file)
    return _in_si(file, "pressure", variable, _numbers(variable))


def _in_si(file: Path, name: str, variable: Any, values: Floats) -> Floats:
    """Values of a variable in SI units; geopotential as height, ozone as mass fraction."""
    unit_name = str(getattr(variable, "units", ""))
    choices = _UNITS.get(name, UNITS.get(name, {}))
    unit = unit_of(_SPELLINGS.get(unit_name, unit_name), choices)
    if unit is None:
        raise InputError(
            f"found the unit '{unit_name[:40]}' of {variable.name}; allowed: {', '.join(choices)}", file=file
        )
    if name in _UNITS:
        return values * _UNITS[name][unit]
    factor, offset = to_si(name, unit)
    return values * factor + offset


def _column(file: Path, variable: Any, vertical: str, at: dict[str, dict[int, float]]) -> Floats:
    """Values of a variable on its levels, summed over the columns and times with their weights."""
    levels = len(variable.get_dims()[variable.dimensions.index(vertical)])
    total = np.zeros(levels)
    combined: list[tuple[tuple[Any, ...], float]] = [((), 1.0)]
    for dimension in variable.dimensions:
        nodes = [(_ALL, 1.0)] if dimension == vertical else [*at.get(dimension, {0: 1.0}).items()]
        combined = [((*index, node), weight * share) for index, weight in combined for node, share in nodes]
    for index, weight in combined:
        total += weight * np.ma.filled(np.ma.asarray(variable[index], dtype=float), np.nan)
    return total
