"""Exact periodic conduction in a skin over two layers, as a linear operator on surface temperature.

The heat that a stack draws from its surface is Y(s) T(s) for every complex frequency s, with Y the surface admittance
of the whole stack. Sampled at N times of a period this is a circulant matrix, so that nothing inside the stack has to
be stored or marched: its layers are exact at any thickness, and the period has no initial condition.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.materials.records import ThermalStack
from skyshine.schemas.errors import InputError

SCHEMES = ("bdf2", "euler", "spectral")
# Below this |g d| the series of tanh(x)/x is exact to 1e-16 with four terms: the next is 62/2835 x^8.
_SMALL = 1e-2
# tanh(20) differs from 1 by 8e-18.
_LARGE = 20.0


def _tanh_ratio(x: np.ndarray) -> np.ndarray:
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


def _wave(layer, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Complex wave number g [1/m] of a layer and its characteristic admittance k g [W m^-2 K^-1]."""
    g = np.sqrt(s * (layer.density * layer.heat_capacity / layer.conductivity))
    return g, layer.conductivity * g


def _through(layer, s: np.ndarray, behind: np.ndarray | None) -> np.ndarray:
    """Admittance in front of a layer, given the one behind it (None: a fixed temperature, infinite admittance).

    With x = g d the classic form Yc (Y + Yc tanh x) / (Yc + Y tanh x) is written in storage S = Yc tanh x and
    resistance R = tanh x / Yc, both regular at s = 0.
    """
    g, characteristic = _wave(layer, s)
    if np.isinf(layer.thickness):
        return characteristic
    ratio = _tanh_ratio(g * layer.thickness)
    storage = s * (layer.density * layer.heat_capacity * layer.thickness) * ratio
    resistance = layer.thickness / layer.conductivity * ratio
    if behind is None:
        return 1 / resistance
    return (behind + storage) / (1 + behind * resistance)


def _back(stack: ThermalStack, s: np.ndarray) -> np.ndarray | None:
    """Admittance of what the stack rests on."""
    if stack.back.kind == "adiabatic":
        return np.zeros_like(s)
    if stack.back.kind == "convective":
        return np.full_like(s, stack.back.coefficient)
    return None


def surface_admittance(stack: ThermalStack, s) -> np.ndarray:
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
    s = np.atleast_1d(np.asarray(s, complex))
    admittance = _back(stack, s)
    for layer in reversed(stack.layers):
        admittance = _through(layer, s, admittance)
    skin = stack.skin
    return admittance + s * (skin.thickness * skin.density * skin.heat_capacity)


def depth_response(stack: ThermalStack, s, depth: float) -> np.ndarray:
    """Temperature at a depth below the skin per kelvin at the surface, at complex frequencies, the back held at 0.

    Parameters
    ----------
    stack : ThermalStack
    s : (n,) complex
        [1/s]
    depth : float
        Below the skin [m], within the layers.

    Returns
    -------
    (n,) complex

    Raises
    ------
    InputError
        The depth lies outside the layers.
    """
    if not 0 <= depth <= sum(layer.thickness for layer in stack.layers):
        raise InputError(f"found a depth of {depth:g} m; allowed: 0 to the thickness of the two layers")
    s = np.atleast_1d(np.asarray(s, complex))
    behind = [_back(stack, s)]
    for layer in reversed(stack.layers):
        behind.insert(0, _through(layer, s, behind[0]))
    response, above = np.ones_like(s), 0.0
    for layer, beyond in zip(stack.layers, behind[1:], strict=True):
        inside = min(depth - above, layer.thickness)
        response = response * _partial(layer, s, beyond, inside)
        above += layer.thickness
        if depth <= above:
            break
    return response


def _partial(layer, s: np.ndarray, beyond: np.ndarray | None, inside: float) -> np.ndarray:
    """Temperature at `inside` of a layer per kelvin at its front, as decaying exponentials: no overflow at any g d."""
    g, characteristic = _wave(layer, s)
    if np.isinf(layer.thickness):
        return np.exp(-g * inside)
    if beyond is None:
        reflection = -np.ones_like(s)
    else:
        steady = np.isclose(np.abs(characteristic), 0)
        reflection = (characteristic - beyond) / np.where(steady & (beyond == 0), 1, characteristic + beyond)
    echo = reflection * np.exp(-2 * g * layer.thickness)
    nearly_steady = np.abs(g * layer.thickness) < 1e-6
    with np.errstate(invalid="ignore", divide="ignore"):
        wave = (np.exp(-g * inside) + echo * np.exp(g * inside)) / (1 + echo)
    if beyond is None:
        steady_value = 1 - inside / layer.thickness + 0 * s
    else:
        resistance = 1 / layer.conductivity
        steady_value = 1 - beyond * inside * resistance / (1 + beyond * layer.thickness * resistance)
    return np.where(nearly_steady, steady_value, wave)


def frequencies(steps: int, period: float, scheme: str) -> np.ndarray:
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
    delay = np.exp(-1j * angle)
    if scheme == "bdf2":
        return (1.5 - 2 * delay + 0.5 * delay**2) * steps / period
    if scheme == "euler":
        return (1 - delay) * steps / period
    raise ValueError(f"unknown scheme '{scheme}': one of {', '.join(SCHEMES)}")


@dataclass(frozen=True, eq=False)
class Conduction:
    """The stack's response to N surface temperatures of a period.

    Attributes
    ----------
    stack : ThermalStack
    steps : int
    period : float
        [s]
    scheme : str
        One of `SCHEMES`.
    """

    stack: ThermalStack
    steps: int
    period: float
    scheme: str = "bdf2"

    @cached_property
    def admittance(self) -> np.ndarray:
        """Y of the harmonics 0 ... N/2, shape (N // 2 + 1,) [W m^-2 K^-1]."""
        return surface_admittance(self.stack, frequencies(self.steps, self.period, self.scheme))

    @cached_property
    def steady_conductance(self) -> float:
        """Y(0) [W m^-2 K^-1]: 0 where the mean flux is zero (adiabatic, semi-infinite)."""
        return float(self.admittance[0].real)

    def flux(self, temperature: np.ndarray) -> np.ndarray:
        """Heat flux into the surface [W m^-2] of temperatures (..., N) [K] above a back at 0."""
        return np.fft.irfft(np.fft.rfft(temperature) * self.admittance, self.steps)

    def relax(self, flux: np.ndarray, conductance: float) -> np.ndarray:
        """Temperatures (..., N) [K] whose conduction plus `conductance` times themselves is `flux` (..., N)."""
        return np.fft.irfft(np.fft.rfft(flux) / (self.admittance + conductance), self.steps)

    @cached_property
    def matrix(self) -> np.ndarray:
        """The circulant (N, N) matrix C of `flux`: flux = C T."""
        column = np.fft.irfft(self.admittance, self.steps)
        index = np.arange(self.steps)
        return column[(index[:, None] - index[None, :]) % self.steps]

    def response_time_exceeds(self, conductance: float) -> bool:
        """Whether a surface losing `conductance` [W m^-2 K^-1] settles more slowly than one step.

        The stack's own admittance at the rate 1 / step says how strongly it resists a change within the step.
        """
        rate = np.array([self.steps / self.period], complex)
        return bool(surface_admittance(self.stack, rate)[0].real > conductance)
