"""The gate before all readers of HDF5: hostile files end in one clear line, at once and without memory."""

import os
import resource
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from skyshine.schemas import hdf5_gate
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, open_database, read_file, write_file
from skyshine.schemas.hdf5_gate import settled_stamp

HEADER = Header("band", "materials 1.0.0", "name: x\n", "A title")


ROWS = 1 << 15  # of arrays that claim more than they hold


def _replaced(file: h5py.File, name: str, **how) -> h5py.Dataset:
    del file[name]
    return file.create_dataset(name, **how)


def _linked(file: h5py.File, name: str, **how) -> h5py.Dataset:
    """An array in place of another, on axes of its own length."""
    dataset = _replaced(file, name, **how)
    for position, length in enumerate(dataset.shape):
        axis = file.create_dataset(
            f"{name}_{position}", (length,), "i1", compression="gzip", chunks=(min(length, 4096),)
        )
        axis.make_scale(f"{name}_{position}")
        axis[:] = 0
        dataset.dims[position].attach_scale(axis)
    return dataset


def many_paths(file: h5py.File) -> None:
    """Twenty groups, each with two links to the next: a million paths in a few kilobytes."""
    for name in "ab":
        file[f"maze0/{name}"] = file.require_group("maze1")
    for level in range(1, 20):
        for name in "ab":
            file[f"maze{level}/{name}"] = file.require_group(f"maze{level + 1}")


def circle(file: h5py.File) -> None:
    file.create_group("loop")["again"] = file["/"]


def soft_link(file: h5py.File) -> None:
    file["other"] = h5py.SoftLink("/beta")


def external_link(file: h5py.File) -> None:
    file["other"] = h5py.ExternalLink("/etc/passwd", "/")


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((1 << 20, 1 << 23), "f4")
    del file["beta"]
    file.create_virtual_dataset("beta", layout)


def external_storage(file: h5py.File) -> None:
    _replaced(file, "beta", shape=(2, 3), dtype="f4", external=[("/etc/passwd", 0, 24)])


def claims_without_bytes(file: h5py.File) -> None:
    _replaced(file, "beta", shape=(ROWS, ROWS), dtype="f4", chunks=(1024, 1024))


def packed_bomb(file: h5py.File) -> None:
    """Zeros that deflate packs a thousandfold, more than an array may take."""
    bomb = _linked(file, "beta", shape=(1 << 11, 1 << 12), dtype="f8", chunks=(1 << 11, 1 << 12), compression="gzip")
    bomb[:] = 0.0


def wide_chunk(file: h5py.File) -> None:
    """A chunk of 512 MiB, which reading one value would unpack."""
    zeros = np.zeros(1 << 26)
    _replaced(file, "beta", data=zeros, chunks=zeros.shape, compression="gzip", compression_opts=1)


def object_references(file: h5py.File) -> None:
    references = _replaced(file, "beta", shape=(2, 3), dtype=h5py.ref_dtype)
    references[:] = file["range"].ref


def region_references(file: h5py.File) -> None:
    _replaced(file, "beta", shape=(2, 3), dtype=h5py.regionref_dtype)


def records(file: h5py.File) -> None:
    _replaced(file, "beta", data=np.zeros((2, 3), [("a", "f4"), ("b", "i4")]))


def lists(file: h5py.File) -> None:
    _replaced(file, "beta", shape=(2, 3), dtype=h5py.vlen_dtype(np.float32))


def named_type(file: h5py.File) -> None:
    file["kind"] = np.dtype("f4")


def no_axes(file: h5py.File) -> None:
    _replaced(file, "beta", data=np.zeros((2, 3), "f4"))


def short_axis(file: h5py.File) -> None:
    """Two nodes over an array of 2,701 values."""
    array = _replaced(file, "beta", data=np.zeros(2701, "f4"))
    array.dims[0].attach_scale(file["range"])


def axis_of_another_group(file: h5py.File) -> None:
    array = _replaced(file, "beta", data=np.zeros(2, "f4"))
    array.dims[0].attach_scale(file["accuracy/quantity"])


def two_axes_of_one_dimension(file: h5py.File) -> None:
    file["beta"].dims[1].attach_scale(file["range"])


def table_as_axis(file: h5py.File) -> None:
    file.create_dataset("flat", data=np.zeros((2, 2))).make_scale("flat")


def units_as_list(file: h5py.File) -> None:
    file["beta"].attrs["units"] = ["km", "km"]


def units_as_number(file: h5py.File) -> None:
    file["beta"].attrs["units"] = 3.0


def endless_units(file: h5py.File) -> None:
    file["beta"].attrs["units"] = "k" * 100_000


def endless_name(file: h5py.File) -> None:
    file["name"][0] = "m" * 100_000


def endless_job(file: h5py.File) -> None:
    file.attrs["job"] = "j" * 17_000_000


def period_as_list(file: h5py.File) -> None:
    file["range"].attrs["period"] = [360.0, 24.0]


def attribute_of_references(file: h5py.File) -> None:
    file["beta"].attrs["see"] = file["range"].ref


def empty_attribute(file: h5py.File) -> None:
    file["beta"].attrs["units"] = h5py.Empty("f4")


def broken_axis_list(file: h5py.File) -> None:
    del file["beta"].attrs["DIMENSION_LIST"]
    file["beta"].attrs["DIMENSION_LIST"] = np.arange(2)


def many_objects(file: h5py.File) -> None:
    group = file.create_group("crowd")
    for number in range(20_001):
        h5py.h5g.create(group.id, str(number).encode())


def deep_groups(file: h5py.File) -> None:
    file.create_group("/".join("g" * 40))


