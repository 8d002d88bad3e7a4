"""A quantity of the atmospheric tables on axes of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skyshine.mat.tables.axes import AxisRule
from skyshine.mat.tables.interpolation import interpolate

if TYPE_CHECKING:
    from skyshine.mat.quantities.grid import PathGrid

AXES = ("range", "altitude", "elevation", "source_elevation", "source_azimuth")
FIELDS = ("range_km", "altitude_km", "elevation_deg", "source_elevation_deg", "source_azimuth_deg")
ANGLE = "scattering_angle"  # may replace the azimuth when path radiance is read
# Names in the files and in `AtmosphericQuantities`, and how many of the axes each has.
QUANTITIES = {
    "beta_star": ("beta_star", 3),
    "path_radiance_ratio": ("path_radiance_ratio", 5),
    "ambient_radiance": ("ambient", 4),
    "direct_radiance": ("direct", 4),
}


@dataclass(frozen=True, eq=False)
class Gridded:
    """One quantity on a grid.

    Attributes
    ----------
    values : array
        Values on as many axes of the grid as the quantity has, in their order.
    valid : (R, A, E) bool array
        Validity of the paths, as in `AtmosphericQuantities`.
    """

    grid: PathGrid
    values: np.ndarray
    valid: np.ndarray

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes of `values`."""
        return AXES[: self.values.ndim]

    @property
    def nodes(self) -> list[np.ndarray]:
        """Nodes of each axis of `values`."""
        return [getattr(self.grid, field) for field in FIELDS][: self.values.ndim]

    def read(self, coordinates: dict[str, np.ndarray]) -> np.ndarray:
        """Interpolated values at places by the names of `AXES`, broadcast against each other.

        Coordinates beyond an axis take its end: observers in space are moved to the top of the air when errors are
        measured.
        """
        axes = list(zip(self.axes, self.nodes, strict=True))
        inside = {name: np.clip(coordinates[name], nodes[0], nodes[-1]) for name, nodes in axes}
        return interpolate(self.values, [AxisRule(name, nodes) for name, nodes in axes], inside)
