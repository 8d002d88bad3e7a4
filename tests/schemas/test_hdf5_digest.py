"""The digest covers all that a file says, and nothing of how HDF5 stores it."""

import hashlib

import h5py
import numpy as np
import pytest

from skyshine.schemas.array_digest import array_digest
from skyshine.schemas.digest import digest_of
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, is_current, open_database, read_file, write_file
from skyshine.schemas.hdf5_digest import axis_names, content_hash, digest_holds, dims_of

HEADER = Header("htt", "materials 1.0.0", "name: x\n", "A title")


@pytest.fixture
def good(tmp_path):
    rule = {"interpolation": "linear_periodic", "period": 24.0, "out_of_range": "error"}
    root = Group(
        {"time": Axis([0.0, 6.0], "h", "clock", rule), "code": Axis(np.array([3, 5, 7], np.int32), "1", "code")},
        {
            "heat": Variable(("time", "code"), np.arange(6.0).reshape(2, 3), "K", "temperature", {"comment": "c"}),
            "name": Variable(("code",), np.array(["soil", "rock", "sea"], object), "1", "name"),
        },
        {"accuracy": Group(attributes={"seed": 3, "edges": np.array([8.0, 12.0])})},
        {"site": "here"},
    )
    write_file(tmp_path / "a.h5", root, HEADER)
    return tmp_path / "a.h5"


def holds(path):
    with open_database(path) as file:
        return digest_holds(file)


def rename(file):
    file.move("heat", "warmth")


def retype(file):
    values = file["heat"][()]
    del file["heat"]
    again = file.create_dataset("heat", data=values.astype("f8"))
    again.attrs["units"], again.attrs["long_name"], again.attrs["comment"] = "K", "temperature", "c"
    again.dims[0].attach_scale(file["time"])
    again.dims[1].attach_scale(file["code"])


def swap_axes(file):
    """The same numbers on two axes of one length: only the dimension scales tell."""
    square = file.create_dataset("square", data=np.zeros(2, "f4"))
    square.dims[0].attach_scale(file["time"])


