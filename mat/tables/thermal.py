"""Layout of the ``.thermal_atmq`` database: transmittance of what classes of material emit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.tables.atmq import PATH, path_axes
from skyshine.mat.tables.axes import EXACT, table_axis
from skyshine.mat.tables.band import PLANCK_TEMPERATURES
from skyshine.mat.tables.named_materials import with_names
from skyshine.schemas.hdf5 import Group, Variable

if TYPE_CHECKING:
    from skyshine.mat.quantities.emission import EmissionClasses
    from skyshine.mat.quantities.grid import PathGrid
    from skyshine.materials.library import Material

QUANTITY = "beta_star_thermal"


def thermal_group(
    beta_star: np.ndarray,
    valid: np.ndarray,
    grid: PathGrid,
    materials: Sequence[Material],
    classes: EmissionClasses,
    accuracy: Group,
    attributes: dict[str, Any],
) -> Group:
    """Arrange the weighted transmittance of a state and a band for writing.

    Parameters
    ----------
    beta_star : (C, T, R, A, E) array
        km, at `band.PLANCK_TEMPERATURES`.
    valid : (R, A, E) bool array
    grid : PathGrid
    materials : (M,) sequence of Material
        Codes ascending.
    classes : EmissionClasses
        Of the materials.
    accuracy : Group
    attributes : dict
        Band edges and state, for the root.
    """
    axes = {
        "material_class": table_axis(
            np.arange(1, classes.count + 1, dtype=np.int32),
            "1",
            "class of materials, see class_of_material",
            interpolation=EXACT,
        ),
        "planck_temperature": table_axis(PLANCK_TEMPERATURES, "K", "temperature of the surface that emits"),
        **path_axes(grid),
        "material": table_axis(
            np.array([m.code for m in materials], np.int32), "1", "material code", interpolation=EXACT
        ),
    }
    variables = {
        QUANTITY: Variable(
            ("material_class", "planck_temperature", *PATH),
            beta_star,
            "km",
            "beta* of the light that a class of materials emits, in place of beta* in equation (6)",
            {"comment": "goes with 1 - reflectance_planck of the .band file: together they are the integral (5)"},
        ),
        "class_of_material": Variable(("material",), classes.number.astype(np.int32), "1", "class of each material"),
        "class_difference": Variable(
            ("material",),
            classes.difference,
            "1",
            "largest difference of a material's own transmittance from its class's",
        ),
        "material_name": Variable(("material",), np.array([m.name for m in materials], object), "1", "material name"),
        "valid": Variable(
            PATH,
            np.asarray(valid, np.int8),
            "1",
            "1 where the range ends in air, 0 where it would pass through the ground",
            {
                "comment": (
                    "cells of 0 continue beta* through the air above the ground, for interpolation beside them only"
                )
            },
        ),
    }
    return Group(axes, with_names(variables), {"accuracy": accuracy}, attributes)
