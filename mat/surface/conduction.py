"""Exact periodic conduction in a skin over two layers, as a linear operator on surface temperature.

The heat that a stack draws from its surface is Y(s) T(s) for every complex frequency s, with Y the surface admittance
of the whole stack. Sampled at N times of a period this is a circulant matrix, so that nothing inside the stack has to
be stored or marched: its layers are exact at any thickness, and the period has no initial condition.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from skyshine.materials.records import Back, Layer, ThermalStack
from skyshine.schemas.arrays import Floats, Reals
from skyshine.schemas.errors import InputError

Complexes: TypeAlias = npt.NDArray[np.complexfloating[Any, Any]]

# Below this |g d| the series of tanh(x)/x is exact to 1e-16 with four terms: the next is 62/2835 x^8.
_SMALL = 1e-2
# Up to this many steps a matrix product is faster than Fourier transforms.
_DENSE_FLUX_STEPS = 192
# tanh(20) differs from 1 by 8e-18.
_LARGE = 20.0


def _tanh_ratio(x: Complexes) -> Complexes:
    """tanh(x) / x of complex x with a non-negative real part, 1 at 0."""
    ratio = np.empty_like(x)
    small = np.abs(x) < _SMALL
    square = x[small] ** 2
    ratio[small] = 1 + square * (-1 / 3 + square * (2 / 15 - square * 17 / 315))
    large = x.real > _LARGE
    ratio[large] = 1 / x[large]
    middle = ~(small | large)
    ratio[middle] = np.tanh(x[middle]) / x[middle]
    return ratio


def _wave(layer: Layer, s: Complexes) -> tuple[Complexes, Complexes]:
    """Complex wave number g [1/m] of a layer and its characteristic admittance k g [W m^-2 K^-1]."""
    g: Complexes = np.sqrt(s * (layer.density * layer.heat_capacity / layer.conductivity))
    return g, layer.conductivity * g


def _sech(x: Complexes) -> Complexes:
    """1 / cosh(x) of complex x with a non-negative real part, without overflow."""
    decay = np.exp(-x)
    sech: Complexes = 2 * decay / (1 + decay**2)
    return sech


@dataclass(frozen=True, eq=False)
class _Norton:
    """Norton equivalent of all that lies behind a plane: heat flux Y T - J d inwards.

    T is the temperature of the plane, d the drive of the back.

    Attributes
    ----------
    admittance : (n,) complex or None
        Y [W m^-2 K^-1]; None where the plane's temperature is the drive itself.
    transfer : (n,) complex
        J: W m^-2 K^-1 where the drive is a temperature, 1 where it is a heat flux.
    """

    admittance: Complexes | None
    transfer: Complexes


def _through(layer: Layer, s: Complexes, behind: _Norton) -> _Norton:
    """Norton equivalent of a layer and all behind it.

    With x = g d the classic form Yc (Y + Yc tanh x) / (Yc + Y tanh x) is written in storage S = Yc tanh x and
    resistance R = tanh x / Yc, both regular at s = 0.
    """
    g, characteristic = _wave(layer, s)
    if np.isinf(layer.thickness):
        return _Norton(characteristic, np.zeros_like(s))
    x = g * layer.thickness
    ratio = _tanh_ratio(x)
    storage = s * (layer.density * layer.heat_capacity * layer.thickness) * ratio
    resistance = layer.thickness / layer.conductivity * ratio
    if behind.admittance is None:
        if layer.thickness == 0:
            return behind
        return _Norton(1 / resistance, behind.transfer * _sech(x) / resistance)
    divisor = 1 + behind.admittance * resistance
    return _Norton((behind.admittance + storage) / divisor, behind.transfer * _sech(x) / divisor)


def _back_boundary(stack: ThermalStack, s: Complexes) -> _Norton:
    """Norton equivalent of the back boundary."""
    ones, boundary = np.ones_like(s), stack.back
    if boundary.kind == "fixed":
        return _Norton(None, ones)
    if boundary.kind in ("convective", "open"):
        coefficient = _given(boundary, "coefficient")
        return _Norton(coefficient * ones, coefficient * ones)
    if boundary.kind == "cavity":
        coefficient, exchange = _given(boundary, "coefficient"), _given(boundary, "exchange")
        beyond = exchange + s * _given(boundary, "capacity")
        return _Norton(coefficient * beyond / (coefficient + beyond), coefficient * exchange / (coefficient + beyond))
    return _Norton(0 * ones, ones if boundary.kind == "heated" else 0 * ones)


def _given(boundary: Back, name: str) -> float:
    value = getattr(boundary, name)
    if value is None:
        raise InputError(f"found a {boundary.kind} back without {name}; allowed: with one; give it")
    return float(value)


def stack_response(stack: ThermalStack, s: Complexes) -> tuple[Complexes, Complexes]:
    """Admittance of a whole stack, the skin's capacity included, and what its back transfers to the surface.

    Parameters
    ----------
    s : (n,) complex
        Laplace variable, as in `surface_admittance`.

    Returns
    -------
    admittance, transfer : (n,) complex
        [W m^-2 K^-1], the transfer 1 where heat drives the back.
    """
    behind = _back_boundary(stack, s)
    for layer in reversed(stack.layers):
        behind = _through(layer, s, behind)
    if behind.admittance is None:
        raise InputError("found layers without thickness on a back of fixed temperature; allowed: at least one layer")
    skin = stack.skin
    return behind.admittance + s * (skin.thickness * skin.density * skin.heat_capacity), behind.transfer


def between_faces(layer: Layer, s: Complexes) -> tuple[Complexes, Complexes]:
    """Heat flux into one face of a layer per kelvin there, the other face held at 0, and the flux that leaves that one.

    Parameters
    ----------
    layer : Layer
        Layer of finite thickness.
    s : (n,) complex
        Laplace variable, as in `surface_admittance`.

    Returns
    -------
    own, across : (n,) complex
        [W m^-2 K^-1]: Yc coth x and Yc / sinh x, x = g d; both the conductance k / d at s = 0.
    """
    g, _ = _wave(layer, s)
    x = g * layer.thickness
    same_face = layer.conductivity / (layer.thickness * _tanh_ratio(x))
    return same_face, same_face * _sech(x)


def surface_admittance(stack: ThermalStack, s: npt.ArrayLike) -> Complexes:
    """Heat flux into the surface per kelvin at complex frequencies.

    Parameters
    ----------
    stack : ThermalStack
        A last layer of infinite thickness makes the stack semi-infinite, whatever its back.
    s : (n,) complex
        Laplace variable [1/s], real part not negative; s = i omega for a wave of angular frequency omega.

    Returns
    -------
    (n,) complex
        Y(s) [W m^-2 K^-1]; Y(0) is the steady conductance to the back.

    References
    ----------
    Carslaw and Jaeger (1959), Conduction of Heat in Solids, 2nd ed., section 3.7: composite slabs.
    """
    return stack_response(stack, np.atleast_1d(np.asarray(s, complex)))[0]


def depth_response(stack: ThermalStack, s: npt.ArrayLike, depth: float) -> tuple[Complexes, Complexes]:
    """Temperature at a depth below the skin at complex frequencies.

    Parameters
    ----------
    s : (n,) complex
        [1/s]
    depth : float
        Below the skin [m], within the layers.

    Returns
    -------
    surface : (n,) complex
        Per kelvin at the surface, nothing driving the back.
    back : (n,) complex
        Per unit of the back's drive, temperature or heat flux, the surface held at 0.

    Raises
    ------
    InputError
        The depth lies outside the layers.
    """
    if not 0 <= depth <= sum(layer.thickness for layer in stack.layers):
        raise InputError(f"found a depth of {depth:g} m; allowed: 0 to the thickness of the two layers")
    s = np.atleast_1d(np.asarray(s, complex))
    above, below = cut(stack.layers, depth)
    behind = [_back_boundary(stack, s)]  # what lies behind each layer of `above`, then of `below`
    for layer in reversed(above[1:] + below):
        behind.insert(0, _through(layer, s, behind[0]))
    surface, drive = np.ones_like(s), np.zeros_like(s)
    for layer, beyond in zip(above, behind[: len(above)], strict=True):
        if beyond.admittance is None:
            return np.zeros_like(s), np.ones_like(s)
        g, _ = _wave(layer, s)
        x = g * layer.thickness
        resistance = layer.thickness / layer.conductivity * _tanh_ratio(x)
        divisor = 1 + beyond.admittance * resistance
        surface = surface * _sech(x) / divisor
        drive = (drive * _sech(x) + resistance * beyond.transfer) / divisor
    return surface, drive


def cut(layers: Sequence[Layer], depth: float) -> tuple[list[Layer], list[Layer]]:
    """Layers above and below a depth, the one that contains it cut in two."""
    above: list[Layer] = []
    below: list[Layer] = []
    for layer in layers:
        inside = min(depth, layer.thickness)
        depth -= inside
        above += [replace(layer, thickness=inside)] if inside > 0 else []
        below += [replace(layer, thickness=layer.thickness - inside)] if inside < layer.thickness else []
    return above, below


def frequencies(steps: int, period: float, scheme: str) -> Complexes:
    """Complex frequencies of the discrete harmonics 0 ... N/2 of a time scheme.

    Parameters
    ----------
    steps : int
        N samples in the period.
    period : float
        [s]
    scheme : str
        "spectral" (s = i omega), "bdf2" or "euler" (convolution quadrature: s = delta(exp(-i omega dt)) / dt).

    Returns
    -------
    (N // 2 + 1,) complex
        [1/s]

    References
    ----------
    Lubich (1988), Convolution quadrature and discretized operational calculus I, Numer. Math. 52, 129-145.
    """
    angle = 2 * np.pi * np.arange(steps // 2 + 1) / steps
    if scheme == "spectral":
        return 1j * angle * steps / period
    return _of_delay(np.exp(-1j * angle), scheme) * steps / period


def _of_delay(delay: Complexes, scheme: str) -> Complexes:
    """delta of a factor by which a time scheme delays one step."""
    multipliers = {"bdf2": 1.5 - 2 * delay + 0.5 * delay**2, "euler": 1 - delay}
    if scheme not in multipliers:
        raise ValueError(f"unknown scheme '{scheme}': one of spectral, {', '.join(multipliers)}")
    delta: Complexes = multipliers[scheme]
    return delta


def delayed_responses(stack: ThermalStack, step: float, lags: int, scheme: str) -> tuple[Floats, Floats]:
    """Heat flux into the surface, and out of the back, at 0, 1, 2 ... steps after their cause lasted for one step.

    Parameters
    ----------
    step : float
        [s]
    scheme : str
        "bdf2" or "euler"; see `frequencies`.

    Returns
    -------
    surface : (lags,) ndarray
        Into a surface that had 1 K [W m^-2]; of the circulant matrix of a period of N steps, summed over lags that
        differ by N.
    back : (lags,) ndarray
        To a surface at 0 K from a back that had a unit of its drive [W m^-2].

    References
    ----------
    Lubich (1988), Convolution quadrature and discretized operational calculus II, Numer. Math. 52, 413-425: the
    weights by Fourier transform on a circle of radius below 1.
    """
    surface, back = delayed_weights(lambda s: stack_response(stack, s), step, lags, scheme)
    return surface, back


def delayed_weights(
    response: Callable[[Complexes], tuple[Complexes, ...]], step: float, lags: int, scheme: str
) -> tuple[Floats, ...]:
    """What responses to complex frequencies [1/s] are at 0, 1, 2 ... steps after their cause lasted for one step.

    Parameters
    ----------
    response : callable
        Takes frequencies (n,), gives one or more responses (n,).
    step, lags, scheme
        As `delayed_responses` takes them.

    Returns
    -------
    tuple of (lags,) ndarray
    """
    length = 2 * lags
    # What comes around the circle loses five digits, and rounding grows by five.
    radius = 10.0 ** (-5.0 / length)
    delay = radius * np.exp(-2j * np.pi * np.arange(length // 2 + 1) / length)
    growth = radius ** np.arange(lags)
    return tuple(
        np.fft.irfft(spectrum, length)[:lags] / growth for spectrum in response(_of_delay(delay, scheme) / step)
    )


def circulant(harmonics: Complexes, steps: int) -> Floats:
    """The matrix (N, N) over a period of N steps of a response to its harmonics 0 ... N/2."""
    column = np.fft.irfft(harmonics, steps)
    index = np.arange(steps)
    matrix: Floats = column[(index[:, None] - index[None, :]) % steps]
    return matrix


def real_at_end(harmonics: Complexes) -> Complexes:
    """Eigenvalues of `circulant` for an even number of steps: the real part of the last harmonic counts there."""
    values = harmonics.copy()
    values[-1] = values[-1].real
    return values


@dataclass(frozen=True, eq=False)
class Conduction:
    """The stack's response to N surface temperatures of a period.

    Attributes
    ----------
    period : float
        [s]
    scheme : str
        "bdf2", "euler" or "spectral"; see `frequencies`.
    """

    stack: ThermalStack
    steps: int
    period: float
    scheme: str = "bdf2"

    @cached_property
    def _response(self) -> tuple[Complexes, Complexes]:
        return stack_response(self.stack, frequencies(self.steps, self.period, self.scheme))

    @property
    def admittance(self) -> Complexes:
        """Y of the harmonics 0 ... N/2, shape (N // 2 + 1,) [W m^-2 K^-1]."""
        return self._response[0]

    def from_back(self, drive: Floats) -> Floats:
        """Heat flux [W m^-2] that a drive (..., N) of the back, temperature [K] or heat flux, brings to a surface
        at 0 K.
        """
        return np.fft.irfft(np.fft.rfft(drive) * self._response[1], self.steps)

    @cached_property
    def back_matrix(self) -> Floats:
        """The circulant (N, N) matrix of `from_back`."""
        return circulant(self._response[1], self.steps)

    @cached_property
    def steady_conductance(self) -> float:
        """Y(0) [W m^-2 K^-1]: 0 where the mean flux is zero (adiabatic, semi-infinite)."""
        return float(self.admittance[0].real)

    @cached_property
    def steady_transfer(self) -> float:
        """J(0): flux that a steady unit drive of the back brings to a surface at 0 K; for a temperature it is Y(0)."""
        return float(self._response[1][0].real)

    def flux(self, temperature: Reals) -> Floats:
        """Heat flux into the surface [W m^-2] of temperatures (..., N) [K] above a back at 0."""
        if self.steps <= _DENSE_FLUX_STEPS:
            return temperature @ self.matrix.T
        return np.fft.irfft(np.fft.rfft(temperature) * self.admittance, self.steps)

    def mean_flux(self, temperature: Floats) -> Floats:
        """Mean over the period (...,) of `flux`."""
        mean: Floats = self.steady_conductance * temperature.mean(axis=-1)
        return mean

    def relax(self, flux: Floats, conductance: float) -> Floats:
        """Temperatures (..., N) [K] whose conduction plus `conductance` times themselves is `flux` (..., N)."""
        return np.fft.irfft(np.fft.rfft(flux) / (self.admittance + conductance), self.steps)

    @cached_property
    def matrix(self) -> Floats:
        """The circulant (N, N) matrix C of `flux`: flux = C T."""
        return circulant(self.admittance, self.steps)
