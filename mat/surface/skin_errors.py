"""Bias and root mean square of predicted skin temperatures, by day and by night."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats

DAYLIGHT = 20.0  # W m^-2 of sunlight above which it is day


@dataclass(frozen=True)
class SkinError:
    """Error of one prediction over some readings.

    Attributes
    ----------
    part : str
        "fitted" or "held out".
    prediction, hours : str
        "all", "day" or "night".
    bias, rms : float
        Predicted less measured [K].
    count : int
        Number of readings.
    """

    part: str
    prediction: str
    hours: str
    bias: float
    rms: float
    count: int


def skin_errors(
    measured: Floats,
    predictions: Mapping[str, Floats],
    sunlight: Floats,
    parts: Mapping[str, npt.NDArray[np.bool_]],
) -> tuple[SkinError, ...]:
    """Errors of predictions (N,) [K] in parts (N,) of a record; hours without any reading are omitted.

    Parameters
    ----------
    measured : (N,) ndarray
        [K]; NaN where there is none.
    predictions : mapping of str to (N,) ndarray
        [K]; NaN where one says nothing.
    sunlight : (N,) ndarray
        [W m^-2]
    parts : mapping of str to (N,) ndarray of bool
    """
    everything, day = np.ones(len(measured), bool), sunlight > DAYLIGHT
    errors = []
    for part, inside in parts.items():
        for name, predicted in predictions.items():
            error = predicted - measured
            for hours, chosen in (("all", everything), ("day", day), ("night", ~day)):
                values = error[inside & chosen & np.isfinite(error)]
                if values.size:
                    bias, rms = float(values.mean()), float(np.sqrt(np.mean(values**2)))
                    errors.append(SkinError(part, name, hours, bias, rms, int(values.size)))
    return tuple(errors)
