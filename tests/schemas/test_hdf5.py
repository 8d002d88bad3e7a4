"""The HDF5 writer: readers of others open its files, same content gives same bytes, failures leave nothing."""

import shutil
import subprocess

import h5py
import numpy as np
import pytest

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, read_file, write_file

HEADER = Header("band", "materials 1.0.0", "name: x\n", "A title")


@pytest.fixture
def group():
    values = np.linspace(0, 1, 6).reshape(2, 3)
    inner = Group(
        {"quantity": Axis(["a", "b"], "1", "names")}, {"rms": Variable(("quantity",), [1.0, 2.0], "K", "rms")}
    )
    return Group(
        {"range": Axis([1.0, 2.0], "km", "range"), "code": Axis(np.array([3, 5, 7], np.int32), "1", "code")},
        {
            "beta": Variable(("range", "code"), values, "km", "beta", {"comment": "gamma ünïcode"}),
            "name": Variable(("code",), np.array(["soil", "rock", "sea"], object), "1", "name"),
        },
        {"accuracy": inner},
    )


def test_what_is_written_is_read_back(tmp_path, group):
    digest = write_file(tmp_path / "a.h5", group, HEADER)
    root, attributes = read_file(tmp_path / "a.h5", "band")
    assert attributes["content_sha256"] == digest and attributes["job"] == "name: x\n"
    np.testing.assert_allclose(root.variables["beta"].data, group.variables["beta"].data, rtol=1e-7)
    assert root.variables["beta"].dims == ("range", "code") and root.variables["beta"].data.dtype == np.float32
    assert list(root.variables["name"].data) == ["soil", "rock", "sea"]
    assert root.axes["code"].values.dtype == np.int32 and root.axes["range"].values.dtype == np.float64
    assert list(root.groups["accuracy"].axes["quantity"].values) == ["a", "b"]
    assert root.variables["beta"].attributes["comment"] == "gamma ünïcode"


def differenced(values):
    axes = {name: Axis(np.arange(float(n)), "1", name) for name, n in zip("xyz", values.shape, strict=True)}
    return Group(axes, {"smooth": Variable(tuple("xyz"), values, "1", "smooth", {"differences": "x z"})})


@pytest.mark.parametrize("lazy", [False, True])
def test_differences_of_whole_steps_are_stored_and_summed_to_the_very_values(tmp_path, lazy):
    generator = np.random.default_rng(3)
    values = (generator.integers(-9, 9, (7, 5, 40)).cumsum(0).cumsum(2) / 64 - 3e3).astype(np.float32)
    write_file(tmp_path / "a.h5", differenced(values), HEADER)
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["smooth"].attrs["differences"] == b"x z"
        stored = file["smooth"][()]
    expected = np.diff(np.diff(values, axis=0, prepend=0), axis=2, prepend=0)
    np.testing.assert_array_equal(stored, expected)
    smooth = read_file(tmp_path / "a.h5", lazy=lazy, verify=True)[0].variables["smooth"]
    np.testing.assert_array_equal(smooth.data, values)
    assert smooth.attributes == {}


def test_values_that_sums_would_not_give_exactly_are_stored_as_they_are(tmp_path):
    values = np.random.default_rng(4).normal(size=(3, 4, 5)).astype(np.float32)
    write_file(tmp_path / "a.h5", differenced(values), HEADER)
    with h5py.File(tmp_path / "a.h5") as file:
        assert "differences" not in file["smooth"].attrs
    np.testing.assert_array_equal(read_file(tmp_path / "a.h5")[0].variables["smooth"].data, values)


def test_the_same_content_gives_the_same_bytes(tmp_path, group):
    for name in ("a.h5", "b.h5"):
        write_file(tmp_path / name, group, HEADER)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_the_same_content_gives_the_same_bytes_while_others_refer_to_arrays(tmp_path, monkeypatch):
    """A profiler or a debugger holds frames, and with them arrays, for longer."""
    numbers = np.random.default_rng(3).normal(size=(8, 200))
    axes = {"x": Axis(np.arange(8.0), "m", "x"), "y": Axis(np.arange(200.0), "m", "y")}
    group = Group(axes, {f"array{number}": Variable(("x", "y"), numbers, "K", "array") for number in range(9)})
    write_file(tmp_path / "alone.h5", group, HEADER)
    create, kept = h5py.Group.create_dataset, []

    def referred(*arguments, **more):
        kept.append(create(*arguments, **more))
        return kept[-1]

    monkeypatch.setattr(h5py.Group, "create_dataset", referred)
    write_file(tmp_path / "referred.h5", group, HEADER)
    assert len(kept) == 11 and (tmp_path / "referred.h5").read_bytes() == (tmp_path / "alone.h5").read_bytes()


