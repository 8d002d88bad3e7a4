"""Quantities of a sounding, the units and the names that they are written with."""

from __future__ import annotations

from skyshine.mat.radiometry.constants import FOOT, MMHG, STANDARD_ATMOSPHERE, ZERO_CELSIUS

_KELVIN = {
    "K": (1.0, 0.0),
    "C": (1.0, ZERO_CELSIUS),
    "degC": (1.0, ZERO_CELSIUS),
    "°C": (1.0, ZERO_CELSIUS),
    "Celsius": (1.0, ZERO_CELSIUS),
    "F": (5 / 9, 459.67 * 5 / 9),
}
_PASCAL: dict[str, float] = {"Pa": 1.0, "hPa": 1e2, "mbar": 1e2, "mb": 1e2, "kPa": 1e3, "bar": 1e5}
_PASCAL |= {"atm": STANDARD_ATMOSPHERE, "mmHg": MMHG, "Torr": MMHG, "inHg": 25.4 * MMHG}
PARTS = {"ppmv": 1e-6, "ppm": 1e-6, "ppbv": 1e-9, "ppb": 1e-9, "pptv": 1e-12, "ppt": 1e-12, "1": 1.0}
_MASS_PARTS = {"kg/kg": 1.0, "g/kg": 1e-3, "1": 1.0}
_LENGTH = {"m": 1.0, "km": 1e3, "ft": FOOT, "kft": 1e3 * FOOT}
# By quantity: its units as factor, or (factor, offset), to SI.
UNITS: dict[str, dict[str, float] | dict[str, tuple[float, float]]] = {
    "altitude": _LENGTH,
    "geopotential_height": _LENGTH | {"gpm": 1.0},
    "pressure": _PASCAL,
    "temperature": _KELVIN,
    "relative_humidity": {"%": 1e-2, "percent": 1e-2, "1": 1.0},
    "dew_point": _KELVIN,
    "mixing_ratio": _MASS_PARTS,
    "specific_humidity": _MASS_PARTS,
    "vapour_pressure": _PASCAL,
    "absolute_humidity": {"kg/m3": 1.0, "g/m3": 1e-3},
    "h2o": PARTS,
}
# Measures of humidity; where a level has several, the first of them that is given: lists round relative humidity to
# whole percent, which is a tenth of the vapour of dry air.
HUMIDITY = (
    "dew_point",
    "specific_humidity",
    "mixing_ratio",
    "vapour_pressure",
    "absolute_humidity",
    "h2o",
    "relative_humidity",
)

_SPELLINGS = {
    "altitude": ("alt", "height", "geometric_height", "geometric_altitude", "gps_height", "gps_altitude"),
    "geopotential_height": ("gph", "hght", "geopot", "geopotential", "geopotential_altitude"),
    "pressure": ("p", "pres", "press", "air_pressure"),
    "temperature": ("t", "temp", "air_temperature", "air_temp", "dry_bulb", "dry_bulb_temperature"),
    "relative_humidity": ("rh", "relh", "humidity", "relhum", "rel_humidity"),
    "dew_point": ("td", "dewp", "dwpt", "dewpoint", "dew_point_temperature", "dewpoint_temperature"),
    "mixing_ratio": ("mixr", "water_vapour_mixing_ratio", "water_vapor_mixing_ratio"),
    "specific_humidity": ("q", "shum"),
    "vapour_pressure": ("vapor_pressure",),
    "absolute_humidity": (),
    "h2o": (),
}
# Folded spelling to quantity.
NAMES = {spelling: name for name, others in _SPELLINGS.items() for spelling in (name, *others)}


def to_si(name: str, unit: str) -> tuple[float, float]:
    """Factor and offset to SI of a quantity or gas in one of its units."""
    conversion = UNITS.get(name, PARTS)[unit]
    return conversion if isinstance(conversion, tuple) else (conversion, 0.0)
