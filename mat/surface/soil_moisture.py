"""What water in the pores of a soil changes: conduction, heat capacity and the resistance to evaporation.

References
----------
Conductivity: Cote and Konrad (2005), Can. Geotech. J. 42, 443-458, equations (14), (15) and table of kappa, chi and eta
for unfrozen soils; saturated conductivity as the geometric mean of solids and water (Johansen 1975). Heat capacity: de
Vries (1963), in van Wijk, Physics of Plant Environment: parts add by volume. Resistance: van de Griend and Owe (1994),
Water Resour. Res. 30, 181-188.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.materials.records import Layer, Soil, ThermalStack
from skyshine.schemas.arrays import Floats

WATER_CONDUCTIVITY = 0.60  # W m^-1 K^-1, at 20 C: as Cote and Konrad take it
WATER_DENSITY, WATER_HEAT_CAPACITY = 1000.0, 4180.0  # kg m^-3, J kg^-1 K^-1
# Volume fraction of water in the topmost soil at which its resistance is that of free molecules alone, that resistance
# [s m^-1], and its growth as the soil dries: van de Griend and Owe (1994), equation (8).
_MOIST, _LEAST_RESISTANCE, _GROWTH = 0.15, 10.0, 35.63
# They measured down to some 4 %. Below, chosen: the evaporating share goes to 0 with the water, so that a soil without
# water gives none off.
_DRIEST = 0.04


@dataclass(frozen=True)
class _Texture:
    """Parameters of Cote and Konrad: of the relative conductivity, and of the dry one [W m^-1 K^-1] by porosity."""

    kappa: float
    chi: float
    eta: float


TEXTURES = {
    "gravel": _Texture(4.60, 1.70, 1.80),
    "sand": _Texture(3.55, 0.75, 1.20),
    "fine": _Texture(1.90, 0.75, 1.20),
    "organic": _Texture(0.60, 0.30, 0.87),
}


def conductivity(soil: Soil, moisture: npt.ArrayLike) -> Floats:
    """Thermal conductivity of a soil, unfrozen.

    Parameters
    ----------
    soil : Soil
    moisture : array_like
        Volume fraction of water, 0 to the porosity.

    Returns
    -------
    ndarray
        [W m^-1 K^-1]
    """
    texture = TEXTURES[soil.texture]
    saturation = np.asarray(moisture, float) / soil.porosity
    dry = texture.chi * 10.0 ** (-texture.eta * soil.porosity)
    saturated = soil.solid_conductivity ** (1 - soil.porosity) * WATER_CONDUCTIVITY**soil.porosity
    relative = texture.kappa * saturation / (1 + (texture.kappa - 1) * saturation)
    whole: Floats = dry + (saturated - dry) * relative
    return whole


def resistance(moisture: npt.ArrayLike) -> Floats:
    """Resistance of the topmost soil to evaporation [s m^-1] at a volume fraction of water."""
    below = np.maximum(_MOIST - np.asarray(moisture, float), 0.0)
    whole: Floats = _LEAST_RESISTANCE * np.exp(_GROWTH * below)
    return whole


def evaporating_share(moisture: npt.ArrayLike) -> Floats:
    """Share of the surface that evaporates through `resistance`, 0 to 1."""
    share: Floats = np.minimum(np.asarray(moisture, float) / _DRIEST, 1.0)
    return share


def moist_stack(stack: ThermalStack, soil: Soil, moisture: float) -> ThermalStack:
    """A dry stack with water in its soil.

    Parameters
    ----------
    stack : ThermalStack
        Whose skin and first layer are dry.
    soil : Soil
    moisture : float
        Volume fraction of water, 0 to the porosity.

    Returns
    -------
    ThermalStack
        Skin and first layer hold the water. A second layer of the same soil does so where it held less; where it held
        more, it keeps that.
    """

    def moist(layer: Layer) -> Layer:
        density = stack.layers[0].density + moisture * WATER_DENSITY
        capacity = stack.layers[0].density * stack.layers[0].heat_capacity
        capacity += moisture * WATER_DENSITY * WATER_HEAT_CAPACITY
        return Layer(layer.thickness, float(conductivity(soil, moisture)), density, capacity / density)

    first, second = stack.layers
    if soil.layers == 2 and (deep := moist(second)).density >= second.density:
        second = deep
    return replace(stack, skin=moist(stack.skin), layers=(moist(first), second))
