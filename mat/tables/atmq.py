"""Layout of the ``.atmq`` and ``.lunar_atmq`` databases."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from skyshine.mat.tables.axes import FOLDED, table_axis
from skyshine.schemas.hdf5 import Group, Variable

if TYPE_CHECKING:
    from skyshine.mat.quantities import AtmosphericQuantities, PathGrid

RADIANCE = "W m^-2 sr^-1"
PATH = ("range", "altitude", "elevation")


def atmq_group(quantities: AtmosphericQuantities, grid: PathGrid, accuracy: Group, attributes: dict) -> Group:
    """Arrange the four quantities of a state, band and source for writing.

    Parameters
    ----------
    quantities : AtmosphericQuantities
        beta_star (R, A, E), path_radiance_ratio (R, A, E, SE, SA), ambient and direct (R, A, E, SE), valid (R, A, E).
    grid : PathGrid
    accuracy : Group
        The measured errors of the tables and of the compiled band.
    attributes : dict
        Band edges, state and source, for the root.
    """
    source = (*PATH, "source_elevation")
    variables = {
        "beta_star": Variable(
            PATH, quantities.beta_star, "km", "beta* = -5.5 r / ln(transmittance), equation (8)"
        ),
        "path_radiance_ratio": Variable(
            (*source, "source_azimuth"),
            quantities.path_radiance_ratio,
            RADIANCE,
            "path radiance over (1 - transmittance), equations (10) and (11)",
            {"comment": "source angles are those at the observer"},
        ),
        "ambient_radiance": Variable(
            source,
            quantities.ambient,
            RADIANCE,
            "sky irradiance over pi, weighted by path transmittance, equation (20)",
            {"comment": "source elevation is the one at the surface point"},
        ),
        "direct_radiance": Variable(
            source,
            quantities.direct,
            RADIANCE,
            "direct source irradiance over pi, weighted by path transmittance, equation (36)",
            {"comment": "source elevation is the one at the surface point; normal to the beam"},
        ),
        "valid": Variable(
            PATH,
            np.asarray(quantities.valid, np.int8),
            "1",
            "1 where the range ends in air, 0 where it would pass through the ground",
            {"comment": "cells of 0 continue the quantities smoothly, for interpolation beside them only"},
        ),
    }
    return Group(path_axes(grid) | _source_axes(grid), variables, {"accuracy": accuracy}, attributes)


def path_axes(grid: PathGrid) -> dict:
    """The axes of lines of sight."""
    return {
        "range": table_axis(grid.range_km, "km", "line-of-sight range from the observer to the surface point"),
        "altitude": table_axis(grid.altitude_km, "km", "observer altitude above sea level"),
        "elevation": table_axis(grid.elevation_deg, "degree", "line-of-sight elevation at the observer"),
    }


def _source_axes(grid: PathGrid) -> dict:
    return {
        "source_elevation": table_axis(grid.source_elevation_deg, "degree", "geometric elevation of the source"),
        "source_azimuth": table_axis(
            grid.source_azimuth_deg,
            "degree",
            "azimuth of the source relative to the line of sight",
            interpolation=FOLDED,
            period=360.0,
        ),
    }
