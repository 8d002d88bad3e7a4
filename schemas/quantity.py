"""A number or an array with its units, in the shape that every command prints as JSON."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def quantity(values: Any, units: str) -> dict[str, Any]:
    """A number or an array with its units, in the shape that every command prints.

    Values that are not finite (a masked cell, an unbounded limit) become null: JSON has no other name for them.
    """
    array = np.asarray(values)
    if array.ndim == 0:
        return {"units": units, "value": _plain(array.item())}
    return {"units": units, "values": _plain(array.tolist())}


def _plain(value: Any) -> Any:
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def short(value: float | None) -> str:
    """A number in three digits for a table; a dash for none."""
    return "-" if value is None else f"{value:.3g}"
