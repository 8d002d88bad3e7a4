"""A user's profile: radiosonde or model levels from a CSV table, continued to space by a standard profile.

Columns ``altitude``, ``pressure``, ``temperature`` and one of `HUMIDITY`, each with its unit in brackets; other columns
are gases in parts of the air, ``O3[ppbv]``.
"""

from __future__ import annotations

import os

import numpy as np
from scipy import constants

from skyshine.mat.atmosphere.state.humidity import mole_fraction
from skyshine.mat.atmosphere.state.hydrostatics import DRY_AIR_MOLAR_MASS, gravity
from skyshine.mat.atmosphere.state.profiles import Profile
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import CsvTable, parse_table
from skyshine.schemas.errors import nearest

_KELVIN = {
    "K": (1.0, 0.0),
    "C": (1.0, ZERO_CELSIUS),
    "degC": (1.0, ZERO_CELSIUS),
    "°C": (1.0, ZERO_CELSIUS),
    "F": (5 / 9, 459.67 * 5 / 9),
}
_PASCAL: dict[str, float] = {"Pa": 1.0, "hPa": 1e2, "mbar": 1e2, "mb": 1e2, "kPa": 1e3, "bar": 1e5}
_PASCAL |= {"atm": constants.atm, "mmHg": constants.mmHg, "Torr": constants.torr, "inHg": 25.4 * constants.mmHg}
_PARTS = {"ppmv": 1e-6, "ppm": 1e-6, "ppbv": 1e-9, "ppb": 1e-9, "pptv": 1e-12, "ppt": 1e-12, "1": 1.0}
_MASS_PARTS = {"kg/kg": 1.0, "g/kg": 1e-3, "1": 1.0}
# By column: its units as (factor, offset) to SI.
UNITS: dict[str, dict[str, float] | dict[str, tuple[float, float]]] = {
    "altitude": {"m": 1.0, "km": 1e3, "ft": constants.foot, "kft": 1e3 * constants.foot},
    "pressure": _PASCAL,
    "temperature": _KELVIN,
    "relative_humidity": {"%": 1e-2, "percent": 1e-2, "1": 1.0},
    "dew_point": _KELVIN,
    "mixing_ratio": _MASS_PARTS,
    "specific_humidity": _MASS_PARTS,
    "vapour_pressure": _PASCAL,
    "absolute_humidity": {"kg/m3": 1.0, "g/m3": 1e-3},
    "h2o": _PARTS,
}
HUMIDITY = tuple(UNITS)[3:]
_SPELLINGS = {"vapor_pressure": "vapour_pressure", "dewpoint": "dew_point", "H2O": "h2o", "height": "altitude"}

ALTITUDES = (-500.0, 100e3)  # m
TEMPERATURES = (140.0, 335.0)  # K: the coldest mesopause and the hottest air near the ground, with a margin
HIGHEST_PRESSURE = 1100e2  # Pa; the record at sea level is 1085 hPa
# Sondes read a little above saturation in cloud; up to this they are taken as saturated.
SATURATION_MARGIN = 1.03
# Pressure at the top against that which hydrostatic balance gives from the bottom: more says that a unit is wrong.
HYDROSTATIC_MARGIN = 0.05
# The air at the lowest level is continued down this far at its own temperature; above the highest level its difference
# from the standard profile fades out over the other.
_BELOW = 500.0  # m
_FADE = 5e3  # m


def read_sounding(text: str, file: str | os.PathLike[str], above: Profile) -> Profile:
    """Read a sounding.

    Parameters
    ----------
    text : str
        Of the CSV file.
    file : path
        Named in messages.
    above : Profile
        Continues the sounding to space, and holds the gases that it does not name.

    Returns
    -------
    Profile
        From 500 m below the lowest level.

    Raises
    ------
    InputError
        With file:line:column of a missing or unknown column or unit, levels out of order, pressure that does not fall
        or does not fit altitude and temperature, supersaturation, or a value no air has.
    """
    table = parse_table(text, file)
    columns = _columns(table, above)
    values = {name: _converted(table, name, index) for name, index in columns.items()}
    _check_levels(table, columns, values)
    humidity = next(name for name in HUMIDITY if name in columns)
    water = mole_fraction(humidity, values[humidity], values["pressure"], values["temperature"])
    _check_humidity(table, columns[humidity], values, water)
    saturated = saturation_pressure(values["temperature"]) / values["pressure"]
    gases = {"H2O": np.minimum(water, saturated)}
    gases |= {name: values[name] for name in columns if name not in UNITS}
    return _continued(
        Profile(table.file.name, values["altitude"], values["pressure"], values["temperature"], gases), above
    )


def _columns(table: CsvTable, above: Profile) -> dict[str, int]:
    """Index of each column under its own name."""
    columns: dict[str, int] = {}
    for index, written in enumerate(table.names):
        name = _SPELLINGS.get(written, written)
        if name not in UNITS and name not in above.mole_fraction:
            raise table.error(
                -1, index, f"found the column '{written}'; {nearest(written, [*UNITS, *above.mole_fraction])}"
            )
        if name in columns:
            raise table.error(-1, index, f"found {name} twice; allowed: once; remove one")
        columns[name] = index
    for name in ("altitude", "pressure", "temperature"):
        if name not in columns:
            raise table.error(
                -1, 0, f"the column '{name}' is missing; add it, with its unit: {name}[{next(iter(UNITS[name]))}]"
            )
    humidities = [name for name in HUMIDITY if name in columns]
    if len(humidities) != 1:
        raise table.error(
            -1,
            0,
            f"found {' and '.join(humidities) or 'no humidity'}; allowed: one of {', '.join(HUMIDITY)}; "
            + ("remove the others" if humidities else "add it"),
        )
    return columns


