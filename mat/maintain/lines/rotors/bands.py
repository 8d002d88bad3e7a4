"""Lines of vibration-rotation bands: strengths from transition moments, and lists of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import C2
from skyshine.mat.spectroscopy.partition import REFERENCE_TEMPERATURE
from skyshine.schemas.arrays import Floats

# 8 pi^3 / (3 h c) for moments in Debye, cm^2 (CODATA 2018).
MOMENT_FACTOR = 4.162379e-19


@dataclass(frozen=True)
class BandLines:
    """Lines (N,) of one band.

    Attributes
    ----------
    molecule, isotopologue : int
        HITRAN numbers.
    upper, lower : str
        Vibrational states.
    wavenumber, lower_energy : (N,) arrays, cm^-1
    strength : (N,) array
        cm/molecule at 296 K, natural abundance included.
    air_width, self_width, temperature_exponent, shift : (N,) arrays
        Widths, exponents and shifts as in `LineList`.
    upper_rotation, lower_rotation : (N,) str arrays
        Rotational quantum numbers as HITRAN writes them, 15 characters.
    source : str
        Source of constants, strength and widths.
    """

    molecule: int
    isotopologue: int
    upper: str
    lower: str
    wavenumber: Floats
    strength: Floats
    lower_energy: Floats
    air_width: Floats
    self_width: Floats
    temperature_exponent: Floats
    shift: Floats
    upper_rotation: npt.NDArray[np.str_]
    lower_rotation: npt.NDArray[np.str_]
    source: str


def strength(
    wavenumber: Floats, lower_energy: Floats, squared_moment: Floats, partition_sum: float, share: float
) -> Floats:
    """Line strengths at 296 K, cm/molecule (L. S. Rothman et al. 1998, JQSRT 60, 665, equation A5).

    Parameters
    ----------
    wavenumber, lower_energy : (N,) arrays, cm^-1
    squared_moment : (N,) array
        Squared transition moments summed over the orientations of both levels, Debye^2.
    partition_sum : float
        Partition sum at 296 K, without the weights of nuclear spin that `squared_moment` lacks.
    share : float
        Natural abundance.
    """
    reference = REFERENCE_TEMPERATURE
    occupied = np.exp(-C2 * lower_energy / reference) / partition_sum
    return np.asarray(
        share * MOMENT_FACTOR * wavenumber * squared_moment * occupied * -np.expm1(-C2 * wavenumber / reference)
    )
