"""Files of older formats in the present one: what a build of today writes, but for the storage."""

import json

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.tables.convert import convert
from skyshine.mat.tables.files import HTT
from skyshine.mat.tables.named_materials import with_names
from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, read_file, write_file
from skyshine.schemas.hdf5_digest import content_hash

VERSIONS = {"htt": [HTT.format_version]}


@pytest.fixture
def present(tmp_path):
    """A file of the present format; not all of a temperature table."""
    axes = {"material": Axis(np.array([3, 5], np.int32), "1", "code", {"interpolation": "exact"})}
    variables = {
        "temperature": Variable(("material",), np.array([280.0, 290.0]), "K", "temperature"),
        "material_name": Variable(("material",), np.array(["soil", "rock"], object), "1", "name"),
    }
    write_file(tmp_path / "new.h5", Group(axes, with_names(variables)), Header("htt", HTT.format_version, "d", "job"))
    return tmp_path / "new.h5"


@pytest.fixture
def older(present, tmp_path):
    """The same as version 1.1.0 had it."""
    path = tmp_path / "old" / "s01.htt.h5"
    path.parent.mkdir()
    path.write_bytes(present.read_bytes())
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        del file["temperature"].attrs["coordinates"]
        del file.attrs["digest_version"]
        file.attrs["format_version"] = "1.1.0"
        file.attrs["content_sha256"] = content_hash(file)
    return path


def test_a_converted_file_says_what_a_new_one_says(present, older, tmp_path):
    target, old, new = convert(older, tmp_path / "out", VERSIONS)
    assert (target, old, new) == (tmp_path / "out" / "s01.htt.h5", "1.1.0", HTT.format_version)
    with h5py.File(target) as lifted, h5py.File(present) as made:
        assert lifted.attrs["content_sha256"] == made.attrs["content_sha256"] == content_hash(lifted)
        np.testing.assert_array_equal(lifted["temperature"][()], made["temperature"][()])
    assert not any("content_sha256" in line for line in problems(target))
    assert [path.name for path in target.parent.iterdir()] == ["s01.htt.h5"]


def test_a_lifted_file_is_said_to_lack_what_only_a_build_adds(older, small_build, tmp_path):
    files = [str(older), str(small_build / "s01.htt.h5")]
    done = CliRunner().invoke(main, ["convert", *files, "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    lifted, present = done.output.splitlines()
    assert lifted.endswith("; lacks response to shade, tracks of Sun and Moon: build it again for that")
    assert "lacks" not in present
    done = CliRunner().invoke(main, ["convert", "--json", str(older), "--out", str(tmp_path / "json")])
    assert json.loads(done.output)["files"][0]["lacks"] == ["response to shade", "tracks of Sun and Moon"]


def test_a_present_file_is_copied(present, tmp_path):
    target, old, new = convert(present, tmp_path / "out", VERSIONS)
    assert old == new and target.read_bytes() == present.read_bytes()


def test_what_cannot_be_lifted_is_refused(older, tmp_path):
    with pytest.raises(InputError, match="would be written over itself"):
        convert(older, older.parent, VERSIONS)
    with pytest.raises(InputError, match="holds 'htt'; allowed: band"):
        convert(older, tmp_path / "out", {"band": ["1.2.0"]})
    with pytest.raises(InputError, match=r"has format_version '1.1.0'; this reader reads 2.x"):
        convert(older, tmp_path / "out", {"htt": ["2.0.0"]})
    with pytest.raises(InputError, match=r"has format_version 1.1.0; this version writes 1.0.0; upgrade"):
        convert(older, tmp_path / "out", {"htt": ["1.0.0"]})
    with h5py.File(older, "r+") as file:
        file["temperature"][0] = 300.0
    with pytest.raises(InputError, match="content_sha256 does not match"):
        convert(older, tmp_path / "out", VERSIONS)
    assert not (tmp_path / "out").exists()


def test_the_command_converts_several_files(present, older, tmp_path):
    done = CliRunner().invoke(main, ["convert", str(older), str(present), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert f"1.1.0 to {HTT.format_version}" in done.output and "is in the present format" in done.output
    assert read_file(tmp_path / "out" / "s01.htt.h5", verify=True)[1]["format_version"] == HTT.format_version