def _converted(table: CsvTable, name: str, index: int) -> Floats:
    unit = table.units[index]
    choices = UNITS.get(name, _PARTS)
    if unit not in choices:
        raise table.error(
            -1,
            index,
            f"found {f'the unit {unit!r}' if unit else 'no unit'} of {name}; {nearest(unit, choices)}; write"
            f" {name}[unit]",
        )
    conversion = choices[unit]
    factor, offset = conversion if isinstance(conversion, tuple) else (conversion, 0.0)
    values: Floats = table.values[:, index] * factor + offset
    if name in ("temperature", "dew_point"):
        _within(table, index, values, *TEMPERATURES, "K")
    elif name == "altitude":
        _within(table, index, values, *ALTITUDES, "m")
    elif name == "pressure":
        _within(table, index, values, 0.01, HIGHEST_PRESSURE, "Pa")
    else:
        _within(table, index, values, 0.0, np.inf if name in UNITS else 1.0, "in SI units")
    return values


def _within(table: CsvTable, index: int, values: Floats, low: float, high: float, unit: str) -> None:
    for row in np.flatnonzero(~((values >= low) & (values <= high)))[:1]:
        raise table.error(
            row,
            index,
            f"found {table.values[row, index]:g}, which is {values[row]:.4g} {unit}; allowed: {low:g} to {high:g}"
            f" {unit}; fix the value or the column's unit",
        )


def _check_levels(table: CsvTable, columns: dict[str, int], values: dict[str, Floats]) -> None:
    altitude, pressure = values["altitude"], values["pressure"]
    for row in np.flatnonzero(np.diff(altitude) <= 0)[:1]:
        again = "the same altitude again" if altitude[row + 1] == altitude[row] else "a lower altitude"
        raise table.error(
            row + 1,
            columns["altitude"],
            f"found {again}, {altitude[row + 1]:g} m after {altitude[row]:g} m; allowed: altitudes that "
            "increase; sort the rows and merge repeated ones",
        )
    for row in np.flatnonzero(np.diff(pressure) >= 0)[:1]:
        raise table.error(
            row + 1,
            columns["pressure"],
            f"found {pressure[row + 1]:g} Pa above {pressure[row]:g} Pa; allowed: pressure that falls "
            "with altitude; fix the row",
        )
    balance = np.cumsum(
        DRY_AIR_MOLAR_MASS * gravity(altitude[:-1]) * np.diff(altitude) / (constants.R * _middle(values["temperature"]))
    )
    imbalance = np.abs(np.log(pressure[1:] / pressure[0]) + balance)
    for row in np.flatnonzero(imbalance > np.maximum(HYDROSTATIC_MARGIN, HYDROSTATIC_MARGIN * balance))[:1]:
        expected = pressure[0] * np.exp(-balance[row])
        raise table.error(
            row + 1,
            columns["pressure"],
            f"found {pressure[row + 1]:.5g} Pa where altitudes and temperatures from the lowest level up give"
            f" {expected:.5g} Pa; allowed: within {100 * HYDROSTATIC_MARGIN:g} %; look at the units of altitude and"
            " pressure",
        )


def _check_humidity(table: CsvTable, index: int, values: dict[str, Floats], water: Floats) -> None:
    ratio = water * values["pressure"] / saturation_pressure(values["temperature"])
    for row in np.flatnonzero(ratio > SATURATION_MARGIN)[:1]:
        raise table.error(
            row,
            index,
            f"found {table.values[row, index]:g}, which is {100 * ratio[row]:.0f} % relative humidity at "
            f"{values['temperature'][row]:.1f} K; allowed: at most {100 * SATURATION_MARGIN:g} % over liquid water; "
            "fix the value or its unit",
        )


def _middle(values: Floats) -> Floats:
    return 0.5 * (values[1:] + values[:-1])


def _continued(sounding: Profile, above: Profile) -> Profile:
    """The sounding with one level below it and the levels of a standard profile above."""
    scale = DRY_AIR_MOLAR_MASS * gravity(sounding.altitude[0]) / (constants.R * sounding.temperature[0])
    top = sounding.altitude[-1]
    higher = above.altitude > top
    at_top = np.exp(np.interp(top, above.altitude, np.log(above.pressure)))
    warmer = sounding.temperature[-1] - np.interp(top, above.altitude, above.temperature)
    fade = np.clip(1 - (above.altitude - top) / _FADE, 0.0, 1.0)
    altitude = np.concatenate([[sounding.altitude[0] - _BELOW], sounding.altitude, above.altitude[higher]])
    pressure = np.concatenate(
        [
            [sounding.pressure[0] * np.exp(scale * _BELOW)],
            sounding.pressure,
            above.pressure[higher] * sounding.pressure[-1] / at_top,
        ]
    )
    temperature = np.concatenate(
        [sounding.temperature[:1], sounding.temperature, (above.temperature + warmer * fade)[higher]]
    )
    gases = {}
    for gas, fraction in above.mole_fraction.items():
        if gas in sounding.mole_fraction:
            measured = sounding.mole_fraction[gas]
            gases[gas] = np.concatenate([measured[:1], measured, fraction[higher]])
        else:
            gases[gas] = np.interp(altitude, above.altitude, fraction)
    gases["H2O"] = np.minimum(gases["H2O"], saturation_pressure(temperature) / pressure)
    return Profile(sounding.name, altitude, pressure, temperature, gases)
