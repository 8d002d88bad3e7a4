"""Results as `xarray.Dataset`, for users who have xarray."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    import xarray

Column = tuple[str, Any]  # units, values


def dataset(
    coordinates: Mapping[str, Column],
    variables: Mapping[str, tuple[Sequence[str], str, Any]],
    attributes: Mapping[str, Any],
) -> xarray.Dataset:
    """Arrange arrays as a dataset.

    Parameters
    ----------
    coordinates : dict of str to (units, (n,) values)
        Units and values of each dimension.
    variables : dict of str to (dimensions, units, values)
    attributes : dict
        Attributes of the whole dataset.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    try:
        import xarray
    except ModuleNotFoundError:
        raise InputError('needs xarray; run: pip install "skyshine[xarray]"') from None
    return xarray.Dataset(
        {name: (tuple(dims), values, {"units": units}) for name, (dims, units, values) in variables.items()},
        {name: (name, values, {"units": units}) for name, (units, values) in coordinates.items()},
        dict(attributes),
    )
