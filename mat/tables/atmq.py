"""Layout of the ``.atmq`` and ``.lunar_atmq`` databases."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.radiometry.spherical_harmonics import HARMONICS, zonal
from skyshine.mat.tables.axes import DARK_BELOW, EXACT, FOLDED, LINEAR, table_axis
from skyshine.mat.tables.gridded import ANGLE, AXES, FIELDS, Gridded
from skyshine.schemas.hdf5 import Axis, Group, Variable

if TYPE_CHECKING:
    from skyshine.mat.quantities.ambient_harmonics import AmbientHarmonics
    from skyshine.mat.quantities.grid import PathGrid
    from skyshine.schemas.arrays import Floats

RADIANCE = "W m^-2 sr^-1"
PATH = AXES[:3]
_KEPT_BITS = 14
AMBIENT_HARMONICS, GROUND_HARMONICS = "ambient_radiance_harmonics", "ground_radiance_harmonics"
THERMAL_PATH, THERMAL_AMBIENT = "thermal_path_radiance_ratio", "thermal_ambient_radiance"
THERMAL_HARMONICS = "thermal_radiance_harmonics"
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


@dataclass(frozen=True, eq=False)
class ThermalLight:
    """The quantities of an atmospheric table without its source.

    Attributes
    ----------
    path_grid, ambient_grid : PathGrid
        Of the path radiance, and of ambient light.
    path_radiance_ratio : (R, A, E) array
        W m^-2 sr^-1.
    ambient_radiance : (R, A, E) array
        W m^-2 sr^-1.
    harmonics : (R, A, E, H) array, optional
        Of the ambient light, W m^-2 sr^-1.
    dark_below : float
        Elevation at and below which there is no light of the source [degree].
    """

    path_grid: PathGrid
    ambient_grid: PathGrid
    path_radiance_ratio: Floats
    ambient_radiance: Floats
    harmonics: Floats | None
    dark_below: float


def atmq_group(
    tables: Mapping[str, Gridded],
    accuracy: Group,
    attributes: dict[str, Any],
    harmonics: AmbientHarmonics | None = None,
    thermal: ThermalLight | None = None,
) -> Group:
    """Arrange the four quantities of a state, band and source for writing.

    Parameters
    ----------
    tables : mapping of str to Gridded
        By the names of `gridded.QUANTITIES`. Axes that differ from those of the path radiance get the quantity's name
        before their own.
    accuracy : Group
        The measured errors of the tables and of the compiled band.
    attributes : dict
        Band edges, state and source, and of the ground where there are harmonics, for the root.
    harmonics : AmbientHarmonics, optional
        For ambient light on tilted faces.
    thermal : ThermalLight, optional
        The same without the source, for elevations below the lowest of its nodes.
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
    if harmonics is not None:
        for part in (_of_light(harmonics, shared), _of_ground(harmonics, shared)):
            axes |= part.axes
            variables |= part.variables
    if thermal is not None:
        part = _without_source(thermal, shared)
        axes |= part.axes
        variables |= part.variables
        for name, axis in axes.items():
            if name.endswith("source_elevation"):
                axis.attributes[DARK_BELOW] = thermal.dark_below
    return Group(axes, variables, {"accuracy": accuracy}, attributes)


def _of_light(harmonics: AmbientHarmonics, shared: Mapping[str, np.ndarray]) -> Group:
    """Coefficients of the light around a face, which depend on the source."""
    axes = _grid_axes(AMBIENT_HARMONICS, harmonics.grid, 4, shared) | {"harmonic": _harmonic_axis(harmonics.count)}
    words = "spherical harmonics of radiance around the surface, weighted by path transmittance as in equation (20)"
    more = {"comment": "without the light that the ground emits; source elevation is the one at the surface point"}
    return Group(axes, {AMBIENT_HARMONICS: Variable(tuple(axes), _rounded(harmonics.radiance), RADIANCE, words, more)})


