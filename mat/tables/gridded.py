"""A quantity of the atmospheric tables on axes of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.tables.axes import AxisRule
from skyshine.mat.tables.interpolation import interpolate

if TYPE_CHECKING:
    from skyshine.mat.quantities.grid import PathGrid
    from skyshine.mat.quantities.results import AtmosphericQuantities

AXES = ("range", "altitude", "elevation", "source_elevation", "source_azimuth")
FIELDS = ("range_km", "altitude_km", "elevation_deg", "source_elevation_deg", "source_azimuth_deg")
ANGLE = "scattering_angle"  # stands in place of the azimuth
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
    grid : PathGrid
    values : array
        On as many axes of the grid as the quantity has, in their order.
    valid : (R, A, E) bool array
        As in `AtmosphericQuantities`.
    """

    grid: PathGrid
    values: np.ndarray
    valid: np.ndarray

    @classmethod
    def all_of(cls, quantities: AtmosphericQuantities, grid: PathGrid) -> dict[str, Gridded]:
        """The quantities of one grid by their names in the files; those that were not computed are left out."""
        arrays = {name: getattr(quantities, key) for name, (key, _) in QUANTITIES.items()}
        return {name: cls(grid, values, quantities.valid) for name, values in arrays.items() if values is not None}

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes of `values`."""
        names = (*AXES[:4], ANGLE) if self.grid.by_scattering_angle else AXES
        return names[: self.values.ndim]

    @property
    def nodes(self) -> list[np.ndarray]:
        """Those of each axis of `values`."""
        return [getattr(self.grid, field) for field in FIELDS][: self.values.ndim]

    def located(self, places: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Places by the names of `AXES`, as coordinates on the axes of `values`."""
        coordinates = {name: places[name] for name in self.axes if name != ANGLE}
        if ANGLE in self.axes:
            coordinates[ANGLE] = scattering_angle(
                places["elevation"], places["source_elevation"], places["source_azimuth"]
            )
        return coordinates

    def read(self, places: dict[str, np.ndarray]) -> np.ndarray:
        """Interpolated values at places by the names of `AXES`, broadcast against each other."""
        return self.read_at(self.values, self.located(places))

    def read_at(self, values: np.ndarray, located: dict[str, np.ndarray]) -> np.ndarray:
        """Interpolated values of an array on these axes, at coordinates on them."""
        rules = [AxisRule(name, nodes) for name, nodes in zip(self.axes, self.nodes, strict=True)]
        return interpolate(values, rules, located)
