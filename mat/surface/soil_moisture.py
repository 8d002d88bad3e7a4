"""What water in the pores of a soil changes: conduction, heat capacity and the resistance to evaporation.

References
----------
Conductivity: Cote and Konrad (2005), Can. Geotech. J. 42, 443-458, equations (14), (15) and table of kappa, chi and
eta for unfrozen and frozen soils; saturated conductivity as the geometric mean of solids and water or ice (Johansen
1975). Heat capacity: de Vries (1963), in van Wijk, Physics of Plant Environment: parts add by volume. Water that
stays unfrozen: Anderson and Tice (1972), Highway Research Record 393, 12-18, by the surface of the grains. Supply of
water to a drying surface: Gardner and Hillel (1962), J. Geophys. Res. 67, 4319-4325, with the diffusivity of van
Genuchten (1980), Soil Sci. Soc. Am. J. 44, 892-898, equation (11), parameters by texture of Carsel and Parrish
(1988), Water Resour. Res. 24, 755-769, of organic soil those of HYPRES (Wosten et al. 1999, Geoderma 90, 169-185).
Resistance of wet soil: van de Griend and Owe (1994), Water Resour. Res. 30, 181-188.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.materials.records import Layer, Soil, ThermalStack
from skyshine.schemas.arrays import Floats

WATER_CONDUCTIVITY = 0.60  # W m^-1 K^-1, at 20 C: as Cote and Konrad take it
WATER_DENSITY, WATER_HEAT_CAPACITY = 1000.0, 4180.0  # kg m^-3, J kg^-1 K^-1
# Properties of ice: W m^-1 K^-1, as Cote and Konrad take it; J kg^-1 K^-1 at -10 C, of the mass of the water that
# froze.
ICE_CONDUCTIVITY, ICE_HEAT_CAPACITY = 2.24, 2030.0
HEAT_OF_FUSION = 3.337e5  # J kg^-1 of ice at 0 C
# K: below less frost soil is taken to swing over its freezing point, where the law has no bound; chosen.
_LEAST_FROST = 1.0
# s m^-1: of a soil that is wet to its surface, van de Griend and Owe (1994), equation (8).
_LEAST_RESISTANCE = 10.0
DEPTH = 0.1  # m: over which the moisture of a soil is the mean, and which supplies its surface
# Evaporation that wet ground loses in a day of fair summer, 5 mm (FAO Irrigation and Drainage Paper 56, table 2: 4 to 6
# mm in moderately warm semi-arid climates) [kg m^-2 s^-1], and the deficit of vapour density that drives it through the
# 174 s/m of that paper's reference surface under 2 m/s (equations 4 and 5) [kg m^-3].
_DEMAND = 5.0 / 86400.0
_DEFICIT = 174.0 * _DEMAND
_LEAST_DRY = 1e-3  # m: chosen; thinner dry soil hardly changes what a day conducts
_LEAST_SUPPLY = 1e-9  # kg m^-2 s^-1: chosen, 0.1 mm in three years; keeps the resistance finite


@dataclass(frozen=True)
class _Texture:
    """Parameters of a class of grains.

    Attributes
    ----------
    kappa, frozen_kappa, chi, eta : float
        Cote and Konrad: of the relative conductivity, unfrozen and frozen, and of the dry one [W m^-1 K^-1] by
        porosity.
    residual, saturated : float
        Volume fractions of water that does not flow, and of full pores.
    alpha, n : float
        Van Genuchten's [m^-1] and [1].
    flow : float
        Hydraulic conductivity of full pores [m s^-1].
    grains : float
        Surface of the grains over their mass [m^2 g^-1]: of the silts and clays that Anderson and Tice measured, 18 to
        84, and chosen between them; of sand and gravel 1, of organic soil that of silt, chosen.
    """

    kappa: float
    frozen_kappa: float
    chi: float
    eta: float
    residual: float
    saturated: float
    alpha: float
    n: float
    flow: float
    grains: float


_GRAVEL, _SAND = (4.60, 1.70, 1.70, 1.80), (3.55, 0.95, 0.75, 1.20)
_FINE, _ORGANIC = (1.90, 0.85, 0.75, 1.20), (0.60, 0.25, 0.30, 0.87)
_DAY = 0.01 / 86400.0  # m s^-1 in a cm/d
# Gravel is drained as sand, the coarsest class of Carsel and Parrish.
TEXTURES = {
    "gravel": _Texture(*_GRAVEL, 0.045, 0.43, 14.5, 2.68, 712.8 * _DAY, 1.0),
    "sand": _Texture(*_SAND, 0.045, 0.43, 14.5, 2.68, 712.8 * _DAY, 1.0),
    "sandy_loam": _Texture(*_SAND, 0.065, 0.41, 7.5, 1.89, 106.1 * _DAY, 10.0),
    "loam": _Texture(*_FINE, 0.078, 0.43, 3.6, 1.56, 24.96 * _DAY, 40.0),
    "silt": _Texture(*_FINE, 0.034, 0.46, 1.6, 1.37, 6.0 * _DAY, 18.0),
    "clay": _Texture(*_FINE, 0.068, 0.38, 0.8, 1.09, 4.8 * _DAY, 60.0),
    "organic": _Texture(*_ORGANIC, 0.010, 0.766, 1.3, 1.2039, 8.0 * _DAY, 18.0),
}


def conductivity(soil: Soil, moisture: npt.ArrayLike, frozen: bool = False) -> Floats:
    """Thermal conductivity of a soil.

    Parameters
    ----------
    moisture : array_like
        Volume fraction of water, 0 to the porosity.
    frozen : bool
        Whether that is ice.

    Returns
    -------
    ndarray
        [W m^-1 K^-1]
    """
    texture = TEXTURES[soil.texture]
    kappa, pores = (texture.frozen_kappa, ICE_CONDUCTIVITY) if frozen else (texture.kappa, WATER_CONDUCTIVITY)
    saturation = np.asarray(moisture, float) / soil.porosity
    dry = texture.chi * 10.0 ** (-texture.eta * soil.porosity)
    saturated = soil.solid_conductivity ** (1 - soil.porosity) * pores**soil.porosity
    relative = kappa * saturation / (1 + (kappa - 1) * saturation)
    result: Floats = dry + (saturated - dry) * relative
    return result


def unfrozen_water(texture: str, dry_density: float, frost: float) -> float:
    """Volume fraction of water that stays liquid in frozen soil.

    Parameters
    ----------
    texture : str
        A name of `TEXTURES`.
    dry_density : float
        Dry density of the soil [kg m^-3].
    frost : float
        Below 0 C, above 0 [K].

    References
    ----------
    Anderson and Tice (1972): ln w = 0.2618 + 0.5519 ln S - 1.449 S^-0.264 ln frost, w in per cent of the dry mass.

    Examples
    --------
    >>> round(unfrozen_water("silt", 1600.0, 5.0), 3), round(unfrozen_water("clay", 1600.0, 5.0), 3)
    (0.035, 0.09)
    """
    percent = 0.2618 + 0.5519 * np.log(TEXTURES[texture].grains) - _freezing_power(texture) * np.log(frost)
    return float(1e-2 * np.exp(percent) * dry_density / WATER_DENSITY)


def _freezing_power(texture: str) -> float:
    return float(1.449 * TEXTURES[texture].grains ** -0.264)


def freezing_capacity(texture: str, dry_density: float, moisture: float, frost: float) -> float:
    """Heat of the water that freezes as a frozen soil cools by a kelvin, its apparent heat capacity [J m^-3 K^-1]."""
    frost = max(frost, _LEAST_FROST)
    liquid = unfrozen_water(texture, dry_density, frost)
    freezing = _freezing_power(texture) * liquid / frost if liquid < moisture else 0.0
    return HEAT_OF_FUSION * WATER_DENSITY * freezing


def diffusivity(texture: str, moisture: npt.ArrayLike) -> Floats:
    """Diffusivity of water in a soil [m^2 s^-1] at volume fractions of it, by van Genuchten (1980), equation (11)."""
    soil = TEXTURES[texture]
    m = 1.0 - 1.0 / soil.n
    water = (np.asarray(moisture, float) - soil.residual) / (soil.saturated - soil.residual)
    water = np.clip(water, 1e-9, 1.0 - 1e-6)
    full = water ** (1.0 / m)
    # (1 - x)^-m + (1 - x)^m - 2, of which powers of a small x would leave no digits.
    bend = 4.0 * np.sinh(0.5 * m * np.log1p(-full)) ** 2
    scale = (1.0 - m) * soil.flow / (soil.alpha * m * (soil.saturated - soil.residual))
    result: Floats = scale * water ** (0.5 - 1.0 / m) * bend
    return result


def supply(texture: str, moisture: npt.ArrayLike) -> Floats:
    """Water that the upper 0.1 m of a soil can bring to its surface, D (w - w_r) pi^2 / (4 L).

    Parameters
    ----------
    texture : str
        A name of `TEXTURES`.
    moisture : array_like
        Mean volume fraction w of water in these 0.1 m.

    Returns
    -------
    ndarray
        [kg m^-2 s^-1]

    References
    ----------
    Gardner and Hillel (1962): the falling rate of a layer L that is closed below, D at its mean water.

    Examples
    --------
    Millimetres a day, of loam and of sand:

    >>> (86400 * supply("loam", [0.15, 0.25])).round(2), (86400 * supply("sand", [0.05, 0.10])).round(2)
    (array([ 0.44, 21.14]), array([0.  , 7.19]))
    """
    wet = np.maximum(np.asarray(moisture, float) - TEXTURES[texture].residual, 0.0)
    flux: Floats = WATER_DENSITY * diffusivity(texture, moisture) * wet * np.pi**2 / (4 * DEPTH)
    return flux


def resistance(texture: str, moisture: npt.ArrayLike) -> Floats:
    """Resistance of a soil to evaporation [s m^-1]: that through which its supply passes under the deficit of a fair
    day, over that of wet soil.
    """
    result: Floats = _LEAST_RESISTANCE + _DEFICIT / np.maximum(supply(texture, moisture), _LEAST_SUPPLY)
    return result


@lru_cache(maxsize=16)
def drying_moisture(texture: str) -> float:
    """Moisture below which a fair day's evaporation exceeds the supply, so that the surface falls dry."""
    low, high = TEXTURES[texture].residual, TEXTURES[texture].saturated - 1e-3
    for _ in range(5):  # to a part in 1e13; scipy's root finders take 0.25 s to import
        wetter = np.linspace(low, high, 501)
        above = int(np.argmax(supply(texture, wetter) > _DEMAND))
        low, high = wetter[above - 1], wetter[above]
    return float(high)


