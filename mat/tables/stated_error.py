"""The stated error of a table, and the group in which it is stored."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.hdf5 import Axis, Group, Variable


@dataclass(frozen=True)
class ErrorMeasure:
    """Errors of one quantity over some points.

    Attributes
    ----------
    maximum, p99, p95, rms : float
        Errors in the units of the quantity; of atmospheric tables all but the first of the worst region.
    maximum_kelvin, p99_kelvin, p95_kelvin, rms_kelvin : float
        Errors as equivalent temperature.
    maximum_percent, p99_percent : float
        Errors in percent of the light that the scene sends, where that is defined.
    regions : dict of str to ErrorMeasure
        Errors over the points of each region alone, by its name.
    """

    quantity: str
    points: int
    maximum: float
    p99: float
    p95: float
    rms: float
    maximum_kelvin: float
    p99_kelvin: float
    p95_kelvin: float
    rms_kelvin: float
    maximum_percent: float
    p99_percent: float
    regions: dict[str, ErrorMeasure] = field(default_factory=dict)


def measure(
    quantity: str,
    error: Floats,
    kelvin: Floats,
    percent: Floats | None = None,
    *,
    regions: Mapping[str, Booleans] | None = None,
) -> ErrorMeasure:
    """Summarise errors in own units, in kelvin and in percent, (n,) each; not a number where there was no point to
    measure at. Regions (n,) say which points lie in each.
    """
    magnitudes, as_kelvin = (np.abs(np.ravel(values)) for values in (error, kelvin))
    as_percent = np.full(magnitudes.size, np.nan) if percent is None else np.abs(np.ravel(percent))
    if not magnitudes.size:
        nan = float("nan")
        return ErrorMeasure(quantity, 0, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan)
    top, p99, p95, rms = _summary(magnitudes)
    top_k, p99_k, p95_k, rms_k = _summary(as_kelvin)
    top_percent, p99_percent, _, _ = _summary(as_percent)
    parts = {
        name: measure(quantity, magnitudes[inside.ravel()], as_kelvin[inside.ravel()], as_percent[inside.ravel()])
        for name, inside in (regions or {}).items()
    }
    return ErrorMeasure(
        quantity, magnitudes.size, top, p99, p95, rms, top_k, p99_k, p95_k, rms_k, top_percent, p99_percent, parts
    )


def with_independent(
    measured: ErrorMeasure,
    kelvin: Mapping[str, Mapping[str, float]],
    percent: Mapping[str, Mapping[str, float]],
    region: str,
) -> ErrorMeasure:
    """Errors with others that do not depend on them: squares add, largest errors add.

    Parameters
    ----------
    kelvin, percent : mappings
        The others by region and then by "max", "p99", "p95" and "rms"; none where there are no others.
    region : str
        Name of the region of all points. Regions of `measured` without independent errors get those of all points.
    """
    if not kelvin:
        return measured
    parts = {
        name: with_independent(part, kelvin, percent, name if name in kelvin else region)
        for name, part in measured.regions.items()
    }
    kelvin_here, percent_here = kelvin[region], percent[region]
    return replace(
        measured,
        maximum_kelvin=measured.maximum_kelvin + kelvin_here["max"],
        p99_kelvin=math.hypot(measured.p99_kelvin, kelvin_here["p99"]),
        p95_kelvin=math.hypot(measured.p95_kelvin, kelvin_here["p95"]),
        rms_kelvin=math.hypot(measured.rms_kelvin, kelvin_here["rms"]),
        maximum_percent=measured.maximum_percent + percent_here["max"],
        p99_percent=math.hypot(measured.p99_percent, percent_here["p99"]),
        regions=parts,
    )


def of_worst_region(measured: ErrorMeasure, regions: Sequence[str]) -> ErrorMeasure:
    """Errors whose percentiles and root mean square are those of the region, of some, in which each is largest: 99 % of
    the pixels of any scene err by no more, whichever of these regions they see. Unchanged where no region has points.
    """
    parts = [part for name, part in measured.regions.items() if name in regions and part.points]
    if not parts:
        return measured
    names = [f"{name}{unit}" for name in ("p99", "p95", "rms") for unit in ("", "_kelvin")]
    return replace(measured, **{name: max(getattr(part, name) for part in parts) for name in (*names, "p99_percent")})


def _summary(size: Floats) -> tuple[float, float, float, float]:
    p99, p95 = (float(share) for share in np.percentile(size, (99, 95)))
    return float(size.max()), p99, p95, float(np.sqrt(np.mean(size**2)))


_STATISTICS = {
    "maximum": "largest error",
    "p99": "99th percentile of the error",
    "p95": "95th percentile of the error",
    "rms": "root mean square error",
}
_UNITS = {
    "": ("1", ", in quantity's units"),
    "_kelvin": ("K", ", as equivalent temperature"),
    "_percent": ("%", ", of the light of the scene"),
}


def accuracy_group(
    measures: Sequence[ErrorMeasure], extra: Mapping[str, Variable], axes: dict[str, Axis], notes: dict[str, Any]
) -> Group:
    """The ``/accuracy`` group of a file.

    Parameters
    ----------
    extra, axes : mappings
        Further errors (of the compiled band, of the solver) with their axes.
    notes : dict
        Seed, method and other facts of the measurement.
    """
    names = np.array([m.quantity for m in measures], object)
    in_percent = any(np.isfinite(m.maximum_percent) for m in measures)
    variables = {
        f"{name}{suffix}": Variable(
            ("quantity",), np.array([getattr(m, f"{name}{suffix}") for m in measures]), unit, f"{words}{where}"
        )
        for suffix, (unit, where) in _UNITS.items()
        for name, words in _STATISTICS.items()
        if suffix != "_percent" or (in_percent and name in ("maximum", "p99"))
    }
    variables["points"] = Variable(
        ("quantity",), np.array([m.points for m in measures], np.int64), "1", "points at which the error was measured"
    )
    all_axes = {"quantity": Axis(names, "1", "quantity whose interpolation error is stated")}
    regions = list(dict.fromkeys(name for m in measures for name in m.regions))
    if regions:
        all_axes["region"] = Axis(np.array(regions, object), "1", "part of the points; parts overlap")
        variables |= _by_region(measures, regions, in_percent)
    return Group(all_axes | axes, variables | dict(extra), {}, notes)


def _by_region(measures: Sequence[ErrorMeasure], regions: Sequence[str], in_percent: bool) -> dict[str, Variable]:
    empty = measure("", np.empty(0), np.empty(0))
    rows = [[m.regions.get(name, empty) for name in regions] for m in measures]
    dims = ("quantity", "region")
    points = np.array([[part.points for part in row] for row in rows], np.int64)
    variables = {"region_points": Variable(dims, points, "1", "points of each part")}
    for suffix, (unit, where) in _UNITS.items():
        if suffix != "_percent" or in_percent:
            for name in ("maximum", "p99"):
                values = np.array([[getattr(part, f"{name}{suffix}") for part in row] for row in rows])
                text = f"{_STATISTICS[name]} in each part{where}"
                variables[f"region_{name}{suffix}"] = Variable(dims, values, unit, text)
    return variables


def worst_kelvin(table: Group) -> dict[str, Any] | None:
    """Name of the quantity that errs most, its 99 % and largest error [K], and the tolerance `asked` where it is less
    and in kelvin; None where no quantity has kelvin.
    """
    accuracy = table.groups.get("accuracy")
    if accuracy is None or "quantity" not in accuracy.axes:
        return None
    p99, largest = (np.asarray(accuracy.variables[name].data, float) for name in ("p99_kelvin", "maximum_kelvin"))
    if not np.any(np.isfinite(p99)):
        return None
    row = int(np.nanargmax(p99))
    name = str(np.asarray(accuracy.axes["quantity"].values)[row])
    worst = {"quantity": name, "p99": round(float(p99[row]), 4), "maximum": round(float(largest[row]), 4)}
    tolerance, _, unit = str(accuracy.attributes.get("tolerance", "")).partition(" ")
    return worst | {"asked": float(tolerance)} if unit == "K" and p99[row] > float(tolerance) else worst
