"""Temperatures under a change of absorbed heat: computed from the response in a ``.htt`` database.

``schemas/formats/htt-1.md`` gives the formulas.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skyshine.mat.tables.film_response import FILM
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group

KERNEL, REFERENCE = "response_kernel", "response_temperature"
LOSS_SLOPE, LOSS_EXCESS = "heat_loss_slope", "heat_loss_excess"
HIGHEST, MELT = "highest_temperature", "melting_heat"
ALTITUDE, SLOPE, HOUR, LAG, OFFSET = (
    "response_altitude",
    "response_slope",
    "response_hour",
    "lag",
    "temperature_offset",
)

FORCING_STEPS = 288  # forcing steps of a day, at which changes of heat and temperature are computed
DAY_H = 24.0  # h


def forcing_hours() -> Floats:
    """Clock hours of the steps of a day, (FORCING_STEPS,)."""
    return np.arange(float(FORCING_STEPS)) * (DAY_H / FORCING_STEPS)


def need_parts(root: Group, names: Sequence[str]) -> None:
    """Refuse a database that contains some arrays for shade and lacks others, or one of their axes.

    Raises
    ------
    InputError
    """
    for name in names:
        if name not in root.variables or not set(root.variables[name].dims) <= set(root.axes):
            raise InputError(f"lacks '{name}' of the response to shade, or an axis of it; build it again")


def need_response(root: Group) -> None:
    """Refuse a database without the response to shade, or with a part of it.

    Raises
    ------
    InputError
    """
    if KERNEL not in root.variables:
        raise InputError("has no response to shade; build it again, without needs.shade: false")
    film = FILM if FILM[0] in root.variables else ()
    need_parts(root, (KERNEL, REFERENCE, LOSS_SLOPE, LOSS_EXCESS, MELT, HIGHEST, *film))
