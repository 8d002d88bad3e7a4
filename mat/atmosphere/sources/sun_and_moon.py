"""Sun and Moon: irradiance outside the atmosphere and position in the sky."""

from skyshine.mat.atmosphere.sources.ephemeris import SOURCES, SourcePosition, position
from skyshine.mat.atmosphere.sources.lunar import (
    LunarIrradiance,
    disk_reflectance,
    lunar_irradiance,
    subsolar_temperature,
)
from skyshine.mat.atmosphere.sources.solar import ASTRONOMICAL_UNIT, solar_irradiance

__all__ = [
    "ASTRONOMICAL_UNIT",
    "SOURCES",
    "LunarIrradiance",
    "SourcePosition",
    "disk_reflectance",
    "lunar_irradiance",
    "position",
    "solar_irradiance",
    "subsolar_temperature",
]
