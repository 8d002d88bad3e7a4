"""Tables with fewer nodes, cut from finer ones: the error of a coarser setting without its build."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.quantities.channels.coordinates import LEVEL
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.hdf5 import Group, Variable

_AIR = ("share", "height_root", "source_elevation", "scattering_angle")  # axes of an atmosphere, beside `direction`
_PLANE = ("altitude", "slope")  # axes of temperatures, beside the periodic ones
_PERIODIC = ("azimuth", "time")
_FEWEST = 4  # nodes around a periodic axis
_GROUND_OF_FACES = ("ground_emission", "ground_temperature")  # array and axis that files with harmonics have
_LEAST_PART = 3  # nodes of a part of the directions


def thinned(tables: Tables, air: float, surface: float) -> Tables:
    """Tables whose intervals are so many times as long, on every axis on which a job's tolerance places nodes.

    Parameters
    ----------
    air, surface : float
        Factors of the atmosphere's axes and of those of the temperatures, at least 1.
    """
    air_axes = {name: _spread(values.size, air) for name, values in _axes(tables.air.root, _AIR).items()}
    directions = np.asarray(tables.air.root.axes["direction"].values, float)
    air_axes["direction"] = _thinned_directions(directions, air)
    surface_root = tables.surface.root
    surface_axes = {name: _spread(values.size, surface) for name, values in _axes(surface_root, _PLANE).items()}
    for name, values in _axes(surface_root, _PERIODIC).items():
        count = max(_FEWEST, round(values.size / surface))
        surface_axes[name] = np.unique(np.linspace(0, values.size, count, endpoint=False).astype(int))
    return replace(
        tables,
        air=replace(tables.air, root=_cut(tables.air.root, air_axes)),
        surface=replace(tables.surface, root=_cut(surface_root, surface_axes)),
    )


def without_harmonics(tables: Tables) -> Tables:
    """Tables whose faces have the ambient light of level ones."""
    root = tables.air.root

    def of_all_faces(name: str) -> bool:
        return "harmonic" not in name and name not in _GROUND_OF_FACES

    axes = {name: axis for name, axis in root.axes.items() if of_all_faces(name)}
    variables = {name: variable for name, variable in root.variables.items() if of_all_faces(name)}
    air = replace(tables.air, root=Group(axes, variables, root.groups, root.attributes))
    return replace(tables, air=air)


def without_response(tables: Tables) -> Tables:
    """Tables whose temperatures are those in the open: no response to shade and walls."""
    root = tables.surface.root
    variables = {name: variable for name, variable in root.variables.items() if not name.startswith("response_")}
    return replace(tables, surface=replace(tables.surface, root=replace(root, variables=variables)))


def value_counts(tables: Tables) -> tuple[int, int]:
    """Numbers of values of the atmosphere and of the temperatures, by which the times of their builds go."""
    air = sum(int(np.prod(np.shape(variable.data))) for variable in tables.air.root.variables.values())
    return air, int(np.prod(np.shape(tables.surface.root.variables["temperature"].data)))


def _axes(root: Group, names: tuple[str, ...]) -> dict[str, Floats]:
    return {name: np.asarray(root.axes[name].values, float) for name in names if name in root.axes}


def _spread(count: int, factor: float) -> Integers:
    """Indices of the nodes that remain of so many: both ends, and others evenly between."""
    intervals = max(1, round((count - 1) / factor)) if count > 1 else 0
    return np.unique(np.linspace(0, count - 1, intervals + 1).round().astype(int))


def _thinned_directions(directions: Floats, factor: float) -> Integers:
    """The same of directions, whose three parts keep their ends: into the ground, past a lowest point, upwards."""
    ground, upward = directions <= 1.0, directions >= LEVEL
    limb = ~ground & (directions <= LEVEL)
    remaining = []
    for part in (ground, limb, upward):
        index = np.flatnonzero(part)
        least = (index.size - 1) / (_LEAST_PART - 1)
        remaining.append(index[_spread(index.size, min(factor, max(least, 1.0)))])
    return np.unique(np.concatenate(remaining))


def _cut(root: Group, remaining: Mapping[str, Integers]) -> Group:
    """A group with some of the nodes of its axes."""

    def cut(variable: Variable) -> Variable:
        data = np.asarray(variable.data)
        for axis in remaining.keys() & set(variable.dims):
            data = np.take(data, remaining[axis], axis=variable.dims.index(axis))
        return Variable(variable.dims, data, variable.units, variable.long_name, variable.attributes)

    axes = {
        name: replace(axis, values=np.asarray(axis.values)[remaining[name]]) if name in remaining else axis
        for name, axis in root.axes.items()
    }
    return Group(axes, {name: cut(variable) for name, variable in root.variables.items()}, root.groups, root.attributes)
