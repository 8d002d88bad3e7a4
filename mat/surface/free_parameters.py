"""Numbers of a material that a fit may free: what they change, their bounds, and which of them act at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skyshine.mat.surface.convection import TREE_ROUGHNESS
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.stomata import CLOSED
from skyshine.mat.surface.symbolic_balance import SymbolicMaterial
from skyshine.materials.records import SurfaceProperties, ThermalStack
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError, nearest

# Units of each, and whether it is searched by its logarithm.
PARAMETERS = {
    "albedo": ("1", False),
    "emissivity": ("1", False),
    "conductivity": ("W m^-1 K^-1", True),
    "heat_capacity": ("J kg^-1 K^-1", True),
    "thickness": ("m", True),
    "roughness_length": ("m", True),
    "wetness": ("1", False),
    "surface_resistance": ("s m^-1", True),
    "back_temperature": ("K", False),
}
_ALBEDO = 0.01, 0.95  # soot to fresh snow: Oke (1987), Boundary Layer Climates, table 1.1
_EMISSIVITY = 0.02, 1.0  # polished metal to a black body
# W m^-1 K^-1: foams to rock salt and ice, above them metals to silver. Still air has 0.025, quartz 8, silver 430.
_CONDUCTIVITY = (0.01, 10.0), (10.0, 450.0)
_VOLUMETRIC = 1e4, 4.5e6  # J m^-3 K^-1: wool of 10 kg m^-3 to water, 4.2e6
_THICKNESS = 1e-4, 2.0  # m: chosen, sheet metal to the depth that the day does not reach
# m: ice to the least trees, and those; of buildings, from glass to stucco (Walton 1983)
_LOW_FIELD, _TREES, _BUILDING = (1e-5, TREE_ROUGHNESS), (TREE_ROUGHNESS, 5.0), (1e-5, 1e-2)
_BACK = 200.0, 340.0  # K: chosen, from the coldest firn to hot engine rooms
_RESISTANCE = 1.0, CLOSED
# Where a material has 0, from which no derivative shows the way: chosen, moist ground and a topsoil's resistance.
_MOIST, _TOPSOIL = 0.1, 50.0


@dataclass(frozen=True)
class FreeParameter:
    """A number of a material that is free between bounds.

    Attributes
    ----------
    logarithmic : bool
        Whether it is searched, and its uncertainty stated, by its logarithm.
    """

    name: str
    units: str
    start: float
    low: float
    high: float
    logarithmic: bool

    def share(self, value: float) -> float:
        """Where a value lies between the bounds, 0 to 1."""
        if self.logarithmic:
            return float(np.log(value / self.low) / np.log(self.high / self.low))
        return (value - self.low) / (self.high - self.low)

    def value(self, share: float) -> float:
        """The value at a share of the way between the bounds."""
        if self.logarithmic:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)

    def slope(self, share: float) -> float:
        """Derivative of the value by the share."""
        if self.logarithmic:
            return self.value(share) * float(np.log(self.high / self.low))
        return self.high - self.low


def free_parameters(material: SurfaceMaterial, names: Sequence[str], mean_air: float) -> tuple[FreeParameter, ...]:
    """The parameters of these names, that start at the material's values.

    Parameters
    ----------
    names : sequence of str
        Names out of `PARAMETERS`.
    mean_air : float
        Air temperature of the record [K], at which a back without a temperature of its own starts.

    Raises
    ------
    InputError
        No name, an unknown one, one twice, or one that has no effect on this material.
    """
    if not names:
        raise InputError(f"found no parameter to free; allowed: {', '.join(PARAMETERS)}")
    for name in names:
        if name not in PARAMETERS:
            raise InputError(f"found the parameter '{name}'; {nearest(name, PARAMETERS)}")
        if list(names).count(name) > 1:
            raise InputError(f"found the parameter '{name}' twice; name it once")
        reason = _without_effect(material, name, names)
        if reason:
            raise InputError(f"{name} has no effect on material '{material.name}': {reason}")
    return tuple(_parameter(material, name, mean_air) for name in names)


def _parameter(material: SurfaceMaterial, name: str, mean_air: float) -> FreeParameter:
    start, (low, high) = _start_and_bounds(material, name, mean_air)
    units, logarithmic = PARAMETERS[name]
    return FreeParameter(name, units, start, min(low, start), max(high, start), logarithmic)


def _start_and_bounds(material: SurfaceMaterial, name: str, mean_air: float) -> tuple[float, tuple[float, float]]:
    surface, layer = material.surface, material.thermal.layers[0]
    if name == "albedo":
        return 1.0 - material.solar_absorptance, _ALBEDO
    if name == "emissivity":
        return material.thermal_emissivity, _EMISSIVITY
    if name == "conductivity":
        return layer.conductivity, _CONDUCTIVITY[int(layer.conductivity > _CONDUCTIVITY[0][1])]
    if name == "heat_capacity":
        return layer.heat_capacity, (_VOLUMETRIC[0] / layer.density, _VOLUMETRIC[1] / layer.density)
    if name == "thickness":
        return layer.thickness, _THICKNESS
    if name == "roughness_length":
        field = _TREES if surface.roughness_length > TREE_ROUGHNESS else _LOW_FIELD
        return surface.roughness_length, field if surface.exposure == "field" else _BUILDING
    if name == "wetness":
        return surface.wetness or _MOIST, (0.0, 1.0)
    if name == "surface_resistance":
        return surface.surface_resistance or _TOPSOIL, _RESISTANCE
    temperature = material.thermal.back.temperature
    return mean_air if temperature is None else float(np.mean(temperature)), _BACK


def _without_effect(material: SurfaceMaterial, name: str, names: Sequence[str]) -> str:
    """Why a parameter changes nothing, with what to do about it; empty where it does."""
    surface, (upper, lower), back = material.surface, material.thermal.layers, material.thermal.back
    if name == "surface_resistance" and not surface.wetness and "wetness" not in names:
        return "it is dry; free wetness too, or leave it out"
    if name == "roughness_length" and surface.exposure == "plate":
        return "its exposure is 'plate', whose law knows smooth and rough only; leave it out"
    if name == "thickness" and np.isinf(upper.thickness):
        return "its first layer has no end; leave it out"
    if name == "back_temperature":
        if back.kind not in ("fixed", "convective"):
            return f"its back is of kind '{back.kind}'; leave it out"
        if np.isinf(lower.thickness):
            return "its second layer has no end; leave it out"
    return ""


def changed_numbers(material: SurfaceMaterial, values: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers of stack and surface that values of parameters represent, by dotted field name; layers count from 1.

    Notes
    -----
    Conductivity and heat capacity are those of the first layer, and of skin and second layer where these are of the
    same substance. Albedo and emissivity are no numbers of the stack.
    """
    stack = material.thermal
    upper = stack.layers[0]
    parts = {"skin": stack.skin, "layers.1": upper, "layers.2": stack.layers[1]}
    alike = [
        name
        for name, part in parts.items()
        if replace(part, thickness=upper.thickness) == upper  # conductivity, density and heat capacity
    ]
    numbers: dict[str, Any] = {}
    for name, value in values.items():
        if name in ("conductivity", "heat_capacity"):
            numbers |= {f"{part}.{name}": value for part in alike}
        elif name == "thickness":
            numbers["layers.1.thickness"] = value
        elif name == "back_temperature":
            numbers["back.temperature"] = value
        elif name not in ("albedo", "emissivity"):
            numbers[f"surface.{name}"] = value
    return numbers


