"""Layout of the ``.htt`` database."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.tables.axes import EXACT, LINEAR, PERIODIC, table_axis
from skyshine.mat.tables.named_materials import with_names
from skyshine.schemas.hdf5 import Group, Variable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from skyshine.mat.surface.table import SurfaceTemperatures

COLUMN = ("material", "altitude", "azimuth", "slope")


def htt_group(
    table: SurfaceTemperatures,
    codes: Sequence[int],
    names: Sequence[str],
    axes: dict[str, Any],
    accuracy: Group,
    attributes: dict[str, Any],
    *,
    whole_day: bool = True,
) -> Group:
    """Arrange the temperatures of a state for writing.

    Parameters
    ----------
    table : SurfaceTemperatures
        temperature (M, A, Z, S, T) and one diagnostic of each column (M, A, Z, S).
    codes, names : (M,)
        Of the materials, codes ascending.
    axes : dict
        altitude_km, azimuth_deg, slope_deg, time_h.
    accuracy : Group
    attributes : dict
        State, site and weather, for the root.
    whole_day : bool
        The times close to a day; otherwise they are a part of it, from 0 on and beyond 24 after midnight.
    """
    column_axes = {
        "material": table_axis(np.asarray(codes, np.int32), "1", "material code", interpolation=EXACT),
        "altitude": table_axis(axes["altitude_km"], "km", "surface altitude above sea level"),
        "azimuth": table_axis(
            axes["azimuth_deg"],
            "degree",
            "azimuth that the surface faces, from north eastward",
            interpolation=PERIODIC,
            period=360.0,
        ),
        "slope": table_axis(axes["slope_deg"], "degree", "slope of the surface; 0 faces up, 90 is a wall"),
    }
    all_axes = column_axes | {
        "time": table_axis(
            axes["time_h"], "h", "local clock time of day", interpolation=PERIODIC if whole_day else LINEAR, period=24.0
        )
    }
    variables = {
        "temperature": Variable((*COLUMN, "time"), table.temperature, "K", "surface temperature"),
        "material_name": Variable(("material",), np.asarray(names, object), "1", "material name"),
    }
    diagnostics = {
        "residual": Variable(COLUMN, table.residual, "W m^-2", "largest residual of the surface heat balance"),
        "energy_closure": Variable(
            COLUMN, table.energy_closure, "W m^-2", "daily mean of the heat that does not close"
        ),
        "bound_excess": Variable(COLUMN, table.bound_excess, "K", "how far a temperature leaves its physical bounds"),
        "method": Variable(COLUMN, table.method, "1", "method that solved the column", {"comment": table.method_names}),
        "iterations": Variable(COLUMN, table.iterations, "1", "iterations of the solver"),
    }
    groups = {"diagnostics": Group(column_axes, diagnostics), "accuracy": accuracy}
    return Group(all_axes, with_names(variables), groups, attributes)
