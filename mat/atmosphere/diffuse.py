"""Thermal source function of air that scatters: emission, and what particles scatter into a line of sight.

The diffuse thermal field comes from the delta-scaled two-stream equations with hemispheric-mean closure, layer by layer, joined
by adding from the ground up. The scattered part of the source follows the first two moments of the phase function. Scattering by
molecules is far below anything thermal and is left with the emission.

References
----------
Toon et al. 1989, J. Geophys. Res. 94, 16287 (two-stream coefficients, linear thermal source).
Joseph, Wiscombe and Weinman 1976, J. Atmos. Sci. 33, 2452 (delta scaling).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.geometry import trace
from skyshine.mat.radiometry import planck_wavenumber

# Pure scattering has no decay, which the closed form of a layer divides by; this little absorption changes nothing else.
_LARGEST_ALBEDO = 1 - 1e-9
# Below this optical depth a layer emits as if it had its mean temperature.
_THIN = 1e-3


@dataclass(frozen=True, eq=False)
class ThermalSource:
    """Source function of thermal radiation at N levels and P points, W m^-2 sr^-1 (cm^-1)^-1.

    Attributes
    ----------
    mean : (N, P) array
        For horizontal radiation.
    tilt : (N, P) array
        Radiation that rises sees mean + tilt, radiation that falls mean - tilt; between, in proportion to `lean`.
    """

    mean: np.ndarray
    tilt: np.ndarray


def lean(cosine):
    """Share of the tilt for radiation that travels at a cosine of the zenith angle, -1 to 1.

    3/2 of the cosine is the first moment of Eddington's field; beyond 1 it would make the source negative.
    """
    return np.clip(1.5 * np.asarray(cosine), -1.0, 1.0)


def thermal_source(state, shells, optics):
    """The source function of a state; its ground radiates and reflects from below.

    Parameters
    ----------
    state : AtmosphericState
    shells : Shells
    optics : SpectralOptics

    Returns
    -------
    ThermalSource
        The blackbody radiance alone where there are no particles.
    """
    emission = optics.emission
    if not np.any(optics.aerosol_scattering):
        return ThermalSource(emission, np.zeros_like(emission))
    rising, falling = _fluxes(state, shells, optics)
    albedo = optics.aerosol_scattering / optics.extinction
    mean = emission + albedo * ((rising + falling) / (2 * np.pi) - emission)
    return ThermalSource(mean, albedo * optics.asymmetry * (rising - falling) / (2 * np.pi))


def _fluxes(state, shells, optics):
    """Upward and downward thermal flux at the levels, (N, P) each, W m^-2 (cm^-1)^-1."""
    reflection, transmission, upward, downward = _layers(shells, optics)
    count = reflection.shape[0]
    below = np.empty((count + 1, reflection.shape[1]))  # albedo of all that lies under a level
    source = np.empty_like(below)  # what it sends up by itself
    below[0] = state.surface_albedo
    source[0] = (1 - state.surface_albedo) * np.pi * planck_wavenumber(optics.wavenumber, state.surface_temperature)
    for k in range(count):
        bounce = transmission[k] / (1 - reflection[k] * below[k])
        below[k + 1] = reflection[k] + transmission[k] * bounce * below[k]
        source[k + 1] = upward[k] + bounce * (source[k] + below[k] * downward[k])
    falling = np.zeros_like(below)
    for k in range(count - 1, -1, -1):
        arriving = transmission[k] * falling[k + 1] + downward[k] + reflection[k] * source[k]
        falling[k] = arriving / (1 - reflection[k] * below[k])
    return source + below * falling, falling


def _layers(shells, optics):
    """Reflection, transmission, and emission up and down of each layer, (N-1, P) each."""
    zenith = trace(shells, shells.altitude[:1], np.array([np.pi / 2]))
    count = shells.altitude.size - 1
    lower, upper = (part[0, count:, None] for part in (zenith.lower, zenith.upper))  # the segments on the way up

    def column(values):
        return lower * values[:-1] + upper * values[1:]

    depth, scattering = column(optics.extinction), column(optics.aerosol_scattering)
    some = scattering > 0
    asymmetry = np.where(
        some, column(optics.aerosol_scattering * optics.asymmetry) / np.where(some, scattering, 1.0), 0.0
    )
    albedo = scattering / depth
    forward = asymmetry**2
    depth = depth * (1 - albedo * forward)
    albedo = np.minimum(albedo * (1 - forward) / (1 - albedo * forward), _LARGEST_ALBEDO)
    asymmetry = asymmetry / (1 + asymmetry)

    same, other = 2 - albedo * (1 + asymmetry), albedo * (1 - asymmetry)
    decay = np.sqrt((same - other) * (same + other))
    deep = other / (same + decay)  # reflection of an infinitely deep layer
    left = np.exp(-decay * depth)
    reflection = -deep * np.expm1(-2 * decay * depth) / (1 - (deep * left) ** 2)
    transmission = (1 - deep**2) * left / (1 - (deep * left) ** 2)
    absorbed = -(1 - deep) * np.expm1(-decay * depth) / (1 + deep * left)

    bottom, top = np.pi * optics.emission[:-1], np.pi * optics.emission[1:]
    thin = depth < _THIN
    slope = (bottom - top) / (np.where(thin, 1.0, depth) * (same + other))
    level = 0.5 * absorbed * (bottom + top)
    upward = np.where(thin, level, top + slope - reflection * (top - slope) - transmission * (bottom + slope))
    downward = np.where(thin, level, bottom - slope - reflection * (bottom + slope) - transmission * (top - slope))
    return reflection, transmission, upward, downward
