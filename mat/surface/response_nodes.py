"""Nodes of the response of surfaces to a change of absorbed heat, as tables contain them (`response.py`)."""

from __future__ import annotations

import numpy as np

from skyshine.schemas.arrays import Floats

RESPONSE_HOURS = np.arange(24.0)  # local clock [h]
# h: where the cells of lag begin; the last ends a day after the first begins. The first is the step of the finest
# solution about the present, others grow with the lag, as the response becomes smooth.
LAG_STARTS = np.array(
    [-1 / 24, 1 / 24, 1 / 8, 3 / 8, 5 / 8, 7 / 8, 11 / 8, 15 / 8, 23 / 8, 31 / 8, 47 / 8, 63 / 8, 95 / 8, 127 / 8]
)
# K from the temperature of the air, where stable air turns unstable and the heat loss bends; closer near it.
_AWAY = (0.5, 1.5, 3.0, 5.0, 8.0, 12.0, 17.0, 23.0, 30.0, 40.0, 52.0, 70.0, 95.0, 140.0)
OFFSETS = np.array([*(-offset for offset in reversed(_AWAY)), 0.0, *_AWAY])
RESPONSE_SLOPES = np.array([0.0, 90.0, 180.0])  # degree


def response_slopes(slopes: Floats) -> Floats:
    """Slopes of the planes whose response is stored for faces of some slopes [degree].

    Convection differs between level, upright and hanging surfaces.
    """
    between = RESPONSE_SLOPES[np.searchsorted(RESPONSE_SLOPES, slopes.min(), side="right") - 1 :]
    return between[: int(np.searchsorted(between, slopes.max())) + 1]