def with_values(material: SurfaceMaterial, values: Mapping[str, Any]) -> SymbolicMaterial:
    """The material with numbers or casadi expressions for some of its parameters."""
    thermal, surface = _replaced(material, values)
    symbols = SymbolicMaterial.of(material)
    return replace(
        symbols,
        thermal=thermal,
        surface=surface,
        solar_absorptance=1.0 - values["albedo"] if "albedo" in values else symbols.solar_absorptance,
        thermal_emissivity=values.get("emissivity", symbols.thermal_emissivity),
    )


def with_numbers(material: SurfaceMaterial, values: Mapping[str, float]) -> SurfaceMaterial:
    """The material with numbers for some of its parameters."""
    changed = with_values(material, values)
    return SurfaceMaterial(
        material.name, changed.thermal, changed.surface, changed.solar_absorptance, changed.thermal_emissivity
    )


def _replaced(material: SurfaceMaterial, values: Mapping[str, Any]) -> tuple[ThermalStack, SurfaceProperties]:
    numbers = changed_numbers(material, values)

    def of(prefix: str) -> dict[str, Any]:
        return {key.removeprefix(prefix): value for key, value in numbers.items() if key.startswith(prefix)}

    stack = material.thermal
    upper, lower = stack.layers
    thermal = ThermalStack(
        replace(stack.skin, **of("skin.")),
        (replace(upper, **of("layers.1.")), replace(lower, **of("layers.2."))),
        replace(stack.back, **of("back.")),
    )
    return thermal, replace(material.surface, **of("surface."))


def parameter_values(parameters: Sequence[FreeParameter], shares: Floats) -> dict[str, float]:
    """Values of parameters at shares (free,) of the way between their bounds, by name."""
    return {parameter.name: parameter.value(float(share)) for parameter, share in zip(parameters, shares, strict=True)}
