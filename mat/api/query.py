"""Values of a database between its nodes, with the error that the file states."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.tables.dataset import Column, dataset
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.result import Panel, Result
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class Query(Result):
    """Values of a quantity with their stated error.

    Attributes
    ----------
    quantity, units : str
    value : array
        Shape of the axes' values, broadcast against each other.
    error : dict of str to float
        Errors of interpolation that the file states for the quantity: rms, 99 % and maximum, in its units, in K
        (``..._kelvin``) or in percent (``..._percent``), and the number of points that were compared (``points``).
    coordinates : dict of str to (units, value)
        Value or values of each axis, and its units.
    """

    quantity: str
    units: str
    value: Floats
    error: dict[str, float]
    coordinates: dict[str, Column]

    def to_xarray(self) -> xarray.Dataset:
        """The values as an `xarray.Dataset`: over the axis of which several values were asked, else over points."""
        shape = np.shape(self.value)
        several = {name: column for name, column in self.coordinates.items() if np.ndim(column[1])}
        dims = tuple(several) if len(several) == 1 else tuple(f"point_{number}" for number in range(len(shape)))
        axes = several if dims == tuple(several) else {}
        others = {
            name: (dims if np.ndim(at) else (), units, np.broadcast_to(at, shape) if np.ndim(at) else at)
            for name, (units, at) in self.coordinates.items()
            if name not in axes
        }
        return dataset(axes, {self.quantity: (dims, self.units, self.value), **others}, self.error)

    def _panels(self) -> list[Panel]:
        several = [(name, units, at) for name, (units, at) in self.coordinates.items() if np.ndim(at)]
        if len(several) != 1 or isinstance(several[0][2][0], str):
            raise InputError(f"found several values of {len(several)} axes; allowed: numbers of one axis")
        ((name, units, at),) = several
        return [Panel(at, f"{name}, {units}", f"{self.quantity}, {self.units}", {self.quantity: self.value})]

    def __repr__(self) -> str:
        low, high = float(np.min(self.value)), float(np.max(self.value))
        values = f"{low:.6g}" if np.ndim(self.value) == 0 else f"{np.size(self.value)} values, {low:.6g} to {high:.6g}"
        units = {"p99_kelvin": "K", "p99": self.units}
        p99 = next((f", 99 % within {self.error[key]:.2g} {units[key]}" for key in units if key in self.error), "")
        return f"<Query {self.quantity}: {values} {self.units}{p99}>"


def query(file: str | os.PathLike[str], quantity: str, *, clamp: bool = False, **coordinates: Any) -> Query:
    """Interpolate a quantity of a database, as `mat query` does.

    Parameters
    ----------
    file : path
        A database of `mat build`.
    quantity : str
        Name of a table in it.
    clamp : bool
        Whether values outside an axis are read at its nearest end.
    **coordinates : array_like or str
        A value for each axis of the quantity, in its units, as ``range=2.0``; a material by name or code.

    Raises
    ------
    InputError
        The file cannot be read, the quantity or an axis is not in it, or a value lies outside an axis.

    Examples
    --------
    >>> import skyshine.mat
    >>> answer = skyshine.mat.query(
    ...     "demo/built/s01.htt.h5",
    ...     "temperature",
    ...     material="asphalt_road",
    ...     altitude=2.1,
    ...     azimuth=180,
    ...     slope=0,
    ...     time=[6, 14.5],
    ... )  # doctest: +SKIP
    >>> answer.value, answer.error["p99_kelvin"]  # doctest: +SKIP
    """
    table = open_table(file)
    value = (table.clamped() if clamp else table).value(quantity, **coordinates)
    axes = table.root.axes
    columns = {name: (axes[name].units if name in axes else "1", at) for name, at in coordinates.items()}
    return Query(quantity, table.units(quantity), value, table.error(quantity), columns)
