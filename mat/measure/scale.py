"""Errors of atmospheric quantities as equivalent temperature or radiance of a scene at 300 K."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import kelvin_per_radiance, reference_radiance
from skyshine.schemas.arrays import Floats

# Of the surface whose reflected light counts in kelvin: nine in ten materials of the library reflect less in 3-5 and in
# 8-12 um (tests/mat/radiometry/test_reflectance.py).
REFLECTANCE = 0.3


@dataclass(frozen=True)
class Scale:
    """What errors count as.

    Attributes
    ----------
    background : float
        Radiance of a black body at 300 K, W m^-2 sr^-1: what is seen through the path.
    factor : float
        Kelvin, or 1, per W m^-2 sr^-1.
    reflectance : float
        Of a surface that faces source and sky, for ambient and direct light.
    """

    background: float
    factor: float
    reflectance: float

    @classmethod
    def kelvin(cls, response: SpectralResponse) -> Scale:
        """Equivalent temperature; not a number for bands that end before 2.5 um."""
        return cls(reference_radiance(response), kelvin_per_radiance(response), REFLECTANCE)

    @classmethod
    def radiance(cls, response: SpectralResponse) -> Scale:
        """W m^-2 sr^-1, with all light reflected."""
        return cls(reference_radiance(response), 1.0, 1.0)

    def error(self, quantity: str, read: Floats, exact: Floats, transmittance: Floats, distance: Floats) -> Floats:
        """What an error in one quantity changes of the radiance that reaches the observer.

        Parameters
        ----------
        quantity : str
            One of `gridded.QUANTITIES`.
        read, exact : arrays
            Interpolated and computed directly.
        transmittance : array
            Of the path, computed directly.
        distance : array
            km.
        """
        if quantity == "beta_star":
            error: Floats = (np.exp(-BETA_FACTOR * distance / read) - transmittance) * self.background * self.factor
        elif quantity == "path_radiance_ratio":
            error = (read - exact) * (1 - transmittance) * self.factor
        else:
            error = (read - exact) * transmittance * self.reflectance * self.factor
        return error
