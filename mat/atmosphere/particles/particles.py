"""Particles whose optical properties depend on wavelength alone."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles.moments import MOMENTS
from skyshine.mat.atmosphere.particles.tables import Columns, PhaseTable
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
class SpectralModel(ABC):
    """Optical properties at W wavelengths; answers as `aerosol.AerosolModel` does, whatever the humidity.

    Attributes
    ----------
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
        **scattering: Any,
    ) -> tuple[Self, float]:
        """The model of a table (W,) in any measure, and its extinction at 0.55 um in that measure; `scattering` are the
        further attributes of the class.
        """
        at_550 = float(between_wavelengths(wavelength, extinction, absorption, np.array([0.55]))[0][0])
        return cls(name, wavelength, extinction / at_550, absorption / at_550, asymmetry, **scattering), at_550

    def optics(self, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike) -> AerosolOptics:
        """Extinction, single-scattering albedo and asymmetry; arguments, result and errors as
        `aerosol.AerosolModel.optics`.
        """
        wavelength = self._wavelength(wavenumber)
        extinction, albedo = between_wavelengths(self.wavelength, self.extinction, self.absorption, wavelength)
        asymmetry = np.interp(wavelength, self.wavelength, self.asymmetry)
        shape = (np.size(relative_humidity), wavelength.size)
        return AerosolOptics(*(np.broadcast_to(part, shape) for part in (extinction, albedo, asymmetry)))

    def phase_function(
        self, cos_angle: npt.ArrayLike, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike
    ) -> Floats:
        """Phase function (A, L, P), mean over the sphere 1; arguments as `aerosol.AerosolModel.phase_function`."""
        cosine = np.atleast_1d(np.asarray(cos_angle, dtype=float))
        phase = self._phase(cosine, self._wavelength(wavenumber))[:, None]
        return np.broadcast_to(phase, (cosine.size, np.size(relative_humidity), phase.shape[-1]))

    def phase_moments(self, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike) -> Floats:
        """Legendre moments (`MOMENTS`, L, P) of the phase function; arguments as `phase_function`."""
        moments = self._moments(self._wavelength(wavenumber))[:, None]
        return np.broadcast_to(moments, (MOMENTS, np.size(relative_humidity), moments.shape[-1]))

    @abstractmethod
    def _phase(self, cosine: Floats, wavelength: Floats) -> Floats:
        """Phase function (A, P) at cosines (A,) and wavelengths (P,) [um]."""

    @abstractmethod
    def _moments(self, wavelength: Floats) -> Floats:
        """Its Legendre moments (`MOMENTS`, P)."""

    def _wavelength(self, wavenumber: npt.ArrayLike) -> Floats:
        wavelength: Floats = 1e4 / np.atleast_1d(np.asarray(wavenumber, dtype=float))
        if not np.all((wavelength >= self.wavelength[0] * (1 - 1e-9)) & np.isfinite(wavelength)):
            raise InputError(f"'{self.name}' is tabulated from {self.wavelength[0]:g} um on; ask for longer waves")
        return wavelength


@dataclass(frozen=True, eq=False)
class HenyeyGreensteinModel(SpectralModel):
    """Particles of which the mean cosine of the scattering angle is all that is known of their phase function.

    References
    ----------
    Henyey and Greenstein 1941, Astrophys. J. 93, 70.
    """

    def _phase(self, cosine: Floats, wavelength: Floats) -> Floats:
        return henyey_greenstein(np.interp(wavelength, self.wavelength, self.asymmetry), cosine[:, None])

    def _moments(self, wavelength: Floats) -> Floats:
        g = np.interp(wavelength, self.wavelength, self.asymmetry)
        moments: Floats = g ** np.arange(MOMENTS)[:, None]
        return moments


@dataclass(frozen=True, eq=False)
class SphereModel(SpectralModel):
    """Spheres, with phase functions by Mie theory.

    Attributes
    ----------
    phase_angle : (A,) array
        Degree.
    phase_wavelength : (V,) array
        um.
    phase : (A, V) array
        Mean over the sphere 1.
    moments : (`MOMENTS`, V) array
        Legendre moments of the phase function, which those of its values between the angles only come near to.
    """

    phase_angle: Floats
    phase_wavelength: Floats
    phase: Floats
    moments: Floats

    def _phase(self, cosine: Floats, wavelength: Floats) -> Floats:
        angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        at_angle = np.exp(linear_weights(self.phase_angle, angle).T @ np.log(self.phase))
        phase: Floats = at_angle @ linear_weights(self.phase_wavelength, wavelength)
        return phase

    def _moments(self, wavelength: Floats) -> Floats:
        moments: Floats = self.moments @ linear_weights(self.phase_wavelength, wavelength)
        return moments


