"""Writing and reading of the HDF5 databases: dimension scales, units, versions, hash, whole files or none.

The subset of HDF5 is the one that netCDF-4, xarray, C and browser readers share: default library version,
gzip with shuffle and Fletcher checksums, UTF-8 text (of variable length, but in attributes of arrays), creation order
kept, no times in the file. Small arrays lie in the headers, under the headers' checksums.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import prod
from pathlib import Path
from typing import Any, TypeAlias, cast

import h5py
import numpy as np
import numpy.typing as npt

from skyshine.schemas.array_digest import array_digest
from skyshine.schemas.errors import InputError
from skyshine.schemas.format_versions import FORMAT_VERSION, check_version
from skyshine.schemas.hdf5_digest import (
    DIFFERENCES,
    DIGEST,
    as_text,
    attributes_of,
    axis_names,
    content_hash,
    digest_holds,
    dims_of,
    is_text,
    values_of,
)
from skyshine.schemas.hdf5_gate import JOB_LIMIT, pass_gate
from skyshine.schemas.paths import StrPath
from skyshine.schemas.regular_files import refuse_special_file
from skyshine.schemas.whole_files import part_file

CONVENTIONS = "CF-1.11"
_CHUNK_VALUES = 1 << 18  # 1 MiB of floats, the cache that HDF5 has for the chunks of an array
# What CF knows of our arrays by name. The hour of the local clock, `time`, is no instant, and has none.
CF_NAMES = {
    "altitude": {"standard_name": "altitude", "positive": "up"},
    "wavelength": {"standard_name": "radiation_wavelength"},
    "sun_elevation": {"standard_name": "solar_elevation_angle"},
    "sun_azimuth": {"standard_name": "solar_azimuth_angle"},
}
ValueCheck: TypeAlias = Callable[[StrPath, str, npt.NDArray[Any]], None]  # path and name of the array, for messages


@dataclass(frozen=True)
class Axis:
    """One axis of a group: values (n,), kept as float64 unless they are integers or text."""

    values: Any
    units: str
    long_name: str
    attributes: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Streamed:
    """In place of the data of a variable that are too large for memory: they are written part by part."""

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
    def dtype(self) -> np.dtype[Any]:
        """Type of the numbers in `data`; of objects for text."""
        return np.asarray(self.data).dtype

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of `data`."""
        return np.shape(self.data)


@dataclass(frozen=True)
class StoredVariable:
    """A `Variable` of numbers whose array is read from its file when it is first asked for, and kept.

    Raises
    ------
    InputError
        From `data`: the file is gone, damaged, or has been built again since it was opened, or `check` refuses it.
    """

    path: Path
    name: str
    digest: str
    dims: tuple[str, ...]
    units: str
    long_name: str
    attributes: dict[str, Any]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    check: ValueCheck | None = None

    @cached_property
    def data(self) -> npt.NDArray[Any]:
        with _behind_gate(self.path) as file, sound(self.path):
            if as_text(file.attrs.get(DIGEST, "")) != self.digest:
                raise InputError("has been built again since it was opened; open it again", file=self.path)
            values = values_of(file[self.name])
        if self.check is not None:
            self.check(self.path, self.name, values)
        return values


@dataclass(frozen=True)
class Group:
    """Axes, arrays and further groups; a variable's axes are in its own group."""

    axes: dict[str, Axis] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)
    groups: dict[str, Group] = field(default_factory=dict)
    attributes: dict[str, Any] = field(default_factory=dict)


def type_name(dtype: np.dtype[Any]) -> str:
    """Name of a type of values in layouts and exports: `text`, or as numpy has it, without the order of bytes."""
    return "text" if dtype.kind in "UO" else dtype.str.lstrip("<>|=")


def unread(group: Group) -> Group:
    """The same content in dictionaries of its own, whose stored arrays are still in their file."""
    return Group(
        dict(group.axes),
        {
            name: cast(Variable, replace(variable)) if isinstance(variable, StoredVariable) else variable
            for name, variable in group.variables.items()
        },
        {name: unread(child) for name, child in group.groups.items()},
        dict(group.attributes),
    )


