"""Integrals of properties of the air across layers."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import Shells, trace
from skyshine.schemas.arrays import Floats


def vertical_column(shells: Shells, per_molecule: Floats) -> Floats:
    """Integral of a property (N, P) [m^2 per molecule] across each layer, (N-1, P)."""
    lower, upper = vertical_parts(shells, per_molecule)
    return lower + upper


def vertical_parts(shells: Shells, per_molecule: Floats) -> tuple[Floats, Floats]:
    """The two parts (N-1, P) of `vertical_column`: by the property at each layer's lower and at its upper level."""
    zenith = trace(shells, shells.altitude[:1], np.array([np.pi / 2]))
    count = shells.altitude.size - 1
    lower, upper = (air[0, count:, None] for air in (zenith.lower, zenith.upper))  # the segments on the way up
    return lower * per_molecule[:-1], upper * per_molecule[1:]