def henyey_greenstein(asymmetry: npt.ArrayLike, cosine: Floats) -> Floats:
    """Phase function of Henyey and Greenstein, mean over the sphere 1; the arguments broadcast against each other."""
    g = np.asarray(asymmetry, dtype=float)
    phase: Floats = (1 - g**2) / (1 + g**2 - 2 * g * cosine) ** 1.5
    return phase


def between_wavelengths(
    nodes: Floats, extinction: Floats, absorption: Floats, wavelength: Floats
) -> tuple[Floats, Floats]:
    """Extinction and single-scattering albedo at any wavelength, from tables of extinction and absorption.

    Both tables follow power laws of the wavelength between its nodes, as extinction by small particles does (Angstrom
    1929). Next to a node without absorption the absorbed share of the extinction is linear in the logarithm of the
    wavelength, so that the albedo stays between those of the nodes. Below the first node its values are taken.
    Beyond the last extinction falls as 1 / wavelength (absorption by small particles: Bohren and Huffman 1983, section
    5.1), and the albedo stays.

    Parameters
    ----------
    nodes : (W,) array
        Wavelengths of the tables, um, increasing.
    extinction, absorption : (..., W) arrays
        Extinction above 0; absorption of at least 0, at most the extinction.
    wavelength : (P,) array
        um.

    Returns
    -------
    extinction, single_scattering_albedo : (..., P) arrays
    """
    log_nodes, log_wavelength = np.log(nodes), np.log(wavelength)
    upper = np.clip(np.searchsorted(nodes, wavelength, side="right"), 1, nodes.size - 1)
    step = log_nodes[upper] - log_nodes[upper - 1]
    share = np.clip((log_wavelength - log_nodes[upper - 1]) / step, 0.0, 1.0)
    log_extinction = np.log(extinction)
    between = np.exp((1 - share) * log_extinction[..., upper - 1] + share * log_extinction[..., upper])
    absorbed = absorption / extinction
    left_value, right_value = absorbed[..., upper - 1], absorbed[..., upper]
    absorbing = (left_value > 0) & (right_value > 0)
    by_power = np.where(absorbing, left_value, 1.0) ** (1 - share) * np.where(absorbing, right_value, 1.0) ** share
    absorbed = np.where(absorbing, by_power, (1 - share) * left_value + share * right_value)
    return between * np.minimum(1.0, nodes[-1] / wavelength), 1.0 - absorbed


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
    position = np.interp(np.log(value), np.log(nodes), np.arange(nodes.size))
    lower = min(int(position), nodes.size - 2)
    share = position - lower

    def between(values: Floats) -> Floats:
        mean: Floats = (1 - share) * values[lower] + share * values[lower + 1]
        return mean

    return wavelength[0], np.exp(between(np.log(extinction))), np.exp(between(np.log(absorption))), between(asymmetry)


def interpolated_phase(table: PhaseTable, value: float) -> dict[str, Floats]:
    """What a `SphereModel` has of a table at one value of its nodes: linear in the logarithm of that, like
    `interpolated_table`.
    """
    weight = linear_weights(np.log(table.node), np.log([value]))[:, 0]
    return {
        "phase_angle": table.angle,
        "phase_wavelength": table.wavelength,
        "phase": np.tensordot(table.phase, weight, axes=(1, 0)),
        "moments": np.tensordot(table.moments, weight, axes=(1, 0)),
    }


def linear_weights(nodes: Floats, points: Floats) -> Floats:
    """Weights (N, M) of linear interpolation from N increasing nodes to M points, the end values held outside."""
    if len(nodes) == 1:
        return np.ones((1, len(points)))
    upper = np.clip(np.searchsorted(nodes, points, side="right"), 1, len(nodes) - 1)
    fraction = np.clip((points - nodes[upper - 1]) / (nodes[upper] - nodes[upper - 1]), 0.0, 1.0)
    weights = np.zeros((len(nodes), len(points)))
    column = np.arange(len(points))
    weights[upper - 1, column] = 1.0 - fraction
    weights[upper, column] = fraction
    return weights
