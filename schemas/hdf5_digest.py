"""The digest of a database: SHA-256 over its whole tree, whatever the way in which HDF5 stores it.

It covers groups, axes, arrays and all attributes but the digest itself. Each array of numbers enters with a digest of
its own (`array_digest`), which is had while the array is written.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from math import prod
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
import numpy.typing as npt

from skyshine.schemas.array_digest import block_shape, digest_of_bands
from skyshine.schemas.digest import feed
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5_gate import SCALE_ATTRIBUTES, refuse_large

if TYPE_CHECKING:
    from hashlib import _Hash

DIGEST = "content_sha256"
# Attribute of an array of which the file has the differences along these axes, each from the value before it, and the
# first value: sums of them are exact, and small numbers pack well.
DIFFERENCES = "differences"
PART_BYTES = 1 << 24  # read at a time where an array may be larger than memory
TEXT_LIMIT = 1024  # characters of one text of an array


def content_hash(file: h5py.File, digests: Mapping[str, bytes] | None = None) -> str:
    """SHA-256 over the content of a file, as 64 hexadecimal digits.

    Parameters
    ----------
    digests : mapping of str to bytes, optional
        Digests of arrays by their paths, so that these arrays are not read back.
    """
    digest = hashlib.sha256()
    _feed_group(digest, file, "", digests or {})
    return digest.hexdigest()


def digest_holds(file: h5py.File) -> bool:
    """Whether the content of a file is that of its digest."""
    return bool(content_hash(file) == as_text(file.attrs.get(DIGEST)))


def _feed_group(digest: _Hash, group: h5py.Group, path: str, digests: Mapping[str, bytes]) -> None:
    feed(digest, ("group", path, attributes_of(group, without=() if path else (DIGEST,))))
    items = sorted(group.items())
    named = axis_names(items)
    for name, item in items:
        inner = f"{path}/{name}"
        if isinstance(item, h5py.Group):
            _feed_group(digest, item, inner, digests)
            continue
        axes = ["axis"] if item.is_scale else ["array", *dims_of(item, named)]
        text = is_text(item)
        kind = "text" if text else item.dtype.newbyteorder("<").str
        feed(digest, (axes, inner, attributes_of(item), kind, list(item.shape)))
        if text:
            feed(digest, texts_of(item))
        else:
            digest.update(digests[inner] if inner in digests else _digest_of(item))


def _digest_of(dataset: h5py.Dataset) -> bytes:
    """Digest of an array of numbers, read a row of its blocks at a time."""
    shape = dataset.shape or (1,)
    return digest_of_bands(bands(dataset, block_shape(shape)[0]), shape)


def attributes_of(item: h5py.Group | h5py.Dataset, without: tuple[str, ...] = ()) -> dict[str, Any]:
    """Attributes of a group or an array, text decoded, without those by which HDF5 links axes."""
    left_out, attributes = {*SCALE_ATTRIBUTES, *without}, item.attrs
    # Those that are omitted are not read: references are slow.
    return {name: as_text(attributes[name]) for name in attributes if name not in left_out}


def as_text(value: Any) -> Any:
    """A value of an attribute; text of fixed length as that of variable length is."""
    return value.decode() if isinstance(value, bytes) else value


def axis_names(items: Iterable[tuple[str, h5py.Group | h5py.Dataset]]) -> dict[int, str]:
    """Names of the axes among the members of a group, by their addresses in the file; for `dims_of`."""
    return {_address(item.id): name for name, item in items if isinstance(item, h5py.Dataset) and item.is_scale}


def dims_of(dataset: h5py.Dataset, axes: Mapping[int, str] = MappingProxyType({})) -> tuple[str, ...]:
    """Names of a dataset's axes, by its dimension scales.

    Parameters
    ----------
    axes : mapping of int to str, optional
        `axis_names` of its group. For the name of another, HDF5 searches the whole file.
    """
    return tuple(_axis_of(dataset, number, axes) for number in range(len(dataset.dims)))


def _axis_of(dataset: h5py.Dataset, number: int, axes: Mapping[int, str]) -> str:
    if not h5py.h5ds.get_num_scales(dataset.id, number):
        return ""
    address = h5py.h5ds.iterate(dataset.id, number, _address)  # address of the first
    name: str = axes.get(address) or dataset.dims[number][0].name.rsplit("/", 1)[-1]
    return name


def _address(identifier: h5py.h5g.GroupID | h5py.h5d.DatasetID) -> int:
    address: int = h5py.h5o.get_info(identifier).addr
    return address


def is_text(dataset: h5py.Dataset) -> bool:
    """Whether an array contains text."""
    return h5py.check_string_dtype(dataset.dtype) is not None


def values_of(dataset: h5py.Dataset) -> npt.NDArray[Any]:
    """The whole array of a dataset: numbers, or text as str objects.

    Raises
    ------
    InputError
        It is larger than memory should be given for.
    """
    if is_text(dataset):
        return texts_of(dataset)
    refuse_large(dataset.file.filename, dataset.name, dataset.dtype.itemsize * prod(dataset.shape))
    values: npt.NDArray[Any] = np.asarray(dataset[()])
    if DIFFERENCES in dataset.attrs:
        names = dims_of(dataset)
        for axis in str(as_text(dataset.attrs[DIFFERENCES])).split():
            np.cumsum(values, axis=names.index(axis), dtype=values.dtype, out=values)
    return values


def texts_of(dataset: h5py.Dataset) -> npt.NDArray[np.object_]:
    """The texts of a dataset, of its shape.

    Raises
    ------
    InputError
        One is longer than `TEXT_LIMIT`.
    """
    texts: npt.NDArray[np.object_] = np.empty(dataset.shape, dtype=object)
    # A few at a time: damaged references may all lead to one long text.
    for start in range(0, dataset.shape[0] if dataset.shape else 1, 64):
        block = np.s_[start : start + 64] if dataset.shape else ()
        texts[block] = dataset.asstr()[block]
        longest = max(map(len, np.ravel(texts[block])), default=0)
        if longest > TEXT_LIMIT:
            raise InputError(
                f"'{dataset.name}' contains a text of {longest} characters; allowed: up to {TEXT_LIMIT}; shorten it",
                file=dataset.file.filename,
            )
    return texts


def parts(dataset: h5py.Dataset) -> Iterator[npt.NDArray[Any]]:
    """The values of a dataset in their order, whole rows of chunks at a time; each is valid until the next.

    Raises
    ------
    InputError
        A row of chunks is larger than memory should be given for.
    """
    if not dataset.chunks:
        yield np.asarray(values_of(dataset))
        return
    row, chunk = dataset.dtype.itemsize * prod(dataset.shape[1:]), dataset.chunks[0]
    yield from bands(dataset, max(chunk, PART_BYTES // max(row, 1) // chunk * chunk))


def bands(dataset: h5py.Dataset, step: int) -> Iterator[npt.NDArray[Any]]:
    """The values of a dataset in their order, `step` rows at a time; each is valid until the next.

    Raises
    ------
    InputError
        So many rows are larger than memory should be given for.
    """
    if not dataset.shape:
        yield np.atleast_1d(values_of(dataset))
        return
    rows = min(step, dataset.shape[0])
    refuse_large(dataset.file.filename, dataset.name, rows * dataset.dtype.itemsize * prod(dataset.shape[1:]))
    # One buffer for all parts: a row of chunks of a wide array is large itself.
    buffer = np.empty((rows, *dataset.shape[1:]), dataset.dtype)
    for start in range(0, dataset.shape[0], step or 1):
        part = buffer[: min(step, dataset.shape[0] - start)]
        if part.size:
            dataset.read_direct(part, np.s_[start : start + len(part)])
        yield part
