"""Reflectance of the ground below the paths against wavelength."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


@dataclass(frozen=True, eq=False)
class SpectralAlbedo:
    """Reflectance of a Lambertian ground, linear between wavelengths; the end values beyond them.

    Attributes
    ----------
    wavelength : (N,) array
        [um], increasing.
    reflectance : (N,) array
        0 to 1.
    mean : float
        Mean over the band of a sensor, for users of a single albedo.
    """

    wavelength: Floats
    reflectance: Floats
    mean: float

    def __post_init__(self) -> None:
        if self.wavelength.shape != self.reflectance.shape or np.any(np.diff(self.wavelength) <= 0):
            raise InputError("wavelengths of a ground's reflectance must increase, one for each value; sort them")
        if not np.all((self.reflectance >= 0) & (self.reflectance <= 1)):
            raise InputError("found a reflectance of the ground outside 0 to 1")

    def at(self, wavenumber: Floats) -> Floats:
        """Reflectance (P,) at wavenumbers (P,) [cm^-1]."""
        reflectance: Floats = np.interp(1e4 / wavenumber, self.wavelength, self.reflectance)
        return reflectance
