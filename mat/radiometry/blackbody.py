"""Blackbody radiance, sensor responses, in-band radiance and brightness temperature.

Wavelengths are in micrometres, wavenumbers in cm^-1, radiance in W m^-2 sr^-1 (per um or per cm^-1
where it is spectral).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.mat.radiometry.constants import C1_WAVELENGTH, C1_WAVENUMBER, C2_WAVELENGTH, C2_WAVENUMBER
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# A panel of the band quadrature spans at most this relative step in wavelength. With eight Gauss
# nodes the Wien exponential of h c / (lambda k T) <= 200 is then integrated to better than 1e-8.
_PANEL_RATIO = 1.05
_FINE_PANEL_RATIO = 1.005
# Wavelength <-> wavenumber conversion moves a band edge by an ulp or two; within this it is the edge.
_EDGE_TOLERANCE = 1e-12
# Elements of a (temperature, quadrature node) work array: about 16 MB in float64.
_CHUNK_ELEMENTS = 2_000_000
_NEWTON_STEPS = 100  # at most; the iteration ends when it converges


def planck_wavenumber(wavenumber: npt.ArrayLike, temperature: npt.ArrayLike) -> Floats:
    """Spectral radiance of a blackbody against wavenumber.

    Parameters
    ----------
    wavenumber : array_like
        [cm^-1], finite and above 0; broadcast against `temperature`.
    temperature : array_like
        [K], finite and not negative; 0 K radiates 0.

    Returns
    -------
    ndarray
        [W m^-2 sr^-1 (cm^-1)^-1], never NaN or infinite: the far Wien tail is 0.

    Raises
    ------
    InputError
        If a temperature is negative or not a number, or a wavenumber is not positive.

    References
    ----------
    Planck's law; equation (3) in its wavenumber form.
    """
    nu = _positive(wavenumber, "wavenumber", "cm^-1")
    kelvin = _temperature(temperature)
    return C1_WAVENUMBER * nu**3 * _occupation(C2_WAVENUMBER * nu, kelvin)


def planck_wavelength(wavelength: npt.ArrayLike, temperature: npt.ArrayLike) -> Floats:
    """Spectral radiance of a blackbody against wavelength.

    Parameters
    ----------
    wavelength : array_like
        [um], finite and above 0; broadcast against `temperature`.
    temperature : array_like
        [K], finite and not negative; 0 K radiates 0.

    Returns
    -------
    ndarray
        [W m^-2 sr^-1 um^-1].

    Raises
    ------
    InputError
        If a temperature is negative or not a number, or a wavelength is not positive.

    References
    ----------
    Equation (3).
    """
    um = _positive(wavelength, "wavelength", "um")
    kelvin = _temperature(temperature)
    return C1_WAVELENGTH / um**5 * _occupation(C2_WAVELENGTH / um, kelvin)


@dataclass(frozen=True, eq=False)
class SpectralResponse:
    """Sensor response phi: linear in wavelength between nodes, 0 outside, peak 1.

    Parameters
    ----------
    wavelength : array_like, shape (n,)
        [um], increasing, at least two.
    response : array_like, shape (n,)
        Relative response, not negative; scaled here so that the largest is 1.

    Raises
    ------
    InputError
        If the table is not a response: too short, not increasing, negative, all zero or not finite.
    """

    wavelength: Floats
    response: Floats

    def __post_init__(self) -> None:
        wavelength = np.array(self.wavelength, dtype=float)
        response = np.array(self.response, dtype=float)
        if wavelength.ndim != 1 or wavelength.shape != response.shape or wavelength.size < 2:
            raise InputError(
                "a spectral response needs two equally long columns of at least two rows, found shapes "
                f"{wavelength.shape} (wavelength) and {response.shape} (response)"
            )
        if not np.all(np.isfinite(wavelength)) or wavelength[0] <= 0.0 or np.any(np.diff(wavelength) <= 0.0):
            raise InputError(
                "response wavelengths must be above 0 um and strictly increasing; sort the table, merge repeated rows"
            )
        if not np.all(np.isfinite(response)) or np.any(response < 0.0):
            raise InputError("response values must be finite and not negative")
        if response.max() == 0.0:
            raise InputError("a spectral response cannot be 0 everywhere")
        response /= response.max()
        wavelength.setflags(write=False)
        response.setflags(write=False)
        object.__setattr__(self, "wavelength", wavelength)
        object.__setattr__(self, "response", response)

    @classmethod
    def rectangular(cls, lower: float, upper: float) -> SpectralResponse:
        """Response 1 from `lower` to `upper` [um], edges included."""
        if not 0.0 < lower < upper < np.inf:
            raise InputError(f"a band runs from a lower to a higher wavelength above 0 um, found {lower} to {upper} um")
        return cls(np.array([lower, upper]), np.ones(2))

    @property
    def lower(self) -> float:
        """First wavelength of the response [um]."""
        return float(self.wavelength[0])

    @property
    def upper(self) -> float:
        """Last wavelength of the response [um]."""
        return float(self.wavelength[-1])

    @property
    def wavenumber_range(self) -> tuple[float, float]:
        """Lowest and highest wavenumber of the response [cm^-1]."""
        return 1e4 / self.upper, 1e4 / self.lower

    def at_wavelength(self, wavelength: npt.ArrayLike) -> Floats:
        """Response at wavelengths [um], in their shape; both edges belong to the band."""
        um = np.asarray(wavelength, dtype=float)
        for edge in (self.lower, self.upper):
            um = np.where(np.abs(um - edge) <= _EDGE_TOLERANCE * edge, edge, um)
        response: Floats = np.interp(um, self.wavelength, self.response, left=0.0, right=0.0)
        return response

    def at_wavenumber(self, wavenumber: npt.ArrayLike) -> Floats:
        """Response at wavenumbers [cm^-1], in their shape; both edges belong to the band."""
        return self.at_wavelength(1e4 / _positive(wavenumber, "wavenumber", "cm^-1"))

    @cached_property
    def quadrature(self) -> tuple[Floats, Floats]:
        """Nodes (q,) [um] and weights (q,) [um] with the response in them.

        Gauss-Legendre panels between the table's nodes: the sum of weight * f(node) is the integral of
        phi f over wavelength, to rounding where f is smooth and phi linear.
        """
        start, ratio = self.wavelength[:-1], self.wavelength[1:] / self.wavelength[:-1]
        panels = np.maximum(np.ceil(np.log(ratio) / np.log(_PANEL_RATIO)), 1.0).astype(int)
        segment = np.repeat(np.arange(len(panels)), panels)
        step = np.arange(len(segment)) - np.repeat(np.cumsum(panels) - panels, panels)
        lower = start[segment] * ratio[segment] ** (step / panels[segment])
        upper = start[segment] * ratio[segment] ** ((step + 1) / panels[segment])
        fine = ratio[segment] < _FINE_PANEL_RATIO
        parts = [_gauss_panels(lower[part], upper[part], order) for part, order in ((fine, 4), (~fine, 8))]
        node = np.concatenate([part[0] for part in parts])
        weight = np.concatenate([part[1] for part in parts]) * np.interp(node, self.wavelength, self.response)
        inside = weight > 0.0
        return node[inside], weight[inside]


def band_radiance(response: SpectralResponse, temperature: npt.ArrayLike) -> Floats:
    """Blackbody radiance of a band against temperature.

    Parameters
    ----------
    temperature : array_like
        [K], any shape; finite and not negative.

    Returns
    -------
    ndarray
        [W m^-2 sr^-1], the shape of `temperature`.

    Raises
    ------
    InputError
        If a temperature is negative or not a number.

    References
    ----------
    Equation (7).
    """
    kelvin = _temperature(temperature)
    node, weight = response.quadrature
    scale = weight * C1_WAVELENGTH / node**5

    def radiance(part: Floats) -> Floats:
        return _occupation(C2_WAVELENGTH / node, part[:, None]) @ scale

    return _in_chunks(radiance, kelvin, node.size)


def brightness_temperature(response: SpectralResponse, radiance: npt.ArrayLike) -> Floats:
    """Temperature of the blackbody that a band sees with this radiance: the inverse of `band_radiance`.

    Parameters
    ----------
    radiance : array_like
        [W m^-2 sr^-1], any shape; finite and not negative.

    Returns
    -------
    ndarray
        [K], the shape of `radiance`; a radiance of 0 gives 0 K.

    Raises
    ------
    InputError
        If a radiance is negative or not a number.

    Notes
    -----
    The logarithm of the band radiance is a convex, decreasing function of 1/T (each wavelength's is, and
    sums of log-convex functions are log-convex). Newton's method started from the highest of the
    single-wavelength brightness temperatures, which bounds the answer from above, therefore
    approaches it from one side and cannot overshoot.
    """
    value = np.asarray(radiance, dtype=float)
    if not np.all(np.isfinite(value)) or np.any(value < 0.0):
        raise InputError("radiance must be finite and not negative to have a brightness temperature")
    node, weight = response.quadrature
    log_scale = np.log(weight * C1_WAVELENGTH / node**5)

    def invert(part: Floats) -> Floats:
        with np.errstate(divide="ignore"):
            target = np.log(part)
        positive = np.isfinite(target)
        kelvin = np.zeros(part.shape)
        kelvin[positive] = 1.0 / _inverse_temperature(node, log_scale, np.log(weight.sum()), target[positive])
        return kelvin

    return _in_chunks(invert, value, node.size)


def _inverse_temperature(node: Floats, log_scale: Floats, log_width: float, target: Floats) -> Floats:
    """Solve logsumexp(log_scale - x - log(1 - exp(-x))) = target for u = 1/T, x = c2 u / node; (m,) -> (m,)."""
    if target.size == 0:
        return target
    rate = C2_WAVELENGTH / node
    spectral = np.log(C1_WAVELENGTH / node**5) + log_width - target[:, None]
    u: Floats = np.min(np.logaddexp(0.0, spectral) / rate, axis=1)
    for _ in range(_NEWTON_STEPS):
        x = rate * u[:, None]
        occupied = -np.expm1(-x)
        terms = log_scale - x - np.log(occupied)
        value = scipy.special.logsumexp(terms, axis=1)
        slope = -np.sum(np.exp(terms - value[:, None]) * rate / occupied, axis=1)
        step = (target - value) / slope
        u = u + step
        if np.all(np.abs(step) <= 1e-14 * u):
            return u
        # Rounding in the logarithms stops the approach a few ulps of them short of the root.
        if np.all(np.abs(target - value) <= 8.0 * np.finfo(float).eps * np.maximum(1.0, np.abs(target))):
            return u
    raise ArithmeticError("brightness temperature did not converge")


def _gauss_panels(lower: Floats, upper: Floats, order: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights of panels, flattened."""
    point, weight = np.polynomial.legendre.leggauss(order)
    half = 0.5 * (upper - lower)[:, None]
    return (0.5 * (upper + lower)[:, None] + half * point).ravel(), (half * weight).ravel()


