"""Changes to the structure of an HDF5 file: arrays, attributes, dimension scales, storage, links."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

SCALE_ATTRIBUTES = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST")
UNREGISTERED_FILTER = 300  # of the range for tests, 256 to 511
UNREADABLE_TEXT = b"asphalt\xff\xfe\xc3"


def set_attribute(file: h5py.File, item: str, key: str, value: Any) -> None:
    """Write an attribute anew; `h5py.Empty` gives it no value."""
    attributes = file[item].attrs
    if key in attributes:
        del attributes[key]
    attributes.create(key, value)


def set_fixed_text(file: h5py.File, item: str, key: str, text: bytes, count: int = 0) -> None:
    """Write a text attribute of fixed length, as netCDF writers in C do; `count` of them where it is not 0."""
    value = np.array([text] * count if count else text, f"S{len(text) or 1}")
    set_attribute(file, item, key, value)


def set_middle(file: h5py.File, name: str, value: float) -> None:
    """Write one value of an array, in the midst of it."""
    values = file[name][()]
    values.flat[values.size // 2] = value
    file[name][...] = values


def more_attributes(file: h5py.File, name: str) -> None:
    """Give the file and an array forty attributes that no format knows."""
    for k in range(40):
        file.attrs[f"note_{k}"] = file[name].attrs[f"note_{k}"] = np.arange(k + 1)


def scales_of(file: h5py.File, name: str) -> list[str]:
    """Names of the dimension scales of an array, "" where an axis has none; of an array whose list is none, nothing."""
    if "DIMENSION_LIST" in file[name].attrs:
        kind = h5py.check_vlen_dtype(file[name].attrs.get_id("DIMENSION_LIST").dtype)
        if kind is None or h5py.check_ref_dtype(kind) is None:
            return []
    return [dim[0].name.lstrip("/") if len(dim) else "" for dim in file[name].dims]


def _users(file: h5py.File, axis: str) -> list[tuple[str, int]]:
    """Arrays of the axis' own group that it is a scale of, with the positions."""
    parent = file[axis].parent
    arrays = [item.name for item in parent.values() if isinstance(item, h5py.Dataset) and not item.is_scale]
    return [(name, k) for name in arrays for k, each in enumerate(scales_of(file, name)) if each == axis.lstrip("/")]


def replace(file: h5py.File, name: str, data: Any = None, *, scales: list[str] | None = None, **how: Any) -> None:
    """Make an array or axis anew, with the attributes and dimension scales that it had.

    Parameters
    ----------
    scales : list of str, optional
        Other dimension scales; "" for an axis without one.
    how
        As for `h5py.Group.create_dataset`; ``made`` where the array was already made under the name ``new``.
    """
    old = file[name]
    kept = {key: value for key, value in old.attrs.items() if key not in SCALE_ATTRIBUTES}
    axis = old.is_scale
    users = _users(file, name) if axis else []
    if not axis and scales is None:
        scales = scales_of(file, name)
    for array, k in users:
        file[array].dims[k].detach_scale(old)
    for k, scale in enumerate([] if axis else scales_of(file, name)):
        if scale:
            old.dims[k].detach_scale(file[scale])
    del file[name]
    if how.pop("made", False):
        file.move("new", name)
    else:
        file.create_dataset(name, data=data, **how)
    new = file[name]
    for key, value in kept.items():
        new.attrs[key] = value
    if axis:
        new.make_scale(name)
        for array, k in users:
            file[array].dims[k].attach_scale(new)
    for k, scale in enumerate(scales or []):
        if scale and k < new.ndim:
            new.dims[k].attach_scale(file[scale])


