"""Exports of whole folders of databases: every state, band and source with its textures, and the shader."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from skyshine.mat.gpu.air import GroundDay, export_air
from skyshine.mat.gpu.band import export_band
from skyshine.mat.gpu.codes import export_codes
from skyshine.mat.gpu.container import ENDING, GpuFile, write_gpu
from skyshine.mat.gpu.shader import write_shaders
from skyshine.mat.gpu.stated_error import with_stated_error
from skyshine.mat.gpu.surface import export_surface
from skyshine.mat.runtime.shade import SHADED_SKY
from skyshine.mat.tables import response
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.catalog import CATALOG, open_catalog
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.loader import open_as
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import open_tmm

_AIR = (".atmq.h5", ".lunar_atmq.h5")
_RENAMED = "give the file the name that mat build gave it"
_FRAME_COMPONENTS = (8, 12)  # between which a frame of a limited size chooses


@dataclass(frozen=True)
class Frame:
    """One moment of an export.

    Attributes
    ----------
    hour : float
        Local clock [h].
    altitude : float
        Altitude of the observer [km].
    """

    hour: float
    altitude: float


@dataclass(frozen=True, eq=False)
class AirSet:
    """An atmosphere with the databases that its export needs."""

    name: str
    air: AtmosphereTable
    band: BandTable
    surface: TemperatureTable


def databases(paths: Iterable[Path]) -> list[Path]:
    """Databases of files and folders.

    Raises
    ------
    InputError
        A path does not exist, or a folder has no database or is half built.
    """
    selected: list[Path] = []
    for path in paths:
        if path.is_dir():
            files = sorted(path.glob("*.h5"))
            if not files:
                raise InputError("has no database; build one with 'mat build'", file=path)
            _refuse_half_built(path, files)
            selected += files
        elif path.is_file():
            selected.append(path)
        else:
            raise InputError("does not exist; name a database, or a folder of them", file=path)
    return selected


def _refuse_half_built(folder: Path, files: list[Path]) -> None:
    catalog = folder / CATALOG
    if not catalog.is_file():
        raise InputError(f"has databases but no {CATALOG}: its build has not ended; run 'mat build'", file=folder)
    listed = {entry.file for entry in open_catalog(folder).entries}
    missing = sorted(listed - {file.name for file in files})
    if missing:
        raise InputError(f"lists {missing[0]}, which is not there; run 'mat build' again", file=catalog)


def air_sets(files: Iterable[Path]) -> list[AirSet]:
    """The atmospheres among files, each with the band and the temperatures of its name.

    Raises
    ------
    InputError
        A database that an atmosphere needs is not beside it.
    """
    sets = []
    for file in files:
        if not file.name.endswith(_AIR):
            continue
        name = file.name.removesuffix(".h5")
        stem = name.split(".")[0]
        state, _, band = stem.partition("b")
        needed = {kind: file.with_name(f"{part}.{kind}.h5") for kind, part in (("band", f"b{band}"), ("htt", state))}
        for path in needed.values():
            if not path.is_file():
                raise InputError(f"needs {path.name}, which is not beside it; export the whole folder", file=file)
        air = open_as(AtmosphereTable, file, _RENAMED)
        materials = open_as(BandTable, needed["band"], _RENAMED)
        sets.append(AirSet(name, air, materials, open_as(TemperatureTable, needed["htt"], _RENAMED)))
    return sets


def export_gpu(
    paths: Iterable[Path], folder: Path, frame: Frame | None = None, report: Callable[[Path], None] | None = None
) -> list[Path]:
    """Write databases as textures, with the shader that reads them.

    Parameters
    ----------
    paths : iterable of Path
        Databases, or folders of them.
    folder : Path
        Output folder.
    frame : Frame, optional
        One hour and altitude alone.
    report : callable, optional
        Gets the path of each header when it is written.

    Raises
    ------
    InputError
        A database is missing, damaged, or not for the frame; the folder cannot be written.
    """
    files = databases(paths)
    atmospheres = air_sets(files)
    headers: list[Path] = []

    def write(content: GpuFile, name: str) -> None:
        headers.append(write_gpu(content, folder, name))
        if report is not None:
            report(headers[-1])

    shaded_sky = SHADED_SKY if any(_has_shade(file) for file in files) else None
    for air_set in atmospheres:
        write(exported_air(air_set, frame), air_set.name)
    for file in files:
        name = file.name.removesuffix(".h5")
        if name.endswith(".tmm"):
            with open_tmm(file) as texture:
                write(export_codes(texture, file.name), name)
        elif name.endswith(".htt"):
            table = open_as(TemperatureTable, file, _RENAMED)
            hour = None if frame is None else frame.hour
            sky = shaded_sky if response.KERNEL in table.root.variables else None
            write(export_surface(table, hour=hour, shaded_sky=sky), name)
        elif name.endswith(".band"):
            write(export_band(open_as(BandTable, file, _RENAMED)), name)
    if not headers:
        raise InputError(f"has nothing that can be exported ({ENDING})", file=folder)
    write_shaders(folder)
    return headers


def _has_shade(file: Path) -> bool:
    """Whether a file is a texture with a layer of shade."""
    if not file.name.endswith(".tmm.h5"):
        return False
    with open_tmm(file) as texture:
        return texture.has_shade


def exported_air(air_set: AirSet, frame: Frame | None, **settings: Any) -> GpuFile:
    """The textures of an atmosphere, of a frame if one is given, with their stated error."""
    if frame is None:
        ground = GroundDay.of(air_set.air, air_set.band, air_set.surface)
        content = export_air(air_set.air, air_set.band, ground_day=ground, **settings)
        return with_stated_error(content, air_set.air, air_set.band, air_set.surface)
    source = str(air_set.air.attributes.get("source", "sun"))
    track = air_set.surface.source_track(source, time=frame.hour)
    elevation, azimuth = float(track.elevation), float(track.azimuth)
    conditions = {"altitude": frame.altitude, "source_elevation": elevation, **settings}
    if AMBIENT_HARMONICS in air_set.air.quantities:
        conditions["ground_temperature"] = float(air_set.air.ground_temperature(air_set.surface, time=frame.hour))
    candidates = []
    for components in _FRAME_COMPONENTS:  # more components leave fewer texels
        content = export_air(air_set.air, air_set.band, most_components=components, **conditions)
        numbers = content.numbers | {"hour": frame.hour, "source_azimuth": azimuth}
        candidates.append(
            with_stated_error(replace(content, numbers=numbers), air_set.air, air_set.band, air_set.surface)
        )
        if content.numbers["components"] < components:
            break
    return min(candidates, key=lambda content: float(content.stated_error["p99"]))
