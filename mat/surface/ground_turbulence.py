"""Optical turbulence over ground, from its temperature and the air's."""

from __future__ import annotations

import numpy as np

from skyshine.mat.surface.convection import VON_KARMAN, Wind, heat_logarithm, lively, momentum_logarithm
from skyshine.mat.surface.similarity import index_structure, inverse_obukhov_length, momentum_profile
from skyshine.mat.surface.stability import Stability
from skyshine.schemas.arrays import Floats

_ITERATIONS, _DAMPING = 40, 0.5
_LEAST_RATIO = 1.0  # smallest ratio of logarithm less psi, as over the sea
_MOST_UNSTABLE = -200.0  # z / L, as over the sea


def ground_turbulence(
    surface_temperature: Floats,
    air_temperature: Floats,
    wind: Wind,
    pressure: Floats,
    roughness_length: float,
    height: Floats,
) -> Floats:
    """Cn2 over level ground whose heat flux is that of the heat balance.

    Parameters
    ----------
    surface_temperature, air_temperature, pressure : (T,) arrays
        [K], [K], [Pa]
    wind : Wind
        Its speed (T,).
    roughness_length : float
        [m]
    height : (H,) array
        Heights above the ground [m].

    Returns
    -------
    (H, T) array
        [m^(-2/3)]; vapour is neglected, which lowers it by a fifth at a Bowen ratio of 0.3. By night, values above the
        Obukhov length are those of a stable layer that has no top.

    References
    ----------
    The flux is that of the logarithmic law with `Stability`. Friction velocity and Obukhov length follow by similarity
    in unstable air; in stable air momentum is damped as heat is (Louis et al. 1982), with the long tail that keeps
    ground and air together.
    """
    speed, measured = lively(wind.speed), np.asarray(wind.height, float)
    difference = surface_temperature - air_temperature
    logarithm = momentum_logarithm(measured, roughness_length)
    neutral = VON_KARMAN**2 * speed / (logarithm * heat_logarithm(wind.air_height, roughness_length))
    factor = Stability.of(wind, air_temperature, 1.0, roughness_length).factor(difference)
    flux, damping = neutral * factor * difference, np.sqrt(np.minimum(factor, 1.0))
    inverse = np.zeros_like(flux)
    for _ in range(_ITERATIONS):
        ratio = np.maximum(logarithm - momentum_profile(measured * inverse), _LEAST_RATIO)
        friction = damping * VON_KARMAN * speed / ratio
        change = inverse_obukhov_length(friction, -flux / friction, 0.0, air_temperature)
        inverse += _DAMPING * (np.clip(change, _MOST_UNSTABLE / measured, 0.0) - inverse)
    return index_structure(height[:, None], friction, -flux / friction, 0.0, air_temperature, pressure)
