"""Opens databases of the table builder, each as the table of its type.

Arrays are read from their file at their first use (a flat export stays on disk, memory-mapped).
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import GRID, GridTable
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.channel_laws import broken_channel_laws
from skyshine.mat.tables.files import BAND, FORMATS
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.laws import broken_rules_of_axes, broken_spectrum_laws
from skyshine.mat.tables.limits import refuse_values
from skyshine.mat.tables.raw import ENDING, read_raw
from skyshine.mat.tables.stored_layout import refuse_layout
from skyshine.mat.tables.table import Table
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import Group, read_file, unread
from skyshine.schemas.hdf5_gate import settled_stamp
from skyshine.schemas.paths import StrPath

TableType = TypeVar("TableType", bound=Table)
_KINDS: tuple[type[Table], ...] = (TemperatureTable, BandTable, AtmosphereTable)


def open_table(path: StrPath, *, grid: bool = False) -> Table:
    """Open any database of the table builder, or the header of its flat export.

    Parameters
    ----------
    path : path
    grid : bool
        Whether the tables of an atmosphere on the five axes of its job are read in place of its channels.

    Returns
    -------
    Table
        Of the class of its type: `TemperatureTable`, `BandTable`, `AtmosphereTable` or `GridTable`. A script whose
        types are checked says which it expects by `isinstance`.

    Raises
    ------
    InputError
        The file is missing, damaged, of another type, of another major version, or its layout is not that of
        the format. Values outside their limits are refused when their array is first read.

    Examples
    --------
    >>> import skyshine.mat
    >>> job = {
    ...     "skyshine": 1,
    ...     "name": "one road",
    ...     "site": {"latitude_deg": 45, "longitude_deg": 7, "date": "2026-06-21", "utc_offset_h": 1},
    ...     "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [14, 27]}}],
    ...     "bands": [],
    ...     "materials": ["asphalt_road"],
    ...     "surface_grid": {"altitude_km": [0], "azimuth_deg": [180], "slope_deg": [0]},
    ...     "output": {"pictures": False},
    ... }
    >>> built = skyshine.mat.build(job, out="road", jobs=1)
    >>> surface = skyshine.mat.open("road/s01.htt.h5")
    >>> assert isinstance(surface, skyshine.mat.TemperatureTable)
    >>> noon, night = surface.temperature(material="asphalt_road", time=[13, 4])
    >>> bool(noon > night + 20)
    True
    """
    path = Path(path)
    root, attributes = read_raw(path) if path.name.endswith(ENDING) else _read_unchanged(path)
    filetype = str(attributes.get("filetype"))
    if filetype not in FORMATS:
        raise InputError(
            f"is of the file type '{filetype}'; {nearest(filetype, FORMATS)}; name another file", file=path
        )
    for line in (*broken_rules_of_axes(root), *(broken_spectrum_laws(root) if filetype == BAND.name else ())):
        raise InputError(f"{line}; build the file again", file=path)
    if filetype in AtmosphereTable.filetypes:
        for line in broken_channel_laws(root):
            raise InputError(f"{line}; build the file again", file=path)
        if grid and GRID not in root.groups:
            raise InputError(
                "contains no tables on five axes; write range_km, altitude_km, elevation_deg, source_elevation_deg and"
                " source_azimuth_deg under atmosphere_grid of the job and build it again, or use mat export --to axes",
                file=path,
            )
        if grid:
            return GridTable(path, filetype, root.groups[GRID], attributes)
    elif grid:
        raise InputError(f"is of the file type '{filetype}'; allowed with grid: atmq, lunar_atmq; omit grid", file=path)
    kind = next(kind for kind in _KINDS if filetype in kind.filetypes)
    return kind(path, filetype, root, attributes)


def _read_unchanged(path: Path) -> tuple[Group, dict[str, Any]]:
    """Content of a database: from memory where the same file was read before, for HDF5 takes 0.1 s to list it."""
    stamp = settled_stamp(path)
    root, attributes = _read(path, stamp) if stamp else _read.__wrapped__(path, stamp)
    return unread(root), dict(attributes)


@lru_cache(maxsize=32)
def _read(path: Path, _stamp: tuple[int, ...] | None) -> tuple[Group, dict[str, Any]]:
    root, attributes = read_file(path, lazy=True, check_values=refuse_values)
    refuse_layout(path, root, str(attributes.get("filetype")))
    _keep_unchanged(root)
    return root, attributes


def _keep_unchanged(group: Group) -> None:
    """Have numpy refuse changes of the axes that several tables share."""
    for axis in group.axes.values():
        axis.values.flags.writeable = False
    for child in group.groups.values():
        _keep_unchanged(child)


def open_as(kind: type[TableType], path: StrPath, remedy: str) -> TableType:
    """Open a database that must be of one class.

    Parameters
    ----------
    kind : type
        `TemperatureTable`, `BandTable` or `AtmosphereTable`.
    remedy : str
        What to do where the file is of another type, for the message.

    Raises
    ------
    InputError
        The file is of another type, or as `open_table`.
    """
    table = open_table(path)
    if table.filetype not in kind.filetypes:
        raise InputError(
            f"is of the file type '{table.filetype}'; allowed: {', '.join(kind.filetypes)}; {remedy}", file=table.path
        )
    return cast(TableType, table)
