"""Thermal source function of air that scatters: emission, and what particles scatter into a line of sight.

The diffuse thermal field comes from the delta-scaled two-stream equations with hemispheric-mean closure, layer by
layer, joined by adding from the ground up. The scattered part of the source follows the first two moments of the phase
function. Scattering by molecules is far below anything thermal and is left with the emission.

References
----------
Toon et al. 1989, J. Geophys. Res. 94, 16287 (two-stream coefficients, linear thermal source).
Joseph, Wiscombe and Weinman 1976, J. Atmos. Sci. 33, 2452 (delta scaling).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.two_stream_layers import Slabs, join, vertical_column
from skyshine.mat.radiometry.blackbody import planck_wavenumber

# Pure scattering has no decay, which the closed form of a layer divides by; this little absorption changes nothing
# else.
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
    emitted = np.pi * planck_wavenumber(optics.wavenumber, state.surface_temperature)
    return join(*_layers(shells, optics), state.surface_albedo, (1 - state.surface_albedo) * emitted)


def _layers(shells, optics):
    """Reflection, transmission, and emission up and down of each layer, (N-1, P) each."""
    depth, scattering = (vertical_column(shells, part) for part in (optics.extinction, optics.aerosol_scattering))
    some = scattering > 0
    asymmetry = np.where(
        some,
        vertical_column(shells, optics.aerosol_scattering * optics.asymmetry) / np.where(some, scattering, 1.0),
        0.0,
    )
    albedo = scattering / depth
    forward = asymmetry**2
    depth = depth * (1 - albedo * forward)
    albedo = np.minimum(albedo * (1 - forward) / (1 - albedo * forward), _LARGEST_ALBEDO)
    asymmetry = asymmetry / (1 + asymmetry)

    same, other = 2 - albedo * (1 + asymmetry), albedo * (1 - asymmetry)
    slabs = Slabs.of(same, other, depth)
    reflection, transmission = slabs.reflection, slabs.transmission
    absorbed = -(1 - slabs.deep) * np.expm1(-slabs.decay * depth) / (1 + slabs.deep * slabs.left)

    bottom, top = np.pi * optics.emission[:-1], np.pi * optics.emission[1:]
    thin = depth < _THIN
    slope = (bottom - top) / (np.where(thin, 1.0, depth) * (same + other))
    level = 0.5 * absorbed * (bottom + top)
    upward = np.where(thin, level, top + slope - reflection * (top - slope) - transmission * (bottom + slope))
    downward = np.where(thin, level, bottom - slope - reflection * (bottom + slope) - transmission * (top - slope))
    return reflection, transmission, upward, downward
