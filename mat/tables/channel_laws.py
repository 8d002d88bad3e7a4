"""Attributes and arrays that an atmospheric database in channels must have before it is read."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from skyshine.mat.tables.axes import EXACT, AxisRule
from skyshine.mat.tables.channel_fields import (
    END_RISE,
    GROUND_EMISSION,
    HARMONIC_LIGHT,
    NOT_READ,
    SOURCE_ELEVATION,
    SOURCE_SHARE,
    THERMAL_SHARE,
    fields_of,
)
from skyshine.mat.tables.limits import ROUNDING, Limits
from skyshine.schemas.hdf5 import Group

_NUMBERS = {
    "ground_altitude_km": Limits("-1 to 10", -1.0, 10.0),
    "scale_height_km": Limits("above 0, up to 1000", 0.0, 1000.0, above=True),
}
_GROUND = {  # ground quantities of files with light on tilted faces
    "ground_emissivity": Limits("0 to 1", 0.0, 1.0),
    "ground_temperature": Limits("0 or above", 0.0, 1e300),
    "ground_radiance": Limits("0 or above", 0.0, 1e300),
}
_SPANS = {"range_km": Limits("0 or above", 0.0, 1e9), "altitude_km": Limits("-1 or above", -1.0, 1e9)}
_LAST_NUMBER = 65535  # last number of channels and of parts


def broken_channel_laws(root: Group) -> Iterator[str]:
    """One line for each attribute, array or axis by which a file in channels cannot be read.

    Parameters
    ----------
    root : Group
        Root group, with the root attributes of the file.
    """
    yield from _attributes(root)
    dimensions = _required_dimensions(root)
    for name, dims in dimensions.items():
        if name not in root.variables:
            yield f"the array '{name}' is missing; a file in channels must contain it"
        elif tuple(root.variables[name].dims) != dims:
            yield f"'{name}' is on the axes {', '.join(root.variables[name].dims)}; allowed: {', '.join(dims)}"
    for name in sorted({dim for dims in dimensions.values() for dim in dims} - set(root.axes)):
        yield f"the axis '{name}' is missing; a file in channels must contain it"
    yield from _axes(root, dimensions)
    axis = root.axes.get(SOURCE_ELEVATION)
    if axis is not None and np.isnan(AxisRule.of(SOURCE_ELEVATION, axis).dark_below):
        yield f"the axis '{SOURCE_ELEVATION}' does not state dark_below; allowed: -90 to 0 degree"
    weight = root.variables.get("channel_weight")
    if weight is not None and abs(total := float(np.sum(np.asarray(weight.data, float))) - 1) > ROUNDING:
        yield f"channel_weight: the weights sum to {1 + total:g}; allowed: 1"
    for name in (THERMAL_SHARE, SOURCE_SHARE):
        shares = root.variables.get(name)
        if shares is not None and tuple(shares.dims) == dimensions[name]:
            off = np.abs(np.asarray(shares.data, float).sum(axis=1) - 1).max(initial=0.0)
            if not off <= ROUNDING:
                yield f"{name}: the shares of a channel sum to 1 within {off:g} only; allowed: 1"


def _required_dimensions(root: Group) -> dict[str, tuple[str, ...]]:
    """Axes of the arrays that the file must contain."""
    fields = fields_of(harmonics=_lights_tilted_faces(root), bent=END_RISE in root.variables)
    return {name: field.dims for name, field in fields.items() if name != NOT_READ}


def _lights_tilted_faces(root: Group) -> bool:
    return not {*HARMONIC_LIGHT, GROUND_EMISSION}.isdisjoint(root.variables)


def _axes(root: Group, dimensions: dict[str, tuple[str, ...]]) -> Iterator[str]:
    """Numbers of parts and codes of harmonics; no axis of a file in channels repeats."""
    for name in sorted({dim for dims in dimensions.values() for dim in dims} & set(root.axes)):
        rule = AxisRule.of(name, root.axes[name])
        nodes = tuple(rule.nodes.tolist())
        if rule.period:
            yield f"{name}: found the period {rule.period:g}; allowed: none"
        coded = name in ("harmonic", "zonal_harmonic")
        if not coded and rule.interpolation == EXACT and not 1 <= nodes[0] <= nodes[-1] <= _LAST_NUMBER:
            yield f"{name}: the numbers span {nodes[0]:g} to {nodes[-1]:g}; allowed: 1 to {_LAST_NUMBER}"


def _attributes(root: Group) -> Iterator[str]:
    attributes = root.attributes
    for name, limits in (_NUMBERS | (_GROUND if _lights_tilted_faces(root) else {})).items():
        value = _numbers(attributes.get(name))
        if value.shape != () or limits.outside(value):
            yield f"{name}: found {_shown(attributes.get(name))}; allowed: a number, {limits.words}"
    for name, limits in _SPANS.items():
        ends = _numbers(attributes.get(name))
        if ends.shape != (2,) or np.any(limits.outside(ends)) or ends[0] > ends[1]:
            yield f"{name}: found {_shown(attributes.get(name))}; allowed: two numbers, {limits.words}, ascending"


def _numbers(value: Any) -> np.ndarray:
    """The numbers of an attribute; NaN where it is something else."""
    values = np.asarray(np.nan if value is None else value)
    return values.astype(float) if values.dtype.kind in "iuf" else np.asarray(np.nan)


def _shown(value: Any) -> str:
    return "none" if value is None else " ".join(repr(value).split())[:60]
