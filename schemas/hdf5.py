"""Writing and reading of the HDF5 databases: dimension scales, units, versions, hash, whole files or none.

The subset of HDF5 is the one that netCDF-4, xarray, C, Rust and JavaScript readers share: default library version,
gzip with shuffle and Fletcher checksums, variable-length UTF-8 text, creation order kept, no times in the file.
"""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5_heaps import refuse_endless_heaps

CONVENTIONS = "CF-1.11"
JOB_LIMIT = 16_000_000  # bytes; variable-length text stands outside of its attribute, which holds less than 64 KiB
PART = ".skyshine-part"  # ends the names of files that are not yet whole; no file of a user ends so
PART_BYTES = 1 << 24  # read at a time where an array may be larger than memory
DEPTH_LIMIT = 16  # of groups in groups
# Deflate packs at most 1032 bytes into one (zlib technical details); a file that claims more holds a forged shape.
PACKING_LIMIT, SMALL = 1100, 1 << 20
_SCALE_ATTRIBUTES = {
    "CLASS",
    "NAME",
    "REFERENCE_LIST",
    "DIMENSION_LIST",
    "_Netcdf4Dimid",
    "_Netcdf4Coordinates",
    "_FillValue",
}


@dataclass(frozen=True)
class Axis:
    """One axis of a group: values (n,), kept as float64 unless they are integers or text."""

    values: Any
    units: str
    long_name: str
    attributes: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Streamed:
    """Stands for the data of a variable that are too large for memory: they are written part by part."""

    shape: tuple[int, ...]
    dtype: Any


@dataclass(frozen=True)
class Variable:
    """One array of a group on named axes: floats are kept as float32, integers and text as they are."""

    dims: tuple[str, ...]
    data: Any
    units: str
    long_name: str
    attributes: dict[str, Any] = field(default_factory=dict)
    chunks: tuple[int, ...] | None = None

    @property
    def kind(self) -> str:
        """Kind of number in `data`, as numpy names it; O for text."""
        return np.asarray(self.data).dtype.kind


@dataclass(frozen=True)
class StoredVariable:
    """A `Variable` of floats whose array is read from its file when it is first asked for, and kept.

    Raises
    ------
    InputError
        From `data`: the file is gone, damaged, or has been built again since it was opened.
    """

    path: Path
    name: str
    digest: str
    dims: tuple[str, ...]
    units: str
    long_name: str
    attributes: dict[str, Any]
    kind = "f"

    @cached_property
    def data(self) -> np.ndarray:
        with open_database(self.path) as file, sound(self.path):
            if _text(file.attrs.get("content_sha256", "")) != self.digest:
                raise InputError("has been built again since it was opened; open it again", file=self.path)
            return _bounded(file, file[self.name])


@dataclass(frozen=True)
class Group:
    """Axes, arrays and further groups; a variable's axes stand in its own group."""

    axes: dict[str, Axis] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)
    groups: dict[str, Group] = field(default_factory=dict)
    attributes: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Header:
    """What the root attributes of every database say of it."""

    filetype: str
    format_version: str
    data_version: str
    job: str
    title: str = ""


