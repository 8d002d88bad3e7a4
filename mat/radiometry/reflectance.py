"""Means of a material's reflectance spectrum over a band, weighted by sunlight or by blackbody radiance.

Spectra are linear between their nodes; beyond the first and last wavelength the end value is held. Where a
material transmits, `Material.absorptance` is less than 1 - reflectance: absorptance and emissivity below are taken
from it, reflectance never.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.constants import C2_WAVELENGTH
from skyshine.materials.records import Material
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError, nearest

WEIGHTINGS = ("flat", "planck", "solar")
# Range of the thermal emissivity [um]: 300 K blackbody radiation outside it is below 2e-4 of the whole.
_THERMAL_RANGE = (1.0, 200.0)


def band_reflectance(
    material: Material,
    response: SpectralResponse,
    weighting: str = "flat",
    temperature: npt.ArrayLike | None = None,
    irradiance: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
) -> float | Floats:
    """Reflectance of a material in a band.

    Parameters
    ----------
    weighting : str
        "flat": by the response alone; "planck": by blackbody radiance too; "solar": by irradiance too.
    temperature : array_like, optional
        [K], above 0, any shape; for "planck".
    irradiance : tuple of two array_like (k,), optional
        Wavelength [um], increasing, and irradiance per unit wavelength (any scale); for "solar".

    Returns
    -------
    float or ndarray
        Of the shape of `temperature` for "planck".

    Raises
    ------
    InputError
        An unknown weighting, a missing or superfluous argument, a temperature that is not above 0, or an
        irradiance that is 0 over the whole band.
    """
    if weighting not in WEIGHTINGS:
        raise InputError(f"found the weighting '{weighting}'; {nearest(weighting, WEIGHTINGS)}")
    if (temperature is not None) != (weighting == "planck"):
        raise InputError("a temperature belongs to the weighting 'planck', and to it alone")
    if (irradiance is not None) != (weighting == "solar"):
        raise InputError("an irradiance belongs to the weighting 'solar', and to it alone")
    if irradiance is not None:
        return _solar_mean(material.wavelength, material.reflectance, response, *_spectrum(*irradiance))
    if temperature is not None:
        return _planck_mean(material.wavelength, material.reflectance, response, temperature)
    node, weight = _refined(response, material.wavelength).quadrature
    return float(np.interp(node, material.wavelength, material.reflectance) @ weight / weight.sum())


@overload
def band_emissivity(material: Material, response: SpectralResponse, temperature: float) -> float: ...


@overload
def band_emissivity(
    material: Material, response: SpectralResponse, temperature: Floats | Sequence[float]
) -> Floats: ...


def band_emissivity(
    material: Material, response: SpectralResponse, temperature: float | Floats | Sequence[float]
) -> float | Floats:
    """Emissivity of a material in a band, weighted by blackbody radiance.

    Equal to 1 - `band_reflectance(..., "planck", temperature)` unless the material transmits.

    Parameters
    ----------
    temperature : float or array
        [K], above 0, any shape.

    Returns
    -------
    float or ndarray
        Of the shape of `temperature`.
    """
    return _planck_mean(material.wavelength, material.absorptance, response, temperature)


def solar_absorptance(material: Material, wavelength: npt.ArrayLike, irradiance: npt.ArrayLike) -> float:
    """Fraction of solar irradiance that a material absorbs.

    Parameters
    ----------
    wavelength : array_like, shape (k,)
        [um], increasing.
    irradiance : array_like, shape (k,)
        Per unit wavelength, any scale; not negative. Its range is the range of the mean.

    Raises
    ------
    InputError
        The irradiance is not a spectrum: too short, not increasing, negative or 0 everywhere.
    """
    um, value = _spectrum(wavelength, irradiance)
    everywhere = SpectralResponse.rectangular(um[0], um[-1])
    return _solar_mean(material.wavelength, material.absorptance, everywhere, um, value)


def thermal_emissivity(material: Material, temperature: float = 300.0) -> float:
    """Emissivity over the whole thermal spectrum (1 to 200 um) at `temperature` [K]; the ends of the table are held."""
    return band_emissivity(material, SpectralResponse.rectangular(*_THERMAL_RANGE), temperature)


def _solar_mean(
    wavelength: Floats, values: Floats, response: SpectralResponse, um: Floats, irradiance: Floats
) -> float:
    """Mean of values (n,) at wavelengths (n,) [um], weighted by the response and an irradiance (k,) at `um` (k,)."""
    node, weight = _refined(response, wavelength, um).quadrature
    weight = weight * np.interp(node, um, irradiance, left=0.0, right=0.0)
    if not weight.sum() > 0.0:
        raise InputError(
            f"the irradiance is 0 over the whole band of {response.lower:g} to {response.upper:g} um; "
            "give one that covers it"
        )
    return float(np.interp(node, wavelength, values) @ weight / weight.sum())


def _planck_mean(
    wavelength: Floats, values: Floats, response: SpectralResponse, temperature: npt.ArrayLike
) -> float | Floats:
    """Mean of values (n,) at wavelengths (n,) [um], weighted by the response and blackbody radiance; of the shape of
    `temperature` [K].
    """
    kelvin = np.asarray(temperature, dtype=float)
    if not np.all(np.isfinite(kelvin)) or np.any(kelvin <= 0.0):
        raise InputError("a Planck-weighted mean needs finite temperatures above 0 K")
    node, weight = _refined(response, wavelength).quadrature
    shape = _planck_shape(node, kelvin.ravel()) * weight
    mean = (shape @ np.interp(node, wavelength, values) / shape.sum(axis=1)).reshape(kelvin.shape)
    return float(mean) if kelvin.ndim == 0 else mean


def _planck_shape(wavelength: Floats, kelvin: Floats) -> Floats:
    """Blackbody spectra (m, q) at wavelengths (q,) [um] and temperatures (m,) [K], each scaled to a peak of 1 so
    that none underflows in the cold.
    """
    x = C2_WAVELENGTH / (wavelength * kelvin[:, None])
    logarithm = -5.0 * np.log(wavelength) - x - np.log(-np.expm1(-x))
    spectra: Floats = np.exp(logarithm - logarithm.max(axis=1, keepdims=True))
    return spectra


def _refined(response: SpectralResponse, *grids: Floats) -> SpectralResponse:
    """The same response with the nodes of other grids added, so that its quadrature resolves them."""
    inside = [grid[(grid > response.lower) & (grid < response.upper)] for grid in grids]
    nodes = np.unique(np.concatenate([response.wavelength, *inside]))
    return SpectralResponse(nodes, response.at_wavelength(nodes))


def _spectrum(wavelength: npt.ArrayLike, irradiance: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Columns (k,) of an irradiance spectrum, checked: wavelength [um] and irradiance per unit wavelength."""
    um, value = np.asarray(wavelength, dtype=float), np.asarray(irradiance, dtype=float)
    if um.ndim != 1 or um.shape != value.shape or um.size < 2:
        raise InputError(
            f"an irradiance spectrum needs two equally long columns, found shapes {um.shape} and {value.shape}"
        )
    if not np.all(np.isfinite(um)) or um[0] <= 0.0 or np.any(np.diff(um) <= 0.0):
        raise InputError("irradiance wavelengths must be above 0 um and strictly increasing")
    if not np.all(np.isfinite(value)) or np.any(value < 0.0) or value.max() == 0.0:
        raise InputError("irradiance must be finite, not negative, and not 0 everywhere")
    return um, value