@pytest.mark.parametrize("engine", ["netcdf4", "h5netcdf"])
def test_xarray_opens_it_without_a_warning(tmp_path, group, engine, recwarn):
    xarray = pytest.importorskip("xarray")
    write_file(tmp_path / "a.h5", group, HEADER)
    with xarray.open_dataset(tmp_path / "a.h5", engine=engine) as data:
        assert data["beta"].dims == ("range", "code") and data["beta"].attrs["units"] == "km"
        assert float(data["beta"].sel(range=2.0, code=7)) == 1.0
        assert str(data["name"].values[0]) == "soil"
    with xarray.open_dataset(tmp_path / "a.h5", engine=engine, group="accuracy") as data:
        assert float(data["rms"].sel(quantity="b")) == 2.0
    assert not [w for w in recwarn if "skyshine" in str(w.filename) or "xarray" in str(w.filename)]


@pytest.mark.parametrize("tool", [["ncdump", "-h"], ["h5dump", "-H"]], ids=["ncdump", "h5dump"])
def test_the_standard_dump_tools_open_it(tmp_path, group, tool):
    if shutil.which(tool[0]) is None:
        pytest.skip(f"{tool[0]} is not installed")
    write_file(tmp_path / "a.h5", group, HEADER)
    done = subprocess.run([*tool, tmp_path / "a.h5"], capture_output=True, text=True)
    assert done.returncode == 0 and "beta" in done.stdout and not done.stderr


def test_a_failed_write_leaves_the_old_file_and_no_part(tmp_path, group):
    write_file(tmp_path / "a.h5", group, HEADER)
    before = (tmp_path / "a.h5").read_bytes()
    wrong = Group(group.axes, {"beta": Variable(("range", "code"), np.zeros((2, 2)), "km", "beta")})
    with pytest.raises(ValueError, match="shape"):
        write_file(tmp_path / "a.h5", wrong, HEADER)
    assert (tmp_path / "a.h5").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5"]


def test_readers_refuse_what_they_cannot_read(tmp_path, group):
    file = tmp_path / "a.h5"
    write_file(file, group, HEADER)
    with pytest.raises(InputError, match="contains 'band'; allowed: 'htt'"):
        read_file(file, "htt")
    with pytest.raises(InputError, match="does not exist"):
        read_file(tmp_path / "none.h5")
    file.write_bytes(file.read_bytes()[:3000])
    with pytest.raises(InputError, match="not a readable HDF5"):
        read_file(file)
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["x"] = 1
    with pytest.raises(InputError, match="a database of skyshine"):
        read_file(tmp_path / "other.h5")


def test_a_heap_that_the_library_would_walk_for_ever_is_refused(tmp_path, group):
    """Free space of a text heap whose length is 0 holds libhdf5 in one place."""
    write_file(tmp_path / "a.h5", group, HEADER)
    content = bytearray((tmp_path / "a.h5").read_bytes())
    heap = content.find(b"GCOL\x01\0\0\0")
    content[heap + 16 : heap + 32] = bytes(16)  # number 0, length 0 where the first object stood
    (tmp_path / "a.h5").write_bytes(content)
    with pytest.raises(InputError, match="a text heap with an object without length"):
        read_file(tmp_path / "a.h5")


def test_a_changed_header_of_an_array_is_refused(tmp_path, group):
    write_file(tmp_path / "a.h5", group, HEADER)
    whole = (tmp_path / "a.h5").read_bytes()
    (tmp_path / "a.h5").write_bytes(whole.replace(b"long_name", b"long_nome", 1))
    with pytest.raises(InputError, match="damaged"):
        read_file(tmp_path / "a.h5")


def test_arrays_are_stored_in_few_chunks_whole_along_their_last_axes(tmp_path):
    data = np.arange(6 * 300 * 400, dtype=np.float32).reshape(6, 300, 400)
    axes = {name: Axis(np.arange(size), "1", name) for name, size in zip("abc", data.shape, strict=True)}
    group = Group(axes, {"values": Variable(("a", "b", "c"), data, "1", "values")}, {}, {})
    write_file(tmp_path / "f.h5", group, HEADER)
    with h5py.File(tmp_path / "f.h5") as file:
        assert file["values"].chunks == (2, 300, 400)
        np.testing.assert_array_equal(file["values"][()], data)
