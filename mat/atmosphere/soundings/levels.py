"""The levels of a sounding: readings checked, gaps closed, humidity as mole fraction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.soundings.readings import Readings
from skyshine.mat.atmosphere.soundings.units import HUMIDITY, UNITS
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts, scaled_gases
from skyshine.mat.atmosphere.state.humidity import MASS_RATIO, mole_fraction
from skyshine.mat.atmosphere.state.hydrostatics import DRY_AIR_MOLAR_MASS, EARTH_RADIUS, gravity
from skyshine.mat.radiometry.constants import GAS_CONSTANT, STANDARD_GRAVITY
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

ALTITUDES = (-500.0, 100e3)  # m
TEMPERATURES = (140.0, 335.0)  # K: the coldest mesopause and the hottest air near the ground, with a margin
HIGHEST_PRESSURE = 1100e2  # Pa; the record at sea level is 1085 hPa
_LIMITS = {
    "altitude": (*ALTITUDES, "m"),
    "geopotential_height": (*ALTITUDES, "m"),
    "pressure": (0.001, HIGHEST_PRESSURE, "Pa"),
    "temperature": (*TEMPERATURES, "K"),
    "dew_point": (100.0, TEMPERATURES[1], "K"),
}
# Sondes read a little above saturation in cloud; up to this they are taken as saturated.
SATURATION_MARGIN = 1.03
# Pressure at the top against that which hydrostatic balance gives from the bottom: more says that a unit is wrong.
HYDROSTATIC_MARGIN = 0.05


@dataclass(frozen=True, eq=False)
class Levels:
    """A sounding of N levels, checked.

    Attributes
    ----------
    time : datetime or None
        UTC, where the file says.
    altitude, pressure, temperature : (N,) arrays
        m (geometric, increasing), Pa, K.
    mole_fraction : dict of str to (N,) array
        Mole fractions of water vapour, at most saturated, and the gases of the file; NaN above the highest level with a
        value.
    notes : tuple of str
        Values in the place of those that the file lacks.
    """

    file: Path
    time: datetime | None
    altitude: Floats
    pressure: Floats
    temperature: Floats
    mole_fraction: dict[str, Floats]
    notes: tuple[str, ...] = ()


def levels_of(readings: Readings) -> Levels:
    """Levels with pressure and temperature, from the lowest up.

    Geopotential heights become altitudes; missing ones follow from hydrostatic balance. Humidity and gases are
    interpolated over levels that lack them, and remain missing above the highest level that has them.

    Raises
    ------
    InputError
        At the place of a value that no air has; of levels out of order, pressure that does not fall or does not fit
        altitude and temperature, supersaturation; and for a sounding of fewer than two levels or without humidity.
    """
    for name in readings.values:
        _check_limits(readings, name)
    rows, notes = _rising_rows(readings)
    notes = [*readings.notes, *notes]
    values = {name: values[rows] for name, values in readings.values.items()}
    water = _water(values)
    if not np.any(np.isfinite(water)):
        raise InputError(
            "has no humidity beside pressure and temperature; allowed: some level with it", file=readings.file
        )
    _check_saturation(readings, rows, values, water)
    saturated = saturation_pressure(values["temperature"]) / values["pressure"]
    altitude, more = _altitudes(readings.file, values, np.minimum(np.nan_to_num(water), saturated))
    notes += more
    _check_order(readings, rows, values | {"altitude": altitude})
    _check_balance(readings, rows, values | {"altitude": altitude})
    gases = {"H2O": np.minimum(_bridged(altitude, water / saturated) * saturated, saturated)}
    gases |= {name: _bridged(altitude, values[name]) for name in values if name not in UNITS}
    if readings.amounts != GasAmounts():
        clear = np.zeros(altitude.shape, dtype=bool)
        gases = scaled_gases(gases, readings.amounts, altitude, values["pressure"], values["temperature"], clear)
    if np.isnan(gases["H2O"][-1]):
        top = altitude[np.isfinite(gases["H2O"])][-1]
        notes.append(f"has no humidity above {top / 1e3:.0f} km; that of the profile is used there")
    return Levels(
        readings.file, readings.time, altitude, values["pressure"], values["temperature"], gases, tuple(notes)
    )


def _check_limits(readings: Readings, name: str) -> None:
    low, high, unit = _LIMITS.get(name, (0.0, np.inf if name in UNITS else 1.0, "in SI units"))
    values = readings.values[name]
    for row in np.flatnonzero((values < low) | (values > high))[:1]:
        raise readings.error(
            row,
            name,
            f"found {readings.number(row, name):g}, which is {values[row]:.4g} {unit}; allowed: {low:g} to {high:g}"
            f" {unit}; fix the value or the column's unit",
        )


def _rising_rows(readings: Readings) -> tuple[npt.NDArray[np.intp], list[str]]:
    """Rows with pressure and temperature, from the lowest up; what was omitted on the way."""
    pressure = readings.values["pressure"]
    altitude = _altitude_as_written(readings.values)
    rows = np.flatnonzero(np.isfinite(pressure) & np.isfinite(readings.values["temperature"]))
    notes = []
    if readings.order == "any":
        rows = rows[np.argsort(-pressure[rows], kind="stable")]
    if readings.order != "sorted":
        rising, lowest, highest = [], np.inf, -np.inf
        for row in rows:
            if pressure[row] < lowest and not altitude[row] <= highest:
                rising.append(row)
                lowest, highest = pressure[row], max(highest, np.nan_to_num(altitude[row], nan=-np.inf))
        if len(rising) < rows.size:
            notes.append(
                f"has {rows.size - len(rising)} of {rows.size} levels that do not rise above those before; they are"
                " not read"
            )
        rows = np.array(rising, dtype=np.intp)
    if rows.size < 2:
        raise InputError(
            f"found {rows.size} levels with pressure and temperature; allowed: 2 or more", file=readings.file
        )
    return rows, notes


def _altitude_as_written(values: Mapping[str, Floats]) -> Floats:
    """Geometric altitude, from geopotential height where only that is given; NaN where neither is [m]."""
    nothing = np.full(np.shape(values["pressure"]), np.nan)
    height = values.get("geopotential_height", nothing)
    altitude = values.get("altitude", nothing)
    # US Standard Atmosphere 1976, equation (19): geopotential metres to metres.
    return np.where(np.isfinite(altitude), altitude, EARTH_RADIUS * height / (EARTH_RADIUS - height))


def _altitudes(file: Path, values: Mapping[str, Floats], water: Floats) -> tuple[Floats, list[str]]:
    """Altitudes of all levels: written, or by hydrostatic balance of moist air between those that are."""
    altitude = _altitude_as_written(values)
    finite = np.isfinite(altitude)
    if np.all(finite):
        return altitude, []
    if not np.any(finite):
        raise InputError(
            "has no altitude at any level; allowed: altitude or geopotential height, once at least", file=file
        )
    virtual = values["temperature"] / (1 - (1 - MASS_RATIO) * water)
    scale = GAS_CONSTANT / (DRY_AIR_MOLAR_MASS * STANDARD_GRAVITY)
    height = np.append(0.0, np.cumsum(scale * _middle(virtual) * -np.diff(np.log(values["pressure"]))))  # gpm
    geometric = altitude[finite] * EARTH_RADIUS / (EARTH_RADIUS + altitude[finite])
    shift = np.interp(height, height[finite], geometric - height[finite])
    filled = EARTH_RADIUS * (height + shift) / (EARTH_RADIUS - height - shift)
    return np.where(finite, altitude, filled), []


def _water(values: Mapping[str, Floats]) -> Floats:
    """Mole fraction of water vapour by the first measure that each level has; NaN where it has none."""
    water = np.full(values["pressure"].shape, np.nan)
    for name in HUMIDITY:
        if name in values:
            stated = mole_fraction(name, values[name], values["pressure"], values["temperature"])
            water = np.where(np.isfinite(water), water, stated)
    return water


def _bridged(altitude: Floats, values: Floats) -> Floats:
    """Values with gaps closed by interpolation and continued down to the ground; NaN above the highest."""
    finite = np.isfinite(values)
    if not np.any(finite):
        return values
    filled = np.interp(altitude, altitude[finite], values[finite])
    return np.where(altitude > altitude[finite][-1], np.nan, filled)


def _check_order(readings: Readings, rows: npt.NDArray[np.intp], values: Mapping[str, Floats]) -> None:
    altitude, pressure = values["altitude"], values["pressure"]
    for at in np.flatnonzero(np.diff(altitude) <= 0)[:1]:
        again = "the same altitude again" if altitude[at + 1] == altitude[at] else "a lower altitude"
        raise readings.error(
            rows[at + 1],
            "altitude",
            f"found {again}, {altitude[at + 1]:g} m after {altitude[at]:g} m; allowed: altitudes that "
            "increase; sort the rows and merge repeated ones",
        )
    for at in np.flatnonzero(np.diff(pressure) >= 0)[:1]:
        raise readings.error(
            rows[at + 1],
            "pressure",
            f"found {pressure[at + 1]:g} Pa above {pressure[at]:g} Pa; allowed: pressure that falls "
            "with altitude; fix the row",
        )


def _check_balance(readings: Readings, rows: npt.NDArray[np.intp], values: Mapping[str, Floats]) -> None:
    altitude, pressure = values["altitude"], values["pressure"]
    balance = np.cumsum(
        DRY_AIR_MOLAR_MASS
        * gravity(altitude[:-1])
        * np.diff(altitude)
        / (GAS_CONSTANT * _middle(values["temperature"]))
    )
    imbalance = np.abs(np.log(pressure[1:] / pressure[0]) + balance)
    for at in np.flatnonzero(imbalance > np.maximum(HYDROSTATIC_MARGIN, HYDROSTATIC_MARGIN * balance))[:1]:
        expected = pressure[0] * np.exp(-balance[at])
        raise readings.error(
            rows[at + 1],
            "pressure",
            f"found {pressure[at + 1]:.5g} Pa where altitudes and temperatures from the lowest level up give"
            f" {expected:.5g} Pa; allowed: within {100 * HYDROSTATIC_MARGIN:g} %; look at the units of altitude and"
            " pressure",
        )


def _check_saturation(
    readings: Readings, rows: npt.NDArray[np.intp], values: Mapping[str, Floats], water: Floats
) -> None:
    ratio = water * values["pressure"] / saturation_pressure(values["temperature"])
    for at in np.flatnonzero(ratio > SATURATION_MARGIN)[:1]:
        name = next(name for name in HUMIDITY if name in values and np.isfinite(values[name][at]))
        raise readings.error(
            rows[at],
            name,
            f"found {readings.number(rows[at], name):g}, which is {100 * ratio[at]:.0f} % relative humidity at "
            f"{values['temperature'][at]:.1f} K; allowed: at most {100 * SATURATION_MARGIN:g} % over liquid water; "
            "fix the value or its unit",
        )


def _middle(values: Floats) -> Floats:
    return 0.5 * (values[1:] + values[:-1])
