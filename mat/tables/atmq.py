"""Layout of the ``.atmq`` and ``.lunar_atmq`` databases."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.tables.axes import FOLDED, LINEAR, table_axis
from skyshine.mat.tables.gridded import ANGLE, AXES, FIELDS, Gridded
from skyshine.schemas.hdf5 import Axis, Group, Variable

if TYPE_CHECKING:
    from skyshine.mat.quantities.grid import PathGrid

RADIANCE = "W m^-2 sr^-1"
PATH = AXES[:3]
_DESCRIBED = {
    "beta_star": ("km", "beta* = -5.5 r / ln(transmittance), equation (8)", {}),
    "path_radiance_ratio": (
        RADIANCE,
        "path radiance over (1 - transmittance), equations (10) and (11)",
        {"comment": "source angles are those at the observer"},
    ),
    "ambient_radiance": (
        RADIANCE,
        "sky irradiance over pi, weighted by path transmittance, equation (20)",
        {"comment": "source elevation is the one at the surface point"},
    ),
    "direct_radiance": (
        RADIANCE,
        "direct source irradiance over pi, weighted by path transmittance, equation (36)",
        {"comment": "source elevation is the one at the surface point; normal to the beam"},
    ),
}
_READ = {
    "range": ("km", "line-of-sight range from the observer to the surface point"),
    "altitude": ("km", "observer altitude above sea level"),
    "elevation": ("degree", "line-of-sight elevation at the observer"),
    "source_elevation": ("degree", "geometric elevation of the source"),
    "source_azimuth": ("degree", "azimuth of the source relative to the line of sight"),
    ANGLE: ("degree", "angle between the line of sight and the source, at the observer"),
}


def atmq_group(tables: Mapping[str, Gridded], accuracy: Group, attributes: dict[str, Any]) -> Group:
    """Arrange the four quantities of a state, band and source for writing.

    Parameters
    ----------
    tables : mapping of str to Gridded
        By the names of `gridded.QUANTITIES`. Axes that differ from those of the path radiance get the quantity's name
        before their own.
    accuracy : Group
        The measured errors of the tables and of the compiled band.
    attributes : dict
        Band edges, state and source, for the root.
    """
    path = tables["path_radiance_ratio"]
    shared = dict(zip(path.axes, path.nodes, strict=True))
    axes, variables = {name: _axis(name, nodes) for name, nodes in shared.items()}, {}
    for quantity, (units, words, more) in _DESCRIBED.items():
        table, dims = tables[quantity], []
        for name, nodes in zip(table.axes, table.nodes, strict=True):
            dim = name if np.array_equal(nodes, shared[name]) else f"{quantity}_{name}"
            axes[dim] = _axis(name, nodes)
            dims.append(dim)
        variables[quantity] = Variable(tuple(dims), table.values, units, words, more)
    variables["valid"] = Variable(
        PATH,
        np.asarray(path.valid, np.int8),
        "1",
        "1 where the range ends in air, 0 where it would pass through the ground",
        {"comment": "cells of 0 continue the quantities smoothly, for interpolation beside them only"},
    )
    return Group(axes, variables, {"accuracy": accuracy}, attributes)


def path_axes(grid: PathGrid) -> dict[str, Axis]:
    """The axes of the lines of sight of a grid."""
    return {name: _axis(name, getattr(grid, field)) for name, field in zip(PATH, FIELDS[: len(PATH)], strict=True)}


def _axis(name: str, nodes: np.ndarray) -> Axis:
    if name == "source_azimuth":
        return table_axis(nodes, *_READ[name], interpolation=FOLDED, period=360.0)
    return table_axis(nodes, *_READ[name], interpolation=LINEAR)