CHANGES = {
    "a value": lambda file: file["heat"].__setitem__((0, 1), 9.0),
    "a node": lambda file: file["time"].__setitem__(1, 7.0),
    "a name": lambda file: file["name"].__setitem__(1, "clay"),
    "interpolation": lambda file: file["time"].attrs.__setitem__("interpolation", "linear"),
    "period": lambda file: file["time"].attrs.__setitem__("period", 12.0),
    "out_of_range": lambda file: file["time"].attrs.__setitem__("out_of_range", "clamp"),
    "units": lambda file: file["heat"].attrs.__setitem__("units", "degC"),
    "comment": lambda file: file["heat"].attrs.__setitem__("comment", "d"),
    "an attribute more": lambda file: file["heat"].attrs.__setitem__("_FillValue", np.float32(3)),
    "an attribute less": lambda file: file["heat"].attrs.__delitem__("comment"),
    "the type of an attribute": lambda file: file["accuracy"].attrs.__setitem__("seed", 3.0),
    "an attribute of a group": lambda file: file["accuracy"].attrs.__setitem__("edges", [8.0, 12.5]),
    "the job": lambda file: file.attrs.__setitem__("job", "name: y\n"),
    "the title": lambda file: file.attrs.__setitem__("title", "B"),
    "the format version": lambda file: file.attrs.__setitem__("format_version", "1.1.0"),
    "an empty group": lambda file: file.create_group("more"),
    "a name of an array": rename,
    "a type": retype,
    "an array": swap_axes,
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_of_anything_is_seen(good, change):
    assert holds(good)
    with h5py.File(good, "r+") as file:
        CHANGES[change](file)
    assert not holds(good)
    with pytest.raises(InputError, match="content_sha256 does not match"):
        read_file(good, verify=True)


def test_axes_that_trade_places_are_seen(tmp_path):
    digests = set()
    for dims in (("a", "b"), ("b", "a")):
        axes = {name: Axis([1.0, 2.0], "1", "axis") for name in "ab"}
        root = Group(axes, {"x": Variable(dims, np.zeros((2, 2)), "1", "x")})
        digests.add(write_file(tmp_path / "a.h5", root, HEADER))
    assert len(digests) == 2


def test_axes_have_their_names_of_whatever_group(tmp_path):
    """Of the array's own group, without a search, of another, and none."""
    with h5py.File(tmp_path / "a.h5", "w") as file:
        own, other, wrong = (file.create_dataset(name, data=np.arange(2.0)) for name in ("own", "inner/other", "wrong"))
        array = file.create_dataset("array", (2, 2, 2), "f4")
        for number, axis in enumerate((own, other)):
            axis.make_scale()
            array.dims[number].attach_scale(axis)
        wrong.make_scale()
        named = axis_names(file.items())
        assert sorted(named.values()) == ["own", "wrong"]
        assert dims_of(array, named) == dims_of(array) == ("own", "other", "")


def test_the_way_of_storage_is_not_seen(good, tmp_path):
    """Another chunking, no compression, big-endian numbers, other order and text of fixed length: the same digest."""
    with h5py.File(good) as file, h5py.File(tmp_path / "b.h5", "w") as other:
        for name in reversed(list(file)):
            item = file[name]
            if isinstance(item, h5py.Group):
                group = other.create_group(name)
                for key in reversed(list(item.attrs)):
                    group.attrs[key] = item.attrs[key]
                continue
            text = h5py.check_string_dtype(item.dtype) is not None
            data = item[()] if text else item[()].astype(item.dtype.newbyteorder(">"))
            again = other.create_dataset(name, data=data, dtype=item.dtype if text else data.dtype)
            for key, value in item.attrs.items():
                if key not in ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"):
                    again.attrs[key] = np.bytes_(value.encode()) if isinstance(value, str) else value
            if item.is_scale:
                again.make_scale(name)
        for name in ("heat", "name"):
            for place, dim in enumerate(file[name].dims):
                other[name].dims[place].attach_scale(other[dim[0].name])
        for key, value in file.attrs.items():
            other.attrs[key] = value
        assert content_hash(other) == file.attrs["content_sha256"]


def by_the_text(values):
    """The digest of an array as `array_digest` words it, value by value."""

    def of(data):
        return hashlib.sha256(data).digest()

    if values.ndim == 1:
        blocks = [values[i : i + 65536] for i in range(0, len(values), 65536)]
    else:
        rows, columns = (range(0, n, 256) for n in values.shape[:2])
        blocks = [values[i : i + 256, j : j + 256] for i in rows for j in columns]
    size = values.dtype.itemsize
    joined = [block.astype(values.dtype.newbyteorder("<")).tobytes() for block in blocks]
    return of(b"".join(of(b"".join(of(data[k::size]) for k in range(size))) for data in joined))


@pytest.mark.parametrize("shape", [(1,), (70_000,), (3, 4), (300, 520), (2, 300, 5, 7), (513, 3, 3), (4, 0), (0,)])
@pytest.mark.parametrize("kind", ["<u2", ">f4", "u1", "<f8", "<i4"])
def test_the_digest_of_an_array_is_what_its_text_says(shape, kind):
    values = np.random.default_rng(1).integers(0, 9, shape).astype(kind)
    assert array_digest(values) == by_the_text(values)
    if values.size:
        changed = values.copy()
        changed.flat[-1] += 1
        assert array_digest(changed) != array_digest(values)


def test_an_array_read_back_has_the_digest_of_the_one_in_memory(tmp_path):
    axes = {name: Axis(np.arange(n), "1", "number") for name, n in (("y", 600), ("x", 513))}
    data = np.random.default_rng(2).normal(size=(600, 513)).astype("f4")
    digest = write_file(tmp_path / "a.h5", Group(axes, {"a": Variable(("y", "x"), data, "1", "a")}), HEADER)
    with h5py.File(tmp_path / "a.h5") as file:
        assert content_hash(file) == digest == content_hash(file, {"/a": array_digest(data)})
        assert content_hash(file, {"/a": array_digest(data + 1)}) != digest


def test_a_file_is_current_while_header_and_content_are(good):
    assert is_current(good, HEADER) and not is_current(good, HEADER, lambda file: "gone" in file)
    assert not is_current(good, HEADER, lambda file: file["gone"]) and not is_current(good.parent / "none.h5", HEADER)
    assert not is_current(good, Header("htt", "materials 1.0.1", "name: x\n", "A title"))
    with h5py.File(good, "r+") as file:
        file["heat"].attrs["units"] = "degC"
    assert not is_current(good, HEADER)


def test_a_job_of_megabytes_is_kept(tmp_path):
    job = "x" * 3_000_000
    write_file(tmp_path / "a.h5", Group(), Header("htt", "d", job))
    assert read_file(tmp_path / "a.h5", verify=True)[1]["job"] == job
    with pytest.raises(InputError, match="job is longer than"):
        write_file(tmp_path / "b.h5", Group(), Header("htt", "d", 6 * job))


def test_values_that_differ_have_different_digests():
    values = [1, 1.0, True, "1", b"1", None, [1], [[1]], ["ab", "c"], ["a", "bc"], np.ones(1), np.ones((1, 1))]
    values += [np.ones(1, "f4"), {"a": 1}, {"a": [1]}, np.array(["ab", "c"], object), np.array(["a", "bc"], object)]
    assert len({digest_of(value) for value in values}) == len(values)
    assert digest_of(np.arange(3, dtype=">i4")) == digest_of(np.arange(3, dtype="<i4"))
    # SHA-256 of what the bytes are by the definition, from another implementation of the hash.
    assert digest_of("ab") == hashlib.new("sha256", b"sequence 1 str 2 ab").hexdigest()
    with pytest.raises(TypeError):
        digest_of(object())
