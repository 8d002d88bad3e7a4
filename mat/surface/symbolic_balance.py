"""The nonlinear heat balance of a surface as casadi expressions, in which numbers of the material may be symbols.

It is written independently of `balance`, for checks of the solver (`tests/validation/surface_oracle.py`) and for fits,
which need exact derivatives by the material's parameters (`fit`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN, ZERO_CELSIUS
from skyshine.mat.surface.balance import skin_of
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.convection import AIR_GAS_CONSTANT, AIR_HEAT_CAPACITY, TREE_ROUGHNESS, natural_coefficients
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.materials.records import SurfaceProperties, ThermalStack
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


@dataclass(frozen=True, eq=False)
class SymbolicMaterial:
    """A `SurfaceMaterial` whose numbers may be casadi expressions.

    Attributes
    ----------
    solar_absorptance, thermal_emissivity : float or casadi.SX
    trees : bool
        Whether the roughness length is that of trees, over which stability has no effect.
    by_time : bool
        Whether its skin is that of the forcing's rows, not its own.
    gets_wet : bool
        Whether those rows may bring water to a dry material.
    """

    thermal: ThermalStack
    surface: SurfaceProperties
    solar_absorptance: Any
    thermal_emissivity: Any
    trees: bool
    by_time: bool = False
    gets_wet: bool = False

    @classmethod
    def of(cls, material: SurfaceMaterial, by_time: bool = False) -> SymbolicMaterial:
        """A material whose numbers are all known.

        Raises
        ------
        InputError
            Its layers let sunlight in, or its leaves have gaps, which these equations do not know.
        """
        if material.canopy is not None:
            raise InputError(f"material '{material.name}': gaps between leaves; allowed: others; take another")
        if material.thermal.light:
            raise InputError(f"material '{material.name}': lets sunlight in; allowed: others; take another")
        optical = material.solar_absorptance, material.thermal_emissivity
        trees = material.surface.roughness_length > TREE_ROUGHNESS
        wet = material.film is not None or material.moist is not None
        return cls(material.thermal, material.surface, *optical, trees, by_time, by_time and wet)

    @property
    def dry(self) -> bool:
        """Whether it is known that no water evaporates."""
        return not self.gets_wet and isinstance(self.surface.wetness, int | float) and self.surface.wetness == 0


FORCING = (  # rows of a forcing, in the order that `loss` takes
    *("shortwave", "longwave", "air", "vapour", "pressure", "wind", "wind_height", "air_height"),
    *("upward", "warmer", "colder", "open_light"),
    *("absorptance", "emissivity", "wetness", "resistance", "film"),
)


def forcing_rows(forcing: Forcing, count: int, material: SurfaceMaterial, *, by_time: bool) -> Floats:
    """Forcing of the balance at each time, (fields, times): see `FORCING`; the last five are of the material's skin, 0
    where that is not by time; the film is -1 where none may be.
    """
    skin: list[float | Floats] = [0.0] * 5
    if by_time:
        surface = skin_of(material, forcing)
        skin = [surface.solar_absorptance, surface.thermal_emissivity, surface.wetness, surface.surface_resistance]
        skin.append(-1.0 if material.film is None or forcing.film is None else forcing.film)
    warmer, colder = natural_coefficients(forcing.cos_slope, forcing.pressure, material.surface)
    rows = [
        forcing.shortwave_direct + forcing.shortwave_diffuse + forcing.shortwave_reflected,
        forcing.longwave_sky + forcing.longwave_ground,
        forcing.air_temperature,
        forcing.vapour_pressure,
        forcing.pressure,
        forcing.wind_speed,
        forcing.wind_height,
        forcing.air_height,
        1.0 + np.minimum(90.0 - np.degrees(np.arccos(forcing.cos_slope)), 0.0) / 90.0,
        warmer,
        colder,
        forcing.open_light,
        *skin,
    ]
    return np.stack([np.broadcast_to(row, (1, count))[0] for row in rows])


def loss(ca: Any, material: SymbolicMaterial, surface: Any, parameter: Any) -> Any:
    """Outward flux of a surface [W m^-2] as a casadi expression.

    Parameters
    ----------
    ca : module
        casadi.
    surface : casadi.SX
        Temperature of the surface [K].
    parameter : casadi.SX
        One value for each of `FORCING`.
    """
    weather, skin = ca.vertsplit(parameter)[:12], ca.vertsplit(parameter)[12:]
    short, long, air, vapour, pressure, speed, wind_height, air_height, upward, warmer, colder, open_light = weather
    wind = speed, wind_height, air_height
    properties = material.surface
    if not material.by_time:
        skin = [material.solar_absorptance, material.thermal_emissivity, properties.wetness]
        skin += [properties.surface_resistance, 0.0]
    absorptance, emissivity, wetness, resists, film = skin
    net = emissivity * (STEFAN_BOLTZMANN * surface**4 - long) - absorptance * short
    net += properties.delivered * (1.0 + properties.delivered_per_kelvin * (surface - 298.15)) * short
    volumetric = pressure / (AIR_GAS_CONSTANT * air) * AIR_HEAT_CAPACITY
    difference = surface - air
    width = ca.sqrt(difference**2 + 0.01)
    natural = 0.5 * (warmer**3 * (width + difference) + colder**3 * (width - difference))
    forced = _forced(ca, properties, volumetric, pressure, wind)
    if properties.exposure == "field" and not material.trees:
        forced *= _stability(ca, properties.roughness_length, difference / air, wind, upward)
    minimum = 8.0
    if properties.exposure == "field" and not material.trees:
        minimum = ca.if_else(upward >= 1.0, 1.0, 8.0)
    coefficient = ca.if_else(pressure > 0, (minimum + forced**3 + natural) ** (1.0 / 3.0), 0.0)
    net += coefficient * difference
    if not material.dry:
        celsius = surface - ZERO_CELSIUS
        frozen = ca.fmin(ca.fmax(-celsius / 2.0, 0.0), 1.0)
        ice = frozen * frozen * (3.0 - 2.0 * frozen)
        over_ice = 9.550426 - 5723.265 / surface + 3.53068 * ca.log(surface) - 0.00728332 * surface
        over_water = _over_water(ca, surface)
        deficit = (ca.exp(ice * over_ice + (1.0 - ice) * over_water) - vapour) * (1.0 + ice * 0.333 / 2.501)
        through_air = volumetric / coefficient
        resistance = through_air + (
            _leaves(ca, material, open_light, air, (vapour, pressure)) if properties.canopy else resists
        )
        covered = ca.if_else(film >= 0, ca.if_else(deficit > 0, film, 1.0), 0.0) if material.by_time else 0.0
        share = covered / through_air + (1 - covered) * wetness / resistance
        net += volumetric / (0.665e-3 * pressure) * deficit * share
    return net


def _over_water(ca: Any, kelvin: Any) -> Any:
    """Logarithm of the saturation pressure [ln Pa]."""
    bend = 53.878 - 1331.22 / kelvin - 9.44523 * ca.log(kelvin) + 0.014025 * kelvin
    level = 54.842763 - 6763.22 / kelvin - 4.210 * ca.log(kelvin) + 0.000367 * kelvin
    return level + ca.tanh(0.0415 * (kelvin - 218.8)) * bend


def _leaves(ca: Any, material: SymbolicMaterial, sunlight: Any, air: Any, humidity: tuple[Any, Any]) -> Any:
    """Resistance of a canopy [s m^-1] under sunlight on open level ground [W m^-2]."""
    minimum, trees = material.surface.surface_resistance, material.trees
    vapour, pressure = humidity
    light = 1.1 * sunlight / (150.0 if trees else 300.0)
    share = (light + minimum * (5.0 if trees else 3.0) / 5000.0) / (1.0 + light)
    deficit = 0.622 * ca.fmax(ca.exp(_over_water(ca, air)) - vapour, 0.0) / pressure
    mild = ca.fmax(1.0 - 0.0016 * (air - 298.15) ** 2, 0.01)
    return ca.fmin(minimum * (1.0 + (54.53 if trees else 36.35) * deficit) / (share * mild), 5000.0)


def _forced(ca: Any, surface: SurfaceProperties, volumetric: Any, pressure: Any, wind: tuple[Any, Any, Any]) -> Any:
    """Transfer coefficient of the wind in neutral air [W m^-2 K^-1]; `wind` is speed, its height, that of the air."""
    roughness, (speed, wind_height, air_height) = surface.roughness_length, wind
    if surface.exposure == "field":
        logs = ca.log(1 + wind_height / roughness) * ca.log(1 + air_height * np.exp(2.0) / roughness)
        return volumetric * 0.16 * ca.sqrt(speed**2 + 0.01) / logs

    def at(height: float) -> Any:
        return speed * np.log(height / 0.03) / ca.log(wind_height / 0.03)

    thin = (pressure / 101325.0) ** 0.8
    if surface.exposure == "plate":
        return 5.678 * (0.53 if roughness > 3e-5 else 0.50) * (at(2.0) / 0.3048) ** 0.78 * thin
    factor = _multiplier(ca, roughness)
    if surface.exposure == "roof":
        return factor * 0.0296 * 0.0257 / 5.0 * (1.2041 * at(6.0) * 5.0 / 1.81e-5) ** 0.8 * 0.71 ** (1 / 3) * thin
    return factor * (1.63 * at(10.0) ** 0.89 + 1.775 * at(10.0) ** 0.617) * thin


def _multiplier(ca: Any, roughness: Any) -> Any:
    """Walton's multiplier of a rough building surface, linear in the logarithm between its values."""
    nodes, values = np.log10([1e-5, 1e-4, 1e-3, 0.002, 1e-2]), np.array([1.0, 1.11, 1.52, 1.67, 2.17])
    level = ca.log10(roughness)
    slopes = np.diff(values) / np.diff(nodes)
    parts = zip(nodes, nodes[1:], slopes, strict=False)
    return values[0] + sum(slope * (ca.fmin(ca.fmax(level, low), high) - low) for low, high, slope in parts)


