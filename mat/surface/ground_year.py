"""Temperature of the ground below by the season: an annual wave at its surface, weaker and later with depth.

References
----------
Kusuda and Achenbach (1965), Earth temperature and thermal diffusivity at selected stations in the United States,
ASHRAE Trans. 71 (1), 61-74. An annual harmonic of the air represents that of the ground's surface, as in weather files.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.materials.records import ThermalStack
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

YEAR = 365.25  # d
_SECONDS = 86400.0  # in a day


@dataclass(frozen=True, eq=False)
class GroundSeason:
    """The annual wave at the surface of the ground, on a day; each a number or an array, which broadcast.

    Attributes
    ----------
    mean, amplitude : float or ndarray
        Mean and amplitude of the year [K].
    since_coldest : float or ndarray
        Time since the surface was coldest [d].

    Examples
    --------
    Half a year after the coldest day the surface is warmest:

    >>> float(GroundSeason(283.0, 10.0, YEAR / 2).below(0.0))
    293.0
    """

    mean: float | Floats
    amplitude: float | Floats
    since_coldest: float | Floats

    def below(self, damping: float) -> Floats:
        """Temperature [K] below so many damping depths of ground, by the law of Kusuda and Achenbach."""
        angle = 2 * np.pi * np.asarray(self.since_coldest) / YEAR - damping
        kelvin: Floats = self.mean - self.amplitude * np.exp(-damping) * np.cos(angle)
        return kelvin


def damping_depths(stack: ThermalStack) -> float:
    """Thickness of the layers of a stack in damping depths of the annual wave; what is endless has no deep side."""
    layers = [layer for layer in stack.layers if np.isfinite(layer.thickness)]
    return sum(damping(layer.thickness, layer.conductivity / (layer.density * layer.heat_capacity)) for layer in layers)


def damping(depth: float, diffusivity: float) -> float:
    """A depth [m] over the damping depth of the annual wave, sqrt(2 diffusivity / frequency).

    Parameters
    ----------
    depth, diffusivity : float
        [m], [m^2 s^-1]

    Examples
    --------
    >>> round(damping(1.0, 6e-7), 3)
    0.407
    """
    return float(depth * np.sqrt(np.pi / (diffusivity * YEAR * _SECONDS)))


def spans_year(day: Floats) -> bool:
    """Whether readings at days of the year lie in each of its twelfths."""
    return np.unique(np.floor(day / YEAR * 12) % 12).size == 12


def annual_harmonic(day: Floats, temperature: Floats) -> tuple[float, float, float]:
    """Mean, amplitude and coldest day of the annual harmonic of readings, by least squares.

    Parameters
    ----------
    day : (n,) ndarray
        Day of the year, 1 at noon of 1 January [d].
    temperature : (n,) ndarray
        Any unit; not a number where it is missing.

    Returns
    -------
    mean, amplitude : float
        [unit of the temperature]
    coldest_day : float
        1 to a year after [d].

    Raises
    ------
    InputError
        The readings do not span a year.
    """
    finite = np.isfinite(temperature)
    if not spans_year(day[finite]):
        raise InputError(
            "found temperatures of a part of the year; allowed: of all its twelfths; give mean_c and amplitude_c, or"
            " latitude"
        )
    angle = 2 * np.pi * day[finite] / YEAR
    terms = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    (mean, cosine, sine), *_ = np.linalg.lstsq(terms, temperature[finite], rcond=None)
    coldest = np.arctan2(-sine, -cosine) * YEAR / (2 * np.pi)
    return float(mean), float(np.hypot(cosine, sine)), float((coldest - 1.0) % YEAR + 1.0)
