"""The names of materials as a coordinate of the arrays on a material axis, as netCDF readers find it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from skyshine.schemas.hdf5 import Variable

AXIS, NAMES = "material", "material_name"
COORDINATES = "coordinates"  # CF conventions 1.11, section 5: auxiliary coordinates of an array


def with_names(variables: Mapping[str, Variable]) -> dict[str, Variable]:
    """The variables of a group, those on the material axis with the names of the materials as a coordinate."""
    return {
        name: replace(variable, attributes=variable.attributes | {COORDINATES: NAMES})
        if needs_names(name, variable.dims)
        else variable
        for name, variable in variables.items()
    }


def needs_names(name: str, dims: tuple[str, ...]) -> bool:
    """Whether an array of a group with `NAMES` has them as a coordinate."""
    return name != NAMES and AXIS in dims
