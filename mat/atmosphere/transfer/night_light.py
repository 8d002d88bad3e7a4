"""Light of the night sky under the air: every direction of the sky is the beam of a distant source.

So the solver that scatters sunlight scatters this light too, and what is direct and what is scattered add up.
"""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.sources.night_sky import LAYER_HEIGHT, airglow_radiance, starlight_radiance, van_rhijn
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.schemas.arrays import Floats

ELEVATIONS = 6  # Gauss nodes in the sine of elevation; 12 change irradiance by less than 1 %


def night_irradiance(air: SpectralAir, altitude: Floats) -> Floats:
    """Irradiance of level surfaces by the night sky, direct and scattered.

    Parameters
    ----------
    altitude : (Z,) array
        [m]; above the airglow, the layer is taken just above.

    Returns
    -------
    (Z, P) array
        [W m^-2 (cm^-1)^-1]; 0 where the state has no night sky.
    """
    factor, wavenumber = air.state.night_sky, air.optics.wavenumber
    if factor == 0 or not np.any(night_radiance(air, 1.0, 0.0) > 0):
        return np.zeros((altitude.size, wavenumber.size))
    node, weight = np.polynomial.legendre.leggauss(ELEVATIONS)
    sine, weight = 0.5 * (node + 1), 0.5 * weight
    elevation = np.arcsin(sine)
    direct = direct_transmittance(air.source_paths, altitude, elevation)
    arriving = sine[:, None] * direct
    if air.scatters:
        arriving = arriving + sky_irradiance(air, altitude, elevation).scattered
    below = np.minimum(altitude, 0.99 * LAYER_HEIGHT)
    radiance = np.stack([[night_radiance(air, float(s), float(z)) for s in sine] for z in below])
    irradiance: Floats = 2 * np.pi * np.einsum("s,zsp,zsp->zp", weight, radiance, arriving)
    return irradiance


def night_radiance(air: SpectralAir, sine: float, altitude: float) -> Floats:
    """Radiance (P,) of the night sky outside the lower atmosphere [W m^-2 sr^-1 (cm^-1)^-1].

    Parameters
    ----------
    air : SpectralAir
        The factor of its state is that of airglow; without it there is no starlight either.
    sine : float
        Sine of the elevation of the line of sight, above the horizon.
    altitude : float
        [m].
    """
    factor, wavenumber = air.state.night_sky, air.optics.wavenumber
    if factor == 0:
        return np.zeros(wavenumber.size)
    glow = factor * airglow_radiance(wavenumber) * van_rhijn(sine, min(altitude, 0.99 * LAYER_HEIGHT))
    radiance: Floats = glow + starlight_radiance(wavenumber)
    return radiance
