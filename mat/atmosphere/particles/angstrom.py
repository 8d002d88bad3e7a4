"""Aerosol whose extinction of sunlight follows a measured Angstrom exponent.

References
----------
Angstrom 1929, Geogr. Ann. 11, 156. Holben et al. 1998, Remote Sens. Environ. 66, 1 (sun photometers).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.particles import AerosolOptics, SpectralModel
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

EXPONENTS = (-1.0, 4.0)  # coarse dust has about -0.3, smoke up to 2.5, molecules 4
REFERENCE = 0.55  # um
# The longest wavelength of sun photometers, um. Beyond it an exponent measured in sunlight says nothing of the bands of
# absorption, which the model has.
LONGEST = 1.64


@dataclass(frozen=True, eq=False)
class AngstromModel:
    """A model with another spectral slope of extinction; answers as `aerosol.AerosolModel` does.

    Up to `LONGEST` extinction follows the power law of the exponent, beyond it the spectrum of the model, joined there.
    Single-scattering albedo, asymmetry and phase function are the model's.

    Attributes
    ----------
    model : AerosolModel or SpectralModel
    exponent : float
        Angstrom's, of extinction.
    """

    model: AerosolModel | SpectralModel
    exponent: float

    def __post_init__(self) -> None:
        low, high = EXPONENTS
        if not low <= self.exponent <= high:
            raise InputError(f"Angstrom exponent {self.exponent:g} is outside {low:g} to {high:g}")

    @property
    def name(self) -> str:
        """That of the model."""
        return self.model.name

    @property
    def wavelength(self) -> Floats:
        """Wavelength of the model's tables, um."""
        return self.model.wavelength

    def optics(self, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike) -> AerosolOptics:
        """As `aerosol.AerosolModel.optics`."""
        tabulated = self.model.optics(wavenumber, relative_humidity)
        joint = self.model.optics(1e4 / LONGEST, relative_humidity)
        wavelength = 1e4 / np.atleast_1d(np.asarray(wavenumber, dtype=float))
        by_power = (np.minimum(wavelength, LONGEST) / REFERENCE) ** -self.exponent
        extinction = by_power * np.where(wavelength > LONGEST, tabulated.extinction / joint.extinction, 1.0)
        return AerosolOptics(extinction, tabulated.single_scattering_albedo, tabulated.asymmetry)

    def phase_function(
        self, cos_angle: npt.ArrayLike, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike
    ) -> Floats:
        """As `aerosol.AerosolModel.phase_function`."""
        return self.model.phase_function(cos_angle, wavenumber, relative_humidity)

    def phase_moments(self, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike) -> Floats:
        """As `aerosol.AerosolModel.phase_moments`."""
        return self.model.phase_moments(wavenumber, relative_humidity)


ParticleModel = AerosolModel | SpectralModel | AngstromModel
