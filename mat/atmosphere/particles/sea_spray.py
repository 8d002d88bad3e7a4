"""Large drops of sea spray by wind and height.

The packaged maritime aerosols have particles of up to some 5 um, which the wind mixes evenly. Drops of about 10 um fall
faster: near the water there are more of them. The Navy's coastal model (ANAM) has a fourth mode for them (Gathman, van
Eijk and Cohen 1998, Proc. SPIE 3433), whose coefficients are not public; here their number follows from a published
flux of spray. Their number at height z follows from the balance of fall and mixing, v n = -0.4 u* z dn/dz.

References
----------
Smith, Park and Consterdine 1993, Q. J. R. Meteorol. Soc. 119, 809: flux of drops of 1 to 25 um in winds from 0 to more
than 30 m/s, from numbers at about 10 m for which as many drops fall as are made; the second of its two modes, 9.2 um.
Andreas 1998, J. Phys. Oceanogr. 28, 2175, appendix: the same coefficients, by the radius at 80 % humidity and the wind
at 14 m. Hoppel, Frick and Fitzgerald 2002, J. Geophys. Res. 107, 4382: that balance is one of radii above 5 to 10 um.
Gathman 1983, Opt. Eng. 22, 57: growth by humidity, as LOWTRAN7 has it in its Navy maritime model.
"""

from __future__ import annotations

import numpy as np
import scipy

from skyshine.mat.atmosphere.particles.aerosol_layer import AerosolLayer
from skyshine.mat.atmosphere.particles.cloud import RADII, CloudLayer
from skyshine.mat.radiometry.constants import STANDARD_GRAVITY
from skyshine.mat.surface.convection import VON_KARMAN
from skyshine.schemas.arrays import Floats

MARITIME = ("maritime", "navy_maritime", "opac_maritime_clean", "opac_maritime_polluted", "opac_maritime_tropical")
# Smith et al. 1993 and Andreas 1998, (A1) to (A5): the second mode at 80 % humidity, m^-2 s^-1 um^-1.
_RADIUS, _NARROWNESS, _WIND_SLOPE, _WIND_OFFSET = 9.2, 3.3, 0.959, -1.476
_STRONGEST_WIND = 30.0  # m/s, of the measurements
_MOST_HUMID = 0.98  # fraction of growth, as in the Navy maritime aerosol
_WATER_DENSITY, _VISCOSITY = 1030.0, 1.8e-5  # kg m^-3 of sea water; Pa s of air at 15 C
_REFERENCE = 10.0  # m, near the height of the measurements
_TOP = 600.0  # m: depth of the mixed layer that COARE takes
_LOWEST = 1.0  # m: waves mix the air below
_STEEPEST = 1.0  # largest power of height: a chosen bound for light winds, in which few drops are made
_EXTINCTION = 2.1  # efficiency at 0.55 um of drops of about 10 um: Mie theory (Bohren and Huffman 1983, section 4.4)
_RADII = np.linspace(1.0, 40.0, 400)  # um at 80 %; those above 25, where nothing was measured, have 1.4 %


def sea_spray(wind_speed: float, friction_velocity: float, relative_humidity: float) -> AerosolLayer:
    """Drops of about 10 um over the sea.

    Parameters
    ----------
    wind_speed : float
        Wind speed at 10 m [m/s].
    friction_velocity : float
        u* [m/s]
    relative_humidity : float
        Relative humidity at 10 m [percent].

    Returns
    -------
    AerosolLayer
        To 600 m above the water; optical properties of water drops of their effective radius.
    """
    wind = min(wind_speed + friction_velocity / VON_KARMAN * np.log(14 / 10), _STRONGEST_WIND)
    flux = 10 ** (_WIND_SLOPE * np.sqrt(wind) + _WIND_OFFSET) * np.exp(-_NARROWNESS * np.log(_RADII / _RADIUS) ** 2)
    humid = min(relative_humidity / 100, _MOST_HUMID)
    growth = ((2 - humid) / (6 * (1 - humid))) ** (1 / 3)
    radius = growth * _RADII * 1e-6
    number = flux / fall_speed(radius)  # m^-3 um^-1: as many fall as are made
    power = np.minimum(fall_speed(radius) / (VON_KARMAN * friction_velocity), _STEEPEST)
    height = np.array([0.0, _LOWEST, 2.0, 5.0, _REFERENCE, 20.0, 50.0, 150.0, 300.0, _TOP])
    ratio = np.maximum(height, _LOWEST)[:, None] / _REFERENCE
    extinction = scipy.integrate.trapezoid(_EXTINCTION * np.pi * radius**2 * number * ratio**-power, _RADII, axis=1)
    effective = (
        1e6
        * scipy.integrate.trapezoid(radius**3 * number, _RADII)
        / scipy.integrate.trapezoid(radius**2 * number, _RADII)
    )
    drops = CloudLayer("water", 0.0, _TOP, float(np.clip(effective, *RADII["water"])), 0.0).model
    return AerosolLayer.measured(drops, height, extinction, None)


def fall_speed(radius: Floats) -> Floats:
    """Speed [m/s] at which drops of radii [m] of up to some 30 um fall: Stokes' law."""
    speed: Floats = 2 * _WATER_DENSITY * STANDARD_GRAVITY * radius**2 / (9 * _VISCOSITY)
    return speed
