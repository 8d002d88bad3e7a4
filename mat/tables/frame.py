"""The part of a table that one frame of a runtime reads.

Observer and source stand still in a frame: read there once, a table of five axes is one of range, elevation and
azimuth, of which a frame spans few nodes. Linear interpolation in one axis after the other is interpolation in all of
them, so nothing is lost: what the pixels of a frame were extrapolated to from its centre, they interpolate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from skyshine.mat.tables.axes import EXACT, FOLDED, PERIODIC, AxisRule
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Variable


def part_of(root: Group, rules: Mapping[str, Sequence[AxisRule]], places: Mapping[str, Mapping[str, object]]) -> Group:
    """Quantities read at single values of some axes and cut to pairs of values of others.

    Parameters
    ----------
    root : Group
    rules : mapping of quantity to its axes' rules
    places : mapping of quantity to a mapping of its axes to a number or a pair

    Returns
    -------
    Group
        The quantities, float64, and what else has none of those axes; with the attributes and errors of the whole.

    Raises
    ------
    InputError
        A value outside its axis, or a pair on an axis that repeats.
    """
    axes, variables = dict(root.axes), {}
    moved = {axis for where in places.values() for axis in where}
    for name, variable in root.variables.items():
        if name in rules:
            data, dims = np.asarray(variable.data, dtype=float), list(variable.dims)
            for rule, dim in zip(rules[name], variable.dims, strict=True):
                if rule.name not in places[name]:
                    continue
                place, wanted = dims.index(dim), np.asarray(places[name][rule.name])
                if wanted.ndim == 0:
                    lower, upper, weight = rule.locate(wanted)
                    data = data.take(lower, place) * (1.0 - weight) + data.take(upper, place) * weight
                    del dims[place]
                else:
                    kept = _around(rule, wanted)
                    data = data[(slice(None),) * place + (kept,)]
                    whole = root.axes[dim]
                    axes[dim] = Axis(np.asarray(whole.values)[kept], whole.units, whole.long_name, whole.attributes)
            variables[name] = Variable(tuple(dims), data, variable.units, variable.long_name, variable.attributes)
        elif not set(variable.dims) & moved:
            variables[name] = variable
    used = {dim for variable in variables.values() for dim in variable.dims}
    return Group({name: axis for name, axis in axes.items() if name in used}, variables, root.groups, root.attributes)


def _around(rule: AxisRule, wanted: np.ndarray) -> slice:
    """The nodes from the one below the lesser value to the one above the greater."""
    if rule.interpolation in (PERIODIC, FOLDED, EXACT) or rule.period > 0:
        raise InputError(
            f"{rule.name}: found a pair; allowed: one value, or leave the axis whole; it is read by"
            f" '{rule.interpolation}'"
        )
    if wanted.shape != (2,) or not wanted[0] <= wanted[1]:
        raise InputError(f"{rule.name}: found {wanted.tolist()}; allowed: a number, or the least and the most")
    lower, upper, _ = rule.locate(wanted)
    return slice(int(lower[0]), int(upper[1]) + 1)
