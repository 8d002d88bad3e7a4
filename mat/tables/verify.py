"""Checking a database: layout, versions, units, finite values, physical laws, digest."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np

from skyshine import schemas
from skyshine.mat.tables.laws import broken_laws, broken_texture_laws
from skyshine.schemas.hdf5 import open_database, read_file, sound
from skyshine.schemas.hdf5_digest import as_text, digest_holds, dims_of, is_text, parts
from skyshine.schemas.paths import StrPath


def describe(group: h5py.Group) -> dict[str, Any]:
    """Names, axes, types and units of a group's arrays, in the shape that the layout schemas describe."""
    described: dict[str, Any] = {"axes": {}, "variables": {}, "groups": {}}
    for name, item in group.items():
        if isinstance(item, h5py.Group):
            described["groups"][name] = describe(item)
        elif item.is_scale:
            described["axes"][name] = {"type": _kind(item), "units": _units(item), **_reading(item)}
        else:
            described["variables"][name] = {"type": _kind(item), "units": _units(item), "dims": list(dims_of(item))}
    return described


def _kind(dataset: h5py.Dataset) -> str:
    return "text" if is_text(dataset) else str(dataset.dtype.str).lstrip("<>|=")


def _units(dataset: h5py.Dataset) -> str:
    return str(dataset.attrs.get("units", ""))


def _reading(dataset: h5py.Dataset) -> dict[str, Any]:
    """How a runtime reads an axis, where the file says so."""
    said = {key: as_text(dataset.attrs[key]) for key in ("interpolation", "period") if key in dataset.attrs}
    return {key: value if isinstance(value, str) else float(value) for key, value in said.items()}


def problems(path: StrPath) -> list[str]:
    """All that is wrong with a database; an empty list where nothing is.

    Raises
    ------
    InputError
        The file is missing or is not a database at all.
    """
    with open_database(path) as file, sound(path):
        lines = [*_layout_problems(file), *_value_problems(file)]
        if file.attrs["filetype"] == "tmm":
            lines += broken_texture_laws(file)
        else:
            lines += broken_laws(str(file.attrs["filetype"]), read_file(path, lazy=True)[0])
        if not digest_holds(file):
            lines.append("content_sha256 does not match the content: the file was changed or damaged")
    return lines


def _layout_problems(file: h5py.File) -> Iterator[str]:
    import jsonschema

    filetype, version = str(file.attrs["filetype"]), str(file.attrs.get("format_version", ""))
    schema = schemas.path(f"{filetype}-{version.split('.')[0]}.layout.json")
    if not schema.is_file():
        known = sorted(p.name.removesuffix(".layout.json") for p in schema.parent.glob("*.layout.json"))
        yield f"no layout is known for {filetype} {version}; known: {', '.join(known)}"
        return
    content = describe(file) | {"attributes": {k: str(v) for k, v in file.attrs.items()}}
    validator = jsonschema.Draft202012Validator(json.loads(schema.read_text(encoding="utf-8")))
    for error in sorted(validator.iter_errors(content), key=lambda e: list(map(str, e.absolute_path))):
        yield f"{'/'.join(str(p) for p in error.absolute_path) or 'root'}: {error.message}"


def _value_problems(file: h5py.File) -> list[str]:
    lines: list[str] = []

    def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
        if not isinstance(item, h5py.Dataset) or is_text(item):
            return
        if item.dtype.kind == "f" and not name.startswith("accuracy/"):
            wrong = sum(np.count_nonzero(~np.isfinite(part)) for part in parts(item))
            if wrong:
                lines.append(f"{name}: {wrong} values are not finite")
        if item.is_scale and np.any(np.diff(item[()].astype(float)) <= 0):
            lines.append(f"{name}: the axis is not strictly ascending")

    file.visititems(visit)
    return lines
