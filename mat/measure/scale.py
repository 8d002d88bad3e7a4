"""Errors of atmospheric quantities as equivalent temperature or radiance of a scene at 300 K."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import SHORTEST, kelvin_per_radiance, reference_radiance
from skyshine.schemas.arrays import Floats

# Reflectance of the surface whose reflected light counts in kelvin: nine in ten materials of the library reflect less
# in 3-5 and in 8-12 um (tests/mat/radiometry/test_reflectance.py).
REFLECTANCE = 0.3
PERCENT_PER_KELVIN = 3.0  # percent per kelvin of light, in bands in which a scene emits almost nothing
UNITS = ("K", "%", "W m^-2 sr^-1")


@dataclass(frozen=True)
class Scale:
    """What errors count as.

    Attributes
    ----------
    background : float
        Radiance seen through the path, W m^-2 sr^-1: of a black body at 300 K, or reflected.
    factor : float
        Kelvin, percent, or 1, per W m^-2 sr^-1.
    reflectance : float
        Reflectance of a surface that faces source and sky, for ambient and direct light.
    relative : bool
        Errors of path radiance that is brighter than the background count in it.
    """

    background: float
    factor: float
    reflectance: float
    relative: bool = False

    @classmethod
    def kelvin(cls, response: SpectralResponse) -> Scale:
        """Equivalent temperature; not a number for bands that end before 2.5 um."""
        return cls(reference_radiance(response), kelvin_per_radiance(response), REFLECTANCE)

    @classmethod
    def radiance(cls, response: SpectralResponse) -> Scale:
        """W m^-2 sr^-1, with all light reflected."""
        return cls(reference_radiance(response), 1.0, 1.0)

    @classmethod
    def of_unit(cls, unit: str, response: SpectralResponse, irradiance: float) -> Scale:
        """In the unit of a tolerance.

        Percent are of a black body at 300 K, or of path radiance where that is brighter, as towards the Sun. In bands
        that end before 2.5 um, where a scene at 300 K emits almost nothing, they are of the light that a surface
        reflects of the source alone in place of the black body, and `PERCENT_PER_KELVIN` of them count as a kelvin.

        Parameters
        ----------
        unit : {'K', '%', 'W m^-2 sr^-1'}
        irradiance : float
            Irradiance of the source outside the atmosphere, in band, W m^-2.
        """
        if unit not in UNITS:
            raise ValueError(f"unit '{unit}'; known: {', '.join(UNITS)}")
        if unit == "W m^-2 sr^-1":
            return cls.radiance(response)
        emits = response.upper >= SHORTEST
        if unit == "K" and emits:
            return cls.kelvin(response)
        light = reference_radiance(response) if emits else REFLECTANCE * irradiance / np.pi
        percent = 100 / light if light > 0 else float("nan")
        return cls(light, percent / (PERCENT_PER_KELVIN if unit == "K" else 1.0), REFLECTANCE, relative=True)

    def error(self, quantity: str, read: Floats, exact: Floats, transmittance: Floats, distance: Floats) -> Floats:
        """What an error in one quantity changes of the radiance that reaches the observer.

        Parameters
        ----------
        quantity : str
            One of `gridded.QUANTITIES`.
        read, exact : arrays
            Interpolated and computed directly.
        transmittance : array
            Transmittance of the path, computed directly.
        distance : array
            km.
        """
        if quantity == "beta_star":
            error: Floats = (np.exp(-BETA_FACTOR * distance / read) - transmittance) * self.background * self.factor
        elif quantity == "path_radiance_ratio":
            path = exact * (1 - transmittance)
            brighter = np.maximum(path / self.background, 1.0) if self.relative else 1.0
            error = (read - exact) * (1 - transmittance) * self.factor / brighter
        else:
            error = (read - exact) * transmittance * self.reflectance * self.factor
        return error
