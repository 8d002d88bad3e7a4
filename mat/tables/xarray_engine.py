"""The engine ``skyshine`` of xarray: databases with their materials by name.

``xarray.open_dataset("built/s01.htt.h5", engine="skyshine").sel(material="asphalt_road")``
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import xarray
from xarray.backends import BackendEntrypoint

from skyshine.mat.tables.loader import open_table


class SkyshineEngine(BackendEntrypoint):
    """Opens databases of the table builder and their flat exports; named as an entry point of the package."""

    description = "Databases of skyshine, with materials by name"

    def open_dataset(
        self, filename_or_obj: Any, *, drop_variables: str | Iterable[str] | None = None
    ) -> xarray.Dataset:
        """A database as `Table.to_xarray` gives it.

        Parameters
        ----------
        drop_variables : str or iterable of str, optional
            Arrays to leave out.

        Raises
        ------
        InputError
            The file is missing, damaged or of another type.
        """
        dropped = [drop_variables] if isinstance(drop_variables, str) else list(drop_variables or ())
        return open_table(filename_or_obj).to_xarray().drop_vars(dropped, errors="ignore")
