"""Checking a database: layout, versions, units, finite values, physical laws, digest."""

from __future__ import annotations

import h5py
import numpy as np

from skyshine.mat.tables.laws import broken_laws, broken_texture_laws
from skyshine.mat.tables.stored_layout import layout_problems
from skyshine.schemas.hdf5 import open_database, read_file, sound
from skyshine.schemas.hdf5_digest import digest_holds, is_text, parts
from skyshine.schemas.paths import StrPath


def problems(path: StrPath) -> list[str]:
    """All that is wrong with a database; an empty list where nothing is.

    Raises
    ------
    InputError
        The file is missing or is not a database at all.
    """
    with open_database(path) as file, sound(path):
        root, attributes = read_file(path, lazy=True)
        lines = [*layout_problems(root, attributes), *_value_problems(file)]
        if attributes["filetype"] == "tmm":
            lines += broken_texture_laws(file)
        else:
            lines += broken_laws(str(attributes["filetype"]), root)
        if not digest_holds(file):
            lines.append("content_sha256 does not match the content: the file was changed or damaged")
    return lines


def _value_problems(file: h5py.File) -> list[str]:
    lines: list[str] = []

    def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
        if not isinstance(item, h5py.Dataset) or is_text(item):
            return
        if item.dtype.kind == "f" and "accuracy/" not in name:
            wrong = sum(np.count_nonzero(~np.isfinite(part)) for part in parts(item))
            if wrong:
                lines.append(f"{name}: {wrong} values are not finite")
        if item.is_scale and np.any(np.diff(item[()].astype(float)) <= 0):
            lines.append(f"{name}: the axis is not strictly ascending")

    file.visititems(visit)
    return lines