@contextmanager
def new_dataset(file: h5py.File, name: str, dtype: Any, shape: tuple[int, ...]) -> Iterator[h5py.h5p.PropDCID]:
    """Make an array anew with the low-level creation properties that the caller sets; it is left unwritten."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    yield properties
    kind = h5py.h5t.py_create(np.dtype(dtype), logical=True)
    h5py.h5d.create(file.id, b"new", kind, h5py.h5s.create_simple(shape), properties)
    replace(file, name, made=True)


def with_filter(file: h5py.File, name: str, *, claimed: bool) -> None:
    """Store an array through a filter that no reader has; optional, and truly applied only where it is `claimed`."""
    values = file[name][()]
    with new_dataset(file, name, values.dtype, values.shape) as properties:
        properties.set_chunk(values.shape)
        properties.set_filter(UNREGISTERED_FILTER, h5py.h5z.FLAG_OPTIONAL, (1, 2))
    file[name].id.write_direct_chunk((0,) * values.ndim, values.tobytes(), 0 if claimed else 1)


def damaged_chunk(file: h5py.File, name: str) -> None:
    """Flip bytes within the packed values."""
    packed = bytearray(file[name].id.read_direct_chunk((0,) * file[name].ndim)[1])
    packed[len(packed) // 2] ^= 0x5A
    file[name].id.write_direct_chunk((0,) * file[name].ndim, bytes(packed), 0)


def short_chunk(file: h5py.File, name: str) -> None:
    """Packed values that unpack to a quarter of the chunk."""
    import zlib

    values = file[name][()]
    replace(file, name, values, chunks=values.shape, compression="gzip")
    packed = zlib.compress(values.tobytes()[: values.nbytes // 4])
    file[name].id.write_direct_chunk((0,) * values.ndim, packed, 0)


def as_virtual(file: h5py.File, name: str, *, own: bool) -> None:
    """Make an array a view of another: of this file, or of one beside it that does not exist."""
    values = file[name]
    layout = h5py.VirtualLayout(values.shape, values.dtype)
    other = "." if own else "beside.h5"
    if own:
        file.create_dataset("hidden", data=values[()])
    layout[...] = h5py.VirtualSource(other, "hidden", values.shape, values.dtype)
    file.create_virtual_dataset("new", layout)
    replace(file, name, made=True)


def as_external(file: h5py.File, name: str) -> None:
    """Keep the values of an array in a raw file beside this one."""
    values = file[name][()]
    raw = Path(file.filename).with_suffix(".raw")
    values.tofile(raw)
    replace(file, name, shape=values.shape, dtype=values.dtype, external=[(raw.name, 0, values.nbytes)])


def as_external_link(file: h5py.File, name: str) -> None:
    """Move an array to a file beside this one."""
    other = Path(file.filename).with_suffix(".other.h5")
    with h5py.File(other, "w") as target:
        for each in {name, *scales_of(file, name)}:
            file.copy(each, target)
    del file[name]
    file[name] = h5py.ExternalLink(other.name, f"/{name}")


def linked_web(file: h5py.File, depth: int = 28) -> None:
    """Groups of two links each to the next one: 2^depth paths."""
    group = file.create_group("web")
    for _ in range(depth):
        following = group.create_group("a")
        group["b"] = following
        group = following


def deep_groups(file: h5py.File, depth: int = 400) -> None:
    group = file
    for _ in range(depth):
        group = group.create_group("g")


def flatten_dimension_list(file: h5py.File, name: str, value: Any) -> None:
    """Put something else in the place of the references to dimension scales."""
    dataset = file[name]
    del dataset.attrs["DIMENSION_LIST"]
    dataset.attrs["DIMENSION_LIST"] = value


def truncate(path: Path, share: float) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])


def with_user_block(path: Path, size: int = 512) -> None:
    """Put the bytes of another format before those of HDF5."""
    path.write_bytes(b"#!/bin/true\n".ljust(size, b"\0") + path.read_bytes())


def in_old_format(path: Path) -> None:
    """Write the arrays and axes of the root anew in the format of HDF5 1.6."""
    new = path.with_suffix(".new")
    with h5py.File(path) as source, h5py.File(new, "w", libver=("earliest", "v108")) as target:
        target.attrs.update(source.attrs)
        arrays = {name: item for name, item in source.items() if isinstance(item, h5py.Dataset)}
        for name, item in arrays.items():
            target.create_dataset(name, data=item[()], dtype=item.dtype)
            target[name].attrs.update({k: v for k, v in item.attrs.items() if k not in SCALE_ATTRIBUTES})
            if item.is_scale:
                target[name].make_scale(name)
        for name, item in arrays.items():
            for k, scale in enumerate([] if item.is_scale else scales_of(source, name)):
                target[name].dims[k].attach_scale(target[scale])
    os.replace(new, path)
