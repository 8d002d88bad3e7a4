"""The states of a folder as cubes by date in netCDF, for analysis with xarray and other readers of CF.

A cube of temperatures is read at the nodes of its tables and at whole hours, for each day places nodes of time of its
own; one of a band's atmosphere on the axes of DSTO-TN-0193 from the least to the most of its files.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import DESCRIBED, GRID_AXES, tables_on_axes
from skyshine.mat.tables.axes import LINEAR
from skyshine.mat.tables.catalog import Catalog, Entry, open_catalog
from skyshine.mat.tables.htt import COLUMN, TemperatureTable
from skyshine.mat.tables.loader import open_as
from skyshine.mat.tables.named_materials import NAMES
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import CONVENTIONS
from skyshine.schemas.whole_files import part_file

if TYPE_CHECKING:
    from netCDF4 import Dataset

HOURS = np.arange(24.0)  # local clock [h]
DATE_UNITS = "days since 1970-01-01"
# [degree], denser at the horizon, where the path radiance changes most.
ELEVATIONS = (-90.0, -60.0, -30.0, -15.0, -8.0, -4.0, -2.0, 0.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 90.0)
AZIMUTHS = (0.0, 15.0, 45.0, 90.0, 135.0, 180.0)  # from the Sun [degree], denser near it
RANGES, ALTITUDES, SOURCE_STEP = 8, 3, 10.0  # nodes; degree
_SHORTEST = 1e-2  # km, the first range of a file that begins nearer
Axes = dict[str, tuple[Any, str, str]]  # nodes, units, meaning


def export_cubes(folder: Path, out: Path) -> Iterator[Path]:
    """Write the cubes of a folder of `mat build`: one of temperatures, one for each band and source; of each site.

    Raises
    ------
    InputError
        netCDF4 is not installed, the folder has no catalogue, two states of a site have one date, or tables of a cube
        have other axes.
    """
    catalog = open_catalog(folder)
    groups: dict[str, list[Entry]] = {}
    for entry in catalog.entries:
        if entry.date is not None and entry.state is not None:
            band = f"b{entry.band:02d}." if entry.band is not None else ""
            site = f"{entry.site}." if entry.site else ""
            groups.setdefault(f"{site}{band}{entry.filetype}", []).append(entry)
    if not groups:
        raise InputError("contains no state of a date; name a folder of mat build", file=folder)
    for name, entries in groups.items():
        entries.sort(key=lambda entry: str(entry.date))
        dates = [str(entry.date) for entry in entries]
        twice = next((date for date, later in pairwise(dates) if date == later), None)
        if twice is not None:
            raise InputError(
                f"has two states on {twice}; allowed: one a date; export a folder of one series", file=folder
            )
        yield _cube(catalog, entries, out / f"{name}.nc")


def _cube(catalog: Catalog, entries: Sequence[Entry], target: Path) -> Path:
    try:
        import netCDF4
    except ModuleNotFoundError:
        raise InputError('needs netCDF4; run: pip install "skyshine[netcdf]"') from None
    target.parent.mkdir(parents=True, exist_ok=True)
    part = part_file(target)
    axes: Axes = {}
    try:
        with netCDF4.Dataset(part, "w") as file:
            for number, entry in enumerate(entries):
                path = catalog.folder / entry.file
                if entry.filetype == "htt":
                    own, arrays = _temperatures(path, axes)
                else:
                    own, arrays = _atmosphere(path, axes)
                if not number:
                    axes = own
                    _define(file, axes, arrays, entry)
                elif (name := _other_axis(axes, own)) is not None:
                    raise InputError(
                        f"has another axis '{name}' than {entries[0].file}; export folders of one job", file=path
                    )
                file["date"][number] = (np.datetime64(str(entry.date)) - np.datetime64("1970-01-01")).astype(int)
                for name, (_, values, *_) in arrays.items():
                    file[name][number] = values
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
    return target


def _other_axis(axes: Axes, own: Axes) -> str | None:
    return next((name for name in axes if not np.array_equal(axes[name][0], own[name][0])), None)


Arrays = Mapping[str, tuple[tuple[str, ...], Any, str, str]]  # axes, values, units, meaning


def _define(file: Dataset, axes: Axes, arrays: Arrays, entry: Entry) -> None:
    file.setncatts(
        {
            "Conventions": CONVENTIONS,
            "title": f"{entry.filetype} by date",
            **{key: text for key in ("site", "band_name", "source") if (text := getattr(entry, key))},
        }
    )
    file.createDimension("date", None)
    file.createVariable("date", "i4", ("date",)).setncatts({"units": DATE_UNITS, "standard_name": "time"})
    for name, (nodes, units, words) in axes.items():
        values = np.asarray(nodes)
        file.createDimension(name, values.size)
        axis = file.createVariable(name, str if values.dtype.kind in "UO" else "f8", (name,))
        axis[:] = values.astype(object) if values.dtype.kind in "UO" else values
        axis.setncatts({"units": units, "long_name": words})
    for name, (dims, values, units, words) in arrays.items():
        variable = file.createVariable(
            name, "f4", ("date", *dims), zlib=True, shuffle=True, chunksizes=(1, *np.shape(values)), fill_value=np.nan
        )
        variable.setncatts({"units": units, "long_name": words})


def _temperatures(path: Path, axes: Axes) -> tuple[Axes, Arrays]:
    """Temperatures of a file on its nodes, or on those of the first file: a build places them for each state."""
    table = open_as(TemperatureTable, path, "name a folder of mat build")
    stored = table.root.axes
    codes, times = np.asarray(stored["material"].values), stored["time"]
    hours = HOURS
    if times.attributes["interpolation"] == LINEAR:  # times are a part of the day
        hours = HOURS[(times.values[0] <= HOURS) & (times.values[-1] >= HOURS)]
    cube_axes: Axes = {
        "material": (np.asarray(table.root.variables[NAMES].data).astype(str), "1", "material"),
        **{
            name: axes.get(name) or (np.asarray(stored[name].values), stored[name].units, stored[name].long_name)
            for name in COLUMN[1:]
        },
        "hour": (hours, "h", "local clock time of day"),
    }
    mesh = np.meshgrid(codes, *(cube_axes[name][0] for name in (*COLUMN[1:], "hour")), indexing="ij", sparse=True)
    values = table.value("temperature", **dict(zip((*COLUMN, "time"), mesh, strict=True)))
    return cube_axes, {"temperature": (tuple(cube_axes), values, "K", "surface temperature")}


def _atmosphere(path: Path, axes: Axes) -> tuple[Axes, Arrays]:
    """The four quantities of a file on some axes; of the first one, by whose ends they are placed."""
    air = open_as(AtmosphereTable, path, "name a folder of mat build")
    grid = PathGrid(*(nodes for nodes, _, _ in axes.values())) if axes else _grid(air)
    tables = tables_on_axes(air, grid)
    path_table = tables["path_radiance_ratio"]
    own = {name: (nodes, *GRID_AXES[name]) for name, nodes in zip(path_table.axes, path_table.nodes, strict=True)}
    arrays = {}
    for name, (units, words, _) in DESCRIBED.items():
        table = tables[name]
        inside = table.valid.reshape(table.valid.shape + (1,) * (table.values.ndim - table.valid.ndim))
        arrays[name] = (table.axes, np.where(inside, table.values, np.nan), units, words)
    return own, arrays


def _grid(air: AtmosphereTable) -> PathGrid:
    shortest, longest = (float(value) for value in air.attributes["range_km"])
    low, high = (float(value) for value in air.attributes["altitude_km"])
    source = np.asarray(air.root.axes["source_elevation"].values, float)
    return PathGrid(
        np.unique(np.geomspace(max(shortest, min(_SHORTEST, longest)), longest, RANGES)),
        np.unique(np.linspace(low, high, ALTITUDES)),
        np.array(ELEVATIONS),
        _between(float(source[0]), float(source[-1])),
        np.array(AZIMUTHS),
    )


def _between(low: float, high: float) -> Floats:
    """Whole steps between two elevations, and these."""
    return np.unique([low, *np.arange(np.ceil(low / SOURCE_STEP), high / SOURCE_STEP) * SOURCE_STEP, high])