def unknown_filter(file: h5py.File) -> None:
    array = _replaced(file, "beta", data=np.zeros((2, 3), "f4"), chunks=(2, 3), compression="lzf")
    array.dims[0].attach_scale(file["range"])
    array.dims[1].attach_scale(file["code"])


# What each is, and words of its message.
CHANGES: dict[Callable[[h5py.File], None], str] = {
    many_paths: "is a second link to the same object",
    circle: "is a second link to the same object",
    soft_link: "is a soft or external link",
    external_link: "is a soft or external link",
    virtual: ("is stored outside the file", "0 of the file's"),  # HDF5 1.14 tells the layout of none
    external_storage: "is stored outside the file",
    claims_without_bytes: "claims 4294967296 bytes",
    packed_bomb: "of memory; allowed",
    wide_chunk: "is stored in chunks of 536870912 bytes",
    object_references: "contains values of type object",
    region_references: "contains values of type object",
    records: "contains values of type",
    lists: "contains values of type object",
    named_type: "is a named type",
    no_axes: "and no axes",
    short_axis: "has 2701 values along dimension 0, and its axis has 2",
    axis_of_another_group: "another group",
    two_axes_of_one_dimension: "has 2 axes for dimension 1",
    table_as_axis: "is an axis of shape",
    units_as_list: "allowed: one text",
    units_as_number: "allowed: one text",
    endless_units: "is a text of 100000 bytes",
    endless_name: "contains a text of 100000 characters",
    endless_job: "contains a text of 17000000 bytes",
    period_as_list: "allowed: one number",
    attribute_of_references: "is of type object",
    empty_attribute: "contains no value",
    broken_axis_list: "allowed: the references of axes",
    many_objects: "at most 20000 objects",
    deep_groups: "groups deep",
    unknown_filter: "is packed by filters",
}


def spoil(path: Path, change: Callable[[h5py.File], None]) -> Path:
    """Change a file so; returns its path."""
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        change(file)
    return path


@pytest.fixture
def good(tmp_path):
    """A database with two axes, an array, text, and a group."""
    quantity = {"quantity": Axis(["a", "b"], "1", "names")}
    root = Group(
        {"range": Axis([1.0, 2.0], "km", "range"), "code": Axis(np.array([3, 5, 7], np.int32), "1", "code")},
        {
            "beta": Variable(("range", "code"), np.ones((2, 3)), "km", "beta"),
            "name": Variable(("code",), np.array(["soil", "rock", "sea"], object), "1", "name"),
        },
        {"accuracy": Group(quantity, {"rms": Variable(("quantity",), [1.0, 2.0], "K", "rms")})},
    )
    write_file(tmp_path / "a.h5", root, HEADER)
    return tmp_path / "a.h5"


def test_a_good_file_passes(good):
    read_file(good, "band", verify=True)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_a_hostile_file_is_refused_in_one_line_at_once(good, change, monkeypatch):
    if change is packed_bomb:
        monkeypatch.setenv("SKYSHINE_MAX_ARRAY_GIB", "0.05")
    spoil(good, change)
    memory, begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    with pytest.raises(InputError) as caught:
        read_file(good)
    words = CHANGES[change] if isinstance(CHANGES[change], tuple) else (CHANGES[change],)
    assert any(word in str(caught.value) for word in words) and "\n" not in str(caught.value)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 100_000  # kB
    assert time.process_time() - begin < 10


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_pipe_or_a_device_is_refused_without_waiting(tmp_path):
    os.mkfifo(tmp_path / "pipe.h5")
    for path in (tmp_path / "pipe.h5", os.devnull):
        with pytest.raises(InputError, match="is a pipe, socket or device"):
            open_database(path)
    with pytest.raises(InputError, match="is a folder"):
        open_database(tmp_path)
    with pytest.raises(InputError, match="cannot be read"):
        open_database("a\0b")


def test_a_file_that_changes_after_it_has_passed_is_looked_at_again(good):
    while settled_stamp(good) is None:
        time.sleep(0.01)
    read_file(good)
    read_file(good)
    with h5py.File(good, "r+") as file:
        file["other"] = h5py.SoftLink("/beta")
    with pytest.raises(InputError, match="is a soft or external link"):
        read_file(good)


@pytest.mark.parametrize(("age", "settled"), [(0.01, False), (0.2, True)])
def test_times_of_whole_seconds_settle_later(good, monkeypatch, age, settled):
    """As those of FAT, which has 2 s."""
    real = os.stat(good)
    fine, coarse = 1_700_000_000_123_456_789, 1_700_000_000_000_000_000
    for stamp, expected in ((fine, settled), (coarse, False)):
        status = SimpleNamespace(
            **{name: getattr(real, name) for name in ("st_dev", "st_ino", "st_size")},
            st_mtime=stamp / 1e9,
            st_ctime=stamp / 1e9,
            st_mtime_ns=stamp,
            st_ctime_ns=stamp,
        )
        with monkeypatch.context() as patch:
            patch.setattr(hdf5_gate.os, "stat", lambda _, status=status: status)
            patch.setattr(hdf5_gate.time, "time", lambda stamp=stamp: stamp / 1e9 + age)
            assert (settled_stamp(good) is not None) == expected


def test_the_limit_of_an_array_can_be_raised_and_must_be_a_number(good, monkeypatch):
    monkeypatch.setenv("SKYSHINE_MAX_ARRAY_GIB", "1e-8")
    with pytest.raises(InputError, match="set SKYSHINE_MAX_ARRAY_GIB to 1"):
        read_file(good)
    monkeypatch.setenv("SKYSHINE_MAX_ARRAY_GIB", "much")
    with pytest.raises(InputError, match="found 'much'"):
        read_file(good)
