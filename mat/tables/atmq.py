"""The four quantities on a job's own five axes: the group ``grid`` of ``.atmq`` and ``.lunar_atmq`` files.

They are evaluated from the channels of the same file at their nodes. A runtime that reads axes interpolates between
them, with the error that ``grid/accuracy`` states.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from skyshine.mat.tables.axes import FOLDED, LINEAR, table_axis
from skyshine.mat.tables.gridded import AXES, FIELDS, QUANTITIES, Gridded
from skyshine.mat.tables.table import Table
from skyshine.schemas.hdf5 import Axis, Group, Variable

if TYPE_CHECKING:
    from skyshine.mat.quantities.grid import PathGrid

GRID = "grid"  # the group
RADIANCE = "W m^-2 sr^-1"
PATH = AXES[:3]
VALID = "valid"
AMBIENT_HARMONICS, GROUND_HARMONICS = "ambient_radiance_harmonics", "ground_radiance_harmonics"
DESCRIBED = {
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
GRID_AXES = {
    "range": ("km", "line-of-sight range from the observer to the surface point"),
    "altitude": ("km", "observer altitude above sea level"),
    "elevation": ("degree", "line-of-sight elevation at the observer"),
    "source_elevation": ("degree", "geometric elevation of the source"),
    "source_azimuth": ("degree", "azimuth of the source relative to the line of sight"),
}


class GridTable(Table):
    """The tables on five axes of an ``.atmq`` or ``.lunar_atmq`` database, read by linear interpolation.

    Opened by ``skyshine.mat.open(path, grid=True)``. Between the nodes it errs by what the group ``grid/accuracy`` of
    the file states; `AtmosphereTable` reads the channels of the same file, which err far less.

    Examples
    --------
    >>> import skyshine.mat
    >>> job = {
    ...     "skyshine": 1,
    ...     "name": "axes",
    ...     "site": {"latitude_deg": 45, "longitude_deg": 7, "date": "2026-06-21", "utc_offset_h": 1},
    ...     "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [14, 27]}}],
    ...     "bands": [{"wavelength_um": [10.0, 10.2]}],
    ...     "sources": ["sun"],
    ...     "materials": ["asphalt_road"],
    ...     "atmosphere_grid": {
    ...         "tolerance": "5 K",
    ...         "range_km": [0.1, 1, 5],
    ...         "altitude_km": [0.1, 1],
    ...         "elevation_deg": [-90, -30, 0],
    ...         "source_elevation_deg": [0, 60],
    ...         "source_azimuth_deg": [0, 180],
    ...     },
    ...     "surface_grid": {"altitude_km": [0], "azimuth_deg": [180], "slope_deg": [0]},
    ...     "output": {"pictures": False},
    ... }
    >>> built = skyshine.mat.build(job, out="axes", jobs=1)
    >>> tables = skyshine.mat.open("axes/s01b01.atmq.h5", grid=True)
    >>> line = {"range": 1.0, "altitude": 1.0, "elevation": -30.0}
    >>> bool(tables.value("beta_star", **line) > 0)
    True
    """


# From space the source is higher or lower at the entry of a line into the air than at its observer. Beyond the ends of
# the channels they are read at them: so are they where their tolerance is tested, and the file states the error.
_CLAMPED = "source_elevation"


def tables_on_axes(air: Table, grid: PathGrid) -> dict[str, Gridded]:
    """The four quantities at the nodes of five axes, evaluated from the channels.

    Parameters
    ----------
    air : AtmosphereTable
        Its channels.
    grid : PathGrid
        Axes of (R, A, E, SE, SA) nodes within those that the file is for.

    Returns
    -------
    dict of str to Gridded
        By the names of `gridded.QUANTITIES`; ranges that would pass through the ground continue as in the channels.
    """
    sparse = np.meshgrid(*(getattr(grid, field) for field in FIELDS), indexing="ij", sparse=True)
    nodes = dict(zip(AXES, sparse, strict=True))
    parts: dict[str, list[np.ndarray]] = {name: [] for name in (VALID, *QUANTITIES)}
    light = air.clamped(_CLAMPED)
    for altitude in grid.altitude_km:  # one at a time, for all channels of all nodes would take much memory
        coordinates = nodes | {"altitude": np.full((1,) * len(AXES), altitude)}
        for name, values in parts.items():
            count = QUANTITIES.get(name, ("", len(PATH)))[1]
            behind = (slice(None),) * count + (0,) * (len(AXES) - count)
            values.append(light.value(name, **{axis: coordinates[axis][behind] for axis in AXES[:count]}))
    arrays = {name: np.concatenate(values, axis=1) for name, values in parts.items()}
    arrays["beta_star"] = _falling(arrays["beta_star"], grid.range_km)
    arrays = {name: values.astype(np.float32) for name, values in arrays.items()}
    valid = arrays.pop(VALID) > 0
    return {name: Gridded(grid, values, valid) for name, values in arrays.items()}


def _falling(beta_star: np.ndarray, range_km: np.ndarray) -> np.ndarray:
    """beta* (R, A, E) of a transmittance that never rises with range; channels let it within their error."""
    reach = range_km[:, None, None]
    depth = np.maximum.accumulate(reach / beta_star, axis=0)
    return np.where(reach > 0, np.minimum(beta_star, reach / np.where(depth > 0, depth, 1.0)), beta_star)


def grid_group(tables: Mapping[str, Gridded], accuracy: Group) -> Group:
    """Arrange the four quantities for writing.

    Parameters
    ----------
    tables : mapping of str to Gridded
        Tables by the names of `gridded.QUANTITIES`, on the same axes.
    accuracy : Group
        The measured errors of interpolation between their nodes.
    """
    path = tables["path_radiance_ratio"]
    axes = {name: _axis(name, nodes) for name, nodes in zip(path.axes, path.nodes, strict=True)}
    variables = {
        name: Variable(tables[name].axes, tables[name].values, units, words, more)
        for name, (units, words, more) in DESCRIBED.items()
    }
    variables[VALID] = Variable(
        PATH,
        np.asarray(path.valid, np.int8),
        "1",
        "1 where the range ends in air, 0 where it would pass through the ground",
        {"comment": "cells of 0 continue the quantities smoothly, for interpolation beside them only"},
    )
    return Group(axes, variables, {"accuracy": accuracy}, {})


def _axis(name: str, nodes: np.ndarray) -> Axis:
    if name == "source_azimuth":
        return table_axis(nodes, *GRID_AXES[name], interpolation=FOLDED, period=360.0)
    return table_axis(nodes, *GRID_AXES[name], interpolation=LINEAR)
