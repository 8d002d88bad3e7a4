"""Resistance of leaves to transpiration: stomata open with light and close in dry, cold and hot air."""

from __future__ import annotations

import numpy as np

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.convection import TREE_ROUGHNESS
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats

CLOSED = 5000.0  # s m^-1, of leaves without light: Noilhan and Planton (1989), r_s,max
_WATER_RATIO = 0.622  # ratio of the molar masses of water and dry air
_BEST_TEMPERATURE = ZERO_CELSIUS + 25.0  # K; and the loss of conductance [K^-2] beside it: Noilhan and Planton (1989)
_COLD_AND_HEAT = 0.0016
_LEAST_SHARE = 0.01  # fraction of conductance, in cold or heat that closes leaves
# Sunlight [W m^-2] at which stomata are half open, R_gl LAI / (2 x 0.55) of Noilhan and Planton (1989): their R_gl of
# 100 for crops and grass of leaf area index 3, and of 30 for trees of index 5. Sensitivity to the deficit of specific
# humidity: grassland 36.35, broad-leaved trees 54.53, Chen and Dudhia (2001), Mon. Weather Rev. 129, 569-585, as the
# tables of the Noah model have them.
_LOW, _TREES = (100.0 * 3.0 / 1.1, 3.0, 36.35), (30.0 * 5.0 / 1.1, 5.0, 54.53)


def canopy_resistance(
    minimum: float, roughness_length: float, sunlight: Floats, air_temperature: Floats, air: tuple[Floats, Floats]
) -> Floats:
    """Resistance of a canopy to transpiration.

    Parameters
    ----------
    minimum : float
        Resistance in full light and humid air of 25 C [s m^-1].
    roughness_length : float
        Tells trees from lower plants [m].
    sunlight : ndarray
        Sunlight on open level ground [W m^-2]: the light of the hour, whatever the orientation and the shade of a face.
    air_temperature : ndarray
        [K]
    air : (ndarray, ndarray)
        Vapour pressure and pressure [Pa].

    Returns
    -------
    ndarray
        [s m^-1], at most `CLOSED`.

    References
    ----------
    Jarvis (1976), Phil. Trans. R. Soc. B 273, 593-610, with the functions of light and temperature of Noilhan and
    Planton (1989), Mon. Weather Rev. 117, 536-549, and of humidity of Chen and Dudhia (2001).
    """
    half_open, leaf_area, sensitivity = _TREES if roughness_length > TREE_ROUGHNESS else _LOW
    vapour, pressure = air
    light = sunlight / half_open
    open_share = (light + minimum * leaf_area / CLOSED) / (1 + light)
    deficit = _WATER_RATIO * np.maximum(saturation_pressure(air_temperature) - vapour, 0.0) / pressure
    mild = np.maximum(1 - _COLD_AND_HEAT * (air_temperature - _BEST_TEMPERATURE) ** 2, _LEAST_SHARE)
    conductance = np.maximum(open_share * mild, _LEAST_SHARE**3)
    resistance: Floats = np.minimum(minimum * (1 + sensitivity * deficit) / conductance, CLOSED)
    return resistance
