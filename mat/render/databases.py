"""The built databases that a scene reads: temperatures, and band and atmosphere of each band."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.mat.render.frame_file import LoadedFrame
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.catalog import CATALOG, Entry, open_catalog
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.loader import TableType, open_as
from skyshine.mat.tables.night import SOURCE_ELEVATION, Night
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError, nearest

Place = tuple[str | int, ...]
Refuse = Callable[[Place, str], InputError]


def refused(key: Place, message: str) -> InputError:
    """The error where no scene file has a line for it."""
    return InputError(message)


@dataclass(frozen=True, eq=False)
class BandTables:
    """What one band reads."""

    name: str
    band: BandTable
    air: AtmosphereTable


@dataclass(frozen=True, eq=False)
class SceneTables:
    """The open databases of a scene.

    Attributes
    ----------
    bands : tuple of BandTables
        Tables of the bands, in the order of the scene.
    """

    surface: TemperatureTable
    bands: tuple[BandTables, ...]

    @classmethod
    def of(
        cls, folder: Path, *, state: int, bands: Sequence[str] | None, source: str, refuse: Refuse = refused
    ) -> SceneTables:
        """Open databases of a folder.

        Parameters
        ----------
        folder : Path
            Output folder of a finished build.
        state : int
            Counted from 1.
        bands : sequence of str, optional
            Names; by default all.
        source : {'sun', 'moon'}
        refuse : callable
            Makes the error for a key (``databases``, ``state``, ``bands`` or ``source``) and a message.

        Raises
        ------
        InputError
            The folder, or a state, band or source in it, is missing, or a database is damaged.
        """
        entries = _catalog(folder, refuse)
        states = sorted({entry.state for entry in entries if entry.filetype == "htt" and entry.state is not None})
        if state not in states:
            allowed = ", ".join(map(str, states)) or "none; build the job first"
            raise refuse(("state",), f"{folder} has no state {state}; allowed: {allowed}")
        of_state = [entry for entry in entries if entry.state in (None, state)]
        numbers = {str(entry.band_name): entry.band for entry in of_state if entry.filetype == "band"}
        names = list(numbers) if bands is None else bands
        if not names:
            raise refuse(("bands",), f"{folder} has no band; build a job that has one")
        opened = []
        for index, name in enumerate(names):
            if name not in numbers:
                raise refuse(("bands", index), f"found the band '{name}'; {nearest(name, numbers)}")
            kind = "atmq" if source == "sun" else "lunar_atmq"
            air = _file(of_state, filetype=kind, band=numbers[name])
            if air is None:
                raise refuse(
                    ("source",), f"{folder} has no .{kind} of the band '{name}'; build the job with that source"
                )
            band = _open(BandTable, folder, _file(of_state, filetype="band", band=numbers[name]))
            opened.append(BandTables(name, band, _open(AtmosphereTable, folder, air)))
        return cls(_open(TemperatureTable, folder, _file(of_state, filetype="htt")), tuple(opened))

    @classmethod
    def of_scene(cls, scene: LoadedScene | LoadedFrame) -> SceneTables:
        """Open the databases that a scene, or a frame, names; raises as `of`, at the keys of its file."""
        model = scene.model
        tables = cls.of(scene.databases, state=model.state, bands=model.bands, source=model.source, refuse=scene.error)
        names = [band.name for band in tables.bands]
        for name in model.sensors or {}:
            if name not in names:
                raise scene.error(("sensors", name), f"found the band '{name}'; {nearest(name, names)}")
        return tables

    def codes(self, keys: Mapping[str, Place], refuse: Refuse = refused) -> Integers:
        """Codes (K,) of materials in the databases.

        Parameters
        ----------
        keys : dict
            K materials, with the key that each comes from.
        refuse : callable
            Maker of an error, as for `of`.

        Raises
        ------
        InputError
            A database lacks one of them, or has another code for it.
        """
        material_codes = self.surface.materials
        for name, key in keys.items():
            for table in (self.surface, *(tables.band for tables in self.bands)):
                if name not in table.materials:
                    raise refuse(
                        key,
                        f"{table.path.name} lacks the material '{name}'; {nearest(name, table.materials)}; add it to"
                        " the job and build again",
                    )
                if table.materials[name] != material_codes[name]:
                    raise InputError(f"has another code for '{name}' than the .htt file; build again", file=table.path)
        return np.array([material_codes[name] for name in keys], int)


def held_hours(surface: TemperatureTable, hours: Floats) -> Booleans:
    """Whether a table of temperatures covers clock hours (T,): all, or a part of the day."""
    rule = AxisRule.of("time", surface.root.axes["time"])
    if rule.interpolation == PERIODIC:
        return np.ones(hours.shape, bool)
    start, stop = rule.nodes[[0, -1]]
    inside: Booleans = np.mod(hours - start, 24.0) <= stop - start + 1e-9
    return inside


def in_twilight(air: AtmosphereTable, elevation: Floats) -> Booleans:
    """Which elevations (T,) of the source [degree] are in a twilight that the atmosphere of a band does not contain."""
    lacking: Booleans = Night(AxisRule.of(SOURCE_ELEVATION, air.root.axes[SOURCE_ELEVATION])).lacks(elevation)
    return lacking


def _catalog(folder: Path, refuse: Refuse) -> tuple[Entry, ...]:
    if not any((path / CATALOG).is_file() for path in (folder, folder.resolve().parent)):
        raise refuse(("databases",), f"{folder} contains no {CATALOG}; run mat build, or name the folder it wrote")
    entries = open_catalog(folder).entries
    if sites := {entry.site for entry in entries if entry.site and "/" in entry.file}:
        raise refuse(("databases",), f"{folder} has {len(sites)} sites; allowed: one; name its folder in it")
    return entries


def _file(entries: Sequence[Entry], filetype: str, band: int | None = None) -> str | None:
    """Name of the first file of a type, and of a band."""
    for entry in entries:
        if entry.filetype == filetype and band in (None, entry.band):
            return entry.file
    return None


def _open(kind: type[TableType], folder: Path, name: str | None) -> TableType:
    if name is None:
        raise InputError(f"lacks a database that '{CATALOG}' should name; run mat build again", file=folder)
    return open_as(kind, folder / name, "run mat build again")
