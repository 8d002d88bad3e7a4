"""Radiance errors as equivalent temperatures of a black body."""

from __future__ import annotations

import numpy as np

from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance

REFERENCE = 300.0  # K, the scene temperature at which a radiance error is turned into kelvin
_STEP = 0.5  # K, half the width of the central difference
SHORTEST = 2.5  # um; in bands that end before it a scene at 300 K emits almost nothing, and none is defined


def kelvin_per_radiance(response: SpectralResponse, temperature: float = REFERENCE) -> float:
    """Change of a black body's temperature that changes its band radiance by 1 W m^-2 sr^-1.

    Not a number for bands that end before 2.5 um: radiance errors there have no equivalent temperature.
    """
    if response.upper < SHORTEST:
        return float("nan")
    low, high = band_radiance(response, np.array([temperature - _STEP, temperature + _STEP]))
    return 2 * _STEP / float(high - low)


def reference_radiance(response: SpectralResponse) -> float:
    """Band radiance of a black body at 300 K, W m^-2 sr^-1."""
    return float(band_radiance(response, REFERENCE))
