"""Aerosols of spheres of known sizes and refractive indices, by Mie theory.

References
----------
Hess et al. 1998, Bull. Am. Meteorol. Soc. 79, 831 (log-normal components). Hansen and Travis 1974, Space Sci. Rev. 16,
527.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skyshine.mat.atmosphere.particles.mie import Complexes, phase_of_spheres
from skyshine.mat.atmosphere.particles.moments import MOMENTS
from skyshine.mat.atmosphere.particles.particles import SphereModel
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

MEDIAN_RADII = (0.001, 20.0)  # um
GEOMETRIC_SDS = (1.05, 4.0)  # geometric standard deviations: nearly one radius, to beyond measured aerosol
# Radii that are integrated over, um: smaller spheres hardly scatter, larger ones fall within minutes.
RADII = (0.0005, 100.0)
_STEPS_PER_SD, _MOST_RADII = 60, 600
# Standard deviations of the distribution of cross sections, and of volumes where spheres are small, that are kept.
_KEPT = 4.5
# um; properties follow power laws between them.
_WAVELENGTHS = np.unique(np.append(np.geomspace(0.25, 40.0, 64), 0.55))
_ANGLES = np.unique(
    np.concatenate([np.arange(0, 2, 0.1), np.arange(2, 10, 0.5), np.arange(10, 170, 2), np.arange(170, 180.1, 1)])
)


@dataclass(frozen=True)
class RefractiveIndex:
    """n + ik at wavelengths [um] that increase; the logarithm of an absorbing k is linear in that of wavelength."""

    wavelength: tuple[float, ...]
    real: tuple[float, ...]
    imaginary: tuple[float, ...]

    def at(self, wavelength: Floats) -> Complexes:
        """(P,) at wavelengths (P,)."""
        nodes, log = np.log(self.wavelength), np.log(wavelength)
        real, imaginary = np.interp(log, nodes, self.real), np.interp(log, nodes, self.imaginary)
        if min(self.imaginary) > 0:
            imaginary = np.exp(np.interp(log, nodes, np.log(self.imaginary)))
        return np.asarray(real + 1j * imaginary)


@dataclass(frozen=True)
class LogNormalMode:
    """Spheres of one material.

    Attributes
    ----------
    median_radius : float
        Median radius of the number distribution, um.
    geometric_sd : float
        Geometric standard deviation of the radius.
    number : float
        Number of spheres, in a measure common to all modes.
    largest_radius : float
        um, beyond which there are none.
    """

    median_radius: float
    geometric_sd: float
    number: float
    refractive_index: RefractiveIndex
    largest_radius: float = RADII[1]

    def __post_init__(self) -> None:
        for name, value, (low, high) in (
            ("median radius", self.median_radius, MEDIAN_RADII),
            ("geometric standard deviation", self.geometric_sd, GEOMETRIC_SDS),
        ):
            if not low <= value <= high:
                raise InputError(f"{name} {value:g} is outside {low:g} to {high:g}")
        if not 0 < self.number < np.inf:
            raise InputError(f"number {self.number:g} of a mode is not allowed; give one above 0")

    def radii(self) -> Floats:
        """Radii (K,) [um] to integrate over."""
        log_sd = np.log(self.geometric_sd)
        middle = np.log(self.median_radius)
        low = max(middle - _KEPT * log_sd, np.log(RADII[0]))
        high = min(middle + 6 * log_sd**2 + _KEPT * log_sd, np.log(self.largest_radius))
        steps = int(np.clip(_STEPS_PER_SD * (high - low) / log_sd, 100, _MOST_RADII))
        return np.exp(np.linspace(low, high, steps))

    def number_per_radius(self, radius: Floats) -> Floats:
        """At radii (K,) [um]."""
        log_sd = np.log(self.geometric_sd)
        exponent = -0.5 * (np.log(radius / self.median_radius) / log_sd) ** 2
        return np.asarray(self.number * np.exp(exponent) / (np.sqrt(2 * np.pi) * log_sd * radius))


@dataclass(frozen=True, eq=False)
class ModeScattering:
    """Scattering of some modes together, each of spheres of its own material.

    Attributes
    ----------
    extinction, absorption : (W,) arrays
        um^2 times the measure of the modes' numbers.
    phase : (A, W) array
        Mean over the sphere 1.
    moments : (`MOMENTS`, W) array
    """

    extinction: Floats
    absorption: Floats
    phase: Floats
    moments: Floats


def scattering_of_modes(modes: tuple[LogNormalMode, ...], wavelength: Floats, angle: Floats) -> ModeScattering:
    """Scattering at wavelengths (W,) [um] and angles (A,) [degree] that increase."""
    extinction, absorption = np.zeros(wavelength.size), np.zeros(wavelength.size)
    phase, moments = np.zeros((angle.size, wavelength.size)), np.zeros((MOMENTS, wavelength.size))
    for mode in modes:
        radius = mode.radii()
        number = mode.number_per_radius(radius)[None]
        for row, index in enumerate(mode.refractive_index.at(wavelength)):
            sections, at_angle, legendre = phase_of_spheres(
                radius, number, complex(index), float(wavelength[row]), np.radians(angle), MOMENTS
            )
            scattering = min(sections[1, 0], sections[0, 0])
            extinction[row] += sections[0, 0]
            absorption[row] += sections[0, 0] - scattering
            phase[:, row] += scattering * at_angle[0]
            moments[:, row] += scattering * legendre[0]
    scattered = moments[0].copy()
    return ModeScattering(extinction, absorption, phase / scattered, moments / scattered)


@lru_cache(maxsize=16)
def sphere_mixture(name: str, modes: tuple[LogNormalMode, ...]) -> SphereModel:
    """The aerosol of some modes together.

    Returns
    -------
    SphereModel
        From 0.25 to 40 um.
    """
    light = scattering_of_modes(modes, _WAVELENGTHS, _ANGLES)
    return SphereModel.of_table(
        name,
        _WAVELENGTHS,
        light.extinction,
        light.absorption,
        light.moments[1],
        phase_angle=_ANGLES,
        phase_wavelength=_WAVELENGTHS,
        phase=light.phase,
        moments=light.moments,
    )[0]
