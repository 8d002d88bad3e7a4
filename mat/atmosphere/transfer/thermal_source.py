"""Thermal source function of air that scatters: emission, and diffuse radiation scattered into a line of sight.

The diffuse thermal field comes from the delta-scaled two-stream equations with hemispheric-mean closure, layer by
layer, joined by adding from the ground up. The scattered part of the source follows the first two moments of the phase
function. Scattering by molecules is negligible at thermal wavelengths and is counted as absorption.

References
----------
Toon et al. 1989, J. Geophys. Res. 94, 16287 (two-stream coefficients, linear thermal source).
Joseph, Wiscombe and Weinman 1976, J. Atmos. Sci. 33, 2452 (delta scaling).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.two_stream_layers import TwoStreamLayers, add_layers, vertical_column
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.arrays import Floats, Reals

# Without absorption lambda is 0, by which the closed form of a layer divides; this much absorption changes no result
# otherwise.
_LARGEST_ALBEDO = 1 - 1e-9
# Below this optical depth a layer emits as if it had its mean temperature.
_THIN = 1e-3


@dataclass(frozen=True, eq=False)
class ThermalSource:
    """Source function of thermal radiation at N levels and P points, W m^-2 sr^-1 (cm^-1)^-1.

    Attributes
    ----------
    mean : (N, P) array
        For horizontal radiation; single or double precision.
    tilt : (N, P) array
        The source is mean + tilt for radiation straight up, mean - tilt straight down, mean + `tilt_weight` * tilt
        between.
    """

    mean: Reals
    tilt: Reals


def tilt_weight(cosine: npt.ArrayLike) -> Floats:
    """Weight of the tilt, -1 to 1, for radiation that travels at a cosine of the angle from the vertical.

    3/2 of the cosine is the first moment of Eddington's field; beyond 1 it would make the source negative.
    """
    weight: Floats = np.clip(1.5 * np.asarray(cosine), -1.0, 1.0)
    return weight


def thermal_source(state: AtmosphericState, shells: Shells, optics: SpectralOptics) -> ThermalSource:
    """The source function of a state; its ground emits and reflects from below.

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


def _fluxes(state: AtmosphericState, shells: Shells, optics: SpectralOptics) -> tuple[Floats, Floats]:
    """Upward and downward thermal flux at the levels, (N, P) each, W m^-2 (cm^-1)^-1."""
    emitted = np.pi * planck_wavenumber(optics.wavenumber, state.surface_temperature)
    albedo = state.albedo_at(optics.wavenumber)
    return add_layers(*_layers(shells, optics), albedo, (1 - albedo) * emitted)


def _layers(shells: Shells, optics: SpectralOptics) -> tuple[Floats, Floats, Floats, Floats]:
    """Reflection, transmission, and emission up and down [W m^-2 (cm^-1)^-1] of each layer, (N-1, P) each.

    References
    ----------
    Toon et al. 1989, equations 25 to 27, for a source linear in optical depth; hemispheric mean: gamma1 = 2 - omega
    (1 + g), gamma2 = omega (1 - g).
    """
    tau, omega, g = _delta_scaled(shells, optics)
    gamma1, gamma2 = 2 - omega * (1 + g), omega * (1 - g)
    layers = TwoStreamLayers.of(gamma1, gamma2, tau)
    reflection, transmission = layers.reflection, layers.transmission
    absorption = -(1 - layers.Gamma) * np.expm1(-layers.lambda_ * tau) / (1 + layers.Gamma * layers.exp_lambda_tau)

    bottom, top = np.pi * optics.emission[:-1], np.pi * optics.emission[1:]
    thin = tau < _THIN
    slope = (bottom - top) / (np.where(thin, 1.0, tau) * (gamma1 + gamma2))
    isothermal = 0.5 * absorption * (bottom + top)
    upward = np.where(thin, isothermal, top + slope - reflection * (top - slope) - transmission * (bottom + slope))
    downward = np.where(thin, isothermal, bottom - slope - reflection * (bottom + slope) - transmission * (top - slope))
    return reflection, transmission, upward, downward


def _delta_scaled(shells: Shells, optics: SpectralOptics) -> tuple[Floats, Floats, Floats]:
    """Optical depth, single-scattering albedo and asymmetry of each layer, (N-1, P) each, delta scaled with f = g^2.

    References
    ----------
    Joseph, Wiscombe and Weinman 1976, equations 5 and 13.
    """
    tau, scattering = (vertical_column(shells, part) for part in (optics.extinction, optics.aerosol_scattering))
    scatters = scattering > 0
    g = np.where(
        scatters,
        vertical_column(shells, optics.aerosol_scattering * optics.asymmetry) / np.where(scatters, scattering, 1.0),
        0.0,
    )
    omega = scattering / tau
    f = g**2
    scaled_tau = tau * (1 - omega * f)
    scaled_omega = np.minimum(omega * (1 - f) / (1 - omega * f), _LARGEST_ALBEDO)
    return scaled_tau, scaled_omega, g / (1 + g)
