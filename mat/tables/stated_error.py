"""The error that a table states about itself, and the group that holds it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyshine.schemas.hdf5 import Axis, Group, Variable


@dataclass(frozen=True)
class ErrorMeasure:
    """Errors of one quantity over all points measured.

    Attributes
    ----------
    quantity : str
    points : int
    maximum, p95, rms : float
        In the quantity's own units.
    maximum_kelvin, p95_kelvin, rms_kelvin : float
        As equivalent temperature.
    """

    quantity: str
    points: int
    maximum: float
    p95: float
    rms: float
    maximum_kelvin: float
    p95_kelvin: float
    rms_kelvin: float


def measure(quantity: str, error: np.ndarray, kelvin: np.ndarray) -> ErrorMeasure:
    """Summarise errors (n,) in own units and the same in kelvin; not a number where there was no point to measure
    at.
    """
    size = np.abs(np.ravel(error)), np.abs(np.ravel(kelvin))
    if not size[0].size:
        return ErrorMeasure(quantity, 0, *[float("nan")] * 6)
    units, as_kelvin = ((float(e.max()), float(np.percentile(e, 95)), float(np.sqrt(np.mean(e**2)))) for e in size)
    return ErrorMeasure(quantity, size[0].size, *units, *as_kelvin)


def accuracy_group(
    measures: Sequence[ErrorMeasure], extra: Mapping[str, Variable], axes: dict[str, Axis], notes: dict[str, Any]
) -> Group:
    """The ``/accuracy`` group of a file.

    Parameters
    ----------
    measures : sequence of ErrorMeasure
    extra, axes : mappings
        Further errors (of the compiled band, of the solver) with their axes.
    notes : dict
        Seed, method and other facts of the measurement.
    """
    names = np.array([m.quantity for m in measures], object)
    statistics = ("maximum", "p95", "rms")
    words = {"maximum": "largest error", "p95": "95th percentile of the error", "rms": "root mean square error"}
    variables = {
        name: Variable(
            ("quantity",), np.array([getattr(m, name) for m in measures]), "1", f"{words[name]}, in quantity's units"
        )
        for name in statistics
    }
    variables |= {
        f"{name}_kelvin": Variable(
            ("quantity",),
            np.array([getattr(m, f"{name}_kelvin") for m in measures]),
            "K",
            f"{words[name]}, as equivalent temperature",
        )
        for name in statistics
    }
    variables["points"] = Variable(
        ("quantity",), np.array([m.points for m in measures], np.int64), "1", "points at which the error was measured"
    )
    quantity = Axis(names, "1", "quantity whose interpolation error is stated")
    return Group({"quantity": quantity} | axes, variables | dict(extra), {}, notes)


def worst_kelvin(table: Group) -> dict[str, Any] | None:
    """Of a table's quantity that errs most: its name, 95 % and largest error [K]; None where none has kelvin."""
    accuracy = table.groups.get("accuracy")
    if accuracy is None or "quantity" not in accuracy.axes:
        return None
    p95, largest = (np.asarray(accuracy.variables[name].data, float) for name in ("p95_kelvin", "maximum_kelvin"))
    if not np.any(np.isfinite(p95)):
        return None
    row = int(np.nanargmax(p95))
    name = str(np.asarray(accuracy.axes["quantity"].values)[row])
    return {"quantity": name, "p95": round(float(p95[row]), 4), "maximum": round(float(largest[row]), 4)}
