"""Typical aerosol of a place and month: optical depth from a climatology of the Linke turbidity.

The climatology is that which pvlib ships (5 arc minutes, by month; of SoDa): it is read there, not copied. Its authors
state an error of 0.73 of the Linke turbidity, which is 0.09 of the optical depth at sea level. It represents the mean
of a month; clear days have less aerosol.

References
----------
Remund et al. 2003, Worldwide Linke turbidity information, ISES Solar World Congress, Gothenburg. Ineichen 2008, Sol.
Energy 82, 1095 (conversion).
"""

from __future__ import annotations

import datetime
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.climate import blended_profile, profile_weights
from skyshine.mat.atmosphere.state.state import AtmosphericState

SEA_LEVEL_PRESSURE = 101325.0  # Pa
LEAST_DEPTH = 0.01  # optical depth of the stratosphere without volcanoes
_MM_PER_CM = 10.0  # precipitable water in cm is in the formula, in mm in the state


@dataclass(frozen=True)
class TypicalAerosol:
    """What the climatology has for a place and month.

    Attributes
    ----------
    linke_turbidity : float
        Linke turbidity at air mass 2.
    water_vapour : float
        Above the ground, mm, of the standard profiles of latitude and season.
    optical_depth : float
        Vertical, at 0.55 um, a multiple of 0.01.
    """

    linke_turbidity: float
    water_vapour: float
    optical_depth: float
    month: int


def typical_aerosol(latitude: float, longitude: float, altitude: float, date: datetime.date) -> TypicalAerosol:
    """Typical aerosol at a place [degree, degree, m] in the month of a date."""
    import pandas as pd
    from pvlib.clearsky import lookup_linke_turbidity

    time = pd.DatetimeIndex([f"{date:%Y-%m}-15T12:00Z"])
    east = (longitude + 180) % 360 - 180
    turbidity = float(lookup_linke_turbidity(time, latitude, east, interp_turbidity=False).iloc[0])
    profile = blended_profile(profile_weights(latitude, date))
    air = AtmosphericState.from_profile(profile, surface_altitude=altitude, aerosol=Aerosol("none"))
    water = float(air.precipitable_water(altitude))
    depth = aerosol_depth(turbidity, water, float(air.pressure[0]))
    return TypicalAerosol(turbidity, water, max(round(depth, 2), LEAST_DEPTH), date.month)


def aerosol_depth(linke_turbidity: float, water_vapour: float, pressure: float) -> float:
    """Aerosol optical depth at 0.55 um.

    Inverse of the conversion of Ineichen 2008, made for optical depths up to 0.6 and 2 to 100 mm of water vapour.

    Parameters
    ----------
    linke_turbidity : float
        Linke turbidity at air mass 2.
    water_vapour : float
        mm.
    pressure : float
        Pressure at the ground, Pa.

    Examples
    --------
    >>> round(aerosol_depth(3.0, 10.0, 101325.0), 3)
    0.103
    """
    ratio = SEA_LEVEL_PRESSURE / pressure
    clean = 2 + 0.54 * ratio - 0.5 * ratio**2 + 0.16 * ratio**3 + 0.376 * np.log(water_vapour / _MM_PER_CM)
    return float((linke_turbidity - clean) / (3.91 * np.exp(0.689 * ratio)))
