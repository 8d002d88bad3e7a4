"""Checking a database: layout, versions, units, finite values, hash."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator

import h5py
import numpy as np

from skyshine import schemas
from skyshine.schemas.hdf5 import open_database, sound
from skyshine.schemas.hdf5_digest import digest_holds, dims_of


def describe(group: h5py.Group) -> dict:
    """Names, axes, types and units of a group's arrays, in the shape that the layout schemas describe."""
    described: dict = {"axes": {}, "variables": {}, "groups": {}}
    for name, item in group.items():
        if isinstance(item, h5py.Group):
            described["groups"][name] = describe(item)
        elif item.is_scale:
            described["axes"][name] = {"type": _kind(item), "units": _units(item), **_reading(item)}
        else:
            described["variables"][name] = {"type": _kind(item), "units": _units(item), "dims": list(dims_of(item))}
    return described


def _kind(dataset: h5py.Dataset) -> str:
    return "text" if h5py.check_string_dtype(dataset.dtype) is not None else dataset.dtype.str.lstrip("<>|=")


def _units(dataset: h5py.Dataset) -> str:
    return str(dataset.attrs.get("units", ""))


def _reading(dataset: h5py.Dataset) -> dict:
    """How a runtime reads an axis, where the file says so."""
    found = {key: dataset.attrs[key] for key in ("interpolation", "period") if key in dataset.attrs}
    return {key: value if isinstance(value, str) else float(value) for key, value in found.items()}


def problems(path: str | os.PathLike) -> list[str]:
    """All that is wrong with a database; an empty list where nothing is.

    Raises
    ------
    InputError
        The file is missing or is not a database at all.
    """
    with open_database(path) as file, sound(path):
        found = list(_layout_problems(file))
        found += _value_problems(file)
        if not digest_holds(file):
            found.append("content_sha256 does not match the content: the file was changed or damaged")
    return found


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
    found: list[str] = []

    def visit(name: str, item) -> None:
        if not isinstance(item, h5py.Dataset) or item.dtype.kind != "f":
            return
        values = item[()]
        if not name.startswith("accuracy/") and not np.all(np.isfinite(values)):
            found.append(f"{name}: {np.count_nonzero(~np.isfinite(values))} values are not finite")
        if item.is_scale and values.ndim == 1 and np.any(np.diff(values) <= 0):
            found.append(f"{name}: the axis is not strictly ascending")

    file.visititems(visit)
    return found