def _of_ground(harmonics: AmbientHarmonics, shared: Mapping[str, np.ndarray]) -> Group:
    """Coefficients of the light that the ground emits, per unit of it."""
    from skyshine.mat.quantities.ambient_harmonics import GROUND_TEMPERATURES

    axes = _grid_axes(GROUND_HARMONICS, harmonics.grid, 3, shared) | {
        "ground_temperature": table_axis(np.array(GROUND_TEMPERATURES), "K", "temperature of the ground"),
        "zonal_harmonic": table_axis(
            np.array(zonal(harmonics.count), np.int32),
            "1",
            "spherical harmonic without azimuth, 10 l",
            interpolation=EXACT,
        ),
    }
    words = "spherical harmonics of the ground's emission around the surface, over the radiance that it emits"
    more = {"comment": "weighted by path transmittance as ambient_radiance_harmonics, to which its product is added"}
    return Group(axes, {GROUND_HARMONICS: Variable(tuple(axes), _rounded(harmonics.ground), "1", words, more)})


def _without_source(thermal: ThermalLight, shared: Mapping[str, np.ndarray]) -> Group:
    """What the air emits, without any light of the source."""
    axes: dict[str, Axis] = {}
    variables: dict[str, Variable] = {}

    def add(name: str, grid: PathGrid, values: np.ndarray, like: str, harmonic: dict[str, Axis]) -> None:
        own = _grid_axes(name, grid, 3, shared) | harmonic
        axes.update(own)
        variables[name] = Variable(tuple(own), values, RADIANCE, f"{like} without light of the source")

    add(THERMAL_PATH, thermal.path_grid, thermal.path_radiance_ratio, "path_radiance_ratio", {})
    add(THERMAL_AMBIENT, thermal.ambient_grid, thermal.ambient_radiance, "ambient_radiance", {})
    if thermal.harmonics is not None:
        add(
            THERMAL_HARMONICS,
            thermal.ambient_grid,
            _rounded(thermal.harmonics),
            AMBIENT_HARMONICS,
            {"harmonic": _harmonic_axis(thermal.harmonics.shape[-1])},
        )
    return Group(axes, variables)


def _harmonic_axis(count: int) -> Axis:
    return table_axis(
        np.array(HARMONICS[:count], np.int32),
        "1",
        "spherical harmonic, 10 l + m, in cos(m azimuth from the source)",
        interpolation=EXACT,
    )


def _rounded(coefficients: np.ndarray) -> np.ndarray:
    """Coefficients (..., H) rounded to 2^-14 of the power of two below the first, some 3e-5 of it.

    Terms that are 0 but for rounding errors, and bits far below the error of the table, do not compress.
    """
    _, exponent = np.frexp(coefficients[..., :1])
    step = np.ldexp(1.0, exponent - 1 - _KEPT_BITS)
    rounded: np.ndarray = np.round(coefficients / step) * step
    return rounded


def _grid_axes(quantity: str, grid: PathGrid, count: int, shared: Mapping[str, np.ndarray]) -> dict[str, Axis]:
    """The first axes of a grid, with the quantity's name before those that differ from the shared ones."""
    nodes = {name: getattr(grid, field) for name, field in zip(AXES[:count], FIELDS[:count], strict=True)}
    return {
        name if np.array_equal(values, shared[name]) else f"{quantity}_{name}": _axis(name, values)
        for name, values in nodes.items()
    }


def path_axes(grid: PathGrid) -> dict[str, Axis]:
    """The axes of the lines of sight of a grid."""
    return {name: _axis(name, getattr(grid, field)) for name, field in zip(PATH, FIELDS[: len(PATH)], strict=True)}


def _axis(name: str, nodes: np.ndarray) -> Axis:
    if name == "source_azimuth":
        return table_axis(nodes, *_READ[name], interpolation=FOLDED, period=360.0)
    return table_axis(nodes, *_READ[name], interpolation=LINEAR)
