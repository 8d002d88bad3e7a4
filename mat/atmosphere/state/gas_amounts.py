"""How much of a gas there is: factors on the gases of a profile, and columns."""

from __future__ import annotations

import numpy as np
from scipy import constants
from scipy.optimize import brentq

from skyshine.mat.atmosphere.state.humidity import WATER_MOLAR_MASS
from skyshine.schemas.errors import InputError, nearest

DOBSON_UNIT = 2.6867e20  # molecules m^-2: 10 um of ozone at 0 C and 1 atm (Loschmidt constant, CODATA)
_LARGEST_FACTOR = 1e6  # beyond it every level is saturated


def gas_factors(gases, scale, ppm):
    """Factor on each gas.

    Parameters
    ----------
    gases : dict of (N,) arrays
        Mole fractions from the ground up.
    scale : dict of float
        Gas to factor.
    ppm : dict of float
        Gas to parts per million at the ground.

    Returns
    -------
    dict of float

    Raises
    ------
    InputError
        For a gas that the profile does not hold, is named twice or is 0 at the ground, and for a negative or infinite
        amount.
    """
    for gas, amount in [*scale.items(), *ppm.items()]:
        if gas not in gases:
            raise InputError(f"no gas '{gas}' in this profile; {nearest(gas, gases)}")
        if not (np.isfinite(amount) and amount >= 0):
            raise InputError(f"amount {amount} of {gas} is not allowed; give a finite number of at least 0")
    factors = dict(scale)
    for gas, parts in ppm.items():
        if factors.get(gas, 1.0) != 1.0:
            raise InputError(f"{gas} has both a scale and an amount; give one of them")
        if gases[gas][0] <= 0:
            raise InputError(
                f"the profile holds no {gas} at the ground, so that none can be scaled to {parts:g} ppm; give a scale"
            )
        factors[gas] = parts * 1e-6 / gases[gas][0]
    return factors


def mean_exponential(first, second):
    """Mean of a quantity that runs exponentially from `first` to `second`; linear where one of them is 0."""
    high, low = np.maximum(first, second), np.minimum(first, second)
    usable = low > 0
    ratio = np.where(usable, high / np.where(usable, low, 1.0), 2.0)
    log = np.log(ratio)
    close = log < 1e-4
    exact = (high - low) / np.where(close, 1.0, log)
    return np.where(usable & ~close, exact, 0.5 * (first + second))


def layer_columns(altitude, density):
    """Integral across each layer of a density (N,) [x m^-3], exponential between levels (N,) [m]: (N-1,) [x m^-2]."""
    return mean_exponential(density[:-1], density[1:]) * np.diff(altitude)


def ozone_factor(altitude, density, column):
    """Factor that gives ozone of a number density (N,) [m^-3] a column [DU].

    Raises
    ------
    InputError
        For a column that is negative or not finite, or where there is no ozone to scale.
    """
    now = layer_columns(altitude, density).sum() / DOBSON_UNIT
    if not (np.isfinite(column) and column >= 0):
        raise InputError(f"ozone column {column} DU is not allowed; give a finite number of at least 0")
    if now <= 0:
        raise InputError("the profile holds no ozone that could be scaled to a column")
    return column / now


def water_factor(altitude, density, fraction, saturated, column):
    """Factor that gives water vapour a column, where no level holds more than saturated air does.

    Parameters
    ----------
    altitude, density : (N,) arrays
        m; of air, m^-3.
    fraction, saturated : (N,) arrays
        Mole fraction of water vapour, and that at saturation.
    column : float
        kg m^-2.

    Raises
    ------
    InputError
        For a column that is negative or not finite, or that saturated air does not hold.
    """

    def held(factor):
        vapour = density * np.minimum(fraction * factor, saturated)
        return layer_columns(altitude, vapour).sum() * WATER_MOLAR_MASS / constants.N_A

    if not (np.isfinite(column) and column >= 0):
        raise InputError(f"water column {column} mm is not allowed; give a finite number of at least 0")
    if column == 0:
        return 0.0
    most = held(_LARGEST_FACTOR)
    if column > most:
        raise InputError(
            f"water column {column:g} mm is more than saturated air of this profile holds, {most:.4g} mm; give less"
        )
    return brentq(lambda factor: held(factor) - column, 0.0, _LARGEST_FACTOR, xtol=1e-12, rtol=1e-12)
