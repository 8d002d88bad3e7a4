"""Particles whose optical properties depend on wavelength alone, with the phase function of Henyey and Greenstein."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles.tables import Columns
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


@dataclass(frozen=True)
class AerosolOptics:
    """Optical properties of particles; every array has the shape (L, P) of humidity and wavenumber.

    Attributes
    ----------
    extinction : array
        Relative to extinction at 0.55 um.
    single_scattering_albedo, asymmetry : array
    """

    extinction: Floats
    single_scattering_albedo: Floats
    asymmetry: Floats


@dataclass(frozen=True, eq=False)
class HenyeyGreensteinModel:
    """Optical properties at W wavelengths; answers as `aerosol.AerosolModel` does, whatever the humidity.

    Attributes
    ----------
    name : str
    wavelength : (W,) array
        um, increasing.
    extinction, absorption : (W,) arrays
        Relative to extinction at 0.55 um.
    asymmetry : (W,) array
    """

    name: str
    wavelength: Floats
    extinction: Floats
    absorption: Floats
    asymmetry: Floats

    @classmethod
    def of_table(
        cls,
        name: str,
        wavelength: Floats,
        extinction: Floats,
        absorption: Floats,
        asymmetry: Floats,
    ) -> tuple[HenyeyGreensteinModel, float]:
        """The model of a table (W,) in any measure, and its extinction at 0.55 um in that measure."""
        at_550 = float(np.interp(0.55, wavelength, extinction))
        return cls(name, wavelength, extinction / at_550, absorption / at_550, asymmetry), at_550

    def optics(self, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike) -> AerosolOptics:
        """Extinction, single-scattering albedo and asymmetry; arguments, result and errors as
        `aerosol.AerosolModel.optics`.

        Linear in wavelength; beyond the table extinction falls as 1 / wavelength, as there.
        """
        wavelength = self._wavelength(wavenumber)
        extinction, absorption, asymmetry = (
            np.interp(wavelength, self.wavelength, table)
            for table in (self.extinction, self.absorption, self.asymmetry)
        )
        beyond = np.minimum(1.0, self.wavelength[-1] / wavelength)
        shape = (np.size(relative_humidity), wavelength.size)
        return AerosolOptics(
            *(np.broadcast_to(part, shape) for part in (extinction * beyond, 1.0 - absorption / extinction, asymmetry))
        )

    def phase_function(
        self, cos_angle: npt.ArrayLike, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike
    ) -> Floats:
        """Phase function (A, L, P), mean over the sphere 1; arguments as `aerosol.AerosolModel.phase_function`.

        References
        ----------
        Henyey and Greenstein 1941, Astrophys. J. 93, 70.
        """
        g = np.interp(self._wavelength(wavenumber), self.wavelength, self.asymmetry)
        cosine = np.atleast_1d(np.asarray(cos_angle, dtype=float))[:, None]
        phase = (1 - g**2) / (1 + g**2 - 2 * g * cosine) ** 1.5
        return np.broadcast_to(phase[:, None], (cosine.shape[0], np.size(relative_humidity), g.size))

    def _wavelength(self, wavenumber: npt.ArrayLike) -> Floats:
        wavelength: Floats = 1e4 / np.atleast_1d(np.asarray(wavenumber, dtype=float))
        if not np.all((wavelength >= self.wavelength[0] * (1 - 1e-9)) & np.isfinite(wavelength)):
            raise InputError(f"'{self.name}' is tabulated from {self.wavelength[0]:g} um on; ask for longer waves")
        return wavelength


def interpolated_table(table: Columns, value: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Rows of a table at one value of its first column.

    Parameters
    ----------
    table : dict of arrays
        A first column of nodes above 0, wavelength, extinction, absorption, asymmetry.
    value : float
        Held at the first and last node.

    Returns
    -------
    wavelength, extinction, absorption, asymmetry : (W,) arrays
        Logarithms of extinction and absorption, and asymmetry, linear in the logarithm of the first column.
    """
    nodes, *columns = table.values()
    nodes = np.unique(nodes)
    wavelength, extinction, absorption, asymmetry = (column.reshape(nodes.size, -1) for column in columns)
    place = np.interp(np.log(value), np.log(nodes), np.arange(nodes.size))
    lower = min(int(place), nodes.size - 2)
    share = place - lower

    def between(values: Floats) -> Floats:
        mean: Floats = (1 - share) * values[lower] + share * values[lower + 1]
        return mean

    return wavelength[0], np.exp(between(np.log(extinction))), np.exp(between(np.log(absorption))), between(asymmetry)