def dry_layer(texture: str, moisture: float) -> float:
    """Depth of dry soil [m] above what is as moist as when the surface fell dry, which together contain the water.

    Examples
    --------
    Sand with 0.05 m3/m3 is dry but for its lowest centimetre, with 0.15 m3/m3 it is moist to its surface:

    >>> round(dry_layer("sand", 0.05), 3), dry_layer("sand", 0.15)
    (0.09, 0.0)
    """
    residual, moist = TEXTURES[texture].residual, drying_moisture(texture)
    return DEPTH * min(max((moist - moisture) / (moist - residual), 0.0), 1.0)


def moist_stack(stack: ThermalStack, soil: Soil, moisture: float, frost: float = 0.0) -> ThermalStack:
    """A dry stack with water in its soil.

    Parameters
    ----------
    stack : ThermalStack
        Stack with dry skin and dry first layer.
    moisture : float
        Volume fraction of water, 0 to the porosity.
    frost : float
        How far the soil is below 0 C in the mean [K]; above 0 the water is ice, and freezes and thaws a little as the
        soil cools and warms.

    Returns
    -------
    ThermalStack
        Skin and first layer have the water. Of soil in both layers they are dry where the surface has fallen dry, and
        the second begins below the dry soil. It has the water of what is moist above, less where little of that is,
        where it held less; where it held more, it keeps that.
    """

    def moist(layer: Layer, moisture: float) -> Layer:
        density = stack.layers[0].density + moisture * WATER_DENSITY
        capacity = stack.layers[0].density * stack.layers[0].heat_capacity
        capacity += moisture * WATER_DENSITY * (ICE_HEAT_CAPACITY if frost else WATER_HEAT_CAPACITY)
        if frost:
            capacity += freezing_capacity(soil.texture, stack.layers[0].density, moisture, frost)
        return Layer(layer.thickness, float(conductivity(soil, moisture, frost > 0)), density, capacity / density)

    upper, lower = stack.layers
    if soil.layers == 1:
        return replace(stack, skin=moist(stack.skin, moisture), layers=(moist(upper, moisture), lower))
    dry = dry_layer(soil.texture, moisture)
    below = (1 - dry / DEPTH) * min(drying_moisture(soil.texture), soil.porosity) if dry else moisture
    if (deep := moist(lower, below)).density >= lower.density:
        lower = deep
    if dry < _LEAST_DRY:
        return replace(stack, skin=moist(stack.skin, moisture), layers=(moist(upper, moisture), lower))
    lower = replace(lower, thickness=lower.thickness + upper.thickness - dry)
    return replace(stack, layers=(replace(upper, thickness=dry), lower))
