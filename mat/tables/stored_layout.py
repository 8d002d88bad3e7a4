"""The layout of a file beside the layout schema of its type: axes, arrays, their types, units and order."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine import schemas
from skyshine.schemas.errors import InputError
from skyshine.schemas.format_versions import FORMAT_MAJOR
from skyshine.schemas.hdf5 import Group, type_name
from skyshine.schemas.paths import StrPath

if TYPE_CHECKING:
    from jsonschema import Draft202012Validator

ENDING = f"-{FORMAT_MAJOR}.layout.json"


def layout_problems(root: Group, attributes: dict[str, Any]) -> Iterator[str]:
    """One line for each part of a file that is not as the layout schema of the file's type has it."""
    filetype = str(attributes["filetype"])
    schema = _schema(filetype)
    if schema is None:
        layouts = sorted(p.name.removesuffix(ENDING) for p in schemas.path("").glob(f"*{ENDING}"))
        yield f"no layout is known for {filetype}; known: {', '.join(layouts)}"
        return
    content = describe(root) | {"attributes": {name: str(value) for name, value in attributes.items()}}
    yield from _lines(_validator(json.dumps(schema)), content)


def refuse_layout(path: StrPath, root: Group, filetype: str) -> None:
    """Refuse a file in which an array or axis of the format has another type, order or rule.

    Axes, arrays and groups that the format does not know are those of a later minor version: they are passed over.

    Raises
    ------
    InputError
    """
    schema = _schema(filetype)
    if schema is None:
        return  # the caller refuses another type
    properties = {part: schema["properties"][part]["properties"] for part in ("axes", "variables")}
    content = {
        part: {name: described for name, described in items.items() if name in properties[part]}
        for part, items in describe(root).items()
        if part in properties
    }
    subset = {"properties": {part: {"properties": rules} for part, rules in properties.items()}}
    for line in _lines(_validator(json.dumps(subset)), content):
        raise InputError(f"is not laid out as its format has it ({line[:200]}); build it again", file=path)


def describe(group: Group) -> dict[str, Any]:
    """Names, axes, types and units of a group's arrays, in the shape that the layout schemas describe."""
    return {
        "axes": {
            name: {"type": type_name(np.asarray(axis.values).dtype), "units": axis.units, **_reading(axis.attributes)}
            for name, axis in group.axes.items()
        },
        "variables": {
            name: {"type": type_name(variable.dtype), "units": variable.units, "dims": list(variable.dims)}
            for name, variable in group.variables.items()
        },
        "groups": {name: describe(child) for name, child in group.groups.items()},
    }


@lru_cache
def _schema(filetype: str) -> dict[str, Any] | None:
    path = schemas.path(f"{filetype}{ENDING}")
    if "/" in filetype or not path.is_file():
        return None
    schema: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return schema


@lru_cache
def _validator(schema: str) -> Draft202012Validator:
    from jsonschema import Draft202012Validator

    return Draft202012Validator(json.loads(schema))


def _lines(validator: Draft202012Validator, content: dict[str, Any]) -> Iterator[str]:
    for error in sorted(validator.iter_errors(content), key=lambda e: list(map(str, e.absolute_path))):
        yield f"{'/'.join(str(p) for p in error.absolute_path) or 'root'}: {error.message}"


def _reading(attributes: dict[str, Any]) -> dict[str, Any]:
    """How a runtime reads an axis, where the file says so."""
    rules = {key: attributes[key] for key in ("interpolation", "period") if key in attributes}
    return {key: value if isinstance(value, str) else float(value) for key, value in rules.items()}
