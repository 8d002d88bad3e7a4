"""The material library: the packaged materials and a user's own, by name or code."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StringConstraints, field_validator

from skyshine import materials
from skyshine.materials.records import (
    Back,
    Layer,
    Material,
    Soil,
    SpectralRange,
    SurfaceProperties,
    ThermalStack,
)
from skyshine.materials.words import meant
from skyshine.schemas.documents import Document, StrictModel, Text, parse_model, read_yaml
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath

__all__ = [
    "Back",
    "Layer",
    "Material",
    "MaterialLibrary",
    "Soil",
    "SpectralRange",
    "SurfaceProperties",
    "ThermalStack",
    "load_library",
]

ENVIRONMENT = "MATERIALS_DATABASE"

Name = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
Code = Annotated[int, Field(ge=1, le=65535, strict=True)]


class IndexEntry(StrictModel):
    """A line of the index."""

    code: Code = Field(
        description="Code in textures and tables; never reused or changed. A user's own need unused ones."
    )
    name: Name = Field(description="Lower-case letters, digits and underscores; names the files of the material.")
    group: Name = Field(description="Kind of material, by which lists are sorted, such as roofing.")
    description: Text = Field(description="One line that says what it is.")


class Index(StrictModel):
    """`mat.yaml`."""

    data_version: str = Field(description="Semantic version such as 1.0.0; it rises with every changed value.")
    references: dict[str, Text] = Field({}, description="Full references of the keys that sources name in brackets.")
    materials: Annotated[list[IndexEntry], Field(min_length=1)] = Field(description="All materials of the folder.")

    @field_validator("data_version", mode="before")
    @classmethod
    def _semantic(cls, value: Any) -> str:
        # Before the type check: YAML reads 1.0 as a number.
        if not isinstance(value, str) or not re.fullmatch(r"[0-9]+\.[0-9]+\.[0-9]+", value):
            raise ValueError(f"found '{value}'; allowed: a semantic version such as 1.0.0")
        return value


def unknown_material(name: object, allowed: Iterable[str]) -> str:
    """Words for a name that the library does not have: which it may mean, and how to add it."""
    text = str(name)[:40]
    message = f"unknown material '{text}'; {meant(text, allowed)}"
    if not re.fullmatch("[a-z][a-z0-9_]*", text):
        return message
    return f"{message}; to add it: 'mat materials new {text} --like ONE_OF_THESE'"


@dataclass(frozen=True)
class _Place:
    """Where an entry of the library is defined."""

    entry: IndexEntry
    folder: Path
    line: int


class MaterialLibrary:
    """Materials by name and code; each is read from its files when it is first asked for.

    Attributes
    ----------
    version : str
        `data_version` of the packaged index, followed by ``+NAME-VERSION`` for a user's folder.
    references : dict of str to str
        Full references of the keys that sources name in square brackets.
    """

    def __init__(self, version: str, references: dict[str, str], entries: list[_Place]):
        self.version = version
        self.references = references
        self._places = {entry.entry.name: entry for entry in sorted(entries, key=lambda entry: entry.entry.code)}
        self._names = {entry.entry.code: name for name, entry in self._places.items()}
        self._loaded: dict[str, Material] = {}
        self._given: dict[str, Material] = {}  # materials of no files
        self._change: Callable[[Material], Material] = lambda material: material

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all materials, in the order of their codes."""
        return tuple(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def __iter__(self) -> Iterator[Material]:
        return (self[name] for name in self._places)

    def __getitem__(self, name: str) -> Material:
        """The material of this name.

        Raises
        ------
        InputError
            There is none of this name, or one of its files is wrong.
        """
        if name not in self._loaded:
            self._loaded[name] = self._change(self._given.get(name) or _read(self._place(name)))
        return self._loaded[name]

    def _place(self, name: str) -> _Place:
        if name not in self._places:
            raise InputError(unknown_material(name, self._places))
        return self._places[name]

    def code(self, name: str) -> int:
        """Code of the material of this name, by the index alone: no other file is read.

        Raises
        ------
        InputError
            There is none of this name.

        Examples
        --------
        >>> library = load_library()
        >>> library.code("asphalt_road") == library["asphalt_road"].code
        True
        """
        return self._place(name).entry.code

    def group(self, name: str) -> str:
        """Group of the material of this name; as `code`."""
        return self._place(name).entry.group

    def changed(self, change: Callable[[Material], Material]) -> MaterialLibrary:
        """The same library whose materials went through a function."""
        library = MaterialLibrary(self.version, self.references, [*self._places.values()])
        library._given = self._given
        library._change = lambda material: change(self._change(material))
        return library

    def with_materials(self, materials_of_job: Iterable[Material]) -> MaterialLibrary:
        """The same library with materials of other names and codes that no file has; its version ends in ``+job``."""
        by_name = {material.name: material for material in materials_of_job}
        entries = [
            _Place(IndexEntry(code=m.code, name=m.name, group=m.group, description=m.description), Path(), 0)
            for m in by_name.values()
        ]
        library = MaterialLibrary(f"{self.version}+job", self.references, [*self._places.values(), *entries])
        library._given, library._change = self._given | by_name, self._change
        return library

    def by_code(self, code: int) -> Material:
        """The material of this code.

        Raises
        ------
        InputError
            There is none of this code, or one of its files is wrong.
        """
        if code not in self._names:
            raise InputError(f"no material of code {code}; allowed: {', '.join(map(str, self._names))}")
        return self[self._names[code]]


def load_library(folder: StrPath | None = None) -> MaterialLibrary:
    """The packaged library with the user's folder on top; what this process has read before, as long as no file of the
    folder has changed.

    Parameters
    ----------
    folder : path, optional
        A folder of the packaged layout (`mat.yaml`, `ht/`, `ref/`, `spec/`); by default the one that
        MATERIALS_DATABASE names in the environment, if it is set. A material of a packaged name replaces
        that one; other names are added.

    Raises
    ------
    InputError
        An index cannot be read, or a name or code occurs twice.
    """
    if folder is None:
        folder = os.environ.get(ENVIRONMENT) or None
    if folder is not None and not Path(folder).is_dir():
        raise InputError(f"{ENVIRONMENT} names '{folder}', which is not a folder; give one that contains mat.yaml")
    user_folder = None if folder is None else Path(folder)
    return _library(user_folder, None if user_folder is None else _stamps(user_folder))


Stamps = tuple[tuple[str, int, int], ...]


def _stamps(folder: Path) -> Stamps:
    """What tells whether a file of a library has changed: name, time of its last change, size."""
    inside = [folder, *(Path(entry.path) for entry in os.scandir(folder) if entry.is_dir())]
    files = [(entry.path, entry.stat()) for place in inside for entry in os.scandir(place) if entry.is_file()]
    return tuple(sorted((path, stat.st_mtime_ns, stat.st_size) for path, stat in files))


@lru_cache(maxsize=4)
def _library(folder: Path | None, _own_files: Stamps | None) -> MaterialLibrary:
    packaged, entries = _read_index(materials.path())
    if folder is None:
        return MaterialLibrary(packaged.data_version, packaged.references, entries)
    index, user_places = _read_index(folder)
    merged = {entry.entry.name: entry for entry in entries}
    merged.update({entry.entry.name: entry for entry in user_places})
    _refuse_shared_codes(merged.values())
    return MaterialLibrary(
        f"{packaged.data_version}+{folder.resolve().name}-{index.data_version}",
        {**packaged.references, **index.references},
        list(merged.values()),
    )


def _read_index(folder: Path) -> tuple[Index, list[_Place]]:
    document = read_yaml(folder / "mat.yaml")
    index = parse_model(document, Index)
    entries = [
        _Place(entry, folder, document.where(("materials", position))[0] or 1)
        for position, entry in enumerate(index.materials)
    ]
    _refuse_repeats(document, index)
    return index, entries


def _refuse_repeats(document: Document, index: Index) -> None:
    for field in ("name", "code"):
        lines: dict[Any, int] = {}
        for position, entry in enumerate(index.materials):
            value = getattr(entry, field)
            if value in lines:
                earlier = document.where(("materials", lines[value], field))[0]
                raise document.error(
                    ("materials", position, field),
                    f"{field} {value} occurs twice (first at line {earlier}); allowed: each {field} once; "
                    f"{'give this material a free code' if field == 'code' else 'rename this material'}",
                )
            lines[value] = position


def _refuse_shared_codes(entries: Iterable[_Place]) -> None:
    """A user's addition must not take the code of another material: textures contain codes."""
    owners: dict[int, _Place] = {}
    for entry in entries:
        owner = owners.setdefault(entry.entry.code, entry)
        if owner is not entry:
            raise InputError(
                f"code {entry.entry.code} of '{entry.entry.name}' is that of '{owner.entry.name}' "
                f"({owner.folder / 'mat.yaml'}:{owner.line}); give it a free code (1 to 65535)",
                file=entry.folder / "mat.yaml",
                line=entry.line,
            )


def _read(location: _Place) -> Material:
    # Their models take 0.06 s to build, which what asks for codes alone does not wait for.
    from skyshine.materials.files import load_spectrum, load_specular, load_thermal

    entry = location.entry
    thermal = load_thermal(location.folder / "ht" / f"{entry.name}.yaml")
    spectrum = load_spectrum(location.folder / "ref" / f"{entry.name}.csv")
    fraction, width, lobe_sources = load_specular(location.folder / "spec" / f"{entry.name}.yaml")
    return Material(
        code=entry.code,
        name=entry.name,
        description=entry.description,
        group=entry.group,
        thermal=thermal.stack,
        surface=thermal.surface,
        wavelength=spectrum.wavelength,
        reflectance=spectrum.reflectance,
        absorptance=spectrum.absorptance,
        transmits=spectrum.transmits,
        ranges=spectrum.ranges,
        specular_fraction=fraction,
        lobe_fwhm=width,
        sources={**thermal.sources, **lobe_sources, "reflectance": spectrum.header},
        reflectance_note=spectrum.header,
        soil=thermal.soil,
        stand=thermal.stand,
        operated=thermal.operated,
    )
