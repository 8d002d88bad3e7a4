"""Numbers, arrays and limits that a user gives to the functions of `skyshine.mat`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError


def wavenumber_limits(
    wavenumber: tuple[float, float] | None, wavelength: tuple[float, float] | None
) -> tuple[float, float]:
    """Lowest and highest wavenumber, cm^-1."""
    if (wavenumber is None) == (wavelength is None):
        raise InputError("found both or neither of wavenumber (cm-1) and wavelength (um); give one of them")
    low, high = wavenumber or wavelength or (0.0, 0.0)
    if not 0 < low < high < math.inf:
        raise InputError(f"found the limits {low:g} and {high:g}; allowed: 0 < low < high")
    return (low, high) if wavelength is None else (1e4 / high, 1e4 / low)


def numbers(name: str, value: Any, infinite: bool = False) -> npt.NDArray[np.float64]:
    """A number () or array (n,) of what the user gave; with `infinite` for what must only be at least 0, or
    ``'space'``.

    Raises
    ------
    InputError
    """
    if isinstance(value, str) or not np.iterable(value):
        values = np.array(number(name, _infinite(value) if infinite else value, infinite=True))
    else:
        rows = [_infinite(item) for item in value] if infinite else value
        try:
            values = np.ma.filled(np.ma.asarray(rows, dtype=float), np.nan)
        except (TypeError, ValueError):
            raise InputError(f"found {name} {value!r}; allowed: numbers") from None
        if values.ndim != 1 or not values.size:
            raise InputError(
                f"found {name} of shape {values.shape}; allowed: a number or a one-dimensional array of them"
            )
    if infinite and not np.all(values >= 0):
        raise InputError(f"found the {name} {_worst(values, ~(values >= 0))}; allowed: at least 0 km, or 'space'")
    if not infinite and not np.all(np.isfinite(values)):
        raise InputError(f"found {name} {_worst(values, ~np.isfinite(values))}; allowed: a finite number")
    return values


def _worst(values: npt.NDArray[np.float64], wrong: npt.NDArray[np.bool_]) -> float:
    """First of the values that are wrong."""
    return float(np.ravel(values)[np.flatnonzero(wrong)[0]])


def _infinite(value: Any) -> Any:
    """Infinity for ``'space'``."""
    return math.inf if isinstance(value, str) and value == "space" else value


def number(name: str, value: Any, infinite: bool = False) -> float:
    """A Python float of whatever is a single number, such as numpy's; finite unless `infinite`.

    Raises
    ------
    InputError
    """
    try:
        result = float(np.asarray(value, dtype=float)[()])
    except (TypeError, ValueError):
        raise InputError(f"found {name} {value!r}; allowed: a number") from None
    if not (infinite or math.isfinite(result)):
        raise InputError(f"found {name} {result}; allowed: a finite number")
    return result
