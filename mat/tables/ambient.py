"""Properties of the surrounding ground that an atmospheric table states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.schemas.errors import InputError


@dataclass(frozen=True)
class StatedGround:
    """What a file states of the ground around faces.

    Attributes
    ----------
    emissivity : float
    temperature : float
        K.
    radiance : float
        Emitted in the band at that temperature, W m^-2 sr^-1.
    """

    emissivity: float
    temperature: float
    radiance: float


def stated_ground(path: Path, attributes: Mapping[str, Any]) -> StatedGround:
    """The ground of a file's root attributes.

    Raises
    ------
    InputError
        One of them is missing, no number, or negative.
    """
    names = ("ground_emissivity", "ground_temperature", "ground_radiance")
    try:
        values = [float(attributes[name]) for name in names]
    except (KeyError, TypeError, ValueError):
        raise InputError(f"lacks {', '.join(names)} or one of them; build the file again", file=path) from None
    if not all(np.isfinite(value) and value >= 0 for value in values):
        raise InputError(f"states {', '.join(names)} that no ground has; build the file again", file=path)
    return StatedGround(*values)