@dataclass(frozen=True)
class Filled:
    """What is in a file once its `Streamed` arrays are written.

    Attributes
    ----------
    rest : Group
        What else the root contains.
    known : dict of str to bytes
        Digests of `Streamed` arrays by their paths; the others are read back for theirs.
    """

    rest: Group
    known: dict[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Header:
    """What the root attributes of every database say of it."""

    filetype: str
    data_version: str
    job: str
    title: str = ""


def write_file(path: StrPath, root: Group, header: Header, fill: Callable[[h5py.File], Filled] | None = None) -> str:
    """Write a database whole: a part file first, renamed when it is complete.

    Parameters
    ----------
    fill : callable, optional
        Writes the `Streamed` arrays into the open file. The bytes of the file depend on the order of its writes: it
        writes each chunk once, always in the same order.

    Returns
    -------
    str
        The digest of the content, as written to ``content_sha256``; see `hdf5_digest`.

    Raises
    ------
    InputError
        The file cannot be written, or the job text is too long.
    """
    path = Path(path)
    if len(header.job.encode()) > JOB_LIMIT:
        raise InputError(f"the resolved job is longer than {JOB_LIMIT} bytes; split it into smaller jobs", file=path)
    part = part_file(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Made in memory unless it is streamed: HDF5 cannot close a file on a full disk without writing to standard
        # error. Not by its core driver, whose image has a wrong checksum before HDF5 2.0. What is streamed comes in
        # whole chunks, so that a cache of chunks for each array would only take memory.
        image = io.BytesIO()
        target, cache = (image, {}) if fill is None else (part, {"rdcc_nbytes": 0})
        # Everything that HDF5 1.10 keeps of arrays and groups has a checksum; the indexes of chunks before it have
        # none.
        with h5py.File(target, "w", libver=("v110", "v110"), track_order=True, **cache) as file:
            digests = _write_group(file, root)
            filled = Filled(Group()) if fill is None else fill(file)
            digests |= filled.known | _write_group(file, filled.rest)
            file.attrs.update(_root_attributes(header))
            digest = content_hash(file, digests)
            file.attrs[DIGEST] = digest
        if fill is None:
            part.write_bytes(image.getbuffer())
        os.replace(part, path)
    except (OSError, RuntimeError) as error:
        words = getattr(error, "strerror", None) or " ".join(str(error).split())[:160]
        raise InputError(f"cannot be written: {words}; check free space and permissions", file=path) from None
    finally:
        part.unlink(missing_ok=True)
    return digest


def _root_attributes(header: Header) -> dict[str, str]:
    from importlib import metadata  # slow to import, and readers need none

    return {
        "Conventions": CONVENTIONS,
        "title": header.title,
        "filetype": header.filetype,
        "format_version": FORMAT_VERSION,
        "data_version": header.data_version,
        "generator": f"skyshine {metadata.version('skyshine')}",
        "job": header.job,
    }


def _write_group(target: h5py.Group, group: Group) -> dict[str, bytes]:
    """Write a group; returns the digests of its arrays of numbers by their paths, but for those that are `Streamed`."""
    digests: dict[str, bytes] = {}
    for name, value in group.attributes.items():
        target.attrs[name] = value
    for name, axis in group.axes.items():
        dataset = _write_array(target, name, np.asarray(axis.values), axis, np.float64, None, digests)
        dataset.make_scale(name)
    for name, variable in group.variables.items():
        data = variable.data if isinstance(variable.data, Streamed) else np.asarray(variable.data)
        expected = tuple(target[dim].shape[0] for dim in variable.dims)
        if data.shape != expected:
            raise ValueError(f"{name} has shape {data.shape}; its axes {variable.dims} have {expected}")
        dataset = _write_array(target, name, data, variable, np.float32, variable.chunks, digests)
        for position, dim in enumerate(variable.dims):
            dataset.dims[position].attach_scale(target[dim])
    for name, child in group.groups.items():
        digests |= _write_group(target.create_group(name, track_order=True), child)
    return digests


_REFERENCE, _HEADER_LIMIT = 16, 60_000  # bytes of one to a text; that fit into a header, which has 64 KB
_MOST_ATTRIBUTES = 64  # largest number of attributes of an array that are kept in its header
_SMALL = 512  # bytes of an array that takes less room in its header than as a chunk of its own


def _describe(dataset: h5py.Dataset, attributes: Mapping[str, Any]) -> None:
    for name, value in attributes.items():
        text = value.encode() if isinstance(value, str) else b""
        if not 0 < len(text) <= _HEADER_LIMIT or b"\0" in text:
            dataset.attrs[name] = value
            continue
        # The text has a fixed length: a heap of texts takes far more room.
        kind = h5py.string_dtype("utf-8", len(text))
        dataset.attrs.create(name, np.array(text, kind), dtype=kind)


def _write_array(
    target: h5py.Group,
    name: str,
    data: npt.NDArray[Any] | Streamed,
    described: Axis | Variable,
    float_type: type[np.floating[Any]],
    chunks: tuple[int, ...] | None,
    digests: dict[str, bytes],
) -> h5py.Dataset:
    kind, attributes = np.dtype[Any](data.dtype), dict(described.attributes)
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    creation.set_attr_phase_change(_MOST_ATTRIBUTES, 0)
    if isinstance(data, np.ndarray) and kind.kind in "UO":
        # The library follows damaged references to text out of the file; within the header of the array they are under
        # its checksum.
        if _REFERENCE * data.size <= _HEADER_LIMIT:
            creation.set_layout(h5py.h5d.COMPACT)
        dataset = target.create_dataset(name, data=data.astype(object), dtype=h5py.string_dtype(), dcpl=creation)
    else:
        kind = np.dtype(float_type if kind.kind == "f" else kind).newbyteorder("<")
        content: dict[str, Any] = {"shape": data.shape}
        if not isinstance(data, Streamed):
            content = {"data": data.astype(kind, copy=False)}
            if isinstance(described, Variable) and DIFFERENCES in attributes:
                content["data"] = _differences(content["data"], described.dims, attributes)
            digests[f"{target.name.rstrip('/')}/{name}"] = array_digest(content["data"])
        filters: dict[str, Any] = {}
        if prod(data.shape) * kind.itemsize > _SMALL:
            shape = tuple(min(c, n) for c, n in zip(chunks or _chunk_shape(data.shape), data.shape, strict=True))
            filters = {
                "chunks": shape,
                "compression": "gzip",
                "compression_opts": 6,
                "shuffle": True,
                "fletcher32": True,
            }
        elif not isinstance(data, Streamed) and data.size:
            creation.set_layout(h5py.h5d.COMPACT)
        dataset = target.create_dataset(name, dtype=kind, dcpl=creation, **content, **filters)
        dataset.flush()  # its chunk has its place in the file now, not when the last reference to the array goes
    described_as = {"units": described.units, "long_name": described.long_name}
    _describe(dataset, described_as | CF_NAMES.get(name, {}) | attributes)
    return dataset


def _differences(values: npt.NDArray[Any], dims: tuple[str, ...], attributes: dict[str, Any]) -> npt.NDArray[Any]:
    """Differences of an array along the axes that its attribute names; the array itself, without the attribute, where
    their sums do not give it exactly.
    """
    axes = [dims.index(name) for name in attributes[DIFFERENCES].split()]
    parts = values
    for axis in axes:
        parts = np.diff(parts, axis=axis, prepend=parts.dtype.type(0))
    sums = parts
    for axis in axes:
        sums = np.cumsum(sums, axis=axis, dtype=values.dtype)
    if np.array_equal(sums, values):
        return parts
    del attributes[DIFFERENCES]
    return values


def _chunk_shape(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Chunks of up to `_CHUNK_VALUES`, whole along the last axes: smaller ones, as h5py takes them, pack worse."""
    chunk, room = [], _CHUNK_VALUES
    for length in reversed(shape):
        chunk.append(max(1, min(length, room)))
        room //= chunk[-1]
    return tuple(reversed(chunk))


def open_database(path: StrPath, filetype: str | None = None) -> h5py.File:
    """Open a database for reading, behind the gate of `hdf5_gate`, and check what it is.

    Raises
    ------
    InputError
        The file is missing, damaged or hostile, is of another type, or has another major version of the format.
    """
    file = _behind_gate(path)
    try:
        with sound(path):
            _check_kind(file, path, filetype)
    except BaseException:
        file.close()
        raise
    return file


def _behind_gate(path: StrPath) -> h5py.File:
    refuse_special_file(path, "check the path, or build it with 'mat build'")
    try:
        file = h5py.File(path, "r")
    except OSError:
        raise InputError(
            "is not a readable HDF5 file (damaged or of another kind); build it again", file=path
        ) from None
    try:
        with sound(path):
            pass_gate(path, file)
    except BaseException:
        file.close()
        raise
    return file


def _check_kind(file: h5py.File, path: StrPath, filetype: str | None) -> None:
    name = as_text(file.attrs.get("filetype"))
    if name is None or (filetype is not None and name != filetype):
        expected = f"'{filetype}'" if filetype else "a database of skyshine"
        raise InputError(f"contains {name!r}; allowed: {expected}; name another file", file=path)
    check_version(path, as_text(file.attrs.get("format_version")))


def is_current(path: StrPath, header: Header, also: Callable[[h5py.File], bool] | None = None) -> bool:
    """Whether a file is there, undamaged, of this program and with the type, versions and job of a header.

    Parameters
    ----------
    also : callable, optional
        A further condition, which may raise InputError, OSError or KeyError where it is not met.
    """
    expected = _root_attributes(header)
    try:
        with open_database(path, header.filetype) as file, sound(path):
            return (
                all(file.attrs.get(name) == value for name, value in expected.items() if name != "title")
                and (also is None or also(file))
                and digest_holds(file)
            )
    except (InputError, OSError, KeyError):
        return False


def read_file(
    path: StrPath,
    filetype: str | None = None,
    *,
    lazy: bool = False,
    verify: bool = False,
    check_values: ValueCheck | None = None,
) -> tuple[Group, dict[str, Any]]:
    """Read a database; see `open_database` for what it raises.

    Parameters
    ----------
    lazy : bool
        Leave the numbers in the file until they are first asked for; the axes and the text are read.
    verify : bool
        Check the digest of the content too.
    check_values : callable, optional
        Raises InputError where an array is filled as none may be; arrays are checked when they are read, thus with
        `lazy` alone.

    Returns
    -------
    root : Group
    attributes : dict
        The root attributes.

    Raises
    ------
    InputError
        A part of the file is damaged, or the content is not that of the digest.
    """
    with open_database(path, filetype) as file, sound(path):
        attributes = {key: as_text(value) for key, value in file.attrs.items()}
        digest = str(attributes.get(DIGEST, ""))
        if verify and not digest_holds(file):
            raise InputError(f"{DIGEST} does not match: the file was changed or damaged; build it again", file=path)

        def array(
            item: h5py.Dataset, dims: tuple[str, ...], units: str, long_name: str, extra: dict[str, Any]
        ) -> Variable:
            if lazy and not is_text(item):
                stored = StoredVariable(
                    Path(path),
                    item.name,
                    digest,
                    dims,
                    units,
                    long_name,
                    extra,
                    item.shape,
                    item.dtype,
                    check_values,
                )
                return cast(Variable, stored)  # which it reads as
            return Variable(dims, values_of(item), units, long_name, extra)

        return _read_group(file, array), attributes


@contextmanager
def sound(path: StrPath) -> Iterator[None]:
    """Report what a damaged file makes the HDF5 library say as one clear line."""
    try:
        yield
    except (
        OSError,
        KeyError,
        RuntimeError,
        ValueError,
        TypeError,
        AttributeError,
        IndexError,
        MemoryError,
        OverflowError,
        SystemError,
    ) as error:
        words = " ".join(str(error).split())[:120]
        raise InputError(f"is damaged ({words}); build it again", file=path) from None


def _read_group(source: h5py.Group, array: Callable[..., Variable]) -> Group:
    axes: dict[str, Axis] = {}
    variables: dict[str, Variable] = {}
    groups: dict[str, Group] = {}
    items = list(source.items())
    named = axis_names(items)
    for name, item in items:
        if isinstance(item, h5py.Group):
            groups[name] = _read_group(item, array)
            continue
        attributes = attributes_of(item, without=("_FillValue", DIFFERENCES))
        units, long_name = (attributes.pop(key, "") for key in ("units", "long_name"))
        if item.is_scale:
            axes[name] = Axis(values_of(item), units, long_name, attributes)
        else:
            variables[name] = array(item, dims_of(item, named), units, long_name, attributes)
    return Group(axes, variables, groups, attributes_of(source))