def _occupation(scale: Floats, kelvin: Floats) -> Floats:
    """1 / (exp(scale / T) - 1) without overflow; 0 at T = 0."""
    with np.errstate(divide="ignore", over="ignore"):
        x = scale / kelvin
    with np.errstate(under="ignore"):
        # exp(-x) / (1 - exp(-x)): exp(x) itself overflows beyond x = 709 (0.1 um at 200 K).
        return np.exp(-x) / -np.expm1(-x)


def _in_chunks(function: Callable[[Floats], Floats], values: Floats, width: int) -> Floats:
    """Apply a function of a 1-D part to an array of any shape, `width` work elements each."""
    flat = values.ravel()
    size = max(1, _CHUNK_ELEMENTS // width)
    parts = [function(flat[start : start + size]) for start in range(0, flat.size, size)]
    return np.concatenate(parts).reshape(values.shape) if parts else np.zeros(values.shape)


def _temperature(values: npt.ArrayLike) -> Floats:
    kelvin = np.asarray(values, dtype=float)
    if not np.all(np.isfinite(kelvin)) or np.any(kelvin < 0.0):
        raise InputError("temperatures must be finite and not negative (kelvin)")
    return kelvin


def _positive(values: npt.ArrayLike, name: str, units: str) -> Floats:
    array = np.asarray(values, dtype=float)
    if not np.all(np.isfinite(array)) or np.any(array <= 0.0):
        raise InputError(f"{name} must be finite and above 0 {units}")
    return array
