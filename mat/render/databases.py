"""The built databases that a scene reads: temperatures, and band and atmosphere of each band."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from skyshine.mat.render.scene_file import LoadedScene
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.surface_tables import BandTable, TemperatureTable
from skyshine.mat.tables.table import Table
from skyshine.schemas.arrays import Integers
from skyshine.schemas.errors import InputError, nearest

CATALOG = "catalog.json"
TableType = TypeVar("TableType", bound=Table)


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
    surface : TemperatureTable
    bands : tuple of BandTables
        In the order of the scene.
    """

    surface: TemperatureTable
    bands: tuple[BandTables, ...]

    @classmethod
    def of(cls, scene: LoadedScene) -> SceneTables:
        """Open the databases that a scene names.

        Raises
        ------
        InputError
            The folder, or a state, band or source in it, is missing, or a database is damaged.
        """
        folder, model = scene.databases, scene.model
        entries = _catalog(scene, folder)
        states = sorted({entry["state"] for entry in entries if entry.get("filetype") == "htt"})
        if model.state not in states:
            allowed = ", ".join(map(str, states)) or "none; build the job first"
            raise scene.error(("state",), f"{folder} holds no state {model.state}; allowed: {allowed}")
        of_state = [entry for entry in entries if entry.get("state", model.state) == model.state]
        numbers = {entry["band_name"]: entry["band"] for entry in of_state if entry.get("filetype") == "band"}
        names = list(numbers) if model.bands is None else model.bands
        for number, name in enumerate(names):
            if name not in numbers:
                raise scene.error(("bands", number), f"found the band '{name}'; {nearest(name, numbers)}")
        for name in model.sensors or {}:
            if name not in names:
                raise scene.error(("sensors", name), f"found the band '{name}'; {nearest(name, names)}")
        surface = _open(TemperatureTable, folder, _file(of_state, filetype="htt"))
        bands = []
        for name in names:
            kind = "atmq" if model.source == "sun" else "lunar_atmq"
            air = _file(of_state, filetype=kind, band=numbers[name])
            if air is None:
                raise scene.error(
                    ("source",), f"{folder} holds no .{kind} of the band '{name}'; build the job with that source"
                )
            band = _open(BandTable, folder, _file(of_state, filetype="band", band=numbers[name]))
            bands.append(BandTables(name, band, _open(AtmosphereTable, folder, air)))
        return cls(surface, tuple(bands))

    def codes(self, scene: LoadedScene, names: Sequence[str], places: dict[str, tuple[str | int, ...]]) -> Integers:
        """Codes (K,) of materials in the databases.

        Parameters
        ----------
        scene : LoadedScene
        names : sequence of str
            K materials.
        places : dict
            Key of the scene that each comes from, for errors.

        Raises
        ------
        InputError
            A database lacks one of them, or has another code for it.
        """
        known = self.surface.materials
        for name in names:
            for table in (self.surface, *(tables.band for tables in self.bands)):
                if name not in table.materials:
                    raise scene.error(
                        places[name],
                        f"{table.path.name} lacks the material '{name}'; {nearest(name, table.materials)}; add it to"
                        " the job and build again",
                    )
                if table.materials[name] != known[name]:
                    raise InputError(f"has another code for '{name}' than the .htt file; build again", file=table.path)
        return np.array([known[name] for name in names], int)


def _catalog(scene: LoadedScene, folder: Path) -> list[dict[str, Any]]:
    path = folder / CATALOG
    if not path.is_file():
        raise scene.error(("databases",), f"{folder} holds no {CATALOG}; run mat build, or name the folder it wrote")
    try:
        files = json.loads(path.read_text(encoding="utf-8"))["files"]
        return [dict(entry) for entry in files]
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError("is no catalogue of databases; run mat build again", file=path) from None


def _file(entries: Sequence[dict[str, Any]], **wanted: Any) -> str | None:
    """Name of the first file whose entry has all these values."""
    for entry in entries:
        if all(entry.get(key) == value for key, value in wanted.items()):
            return str(entry["file"])
    return None


def _open(kind: type[TableType], folder: Path, name: str | None) -> TableType:
    if name is None:
        raise InputError(f"lacks a database that '{CATALOG}' should name; run mat build again", file=folder)
    table = open_table(folder / name)
    if not isinstance(table, kind):
        raise InputError(f"holds a table of type {table.filetype}; run mat build again", file=folder / name)
    return table
