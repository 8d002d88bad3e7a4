"""Water vapour: the measures in which humidity is written down."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import GAS_CONSTANT
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats

# Ratio of water vapour to dry air: 18.01528 (IUPAC 2018) / 28.9647 g mol^-1 (US Standard Atmosphere 1976 with 400 ppm
# CO2).
MASS_RATIO = 18.01528 / 28.9647
WATER_MOLAR_MASS = 18.01528e-3  # kg mol^-1 (IUPAC 2018)


def mole_fraction(kind: str, value: npt.ArrayLike, pressure: Floats, temperature: Floats) -> Floats:
    """Mole fraction of water vapour in moist air.

    Parameters
    ----------
    kind : str
        relative_humidity (0 to 1, over liquid water), dew_point (K), mixing_ratio (kg vapour per kg dry air),
        specific_humidity (kg per kg moist air), vapour_pressure (Pa), absolute_humidity (kg m^-3) or h2o (mole
        fraction).
    value, pressure, temperature : arrays
        Pressure and temperature of the air in Pa and K.

    Returns
    -------
    array
    """
    value = np.asarray(value, dtype=float)
    fraction: Floats
    if kind == "mixing_ratio":
        fraction = value / (MASS_RATIO + value)
        return fraction
    if kind == "specific_humidity":
        fraction = value / (MASS_RATIO + (1 - MASS_RATIO) * value)
        return fraction
    if kind == "h2o":
        return value
    if kind == "vapour_pressure":
        partial = value
    elif kind == "dew_point":
        partial = saturation_pressure(value)
    elif kind == "absolute_humidity":
        partial = value / WATER_MOLAR_MASS * GAS_CONSTANT * temperature
    else:
        partial = value * saturation_pressure(temperature)
    fraction = partial / pressure
    return fraction
