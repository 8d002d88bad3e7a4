"""Checks of every HDF5 file before a value of it is read: bounded in objects and bytes, without parts in other files.

The gate reads headers alone. It refuses links that lead elsewhere or in circles, storage outside the file, arrays whose
size their bytes cannot contain, axes that do not fit, and attributes of another type or shape than the formats have.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from math import prod
from typing import Any

import h5py

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5_heaps import largest_text
from skyshine.schemas.paths import StrPath
from skyshine.schemas.plain_numbers import plain_number

OBJECT_LIMIT = 20_000  # groups and arrays of a file; a texture of 17 levels has 150
DEPTH_LIMIT = 16  # depth limit of groups in groups
RANK_LIMIT = 8  # axes of an array
ATTRIBUTE_LIMIT = 10_000  # attribute limit of one object; a texture has one for each of its seed files
ATTRIBUTE_BYTES = 1 << 20  # 1 MiB
SHORT_TEXT = 4096  # characters of an attribute that is one line
JOB_LIMIT = 16_000_000  # bytes of a job's text, those of a job file at most
CHUNK_BYTES = 1 << 28  # 256 MiB
# Deflate packs at most 1032 bytes into one (zlib technical details); a file that claims more contains a forged shape.
PACKING_LIMIT, SMALL = 1100, 1 << 20
ARRAY_LIMIT_VARIABLE, ARRAY_LIMIT_GIB = "SKYSHINE_MAX_ARRAY_GIB", 4.0
READ_BY_ROWS = ("tmm",)  # file types whose arrays may be larger than memory

ROOT_TEXTS = {
    "Conventions",
    "title",
    "filetype",
    "format_version",
    "data_version",
    "generator",
    "job",
    "content_sha256",
}
TEXTS = {"units", "long_name", "interpolation", "out_of_range", "comment", "coordinates", "differences"}
NUMBERS = {"period", "add_offset", "scale_factor", "total"}
SCALE_ATTRIBUTES = {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "_Netcdf4Dimid", "_Netcdf4Coordinates"}
_LINKED = {"DIMENSION_LIST": h5py.h5t.VLEN, "REFERENCE_LIST": h5py.h5t.COMPOUND}
_NUMERIC = (h5py.h5t.INTEGER, h5py.h5t.FLOAT)
_ITEM_BYTES = {h5py.h5t.INTEGER: (1, 2, 4, 8), h5py.h5t.FLOAT: (4, 8)}
_FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)
_LAYOUTS = (h5py.h5d.COMPACT, h5py.h5d.CONTIGUOUS, h5py.h5d.CHUNKED)


def array_limit() -> int:
    """Bytes that one array may take in memory."""
    text = os.environ.get(ARRAY_LIMIT_VARIABLE, "")
    try:
        gib = plain_number(text) if text else ARRAY_LIMIT_GIB
    except ValueError:
        gib = -1.0
    if not 0 < gib < 1 << 20:
        raise InputError(f"{ARRAY_LIMIT_VARIABLE}: found '{text[:40]}'; allowed: a number of GiB above 0; correct it")
    return int(gib * (1 << 30))


def refuse_large(path: StrPath, name: str, size: int) -> None:
    """Refuse an array of `size` bytes before memory is taken for it.

    Raises
    ------
    InputError
        It is larger than `array_limit`.
    """
    if size > array_limit():
        raise InputError(
            f"'{name}' takes {size} bytes of memory; allowed: {array_limit()}; if the file is trusted, set"
            f" {ARRAY_LIMIT_VARIABLE} to {-(-size // (1 << 30))}",
            file=path,
        )


@dataclass
class _Group:
    """A group that is still to be looked into."""

    id: Any
    path: str
    depth: int


@dataclass
class Gate:
    """Walks through a file once, each object once.

    Attributes
    ----------
    path : path
        Named in messages.
    text_bytes : int
        No text in the file is longer; see `hdf5_heaps.largest_text`.
    """

    path: StrPath
    file: h5py.File
    text_bytes: int
    by_rows: bool = False
    stored: int = 0
    addresses: set[int] = field(default_factory=set)
    waiting: list[_Group] = field(default_factory=list)

    def check(self) -> None:
        """Check all of the file.

        Raises
        ------
        InputError
            Something is not as the formats have it.
        """
        if self.text_bytes > JOB_LIMIT:
            raise self._refuse("", f"contains a text of {self.text_bytes} bytes", f"texts of up to {JOB_LIMIT} bytes")
        self._attributes(self.file.id, "", root=True)
        self.by_rows = self.file.attrs.get("filetype") in READ_BY_ROWS
        self._enter(self.file["/"].id, "", 0)
        while self.waiting:
            self._group(self.waiting.pop())

    def _refuse(self, path: str, problem: str, allowed: str) -> InputError:
        return InputError(
            f"'/{path}' {problem}; allowed: {allowed}; build the file again, or get it from its source", file=self.path
        )

    def _enter(self, group: Any, path: str, depth: int) -> None:
        self._once(group, path)
        if depth > DEPTH_LIMIT:
            raise self._refuse(path, f"lies {depth} groups deep", f"groups nested up to {DEPTH_LIMIT} deep")
        self.waiting.append(_Group(group, path, depth))

    def _once(self, item: Any, path: str) -> None:
        address = h5py.h5o.get_info(item).addr
        if address in self.addresses:
            raise self._refuse(path, "is a second link to the same object", "one link to each group and array")
        self.addresses.add(address)
        if len(self.addresses) > OBJECT_LIMIT:
            raise self._refuse(path, f"is object {len(self.addresses)} of the file", f"at most {OBJECT_LIMIT} objects")

    def _links(self, group: _Group) -> list[str]:
        names: list[str] = []

        def note(name: bytes, info: Any) -> bool | None:
            text = name.decode("utf-8", "replace")
            path = f"{group.path}/{text}".lstrip("/")
            if info.type != h5py.h5l.TYPE_HARD:
                problems.append(self._refuse(path, "is a soft or external link", "groups and arrays of this file"))
            elif len(names) + len(self.addresses) >= OBJECT_LIMIT:
                problems.append(self._refuse(path, "is one link too many", f"at most {OBJECT_LIMIT} objects"))
            else:
                names.append(text)
            return True if problems else None

        problems: list[InputError] = []
        group.id.links.iterate(note, info=True)
        if problems:
            raise problems[0]
        return names

    def _group(self, group: _Group) -> None:
        arrays: dict[str, Any] = {}
        for name in self._links(group):
            path = f"{group.path}/{name}".lstrip("/")
            item = h5py.h5o.open(group.id, name.encode())
            if isinstance(item, h5py.h5g.GroupID):
                self._enter(item, path, group.depth + 1)
            elif isinstance(item, h5py.h5d.DatasetID):
                self._once(item, path)
                self._storage(item, path)
                arrays[name] = item
            else:
                raise self._refuse(path, "is a named type", "groups and arrays")
            self._attributes(item, path)
        axes = {
            h5py.h5o.get_info(item).addr: item.shape[0]
            for name, item in arrays.items()
            if self._is_axis(item, f"{group.path}/{name}".lstrip("/"))
        }
        for name, item in arrays.items():
            if h5py.h5o.get_info(item).addr not in axes:
                self._axes_fit(item, f"{group.path}/{name}".lstrip("/"), axes)

    def _storage(self, item: Any, path: str) -> None:
        kind, space = item.get_type(), item.get_space()
        text = kind.get_class() == h5py.h5t.STRING and kind.is_variable_str()
        if not text and kind.get_size() not in _ITEM_BYTES.get(kind.get_class(), ()):
            raise self._refuse(path, f"contains values of type {kind.dtype}", "integers, floats and text")
        if space.get_simple_extent_type() == h5py.h5s.NULL or len(item.shape) > RANK_LIMIT:
            raise self._refuse(path, f"has shape {item.shape}", f"arrays of up to {RANK_LIMIT} axes")
        how = item.get_create_plist()
        if how.get_layout() not in _LAYOUTS or how.get_external_count():
            raise self._refuse(path, "is stored outside the file (external or virtual)", "arrays stored in the file")
        filters = [how.get_filter(number)[0] for number in range(how.get_nfilters())]
        if not set(filters) <= set(_FILTERS) or len(filters) > len(_FILTERS):
            raise self._refuse(path, f"is packed by filters {filters}", f"each of {list(_FILTERS)} once")
        size = kind.get_size() * prod(item.shape)
        chunk = kind.get_size() * prod(how.get_chunk()) if how.get_layout() == h5py.h5d.CHUNKED else 0
        packing = PACKING_LIMIT if h5py.h5z.FILTER_DEFLATE in filters else 1
        there = item.get_storage_size()
        self.stored += there
        file_bytes = os.path.getsize(self.path)
        if size > packing * there + SMALL or self.stored > file_bytes:
            raise self._refuse(
                path,
                f"claims {size} bytes, and {there} of the file's {file_bytes} are its own",
                f"{packing} times that",
            )
        if chunk > CHUNK_BYTES:
            raise self._refuse(path, f"is stored in chunks of {chunk} bytes", f"chunks of up to {CHUNK_BYTES} bytes")
        if not self.by_rows:
            refuse_large(self.path, f"/{path}", size)

    def _is_axis(self, item: Any, path: str) -> bool:
        axis = b"CLASS" in _names(item) and h5py.h5ds.is_scale(item)
        if axis and len(item.shape) != 1:
            raise self._refuse(path, f"is an axis of shape {item.shape}", "axes of one dimension")
        return bool(axis)

    def _axes_fit(self, item: Any, path: str, axes: dict[int, int]) -> None:
        """Whether each dimension of an array has one axis of its own group, of its length."""
        if not item.shape:
            return
        references = h5py.Dataset(item).attrs.get("DIMENSION_LIST")
        if references is None or references.shape != (len(item.shape),):
            raise self._refuse(path, f"has shape {item.shape} and no axes", "an axis for each dimension")
        for dimension, (length, own_axes) in enumerate(zip(item.shape, references, strict=True)):
            if len(own_axes) != 1 or not own_axes[0]:
                raise self._refuse(path, f"has {len(own_axes)} axes for dimension {dimension}", "one")
            address = h5py.h5o.get_info(h5py.h5r.dereference(own_axes[0], self.file.id)).addr
            if axes.get(address) != length:
                nodes = axes.get(address, "none, in another group")
                raise self._refuse(
                    path,
                    f"has {length} values along dimension {dimension}, and its axis has {nodes}",
                    "as many as its axis has nodes",
                )

    def _attributes(self, item: Any, path: str, root: bool = False) -> None:
        names = _names(item)
        if len(names) > ATTRIBUTE_LIMIT:
            raise self._refuse(path, f"has {len(names)} attributes", f"at most {ATTRIBUTE_LIMIT}")
        for name in names:
            self._attribute(h5py.h5a.open(item, name), name.decode("utf-8", "replace"), path, root)

    def _attribute(self, attribute: Any, name: str, path: str, root: bool) -> None:
        kind, shape = attribute.get_type(), attribute.shape
        form, where = kind.get_class(), f"{path}@{name}"
        count = prod(shape) if shape is not None else 0
        if name in _LINKED:
            right = form == _LINKED[name] and len(shape) == 1 and kind.get_size() * count <= ATTRIBUTE_BYTES
            if not right or (form == h5py.h5t.VLEN and kind.get_super().get_class() != h5py.h5t.REFERENCE):
                raise self._refuse(where, f"is of type {kind.dtype} and shape {shape}", "the references of axes")
            return
        if attribute.get_space().get_simple_extent_type() == h5py.h5s.NULL:
            raise self._refuse(where, "contains no value", "a value")
        if form not in (*_NUMERIC, h5py.h5t.STRING) and not (form == h5py.h5t.ENUM and kind.dtype.kind == "b"):
            raise self._refuse(where, f"is of type {kind.dtype}", "numbers, booleans and text")
        is_text = form == h5py.h5t.STRING
        variable = is_text and kind.is_variable_str()
        if kind.get_size() * count > ATTRIBUTE_BYTES or len(shape) > 2:
            raise self._refuse(where, f"has shape {shape}", f"up to {ATTRIBUTE_BYTES} bytes in up to 2 dimensions")
        if variable and count > 1 and count * self.text_bytes > CHUNK_BYTES:
            raise self._refuse(where, f"has {count} texts beside one of {self.text_bytes} bytes", "shorter lists")
        if name in TEXTS or (root and name in ROOT_TEXTS):
            if not is_text or shape != ():
                raise self._refuse(where, f"is of type {kind.dtype} and shape {shape}", "one text")
            limit = JOB_LIMIT if name == "job" else SHORT_TEXT
            if (kind.get_size() if not variable else self.text_bytes) > limit:
                self._short(attribute, where, limit)
        elif name in NUMBERS and not (form in _NUMERIC and shape == ()):
            raise self._refuse(where, f"is of type {kind.dtype} and shape {shape}", "one number")

    def _short(self, attribute: Any, where: str, limit: int) -> None:
        import numpy as np

        value = np.empty((), dtype=attribute.dtype)
        attribute.read(value)
        length = len(value.item())
        if length > limit:
            raise self._refuse(where, f"is a text of {length} bytes", f"up to {limit}")


def _names(item: Any) -> list[bytes]:
    """Names of the attributes of an object, up to one more than it may have."""
    names: list[bytes] = []

    def note(name: bytes, *_: object) -> bool | None:
        names.append(name)
        return True if len(names) > ATTRIBUTE_LIMIT else None

    h5py.h5a.iterate(item, note)
    return names


_passed: dict[str, tuple[int, ...]] = {}  # files that the gate let through, with what changes when they do
_REMEMBERED = 256  # files that were checked in this process
_PACKAGED = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "atmospheres", "")
# A file changed less long ago, in seconds, may change again without a change of its times: FAT counts 2 s. Times that
# are not of whole hundredths of a second are those of a kernel, which counts 0.01 s or less.
_SETTLED, _SETTLED_FINE, _HUNDREDTH = 2.0, 0.05, 10_000_000


def pass_gate(path: StrPath, file: h5py.File) -> None:
    """Check an open file, unless it has passed before and is the same, or lies in the package as the code does; see
    `Gate`.
    """
    name = os.path.abspath(path)
    stamp = settled_stamp(path)
    if name.startswith(_PACKAGED) or (stamp is not None and _passed.get(name) == stamp):
        return
    Gate(path, file, largest_text(path)).check()
    if stamp is not None:
        if len(_passed) >= _REMEMBERED:
            _passed.clear()  # at once: several threads may be here
        _passed[name] = stamp


def settled_stamp(path: StrPath) -> tuple[int, ...] | None:
    """What changes when a file does; None where it is not there, or changed less long ago than its times tell."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):  # the latter of a zero byte in the path
        return None
    last = max(status.st_mtime, status.st_ctime)  # a copy may keep the former
    if time.time() - last <= (_SETTLED_FINE if status.st_ctime_ns % _HUNDREDTH else _SETTLED):
        return None
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns
