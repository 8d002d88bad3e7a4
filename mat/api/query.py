"""Values of a database between its nodes, with the error that the file states."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from skyshine.mat.tables.loader import open_table
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class Query:
    """Values of a quantity with their stated error.

    Attributes
    ----------
    quantity, units : str
    value : array
        Shape of the axes' values, broadcast against each other.
    error : dict of str to float
        Errors of interpolation that the file states for the quantity: rms, 99 % and maximum, in its units, in K
        (``..._kelvin``) or in percent (``..._percent``), and the number of points that were compared (``points``).
    """

    quantity: str
    units: str
    value: Floats
    error: dict[str, float]


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
    return Query(quantity, table.units(quantity), value, table.error(quantity))
