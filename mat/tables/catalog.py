"""``catalog.json``: every database of a folder with its type, state, band, date, versions and hash."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date as Date
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pydantic

from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.result import Result
from skyshine.mat.tables.table import Table
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.format_versions import FORMAT_VERSION
from skyshine.schemas.hdf5 import open_database
from skyshine.schemas.paths import StrPath
from skyshine.schemas.whole_files import write_whole

if TYPE_CHECKING:
    import xarray

CATALOG = "catalog.json"
# Root attributes by the keys of an entry, in which state and band are numbers.
_NAMES = {
    "state_name": "state",
    "sounding": "sounding",
    "band_name": "band",
    "date": "date",
    "source": "source",
}
_NAME = re.compile(r"^(?:s(?P<state>\d+))?(?:b(?P<band>\d+))?\.")
_LISTED = 40  # values that one line of an error lists
_NEEDED = {"htt": ("state",), "band": ("band", "band_name"), "atmq": ("state", "band")}


class Entry(pydantic.BaseModel):
    """One database of a folder.

    Attributes
    ----------
    file : str
        Its name, after the folder of its site where the job has several.
    site : str or None
        Name of its site, of a job that has several.
    state, band : int or None
        Counted from 1, as in the job; None for a database that belongs to none.
    state_name, band_name : str or None
        Names of state and band in the job.
    date : datetime.date or None
        Local day.
    source : str or None
        'sun' or 'moon'.
    """

    model_config = pydantic.ConfigDict(frozen=True)

    file: str
    filetype: str = ""
    site: str | None = None
    state: int | None = None
    band: int | None = None
    state_name: str | None = None
    band_name: str | None = None
    date: Date | None = None
    source: str | None = None

    @pydantic.model_validator(mode="after")
    def _whole(self) -> Entry:
        if Path(self.file).name != self.file.removeprefix(f"{self.site}/"):
            raise ValueError("a database of another folder")
        if any(getattr(self, key) is None for key in _NEEDED.get(self.filetype, ())):
            raise ValueError("lacks what databases of its type have")
        return self


@dataclass(frozen=True, eq=False)
class Catalog(Result):
    """The databases of a folder, found by their contents.

    Attributes
    ----------
    folder : Path
    entries : tuple of Entry
        Entries in the order of their names.
    """

    folder: Path
    entries: tuple[Entry, ...]

    def __repr__(self) -> str:
        return f"<Catalog {self.folder}, {len(self.entries)} databases>"

    def to_xarray(self) -> xarray.Dataset:
        """The entries as an `xarray.Dataset` over files; 0 or empty text where a database has no such key."""

        def values(key: str) -> npt.NDArray[Any]:
            empty = 0 if key in ("state", "band") else ""
            column = [getattr(entry, key) or empty for entry in self.entries]
            return np.array(column if empty == 0 else [str(value) for value in column])

        return dataset(
            {"file": ("1", values("file"))},
            {key: (("file",), "1", values(key)) for key in Entry.model_fields if key != "file"},
            {"folder": str(self.folder)},
        )

    def find(
        self,
        filetype: str | None = None,
        *,
        site: str | None = None,
        state: int | str | None = None,
        band: int | str | None = None,
        date: Date | str | None = None,
        source: str | None = None,
    ) -> tuple[Entry, ...]:
        """Databases that have all of what is given; none where they do not come together.

        Parameters
        ----------
        filetype : str, optional
            'htt', 'band', 'atmq', 'lunar_atmq' or 'tmm'.
        site : str, optional
            Name of a site, of a job that has several; bands and textures are of all sites.
        state, band : int or str, optional
            Number, from 1, or name in the job.
        date : datetime.date or str, optional
            Local day, such as 2026-07-28.
        source : {'sun', 'moon'}, optional

        Raises
        ------
        InputError
            No database of the folder has one of them.
        """
        entries = self.entries
        for key, criterion in (
            ("filetype", filetype),
            ("site", site),
            ("state", state),
            ("band", band),
            ("date", date),
            ("source", source),
        ):
            if criterion is None:
                continue
            values = [_values(entry, key) for entry in self.entries]
            if not any(str(criterion) in value for value in values):
                names = list(dict.fromkeys(text for value in values for text in value))
                allowed = nearest(str(criterion), names) if len(names) <= _LISTED else f"{names[0]} to {names[-1]}"
                raise InputError(f"contains no {key} '{criterion}'; {allowed}", file=self.folder / CATALOG)
            having = {entry.file for entry, value in zip(self.entries, values, strict=True) if str(criterion) in value}
            entries = tuple(entry for entry in entries if entry.file in having)
        return entries

    def open(self, filetype: str | None = None, **criteria: Any) -> Table:
        """The only database that has all of what is given, as `find`.

        Raises
        ------
        InputError
            There is none, or more than one; as `find` and `loader.open_table`.
        """
        entries = self.find(filetype, **criteria)
        if len(entries) != 1:
            words = ", ".join(f"{key} {value}" for key, value in {"filetype": filetype, **criteria}.items() if value)
            names = ", ".join(entry.file for entry in entries[:4]) + (" ..." if len(entries) > 4 else "")
            raise InputError(
                f"has {len(entries)} databases of {words or 'all'}{': ' + names if entries else ''}; allowed: one;"
                " specify filetype, site, state, band, date or source",
                file=self.folder / CATALOG,
            )
        return open_table(self.folder / entries[0].file)


def open_catalog(folder: StrPath) -> Catalog:
    """The catalogue of a folder of built databases, or of one site in it: with the bands and textures of all sites.

    Raises
    ------
    InputError
        The folder has no catalogue, because its build has not ended, or a damaged one.

    Examples
    --------
    >>> import skyshine.mat
    >>> year = skyshine.mat.open_catalog("a_year/built")  # doctest: +SKIP
    >>> [entry.file for entry in year.find("atmq", date="2026-07-28", band="window")]  # doctest: +SKIP
    ['s209b01.atmq.h5']
    >>> table = year.open("htt", date="2026-07-28")  # doctest: +SKIP
    """
    own = Path(folder).resolve()
    path, site = own / CATALOG, ""
    if not path.is_file() and (own.parent / CATALOG).is_file():
        path, site = own.parent / CATALOG, own.name
    if not path.is_file():
        raise InputError(f"contains no {CATALOG}; run mat build, or name the folder it wrote", file=folder)
    try:
        files = json.loads(path.read_text(encoding="utf-8"))["files"]
        entries = tuple(Entry.model_validate(entry) for entry in files)
    except (OSError, ValueError, KeyError, TypeError):
        entries = ()
    if not entries:
        raise InputError("is no catalogue of databases; run mat build again", file=path)
    return Catalog(Path(folder), _of_site(entries, site, Path(folder)) if site else entries)


def _of_site(entries: Sequence[Entry], site: str, folder: Path) -> tuple[Entry, ...]:
    """Entries of a site and of all sites, their files relative to the folder of the site."""
    own = [entry.model_copy(update={"file": Path(entry.file).name}) for entry in entries if entry.site == site]
    if not own:
        raise InputError(f"is no site of the {CATALOG} in the folder above; run mat build again", file=folder)
    common = [entry.model_copy(update={"file": f"../{entry.file}"}) for entry in entries if entry.site is None]
    return (*own, *common)


def write_catalog(folder: Path, entries: Sequence[Mapping[str, Any]]) -> Path:
    """Write the catalogue of a folder from what `catalog_entry` gives of its databases."""
    path = folder / CATALOG
    content = {"format_version": FORMAT_VERSION, "files": sorted(entries, key=lambda entry: str(entry["file"]))}
    write_whole(path, json.dumps(content, indent=2) + "\n")
    return path


def _values(entry: Entry, key: str) -> list[str]:
    """Criteria for a database: a number, a name."""
    values = [getattr(entry, key), getattr(entry, f"{key}_name", None)]
    return [str(value) for value in values if value is not None]


def catalog_entry(folder: Path, name: str) -> dict[str, Any]:
    """Entry of a database, by its name after the folder of its site, where it has one."""
    site, _, base = name.rpartition("/")
    match = _NAME.match(base)
    numbers = {key: int(text) for key, text in match.groupdict().items() if text} if match else {}
    with open_database(folder / name) as file:
        read = ("filetype", "format_version", "data_version", "generator", "content_sha256")
        names = {entry: str(file.attrs[key]) for entry, key in _NAMES.items() if key in file.attrs}
        return {
            "file": name,
            **({"site": site} if site else {}),
            **numbers,
            **names,
            **{key: str(file.attrs[key]) for key in read},
        }