def write_file(
    path: str | os.PathLike, root: Group, header: Header, fill: Callable[[h5py.File], Group] | None = None
) -> str:
    """Write a database whole: a part file first, renamed when it is complete.

    Parameters
    ----------
    fill : callable, optional
        Writes the `Streamed` arrays into the open file, and returns what else the root holds. The bytes of the file
        depend on the order of its writes: it writes each chunk once, always in the same order.

    Returns
    -------
    str
        The SHA-256 over the decoded arrays, as written to ``content_sha256``.

    Raises
    ------
    InputError
        The file cannot be written, or the job text is too long for an attribute.
    """
    path = Path(path)
    if len(header.job.encode()) > JOB_LIMIT:
        raise InputError(f"the resolved job is longer than {JOB_LIMIT} bytes; split it into smaller jobs", file=path)
    part = part_file(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Made in memory, packed, unless it is streamed: HDF5 cannot close a file on a full disk without writing to
        # standard error. What is streamed comes in whole chunks, so that a cache of chunks for each array would only
        # hold memory.
        how = {"driver": "core", "backing_store": False} if fill is None else {"rdcc_nbytes": 0}
        # Everything that HDF5 1.10 keeps of arrays and groups has a checksum; the indexes of chunks before it have
        # none.
        with h5py.File(part, "w", libver=("v110", "v110"), track_order=True, **how) as file:
            _write_group(file, root)
            if fill is not None:
                _write_group(file, fill(file))
            digest = content_hash(file)
            file.attrs.update(_root_attributes(header, digest))
            file.flush()
            image = file.id.get_file_image() if fill is None else None
        if image is not None:
            part.write_bytes(image)
        os.replace(part, path)
    except (OSError, RuntimeError) as error:
        words = getattr(error, "strerror", None) or " ".join(str(error).split())[:160]
        raise InputError(f"cannot be written: {words}; check space and rights", file=path) from None
    finally:
        part.unlink(missing_ok=True)
    return digest


def part_file(path: Path) -> Path:
    """Name under which this process writes a file until it is complete; unlike that of any other process or machine."""
    return path.with_name(f".{path.name}.{platform.node()}.{os.getpid()}{PART}")


def write_whole(path: Path, text: str) -> None:
    """Write a text file whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    part = part_file(path)
    try:
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}; check space and rights", file=path) from None
    finally:
        part.unlink(missing_ok=True)


def _root_attributes(header: Header, digest: str) -> dict[str, str]:
    return {
        "Conventions": CONVENTIONS,
        "title": header.title,
        "filetype": header.filetype,
        "format_version": header.format_version,
        "data_version": header.data_version,
        "generator": f"skyshine {metadata.version('skyshine')}",
        "job": header.job,
        "content_sha256": digest,
    }


def _write_group(target: h5py.Group, group: Group) -> None:
    for name, value in group.attributes.items():
        target.attrs[name] = value
    for name, axis in group.axes.items():
        dataset = _write_array(target, name, np.asarray(axis.values), axis, np.float64, None)
        dataset.make_scale(name)
    for name, variable in group.variables.items():
        data = variable.data if isinstance(variable.data, Streamed) else np.asarray(variable.data)
        expected = tuple(target[dim].shape[0] for dim in variable.dims)
        if data.shape != expected:
            raise ValueError(f"{name} has shape {data.shape}; its axes {variable.dims} have {expected}")
        dataset = _write_array(target, name, data, variable, np.float32, variable.chunks)
        for position, dim in enumerate(variable.dims):
            dataset.dims[position].attach_scale(target[dim])
    for name, child in group.groups.items():
        _write_group(target.create_group(name, track_order=True), child)


_REFERENCE, _COMPACT_LIMIT = 16, 60_000  # bytes of one to a text; that fit into a header, which holds 64 KB


def _write_array(target, name, data, described, float_type, chunks) -> h5py.Dataset:
    kind = np.dtype(data.dtype)
    if kind.kind in "UO":
        # The library follows damaged references to text out of the file; within the header of the array they are under
        # its checksum.
        place = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        if _REFERENCE * data.size <= _COMPACT_LIMIT:
            place.set_layout(h5py.h5d.COMPACT)
        dataset = target.create_dataset(
            name, data=data.astype(object), dtype=h5py.string_dtype(), track_order=True, dcpl=place
        )
    else:
        kind = np.dtype(float_type if kind.kind == "f" else kind).newbyteorder("<")
        content = {"shape": data.shape} if isinstance(data, Streamed) else {"data": data.astype(kind, copy=False)}
        filters = {}
        if np.prod(data.shape) > 1:
            shape = tuple(min(c, n) for c, n in zip(chunks, data.shape, strict=True)) if chunks else True
            filters = {
                "chunks": shape,
                "compression": "gzip",
                "compression_opts": 4,
                "shuffle": True,
                "fletcher32": True,
            }
        dataset = target.create_dataset(name, dtype=kind, track_order=True, **content, **filters)
    dataset.attrs["units"] = described.units
    dataset.attrs["long_name"] = described.long_name
    for key, value in described.attributes.items():
        dataset.attrs[key] = value
    return dataset


def content_hash(file: h5py.File) -> str:
    """SHA-256 over names, types, shapes and decoded values of all arrays, in the order of their names."""
    names: list[str] = []
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    digest = hashlib.sha256()
    for name in sorted(names):
        dataset = file[name]
        _refuse_forged(file, dataset)
        text = h5py.check_string_dtype(dataset.dtype) is not None
        kind = "text" if text else dataset.dtype.newbyteorder("<").str
        digest.update(f"{name}\0{kind}\0{dataset.shape}\0{dataset.attrs.get('units', '')}\0".encode())
        if text:
            digest.update("\0".join(_decoded(dataset).ravel().tolist()).encode())
        else:
            for part in _parts(dataset):
                digest.update(np.ascontiguousarray(part, dtype=part.dtype.newbyteorder("<")))
            del part  # before the next array's buffer
    return digest.hexdigest()


def _parts(dataset: h5py.Dataset) -> Iterator[np.ndarray]:
    """The values of a dataset in their order, whole rows of chunks at a time; each is valid until the next."""
    if not dataset.chunks:
        yield np.asarray(dataset[()])
        return
    row = dataset.dtype.itemsize * int(np.prod(dataset.shape[1:]))
    step = max(dataset.chunks[0], PART_BYTES // max(row, 1) // dataset.chunks[0] * dataset.chunks[0])
    # One buffer for all parts: a row of chunks of a wide array is large itself.
    kept = np.empty((min(step, dataset.shape[0]), *dataset.shape[1:]), dataset.dtype)
    for start in range(0, dataset.shape[0], step):
        part = kept[: min(step, dataset.shape[0] - start)]
        if part.size:
            dataset.read_direct(part, np.s_[start : start + len(part)])
        yield part


def _decoded(dataset: h5py.Dataset) -> np.ndarray:
    if h5py.check_string_dtype(dataset.dtype) is not None:
        return np.asarray(dataset.asstr()[()], dtype=object)
    return dataset[()]


def open_database(path: str | os.PathLike, filetype: str | None = None, major: int | None = None) -> h5py.File:
    """Open a database for reading and check what it is.

    Raises
    ------
    InputError
        The file is missing or damaged, is of another type, or has a layout of another major version.
    """
    try:
        refuse_endless_heaps(path)
        file = h5py.File(path, "r")
    except FileNotFoundError:
        raise InputError("does not exist; check the path, or build it with 'mat build'", file=path) from None
    except IsADirectoryError:
        raise InputError("is a folder; name one of the files in it", file=path) from None
    except OSError:
        raise InputError(
            "is not a readable HDF5 file (damaged or of another kind); build it again", file=path
        ) from None
    try:
        with sound(path):
            _check_kind(file, path, filetype, major)
    except InputError:
        file.close()
        raise
    return file


def _check_kind(file: h5py.File, path: str | os.PathLike, filetype: str | None, major: int | None) -> None:
    found, version = (_text(file.attrs.get(name)) for name in ("filetype", "format_version"))
    if found is None or (filetype is not None and found != filetype):
        wanted = f"'{filetype}'" if filetype else "a database of skyshine"
        raise InputError(f"holds {found!r}; allowed: {wanted}; name another file", file=path)
    if major is not None:
        check_version(path, str(found), str(version), major)


def check_version(path: str | os.PathLike, filetype: str, version: str, major: int) -> None:
    """Refuse a layout of another major version, and say how to convert it.

    Raises
    ------
    InputError
    """
    held = version.split(".")[0]
    if held == str(major):
        return
    remedy = f"build it again from its job with 'mat build --fresh' to convert it to {major}.x"
    if held.isdecimal() and int(held) > major:
        remedy = f"upgrade skyshine to one whose {filetype} format is {held}.x, or {remedy}"
    raise InputError(f"has format_version {version!r}; this reader reads {major}.x; {remedy}", file=path)


def read_file(
    path: str | os.PathLike, filetype: str | None = None, major: int | None = None, *, lazy: bool = False
) -> tuple[Group, dict]:
    """Read a database; see `open_database` for what it raises.

    Parameters
    ----------
    lazy : bool
        Leave the arrays in the file until they are first asked for; the axes and the text are read.

    Returns
    -------
    root : Group
    attributes : dict
        The root attributes.

    Raises
    ------
    InputError
        A part of the file is damaged, or claims a size that its bytes cannot hold.
    """
    with open_database(path, filetype, major) as file, sound(path):
        attributes = {key: _text(value) for key, value in file.attrs.items()}
        digest = str(attributes.get("content_sha256", ""))

        def variable(item: h5py.Dataset, units: str, long_name: str, extra: dict) -> Variable | StoredVariable:
            if lazy and item.dtype.kind == "f":
                return StoredVariable(Path(path), item.name, digest, dims_of(item), units, long_name, extra)
            return Variable(dims_of(item), _bounded(file, item), units, long_name, extra)

        return _read_group(file, variable), attributes


@contextmanager
def sound(path: str | os.PathLike):
    """Report what a damaged file makes the HDF5 library say as one clear line."""
    try:
        yield
    except (OSError, KeyError, RuntimeError, ValueError, TypeError, AttributeError, IndexError) as error:
        words = " ".join(str(error).split())[:120]
        raise InputError(f"is damaged ({words}); build it again", file=path) from None


def _bounded(file: h5py.File, dataset: h5py.Dataset) -> np.ndarray:
    """The array of a dataset, unless its shape is forged."""
    _refuse_forged(file, dataset)
    return _decoded(dataset)


def _refuse_forged(file: h5py.File, dataset: h5py.Dataset) -> None:
    """Raise InputError where a dataset claims more bytes than its file can hold."""
    if file.mode != "r":  # about to be written: there may be no file yet
        return
    claimed, held = dataset.size * dataset.dtype.itemsize, os.path.getsize(file.filename)
    if claimed > PACKING_LIMIT * held + SMALL:
        raise InputError(
            f"'{dataset.name}' claims {claimed} bytes, and the file has {held}; allowed: at most {PACKING_LIMIT} times"
            " that; build it again",
            file=file.filename,
        )


def _read_group(source: h5py.Group, variable: Callable, depth: int = 0) -> Group:
    if depth > DEPTH_LIMIT:
        raise ValueError(f"groups are nested deeper than {DEPTH_LIMIT}")
    axes, variables, groups = {}, {}, {}
    for name, item in source.items():
        if isinstance(item, h5py.Group):
            groups[name] = _read_group(item, variable, depth + 1)
            continue
        if not isinstance(item, h5py.Dataset):
            raise TypeError(f"'{name}' is neither a group nor an array")
        extra = {k: _text(v) for k, v in item.attrs.items() if k not in _SCALE_ATTRIBUTES | {"units", "long_name"}}
        units, long_name = _text(item.attrs.get("units", "")), _text(item.attrs.get("long_name", ""))
        if item.is_scale:
            axes[name] = Axis(_bounded(item.file, item), units, long_name, extra)
        else:
            variables[name] = variable(item, units, long_name, extra)
    return Group(axes, variables, groups, {k: _text(v) for k, v in source.attrs.items()})


def dims_of(dataset: h5py.Dataset) -> tuple[str, ...]:
    """Names of a dataset's axes, by its dimension scales."""
    return tuple(dim[0].name.rsplit("/", 1)[-1] if len(dim) else "" for dim in dataset.dims)


def _text(value: Any) -> Any:
    return value.decode() if isinstance(value, bytes) else value
