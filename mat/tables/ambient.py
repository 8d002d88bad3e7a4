"""Properties of the surrounding ground that an atmospheric table states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class StatedGround:
    """What a file states of the ground around faces.

    Attributes
    ----------
    temperature : float
        K.
    radiance : float
        Emitted in the band at that temperature, W m^-2 sr^-1.
    """

    emissivity: float
    temperature: float
    radiance: float


def stated_ground(attributes: Mapping[str, Any]) -> StatedGround:
    """The ground of the root attributes of a file, which are numbers: `open_table` refuses others."""
    return StatedGround(*(float(attributes[f"ground_{name}"]) for name in ("emissivity", "temperature", "radiance")))
