"""A spectrum brought to a broadband level: the odds of reflection are multiplied by one factor."""

from __future__ import annotations

import numpy as np
import scipy

from skyshine.mat.radiometry.constants import C2_WAVELENGTH
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

LEAST_FACTOR, MOST_FACTOR = 1e-4, 1e4  # bounds of the factor on the odds


def with_odds(reflectance: Floats, factor: float) -> Floats:
    """Reflectance (W,) whose odds r / (1 - r) are multiplied by a factor.

    With a factor 1 - p this is the law of light that a structure returns to its own elements with probability p after
    each reflection, r (1 - p) / (1 - p r): what gaps of a canopy or roughness do to the spectrum of their elements.

    References
    ----------
    Smolander and Stenberg 2005, Remote Sens. Environ. 94:355-363, doi:10.1016/j.rse.2004.10.010.
    """
    return factor * reflectance / (1.0 + (factor - 1.0) * reflectance)


def odds_factor(reflectance: Floats, weight: Floats, absorptance: float) -> float:
    """Factor on the odds of reflection with which the weighted mean of 1 - reflectance is a number.

    Parameters
    ----------
    reflectance, weight : (W,) arrays
        Reflectance and weight at the same points; the weight includes the width of each.
    absorptance : float
        Absorptance, between 0 and 1.

    Raises
    ------
    InputError
        No factor from 1e-4 to 1e4 does.
    """

    def excess(logarithm: float) -> float:
        return float(1.0 - with_odds(reflectance, np.exp(logarithm)) @ weight / weight.sum()) - absorptance

    low, high = np.log(LEAST_FACTOR), np.log(MOST_FACTOR)
    if not excess(low) >= 0.0 >= excess(high):
        raise InputError(f"no scaling of the sample gives an absorptance of {absorptance:g}; choose another sample")
    return float(np.exp(scipy.optimize.brentq(excess, low, high, xtol=1e-10)))


def blackbody_weight(wavelength: Floats, temperature: float) -> Floats:
    """Blackbody radiance (W,) of any scale at wavelengths (W,) [um] and a temperature [K]."""
    return wavelength**-5 / np.expm1(C2_WAVELENGTH / (wavelength * temperature))
