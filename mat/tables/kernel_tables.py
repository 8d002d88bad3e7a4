"""Open databases as tables of the C library, cached with their Python table; its refusals become messages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.kernel import pixels as kernel
from skyshine.mat.tables.axes import EXACT, PERIODIC, AxisRule
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    from skyshine.mat.tables.table import Table

_RULES = {PERIODIC: kernel.PERIODIC, EXACT: kernel.EXACT}
_GROUND = ("ground_emissivity", "ground_temperature", "ground_radiance", "ground_albedo")
_ALWAYS = ("temperature",)  # quantities of a surface without response to shade
_HEIGHTS = ("ground_altitude_km", "scale_height_km")
_KEPT, _MOST = "_kernel_tables", 4  # with a table: those of it and of so many others


def kernel_tables(surface: Table | None = None, band: Table | None = None, air: Table | None = None) -> kernel.Tables:
    """The tables of the library of some databases, made once for each of them.

    Raises
    ------
    InputError
        Atmosphere and band are of different bands, or an array does not fit its axes.
    """
    arguments = surface, band, air
    owner = next(table for table in (air, band, surface) if table is not None)
    cache: dict[Any, tuple[Any, kernel.Tables]] = owner.__dict__.setdefault(_KEPT, {})
    key = tuple(id(table) for table in arguments)
    if key not in cache:
        databases = [None if table is None else _database(kind, table, surface) for kind, table in enumerate(arguments)]
        with messages(None if band is None else band.path):
            tables = kernel.Tables(*databases)
        if len(cache) == _MOST:
            del cache[next(iter(cache))]
        cache[key] = arguments, tables
    return cache[key][1]


def _database(kind: int, table: Table, surface: Table | None) -> kernel.Database:
    root, database = table.root, kernel.Database(kind)
    lacks_response = kind == kernel.SURFACE and "response_kernel" not in root.variables
    for number, (name, axes) in enumerate(kernel.array_names(kind)):
        if name not in root.variables or (lacks_response and name not in _ALWAYS):
            continue
        data = root.variables[name].data
        missing = [axis for axis in axes if axis not in root.axes]
        if missing or data.shape != tuple(np.size(root.axes[axis].values) for axis in axes):
            raise InputError(f"'{name}' does not fit its axes; build the file again", file=table.path)
        database.set_array(number, data)
        for position, axis in enumerate(axes):
            rule = table.out_of_range.applied(
                AxisRule.of(axis, root.axes[axis]), "source_elevation" if axis == "sky_source_elevation" else None
            )
            number_of_rule = _RULES.get(rule.interpolation, kernel.LINEAR)
            nodes = np.asarray(rule.nodes, float)
            clamps = rule.out_of_range == "clamp"
            database.set_axis(number, position, nodes, number_of_rule, rule.period, rule.dark_below, clamps)
    database.set_numbers(_numbers(kind, table, surface))
    return database


def _numbers(kind: int, table: Table, surface: Table | None) -> dict[str, float]:
    attributes = table.attributes
    numbers = {name: float(attributes[name]) for name in (*_GROUND, *_HEIGHTS) if name in attributes}
    materials = surface.materials if kind == kernel.AIR and surface is not None else table.materials
    if "ground_material" in attributes:
        numbers["ground_code"] = float(materials.get(str(attributes["ground_material"]), 0))
    if kind != kernel.AIR:
        return numbers
    for name in ("range", "altitude"):
        low, high = (float(value) for value in attributes[f"{name}_km"])
        numbers |= {f"{name}_first": low, f"{name}_last": high}
    clamped = table.out_of_range
    return numbers | {
        f"clamp_{name}": float(clamped.everywhere or name in clamped.axes)
        for name in ("range", "altitude", "elevation")
    }


@contextmanager
def messages(file: Path | None = None) -> Iterator[None]:
    """Refusals of the library within, as messages; of a file, where it is one that is refused."""
    try:
        yield
    except kernel.KernelRefusal as refusal:
        raise InputError(_TEXTS[refusal.status](refusal), file=file) from None


def _outside(refusal: kernel.KernelRefusal) -> str:
    if not np.isfinite(refusal.found):
        return f"{refusal.name}: found a value that is not finite; allowed: finite numbers"
    return (
        f"{refusal.name}: found {refusal.found:g}; allowed: {refusal.least:g} to {refusal.most:g}; stay inside, build"
        " the file with more nodes, or read the nearest one with table.clamped() or mat query --clamp"
    )


def _twilight(refusal: kernel.KernelRefusal) -> str:
    return (
        f"{refusal.name}: found {refusal.found:g}; allowed: {refusal.least:g} and above, or {refusal.most:g} and below,"
        " where it is dark; for twilight, build the file with a node at -6 or below"
    )


def _share(refusal: kernel.KernelRefusal) -> str:
    what = "share in the shade" if refusal.name == "shade" else refusal.name
    return f"found a {what} beyond 0 to 1 ({refusal.found:g}); allowed: 0 to 1, as a texture's `shade` gives it"


_TEXTS: dict[int, Callable[[kernel.KernelRefusal], str]] = {
    kernel.OUTSIDE: _outside,
    kernel.CODE: lambda r: f"{r.name}: found {r.found:g}; allowed: the codes of the table; name one of them",
    kernel.TWILIGHT: _twilight,
    kernel.DIRECTION: lambda r: "found a direction without length; allowed: three finite numbers that are not all 0",
    kernel.SHARE: _share,
    kernel.LENGTH: lambda r: f"{r.name}: found {r.found:g}; allowed: 0 km or more",
    kernel.NO_MATERIAL: lambda r: "found a pixel without material; allowed: codes of the tables; leave such pixels out",
    kernel.NO_RESPONSE: lambda r: "has no response to shade; build it again, without needs.shade: false",
    kernel.NO_GROUND: lambda r: (
        "the atmosphere names a ground that the temperatures lack, or states none; build all files from one job"
    ),
    kernel.NOT_FINITE: lambda r: (
        f"{r.name}: found no steps or a value that is not finite; allowed: finite W m^-2 by time"
    ),
    kernel.LACKS: lambda r: f"lacks '{r.name}', or an axis of it; build the file again",
    kernel.NODES: lambda r: f"the axis '{r.name}' has nodes that are not those of the format; build the file again",
    kernel.BANDS: lambda r: (
        f"spans {r.least:g} to {r.most:g} um, at {r.found:g} wavelengths that are not those of the atmosphere; allowed:"
        " the same band; build both from one job"
    ),
}
