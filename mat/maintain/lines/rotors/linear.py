"""Bands of a linear molecule: levels from polynomials, strengths from Honl-London factors and a band's moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mat.maintain.lines.rotors.asymmetric import clebsch_gordan
from skyshine.schemas.arrays import Floats

Constants = tuple[float, float, float, float]  # G, B, D, H of G + B x - D x^2 + H x^3, x = J (J + 1) - l^2, cm^-1
PARITIES = ("e", "f")


@dataclass(frozen=True)
class LinearState:
    """A vibrational state of a linear molecule.

    Attributes
    ----------
    name : str
        Quantum numbers v1 v2 l2 v3.
    e, f : Constants
        Constants of the levels of either parity; a state with l = 0 has e alone.
    """

    name: str
    e: Constants
    f: Constants | None = None

    @property
    def bending_momentum(self) -> int:
        """Angular momentum of the bending vibration."""
        return int(self.name[2])

    def energy(self, parity: str, j: int) -> float:
        """Energy of a level, cm^-1."""
        constants = self.e if parity == "e" else self.f
        if constants is None:
            raise ValueError(f"state {self.name} has no levels of parity {parity}")
        x = j * (j + 1.0) - self.bending_momentum**2
        origin, b, d, h = constants
        return origin + b * x - d * x**2 + h * x**3


def transitions(lower: LinearState, upper: LinearState, largest_j: int) -> dict[str, Floats]:
    """All lines of a band.

    Returns
    -------
    dict of (N,) arrays
        ``wavenumber`` and ``lower_energy`` (cm^-1), ``factor`` (squared direction cosine, summed over the orientations
        of both levels), lower J as ``j``, ``step`` (upper less lower J) and ``f`` (1 where the lower
        level has parity f).
    """
    change = upper.bending_momentum - lower.bending_momentum
    if abs(change) > 1:
        raise ValueError(f"no dipole transition from {lower.name} to {upper.name}")
    # Levels of l > 0 are sums and differences of +l and -l: one of the two parts reaches l = 0, or is reached from it.
    lower_momentum, upper_momentum = lower.bending_momentum, upper.bending_momentum
    share = 2.0 if change and 0 in (lower_momentum, upper_momentum) else 1.0
    rows = []
    for j in range(lower_momentum, largest_j + 1):
        for step in (-1, 0, 1):
            if j + step < upper_momentum or (j == 0 and step == 0):
                continue
            factor = (
                share
                * (2 * j + 1)
                * clebsch_gordan(j, j + step, change)[j + step + upper_momentum, j + lower_momentum] ** 2
            )
            for parity in PARITIES if lower.f else PARITIES[:1]:
                upper_parity = parity if step else PARITIES[1 - PARITIES.index(parity)]
                if factor == 0.0 or (upper_parity == "f" and upper.f is None):
                    continue
                low = lower.energy(parity, j)
                rows.append((upper.energy(upper_parity, j + step) - low, low, factor, j, step, parity == "f"))
    columns = np.array(rows, float).T
    return dict(zip(("wavenumber", "lower_energy", "factor", "j", "step", "f"), columns, strict=True))
