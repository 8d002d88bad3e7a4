"""Flat export for engines without HDF5: a JSON header and the arrays as little-endian float32 in one file beside it.

The header contains axes and texts in full; `schemas/formats/raw-1.md` describes both files.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.format_versions import FORMAT_VERSION, check_version
from skyshine.schemas.hdf5 import Axis, Group, Variable, read_file, type_name
from skyshine.schemas.paths import StrPath
from skyshine.schemas.regular_files import refuse_special_file

FORMAT = "skyshine-raw"
ALIGNMENT = 16  # bytes; arrays can be mapped as vectors of four
HEADER_LIMIT = 64_000_000  # bytes
INTEGER_LIMIT = 1 << 24  # float32 represents every integer up to this one
ENDING = ".raw.json"


def export_raw(path: StrPath, folder: StrPath) -> Path:
    """Write a database as ``NAME.raw.json`` and ``NAME.raw.bin`` into a folder.

    Returns
    -------
    Path
        Path of the header, which is written last: if it exists, both files are complete.

    Raises
    ------
    InputError
        The database cannot be read, the folder cannot be written, or an integer does not fit a float32.
    """
    root, attributes = read_file(path)
    name = Path(path).name.removesuffix(".h5")
    target = Path(folder) / f"{name}{ENDING}"
    parts = [target.with_name(f".{target.name}.{os.getpid()}.{kind}.part") for kind in ("bin", "json")]
    header: dict[str, Any] = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "data": f"{name}.raw.bin",
        "bytes": 0,
        "groups": {},
    }
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with parts[0].open("wb") as file:
            for group_path, group in _walk(root, ""):
                header["groups"][group_path] = _write_group(file, group, Path(path), group_path)
            header["bytes"] = file.tell()
        header["groups"][""]["attributes"] = _plain_all(attributes)
        parts[1].write_text(json.dumps(header, indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")
        os.replace(parts[0], target.with_name(header["data"]))
        os.replace(parts[1], target)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}; check free space and permissions", file=target
        ) from None
    finally:
        for part in parts:
            part.unlink(missing_ok=True)
    return target


def _walk(group: Group, path: str) -> Iterator[tuple[str, Group]]:
    yield path, group
    for name, child in group.groups.items():
        yield from _walk(child, f"{path}/{name}".lstrip("/"))


def _write_group(file: BinaryIO, group: Group, path: Path, group_path: str) -> dict[str, Any]:
    axes = {
        name: {
            **_described(axis),
            "type": type_name(axis.values.dtype),
            "values": [_plain(v) for v in axis.values.tolist()],
        }
        for name, axis in group.axes.items()
    }
    arrays = {}
    for name, variable in group.variables.items():
        entry = {
            **_described(variable),
            "type": type_name(variable.data.dtype),
            "axes": list(variable.dims),
            "shape": list(variable.data.shape),
        }
        if variable.data.dtype.kind == "O":
            entry["values"] = variable.data.ravel().tolist()
        else:
            entry["offset"] = _append(file, variable.data, f"{group_path}/{name}".lstrip("/"), path)
        arrays[name] = entry
    return {"attributes": _plain_all(group.attributes), "axes": axes, "arrays": arrays}


def _append(file: BinaryIO, data: np.ndarray, name: str, path: Path) -> int:
    if data.dtype.kind in "iu" and data.size and max(abs(int(data.min())), abs(int(data.max()))) > INTEGER_LIMIT:
        raise InputError(
            f"'{name}' contains an integer beyond {INTEGER_LIMIT}, which float32 cannot represent", file=path
        )
    file.write(b"\0" * (-file.tell() % ALIGNMENT))
    offset = file.tell()
    file.write(np.ascontiguousarray(data, "<f4").tobytes())
    return offset


def _described(item: Axis | Variable) -> dict[str, Any]:
    return {"units": item.units, "long_name": item.long_name, "attributes": _plain_all(item.attributes)}


def _plain_all(attributes: dict[str, Any]) -> dict[str, Any]:
    return {
        name: _plain(value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value)
        for name, value in attributes.items()
    }


def _plain(value: Any) -> Any:
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def read_header(path: Path, form: str) -> tuple[dict[str, Any], Path]:
    """The JSON header of an export, and the file of its data beside it.

    Parameters
    ----------
    form : str
        The format that the header must name.

    Raises
    ------
    InputError
        The header is of another format or version, or too large, or the data have another size.
    OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError
        It is no such file.
    """
    refuse_special_file(path)
    if path.stat().st_size > HEADER_LIMIT:
        raise InputError(f"is larger than a header may be, {HEADER_LIMIT} bytes", file=path)
    header = json.loads(path.read_text(encoding="utf-8"))
    if header["format"] != form:
        raise InputError(f"contains {header['format']}; allowed: {form}; export the database again", file=path)
    check_version(path, header["format_version"])
    data = path.with_name(Path(header["data"]).name)
    refuse_special_file(data)
    if (size := data.stat().st_size) != header["bytes"]:
        raise InputError(f"has {size} bytes; its header says {header['bytes']}; export it again", file=data)
    return header, data


def read_raw(path: StrPath) -> tuple[Group, dict[str, Any]]:
    """Read a flat export; its float arrays stay on disk, memory-mapped.

    Returns
    -------
    root : Group
    attributes : dict
        The root attributes.

    Raises
    ------
    InputError
        A file is missing, is not of this format or version, or the two do not fit each other.
    """
    path = Path(path)
    try:
        header, data = read_header(path, FORMAT)
        flat = np.memmap(data, np.uint8, "r") if header["bytes"] else np.zeros(0, np.uint8)
        groups = {group_path: _read_group(entry, flat) for group_path, entry in header["groups"].items()}
        for group_path in sorted(groups, key=lambda p: -p.count("/")):
            if group_path:
                parent, _, name = group_path.rpartition("/")
                groups[parent].groups[name] = groups[group_path]
        return groups[""], header["groups"][""]["attributes"]
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        words = " ".join(f"{type(error).__name__} {error}".split())[:120]
        raise InputError(f"is not a flat export ({words}); export the database again", file=path) from None


def _read_group(entry: dict[str, Any], flat: np.ndarray) -> Group:
    axes = {
        name: Axis(np.array(a["values"], _dtype(a["type"])), a["units"], a["long_name"], a["attributes"])
        for name, a in entry["axes"].items()
    }
    variables = {
        name: Variable(tuple(v["axes"]), _array(v, flat), v["units"], v["long_name"], v["attributes"])
        for name, v in entry["arrays"].items()
    }
    return Group(axes, variables, {}, entry["attributes"])


def _dtype(kind: str) -> np.dtype:
    if kind not in ("text", "f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"):
        raise ValueError(f"unknown type {kind!r}")
    return np.dtype(object if kind == "text" else kind)


def _array(entry: dict[str, Any], flat: np.ndarray) -> np.ndarray:
    shape, kind = tuple(entry["shape"]), _dtype(entry["type"])
    if "values" in entry:
        return np.array(entry["values"], kind).reshape(shape)
    if not all(isinstance(n, int) and n >= 0 for n in (*shape, entry["offset"])):
        raise ValueError("shape and offset must be counts")
    size = 1
    for count in shape:
        size *= count
    stored = flat[entry["offset"] : entry["offset"] + 4 * size]
    if stored.size != 4 * size:
        raise ValueError("an array lies outside the data")
    values = stored.view("<f4").reshape(shape)
    return values if kind == np.dtype("f4") else values.astype(kind)