def _stability(ca: Any, roughness: Any, relative: Any, wind: tuple[Any, Any, Any], upward: Any) -> Any:
    """Louis' factor at a difference over air temperature."""
    speed, wind_height, air_height = wind
    height = ca.sqrt(wind_height * air_height)

    def heat(level: Any) -> Any:
        return ca.log(1 + level * np.exp(2.0) / roughness)

    momentum, there = ca.log(1 + height / roughness), ca.log(1 + wind_height / roughness)
    squared = (speed**2 + 0.01) * (momentum / there) ** 2
    number = 9.80665 * height * relative * heat(height) / heat(air_height) / squared
    excess = 2.0
    cubic = 3.2165 + 4.3431 * excess + 0.5360 * excess**2 - 0.0781 * excess**3
    power = 0.5802 - 0.1571 * excess + 0.0327 * excess**2 - 0.0026 * excess**3
    convection = 15 * cubic * 0.16 / (momentum * heat(height)) * (1 + height * np.exp(2.0) / roughness) ** power
    unstable_number, cold = ca.fmax(number, 0.0), ca.fmax(-number, 0.0)
    unstable = 1 + 15 * unstable_number / (1 + convection * ca.sqrt(unstable_number + 1e-16))
    level = ca.if_else(number > 0, unstable, 1 / (1 + 15 * cold * ca.sqrt(1 + 5 * cold)))
    return 1 + upward * (level - 1)
